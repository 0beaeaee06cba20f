/* SPDX-License-Identifier: MIT */
/* cast_bound.h - what leaving out empty space can give at most (Amdahl's law).
 *
 * A picture without it takes a n + b v: n samples are looked up, and the v of them that show something are shaded as well. To
 * leave out all others, for nothing, leaves (a + b) v. The bench counts n and v, and a and b follow from two pictures of the
 * plain loop whose shares of shown samples differ, a dense and a sparse one. */
#ifndef ISO_BENCH_CAST_BOUND_H
#define ISO_BENCH_CAST_BOUND_H

#include "base/status.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

typedef struct bench_samples {
    size_t looked_up; /* until next to no light is left */
    size_t shown;     /* of these: with an extinction */
} bench_samples;

/* The samples of a view at the middles of its steps. ISO_E_MEMORY. */
iso_status iso_bench_count_samples(const iso_level *level, iso_code code, const iso_view *view, int threads,
                                   bench_samples *out, iso_error *err);

/* How many times faster the sparse picture can be; seconds: of the plain loop. NaN where the times do not tell, as where
 * both transfer functions show the same share. */
double iso_bench_skipping_bound(const bench_samples *dense, double dense_seconds, const bench_samples *sparse,
                                double sparse_seconds);

#endif
