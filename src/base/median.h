// The middle of values in a row.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace gprodom {

// Of an even number the upper one of the two in the middle. There must be one.
template <typename T>
T median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace gprodom
