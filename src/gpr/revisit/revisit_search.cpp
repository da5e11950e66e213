#include "gpr/revisit/revisit_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gprodom::gpr {

RevisitSearch::RevisitSearch(const PatchFilter& filter, double spacing,
                             RevisitSearchOptions options)
    : options_(std::move(options)),
      matcher_(filter, spacing, options_.matcher),
      patch_columns_(static_cast<int>(std::lround(options_.patch_m / spacing))) {}

std::vector<PlaceFound> RevisitSearch::look(const Columns& newest, double moved_m,
                                            const std::vector<SearchWindow>& windows) {
  const Columns query = newest.bottomRows(patch_columns_);
  std::vector<PlaceFound> found;
  std::vector<Belief> beliefs;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const SearchWindow& window = windows[w];
    const PatchSurvey survey =
        matcher_.survey(window.features, query, window.expected - static_cast<double>(window.first),
                        window.bound_m);
    if (survey.empty()) continue;
    const auto first = static_cast<std::ptrdiff_t>(window.first) + survey.first();
    Belief belief = expect(window, first, survey.size(), moved_m);
    // Patches overlap, and ground counts once.
    const double fresh = belief.patches == 0 ? 1.0 : std::min(1.0, moved_m / options_.patch_m);
    const Eigen::ArrayXd said[2] = {fresh * survey.log_likelihood(false),
                                    fresh * survey.log_likelihood(true)};
    const double highest = std::max({0.0, said[0].maxCoeff(), said[1].maxCoeff()});
    for (int d = 0; d < 2; ++d) belief.places[d] *= (said[d] - highest).exp();
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

// What is believed of a window's places before the new patch is compared: all alike, or what was
// believed of the stretch before, moved along.
RevisitSearch::Belief RevisitSearch::expect(const SearchWindow& window, std::ptrdiff_t first,
                                            int size, double moved_m) const {
  Belief belief;
  belief.run = window.run;
  belief.first = first;
  const double share = (1.0 - options_.nowhere) / (2.0 * size);
  for (auto& places : belief.places) places = Eigen::ArrayXd::Constant(size, share);
  belief.nowhere = options_.nowhere;
  const Belief* before = nullptr;
  std::ptrdiff_t most = 0;
  for (const Belief& b : beliefs_) {
    if (b.run != belief.run) continue;
    const std::ptrdiff_t overlap =
        std::min(first + size, b.first + b.places[0].size()) - std::max(first, b.first);
    if (overlap > most) {
      most = overlap;
      before = &b;
    }
  }
  if (before != nullptr) move(*before, moved_m, belief);
  return belief;
}

// Places move forwards where driven as then, backwards where mirrored; by how much is known up to
// `drift`. What leaves the window is no longer believed; a little starts anew everywhere.
void RevisitSearch::move(const Belief& before, double moved_m, Belief& after) const {
  const double spacing = matcher_.spacing();
  const double shift = moved_m / spacing;
  const double sigma = std::max(0.7, options_.drift * moved_m / spacing);
  const int reach = static_cast<int>(std::ceil(3.0 * sigma)) + 1;
  double kept = 0.0;
  for (int d = 0; d < 2; ++d) {
    const double step = d == 0 ? shift : -shift;
    const Eigen::ArrayXd& old = before.places[d];
    Eigen::ArrayXd moved = Eigen::ArrayXd::Zero(after.places[d].size());
    for (Eigen::Index i = 0; i < old.size(); ++i) {
      const double at = static_cast<double>(before.first - after.first + i) + step;
      const auto nearest = static_cast<Eigen::Index>(std::lround(at));
      double sum = 0.0;
      for (auto k = nearest - reach; k <= nearest + reach; ++k) {
        sum += std::exp(-0.5 * std::pow((static_cast<double>(k) - at) / sigma, 2));
      }
      for (auto k = std::max<Eigen::Index>(0, nearest - reach);
           k <= std::min(moved.size() - 1, nearest + reach); ++k) {
        moved[k] +=
            old[i] / sum * std::exp(-0.5 * std::pow((static_cast<double>(k) - at) / sigma, 2));
      }
    }
    after.places[d] = options_.lost * after.places[d] + (1.0 - options_.lost) * moved;
    kept += moved.sum();
  }
  after.nowhere =
      options_.lost * after.nowhere + (1.0 - options_.lost) * std::max(before.nowhere, 1.0 - kept);
  after.patches = before.patches;
}

std::vector<PlaceFound> RevisitSearch::decide(const Belief& belief, const PatchSurvey& survey,
                                              const SearchWindow& window) const {
  if (belief.patches < options_.min_patches) return {};
  Eigen::Index at[2];
  const double highest[2] = {belief.places[0].maxCoeff(&at[0]), belief.places[1].maxCoeff(&at[1])};
  const int d = highest[1] > highest[0] ? 1 : 0;
  const auto lobe = static_cast<Eigen::Index>(options_.matcher.lobe_m / matcher_.spacing());
  const auto from = std::max<Eigen::Index>(0, at[d] - lobe);
  const auto to = std::min(belief.places[d].size(), at[d] + lobe + 1);
  PlaceFound place;
  place.certainty = belief.places[d].segment(from, to - from).sum();
  if (place.certainty < options_.certainty) return {};
  const auto column = static_cast<double>(belief.first + at[d]);
  if (std::abs(column - window.expected) * matcher_.spacing() > window.bound_m) return {};
  place.match = survey.around(column - static_cast<double>(window.first), d == 1);
  // What was believed before must not carry a patch that says nothing of it.
  if (place.match.half_sigmas < options_.min_half || place.match.score <= 0.0) return {};
  place.match.offset_m += static_cast<double>(window.first) * matcher_.spacing();
  place.column = place.match.offset_m / matcher_.spacing();
  return {place};
}

// The memory's patch, looked for in the newer ground, must be found where the query's centre is.
bool RevisitSearch::agrees_backwards(const Columns& newest, const SearchWindow& window,
                                     const PlaceFound& found) {
  if (options_.agree_m <= 0.0) return true;
  const auto first = static_cast<Eigen::Index>(
      std::lround(found.column - static_cast<double>(window.first) - 0.5 * (patch_columns_ - 1)));
  if (first < 0 || first + patch_columns_ > window.features.rows()) return false;
  const Columns patch = window.features.middleRows(first, patch_columns_);
  // What the patch of whole columns was cut too early or late by.
  const double cut =
      found.column - static_cast<double>(window.first + first) - 0.5 * (patch_columns_ - 1);
  const double centre = static_cast<double>(newest.rows()) - 0.5 * (patch_columns_ + 1);
  // Where it lies is asked, not how well: what surrounds it need not be compared.
  const double surround = 2.0 * matcher_.spacing();
  const RevisitMatch back =
      matcher_.survey(newest, patch, centre, options_.matcher.lobe_m, surround).best();
  const double sign = found.match.mirrored ? -1.0 : 1.0;
  return back.valid && back.mirrored == found.match.mirrored &&
         std::abs(back.offset_m / matcher_.spacing() + sign * cut - centre) * matcher_.spacing() <=
             options_.agree_m;
}

}  // namespace gprodom::gpr
