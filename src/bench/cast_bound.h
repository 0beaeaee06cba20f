/* SPDX-License-Identifier: MIT */
/* cast_bound.h - upper bound of the speedup by empty-space skipping (Amdahl's law).
 *
 * The plain loop takes a n + b v: it looks up n samples and also shades the v visible ones. Skipping all others at no
 * cost leaves (a + b) v. The bench counts n and v. It computes a and b from two pictures of the plain loop, dense and
 * sparse, whose shares of visible samples differ. */
#pragma once

#include "base/status.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

typedef struct bench_samples {
    size_t looked_up; /* until almost no light remains */
    size_t shown;     /* those with an extinction */
} bench_samples;

/* Counts the samples of a view at the middles of its steps. Errors: ISO_E_MEMORY. */
iso_status iso_bench_count_samples(const iso_level *level, iso_code code, const iso_view *view, int threads,
                                   bench_samples *out, iso_error *err);

/* Returns how many times faster the sparse picture can be; seconds: of the plain loop. NaN if the times do not
 * determine it, for example if both transfer functions show the same share. */
double iso_bench_skipping_bound(const bench_samples *dense, double dense_seconds, const bench_samples *sparse,
                                double sparse_seconds);
