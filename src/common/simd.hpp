#pragma once

/// Put before a function with hot, vectorisable loops: it is compiled once for each instruction set
/// and the best that the processor has is chosen when the program starts, so that one binary runs
/// on any x86-64. Elsewhere the compiler's baseline serves (NEON is part of it on 64-bit ARM).
/// Sanitizers start too late for the choice, so they see the baseline.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__gnu_linux__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(MATCHBOX_NO_SIMD)
#define MATCHBOX_SIMD_CLONES __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define MATCHBOX_SIMD_CLONES
#endif
