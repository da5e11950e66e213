#include "gpr/sequential/dec.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "base/require.h"

namespace gprodom::gpr {

namespace {

constexpr int kLevels = 64;           // of the histogram that Otsu's threshold is read from
constexpr double kDynamicRange = 12;  // natural logarithms below the maximum that the bins cover

// The boundary between bins 0..b and b+1.. with the greatest variance between the two classes.
int otsu_bin(const std::array<int, kLevels>& histogram, int total) {
  double sum_all = 0.0;
  for (int b = 0; b < kLevels; ++b) sum_all += static_cast<double>(b) * histogram[b];
  double best = -1.0, sum_below = 0.0;
  int best_bin = 0, below = 0;
  for (int b = 0; b + 1 < kLevels; ++b) {
    below += histogram[b];
    sum_below += static_cast<double>(b) * histogram[b];
    const int above = total - below;
    if (below == 0 || above == 0) continue;
    const double gap = sum_below / below - (sum_all - sum_below) / above;
    const double between = static_cast<double>(below) * above * gap * gap;
    if (between > best) {
      best = between;
      best_bin = b;
    }
  }
  return best_bin;
}

void insert_point(EnergyPoints& points, const EnergyPoint& point) {
  int at = std::min(points.count, kMaxEnergyPoints);
  while (at > 0 && points.point[at - 1].energy < point.energy) --at;
  if (at == kMaxEnergyPoints) return;
  points.count = std::min(points.count + 1, kMaxEnergyPoints);
  for (int i = points.count - 1; i > at; --i) points.point[i] = points.point[i - 1];
  points.point[at] = point;
}

}  // namespace

void trace_energy(const float* trace, std::size_t n, int half_width, float* energy) {
  const auto size = static_cast<std::ptrdiff_t>(n);
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    const std::ptrdiff_t from = std::max<std::ptrdiff_t>(0, i - half_width);
    const std::ptrdiff_t to = std::min<std::ptrdiff_t>(size - 1, i + half_width);
    float sum = 0.0F;
    for (std::ptrdiff_t k = from; k <= to; ++k) sum += trace[k] * trace[k];
    energy[i] = sum / static_cast<float>(to - from + 1);
  }
}

double background_threshold(const float* energy, std::size_t n) {
  const float strongest = n > 0 ? *std::max_element(energy, energy + n) : 0.0F;
  if (!(strongest > 0.0F)) return 0.0;
  std::array<int, kLevels> histogram{};
  for (std::size_t i = 0; i < n; ++i) {
    const double level = std::log(std::max(energy[i] / strongest, 1e-30F)) / kDynamicRange + 1.0;
    ++histogram[std::clamp(static_cast<int>(level * kLevels), 0, kLevels - 1)];
  }
  if (histogram[kLevels - 1] == static_cast<int>(n)) return 0.0;  // all equal
  const int bin = otsu_bin(histogram, static_cast<int>(n));
  return strongest * std::exp(((bin + 1.0) / kLevels - 1.0) * kDynamicRange);
}

EnergyPoints energy_points(const float* energy, std::size_t n, int first_row, double threshold) {
  EnergyPoints points;
  for (std::size_t i = static_cast<std::size_t>(std::max(1, first_row)); i + 1 < n; ++i) {
    const double before = energy[i - 1], here = energy[i], after = energy[i + 1];
    if (!(here > before && here >= after && here >= threshold)) continue;
    const double curvature = before - 2.0 * here + after;
    insert_point(points, {static_cast<double>(i) + 0.5 * (before - after) / curvature, here});
  }
  return points;
}

// Best score of a path that ends in each point, and the point of the previous filled column from
// which it came.
void CurveRefiner::choose(const std::vector<EnergyPoints>& columns) {
  for (std::size_t f = 0; f < filled_.size(); ++f) {
    const EnergyPoints& here = columns[filled_[f]];
    for (int i = 0; i < here.count; ++i) {
      double best = f == 0 ? 0.0 : -std::numeric_limits<double>::infinity();
      int from = 0;
      if (f > 0) {
        const EnergyPoints& before = columns[filled_[f - 1]];
        const double gap = filled_[f] - filled_[f - 1];
        for (int k = 0; k < before.count; ++k) {
          const double change = here.point[i].row - before.point[k].row;
          const double score = score_[f - 1][k] - options_.jump_penalty * change * change / gap;
          if (score > best) {
            best = score;
            from = k;
          }
        }
      }
      score_[f][i] = best + here.point[i].energy / here.point[0].energy;
      came_from_[f][i] = from;
    }
  }
}

void CurveRefiner::smooth(Eigen::VectorXd& curve) {
  const Eigen::Index half = options_.smoothing / 2, n = rough_.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index from = std::max<Eigen::Index>(0, i - half);
    const Eigen::Index to = std::min<Eigen::Index>(n - 1, i + half);
    curve[i] = rough_.segment(from, to - from + 1).mean();
  }
}

bool CurveRefiner::refine(const std::vector<EnergyPoints>& columns, Eigen::VectorXd& curve) {
  const auto n = static_cast<Eigen::Index>(columns.size());
  curve.setZero(n);
  rough_.setZero(n);
  filled_.clear();
  for (int c = 0; c < n; ++c) {
    if (columns[c].count > 0) filled_.push_back(c);
  }
  if (filled_.empty()) return false;
  score_.resize(std::max(score_.size(), columns.size()));
  came_from_.resize(score_.size());
  choose(columns);

  const auto& last = score_[filled_.size() - 1];
  auto pick = static_cast<int>(
      std::max_element(last.begin(), last.begin() + columns[filled_.back()].count) - last.begin());
  Eigen::Index right = n;  // columns from here on are done
  for (std::size_t f = filled_.size(); f-- > 0;) {
    const Eigen::Index c = filled_[f];
    rough_[c] = columns[c].point[pick].row;
    const double next = right < n ? rough_[right] : rough_[c];
    for (Eigen::Index k = c + 1; k < right; ++k) {
      rough_[k] = rough_[c] +
                  (next - rough_[c]) * static_cast<double>(k - c) / static_cast<double>(right - c);
    }
    right = c;
    pick = came_from_[f][pick];
  }
  rough_.head(right).setConstant(rough_[right]);
  smooth(curve);
  return true;
}

Alignment CurveAligner::align(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  require(a.size() == b.size() && a.size() >= 3,
          "align: both curves must have the same length, at least three");
  const int columns = static_cast<int>(a.size());
  distances_.fill(columns, options_, [&](int width, int from_a, int from_b) {
    const auto in_a = a.segment(from_a, width), in_b = b.segment(from_b, width);
    const double variation =
        (in_a.array() - in_a.mean()).square().sum() + (in_b.array() - in_b.mean()).square().sum();
    return variation > 1e-9 * width ? (in_a - in_b).squaredNorm() / variation
                                    : std::numeric_limits<double>::quiet_NaN();
  });
  return locate_minimum(distances_, columns / 3.0, MinimumShape::kParabola);
}

}  // namespace gprodom::gpr
