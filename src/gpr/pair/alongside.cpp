#include "gpr/pair/alongside.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "gpr/pair/spectra.h"
#include "gpr/pair/transfer.h"

namespace gprodom::gpr {

namespace {

// Places nearer than this show the same ground: half of the shortest wave along the track that
// carries most of the power.
constexpr double kSamePlace_m = 0.05;

// Independent columns lie so far apart along the track, m: an eighth of a wavelength of 400 MHz in
// ground of 0.1 m/ns on either side. A wrong value is corrected by the scatter of the matches
// (MatchScatter).
constexpr double kIndependent_m = 0.06;

constexpr std::array<double, 5> kStretches = {-0.16, -0.08, 0.0, 0.08, 0.16};

// Correlations of all rows of the query with all of the memory, in one block of depth.
struct Block {
  Eigen::MatrixXf products;
  Eigen::VectorXf energy, neighbour;  // of the memory's rows, and their products with the next row
  double query_energy = 0.0, weight = 0.0;
  double frequencies = 0.0;  // independent ones, by their weights
};

struct Place {
  double offset, stretch;
};

// Position of row i of the query among the rows of the memory.
struct Position {
  Eigen::Index index;
  float fraction;
};

Position position(Eigen::Index i, Eigen::Index count, Eigen::Index rows, Eigen::Index reach,
                  const Place& at) {
  const double middle = 0.5 * static_cast<double>(count - 1);
  const double p =
      static_cast<double>(i + reach) + at.offset + at.stretch * (static_cast<double>(i) - middle);
  const double whole = std::clamp(std::floor(p), 0.0, static_cast<double>(rows - 2));
  return {static_cast<Eigen::Index>(whole), static_cast<float>(std::clamp(p - whole, 0.0, 1.0))};
}

double correlation(const Block& block, Eigen::Index reach, const Place& at) {
  const Eigen::Index n = block.products.rows(), m = block.products.cols();
  double sum = 0, energy = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto [j, f] = position(i, n, m, reach, at);
    sum += (1 - f) * block.products(i, j) + f * block.products(i, j + 1);
    energy += (1 - f) * (1 - f) * block.energy[j] + f * f * block.energy[j + 1] +
              2 * f * (1 - f) * block.neighbour[j];
  }
  const double both = energy * block.query_energy;
  return both > 0 ? sum / std::sqrt(both) : 0.0;
}

std::vector<Block> blocks_of(const ColumnMatrix& query, const ColumnMatrix& memory,
                             const Eigen::ArrayXf& weights) {
  const Eigen::Index width = query.cols() / kDepthBlocks, frequencies = width / 2;
  std::vector<Block> blocks;
  for (int k = 0; k < kDepthBlocks; ++k) {
    const auto q = query.middleCols(k * width, width), m = memory.middleCols(k * width, width);
    Block block;
    block.products.noalias() = q * m.transpose();
    block.energy = m.rowwise().squaredNorm();
    block.neighbour = Eigen::VectorXf::Zero(m.rows());
    for (Eigen::Index j = 0; j + 1 < m.rows(); ++j) block.neighbour[j] = m.row(j).dot(m.row(j + 1));
    block.query_energy = q.squaredNorm();
    const Eigen::ArrayXf w = weights.segment(k * frequencies, frequencies);
    block.weight = w.sum();
    const double squares = w.square().sum();
    block.frequencies = squares > 0 ? block.weight * block.weight / squares : 0.0;
    blocks.push_back(std::move(block));
  }
  return blocks;
}

double mean_correlation(const std::vector<Block>& blocks, Eigen::Index reach, const Place& at) {
  double sum = 0, weight = 0;
  for (const Block& block : blocks) {
    sum += block.weight * correlation(block, reach, at);
    weight += block.weight;
  }
  return weight > 0 ? sum / weight : 0.0;
}

// The maximum of the parabola through three values at -1, 0 and 1, at most half a step away.
double peak(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

template <typename F>
Place refined(Place at, const F& value) {
  constexpr double kOffsetStep = 0.5, kStretchStep = 0.04;
  for (int pass = 0; pass < 3; ++pass) {
    const double o = kOffsetStep, s = kStretchStep;
    at.offset +=
        o * peak(value({at.offset - o, at.stretch}), value(at), value({at.offset + o, at.stretch}));
    at.stretch +=
        s * peak(value({at.offset, at.stretch - s}), value(at), value({at.offset, at.stretch + s}));
  }
  return at;
}

// Cramer-Rao bound of the offset, columns^2: of a correlation c with the second derivative -b, seen
// in N independent samples, (1 - c^2) / (N c b) for each block. 0 where no block has a peak.
double variance_at(const std::vector<Block>& blocks, Eigen::Index reach, const Place& at,
                   double spacing_m) {
  constexpr double kStep = 0.5;  // columns
  const auto rows = static_cast<double>(blocks.front().products.rows());
  const double columns = std::max(1.0, rows * spacing_m / kIndependent_m);
  double information = 0;
  for (const Block& block : blocks) {
    const double c = correlation(block, reach, at);
    const double before = correlation(block, reach, {at.offset - kStep, at.stretch});
    const double after = correlation(block, reach, {at.offset + kStep, at.stretch});
    const double bend = (2 * c - before - after) / (kStep * kStep);
    if (c > 0 && bend > 0)
      information += 2 * block.frequencies * columns * c * bend / std::max(1e-3, 1 - c * c);
  }
  return information > 0 ? 1 / information : 0.0;
}

// Least mean squared coherence; that of unrelated columns is one over the number of independent
// ones in a patch, some 0.12.
constexpr double kLeastCoherence = 0.3;

}  // namespace

double evidence(double correlation) {
  const double c = std::clamp(correlation, 0.0, 0.999);
  return -std::log(1 - c * c);
}

std::optional<Alongside> find_alongside(const ColumnMatrix& query, const ColumnMatrix& memory,
                                        Eigen::Index reach, const Eigen::ArrayXf& weights,
                                        double spacing_m) {
  const std::vector<Block> blocks = blocks_of(query, memory, weights);
  const auto value = [&](const Place& at) { return mean_correlation(blocks, reach, at); };
  std::vector<double> best_of(2 * static_cast<std::size_t>(reach) + 1, -1.0);
  Place best{0, 0};
  double most = -1;
  for (Eigen::Index o = -reach; o <= reach; ++o)
    for (const double stretch : kStretches) {
      const Place at{static_cast<double>(o), stretch};
      const double c = value(at);
      double& here = best_of[static_cast<std::size_t>(o + reach)];
      here = std::max(here, c);
      if (c > most) most = c, best = at;
    }
  if (std::abs(best.offset) >= static_cast<double>(reach)) return std::nullopt;
  Alongside found;
  const Place at = refined(best, value);
  found.offset = at.offset;
  found.stretch = at.stretch;
  found.correlation = value(at);
  double second = 0;
  for (Eigen::Index o = -reach; o <= reach; ++o)
    if (std::abs(static_cast<double>(o) - at.offset) * spacing_m > kSamePlace_m)
      second = std::max(second, best_of[static_cast<std::size_t>(o + reach)]);
  found.score = evidence(found.correlation) - evidence(second);
  found.variance = variance_at(blocks, reach, at, spacing_m);
  if (found.variance <= 0) return std::nullopt;
  return found;
}

ColumnMatrix aligned_rows(const ColumnMatrix& memory, Eigen::Index count, Eigen::Index reach,
                          double offset, double stretch) {
  ColumnMatrix rows(count, memory.cols());
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto [j, f] = position(i, count, memory.rows(), reach, {offset, stretch});
    rows.row(i) = (1 - f) * memory.row(j) + f * memory.row(j + 1);
  }
  return rows;
}

void subtract_mean(ColumnMatrix& rows) {
  const Eigen::RowVectorXf mean = rows.colwise().mean();
  rows.rowwise() -= mean;
}

std::optional<Alongside> find_by_coherence(const ColumnMatrix& query, const ColumnMatrix& memory,
                                           Eigen::Index reach) {
  const Eigen::Index count = query.rows();
  ColumnMatrix q = query;
  subtract_mean(q);
  Eigen::VectorXd coherence(2 * reach + 1);
  for (Eigen::Index o = 0; o <= 2 * reach; ++o) {
    ColumnMatrix m = memory.middleRows(o, count);
    subtract_mean(m);
    coherence[o] = Transfer::coherence(q, m);
  }
  Eigen::Index best = 0;
  const double most = coherence.maxCoeff(&best);
  double second = 0;
  constexpr Eigen::Index kNear = 3;  // columns that show the same ground
  for (Eigen::Index o = 0; o <= 2 * reach; ++o)
    if (std::abs(o - best) > kNear) second = std::max(second, coherence[o]);
  if (best == 0 || best == 2 * reach || most < kLeastCoherence) return std::nullopt;
  Alongside found;
  found.offset = static_cast<double>(best - reach);
  found.correlation = std::sqrt(most);
  found.score = std::log((1 - second) / std::max(1e-6, 1 - most));
  return found;
}

}  // namespace gprodom::gpr
