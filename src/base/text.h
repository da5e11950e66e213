// Texts for people, put together.
#pragma once

#include <array>
#include <string>

#include "gprodom/choices.h"
#include "gprodom/types.h"

namespace gprodom {

constexpr std::array<const char*, 3> names_like(HealthLevel) {
  return {"ok", "degraded", "failed"};
}

// The texts, with the separator between two of them.
template <class Texts>
std::string joined(const Texts& texts, const std::string& separator) {
  std::string all;
  for (const auto& text : texts) all += (all.empty() ? "" : separator) + text;
  return all;
}

// As printf writes it.
__attribute__((format(printf, 1, 2))) std::string formatted(const char* format, ...);

}  // namespace gprodom
