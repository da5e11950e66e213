#include "map/ground_files.h"

#include <sys/stat.h>

#include <cstdio>
#include <filesystem>
#include <utility>

#include "base/atomic_file.h"
#include "gprodom/error.h"

namespace gprodom {
namespace {

namespace fs = std::filesystem;

// How many files were set aside under this name so far, and of which size, if several: for them
// somebody has to care.
std::string others_kept(const fs::path& kept) {
  const std::string name = kept.filename().string();
  const std::string begin = name.substr(0, name.rfind('-') + 1);
  int files = 0;
  std::uintmax_t bytes = 0;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(kept.parent_path(), none)) {
    if (entry.path().filename().string().rfind(begin, 0) != 0) continue;
    ++files;
    bytes += entry.file_size(none);
  }
  if (files < 2) return "";
  return ", one of " + std::to_string(files) + " files of " + std::to_string(bytes / 1'000'000) +
         " MB in all, which nothing but you removes";
}

// With its newest ground. keep_both: as of gprodom::set_aside().
void keep_aside(const std::string& path, const std::string& why, bool keep_both,
                std::vector<std::string>& told) {
  const std::string kept = set_aside(path, keep_both);
  if (kept.empty()) return;
  if (path != newest_of(path)) std::rename(newest_of(path).c_str(), newest_of(kept).c_str());
  told.push_back(why + "; it is kept as " + fs::path(kept).filename().string() + others_kept(kept));
}

}  // namespace

GroundFiles::State GroundFiles::state_of(const std::string& path) {
  struct stat file {};
  if (stat(path.c_str(), &file) != 0) return {};
  return {static_cast<std::int64_t>(file.st_dev), static_cast<std::int64_t>(file.st_ino),
          file.st_size, file.st_mtim.tv_sec, file.st_mtim.tv_nsec};
}

bool GroundFiles::replace(const std::string& path, const SavedGround& ground,
                          std::vector<std::string>& told) {
  GroundHead now = ground_head(path, ground.bytes);
  now.descent = ground.descent;
  std::optional<GroundHead> before;
  std::string why;
  std::error_code none;
  if (fs::is_regular_file(path, none)) {
    try {
      before = head(path);
    } catch (const FileError& error) {
      why = error.what();
    }
  }
  const bool holds_more = !why.empty() || (before && before->has_ground);
  if (!now.has_ground && holds_more) return false;
  if (before && before->identity == now.identity) return true;
  if (before && !descends(now, *before)) why = path + ": the new ground does not come from it";
  if (!why.empty()) keep_aside(path, why, true, told);
  keep_damaged_newest(path, told);
  write_whole(path, ground.bytes);
  std::remove(newest_of(path).c_str());  // it belonged to the file of before
  known_[path] = {state_of(path), std::move(now)};
  return true;
}

void GroundFiles::set_aside(const std::string& path, std::vector<std::string>& told) {
  std::string why = path + ": its ground is forgotten";
  try {
    const auto found = head(path);
    if (!found || !found->has_ground) return;
  } catch (const FileError& error) {
    why = error.what();
  }
  keep_aside(path, why, false, told);
}

void GroundFiles::keep_damaged_newest(const std::string& path, std::vector<std::string>& told) {
  const std::string newest = newest_of(path);
  if (const auto own = newest_.find(newest);
      own != newest_.end() && own->second == state_of(newest))
    return;
  std::string bytes;
  try {
    if (read_whole(newest, bytes)) base_of_newest(newest, bytes);
  } catch (const FileError& error) {
    keep_aside(newest, error.what(), false, told);
  }
}

bool GroundFiles::add_newest(const std::string& path, const SavedGround& ground,
                             std::vector<std::string>& told) {
  try {
    const auto whole = head(path);
    if (!whole || whole->identity != ground.base) return false;
  } catch (const FileError&) {  // not the file that it belongs to
    return false;
  }
  keep_damaged_newest(path, told);
  const std::string newest = newest_of(path);
  write_whole(newest, ground.bytes);
  newest_[newest] = state_of(newest);
  return true;
}

std::optional<GroundHead> GroundFiles::head(const std::string& path) {
  const auto known = known_.find(path);
  const State state = state_of(path);
  if (known != known_.end() && known->second.state == state) return known->second.head;
  std::string bytes;
  if (!read_whole(path, bytes)) return std::nullopt;
  GroundHead found = ground_head(path, bytes);
  known_[path] = {state, found};
  return found;
}

}  // namespace gprodom
