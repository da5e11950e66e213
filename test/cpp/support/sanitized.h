// GPRODOM_SANITIZED: 1 where a sanitizer brings an allocator of its own, which a test must leave
// alone. g++ tells of them by macros, clang by features.
#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define GPRODOM_SANITIZED 1
#elif defined(__has_feature)
#define GPRODOM_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define GPRODOM_SANITIZED 0
#endif
