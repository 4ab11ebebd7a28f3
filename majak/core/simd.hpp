// SPDX-License-Identifier: Apache-2.0
// A function marked MAJAK_VECTORIZED is compiled twice, for every x86-64 and for AVX2, and the
// right one is chosen when the program starts. Without fused multiply-adds both give the same
// bytes.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define MAJAK_VECTORIZED __attribute__((target_clones("avx2", "default")))
#else
#define MAJAK_VECTORIZED
#endif
