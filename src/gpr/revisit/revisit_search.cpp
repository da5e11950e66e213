#include "gpr/revisit/revisit_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gprodom::gpr {
namespace {

// Stretches in the tails of the distribution are not compared: probability of each tail.
constexpr double kUnlikely = 1e-3;
// Without a belief from before, stretches within so many standard deviations are compared.
constexpr double kWithin = 2.0;

Eigen::ArrayXd normal_weights(int first, int last, double mean, double sigma) {
  const Eigen::ArrayXd at = Eigen::ArrayXd::LinSpaced(last - first + 1, first, last);
  const Eigen::ArrayXd weights = (-0.5 * ((at - mean) / sigma).square()).exp();
  return weights / weights.sum();
}

// `values` shifted by `shift` entries and blurred, cut to entries 0 to size - 1.
Eigen::ArrayXd moved_on(const Eigen::ArrayXd& values, double shift, double sigma,
                        Eigen::Index size) {
  const auto whole = static_cast<Eigen::Index>(std::lround(shift));
  const int reach = static_cast<int>(std::ceil(3.0 * sigma)) + 1;
  const Eigen::ArrayXd kernel =
      normal_weights(-reach, reach, shift - static_cast<double>(whole), sigma);
  Eigen::ArrayXd moved = Eigen::ArrayXd::Zero(size);
  for (int k = -reach; k <= reach; ++k) {
    const Eigen::Index to = whole + k;
    const auto begin = std::max<Eigen::Index>(0, -to), end = std::min(values.size(), size - to);
    if (begin >= end) continue;
    moved.segment(begin + to, end - begin) +=
        kernel[k + reach] * values.segment(begin, end - begin);
  }
  return moved;
}

}  // namespace

// The step between stretches. At the nearest stretch, the ends of a patch are wrong by no more than
// the filter's smoothing along the track, or than one column.
RevisitSearch::RevisitSearch(const PatchFilter& filter, double spacing,
                             RevisitSearchOptions options)
    : options_(std::move(options)),
      matcher_(filter, spacing, options_.matcher),
      patch_columns_(static_cast<int>(std::lround(options_.patch_m / spacing))),
      step_(4.0 * std::max(1.0, filter.short_sigma()) / patch_columns_) {}

double RevisitSearch::reach_m() const {
  const double longest = 1.1 * std::exp(options_.max_stretch);
  return options_.matcher.surround_m + 0.5 * longest * options_.patch_m;
}

std::vector<PlaceFound> RevisitSearch::find(const Columns& newest, double moved_m,
                                            const std::vector<SearchWindow>& windows) {
  const Columns query = newest.bottomRows(patch_columns_);
  std::vector<PlaceFound> found;
  std::vector<Belief> beliefs;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const SearchWindow& window = windows[w];
    const Belief* before = last_belief_on(window);
    const Stretches asked = stretches(window, before);
    PatchSurvey survey = survey_of(query, window, before, asked, moved_m);
    if (survey.empty()) continue;
    Belief belief = expect(window, before, survey, asked, moved_m);
    // Patches overlap, and each piece of ground counts once.
    const double fresh = belief.patches == 0 ? 1.0 : std::min(1.0, moved_m / options_.patch_m);
    const Eigen::ArrayXXd log_ratio[2] = {fresh * survey.log_likelihood(false),
                                          fresh * survey.log_likelihood(true)};
    const double highest = std::max({0.0, log_ratio[0].maxCoeff(), log_ratio[1].maxCoeff()});
    for (int d = 0; d < 2; ++d) belief.places[d] *= (log_ratio[d] - highest).exp();
    belief.nowhere *= std::exp(-highest);
    const double sum = belief.nowhere + belief.places[0].sum() + belief.places[1].sum();
    for (auto& places : belief.places) places /= sum;
    belief.nowhere /= sum;
    ++belief.patches;
    for (PlaceFound place : decide(belief, survey, window)) {
      place.window = w;
      if (agrees_backwards(newest, window, place)) found.push_back(place);
    }
    beliefs.push_back(std::move(belief));
  }
  beliefs_ = std::move(beliefs);
  return found;
}

// The belief about the run that contains a window.
const RevisitSearch::Belief* RevisitSearch::last_belief_on(const SearchWindow& window) const {
  const auto first = static_cast<std::ptrdiff_t>(window.first);
  const Belief* before = nullptr;
  std::ptrdiff_t most = 0;
  for (const Belief& b : beliefs_) {
    if (b.run != window.run) continue;
    const std::ptrdiff_t overlap =
        std::min<std::ptrdiff_t>(first + window.features.rows(), b.first + b.places[0].rows()) -
        std::max(first, b.first);
    if (overlap > most) {
      most = overlap;
      before = &b;
    }
  }
  return before;
}

RevisitSearch::Peak RevisitSearch::peak_of(const Belief& belief) const {
  Peak peak;
  Eigen::Index at[2];
  const Eigen::ArrayXd places[2] = {belief.places[0].rowwise().sum(),
                                    belief.places[1].rowwise().sum()};
  const double highest[2] = {places[0].maxCoeff(&at[0]), places[1].maxCoeff(&at[1])};
  peak.direction = highest[1] > highest[0] ? 1 : 0;
  peak.at = at[peak.direction];
  const auto lobe = static_cast<Eigen::Index>(options_.matcher.lobe_m / matcher_.spacing());
  const auto from = std::max<Eigen::Index>(0, peak.at - lobe);
  const auto to = std::min(places[peak.direction].size(), peak.at + lobe + 1);
  peak.share = places[peak.direction].segment(from, to - from).sum();
  return peak;
}

// The place of the query if the belief of before is certain: it has moved along.
std::optional<RevisitSearch::Held> RevisitSearch::held_place(const Belief* before,
                                                             double moved_m) const {
  if (before == nullptr || before->patches < options_.min_patches) return std::nullopt;
  const Peak peak = peak_of(*before);
  if (peak.share < options_.certainty) return std::nullopt;
  const auto& places = before->places[peak.direction];
  Eigen::Index stretch = 0;
  places.row(peak.at).maxCoeff(&stretch);
  const double ahead = moved_m / matcher_.spacing() *
                       std::exp((before->first_stretch + static_cast<int>(stretch)) * step_);
  const bool mirrored = peak.direction == 1;
  return Held{static_cast<double>(before->first + peak.at) + (mirrored ? -ahead : ahead), mirrored};
}

// Compares the ground beside a certain place alone if the query clearly lies there; else the whole
// window.
PatchSurvey RevisitSearch::survey_of(const Columns& query, const SearchWindow& window,
                                     const Belief* before, const Stretches& asked, double moved_m) {
  SurveyRange range;
  const auto first = static_cast<double>(window.first);
  range.place = window.expected - first;
  range.bound_m = window.bound_m;
  range.surround_m = options_.matcher.surround_m;
  range.mirrored = window.mirrored;
  range.scales.resize(asked.size());
  for (int i = 0; i < asked.size(); ++i) range.scales[i] = std::exp((asked.first + i) * step_);
  asked.share.maxCoeff(&range.wide);
  const std::optional<Held> held = held_place(before, moved_m);
  if (held && options_.held_m < window.bound_m &&
      std::abs(held->column - window.expected) * matcher_.spacing() < window.bound_m) {
    SurveyRange beside = range;
    beside.place = held->column - first;
    beside.bound_m = options_.held_m;
    PatchSurvey survey = matcher_.survey(window.features, query, beside);
    if (!survey.empty() && survey.around(beside.place, held->mirrored).accepted) return survey;
  }
  return matcher_.survey(window.features, query, range);
}

RevisitSearch::Stretches RevisitSearch::prior_stretches(const SearchWindow& window) const {
  const double most = options_.max_stretch;
  const double mean = std::clamp(window.stretch, -most, most);
  const double sigma = std::hypot(window.stretch_sigma, options_.drift);
  const double low = std::max(-most, mean - kWithin * sigma);
  const double high = std::min(most, mean + kWithin * sigma);
  Stretches all;
  all.first = static_cast<int>(std::floor(low / step_));
  all.share = normal_weights(all.first, static_cast<int>(std::ceil(high / step_)), mean / step_,
                             std::hypot(sigma / step_, 0.5));
  return all;
}

// Transition probabilities of the stretch from one query to the next, in steps up and down. The
// middle entry is "no change".
Eigen::ArrayXd RevisitSearch::stretch_transition(const SearchWindow& window) const {
  const double sigma = std::hypot(window.stretch_change, options_.drift) / step_;
  const int reach = static_cast<int>(std::ceil(kWithin * sigma));
  return normal_weights(-reach, reach, 0.0, sigma);
}

// The stretches to compare. If the place is known the stretch is known too, and only those near it
// are compared.
RevisitSearch::Stretches RevisitSearch::stretches(const SearchWindow& window,
                                                  const Belief* before) const {
  Stretches fresh = prior_stretches(window);
  if (before == nullptr) return fresh;
  const Eigen::ArrayXd held =
      (before->places[0].colwise().sum() + before->places[1].colwise().sum()).transpose();
  const Eigen::ArrayXd change = stretch_transition(window);
  const int reach = static_cast<int>(change.size() / 2);
  const int widest = static_cast<int>(std::ceil(options_.max_stretch / step_));
  const int low = std::max(-widest, std::min(fresh.first, before->first_stretch - reach));
  const int high =
      std::min(widest, std::max(fresh.first + fresh.size(),
                                before->first_stretch + static_cast<int>(held.size()) + reach) -
                           1);
  Eigen::ArrayXd share = Eigen::ArrayXd::Zero(high - low + 1);
  share.segment(fresh.first - low, fresh.size()) = before->nowhere * fresh.share;
  for (int k = low; k <= high; ++k) {
    for (int i = 0; i < held.size(); ++i) {
      const int by = k - before->first_stretch - i;
      if (std::abs(by) <= reach) share[k - low] += held[i] * change[by + reach];
    }
  }
  share /= share.sum();
  Eigen::Index from = 0, end = share.size();
  for (double left = share[from]; left < kUnlikely; left += share[from]) ++from;
  for (double left = share[end - 1]; left < kUnlikely; left += share[end - 1]) --end;
  return {low + static_cast<int>(from), share.segment(from, end - from)};
}

// The prior of a window's places before the new patch is compared: uniform, or the last posterior
// of this ground, moved along.
RevisitSearch::Belief RevisitSearch::expect(const SearchWindow& window, const Belief* before,
                                            const PatchSurvey& survey, const Stretches& stretches,
                                            double moved_m) const {
  Belief belief;
  belief.run = window.run;
  belief.first = static_cast<std::ptrdiff_t>(window.first) + survey.first();
  belief.first_stretch = stretches.first;
  const double share = (1.0 - options_.nowhere) / (2.0 * survey.size());
  for (auto& places : belief.places) {
    places = share * stretches.share.transpose().replicate(survey.size(), 1);
  }
  belief.nowhere = options_.nowhere;
  if (before != nullptr) move(*before, window, moved_m, belief);
  return belief;
}

// Prediction step of the filter. Places move by the distance driven times the stretch: forwards if
// driven as then, backwards if mirrored. Belief that leaves the window is dropped, and a small
// share is spread evenly over all places.
void RevisitSearch::move(const Belief& before, const SearchWindow& window, double moved_m,
                         Belief& after) const {
  const Eigen::ArrayXd change = stretch_transition(window);
  const int reach = static_cast<int>(change.size() / 2);
  const double spacing = matcher_.spacing();
  double kept = 0.0;
  for (int d = 0; d < 2; ++d) {
    Eigen::ArrayXXd moved = Eigen::ArrayXXd::Zero(after.places[d].rows(), after.places[d].cols());
    for (Eigen::Index i = 0; i < before.places[d].cols(); ++i) {
      const int stretch = before.first_stretch + static_cast<int>(i);
      const double step = moved_m * std::exp(stretch * step_) / spacing;
      // Stretches lie one step apart, so each stands for an interval of that width.
      const double sigma = std::max(0.7, std::hypot(options_.drift, 0.5 * step_) * step);
      const double shift =
          static_cast<double>(before.first - after.first) + (d == 0 ? step : -step);
      const Eigen::ArrayXd on =
          moved_on(before.places[d].col(i), shift, sigma, after.places[d].rows());
      for (Eigen::Index k = 0; k < moved.cols(); ++k) {
        const int by = after.first_stretch + static_cast<int>(k) - stretch;
        if (std::abs(by) <= reach) moved.col(k) += change[by + reach] * on;
      }
    }
    after.places[d] = options_.lost * after.places[d] + (1.0 - options_.lost) * moved;
    kept += moved.sum();
  }
  after.nowhere =
      options_.lost * after.nowhere + (1.0 - options_.lost) * std::max(before.nowhere, 1.0 - kept);
  after.patches = before.patches;
  after.clear = before.clear;
}

std::vector<PlaceFound> RevisitSearch::decide(Belief& belief, PatchSurvey& survey,
                                              const SearchWindow& window) const {
  if (belief.patches < options_.min_patches) return {};
  const Peak peak = peak_of(belief);
  PlaceFound place;
  place.certainty = peak.share;
  if (place.certainty < options_.certainty) {
    belief.clear = false;
    return {};
  }
  const auto column = static_cast<double>(belief.first + peak.at);
  if (std::abs(column - window.expected) * matcher_.spacing() > window.bound_m) return {};
  const double in_window = column - static_cast<double>(window.first);
  const bool mirrored = peak.direction == 1;
  matcher_.refine(survey, in_window, mirrored, survey.around(in_window, mirrored).scale);
  place.match = survey.around(in_window, mirrored);
  // The prior alone must not accept a place: the newest patch has to support it by itself.
  if (place.match.half_sigmas < options_.min_half || place.match.score <= 0.0) return {};
  belief.clear = belief.clear || place.match.score >= options_.matcher.min_score;
  if (options_.clear_once && !belief.clear) return {};
  place.match.offset_m += static_cast<double>(window.first) * matcher_.spacing();
  place.column = place.match.offset_m / matcher_.spacing();
  return {place};
}

// Search backwards: the memory's patch at the place found is looked for in the newer ground, and
// must be found at the query's centre.
bool RevisitSearch::agrees_backwards(const Columns& newest, const SearchWindow& window,
                                     const PlaceFound& found) {
  if (options_.agree_m <= 0.0) return true;
  const double scale = found.match.scale;
  const auto columns = std::min<Eigen::Index>(patch_columns_, std::lround(scale * patch_columns_));
  const double half = 0.5 * static_cast<double>(columns - 1);
  const double at = found.column - static_cast<double>(window.first);
  const auto first = static_cast<Eigen::Index>(std::lround(at - half));
  if (first < 0 || first + columns > window.features.rows()) return false;
  const Columns patch = window.features.middleRows(first, columns);
  // The patch is cut at whole columns: the rest of a column by which it begins early or late.
  const double cut = at - static_cast<double>(first) - half;
  SurveyRange range;
  range.place = static_cast<double>(newest.rows()) - 0.5 * (patch_columns_ + 1);
  range.bound_m = options_.matcher.lobe_m;
  // Only the place is needed, not its score, so no surroundings are compared.
  range.surround_m = 2.0 * matcher_.spacing();
  range.scales = options_.matcher.scales;
  range.wide = range.scales.size() / 2;
  for (double& finer : range.scales) finer /= scale;
  const RevisitMatch back = matcher_.survey(newest, patch, range).best();
  const double sign = found.match.mirrored ? -1.0 : 1.0;
  const double apart = back.offset_m / matcher_.spacing() + sign * cut / scale - range.place;
  return back.valid && back.mirrored == found.match.mirrored &&
         std::abs(apart) * matcher_.spacing() <= options_.agree_m;
}

}  // namespace gprodom::gpr
