// gprodom._core: patches of ground and their revisits, on numpy arrays.
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <tuple>

#include "base/require.h"
#include "gpr/revisit/global_search.h"
#include "gpr/revisit/patch_filter.h"
#include "gpr/revisit/revisit.h"
#include "gpr/revisit/revisit_search.h"

namespace py = pybind11;
using namespace py::literals;

namespace {

using namespace gprodom::gpr;

RevisitMatch find_patch(const Columns& memory, const Columns& query, double spacing,
                        double sample_interval, double prior, double bound,
                        const RevisitOptions& options, const PatchFilterOptions& filter_options) {
  gprodom::require(memory.cols() == query.cols(),
                   "memory and query must have the same number of samples");
  const PatchFilter filter(memory, spacing, sample_interval, filter_options);
  const double length = static_cast<double>(memory.rows()) * spacing;
  PatchMatcher matcher(filter, spacing, options);
  return matcher.match(filter.apply(memory), filter.apply(query), prior - 0.5 * length, bound);
}

std::tuple<double, bool, double> match_patch(const Columns& memory, const Columns& query,
                                             double spacing, double sample_interval, double prior,
                                             double bound) {
  const RevisitMatch match =
      find_patch(memory, query, spacing, sample_interval, prior, bound, {}, {});
  if (!match.valid) return {prior, false, -1.0};
  const double length = static_cast<double>(memory.rows()) * spacing;
  return {0.5 * length + match.offset_m, match.mirrored, match.score};
}

// One window: the whole memory, around the column expected.
using Found = std::tuple<double, double, RevisitMatch>;

std::optional<Found> look(RevisitSearch& search, const Columns& newest, double moved,
                          const Columns& memory, double expected, double bound,
                          double stretch_sigma, double stretch_change) {
  SearchWindow window;
  window.features = memory;
  window.expected = expected;
  window.bound_m = bound;
  window.stretch_sigma = stretch_sigma;
  window.stretch_change = stretch_change;
  const std::vector<PlaceFound> found = search.find(newest, moved, {window});
  if (found.empty()) return std::nullopt;
  return Found(found[0].column, found[0].certainty, found[0].match);
}

void bind_along_the_track(py::module_& module) {
  py::class_<RevisitSearchOptions>(module, "RevisitSearchOptions", "See gpr/revisit_search.h.")
      .def(py::init<>())
      .def_readwrite("matcher", &RevisitSearchOptions::matcher)
      .def_readwrite("patch_m", &RevisitSearchOptions::patch_m)
      .def_readwrite("nowhere", &RevisitSearchOptions::nowhere)
      .def_readwrite("lost", &RevisitSearchOptions::lost)
      .def_readwrite("drift", &RevisitSearchOptions::drift)
      .def_readwrite("max_stretch", &RevisitSearchOptions::max_stretch)
      .def_readwrite("certainty", &RevisitSearchOptions::certainty)
      .def_readwrite("min_half", &RevisitSearchOptions::min_half)
      .def_readwrite("min_patches", &RevisitSearchOptions::min_patches)
      .def_readwrite("clear_once", &RevisitSearchOptions::clear_once)
      .def_readwrite("agree_m", &RevisitSearchOptions::agree_m);
  py::class_<RevisitSearch>(module, "RevisitSearch",
                            "Bayes filter for revisits along the track; see gpr/revisit_search.h.")
      .def(py::init<const PatchFilter&, double, RevisitSearchOptions>(), "filter"_a, "spacing"_a,
           py::arg_v("options", RevisitSearchOptions{}, "RevisitSearchOptions()"))
      .def_property_readonly("patch_columns", &RevisitSearch::patch_columns)
      .def("look", &look, "newest"_a, "moved"_a, "memory"_a, "expected"_a, "bound"_a,
           "stretch_sigma"_a = 0.0, "stretch_change"_a = 0.0,
           "newest: features (columns, rows) in the order driven, `moved` m after those of the\n"
           "last call. The centre of their last patch is expected within `bound` m of the column\n"
           "`expected` of `memory`. stretch_sigma, stretch_change: standard deviations of the\n"
           "logarithm of the length ratio of memory and query, and of its change since the last\n"
           "call. Returns (column, certainty, RevisitMatch), or None if no place is certain.")
      .def("forget", &RevisitSearch::forget);
}

void bind_anywhere(py::module_& module) {
  py::class_<GlobalMatch>(module, "GlobalMatch", "A place found in the whole memory.")
      .def_readonly("valid", &GlobalMatch::valid, "at least one place was compared")
      .def_readonly("column", &GlobalMatch::column, "of the memory, at the query's centre")
      .def_readonly("mirrored", &GlobalMatch::mirrored, "driven the other way")
      .def_readonly("score", &GlobalMatch::score, "in standard deviations of a random match")
      .def_readonly("margin", &GlobalMatch::margin, "over the second best place")
      .def_readonly("accepted", &GlobalMatch::accepted, "the margin suffices");
  py::class_<GlobalSearchOptions>(module, "GlobalSearchOptions", "See gpr/global_search.h.")
      .def(py::init<>())
      .def_readwrite("thinning", &GlobalSearchOptions::thinning)
      .def_readwrite("rows", &GlobalSearchOptions::rows)
      .def_readwrite("piece_m", &GlobalSearchOptions::piece_m)
      .def_readwrite("slack", &GlobalSearchOptions::slack)
      .def_readwrite("distinct_m", &GlobalSearchOptions::distinct_m)
      .def_readwrite("min_margin", &GlobalSearchOptions::min_margin);
  py::class_<GlobalSearch>(module, "GlobalSearch", "See gpr/global_search.h.")
      .def(py::init<const PatchFilter&, double, GlobalSearchOptions>(), "filter"_a, "spacing"_a,
           py::arg_v("options", GlobalSearchOptions{}, "GlobalSearchOptions()"))
      .def("add_run", &GlobalSearch::add_run, "first"_a, "features"_a)
      .def(
          "find",
          [](const GlobalSearch& s, const Columns& q) {
            return s.find({{q, {}}});
          },
          "query"_a, py::call_guard<py::gil_scoped_release>())
      .def_property_readonly("bytes", &GlobalSearch::bytes);
}

}  // namespace

void bind_gpr_revisit(py::module_& module) {
  py::class_<RevisitMatch>(module, "RevisitMatch", "Place of a patch in the memory.")
      .def_readonly("valid", &RevisitMatch::valid, "the memory covers the query near the prior")
      .def_readonly("offset_m", &RevisitMatch::offset_m,
                    "query centre minus memory centre, along the memory's direction")
      .def_readonly("sigma_m", &RevisitMatch::sigma_m, "standard deviation of offset_m")
      .def_readonly("mirrored", &RevisitMatch::mirrored, "driven the other way")
      .def_readonly("scale", &RevisitMatch::scale, "metres of memory per metre of query")
      .def_readonly("score", &RevisitMatch::score, "evidence over the second best place")
      .def_readonly("correlation", &RevisitMatch::correlation, "at the place")
      .def_readonly("half_sigmas", &RevisitMatch::half_sigmas,
                    "correlation of the weaker half, in standard deviations of a random match")
      .def_readonly("accepted", &RevisitMatch::accepted, "the evidence suffices");

  py::class_<RevisitOptions>(module, "RevisitOptions", "See gpr/revisit.h.")
      .def(py::init<>())
      .def_readwrite("scales", &RevisitOptions::scales)
      .def_readwrite("depth_blocks", &RevisitOptions::depth_blocks)
      .def_readwrite("time_shift", &RevisitOptions::time_shift)
      .def_readwrite("lobe_m", &RevisitOptions::lobe_m)
      .def_readwrite("surround_m", &RevisitOptions::surround_m)
      .def_readwrite("min_score", &RevisitOptions::min_score)
      .def_readwrite("min_half", &RevisitOptions::min_half);

  py::class_<PatchFilterOptions>(module, "PatchFilterOptions", "See gpr/patch_filter.h.")
      .def(py::init<>())
      .def_readwrite("wave_speed", &PatchFilterOptions::wave_speed)
      .def_readwrite("low_cut", &PatchFilterOptions::low_cut)
      .def_readwrite("high_cut", &PatchFilterOptions::high_cut)
      .def_readwrite("spectrum_floor", &PatchFilterOptions::spectrum_floor)
      .def_readwrite("long_cut", &PatchFilterOptions::long_cut)
      .def_readwrite("short_cut", &PatchFilterOptions::short_cut)
      .def_readwrite("max_rows", &PatchFilterOptions::max_rows)
      .def_readwrite("max_long_cut", &PatchFilterOptions::max_long_cut);

  py::class_<PatchFilter>(module, "PatchFilter", "Traces -> features; see gpr/patch_filter.h.")
      .def(py::init<const Columns&, double, double, const PatchFilterOptions&>(), "traces"_a,
           "spacing"_a, "sample_interval"_a,
           py::arg_v("options", PatchFilterOptions{}, "PatchFilterOptions()"))
      .def("apply", &PatchFilter::apply, "traces"_a,
           "Features (columns, rows) of traces (columns, samples).")
      .def_property_readonly("rows", &PatchFilter::rows)
      .def_property_readonly("row_interval", &PatchFilter::row_interval, "s")
      .def_property_readonly("centre_frequency", &PatchFilter::centre_frequency, "Hz");

  py::class_<PatchMatcher>(module, "PatchMatcher", "See gpr/revisit.h.")
      .def(py::init<const PatchFilter&, double, RevisitOptions>(), "filter"_a, "spacing"_a,
           py::arg_v("options", RevisitOptions{}, "RevisitOptions()"))
      .def("match", &PatchMatcher::match, "memory"_a, "query"_a, "expected"_a, "bound"_a,
           py::call_guard<py::gil_scoped_release>(),
           "The RevisitMatch of two sets of features (columns, rows). The query's centre is\n"
           "expected within `bound` m of the place `expected` m from the memory's centre.");

  bind_along_the_track(module);
  bind_anywhere(module);

  module.def(
      "match_patch", &match_patch, "memory"_a, "query"_a, "spacing"_a, "sample_interval"_a,
      "prior"_a, "bound"_a,

      "Place of the query in the memory; both are traces (columns, samples), `spacing` m apart.\n"
      "Returns (position of its centre in m from the memory's start, mirrored, score). The\n"
      "centre is expected within `bound` m of `prior` m.");
  module.def("find_patch", &find_patch, "memory"_a, "query"_a, "spacing"_a, "sample_interval"_a,
             "prior"_a, "bound"_a, py::arg_v("options", RevisitOptions{}, "RevisitOptions()"),
             py::arg_v("filter_options", PatchFilterOptions{}, "PatchFilterOptions()"),
             py::call_guard<py::gil_scoped_release>(),
             "The same with options; returns a RevisitMatch.");
}
