#include "gpr/sequential/apexes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/median.h"
#include "base/require.h"

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

struct Candidate {
  double row, column, widening;  // of time zero on; rows per column
  float energy, semblance;
};

class Search {
 public:
  Search(const Eigen::MatrixXf& bscan, const ApexOptions& options)
      : interval_s_(options.sample_interval_s),
        half_(std::max(1, static_cast<int>(std::lround(0.5 * options.pulse_s / interval_s_)))),
        row_step_(std::max(1, half_ / 2)),
        zero_(options.time_zero_s / interval_s_),
        first_(std::max(options.first_time_s / interval_s_, 1.0)),
        least_(options.least_widening_s / interval_s_),
        most_(options.most_widening_s / interval_s_),
        rows_(bscan.rows()),
        columns_(bscan.cols()) {
    padded_.setZero(rows_ + 2 * half_ + 2, columns_);
    padded_.middleRows(half_, rows_) = bscan;
    energy_to_.setZero(columns_, padded_.rows() + 1);
    for (Eigen::Index r = 0; r < padded_.rows(); ++r)
      energy_to_.col(r + 1) = energy_to_.col(r) + padded_.row(r).transpose().array().square();
  }

  std::vector<Apex> run() {
    std::vector<Candidate> found = candidates(), kept;
    std::sort(found.begin(), found.end(),
              [](const Candidate& a, const Candidate& b) { return a.energy > b.energy; });
    std::vector<Apex> apexes;
    for (const Candidate& each : found) {
      const auto has_its_hyperbola = [&](const Candidate& known) {
        const double row = std::hypot(known.row, known.widening * (each.column - known.column));
        return std::abs(each.row - row) < 2.0 * half_;
      };
      if (std::any_of(kept.begin(), kept.end(), has_its_hyperbola)) continue;
      kept.push_back(each);
      apexes.push_back(refined(each));
    }
    return apexes;
  }

 private:
  // That is looked at, in rows after time zero.
  double time(Eigen::Index t) const { return first_ + static_cast<double>(t * row_step_); }

  // A pulse of n columns from `from` on, its middle at `row` of the B-scan; none beyond its end.
  bool pulse_at(double row, Eigen::Index from, Eigen::Index n) {
    top_ = static_cast<Eigen::Index>(row);
    if (row < 0 || top_ + 1 >= rows_ || n <= 0) return false;
    const auto part = static_cast<float>(row - static_cast<double>(top_));
    const Eigen::Index length = 2 * half_ + 1;
    pulse_ = (1 - part) * padded_.block(top_, from, length, n) +
             part * padded_.block(top_ + 1, from, length, n);
    return true;
  }

  // Mean echo along the hyperbola of each column: column t of what its energy explains and of its
  // semblance, columns of the B-scan x times.
  void stack(Eigen::Index t, double width, Eigen::ArrayXXf& explained, Eigen::ArrayXXf& semblance) {
    const Eigen::Index length = 2 * half_ + 1;
    sum_.setZero(length, columns_);
    total_.setZero(columns_);
    count_.setZero(columns_);
    const auto reach = static_cast<int>(width);
    for (int d = -reach; d <= reach; ++d) {
      const Eigen::Index from = std::max<Eigen::Index>(0, -d), n = columns_ - std::abs(d);
      if (!pulse_at(zero_ + std::hypot(time(t), time(t) / width * d), from + d, n)) continue;
      sum_.middleCols(from, n) += pulse_;
      total_.segment(from, n) += energy_to_.col(top_ + length).segment(from + d, n) -
                                 energy_to_.col(top_).segment(from + d, n);
      count_.segment(from, n) += 1.0F;
    }
    explained.col(t) = sum_.colwise().squaredNorm().transpose().array() / count_.max(1.0F);
    // With one flank alone, place and widening cannot be told apart.
    semblance.col(t) = (count_ >= 1.5F * static_cast<float>(reach) && total_ > 0.0F)
                           .select(explained.col(t) / total_.max(1e-30F), 0.0F);
  }

  std::vector<Candidate> candidates() {
    // Half a hyperbola's width in columns at 45 degrees, the shape that is the same at all times.
    std::vector<double> widths;
    for (double w = kNarrowest; w <= 0.5 * static_cast<double>(columns_); w *= kWidthStep)
      widths.push_back(w);
    const auto times = static_cast<Eigen::Index>(
        std::ceil(std::max(0.0, (static_cast<double>(rows_) - zero_ - first_) / row_step_)));
    std::vector<Eigen::ArrayXXf> energy(widths.size(), Eigen::ArrayXXf::Zero(columns_, times));
    std::vector<Eigen::ArrayXXf> semblance = energy;
    for (std::size_t w = 0; w < widths.size(); ++w)
      for (Eigen::Index t = 0; t < times; ++t) stack(t, widths[w], energy[w], semblance[w]);
    std::vector<Candidate> found;
    for (std::size_t w = 1; w + 1 < widths.size(); ++w) {
      const double limit = threshold(semblance[w], widths[w]);
      for (Eigen::Index t = 1; t + 1 < times; ++t) {
        const double widening = time(t) / widths[w];
        if ((least_ > 0 && widening < least_) || (most_ > 0 && widening > most_)) continue;
        for (Eigen::Index c = 1; c + 1 < columns_; ++c) {
          const float here = energy[w](c, t);
          const auto higher = [&](const Eigen::ArrayXXf& near) {
            return (near.block<3, 3>(c - 1, t - 1) > here).any();
          };
          const auto narrower = energy.begin() + static_cast<std::ptrdiff_t>(w) - 1;
          if (semblance[w](c, t) < limit || std::any_of(narrower, narrower + 3, higher)) continue;
          found.push_back({time(t), static_cast<double>(c), widening, here, semblance[w](c, t)});
        }
      }
    }
    return found;
  }

  double threshold(const Eigen::ArrayXXf& semblance, double width) const {
    std::vector<float> values(semblance.data(), semblance.data() + semblance.size());
    values.erase(std::remove(values.begin(), values.end(), 0.0F), values.end());
    if (values.empty()) return 1.0;
    // Independent places: pulses in time, hyperbolas' widths along the line.
    const double places = static_cast<double>(semblance.size()) * row_step_ / (2.0 * half_) / width;
    return semblance_threshold(median(std::move(values)), kFalseApexes / std::max(places, 1.0));
  }

  // The echo along a hyperbola of any place: one wavelet, of a strength for each column, as
  // spreading, the antenna's pattern and the ground have it. Weak flanks so count less. Its energy
  // is the largest eigenvalue of all products of rows.
  float echo(const Candidate& at) {
    const auto last = static_cast<double>(columns_ - 1);
    const double reach = at.row / at.widening;
    const int from = static_cast<int>(std::ceil(std::clamp(at.column - reach, 0.0, last)));
    const int to = static_cast<int>(std::floor(std::clamp(at.column + reach, 0.0, last)));
    sum_.setZero(2 * half_ + 1, std::max(1, to - from + 1));
    for (int c = from; c <= to; ++c)
      if (pulse_at(zero_ + std::hypot(at.row, at.widening * (c - at.column)), c, 1))
        sum_.col(c - from) = pulse_;
    parts_.compute(sum_ * sum_.transpose());
    return parts_.eigenvalues()(2 * half_);
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
        const double low = echo(before), high = echo(after);
        const double curvature = low - 2.0 * echo(at) + high;
        const double top = curvature < 0 ? 0.5 * (low - high) / curvature : high > low ? 1.0 : -1.0;
        const double was = at.*coordinate, middle = start.*coordinate;
        at.*coordinate = std::clamp(was + step * std::clamp(top, -1.0, 1.0), middle - cells[i],
                                    middle + cells[i]);
        moved = std::max(moved, std::abs(at.*coordinate - was) / cells[i]);
      }
    }
    echo(at);
    const Eigen::ArrayXf wavelet = parts_.eigenvectors().rightCols<1>();  // of unit energy
    const Eigen::ArrayXf place = Eigen::ArrayXf::LinSpaced(wavelet.size(), -half_, half_);
    const double middle = (wavelet.square() * place).sum();
    const float strength = (wavelet.matrix().transpose() * sum_).mean();
    return {at.column, (at.row + middle) * interval_s_, at.widening * interval_s_,
            std::abs(strength) * wavelet.abs().maxCoeff(), at.semblance};
  }

  const double interval_s_;
  const int half_;             // rows, of an echo
  const int row_step_;         // from a time that is looked at to the next
  const double zero_;          // row of time zero
  const double first_;         // row after it that is looked at
  const double least_, most_;  // widenings, rows per column
  const Eigen::Index rows_, columns_;
  Eigen::MatrixXf padded_;     // half_ rows of zeros before the B-scan, and after it
  Eigen::ArrayXXf energy_to_;  // columns x rows: sum of squares of the rows before
  Eigen::Index top_ = 0;       // of pulse_, in padded_
  Eigen::MatrixXf pulse_, sum_;
  Eigen::ArrayXf total_, count_;
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> parts_;
};

}  // namespace

double semblance_threshold(double median, double chance) {
  if (!(median > 0.0 && median < 1.0)) return 1.0;
  const double exponent = std::log(2.0) / -std::log1p(-median);  // n - 1
  return -std::expm1(std::log(chance) / exponent);
}

std::vector<Apex> find_apexes(const Eigen::MatrixXf& bscan, const ApexOptions& options) {
  require(options.sample_interval_s > 0.0 && options.pulse_s > 0.0,
          "find_apexes: sample_interval and pulse must be positive");
  if (bscan.size() == 0) return {};
  return Search(bscan, options).run();
}

}  // namespace gprodom::gpr
