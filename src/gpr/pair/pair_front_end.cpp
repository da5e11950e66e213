#include "gpr/pair/pair_front_end.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

namespace gprodom::gpr {

namespace {

constexpr double kSpacing = 0.02;  // m, of the columns that are compared
constexpr double kPatch = 0.4;     // m of ground in a match, and between two that are independent

// Matches in one way of the antennas' distance. Their patches overlap; but every part of the path
// is measured, and the slip is known sooner.
constexpr double kMatchesPerDistance = 3.0;

// The part of the antennas' distance by which the predicted motion may be wrong: while the wheel's
// slip is followed, and before.
constexpr double kReachFollowing = 0.4, kReachLearning = 0.8, kReachMargin_m = 0.02;

// Matches without the transfer from which it is learnt at first.
constexpr int kMatchesToLearn = 6;

// The residual variance must be a tenth smaller than at the second place (as for revisits), and the
// correlation far above that of chance.
constexpr double kLeastScore = 0.1, kLeastCorrelation = 0.4;

// Correlation, without the transfer, of ground that repeats itself: half of the power.
constexpr double kRepeats = 0.7;

// In a row: until places further away are searched, while the transfer is learnt (afterwards, one);
// until the transfer is learnt anew, and that is told (16 m with antennas 0.3 m apart).
constexpr int kMissesToSearch = 3, kMissesToLose = 160;

// Where matches are missed, the predicted speed may be wrong by more than a patch can be stretched:
// a wheel that spins at 2.5 times the speed, or one that skids at a third of it.
constexpr double kScales[] = {0.75, 0.55, 0.4, 1.35, 1.8, 2.4, 3.2};

// Constant speeds that are tried where the path is not believed: neighbours overlap, as each is
// searched within kReachFollowing; m/s, at most a fast walk.
constexpr double kSpeedStep = 1.6, kFastest = 2.0;
constexpr double kDirectionSigmas =
    4.0;  // standard deviations of the speed: it is not of the other sign
bool is_direction_known(const Travel& travel, double sigmas) {
  return std::abs(travel.speed_mps()) > sigmas * travel.speed_sigma_mps();
}
// To confirm the order, which is likely beforehand, while nothing speaks against it. Not to deny
// it, nor against a doubt: without a passage the speed wanders, and is sometimes wrong by so much.
constexpr double kOrderSigmas = 2.0;
constexpr TimeNs kSearchPeriod = 500'000'000;  // ns: a new patch at 0.8 m/s

constexpr TimeNs kWindow = 5'000'000'000;  // ns, of the estimator (smoother.lag)

// ns, for which the window is kept longer where a slow robot's passage begins earlier: 0.05 m/s. It
// has twice as many states then. Longer passages enter by the wheel's slip alone, which hardly
// differs (motion/pair_slip.h).
constexpr TimeNs kLongestWindow = 10'000'000'000;

constexpr double kPathSigma = 0.001;  // m, of the path between two states

// m. Where the trailing antenna passes further beside the place of the leading one, it sees other
// ground: the correlation of real ground is cos(d / 0.11 m) at the distance d across the track
// (bench/lateral.py).
constexpr double kMostAside = 0.1;

}  // namespace

std::optional<TimeNs> PairFrontEnd::begin_of_next(const GprConfig& config, const Travel& travel) {
  const auto row = antenna_row(config);
  if (!row || travel.empty()) return std::nullopt;
  const TimeNs now = travel.points().back().time;
  const Run run(travel, now);
  const double behind = (1 + kReachFollowing) * row->distance_m() + 0.5 * kPatch;
  if (run.length() < kSpacing) return std::nullopt;
  // Not from the standstill on with which the run may begin.
  const TimeNs since = run.time_at(run.newest() - std::min(behind, run.length() - 0.5 * kSpacing));
  return since + kLongestWindow < now ? std::nullopt : std::optional(since);
}

PairFrontEnd::PairFrontEnd(const GprConfig& config, const AntennaRow& row)
    : band_(config.filter), antennas_{{{row.front}, {row.rear}}}, distance_m_(row.distance_m()) {}

void PairFrontEnd::reset() {
  for (Antenna& antenna : antennas_) antenna.columns.clear();
  state_ = PairState::kWaits;
}

void PairFrontEnd::add_trace(const GprTrace& trace, bool by_distance) {
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
    if (!by_distance && antenna.newest > 0 && trace.time - antenna.newest > kMaxGap) reset();
    antenna.newest = trace.time;
    const auto n = static_cast<int>(trace.samples.size());
    if (antenna.check.check(trace.samples.data(), n) == TraceQuality::kGood)
      antenna.columns.add(trace.time, antenna.spectra->of(trace.samples));
  }
}

bool PairFrontEnd::transfer_known() const { return transfer_.learnt() >= kMatchesToLearn; }

// The place of the passage must lie within the search: over the way from one antenna to the other,
// for a slow robot over the time for which the estimator's window tells its path.
bool PairFrontEnd::is_believed(const Travel& travel) const {
  constexpr double kLongest_s = to_seconds(kWindow), kSigmas = 2.0;
  const double speed = std::abs(travel.speed_mps());
  if (!travel.by_wheel() && speed > kFastest) return false;  // accelerations alone have run off
  const double seconds = speed * kLongest_s > distance_m_ ? distance_m_ / speed : kLongest_s;
  return missed_ < (transfer_known() ? 1 : kMissesToSearch) &&
         kSigmas * travel.speed_sigma_mps() * seconds < kReachFollowing * distance_m_;
}

std::vector<Passage> PairFrontEnd::tick(TimeNs tick, const Travel& travel) {
  if (travel.empty() || travel.points().front().time >= tick) {  // no path yet
    reset();
    return {};
  }
  for (Antenna& antenna : antennas_) antenna.columns.collect(travel);
  if (!antennas_[0].spectra || !antennas_[1].spectra ||
      antennas_[0].spectra->size() != antennas_[1].spectra->size())
    return {};
  const Run run(travel, tick);
  const double s = travel.at(tick), moved = std::abs(s - std::exchange(last_s_, s));
  next_s_ -= moved;
  unjudged_m_ += moved;
  if (run.direction() != direction_) next_s_ = 0;
  direction_ = run.direction();
  const double needed = (1 + kReachLearning) * distance_m_ + kPatch + 4 * kSpacing;
  const TimeNs oldest = run.length() > 2 * needed ? run.time_at(run.newest() - 2 * needed) : 0;
  for (Antenna& antenna : antennas_) antenna.columns.forget_before(oldest);
  const bool believed = is_believed(travel);
  const bool due = believed ? next_s_ <= 0 : next_s_ <= 0 || tick >= next_search_;
  if (!due || antennas_[0].columns.empty() || antennas_[1].columns.empty()) return {};
  if (!believed) next_search_ = tick + kSearchPeriod;
  const Match match = compare_in_order(run, travel, tick, believed);
  if (order_.swapped()) {
    refuse_swapped();
    return {};
  }
  if (!match.compared()) {
    if (state_ != PairState::kFollows) state_ = PairState::kWaits;
    if (match.outcome == Outcome::kAside) next_s_ = 0.25 * kPatch;
    return {};
  }
  next_s_ = spacing();
  if (match.outcome == Outcome::kFound)
    return confirmed(tick, accept(match, believed && travel.by_wheel()));
  scatter_.interrupt();
  // Before the transfer is known, unrelated columns are a little alike in many places.
  const bool ambiguous = match.outcome == Outcome::kAmbiguous &&
                         (transfer_known() || match.found.correlation > kRepeats);
  state_ = !transfer_known() ? PairState::kLearns
           : ambiguous       ? PairState::kAmbiguous
                             : PairState::kFollows;
  if (!ambiguous) ++missed_;
  if (missed_ == kMissesToLose) transfer_.clear();
  if (missed_ >= kMissesToLose) state_ = PairState::kNoMatch;
  return {};
}

// Until the order of the antennas is confirmed, and wherever places away from the path are
// searched, the same ground is also looked for as the antennas would see it in the opposite order:
// along as many paths, as long as that decides about the order, since among many some ground is
// always a little alike.
PairFrontEnd::Match PairFrontEnd::compare_in_order(const Run& run, const Travel& travel,
                                                   TimeNs tick, bool believed) {
  Match match = believed ? compare(run) : search(travel, tick);
  const bool direction_known =
      is_direction_known(travel, kOrderSigmas) && run.direction() * travel.speed_mps() > 0;
  if (!direction_known || (believed && transfer_known() && order_.confirmed())) return match;
  // Without a wheel the speed runs off while no passage holds it. So what was found along a known
  // path is not taken back along another.
  if (order_.swapped() && !believed) return match;
  const Match other = believed || order_.confirmed() ? compare(run.mirrored())
                                                     : search(travel, tick, /*swapped=*/true);
  if (!match.compared() || !other.compared()) return match;
  const double here = evidence(match.found.correlation), there = evidence(other.found.correlation);
  if (unjudged_m_ >= kPatch) {
    const bool confirms = here > there && !order_.doubted();
    if (confirms || is_direction_known(travel, kDirectionSigmas)) order_.compared(here, there);
    unjudged_m_ = 0;
  }
  // What is held until the order is confirmed need not be certain of it by itself.
  const double least = order_.confirmed() ? kLeastScore : 0.0;
  if (match.outcome == Outcome::kFound && here < there + least) match.outcome = Outcome::kAmbiguous;
  return match;
}

// With the order confirmed, what was found before counts, too, as far as the estimator's window
// reaches.
std::vector<Passage> PairFrontEnd::confirmed(TimeNs tick, const std::optional<Passage>& newest) {
  const auto is_old = [tick](const Passage& p) { return p.from + kWindow < tick; };
  held_.erase(std::remove_if(held_.begin(), held_.end(), is_old), held_.end());
  // Without a known speed the way between two matches may be too short.
  const auto is_next = [this](const Passage& p) {
    const TimeNs apart = from_seconds(to_seconds(p.to - p.from) / kMatchesPerDistance);
    return held_.empty() || p.to - held_.back().to > apart / 2;
  };
  if (newest && is_next(*newest)) held_.push_back(*newest);
  if (order_.confirmed()) return std::exchange(held_, {});
  state_ = PairState::kLearns;
  return {};
}

// What was found and learnt in the wrong order is of no use.
void PairFrontEnd::refuse_swapped() {
  held_.clear();
  transfer_.clear();
  next_s_ = kPatch;
  missed_ = 0;
  scatter_.interrupt();
  state_ = PairState::kSwapped;
}

// Paths other than the predicted one, too: with its distances scaled; without a wheel also at
// constant speeds up to that at which a trace is too far from the next, and unless the direction is
// certain in both. All of them compete, so that ground that repeats itself gives no answer.
PairFrontEnd::Match PairFrontEnd::search(const Travel& travel, TimeNs tick, bool swapped) const {
  std::vector<Run> runs = {Run(travel, tick)};
  for (const double scale : kScales) runs.emplace_back(travel, tick, scale);
  const double needed = (1 + kReachFollowing) * distance_m_ + kPatch + 4 * kSpacing;
  const double longest_s = to_seconds(Run::kLongestSteady);
  const bool direction_known = is_direction_known(travel, kDirectionSigmas);
  for (double speed = needed / longest_s; speed <= kFastest && !travel.by_wheel();
       speed *= kSpeedStep)
    for (const int direction : {1, -1})
      if (!direction_known || direction * travel.speed_mps() > 0)
        runs.emplace_back(travel, tick, direction * speed, 1.2 * needed / speed);
  Match best;
  std::vector<Match> matches;
  for (const Run& run : runs) {
    matches.push_back(compare(swapped ? run.mirrored() : run));
    const Match& match = matches.back();
    if (match.compared()
            ? !best.compared() || match.found.correlation > best.found.correlation
            : match.outcome == Outcome::kAside && best.outcome == Outcome::kNotCompared)
      best = match;
  }
  for (const Match& match : matches)
    if (match.compared() && match.found.correlation > 0 && !same_place(match, best) &&
        evidence(best.found.correlation) < evidence(match.found.correlation) + kLeastScore &&
        best.outcome == Outcome::kFound)
      best.outcome = Outcome::kAmbiguous;
  return best;
}

// As late as the other one: patches along different paths have their middles at different times.
bool PairFrontEnd::same_place(const Match& a, const Match& b) {
  constexpr double kShare = 0.2;  // of the distance: 4 cm of 0.2 m, the robot's speed may change
  const double late_a = to_seconds(a.to - a.from), late_b = to_seconds(b.to - b.from);
  return a.forwards == b.forwards && std::abs(late_a - late_b) < kShare * std::max(late_a, late_b);
}

// In the coordinate of the run an antenna is at s plus its place on the robot, seen in the
// direction of motion. The trailing one asks.
PairFrontEnd::Match PairFrontEnd::compare(const Run& run) const {
  Match match;
  match.forwards = run.direction() > 0;
  const Antenna &leading = antennas_[match.forwards ? 0 : 1],
                &trailing = antennas_[match.forwards ? 1 : 0];
  const bool wide = !run.steady() && !(transfer_known() && missed_ < kMissesToSearch);
  const double reach_m = (wide ? kReachLearning : kReachFollowing) * distance_m_ + kReachMargin_m;
  const auto reach = static_cast<Eigen::Index>(std::lround(reach_m / kSpacing));
  const auto count = static_cast<Eigen::Index>(std::lround(kPatch / kSpacing)) + 1;
  // In coordinates of the trailing antenna's own path; the leading one was there distance_m_ of the
  // path earlier.
  const double end = trailing.columns.newest(run);
  const double begin = end - kSpacing * static_cast<double>(count - 1);
  const double memory_begin = begin - distance_m_ - kSpacing * static_cast<double>(reach);
  ColumnMatrix memory;
  if (!trailing.columns.sample(run, begin, kSpacing, count, match.query) ||
      !leading.columns.sample(run, memory_begin, kSpacing, count + 2 * reach, memory))
    return match;
  const auto found = transfer_known() ? find(match.query, memory, reach, match.forwards)
                                      : find_by_coherence(match.query, memory, reach);
  const bool alike = found && (!transfer_known() || found->correlation >= kLeastCorrelation);
  match.outcome = !alike                       ? Outcome::kUnlike
                  : found->score < kLeastScore ? Outcome::kAmbiguous
                                               : Outcome::kFound;
  if (!found) return match;
  match.found = *found;
  match.memory = aligned_rows(memory, count, reach, found->offset, found->stretch);
  const double middle = 0.5 * (begin + end);
  match.predicted_m = distance_m_ - found->offset * kSpacing;
  match.scale = distance_m_ / std::max(match.predicted_m, 0.1 * distance_m_);
  match.to = run.time_at(middle);
  match.from = run.time_at(middle - match.predicted_m);
  if (is_aside(run, match, begin, end)) match.outcome = Outcome::kAside;
  return match;
}

// Between two bends, or where the robot turns on the spot. Judged all over the patch: its other end
// is what a robot that has turned round sees in the middle, and after a quarter of a turn its
// middle is where both antennas cross.
bool PairFrontEnd::is_aside(const Run& run, const Match& match, double begin, double end) const {
  const bool forwards = match.forwards != run.is_mirrored();
  const Eigen::Vector3d &leading = antennas_[forwards ? 0 : 1].lever,
                        &trailing = antennas_[forwards ? 1 : 0].lever;
  const auto is_far = [&](double s) {
    const TimeNs from = run.time_at(s - match.predicted_m), to = run.time_at(s);
    return run.apart(from, leading, to, trailing, match.scale) > kMostAside;
  };
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0})
    if (is_far(begin + share * (end - begin))) return true;
  return false;
}

double PairFrontEnd::spacing() const { return distance_m_ / kMatchesPerDistance; }

std::optional<Passage> PairFrontEnd::accept(const Match& match, bool by_wheel) {
  const bool known = transfer_known();
  learn(match.query, match.memory, match.forwards);
  state_ = known ? PairState::kFollows : PairState::kLearns;
  missed_ = 0;
  if (match.from >= match.to) return std::nullopt;
  Passage passage;
  passage.from = match.from;
  passage.to = match.to;
  passage.lever_from = antennas_[match.forwards ? 0 : 1].lever;
  passage.lever_to = antennas_[match.forwards ? 1 : 0].lever;
  passage.score = match.found.score;
  // Before the transfer is known there is no variance of the match: a column.
  double sigma_m = kSpacing;
  if (known) {
    const double variance_m2 = match.found.variance * kSpacing * kSpacing;
    if (by_wheel)
      scatter_.add(match.found.offset * kSpacing, variance_m2);
    else
      scatter_.interrupt();
    sigma_m = std::sqrt(scatter_.excess() * variance_m2);
  }
  passage.sigma_m = std::hypot(sigma_m * match.scale, kPathSigma);
  if (known) passage.overlap = std::max(1.0, kPatch / spacing());
  return passage;
}

std::optional<Alongside> PairFrontEnd::find(ColumnMatrix query, ColumnMatrix memory,
                                            Eigen::Index reach, bool forwards) const {
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

}  // namespace gprodom::gpr
