// Positions from outside: datum, tie to site, and which fixes are trusted.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "map/fixes/fix_keeper.h"
#include "support/noise.h"

namespace gprodom {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(Datum, PlaneOfEastNorthAndUp) {
  const Datum datum(Geodetic(0.0, 8.0, 0.0));
  // A degree along the equator, and along a meridian there (WGS 84).
  EXPECT_NEAR(datum.to_site({0.0, 8.001, 0.0}).x(), 111.3195, 1e-3);
  EXPECT_NEAR(datum.to_site({0.001, 8.0, 0.0}).y(), 110.5743, 1e-3);
  EXPECT_NEAR(datum.to_site({0.0, 8.0, 5.0}).z(), 5.0, 1e-9);
}

TEST(Fixes, FitTellsHowTheTrackLiesInSite) {
  const PlanarPose site_from_track{{100.0, -20.0}, 2.5};
  std::vector<PlacePair> pairs;
  for (const Vector2d& p : {Vector2d(0, 0), Vector2d(10, 0), Vector2d(10, 5)})
    pairs.push_back({{p, 0.0}, compose(site_from_track, {p, 0.0}).p, 0.1, std::nullopt, 0.0});
  const auto fit = fit_site(pairs);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->yaw, 2.5, 1e-12);
  EXPECT_TRUE(fit->p.isApprox(site_from_track.p, 1e-12));
  pairs.resize(1);
  EXPECT_FALSE(fit_site(pairs)) << "one place has no direction";
  pairs[0].heading = 2.6, pairs[0].heading_sigma = 0.05;
  EXPECT_NEAR(fit_site(pairs)->yaw, 2.6, 1e-12) << "by its heading";
}

PositionFix fix_at(double seconds, const Vector3d& position, double sigma, FixQuality quality) {
  PositionFix fix;
  fix.time = from_seconds(1000.0 + seconds);
  fix.position = position;
  fix.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  fix.quality = quality;
  return fix;
}

// A drive at 0.5 m/s along a bend of 20 m radius, its odometry 1 % too long, and fixes each second.
class Judged : public ::testing::Test {
 public:
  explicit Judged(const AnchorConfig& config = told()) : keeper_(config) {}
  static constexpr double kSpeed = 0.5, kRadius = 20.0, kSigma = 0.03, kTooLong = 1.01;

  // error_at: of the fix at that time (s), beside its noise. None for NaN.
  void drive(double seconds, const std::function<Vector2d(double)>& error_at) {
    for (int i = 0; i < 5 * seconds; ++i) {
      const double way = kTooLong * kSpeed * now_;
      PathState state;
      state.time = from_seconds(1000.0 + now_);
      state.pose = on_bend(kSpeed * now_);
      state.pose.p *= kTooLong;  // the gyro is right
      state.slip_sigma = slip_sigma_;
      state.covariance = Vector3d(1e-5 * way, 1e-5 * way, 1e-7 * way).asDiagonal();
      // As an error of the scale moves and turns nothing but the place along the track.
      state.d_scale << -state.pose.p, 0.0;
      path_.add(state);
      if (i % 5 == 4) {
        const Vector2d error = error_at(now_);
        if (!std::isnan(error.x())) fix(error);
      }
      now_ += 0.2;
    }
  }

  void fix(const Vector2d& error) {
    const Vector2d place = compose({{50, 60}, 1.0}, on_bend(kSpeed * now_)).p;
    const Vector2d seen = place + error + kSigma * Vector2d(normal_(), normal_());
    const PositionFix fix = fix_at(now_, {seen.x(), seen.y(), 0}, kSigma, FixQuality::kFixed);
    keeper_.add(fix, *path_.mark(fix.time), {1.0, 0.02});
  }

  static PlanarPose on_bend(double way) {
    const double angle = way / kRadius;
    return {{kRadius * std::sin(angle), kRadius * (1 - std::cos(angle))}, angle};
  }

  // Of the trusted fixes the largest error in site.
  double worst() const {
    double worst = 0.0;
    for (const Anchor& anchor : keeper_.anchors()) {
      const double t = to_seconds(anchor.mark.time()) - 1000.0;
      const Vector2d place = compose({{50, 60}, 1.0}, on_bend(kSpeed * t)).p;
      worst = std::max(worst, (anchor.p.head<2>() - place).norm());
    }
    return worst;
  }

  static Vector2d none(double) { return Vector2d::Zero(); }
  static Vector2d away(double) { return {std::nan(""), 0.0}; }

  // The antenna is where the robot is.
  static AnchorConfig told() {
    AnchorConfig config;
    config.antennas[0] = Vector3d::Zero();
    return config;
  }

  Noise normal_{5};
  MapPath path_{kNodeSpacing};
  FixKeeper keeper_;
  double now_ = 0.0, slip_sigma_ = 0.0;
};

TEST_F(Judged, GoodOnesAreTrustedAlsoAfterALongOutage) {
  drive(30, none);
  EXPECT_GE(keeper_.anchors().size(), 25U);
  drive(120, away);
  const std::size_t before = keeper_.anchors().size();
  drive(20, none);
  EXPECT_GE(keeper_.anchors().size(), before + 18);
  EXPECT_EQ(keeper_.trouble(), FixTrouble::kNone);
  EXPECT_EQ(keeper_.refused(), 0U);
}

TEST_F(Judged, AJumpIsToldAndNotUsedUntilTheyComeBack) {
  drive(30, none);
  drive(5, [](double) { return Vector2d(3.0, 0.0); });
  EXPECT_EQ(keeper_.trouble(), FixTrouble::kJump);
  EXPECT_LT(worst(), 0.2);
  drive(10, none);
  EXPECT_EQ(keeper_.trouble(), FixTrouble::kNone);
  EXPECT_LT(worst(), 0.2);
  EXPECT_EQ(keeper_.refused(), 5U);
}

// Where the wheel may slip and the antenna's place is not told, a fix of long ago agrees with any.
class Untold : public Judged {
 public:
  Untold() : Judged(AnchorConfig()) {}
  using Judged::drive, Judged::worst, Judged::keeper_, Judged::slip_sigma_;
  void TestBody() override {}
};
TEST(UntoldAntenna, AFixGoesOnNoneOfLongAgo) {
  for (int direction = 0; direction < 8; ++direction) {
    Untold run;
    run.slip_sigma_ = 0.1;
    run.drive(1, Judged::none);
    run.drive(10, Judged::away);
    run.drive(60, Judged::none);
    const Vector2d jump = Eigen::Rotation2Dd(M_PI / 4 * direction) * Vector2d(5.0, 0.0);
    run.drive(90, [&](double) { return jump; });
    EXPECT_LT(run.worst(), 0.2) << direction;
    run.drive(20, Judged::none);
    EXPECT_EQ(run.keeper_.trouble(), FixTrouble::kNone) << direction;
    EXPECT_LT(run.worst(), 0.2) << direction;
  }
}

TEST_F(Judged, AReceiverThatConvergesAfterAnOutageIsTakenBack) {
  drive(30, none);
  drive(20, away);
  const double begin = now_;
  bool told = false;
  for (int i = 0; i < 40; ++i) {
    drive(1, [begin](double t) { return Vector2d(0.0, 5.0 * std::exp((begin - t) / 8)); });
    told = told || keeper_.trouble() != FixTrouble::kNone;
  }
  drive(10, none);
  EXPECT_TRUE(told);
  EXPECT_LT(worst(), 2.0) << "of 5 m";
  EXPECT_EQ(keeper_.trouble(), FixTrouble::kNone);
  EXPECT_GT(keeper_.anchors().size(), 60U);
}

TEST_F(Judged, ASlowDragIsToldAndTakenBack) {
  drive(60, none);
  const double begin = now_;
  const auto dragged = [begin](double t) { return Vector2d(0.05 * (t - begin), 0.0); };
  double told_after = 0.0;
  for (int i = 0; i < 60 && told_after == 0.0; ++i) {
    drive(1, dragged);
    if (keeper_.trouble() == FixTrouble::kDrag) told_after = now_ - begin;
  }
  EXPECT_GT(told_after, 0.0);
  EXPECT_LT(told_after, 30.0);
  drive(30, dragged);
  EXPECT_LT(worst(), 0.6);
  EXPECT_NE(keeper_.trouble(), FixTrouble::kNone);
}

TEST_F(Judged, PositionsThatComeAgainAreNotUsed) {
  drive(20, none);
  PositionFix old = fix_at(now_ - 0.2, {51, 61, 0}, 0.03, FixQuality::kFixed);
  keeper_.add(old, *path_.mark(old.time), {});
  const std::size_t before = keeper_.anchors().size();
  drive(10, away);
  old.time = from_seconds(1000.0 + now_ - 0.2);
  keeper_.add(old, *path_.mark(old.time), {});
  EXPECT_EQ(keeper_.trouble(), FixTrouble::kRepeated);
  EXPECT_EQ(keeper_.anchors().size(), before);
}

TEST_F(Judged, SwappedLatitudeAndLongitudeAreTold) {
  drive(1, away);
  AnchorConfig config;
  config.datum = Vector3d(47.0, 8.0, 400.0);
  FixKeeper keeper(config);
  PositionFix fix = fix_at(0.5, {8.0001, 47.0001, 400.0}, 1.0, FixQuality::kSingle);
  fix.frame = FixFrame::kGeodetic;
  keeper.add(fix, *path_.mark(fix.time), {});
  EXPECT_EQ(keeper.trouble(), FixTrouble::kSwapped);
  fix.position << 52.0, 9.0, 400.0;
  keeper.add(fix, *path_.mark(fix.time), {});
  EXPECT_EQ(keeper.trouble(), FixTrouble::kFar);
  EXPECT_TRUE(keeper.anchors().empty());
}

}  // namespace
}  // namespace gprodom
