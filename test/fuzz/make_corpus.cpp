// make_corpus FOLDER: sound inputs of every fuzz target but the configuration's, to start from.
#include <filesystem>
#include <fstream>
#include <iostream>
#include <lcm/lcm-cpp.hpp>

#include "gprodom/lcm_io.h"
#include "lcmtypes/gprodom/command_t.hpp"
#include "lcmtypes/gprodom/displacement_t.hpp"
#include "lcmtypes/gprodom/gpr_trace_t.hpp"
#include "lcmtypes/gprodom/imu_t.hpp"
#include "lcmtypes/gprodom/position_fix_t.hpp"
#include "lcmtypes/gprodom/wheel_t.hpp"
#include "lcmtypes/gprodom/wheels_t.hpp"
#include "map/ground_map_file.h"
#include "persist/saved_state.h"
#include "sound_ground.h"

namespace {

namespace fs = std::filesystem;

void write(const fs::path& file, const std::string& bytes) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << bytes;
}

template <typename Message>
std::string encoded(const Message& message) {
  std::string bytes(static_cast<std::size_t>(message.getEncodedSize()), '\0');
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

// In the order of input_channels().
std::vector<std::string> packets() {
  gprodom::gpr_trace_t trace{};
  trace.sample_interval = 2e-10;
  trace.num_samples = 4;
  trace.samples = {1, -2, 3, 0};
  gprodom::displacement_t displacement{};
  displacement.source = "corpus";
  displacement.kind = gprodom::displacement_t::EXTERNAL;
  gprodom::command_t command{};
  command.name = "reset";
  command.argument = "all";
  return {encoded(trace),
          encoded(gprodom::imu_t{}),
          encoded(gprodom::wheel_t{}),
          encoded(gprodom::wheels_t{}),
          encoded(displacement),
          encoded(gprodom::position_fix_t{}),
          encoded(command)};
}

void write_log(const fs::path& file) {
  fs::create_directories(file.parent_path());
  const auto channels = gprodom::input_channels(gprodom::ChannelConfig());
  const auto messages = packets();
  lcm::LogFile log(file.string(), "w");
  for (std::size_t i = 0; i < messages.size(); ++i) {
    std::string data = messages[i];
    lcm::LogEvent event{};
    event.timestamp = static_cast<std::int64_t>(i);
    event.channel = channels[i];
    event.data = data.data();
    event.datalen = static_cast<std::int32_t>(data.size());
    log.writeEvent(&event);
  }
}

// Sound ground as features alone, which is version 1.
gprodom::GroundMap ground_1() {
  const gprodom::GroundMap whole = sound_ground();
  gprodom::GroundMap features{gprodom::gpr::TraceMemoryOptions()};
  features.format = whole.format;
  features.places = whole.places;
  const gprodom::gpr::MemoryRange kept = whole.memory.kept();
  features.memory.restore_run(*whole.memory.filter(), whole.memory.stored_run(kept).times, 0.0, 1,
                              whole.memory.patch(kept));
  return features;
}

// A saved file without what lies between its title and its contents.
std::string contents(const std::string& sealed) {
  return sealed.substr(sealed.find('\n') + 1 + 2 * sizeof(std::uint64_t));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: make_corpus FOLDER\n";
    return 2;
  }
  const fs::path folder = argv[1];
  const auto messages = packets();
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const std::string first(1, static_cast<char>(i));  // chooses the channel
    write(folder / "packets" / ("sound" + std::to_string(i)), first + messages[i]);
  }
  write_log(folder / "log" / "sound");
  write(folder / "state" / "sound", contents(to_bytes(gprodom::SavedState())));
  // The first bits choose what it is.
  const gprodom::GroundMap ground = sound_ground();
  write(folder / "ground" / "sound", '\0' + contents(to_bytes(ground, ground.places)));
  write(folder / "ground" / "sound1", '\1' + contents(to_bytes(ground_1(), ground_1().places)));
  gprodom::GroundMap tied = tied_ground();
  write(folder / "ground" / "tied", '\4' + contents(to_bytes(tied, tied.places)));
  tied.origins[0].antenna_id = 1;
  write(folder / "ground" / "antenna", '\14' + contents(to_bytes(tied, tied.places)));
  for (const bool with_datum : {false, true})
    write(folder / "ground" / (with_datum ? "newest2" : "newest"),
          (with_datum ? '\6' : '\2') +
              contents(sound_newest(with_datum)).substr(sizeof(std::uint64_t)));
}
