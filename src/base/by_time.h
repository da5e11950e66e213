// Entries in the order of their times, and values between them.
#pragma once

#include <algorithm>
#include <iterator>
#include <vector>

#include "gprodom/types.h"

namespace gprodom {

template <typename Entries>
auto first_after(Entries& entries, TimeNs time) {
  return std::partition_point(entries.begin(), entries.end(),
                              [time](const auto& entry) { return entry.time <= time; });
}

// How much of the way from one time to another has passed.
inline double share_of_way(TimeNs from, TimeNs to, TimeNs time) {
  return static_cast<double>(time - from) / static_cast<double>(to - from);
}

// Linear between entries and constant beyond the ends.
template <typename Entries, typename Entry>
double interpolated(const Entries& entries, TimeNs time, double Entry::*value) {
  const auto next = first_after(entries, time);
  if (next == entries.begin()) return entries.front().*value;
  const auto& a = *(next - 1);
  if (next == entries.end()) return a.*value;
  return a.*value + share_of_way(a.time, next->time, time) * ((*next).*value - a.*value);
}

// Takes those out that end at a time or before it.
template <typename T>
std::vector<T> take_ended(std::vector<T>& entries, TimeNs time) {
  const auto later = std::stable_partition(entries.begin(), entries.end(),
                                           [time](const T& entry) { return entry.to <= time; });
  std::vector<T> ended(std::make_move_iterator(entries.begin()), std::make_move_iterator(later));
  entries.erase(entries.begin(), later);
  return ended;
}

}  // namespace gprodom
