#include "gpr/pair/pair_front_end.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gprodom::gpr {

namespace {

// m. Antennas closer together see the same ground at the same time: their footprints overlap.
constexpr double kLeastDistance = 0.1;

constexpr double kSpacing = 0.02;  // m, of the columns that are compared
constexpr double kPatch = 0.4;     // m of ground in a match, and between two: they are independent

// The part of the antennas' distance by which the predicted motion may be wrong: while the wheel's
// slip is followed, and before.
constexpr double kReachFollowing = 0.4, kReachLearning = 0.8, kReachMargin_m = 0.02;

// Matches without the transfer from which it is learnt at first, and their least mean squared
// coherence; that of unrelated columns is one over the number of independent ones in a patch, some
// 0.12.
constexpr int kMatchesToLearn = 6;
constexpr double kLeastCoherence = 0.3;

// The residual variance must be a tenth smaller than at the second place (as for revisits), and the
// correlation far above that of chance.
constexpr double kLeastScore = 0.1, kLeastCorrelation = 0.4;

// In a row: until places further away are searched; until the transfer is learnt anew, and that is
// told (16 m).
constexpr int kMissesToSearch = 3, kMissesToLose = 40;

// Where matches are missed, the predicted speed may be wrong by more than a patch can be stretched:
// a wheel that spins at 2.5 times the speed, or one that is blocked.
constexpr double kScales[] = {0.75, 0.55, 0.4, 1.35};

constexpr double kPathSigma = 0.001;  // m, of the path between two states

// The scatter of the offsets is averaged over so many matches. It begins with that of ground that
// was never seen; a single one counts at most as three standard deviations.
constexpr double kMemory = 30.0, kFirstExcess = 4.0, kMostExcess = 9.0;

void subtract_mean(ColumnMatrix& rows) {
  const Eigen::RowVectorXf mean = rows.colwise().mean();
  rows.rowwise() -= mean;
}

}  // namespace

bool PairFrontEnd::configured(const GprConfig& config) {
  if (!config.enabled || config.antennas.size() < 2) return false;
  const auto by_x = [](const auto& a, const auto& b) { return a.second.x() < b.second.x(); };
  const auto [rear, front] =
      std::minmax_element(config.antennas.begin(), config.antennas.end(), by_x);
  return front->second.x() - rear->second.x() >= kLeastDistance;
}

PairFrontEnd::PairFrontEnd(const GprConfig& config) : band_(config.filter), excess_(kFirstExcess) {
  const auto by_x = [](const auto& a, const auto& b) { return a.second.x() < b.second.x(); };
  const auto [rear, front] =
      std::minmax_element(config.antennas.begin(), config.antennas.end(), by_x);
  antennas_[0].id = front->first;
  antennas_[0].lever = front->second;
  antennas_[1].id = rear->first;
  antennas_[1].lever = rear->second;
  distance_m_ = antennas_[0].lever.x() - antennas_[1].lever.x();
}

void PairFrontEnd::reset() {
  for (Antenna& antenna : antennas_) antenna.columns.clear();
  state_ = PairState::kWaits;
}

void PairFrontEnd::add_trace(const GprTrace& trace) {
  constexpr TimeNs kMaxGap = 1'000'000'000;  // ns
  for (Antenna& antenna : antennas_) {
    if (trace.antenna_id != antenna.id) continue;
    const TraceFormat format = format_of(trace);
    if (!antenna.spectra || !same_format(antenna.format, format)) {
      antenna.format = format;
      antenna.spectra.emplace(format, band_);
      transfer_.clear();
      reset();
    }
    if (antenna.newest > 0 && trace.time - antenna.newest > kMaxGap) reset();
    antenna.newest = trace.time;
    const auto n = static_cast<int>(trace.samples.size());
    if (antenna.check.check(trace.samples.data(), n) == TraceQuality::kGood)
      antenna.columns.add(trace.time, antenna.spectra->of(trace.samples));
  }
}

std::optional<Passage> PairFrontEnd::tick(TimeNs tick, const Travel& travel) {
  if (travel.empty() || travel.points().front().time >= tick) {  // no path yet
    reset();
    return std::nullopt;
  }
  for (Antenna& antenna : antennas_) antenna.columns.collect(travel);
  if (!antennas_[0].spectra || !antennas_[1].spectra ||
      antennas_[0].spectra->size() != antennas_[1].spectra->size())
    return std::nullopt;
  const Run run(travel, tick);
  const double s = travel.at(tick);
  next_s_ -= std::abs(s - std::exchange(last_s_, s));
  if (run.direction() != direction_) next_s_ = 0;
  direction_ = run.direction();
  const double needed = (1 + kReachLearning) * distance_m_ + kPatch + 4 * kSpacing;
  const TimeNs oldest = run.length() > 2 * needed ? run.time_at(run.newest() - 2 * needed) : 0;
  for (Antenna& antenna : antennas_) antenna.columns.forget_before(oldest);
  if (next_s_ > 0 || antennas_[0].columns.empty() || antennas_[1].columns.empty())
    return std::nullopt;
  Passage passage;
  Outcome outcome = match(run, passage);
  if (outcome == Outcome::kRefused && missed_ >= kMissesToSearch)
    for (const double scale : kScales)
      if (outcome != Outcome::kAccepted) outcome = match(Run(travel, tick, scale), passage);
  if (outcome == Outcome::kNotCompared) return std::nullopt;
  next_s_ = kPatch;
  if (outcome == Outcome::kAccepted)
    missed_ = 0;
  else if (state_ != PairState::kAmbiguous)
    ++missed_;
  if (missed_ == kMissesToLose) transfer_.clear();
  if (missed_ >= kMissesToLose) state_ = PairState::kNoMatch;
  if (outcome != Outcome::kAccepted || passage.from >= passage.to) return std::nullopt;
  return passage;
}

// In the coordinate of the run an antenna is at s plus its place on the robot, seen in the
// direction of motion. The trailing one asks.
PairFrontEnd::Outcome PairFrontEnd::match(const Run& run, Passage& passage) {
  const bool forwards = run.direction() > 0;
  const Antenna &leading = antennas_[forwards ? 0 : 1], &trailing = antennas_[forwards ? 1 : 0];
  const bool known = transfer_.learnt() >= kMatchesToLearn;
  const bool follows = known && missed_ < kMissesToSearch;
  const double reach_m =
      (follows ? kReachFollowing : kReachLearning) * distance_m_ + kReachMargin_m;
  const auto reach = static_cast<Eigen::Index>(std::lround(reach_m / kSpacing));
  const auto count = static_cast<Eigen::Index>(std::lround(kPatch / kSpacing)) + 1;
  // In coordinates of the trailing antenna's own path; the leading one was there distance_m_ of the
  // path earlier.
  const double end = trailing.columns.newest(run);
  const double begin = end - kSpacing * static_cast<double>(count - 1);
  const double memory_begin = begin - distance_m_ - kSpacing * static_cast<double>(reach);
  ColumnMatrix query, memory;
  if (!trailing.columns.sample(run, begin, kSpacing, count, query) ||
      !leading.columns.sample(run, memory_begin, kSpacing, count + 2 * reach, memory)) {
    if (state_ != PairState::kFollows) state_ = PairState::kWaits;
    return Outcome::kNotCompared;
  }
  const ColumnMatrix query_seen = query, memory_seen = memory;
  const auto found =
      known ? find(query, memory, reach, forwards) : find_without_transfer(query, memory, reach);
  const bool alike = found && (!known || found->correlation >= kLeastCorrelation);
  if (!alike || found->score < kLeastScore) {
    last_ = {};
    state_ = !known ? PairState::kLearns : alike ? PairState::kAmbiguous : PairState::kFollows;
    return Outcome::kRefused;
  }
  learn(query_seen, aligned_rows(memory_seen, count, reach, found->offset, found->stretch),
        forwards);
  state_ = known ? PairState::kFollows : PairState::kLearns;
  const double offset_m = found->offset * kSpacing, middle = 0.5 * (begin + end);
  // The predicted motion from one passage to the other; the true one is the antennas' distance.
  const double predicted = distance_m_ - offset_m;
  passage.to = run.time_at(middle);
  passage.from = run.time_at(middle - predicted);
  passage.lever_from = leading.lever;
  passage.lever_to = trailing.lever;
  passage.score = found->score;
  const double scale = distance_m_ / std::max(predicted, 0.1 * distance_m_);
  // Before the transfer is known there is no variance of the match: a column.
  double sigma_m = kSpacing;
  if (known) {
    const double noise_m = std::sqrt(found->variance) * kSpacing;
    sigma_m = std::sqrt(follow_excess(offset_m, noise_m)) * noise_m;
  }
  passage.sigma_m = std::hypot(sigma_m * scale, kPathSigma);
  return Outcome::kAccepted;
}

// The predicted motion is smooth over three matches, so what scatters are the matches.
double PairFrontEnd::follow_excess(double offset_m, double sigma_m) {
  last_[0] = last_[1];
  last_[1] = last_[2];
  last_[2] = {offset_m, sigma_m * sigma_m};
  if (last_[0].variance > 0) {
    const double bend = last_[1].offset_m - 0.5 * (last_[0].offset_m + last_[2].offset_m);
    const double expected = last_[1].variance + 0.25 * (last_[0].variance + last_[2].variance);
    excess_ += (std::min(bend * bend / expected, kMostExcess * excess_) - excess_) / kMemory;
  }
  return std::max(1.0, excess_);
}

std::optional<Alongside> PairFrontEnd::find(ColumnMatrix& query, ColumnMatrix& memory,
                                            Eigen::Index reach, bool forwards) {
  subtract_mean(query);
  subtract_mean(memory);
  transfer_.apply(forwards ? query : memory, forwards ? memory : query);
  return find_alongside(query, memory, reach, transfer_.weights(), kSpacing);
}

void PairFrontEnd::learn(const ColumnMatrix& query, const ColumnMatrix& memory, bool forwards) {
  ColumnMatrix q = query, m = memory;
  subtract_mean(q);
  subtract_mean(m);
  transfer_.learn(forwards ? q : m, forwards ? m : q);
}

// By the coherence of each frequency along the track, which a factor between the antennas does not
// change. Whole columns, without a stretch.
std::optional<Alongside> PairFrontEnd::find_without_transfer(const ColumnMatrix& query,
                                                             const ColumnMatrix& memory,
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
