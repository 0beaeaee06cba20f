/* SPDX-License-Identifier: MIT */
/* signal.h - does an image show enough to be compared?
 *
 * Limits are absolute. Where an image hardly differs from its background, a renderer that draws nothing is within them, and
 * so is one that is wrong throughout. So a comparison needs a signal: what the reference shows above its background has to
 * be at least ISO_SIGNAL_FACTOR times the limit that images are held to, in color as well as in alpha. What is drawn wrong
 * by one part in that factor is then outside the limit.
 *
 * Like is measured with like: RMS where the limit is one of RMSE, or of the largest difference (which RMS never exceeds, so
 * that this is the stricter choice); where it is the difference that 99 % of the pixels stay below, what the brightest 1 %
 * of the pixels show at least. */
#ifndef ISO_SIGNAL_H
#define ISO_SIGNAL_H

#include "image/image.h"

#define ISO_SIGNAL_FACTOR 100.0

typedef enum iso_signal_measure { ISO_SIGNAL_RMS, ISO_SIGNAL_P99 } iso_signal_measure;

typedef struct iso_signal {
    double color, alpha; /* what the image shows above its background */
    double least;        /* what is asked of both; 0: nothing */
    iso_signal_measure measure;
} iso_signal;

/* Of an image with its background included, whose alpha is 0 where nothing is drawn. limit: what images are held to.
 * ISO_E_MEMORY. Pixels that are not finite make a signal that is no number, which is never enough. */
iso_status iso_signal_of(const iso_image *image, const double background[3], double limit, iso_signal_measure measure,
                         iso_signal *signal, iso_error *err);
bool iso_signal_suffices(const iso_signal *signal);
/* Why it does not suffice, with its numbers. */
void iso_signal_explain(const iso_signal *signal, char *text, size_t size);

/* Equals the background in every bit, with alpha 0. */
bool iso_image_is_empty(const iso_image *image, const double background[3]);

#endif
