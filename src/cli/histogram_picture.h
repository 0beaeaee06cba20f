/* SPDX-License-Identifier: MIT */
/* histogram_picture.h - draws a volume's histogram with gnuplot, or as text: counts on a logarithmic axis. */
#pragma once

#include <stdio.h>

#include "volume/value_histogram.h"

/* Writes the data block $NAME: start and height of each bin, as a step line that begins and ends on the axis. */
void iso_histogram_put_data(FILE *gp, const char *name, const iso_value_histogram *h);
/* Writes "set y2tics ...": powers of ten at their heights, as many as are readable. axis: "y" or "y2". */
void iso_histogram_put_ticks(FILE *gp, const char *axis, const iso_value_histogram *h);

/* Draws the picture of `info --histogram`. */
iso_status iso_histogram_draw(const iso_value_histogram *h, const char *title, const char *output, iso_error *err);

/* Prints the histogram as text: rows of logarithmic counts over an axis of values. indent: blanks before each line. */
void iso_histogram_print(const iso_value_histogram *h, int indent, FILE *f);
