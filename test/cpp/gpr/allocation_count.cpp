#include "gpr/allocation_count.h"

#include "support/sanitized.h"

#if !GPRODOM_SANITIZED && defined(__GLIBC__)
#define GPRODOM_COUNTS_ALLOCATIONS 1
#else
#define GPRODOM_COUNTS_ALLOCATIONS 0
#endif

namespace {
thread_local std::size_t calls = 0;
}  // namespace

namespace gprodom {
std::size_t allocation_count() { return calls; }
bool counts_allocations() { return GPRODOM_COUNTS_ALLOCATIONS != 0; }
}  // namespace gprodom

#if GPRODOM_COUNTS_ALLOCATIONS
// The C library lets a program replace its allocator; these only count and pass on.
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT: the library's name
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT
void* __libc_realloc(void* memory, std::size_t size);            // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT

void* malloc(std::size_t size) {
  ++calls;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++calls;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  ++calls;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++calls;
  return __libc_memalign(alignment, size);
}
}
#endif
