#include "apps/default_config.h"

#include <filesystem>

namespace gprodom {

std::vector<std::string> or_default(std::vector<std::string> paths) {
  namespace fs = std::filesystem;
  if (!paths.empty()) return paths;
  // GPRODOM_BINDIR and GPRODOM_CONFIG: where CMake installs programs and the robot's file.
  std::error_code unknown;
  const fs::path program = fs::read_symlink("/proc/self/exe", unknown);
  const bool installed = fs::equivalent(program.parent_path(), GPRODOM_BINDIR, unknown);
  if (installed && fs::is_regular_file(GPRODOM_CONFIG, unknown)) paths.emplace_back(GPRODOM_CONFIG);
  return paths;
}

}  // namespace gprodom
