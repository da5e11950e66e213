// gprodom._core.GroundMap: a map file, checked and read, for `gprodom map`.
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/folder_lock.h"
#include "base/text.h"
#include "gprodom/config.h"
#include "gprodom/error.h"
#include "map/ground_files.h"
#include "map/ground_map_file.h"
#include "map/ground_store.h"
#include "map/merge/map_merge.h"
#include "map/path/map_path.h"
#include "python/arrays.h"

namespace py = pybind11;
using namespace py::literals;
using namespace gprodom;

namespace {

py::dict runs(const GroundMap& ground) {
  const std::vector<gpr::MemoryRange> runs = ground.runs();
  const auto begin = [&](const gpr::MemoryRange& run) { return ground.memory.column(run.first); };
  return py::dict(
      "first"_a = column_of<std::int64_t>(runs, [](const auto& run) { return run.first; }),
      "end"_a = column_of<std::int64_t>(runs, [](const auto& run) { return run.end; }),
      "direction"_a = column_of<int>(runs, [&](const auto& run) { return begin(run).direction; }),
      "distance"_a =
          column_of<double>(runs, [&](const auto& run) { return begin(run).distance_m; }));
}

py::dict places(const GroundMap& ground) {
  const std::vector<KnownPlace>& places = ground.places;
  using Place = KnownPlace;
  return py::dict(
      "column"_a = column_of<std::int64_t>(places, [](const Place& p) { return p.column; }),
      "time"_a = column_of<std::int64_t>(
          places, [&](const Place& p) { return ground.memory.column(p.column).time; }),
      "distance"_a = column_of<double>(places, [](const Place& p) { return p.distance_m; }),
      "x"_a = column_of<double>(places, [](const Place& p) { return p.pose.p.x(); }),
      "y"_a = column_of<double>(places, [](const Place& p) { return p.pose.p.y(); }),
      "yaw"_a = column_of<double>(places, [](const Place& p) { return p.pose.yaw; }),
      "map"_a = column_of<int>(places, [](const Place& p) { return p.map; }));
}

// Where each column lies; NaN and -1 where no place is within reach.
py::dict columns(const GroundMap& ground, double reach_m) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<GroundMap::At> at;
  const gpr::MemoryRange kept = ground.memory.kept();
  for (std::size_t i = kept.first; i < kept.end; ++i)
    at.push_back(ground.at(static_cast<double>(i), reach_m)
                     .value_or(GroundMap::At{{{kNone, kNone}, kNone}, -1}));
  using At = GroundMap::At;
  return py::dict("x"_a = column_of<double>(at, [](const At& a) { return a.pose.p.x(); }),
                  "y"_a = column_of<double>(at, [](const At& a) { return a.pose.p.y(); }),
                  "map"_a = column_of<int>(at, [](const At& a) { return a.map; }));
}

py::array_t<std::int64_t> times(const GroundMap& ground) {
  std::vector<std::int64_t> times;
  const gpr::MemoryRange kept = ground.memory.kept();
  for (std::size_t i = kept.first; i < kept.end; ++i) times.push_back(ground.memory.column(i).time);
  return column_of<std::int64_t>(times);
}

std::string hexadecimal(std::uint64_t number) {
  return formatted("%016llx", static_cast<unsigned long long>(number));
}

std::vector<std::string> parents(const GroundMap& ground) {
  std::vector<std::string> all;
  for (const std::uint64_t parent : ground.parents) all.push_back(hexadecimal(parent));
  return all;
}

// Of each session its origin, and the times (ns) of its first and its last column.
py::list sessions(const GroundMap& ground) {
  if (ground.memory.sessions().empty()) return py::list();
  std::vector<std::pair<TimeNs, TimeNs>> times(ground.origins.size(),
                                               {std::numeric_limits<TimeNs>::max(), 0});
  for (const gpr::MemoryRange& run : ground.runs()) {
    auto& [from, to] = times.at(ground.memory.session_of(run.first));
    from = std::min(from, ground.memory.column(run.first).time);
    to = std::max(to, ground.memory.column(run.end - 1).time);
  }
  py::list all;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const SessionOrigin& origin = ground.origins[i];
    all.append(py::dict(
        "from"_a = times[i].first, "to"_a = times[i].second,
        "antenna"_a = std::vector<double>(origin.antenna.begin(), origin.antenna.end()),
        "antenna_id"_a = origin.antenna_id, "program"_a = origin.program, "robot"_a = origin.robot,
        "path_errors"_a =
            std::vector<double>{origin.errors.position, origin.errors.yaw, origin.errors.scale}));
  }
  return all;
}

py::object check_facts(const MapJoin& join) {
  if (!join.check) return py::none();
  return py::dict("off_m"_a = join.check->off_m, "deviations"_a = join.check->deviations,
                  "agrees"_a = join.check->agrees());
}

// Of a map that fixes have tied to site.
py::object datum(const GroundMap& ground, int map) {
  const auto found = ground.datums.find(map);
  if (found == ground.datums.end()) return py::none();
  const MapDatum& datum = found->second;
  py::dict facts("x"_a = datum.pose.p.x(), "y"_a = datum.pose.p.y(), "z"_a = datum.z,
                 "yaw"_a = datum.pose.yaw, "covariance"_a = datum.covariance,
                 "origin"_a = datum.origin, "frame"_a = py::none());
  if (const auto frame = on_earth(datum))
    facts["frame"] = py::make_tuple(frame->origin.x(), frame->origin.y(), frame->origin.z(),
                                    frame->yaw * 180.0 / M_PI);
  return facts;
}

py::dict join_facts(const MapJoin& join) {
  const JoinedTracks joined = join.joined.value_or(JoinedTracks());
  const auto trusted = std::count_if(joined.revisits.begin(), joined.revisits.end(),
                                     [](const Revisited& one) { return one.trusted; });
  const auto& end = joined.end;
  const Eigen::Matrix3d covariance = end.covariance.topLeftCorner<3, 3>();
  const auto& found = joined.places;
  return py::dict(
      "map"_a = join.map, "proven"_a = join.proven, "into"_a = join.into, "revisits"_a = trusted,
      "refused"_a = joined.revisits.size() - trusted, "proven_m"_a = joined.proven_m,
      "stretch"_a = joined.change.stretch, "scale"_a = end.scale,
      "covariance"_a = std::vector<double>(covariance.data(), covariance.data() + 9),
      "by_datum"_a = join.by_datum, "datum"_a = check_facts(join),
      "x"_a = column_of<double>(found, [](const KnownPlace& p) { return p.pose.p.x(); }),
      "y"_a = column_of<double>(found, [](const KnownPlace& p) { return p.pose.p.y(); }),
      "yaw"_a = column_of<double>(found, [](const KnownPlace& p) { return p.pose.yaw; }));
}

py::dict merge(const GroundMap& first, const GroundMap& second) {
  MergedMaps merged = merge_maps(first, second, default_config().graph);
  py::list joins;
  for (const MapJoin& join : merged.joins) joins.append(join_facts(join));
  const double known_m = merged.known_m;
  return py::dict("ground"_a = std::move(merged.ground), "joins"_a = joins, "known_m"_a = known_m);
}

GroundMap part(const GroundMap& ground,
               const std::vector<std::pair<std::size_t, std::size_t>>& ranges) {
  std::vector<gpr::MemoryRange> kept;
  std::size_t last = ground.memory.kept().first;
  for (const auto& [first, end] : ranges) {
    if (first < last || end <= first || end > ground.memory.kept().end)
      throw py::value_error("ranges: expected stored columns, in ascending order");
    kept.push_back({first, last = end});
  }
  return ground.part(kept);
}

// Of the service's folder. What the service itself writes is replaced only while it does not run.
std::vector<std::string> install_map(const std::string& folder, const std::string& name,
                                     const py::bytes& content) {
  FolderLock lock;
  if (name == "ground" || name.rfind("ground-", 0) == 0) lock.take(folder, FolderLock::Use::kAlone);
  SavedGround ground;
  ground.bytes = content;
  const std::string path = folder + "/" + name + ".map";
  ground.descent = ground_head(path, ground.bytes).descent;
  std::vector<std::string> told;
  if (!GroundFiles().replace(path, ground, told))
    throw FileError(path + ": holds ground, and the new file holds none");
  return told;
}

GroundMap read_with_newest(const std::string& path) {
  std::vector<std::string> notices;
  auto ground = read_ground_map(path, memory_options(default_config()), notices);
  if (!ground) throw FileError(path + ": no such file");
  warn(notices);
  return std::move(*ground);
}

}  // namespace

void bind_map(py::module_& module) {
  const double reach_m = 2 * kNodeSpacing;
  module.def("install_map", &install_map, "folder"_a, "name"_a, "content"_a,
             "Writes a map file NAME.map into an estimator's folder. What it held before is kept\n"
             "under another name unless the new ground comes from it; returned is what to say of\n"
             "that. Raises FileError, also for the estimator's own ground while it runs.");
  py::class_<GroundMap>(module, "GroundMap",
                        "A map file: docs/map_format.md. Columns are numbered "
                        "from the first, times in ns.")
      .def(py::init([](const std::string& name, const py::bytes& content) {
             return ground_map_from(name, std::string(content), memory_options(default_config()));
           }),
           "name"_a, "content"_a,
           "name: of the file, for errors. Raises FileError where the bytes are not a whole map.")
      .def_static("read", &read_with_newest, "path"_a,
                  "A file with what its estimator has added since in NAME.new beside it. Raises\n"
                  "FileError.")
      .def("to_bytes",
           [](const GroundMap& ground) { return py::bytes(to_bytes(ground, ground.places)); })
      .def("part", &part, "ranges"_a,
           "The ground of these columns, [first, end), in ascending order; in the same maps.")
      .def("merged", &merge, "other"_a,
           "This map and another file's, its tracks joined where ground that both drove over\n"
           "proves how they lie: ground, known_m (m of the other's ground that was left out),\n"
           "joins (of each map of the other). Where no ground proves it, maps in one site are\n"
           "joined by their datums. Raises ValueError where the files cannot be compared.")
      .def("features_alone", &GroundMap::features_alone,
           "The same ground as version 1 has it: features, which no later filter replaces.")
      .def("datum", &datum, "map"_a,
           "How the frame of a map lies in site: x, y, z (m), yaw (rad), their covariance (4, 4);\n"
           "origin of site (latitude, longitude in deg, height in m; None where it is not known),\n"
           "and by it the frame's own, with the angle from east to its x axis (deg, to the left).\n"
           "None where no fixes have tied it.")
      .def("runs", &runs,
           "Stretches driven one way without a gap: columns [first, end), direction\n"
           "(-1: backwards), distance along the track at the first column, m.")
      .def("places", &places,
           "Poses known: column, time, distance along the track (m), pose of\n"
           "the body (x, y in m, yaw in rad) in the frame of the map `map`.")
      .def("columns", &columns, "reach"_a = reach_m,
           "x, y (m) of the body and number of the map at each column, from places within `reach`\n"
           "m along the track; NaN and -1 where there is none.")
      .def("times", &times, "Of each column.")
      .def(
          "sessions", &sessions,
          "The drives and antennas that the ground comes from: times of the first and last column\n"
          "stored (ns), position of the antenna in body (m), its id (0 before version 6),\n"
          "program, robot (empty where it is not known), and standard deviations of the odometry:\n"
          "m and rad after a metre, and ln of the wheel's scale. None in version 1.")
      .def_property_readonly(
          "version", [](const GroundMap& g) { return g.version; }, "of the file")
      .def_property_readonly(
          "identity", [](const GroundMap& g) { return hexadecimal(g.identity); }, "of the file")
      .def_property_readonly("parents", &parents, "identities of the files it was made from")
      .def_property_readonly(
          "spacing", [](const GroundMap& g) { return g.memory.spacing(); }, "m")
      .def_property_readonly(
          "samples", [](const GroundMap& g) { return g.format.samples; },
          "of a trace; 0: no trace was seen")
      .def_property_readonly(
          "sample_interval", [](const GroundMap& g) { return g.format.sample_interval_s; }, "s")
      .def_property_readonly(
          "rows",
          [](const GroundMap& g) { return g.memory.filter() ? g.memory.filter()->rows() : 0; },
          "features of a column; 0: there is no ground")
      .def_property_readonly(
          "centre_frequency",
          [](const GroundMap& g) {
            return g.memory.filter() ? g.memory.filter()->centre_frequency() : 0.0;
          },
          "Hz, of the received spectrum");
}
