// Adds a multiple of one vector to another, the inner loop of projections and of filters. Runs with
// the processor's widest registers and gives the same numbers on every machine.
#pragma once

#include <cstddef>

namespace gprodom::gpr {

// to[i] += factor * of[i] for i < n. The two do not overlap.
void add_multiple(float factor, const float* of, std::ptrdiff_t n, float* to);

}  // namespace gprodom::gpr
