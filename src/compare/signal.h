/* SPDX-License-Identifier: MIT */
/* signal.h - tests if an image shows enough to be compared.
 *
 * Limits are absolute. If an image hardly differs from its background, an empty image is within them, and so is a wrong
 * one. So a comparison needs a signal: the reference minus its background has to be at least ISO_SIGNAL_FACTOR times
 * the limit of the images, in color and in alpha. An error of one part in that factor then exceeds the limit.
 *
 * The signal has the limit's measure. For a limit of the RMSE or of the largest difference it is the RMS, which the
 * largest difference always reaches, so that this is the stricter choice. For a limit that 99 % of the pixels stay
 * below, it is the least value of the brightest 1 % of the pixels. */
#pragma once

#include "image/image.h"

#define ISO_SIGNAL_FACTOR 100.0

typedef enum iso_signal_measure { ISO_SIGNAL_RMS, ISO_SIGNAL_P99 } iso_signal_measure;

typedef struct iso_signal {
    double color, alpha; /* signal of the image above its background */
    double least;        /* required of both; 0: no requirement */
    iso_signal_measure measure;
} iso_signal;

/* Measures an image that includes its background; alpha is 0 in empty pixels. limit: the limit of the images.
 * ISO_E_MEMORY. Pixels that are not finite make the signal NaN, which is never enough. */
iso_status iso_signal_of(const iso_image *image, const double background[3], double limit, iso_signal_measure measure,
                         iso_signal *signal, iso_error *err);
bool iso_signal_suffices(const iso_signal *signal);
/* Explains why the signal does not suffice, with its numbers. */
void iso_signal_explain(const iso_signal *signal, char *text, size_t size);

/* True if all pixels equal the background in every bit, with alpha 0. */
bool iso_image_is_empty(const iso_image *image, const double background[3]);
