#include "map/fixes/map_datum.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace gprodom {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;

using Vector5d = Eigen::Matrix<double, 5, 1>;

constexpr double kBaseline = 100.0;  // m; any length tells how one plane is turned in another

// The estimate of (x, y, yaw) and of the lasting error of the newest fix of a chain, in that fix's
// standard deviations.
struct Filter {
  Vector5d x = Vector5d::Zero();
  Matrix5d P = Matrix5d::Zero();

  void begin_chain(const FixEdge& fix) {
    x.tail<2>().setZero();
    P.rightCols<2>().setZero();
    P.bottomRows<2>().setZero();
    P.bottomRightCorner<2, 2>() = (1 - fix.white) * Matrix2d::Identity();
  }

  void go_on(const FixEdge& fix) {
    x.tail<2>() *= fix.kept;
    P.rightCols<2>() *= fix.kept;
    P.bottomRows<2>() *= fix.kept;
    P.bottomRightCorner<2, 2>() +=
        (1 - fix.white) * (1 - fix.kept * fix.kept) * Matrix2d::Identity();
  }

  // Returns the norm of the innovation in its standard deviations.
  template <int N>
  double update(const Eigen::Matrix<double, N, 5>& H, const Eigen::Matrix<double, N, 1>& seen,
                double variance) {
    using MatrixN = Eigen::Matrix<double, N, N>;
    const Eigen::Matrix<double, N, 1> innovation = seen - H * x;
    const MatrixN S = H * P * H.transpose() + variance * MatrixN::Identity();
    const Eigen::Matrix<double, 5, N> K = P * H.transpose() * S.inverse();
    x += K * innovation;
    // Joseph's form, since the first fixes know far more than what was known before.
    const Matrix5d rest = Matrix5d::Identity() - K * H;
    P = rest * P * rest.transpose() + variance * K * K.transpose();
    return std::sqrt(innovation.dot(S.inverse() * innovation));
  }

  double see(const FixEdge& fix, const PlanarPose& place, const Vector2d& centre) {
    const Matrix2d L = fix.covariance.llt().matrixL();
    Eigen::Matrix<double, 2, 5> H;
    H << L.inverse() * lever(place.p - centre).topRows<2>(), Matrix2d::Identity();
    double worst = update<2>(H, L.inverse() * (fix.p - place.p), fix.white);
    if (fix.yaw_sigma > 0.0) {
      const Eigen::Matrix<double, 1, 5> yaw = Eigen::Matrix<double, 1, 5>::Unit(2);
      const Eigen::Matrix<double, 1, 1> off(wrapped(fix.yaw - place.yaw));
      worst = std::max(worst, update<1>(yaw, off, fix.yaw_sigma * fix.yaw_sigma));
    }
    return worst;
  }
};

}  // namespace

Matrix3d carried(const Matrix3d& covariance, const Vector2d& way) {
  const Matrix3d J = lever(way);
  return J * covariance * J.transpose();
}

Matrix3d turned(const Matrix3d& covariance, double yaw) {
  const Matrix3d R(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  return R * covariance * R.transpose();
}

std::optional<MapDatum> in_site_of(const MapDatum& datum, const std::optional<Geodetic>& origin) {
  if (datum.origin.has_value() != origin.has_value()) return std::nullopt;
  if (!origin || *origin == *datum.origin) return datum;
  const Datum from(*datum.origin), to(*origin);
  const Vector3d begin = to.to_site(from.origin());
  if (!(begin.norm() < kFarFromDatum)) return std::nullopt;
  const Vector3d east = to.to_site(from.to_geodetic({kBaseline, 0.0, 0.0})) - begin;
  const PlanarPose site{begin.head<2>(), std::atan2(east.y(), east.x())};
  MapDatum moved = datum;
  moved.origin = origin;
  moved.pose = compose(site, datum.pose);
  moved.z += begin.z();
  Matrix4d turn = Matrix4d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(site.yaw).toRotationMatrix();
  moved.covariance = turn * datum.covariance * turn.transpose();
  return moved;
}

std::optional<FrameOnEarth> on_earth(const MapDatum& datum) {
  if (!datum.origin) return std::nullopt;
  const Datum site(*datum.origin);
  const auto at = [&](const Vector2d& p) {
    const Vector2d in_site = compose(datum.pose, {p, 0.0}).p;
    return site.to_geodetic({in_site.x(), in_site.y(), datum.z});
  };
  FrameOnEarth frame;
  frame.origin = at(Vector2d::Zero());
  const Vector3d ahead = Datum(frame.origin).to_site(at({kBaseline, 0.0}));
  frame.yaw = std::atan2(ahead.y(), ahead.x());
  return frame;
}

RigidTie tie_rigidly(const std::vector<FixEdge>& fixes, const std::vector<PlanarPose>& places,
                     const std::optional<KnownTie>& known) {
  Vector2d centre = Vector2d::Zero();
  for (const PlanarPose& place : places) centre += place.p / static_cast<double>(places.size());
  std::vector<std::optional<std::size_t>> next(fixes.size());
  for (std::size_t i = 0; i < fixes.size(); ++i)
    if (fixes[i].before) next[*fixes[i].before] = i;
  Matrix3d before = kNothingKnown.cwiseAbs2().asDiagonal(), share = Matrix3d::Identity();
  if (known) {
    const Matrix3d of_map = carried(known->map, centre);
    before = of_map + carried(known->track, centre);
    share = of_map * before.inverse();
  }
  Filter filter;
  filter.P.topLeftCorner<3, 3>() = before;
  RigidTie tie;
  for (std::size_t first = 0; first < fixes.size(); ++first) {
    if (fixes[first].before) continue;
    filter.begin_chain(fixes[first]);
    for (std::optional<std::size_t> i = first; i; i = next[*i]) {
      if (*i != first) filter.go_on(fixes[*i]);
      tie.worst = std::max(tie.worst, filter.see(fixes[*i], places[*i], centre));
    }
  }
  // What of the motion is the map's; the rest is the track's.
  const Vector3d moved = share * filter.x.head<3>();
  tie.by.yaw = moved[2];
  tie.by.p = centre + moved.head<2>() - Eigen::Rotation2Dd(moved[2]) * centre;
  Matrix3d now = filter.P.topLeftCorner<3, 3>();
  if (known) now = carried(known->map, centre) - share * (before - now) * share.transpose();
  tie.covariance = carried(0.5 * (now + now.transpose()), -centre);
  return tie;
}

}  // namespace gprodom
