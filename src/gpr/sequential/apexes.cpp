#include "gpr/sequential/apexes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gprodom::gpr {
namespace {

// Chance of a false apex in one B-scan of random ground.
constexpr double kFalseApexes = 0.01;
// Columns on either side of the narrowest hyperbola: two unknowns (place, widening) need more.
constexpr int kNarrowest = 4;
// From one widening to the next. Half a step moves the echo at the edge (45 degrees) by 0.04 of the
// travel time, a quarter of a period for echoes of up to some ten periods.
constexpr double kWidthStep = 1.15;
// Of a cell of the search, by which a refined place still moves from round to round; the search
// leaves half a cell. A place that is not at rest after so many rounds lies in no clear maximum.
constexpr double kAtRest = 0.05;
constexpr int kMostRounds = 30;

double moveout(double time, double widening, double columns) {
  return std::hypot(time, widening * columns) - time;
}

struct Candidate {
  double row, column, widening;  // of time zero on; rows per column
  float energy, semblance;
};

class Search {
 public:
  Search(const Eigen::MatrixXf& bscan, const ApexOptions& options)
      : interval_s_(options.sample_interval_s),
        half_(std::max(1, static_cast<int>(std::lround(0.5 * options.pulse_s / interval_s_)))),
        zero_(options.time_zero_s / interval_s_),
        rows_(bscan.rows()),
        columns_(bscan.cols()) {
    padded_.setZero(rows_ + 2 * half_ + 2, columns_);
    padded_.middleRows(half_, rows_) = bscan;
    energy_to_.setZero(padded_.rows() + 1, columns_);
    for (Eigen::Index r = 0; r < padded_.rows(); ++r)
      energy_to_.row(r + 1) = energy_to_.row(r) + padded_.row(r).array().square().matrix();
    const double first = std::max(options.first_time_s / interval_s_, 1.0);
    const int step = std::max(1, half_ / 2);
    times_.reserve(static_cast<std::size_t>(rows_ / step) + 1);
    for (double t = first; zero_ + t < static_cast<double>(rows_); t += step) times_.push_back(t);
    row_step_ = step;
    least_ = options.least_widening_s / interval_s_;
    most_ = options.most_widening_s / interval_s_;
  }

  std::vector<Apex> run() {
    std::vector<Candidate> found = candidates();
    std::sort(found.begin(), found.end(),
              [](const Candidate& a, const Candidate& b) { return a.energy > b.energy; });
    std::vector<Candidate> kept;
    for (const Candidate& candidate : found) {
      const bool known = std::any_of(
          kept.begin(), kept.end(), [&](const Candidate& k) { return on_hyperbola(candidate, k); });
      if (!known) kept.push_back(candidate);
    }
    std::vector<Apex> apexes;
    apexes.reserve(kept.size());
    for (const Candidate& candidate : kept) apexes.push_back(refined(candidate));
    return apexes;
  }

 private:
  using Grid = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic>;  // times x columns

  // Half a hyperbola's width in columns at 45 degrees, the shape that is the same at all times.
  std::vector<double> half_widths() const {
    std::vector<double> widths;
    for (double width = kNarrowest; width <= 0.5 * static_cast<double>(columns_);
         width *= kWidthStep)
      widths.push_back(width);
    return widths;
  }

  // Mean echo along the hyperbola of each column, and the energy of what it is the mean of.
  void stack(double time, double widening, Eigen::ArrayXf& explained, Eigen::ArrayXf& semblance) {
    const Eigen::Index length = 2 * half_ + 1;
    sum_.setZero(length, columns_);
    total_.setZero(columns_);
    count_.setZero(columns_);
    const auto reach = static_cast<int>(time / widening);
    for (int d = -reach; d <= reach; ++d) {
      const double row = zero_ + time + moveout(time, widening, d);  // the echo's middle, in bscan
      const auto top = static_cast<Eigen::Index>(row);
      if (top + 1 >= rows_) continue;
      const auto part = static_cast<float>(row - static_cast<double>(top));
      const Eigen::Index from = std::max<Eigen::Index>(0, -d);
      const Eigen::Index n = columns_ - std::abs(d);
      if (n <= 0) continue;
      sum_.middleCols(from, n) += (1 - part) * padded_.block(top, from + d, length, n) +
                                  part * padded_.block(top + 1, from + d, length, n);
      total_.segment(from, n) +=
          (energy_to_.block(top + length, from + d, 1, n) - energy_to_.block(top, from + d, 1, n))
              .transpose()
              .array();
      count_.segment(from, n) += 1.0F;
    }
    explained = sum_.colwise().squaredNorm().transpose().array() / count_.max(1.0F);
    // With one flank alone, place and widening cannot be told apart.
    semblance = (count_ >= 1.5F * static_cast<float>(reach) && total_ > 0.0F)
                    .select(explained / total_.max(1e-30F), 0.0F);
  }

  std::vector<Candidate> candidates() {
    const std::vector<double> widths = half_widths();
    const auto times = static_cast<Eigen::Index>(times_.size());
    std::vector<Grid> energy(widths.size(), Grid::Zero(times, columns_));
    std::vector<Grid> semblance = energy;
    Eigen::ArrayXf explained, similar;
    for (std::size_t w = 0; w < widths.size(); ++w) {
      for (Eigen::Index t = 0; t < times; ++t) {
        const double widening = times_[static_cast<std::size_t>(t)] / widths[w];
        stack(times_[static_cast<std::size_t>(t)], widening, explained, similar);
        energy[w].row(t) = explained.transpose();
        semblance[w].row(t) = similar.transpose();
      }
    }
    std::vector<Candidate> found;
    for (std::size_t w = 1; w + 1 < widths.size(); ++w) {
      const double limit = threshold(semblance[w], widths[w]);
      for (Eigen::Index t = 1; t + 1 < times; ++t) {
        const double widening = times_[static_cast<std::size_t>(t)] / widths[w];
        if ((least_ > 0 && widening < least_) || (most_ > 0 && widening > most_)) continue;
        for (Eigen::Index c = 1; c + 1 < columns_; ++c) {
          if (semblance[w](t, c) < limit || !is_maximum(energy, w, t, c)) continue;
          found.push_back({times_[static_cast<std::size_t>(t)], static_cast<double>(c), widening,
                           energy[w](t, c), semblance[w](t, c)});
        }
      }
    }
    return found;
  }

  double threshold(const Grid& semblance, double width) const {
    std::vector<float> values(semblance.data(), semblance.data() + semblance.size());
    values.erase(std::remove(values.begin(), values.end(), 0.0F), values.end());
    if (values.empty()) return 1.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    // Independent places: pulses in time, hyperbolas' widths along the line.
    const double places = static_cast<double>(semblance.size()) * row_step_ / (2.0 * half_) / width;
    return semblance_threshold(*middle, kFalseApexes / std::max(places, 1.0));
  }

  static bool is_maximum(const std::vector<Grid>& energy, std::size_t w, Eigen::Index t,
                         Eigen::Index c) {
    const float here = energy[w](t, c);
    for (std::size_t i = w - 1; i <= w + 1; ++i)
      if ((energy[i].block<3, 3>(t - 1, c - 1) > here).any()) return false;
    return true;
  }

  bool on_hyperbola(const Candidate& candidate, const Candidate& known) const {
    const double columns = candidate.column - known.column;
    const double along = known.row + moveout(known.row, known.widening, columns);
    return std::abs(candidate.row - along) < 2.0 * half_;
  }

  // The echo along a hyperbola of any place: one wavelet, of a strength for each column, as
  // spreading, the antenna's pattern and the ground have it. Weak flanks so count less.
  struct Echo {
    Eigen::VectorXf wavelet;  // of the mean strength
    float energy = 0.0F;      // that it explains: the largest eigenvalue of all products of rows
  };

  Echo echo(const Candidate& at) {
    const auto last = static_cast<double>(columns_ - 1);
    const double reach = at.row / at.widening;
    const int from = static_cast<int>(std::ceil(std::clamp(at.column - reach, 0.0, last)));
    const int to = static_cast<int>(std::floor(std::clamp(at.column + reach, 0.0, last)));
    const Eigen::Index length = 2 * half_ + 1;
    sum_.setZero(length, std::max(0, to - from + 1));
    for (int c = from; c <= to; ++c) {
      const double row = zero_ + at.row + moveout(at.row, at.widening, c - at.column);
      const auto top = static_cast<Eigen::Index>(row);
      if (row < 0 || top + 1 >= rows_) continue;
      const auto part = static_cast<float>(row - static_cast<double>(top));
      sum_.col(c - from) = (1 - part) * padded_.col(c).segment(top, length) +
                           part * padded_.col(c).segment(top + 1, length);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> parts(sum_ * sum_.transpose());
    Echo result;
    result.wavelet = parts.eigenvectors().rightCols<1>();
    result.energy = parts.eigenvalues()(length - 1);
    if (sum_.cols() > 0) result.wavelet *= (result.wavelet.transpose() * sum_).mean();
    return result;
  }

  // One coordinate after the other to the top of a parabola through the energy, until none moves;
  // not beyond the places of the search beside it, which have less.
  Apex refined(const Candidate& start) {
    double Candidate::*const coordinates[] = {&Candidate::column, &Candidate::row,
                                              &Candidate::widening};
    const double cells[] = {1.0, static_cast<double>(row_step_), (kWidthStep - 1) * start.widening};
    Candidate at = start;
    double moved = 1.0;  // cells
    for (int round = 0; round < kMostRounds && moved > kAtRest; ++round) {
      moved = 0.0;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto coordinate = coordinates[i];
        const double step = 0.5 * cells[i];
        Candidate before = at, after = at;
        before.*coordinate -= step;
        after.*coordinate += step;
        const double low = echo(before).energy, high = echo(after).energy;
        const double curvature = low - 2.0 * echo(at).energy + high;
        const double top = curvature < 0 ? 0.5 * (low - high) / curvature : high > low ? 1.0 : -1.0;
        const double was = at.*coordinate, middle = start.*coordinate;
        at.*coordinate = std::clamp(was + step * std::clamp(top, -1.0, 1.0), middle - cells[i],
                                    middle + cells[i]);
        moved = std::max(moved, std::abs(at.*coordinate - was) / cells[i]);
      }
    }
    const Echo found = echo(at);
    const Eigen::ArrayXf power = found.wavelet.array().square();
    const Eigen::ArrayXf place = Eigen::ArrayXf::LinSpaced(power.size(), -half_, half_);
    const double middle = (power * place).sum() / std::max(power.sum(), 1e-30F);
    Apex apex;
    apex.column = at.column;
    apex.time_s = (at.row + middle) * interval_s_;
    apex.widening_s = at.widening * interval_s_;
    apex.amplitude = found.wavelet.cwiseAbs().maxCoeff();
    apex.semblance = at.semblance;
    return apex;
  }

  const double interval_s_;
  const int half_;     // rows, of an echo
  const double zero_;  // row of time zero
  const Eigen::Index rows_, columns_;
  Eigen::MatrixXf padded_;     // half_ rows of zeros before the B-scan, and after it
  Eigen::MatrixXf energy_to_;  // sum of squares of the rows before
  std::vector<double> times_;  // rows after time zero that are looked at
  int row_step_ = 1;
  double least_ = 0.0, most_ = 0.0;  // widenings, rows per column
  Eigen::MatrixXf sum_;
  Eigen::ArrayXf total_, count_;
};

}  // namespace

double semblance_threshold(double median, double chance) {
  if (!(median > 0.0 && median < 1.0)) return 1.0;
  const double exponent = std::log(2.0) / -std::log1p(-median);  // n - 1
  return -std::expm1(std::log(chance) / exponent);
}

std::vector<Apex> find_apexes(const Eigen::MatrixXf& bscan, const ApexOptions& options) {
  if (!(options.sample_interval_s > 0.0) || !(options.pulse_s > 0.0))
    throw std::invalid_argument("find_apexes: sample_interval and pulse must be positive");
  if (bscan.size() == 0) return {};
  return Search(bscan, options).run();
}

}  // namespace gprodom::gpr
