// Map files, written so that no ground is lost: a file whose ground is not in the new one, or that
// cannot be read, is set aside before it is replaced.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "map/ground_map_file.h"

namespace gprodom {

// One thread at a time.
class GroundFiles {
 public:
  // Writes the ground as write_whole() does. What the file held before goes on as
  // NAME.kept-N.map, unless the ground descends from it; that and the reason are added to `told`.
  // If several were set aside so far, their number and size too.
  // Ground of which nothing is stored replaces no file that holds more, nor one that cannot be
  // read: false, and nothing is done. Throws FileError.
  bool replace(const std::string& path, const SavedGround& ground, std::vector<std::string>& told);

  // Writes newest ground beside the whole file that it belongs to (newest_of()). False, and nothing
  // is done, if that file is not there. Newest ground that cannot be read goes on as
  // NAME.kept-N.new. Throws FileError.
  bool add_newest(const std::string& path, const SavedGround& ground,
                  std::vector<std::string>& told);

  // Gives a file another name at once, for ground that is to be forgotten; one without ground
  // stays. Throws FileError.
  void set_aside(const std::string& path, std::vector<std::string>& told);

  // The head of a map file; nothing if there is no such file. Reads the whole file only if it is
  // not the one that was last read or written here. Throws FileError if it cannot be used.
  std::optional<GroundHead> head(const std::string& path);

 private:
  // What changes when a file is replaced or written: device, inode, size, time.
  using State = std::array<std::int64_t, 5>;
  static State state_of(const std::string& path);
  struct File {
    State state{};
    GroundHead head;
  };
  void keep_damaged_newest(const std::string& path, std::vector<std::string>& told);

  std::map<std::string, File> known_;    // as last read or written here, by path
  std::map<std::string, State> newest_;  // newest ground as written here, by its path
};

}  // namespace gprodom
