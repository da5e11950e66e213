// Features of the processor, chosen at run time.
#pragma once

// Before a function: it is compiled for AVX2 as well, and the machine's version is the one that
// runs. Without fused multiply-add, and with its sums in the order that is written down, it gives
// the same numbers on every machine. For functions of a file's unnamed namespace only: GCC 12
// exports others from the library whatever their visibility.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#define GPRODOM_ALSO_FOR_AVX2 __attribute__((target_clones("avx2", "default")))
#else
#define GPRODOM_ALSO_FOR_AVX2
#endif
