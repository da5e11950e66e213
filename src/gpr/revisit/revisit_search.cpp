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

bool is_possible(const std::optional<bool>& mirrored, int direction) {
  return !mirrored || *mirrored == (direction == 1);
}

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
    Belief belief = update(expect(window, before, survey, asked, moved_m), survey, moved_m);
    for (PlaceFound place : decide(belief, survey, window)) {
      place.window = w;
      if (agrees_backwards(newest, window, place)) found.push_back(place);
    }
    beliefs.push_back(std::move(belief));
  }
  beliefs_ = std::move(beliefs);
  return found;
}

// Bayes' rule. Patches overlap, and each piece of ground counts once: at a place to which the
// belief has moved on, the new part of the patch. Where a pass begins, none of the patch has
// counted.
RevisitSearch::Belief RevisitSearch::update(Prior prior, const PatchSurvey& survey,
                                            double moved_m) const {
  Belief belief = std::move(prior.belief);
  const double fresh = std::min(1.0, moved_m / options_.patch_m);
  const Eigen::ArrayXd expected[2] = {belief.places[0].rowwise().sum(),
                                      belief.places[1].rowwise().sum()};
  Eigen::ArrayXXd log_ratio[2];
  double highest = 0.0;
  for (int d = 0; d < 2; ++d) {
    if (!is_possible(belief.mirrored, d)) continue;
    log_ratio[d] = survey.log_likelihood(d == 1);
    highest = std::max(highest, log_ratio[d].maxCoeff());
  }
  for (int d = 0; d < 2; ++d) {
    if (!is_possible(belief.mirrored, d)) continue;
    belief.places[d] = belief.places[d] * (fresh * log_ratio[d] - highest).exp() +
                       prior.begun[d] * (log_ratio[d] - highest).exp();
  }
  belief.nowhere *= std::exp(-highest);
  const double sum = belief.nowhere + belief.places[0].sum() + belief.places[1].sum();
  for (auto& places : belief.places) places /= sum;
  belief.nowhere /= sum;
  const Peak peak = peak_of(belief);
  // Other places together were likelier before: the evidence for this one begins with this patch.
  if (lobe_share(expected[peak.direction], peak.at) < 0.5) {
    belief.patches = 0;
    belief.clear = false;
  }
  ++belief.patches;
  return belief;
}

// The belief about the run that contains a window, driven in the same direction.
const RevisitSearch::Belief* RevisitSearch::last_belief_on(const SearchWindow& window) const {
  const auto first = static_cast<std::ptrdiff_t>(window.first);
  const Belief* before = nullptr;
  std::ptrdiff_t most = 0;
  for (const Belief& b : beliefs_) {
    if (b.run != window.run || b.mirrored != window.mirrored) continue;
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
  peak.share = lobe_share(places[peak.direction], peak.at);
  return peak;
}

double RevisitSearch::lobe_share(const Eigen::ArrayXd& places, Eigen::Index at) const {
  const auto lobe = static_cast<Eigen::Index>(options_.matcher.lobe_m / matcher_.spacing());
  const auto from = std::max<Eigen::Index>(0, at - lobe);
  const auto to = std::min(places.size(), at + lobe + 1);
  return places.segment(from, to - from).sum();
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
  const double gripping = window.grip > 0.0 ? 0.0 : mean;
  const double low = std::max(-most, std::min(gripping, mean - kWithin * sigma));
  const double high = std::min(most, std::max(gripping, mean + kWithin * sigma));
  Stretches all;
  all.first = static_cast<int>(std::floor(low / step_));
  const int last = static_cast<int>(std::ceil(high / step_));
  const auto weights = [&](double about, double deviation) {
    return normal_weights(all.first, last, about / step_, std::hypot(deviation / step_, 0.5));
  };
  all.share =
      window.grip * weights(gripping, options_.drift) + (1.0 - window.grip) * weights(mean, sigma);
  return all;
}

// Transition probabilities of the stretch from one query to the next, if no slip has begun or
// ended, in steps up and down. The middle entry is "no change".
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
  const double anew = before->nowhere + (1.0 - window.kept) * held.sum();
  share.segment(fresh.first - low, fresh.size()) = anew * fresh.share;
  for (int k = low; k <= high; ++k) {
    for (int i = 0; i < held.size(); ++i) {
      const int by = k - before->first_stretch - i;
      if (std::abs(by) <= reach) share[k - low] += window.kept * held[i] * change[by + reach];
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
RevisitSearch::Prior RevisitSearch::expect(const SearchWindow& window, const Belief* before,
                                           const PatchSurvey& survey, const Stretches& stretches,
                                           double moved_m) const {
  Prior prior;
  Belief& belief = prior.belief;
  belief.run = window.run;
  belief.mirrored = window.mirrored;
  belief.first = static_cast<std::ptrdiff_t>(window.first) + survey.first();
  belief.first_stretch = stretches.first;
  const double share = (1.0 - options_.nowhere) / survey.size();
  for (int d = 0; d < 2; ++d) {
    const double way = !is_possible(window.mirrored, d) ? 0.0 : window.mirrored ? 1.0 : 0.5;
    prior.begun[d] = way * share * stretches.share.transpose().replicate(survey.size(), 1);
    belief.places[d] = Eigen::ArrayXXd::Zero(survey.size(), stretches.size());
  }
  belief.nowhere = options_.nowhere;
  if (before != nullptr) move(*before, window, moved_m, prior);
  return prior;
}

// Prediction step of the filter. Places move by the distance driven times the stretch: forwards if
// driven as then, backwards if mirrored. Belief that leaves the window is dropped, and a small
// share is spread evenly over all places.
void RevisitSearch::move(const Belief& before, const SearchWindow& window, double moved_m,
                         Prior& after) const {
  Belief& belief = after.belief;
  const Eigen::ArrayXd change = stretch_transition(window);
  const Stretches fresh = prior_stretches(window);
  const int reach = static_cast<int>(change.size() / 2);
  const double spacing = matcher_.spacing();
  double kept = 0.0;
  for (int d = 0; d < 2; ++d) {
    after.begun[d] *= options_.lost;
    if (!is_possible(belief.mirrored, d)) continue;
    Eigen::ArrayXXd& places = belief.places[d];
    Eigen::ArrayXd anew = Eigen::ArrayXd::Zero(places.rows());  // with another stretch
    for (Eigen::Index i = 0; i < before.places[d].cols(); ++i) {
      const int stretch = before.first_stretch + static_cast<int>(i);
      const double step = moved_m * std::exp(stretch * step_) / spacing;
      // Stretches lie one step apart, so each stands for an interval of that width.
      const double sigma = std::max(0.7, std::hypot(options_.drift, 0.5 * step_) * step);
      const double shift =
          static_cast<double>(before.first - belief.first) + (d == 0 ? step : -step);
      const Eigen::ArrayXd on = moved_on(before.places[d].col(i), shift, sigma, places.rows());
      for (Eigen::Index k = 0; k < places.cols(); ++k) {
        const int by = belief.first_stretch + static_cast<int>(k) - stretch;
        if (std::abs(by) <= reach) places.col(k) += window.kept * change[by + reach] * on;
      }
      anew += (1.0 - window.kept) * on;
    }
    for (Eigen::Index k = 0; k < places.cols(); ++k) {
      const Eigen::Index i = belief.first_stretch + k - fresh.first;
      if (i >= 0 && i < fresh.size()) places.col(k) += fresh.share[i] * anew;
    }
    kept += places.sum();
    places *= 1.0 - options_.lost;
  }
  belief.nowhere =
      options_.lost * belief.nowhere + (1.0 - options_.lost) * std::max(before.nowhere, 1.0 - kept);
  belief.patches = before.patches;
  belief.clear = before.clear;
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
