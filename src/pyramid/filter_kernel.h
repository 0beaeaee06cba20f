/* filter_kernel.h - the filters between two levels. Cannot fail, allocate or know of threads.
 *
 * A direction's *state* is 4 floats a voxel, carried from level to level:
 *   moments  (N, S)     N = mean of m^2 d = m g, S = mean of m^2
 *   eq1      (m G, m)   G the filtered gradient of the level, m its length
 *   naive    (G, 0)     G the mean gradient */
#ifndef ISO_PYRAMID_FILTER_KERNEL_H
#define ISO_PYRAMID_FILTER_KERNEL_H

#include <stddef.h>

#include "pyramid/pyramid.h"

enum { ISO_FILTER_MAX_TAPS = 32 };

/* The weights of the 2 radius fine voxels around a coarse voxel's centre,
 * which lies between two of them; their sum is 1. */
typedef struct iso_taps {
    size_t count;
    float weight[ISO_FILTER_MAX_TAPS];
} iso_taps;
iso_taps iso_taps_mean(void);
iso_taps iso_taps_gauss(size_t radius, double sigma);

/* The fine voxel of tap t of coarse voxel i; the edge continues. */
static inline size_t iso_taps_source(const iso_taps *taps, size_t i, size_t t, size_t fine_size)
{
    size_t at = 2 * i + t + 1; /* shifted by the radius, to stay unsigned */
    at = at > taps->count / 2 ? at - taps->count / 2 : 0;
    return at < fine_size ? at : fine_size - 1;
}

/* Gradients of level 0 to states. */
void iso_state_from_gradients(iso_direction_filter f, const float *restrict g, size_t count, float *restrict state);
/* After the states were averaged: what the next level starts from. */
void iso_state_finish(iso_direction_filter f, float *state, size_t count);
/* The directions to store, and the gradient magnitudes (NULL: not wanted). fine: of level 0, hence unit. */
void iso_state_directions(iso_direction_filter f, bool fine, const float *restrict state, size_t count,
                          float *restrict directions, float *restrict magnitude);

#endif
