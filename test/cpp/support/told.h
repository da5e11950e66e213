// What an estimator has told.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace gprodom {

// How many of the texts have this part.
inline auto count_with(const std::vector<std::string>& texts, const std::string& part) {
  return std::count_if(texts.begin(), texts.end(), [&part](const std::string& text) {
    return text.find(part) != std::string::npos;
  });
}

// Of a Status.
template <class Status>
std::optional<double> value_of(const Status& status, const std::string& name) {
  const auto found = std::find(status.names.begin(), status.names.end(), name);
  if (found == status.names.end()) return std::nullopt;
  return status.values[static_cast<std::size_t>(found - status.names.begin())];
}

}  // namespace gprodom
