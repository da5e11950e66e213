// A ground map; what is accepted is looked up, cut and written again.
#include "map/ground_map_file.h"
#include "sealed.h"

namespace {

void use(const std::string& bytes) {
  const gprodom::GroundMap ground =
      gprodom::ground_map_from("ground", bytes, gprodom::gpr::TraceMemoryOptions());
  ground.at(0.5 * static_cast<double>(ground.memory.kept().end), 1.0);
  gprodom::to_bytes(ground, ground.places);
  const gprodom::gpr::MemoryRange kept = ground.memory.kept();
  if (kept.size() > 2) ground.part({{kept.first + 1, kept.end - 1}});
}

}  // namespace

// The first bit chooses the version, so that both get their share.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string title =
      title_of(to_bytes(gprodom::GroundMap(gprodom::gpr::TraceMemoryOptions()), {}));
  static const std::string title_1 = title.substr(0, title.size() - 1) + "1";
  if (size == 0) return 0;
  return read_sealed((data[0] & 1) == 0 ? title : title_1, data + 1, size - 1, use);
}
