// Enums, each with the names of its values in the configuration, in messages and wherever people
// read or write them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace gprodom {

enum class WheelDrive { kSingle, kDifferential, kSkidSteer, kAckermann };
enum class WheelForm { kIncrement, kDistance };
enum class FrontEndKind {
  kMotion,
  kStationarity,
  kSfm,
  kBscan,
  kDec,
  kSalient,
  kTraceCount,
  kNone
};
enum class Trigger { kTime, kDistance, kAuto };  // of the radar's traces
enum class Fusion { kSigned, kNorm };
enum class DistanceForm { kCosine, kPrinted };
enum class CoherenceUse { kContradicted, kAlways, kNever };
enum class SolverKind { kCeres, kChain };  // of the fixed-lag window
enum class MapUse { kExtend, kReadOnly };  // of the ground of earlier runs
enum class LogLevel { kDebug, kInfo, kWarning, kError };
enum class CommandName { kReset, kSaveMap, kLoadMap, kLocateAt };  // of command_t

// In the order of the enum. The argument selects the overload; its value is not used.
constexpr std::array<const char*, 4> names_like(WheelDrive) {
  return {"single", "differential", "skid_steer", "ackermann"};
}
constexpr std::array<const char*, 2> names_like(WheelForm) { return {"increment", "distance"}; }
constexpr std::array<const char*, 8> names_like(FrontEndKind) {
  return {"motion", "stationarity", "sfm", "bscan", "dec", "salient", "trace_count", "none"};
}
constexpr std::array<const char*, 3> names_like(Trigger) { return {"time", "distance", "auto"}; }
constexpr std::array<const char*, 2> names_like(Fusion) { return {"signed", "norm"}; }
constexpr std::array<const char*, 2> names_like(DistanceForm) { return {"cosine", "printed"}; }
constexpr std::array<const char*, 3> names_like(CoherenceUse) {
  return {"contradicted", "always", "never"};
}
constexpr std::array<const char*, 2> names_like(SolverKind) { return {"ceres", "chain"}; }
constexpr std::array<const char*, 2> names_like(MapUse) { return {"extend", "read_only"}; }
constexpr std::array<const char*, 4> names_like(LogLevel) {
  return {"debug", "info", "warning", "error"};
}
constexpr std::array<const char*, 4> names_like(CommandName) {
  return {"reset", "save_map", "load_map", "locate_at"};
}

static_assert(names_like(WheelDrive{}).size() == std::size_t(WheelDrive::kAckermann) + 1);
static_assert(names_like(WheelForm{}).size() == std::size_t(WheelForm::kDistance) + 1);
static_assert(names_like(FrontEndKind{}).size() == std::size_t(FrontEndKind::kNone) + 1);
static_assert(names_like(Trigger{}).size() == std::size_t(Trigger::kAuto) + 1);
static_assert(names_like(Fusion{}).size() == std::size_t(Fusion::kNorm) + 1);
static_assert(names_like(DistanceForm{}).size() == std::size_t(DistanceForm::kPrinted) + 1);
static_assert(names_like(CoherenceUse{}).size() == std::size_t(CoherenceUse::kNever) + 1);
static_assert(names_like(SolverKind{}).size() == std::size_t(SolverKind::kChain) + 1);
static_assert(names_like(MapUse{}).size() == std::size_t(MapUse::kReadOnly) + 1);
static_assert(names_like(LogLevel{}).size() == std::size_t(LogLevel::kError) + 1);
static_assert(names_like(CommandName{}).size() == std::size_t(CommandName::kLocateAt) + 1);

template <class Choice>
std::string name_of(Choice choice) {
  return names_like(choice).at(static_cast<std::size_t>(choice));
}

// "stationarity | sfm | none", or with other separators between names and before the last one.
template <class Choice>
std::string all_names(const char* between = " | ", const char* before_last = " | ") {
  constexpr auto names = names_like(Choice{});
  std::string text = names.front();
  for (std::size_t i = 1; i < names.size(); ++i)
    text += std::string(i + 1 < names.size() ? between : before_last) + names[i];
  return text;
}

// Nothing if no value has that name.
template <class Choice>
std::optional<Choice> find_choice(std::string_view name) {
  const auto names = names_like(Choice{});
  for (std::size_t i = 0; i < names.size(); ++i)
    if (name == names[i]) return static_cast<Choice>(i);
  return std::nullopt;
}

}  // namespace gprodom
