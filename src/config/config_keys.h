// The one table that binds each YAML key to its field in Config, with unit, range and meaning.
// Reading, checking, comparing and describing a configuration all walk over this table.
//
// To add a key: add the field, with its default, to include/gprodom/config.h; add one line to
// config_keys.cpp, beside its neighbours (sections may nest: "gpr.sfm.rows"); then write
// config/gprodom.yaml anew: `gprodomd --print-config > config/gprodom.yaml`. A new type of field
// needs a case in FieldPointer below and in config_value.cpp.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "gprodom/config.h"

namespace gprodom {

// Range of a number, or of each component of a vector. Bounds are inclusive, except with
// `above_minimum`. Infinity and NaN are never allowed.
struct Range {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  bool above_minimum = false;
  const char* why = "";  // reason for the bound, unless the description says it
};

// For strings: text of at most this length.
struct Text {
  std::size_t max_length = 0;
  bool may_be_empty = false;
};

using Allowed = std::variant<Range, Text>;
// gprodom/choices.h has the enums and the names of their values.
using FieldPointer =
    std::variant<bool*, int*, double*, std::string*, Eigen::Vector3d*,
                 std::optional<Eigen::Vector3d>*, MountingAngles*, Antennas*, AntennaOffsets*,
                 WheelDrive*, WheelForm*, FrontEndKind*, Fusion*, DistanceForm*, Trigger*,
                 CoherenceUse*, SolverKind*, MapUse*, LogLevel*>;

struct ConfigKey {
  std::string name;  // "wheel.scale"
  FieldPointer field;
  std::string unit;  // empty if it has none
  Allowed allowed;
  std::string description;
};

// The table, bound to `config`: its fields are read and written through it.
std::vector<ConfigKey> config_keys(Config& config);

// Heading of a section in config/gprodom.yaml; may be empty.
std::string section_description(const std::string& section);

}  // namespace gprodom
