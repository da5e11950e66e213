#include "gpr/revisit/trace_memory.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "base/require.h"

namespace gprodom::gpr {
namespace {

constexpr std::size_t kBlockColumns = ByteColumns::kBlock;
constexpr std::size_t kMostKnown = 50;  // known stretches; only the newest few are still needed

}  // namespace

TraceMemory::TraceMemory(TraceMemoryOptions options) : options_(options) {
  require(options_.spacing_m > 0.0 && options_.learn_m >= 50 * options_.spacing_m &&
              options_.max_length_m >= 10.0,
          "trace memory: expected a spacing above 0, at least 50 columns to learn from and 10 m "
          "kept");
}

void TraceMemory::add(TimeNs time, const std::vector<float>& samples, double sample_interval,
                      double distance_m) {
  const auto n = static_cast<Eigen::Index>(samples.size());
  require((!filter_ || n == filter_->samples()) && (!waiting_ || n == waiting_->values.size()),
          "trace memory: the traces' length has changed; clear() first");
  sample_interval_ = sample_interval;
  Sample sample{time, distance_m, 1, Eigen::Map<const Eigen::RowVectorXf>(samples.data(), n)};
  Eigen::RowVectorXf features = sample.values;
  if (filter_) features = filter_->project(Columns(sample.values)).row(0);
  if (waiting_ && !glitches_.is_glitch(features_before_, waiting_features_, features)) {
    features_before_ = std::move(waiting_features_);
    take(std::move(*waiting_));
  }
  waiting_features_ = std::move(features);
  waiting_ = std::move(sample);
}

void TraceMemory::take(Sample sample) {
  if (last_ && std::abs(sample.distance - last_->distance) > options_.gap_m)
    end_run_before_waiting();
  if (!last_) {
    last_ = std::move(sample);
  } else if (std::abs(sample.distance - last_->distance) < 0.5 * options_.spacing_m) {
    // Traces at one place are averaged: noise falls, and a standstill costs no memory.
    const auto weight = 1.0F / static_cast<float>(std::min(++last_->count, 20));
    last_->values += weight * (sample.values - last_->values);
  } else {
    step_to(std::move(sample));
  }
}

// Goes on from last_, the farthest sample of the run, to `next`. Emits a column at each grid point
// in between.
void TraceMemory::step_to(Sample next) {
  if (direction_ == 0) {
    direction_ = next.distance > last_->distance ? 1 : -1;
    next_ = last_->distance;
  }
  const double ahead = direction_ * (next.distance - last_->distance);
  if (ahead < 0.0) {  // back over ground just seen: ignored, unless it becomes a reversal
    if (-ahead <= options_.reversal_m) return;
    end_run_before_waiting();
    last_ = std::move(next);
    return;
  }
  for (; direction_ * (next.distance - next_) >= 0.0; next_ += direction_ * options_.spacing_m) {
    const double share = std::clamp(direction_ * (next_ - last_->distance) / ahead, 0.0, 1.0);
    const auto late = static_cast<TimeNs>(share * static_cast<double>(next.time - last_->time));
    emit({last_->time + late, next_, direction_},
         last_->values + static_cast<float>(share) * (next.values - last_->values));
  }
  last_ = std::move(next);
}

void TraceMemory::emit(const MemoryColumn& place, const Eigen::RowVectorXf& trace) {
  if (filter_) {
    Pending next{place, filter_->project(Columns(trace)).row(0), {}};
    if (!sessions_.empty()) next.limited = trace * to_limited_.transpose();
    pending_.push_back(std::move(next));
    if (pending_.size() >= settled_ + 2 * context_ + kBlockColumns) keep_settled(false);
    return;
  }
  pending_.push_back({place, trace, {}});
  if (static_cast<double>(pending_.size()) * options_.spacing_m >= options_.learn_m) learn();
}

void TraceMemory::learn() {
  Columns traces(pending_.size(), pending_.front().features.size());
  for (std::size_t i = 0; i < pending_.size(); ++i) traces.row(i) = pending_[i].features;
  try {
    set_filter(PatchFilter(traces, options_.spacing_m, sample_interval_, options_.filter));
  } catch (const std::invalid_argument&) {  // a dead antenna, say: nothing to learn from
    pending_.clear();
    return;
  }
  repair_columns(traces);
  sessions_ = {learn_band_limit(traces, sample_interval_, *filter_)};
  to_limited_ = sessions_.back().projection();
  const Columns features = filter_->project(traces);
  const Columns limited = traces * to_limited_.transpose();
  for (std::size_t i = 0; i < pending_.size(); ++i) {
    pending_[i].features = features.row(i);
    pending_[i].limited = limited.row(i);
  }
}

void TraceMemory::set_filter(const PatchFilter& filter) {
  filter_ = filter;
  // Each of the two Gaussians is three running means with half widths below sigma + 0.5.
  context_ = 3 * static_cast<int>(std::ceil(filter.long_sigma() + filter.short_sigma() + 1.0));
}

void TraceMemory::restore_run(const PatchFilter& filter, const std::vector<TimeNs>& times,
                              double first_distance_m, int direction, const Columns& features) {
  require(features.cols() == filter.rows() && (!filter_ || filter_->rows() == filter.rows()) &&
              features.rows() == static_cast<Eigen::Index>(times.size()),
          "trace memory: columns, times and filter do not agree");
  end_run();
  if (!filter_) set_filter(filter);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double along = static_cast<double>(i) * options_.spacing_m;
    keep({times[i], first_distance_m + direction * along, direction}, features.row(i));
  }
  end_run();
}

Columns TraceMemory::limited_pending() const {
  Columns limited(pending_.size(), to_limited_.rows());
  for (std::size_t i = 0; i < pending_.size(); ++i) limited.row(i) = pending_[i].limited;
  const BandLimit& session = sessions_.back();
  session.high_pass_along(limited);
  limited.array().rowwise() /= session.deviation.array();
  return limited;
}

Columns TraceMemory::filtered_pending() const {
  Columns features(pending_.size(), filter_->rows());
  for (std::size_t i = 0; i < pending_.size(); ++i) features.row(i) = pending_[i].features;
  filter_->band_pass_along(features);
  return features;
}

// Stores the columns whose whole context is there (all: the rest of a run that has ended too).
void TraceMemory::keep_settled(bool all) {
  const std::size_t end = all ? pending_.size() : pending_.size() - context_;
  if (end <= settled_) return;
  const Columns features = filtered_pending();
  const Columns limited = sessions_.empty() ? Columns() : limited_pending();
  for (std::size_t i = settled_; i < end; ++i) {
    if (is_known(pending_[i].place)) {
      end_piece();
      continue;
    }
    if (!sessions_.empty()) limited_.push(limited.row(i), BandLimit::kLevelsPerUnit);
    keep(pending_[i].place, features.row(i));
  }
  const auto history = static_cast<std::size_t>(
      std::max<double>(context_, std::ceil(options_.newest_m / options_.spacing_m)));
  const std::size_t drop = end > history ? end - history : 0;
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(drop));
  settled_ = end - drop;
}

void TraceMemory::mark_known(double one_m, double other_m) {
  const auto [from_m, to_m] = std::minmax(one_m, other_m);
  if (!known_.empty() && from_m <= known_.back().second && to_m >= known_.back().first) {
    known_.back().first = std::min(from_m, known_.back().first);
    known_.back().second = std::max(to_m, known_.back().second);
  } else {
    known_.emplace_back(from_m, to_m);
    if (known_.size() > kMostKnown) known_.erase(known_.begin());  // far behind the antenna
  }
}

bool TraceMemory::is_known(const MemoryColumn& place) const {
  return std::any_of(known_.begin(), known_.end(), [&](const auto& stretch) {
    return place.distance_m >= stretch.first && place.distance_m <= stretch.second;
  });
}

// Ends a piece of the current run. A piece shorter than a patch and its search range is of no use.
void TraceMemory::end_piece() {
  if (!run_kept_) return;
  run_kept_ = false;
  const std::size_t columns = kept().end - runs_.back().first;
  if (static_cast<double>(columns) * options_.spacing_m >= options_.least_m) return;
  runs_.pop_back();
  times_.erase(times_.end() - static_cast<std::ptrdiff_t>(columns), times_.end());
  features_.pop_newest(columns);
  if (!sessions_.empty()) limited_.pop_newest(columns);
}

// The column's band-limited one, if there is any, is stored before.
void TraceMemory::keep(const MemoryColumn& place, const Eigen::RowVectorXf& features) {
  if (std::exchange(begins_session_, false)) {
    session_ = sessions_.size();
    sessions_.push_back(sessions_.back());
  }
  if (!run_kept_) runs_.push_back({kept().end, place.distance_m, place.direction, session_});
  run_kept_ = true;
  times_.push_back(place.time);
  features_.push(features, kLevelsPerUnit);
  if (static_cast<double>(times_.size()) * options_.spacing_m > options_.max_length_m) {
    forget_oldest();
  }
}

void TraceMemory::forget_oldest() {
  features_.forget_block();
  if (!sessions_.empty()) limited_.forget_block();
  times_.erase(times_.begin(), times_.begin() + kBlockColumns);
  first_ += kBlockColumns;
  while (runs_.size() > 1 && runs_[1].first <= first_) runs_.pop_front();
  Run& oldest = runs_.front();
  if (oldest.first < first_) {
    const auto gone = static_cast<double>(first_ - oldest.first);
    oldest.distance += oldest.direction * gone * options_.spacing_m;
    oldest.first = first_;
  }
}

void TraceMemory::end_run() {
  if (waiting_) take(*std::exchange(waiting_, std::nullopt));
  end_run_before_waiting();
}

void TraceMemory::end_run_before_waiting() {
  if (filter_) keep_settled(true);
  if (!known_.empty()) end_piece();
  known_.clear();
  pending_.clear();
  settled_ = 0;
  run_kept_ = false;
  direction_ = 0;
  last_.reset();
}

std::size_t TraceMemory::bytes() const {
  std::size_t sum = times_.size() * sizeof(TimeNs) + runs_.size() * sizeof(Run);
  return sum + features_.bytes() + limited_.bytes();
}

// Of a kept column.
std::deque<TraceMemory::Run>::const_iterator TraceMemory::run_at(std::size_t number) const {
  if (number < kept().first || number >= kept().end) {
    throw std::out_of_range("trace memory: the column is not kept");
  }
  return std::prev(std::upper_bound(runs_.begin(), runs_.end(), number,
                                    [](std::size_t n, const Run& run) { return n < run.first; }));
}

MemoryRange TraceMemory::run_of(std::size_t number) const {
  const auto run = run_at(number), next = std::next(run);
  return {run->first, next == runs_.end() ? kept().end : next->first};
}

MemoryColumn TraceMemory::column(std::size_t number) const {
  const Run& run = *run_at(number);
  const double along = static_cast<double>(number - run.first) * options_.spacing_m;
  return {times_[number - first_], run.distance + run.direction * along, run.direction};
}

Columns TraceMemory::patch(MemoryRange range) const {
  if (range.first < kept().first || range.end < range.first || range.end > kept().end) {
    throw std::out_of_range("trace memory: not all of the range is kept");
  }
  return features_.values(range.first - first_, range.size(), kLevelsPerUnit);
}

std::optional<std::size_t> TraceMemory::column_at(TimeNs time, std::size_t first) const {
  const std::size_t skipped = std::clamp(first, first_, kept().end) - first_;
  const auto begin = times_.begin() + static_cast<std::ptrdiff_t>(skipped);
  const auto after = std::upper_bound(begin, times_.end(), time);
  if (after == begin) return std::nullopt;
  return first_ + static_cast<std::size_t>(after - times_.begin()) - 1;
}

std::optional<MemoryColumn> TraceMemory::newest_place(int count) const {
  if (!filter_ || count < 1 || pending_.size() < static_cast<std::size_t>(count)) {
    return std::nullopt;
  }
  MemoryColumn place =
      pending_[pending_.size() - 1 - count / 2].place;  // half a column early if even
  place.distance_m += place.direction * 0.5 * (1 - count % 2) * options_.spacing_m;
  return place;
}

std::optional<TraceMemory::Newest> TraceMemory::newest(int count, int before,
                                                       const TraceChange& change) const {
  const auto place = newest_place(count);
  if (!place) return std::nullopt;
  const auto pending = static_cast<Eigen::Index>(pending_.size());
  const auto all = std::min<Eigen::Index>(count + before, pending);
  // To undo a change costs by the column.
  const auto used = std::min(all + filter_->smoothing_reach(), pending);
  return Newest{filtered_pending(used, change).bottomRows(all), *place};
}

Columns TraceMemory::filtered_pending(Eigen::Index count, const TraceChange& change) const {
  if (change.none()) return filtered_pending().bottomRows(count);
  Columns columns = limited_pending().bottomRows(count);
  columns.array().rowwise() *= sessions_.back().deviation.array();
  return features_of(columns, sessions_.size() - 1, change);
}

std::size_t TraceMemory::newest_columns(std::size_t first) const {
  const bool stored = run_kept_ || pending_.empty();
  const std::size_t begin = stored && !runs_.empty() ? runs_.back().first : kept().end;
  return kept().end - std::min(kept().end, std::max(begin, first)) +
         (filter_ ? pending_.size() - settled_ : 0);
}

Columns TraceMemory::newest_ground(std::size_t count, const TraceChange& change) const {
  const std::size_t fresh = std::min(count, pending_.size() - settled_);
  const std::size_t end = kept().end, stored = count - fresh;
  if (fresh == 0) return patch({end - stored, end}, change);
  Columns ground(static_cast<Eigen::Index>(count), filter_->rows());
  if (stored > 0) ground.topRows(stored) = patch({end - stored, end}, change);
  const auto pending = static_cast<Eigen::Index>(pending_.size());
  ground.bottomRows(fresh) = filtered_pending(pending, change).bottomRows(fresh);
  return ground;
}

MemoryColumn TraceMemory::newest_column(std::size_t before) const {
  return pending_.empty() ? column(kept().end - 1 - before) : pending_.rbegin()[before].place;
}

}  // namespace gprodom::gpr
