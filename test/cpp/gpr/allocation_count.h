// Counts allocations of this program, whoever makes them: operator new and Eigen both end in
// malloc.
#pragma once

#include <cstddef>

namespace gprodom {

// Calls of malloc, calloc, realloc and aligned_alloc by this thread so far. With a sanitizer, which
// replaces them itself, it stays 0 (see counts_allocations).
std::size_t allocation_count();

bool counts_allocations();

}  // namespace gprodom
