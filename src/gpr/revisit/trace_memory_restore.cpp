// TraceMemory: the ground of map files.
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "base/require.h"
#include "gpr/revisit/trace_memory.h"

namespace gprodom::gpr {
namespace {

// m of a session's ground from which its filter is learnt anew. More would only take longer.
constexpr double kLearnMost = 40.0;

// Columns whose features are made at once: as floats a long run takes many times the memory in
// which it is stored, and what was freed of that among what stays is hardly given back.
constexpr Eigen::Index kBlock = 1000;

// Counts, from levels, of `count` columns.
Columns columns_of(const StoredRun& run, const BandLimit& limit, Eigen::Index first,
                   Eigen::Index count) {
  Columns columns = run.levels.middleRows(first, count).cast<float>() / BandLimit::kLevelsPerUnit;
  columns.array().rowwise() *= limit.deviation.array();
  return columns;
}

// For ground that is too short to learn from: each row gets the same deviation, and no more.
PatchFilter even_rows(const BandLimit& limit, double spacing, const PatchFilterOptions& options) {
  LearntPatchFilter learnt;
  learnt.projection = limit.deviation.cwiseInverse().asDiagonal().toDenseMatrix();
  learnt.row_interval = limit.row_interval();
  learnt.centre = 0.25 / limit.row_interval();
  learnt.long_sigma = limit.long_sigma;
  learnt.short_sigma = options.short_cut * options.wave_speed / learnt.centre / spacing;
  return PatchFilter(std::move(learnt));
}

}  // namespace

void TraceMemory::resume_session(std::size_t session) {
  session_ = session;
  begins_session_ = false;
}

TraceMemory TraceMemory::beside() const {
  constexpr double kKept = 10.0;  // m; a search wants less
  TraceMemoryOptions options = options_;
  options.max_length_m = kKept;
  TraceMemory other(options);
  other.sample_interval_ = sample_interval_;
  other.sessions_ = sessions_;
  other.of_columns_ = of_columns_;
  other.to_limited_ = to_limited_;
  other.session_ = session_;
  other.set_filter(*filter_);
  return other;
}

StoredRun TraceMemory::stored_run(MemoryRange range) const {
  const MemoryColumn first = column(range.first);
  StoredRun stored{run_at(range.first)->session, first.direction, first.distance_m, {}, {}};
  const auto begin = times_.begin() + static_cast<std::ptrdiff_t>(range.first - first_);
  stored.times.assign(begin, begin + static_cast<std::ptrdiff_t>(range.size()));
  stored.levels = limited_.levels(range.first - first_, range.size());
  return stored;
}

// The sessions' columns have the same rows. A session that is too short has no filter of its own.
TraceMemory::SessionFilters TraceMemory::learn_filters(const std::vector<StoredRun>& runs) const {
  std::vector<Columns> ground(sessions_.size());
  const auto most = static_cast<Eigen::Index>(kLearnMost / options_.spacing_m);
  for (const StoredRun& run : runs) {
    Columns& all = ground[run.session];
    const Eigen::Index had = all.rows(), more = std::min(run.levels.rows(), most - had);
    if (more <= 0) continue;
    all.conservativeResize(had + more, run.levels.cols());
    all.bottomRows(more) = columns_of(run, sessions_[run.session], 0, more);
  }
  std::size_t longest = 0;
  for (std::size_t i = 0; i < ground.size(); ++i) {
    if (ground[i].rows() > ground[longest].rows()) longest = i;
  }
  const auto learn = [&](std::size_t session, int row_step) {
    try {
      // Made of what was learnt: checked once more.
      return PatchFilter(learn_from_columns(ground[session], sessions_[session], options_.spacing_m,
                                            options_.filter, row_step)
                             .learnt());
    } catch (const std::invalid_argument&) {  // too short, or nothing changes along it
      return even_rows(sessions_[session], options_.spacing_m, options_.filter);
    }
  };
  const PatchFilter first = learn(longest, 0);
  const int row_step = (first.samples() + first.rows() - 1) / first.rows();
  const auto least = static_cast<Eigen::Index>(options_.learn_m / options_.spacing_m);
  SessionFilters filters{first, {}, sessions_.size()};
  for (std::size_t i = 0; i < ground.size(); ++i) {
    if (i == longest || ground[i].rows() < least) continue;
    PatchFilter own = learn(i, row_step);
    if (own.rows() == first.rows()) filters.own.emplace(i, std::move(own));
  }
  return filters;
}

Columns TraceMemory::patch(MemoryRange range, const TraceChange& change) const {
  if (change.none()) return patch(range);
  const StoredRun stored = stored_run(range);
  const Columns columns = columns_of(stored, sessions_[stored.session], 0, stored.levels.rows());
  return features_of(columns, stored.session, change);
}

Columns TraceMemory::features_of(const Columns& columns, std::size_t session,
                                 const TraceChange& change) const {
  const PatchFilter& filter = of_columns_->of(session);
  Columns features = undoing(change, filter, sessions_[session]).project(columns);
  smooth_along(filter.short_sigma(), features);
  return features;
}

void TraceMemory::restore_columns(const StoredRun& run, const PatchFilter& filter) {
  const Eigen::Index columns = run.levels.rows(), reach = filter.smoothing_reach();
  for (Eigen::Index first = 0; first < columns; first += kBlock) {
    const Eigen::Index end = std::min(columns, first + kBlock);
    const Eigen::Index from = std::max<Eigen::Index>(0, first - reach);
    const Eigen::Index to = std::min(columns, end + reach);
    Columns features = filter.project(columns_of(run, sessions_[run.session], from, to - from));
    smooth_along(filter.short_sigma(), features);
    for (Eigen::Index i = first; i < end; ++i) {
      const double along = static_cast<double>(i) * options_.spacing_m;
      limited_.push(&run.levels(i, 0), static_cast<std::size_t>(run.levels.cols()));
      keep({run.times[static_cast<std::size_t>(i)], run.first_distance_m + run.direction * along,
            run.direction},
           features.row(i - from));
      runs_.back().session = run.session;
    }
  }
  run_kept_ = false;
}

void TraceMemory::restore(std::vector<BandLimit> sessions, const std::vector<StoredRun>& runs) {
  clear();
  require(!sessions.empty(), "it has no session");
  for (const BandLimit& session : sessions) {
    require(session.rows() == sessions.front().rows() && session.step == sessions.front().step &&
                session.deviation.size() == session.rows(),
            "the columns of its sessions differ");
  }
  for (const StoredRun& run : runs) {
    require(run.session < sessions.size() && run.levels.cols() == sessions.front().rows() &&
                run.levels.rows() == static_cast<Eigen::Index>(run.times.size()),
            "columns, times and sessions do not agree");
  }
  sessions_ = std::move(sessions);
  const SessionFilters filters = learn_filters(runs);
  for (const StoredRun& run : runs) restore_columns(run, filters.of(run.session));
  session_ = sessions_.size() - 1;
  of_columns_ = filters;
  to_limited_ = sessions_.back().projection();
  set_filter(for_traces(filters.of(sessions_.size() - 1), sessions_.back()));
}

}  // namespace gprodom::gpr
