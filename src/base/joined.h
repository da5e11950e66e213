// Several texts as one.
#pragma once

#include <string>
#include <vector>

namespace gprodom {

inline std::string joined(const std::vector<std::string>& texts, const std::string& separator) {
  std::string all;
  for (const auto& text : texts) all += (all.empty() ? "" : separator) + text;
  return all;
}

}  // namespace gprodom
