/* SPDX-License-Identifier: MIT */
/* flip.h - the difference that a person sees when two images alternate.
 *
 * LDR: [andersson-2020]. HDR: [andersson-2021].
 * Colors are linear; alpha is ignored. Borders repeat the edge pixel.
 * Values lie in [0, 1]; 0: no visible difference. Symmetric in the two
 * images (LDR); HDR takes its exposures from the first, the reference.
 * Threads do not change the result. */
#pragma once

#include "image/image.h"

/* The paper's observer: 0.7 m from a screen 0.7 m and 3840 pixels wide, 67 pixels a degree. */
#define ISO_FLIP_PIXELS_PER_DEGREE (3840 * 3.14159265358979323846 / 180)

/* Fills map with width * height values; colors are clipped to [0, 1]. ISO_E_RANGE: empty, different sizes, fewer than 1
 * pixel per degree; ISO_E_MEMORY. */
iso_status iso_flip_ldr(const iso_image *a, const iso_image *b, double pixels_per_degree, float *map, iso_error *err);

/* Computes the exposures of HDR-FLIP, as powers of two: `count` of them, evenly from *start to *stop. They span at most
 * 20 stops; 8 if the reference's median is black, as the paper's range then has no end. ISO_E_MEMORY. */
iso_status iso_flip_exposures(const iso_image *reference, double *start, double *stop, size_t *count, iso_error *err);

/* Fills map with the largest LDR value over exposures. They go from the one that keeps the reference's brightest pixel
 * to the one that lifts its median, both to 0.85 of the display after the ACES tone curve. Non-finite or negative
 * colors count as 0. */
iso_status iso_flip_hdr(const iso_image *reference, const iso_image *b, double pixels_per_degree, float *map,
                        iso_error *err);

/* Returns the mean of a map, summed in order. */
double iso_flip_mean(const float *map, size_t count);
