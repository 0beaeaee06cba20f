/* SPDX-License-Identifier: MIT */
/* simd.h - kernels compiled for several instruction sets, chosen when the program starts.
 *
 *     ISO_SIMD void kernel(const float *restrict in, size_t n, float *restrict out) ...
 *
 * Kernels are plain C loops, which the compiler vectorizes. Products and sums are never
 * fused (-ffp-contract=off), so that all instruction sets give the same bits. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    defined(__OPTIMIZE__)
#ifdef ISO_WITHOUT_AVX512 /* make config=avx2: the path of a machine without it */
#define ISO_SIMD __attribute__((target_clones("avx2", "default")))
#else
#define ISO_SIMD __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#endif
#else
#define ISO_SIMD
#endif

/* A variant of a function for one instruction set of x86-64, `ISO_FOR("avx2") static void f_avx2(...)`, is called if
 * ISO_HAS("avx2"). Other processors have the baseline alone. */
#ifdef __x86_64__
#define ISO_FOR(SET) __attribute__((target(SET)))
#define ISO_HAS(SET) __builtin_cpu_supports(SET)
#else
#define ISO_FOR(SET)
#define ISO_HAS(SET) false
#endif

/* Copies bytes past the caches, for results that are not read again soon. */
void iso_copy_streaming(void *restrict to, const void *restrict from, size_t bytes);
