#include "live/runner.h"

#include <algorithm>
#include <cctype>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "gprodom/error.h"

namespace gprodom {
namespace {

// "X Y YAW SIGMA [MAP]"; whether the figures make sense is for the estimator.
RoughPlace rough_place(const std::string& text) {
  std::istringstream words(text);
  words.imbue(std::locale::classic());
  RoughPlace place;
  const bool four = static_cast<bool>(words >> place.x >> place.y >> place.yaw >> place.sigma_m);
  if (four && !(words >> std::ws).eof() && (!(words >> place.map) || place.map < 0))
    words.setstate(std::ios::failbit | std::ios::badbit);
  if (!four || words.bad() || !(words >> std::ws).eof())
    throw std::invalid_argument("expected X Y YAW SIGMA in m and rad, and the map's number if any");
  return place;
}

}  // namespace

bool is_empty(const Outputs& outputs) {
  return outputs.odometry.empty() && outputs.displacements.empty() && outputs.corrections.empty() &&
         outputs.sfm.empty() && outputs.status.empty() && outputs.warnings.empty();
}

Runner::Runner(const Config& config, Execution execution, gpr::FrontEndFactory front_end)
    : command_channel_(config.channels.command),
      state_directory_(config.state.directory),
      odometry_(config, execution, std::move(front_end)) {}

Outputs Runner::feed(const Input& input) {
  std::visit(
      [this](const auto& message) {
        using Message = std::decay_t<decltype(message)>;
        if constexpr (std::is_same_v<Message, Command>)
          obey(message);
        else if constexpr (std::is_same_v<Message, Rejection>)
          reject(message.channel, message.reason);
        else
          odometry_.add(message);
      },
      input);
  return step();
}

Outputs Runner::step() { return with_notices(odometry_.step()); }

Outputs Runner::finish() { return with_notices(odometry_.finish()); }

void Runner::reject(const std::string& channel, const std::string& reason) {
  odometry_.reject(channel, reason);
}

// A command comes from the network, so it may name a file in state.directory only.
std::string Runner::map_path(const std::string& name) const {
  if (state_directory_.empty())
    throw FileError("state.directory is empty: there is no folder for maps");
  const auto allowed = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
  };
  if (name.empty() || name.size() > 100 || name.front() == '.' ||
      !std::all_of(name.begin(), name.end(), allowed))
    throw FileError("expected a map's name of letters, digits, '_', '-' and '.'");
  return state_directory_ + "/" + name + ".map";
}

void Runner::reset(bool all) {
  if (all) {
    odometry_.forget();
    notices_.emplace_back("reset by command: all is forgotten; starting at the initialiser");
  } else {
    odometry_.reset();
    notices_.emplace_back("reset by command: starting at the initialiser; the ground is kept");
  }
}

void Runner::obey(const Command& command) {
  const auto name = find_choice<CommandName>(command.name);
  if (!name) {
    reject(command_channel_, "unknown command, expected " + all_names<CommandName>(", ", " or "));
    return;
  }
  try {
    switch (*name) {
      case CommandName::kReset:
        if (!command.argument.empty() && command.argument != kResetAll)
          reject(command_channel_, command.name + ": expected no argument, or " + kResetAll);
        else
          reset(!command.argument.empty());
        break;
      case CommandName::kSaveMap:
        odometry_.begin_saving_map(map_path(command.argument));
        break;
      case CommandName::kLoadMap:
        odometry_.load_map(map_path(command.argument));
        notices_.push_back("map " + command.argument + " loaded: its ground is looked for");
        break;
      case CommandName::kLocateAt:
        odometry_.locate_at(rough_place(command.argument));
        break;
    }
  } catch (const FileError& error) {
    reject(command_channel_, command.name + ": " + error.what());
  } catch (const std::invalid_argument& error) {
    reject(command_channel_, command.name + ": " + error.what());
  }
}

// The outputs with what there is to tell.
Outputs Runner::with_notices(Outputs outputs) {
  outputs.warnings.insert(outputs.warnings.begin(), notices_.begin(), notices_.end());
  notices_.clear();
  return outputs;
}

}  // namespace gprodom
