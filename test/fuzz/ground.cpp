// A ground map, alone or with what was added to it since; what is accepted is looked up, cut and
// written again.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <vector>

#include "map/ground_map_file.h"
#include "sealed.h"
#include "sound_ground.h"

namespace {

namespace fs = std::filesystem;

void use(const gprodom::GroundMap& ground) {
  ground.at(0.5 * static_cast<double>(ground.memory.kept().end), 1.0);
  gprodom::to_bytes(ground, ground.places);
  const gprodom::gpr::MemoryRange kept = ground.memory.kept();
  if (kept.size() > 2) ground.part({{kept.first + 1, kept.end - 1}});
}

void use_alone(const std::string& bytes) {
  use(gprodom::ground_map_from("ground", bytes, gprodom::gpr::TraceMemoryOptions()));
}

// A sound ground map in a folder of this process, beside which newest ground is put.
class SoundFile {
 public:
  SoundFile() {
    fs::create_directories(folder_);
    const gprodom::GroundMap ground = sound_ground();
    const std::string bytes = to_bytes(ground, ground.places);
    identity = gprodom::ground_head("ground", bytes).identity;
    std::ofstream(folder_ / "ground.map", std::ios::binary) << bytes;
  }
  SoundFile(const SoundFile&) = delete;
  SoundFile& operator=(const SoundFile&) = delete;
  ~SoundFile() { fs::remove_all(folder_); }

  void use_with(const std::string& newest) const {
    const std::string path = (folder_ / "ground.map").string();
    std::ofstream(gprodom::newest_of(path), std::ios::binary) << newest;
    std::vector<std::string> notices;
    const auto ground = gprodom::read_ground_map(path, gprodom::gpr::TraceMemoryOptions(), notices);
    if (!ground) std::abort();  // what is beside it does not take a sound file away
    use(*ground);
  }

  std::uint64_t identity = 0;

 private:
  const fs::path folder_ = fs::temp_directory_path() / ("gprodom-fuzz-" + std::to_string(getpid()));
};

// Of what was added to that file.
int read_newest(bool tied, const std::uint8_t* data, std::size_t size) {
  static const SoundFile file;
  static const std::string titles[] = {title_of(sound_newest()), title_of(sound_newest(true))};
  const auto* identity = reinterpret_cast<const std::uint8_t*>(&file.identity);
  std::vector<std::uint8_t> bytes(identity, identity + sizeof file.identity);
  bytes.insert(bytes.end(), data, data + size);
  return read_sealed(titles[tied ? 1 : 0], bytes.data(), bytes.size(),
                     [](const std::string& newest) { file.use_with(newest); });
}

}  // namespace

// The first bits choose what it is, so that each reader gets its share.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string title =
      title_of(to_bytes(gprodom::GroundMap(gprodom::gpr::TraceMemoryOptions()), {}));
  static const std::string kind = title.substr(0, title.size() - 1);
  if (size == 0) return 0;
  if ((data[0] & 2) != 0) return read_newest((data[0] & 4) != 0, data + 1, size - 1);
  const std::string with_datum = (data[0] & 8) != 0 ? "6" : "5";
  const std::string version = (data[0] & 4) != 0 ? with_datum : (data[0] & 1) != 0 ? "1" : "4";
  return read_sealed(kind + version, data + 1, size - 1, use_alone);
}
