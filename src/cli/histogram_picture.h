/* SPDX-License-Identifier: MIT */
/* histogram_picture.h - a volume's histogram as gnuplot draws it: gray, counts in logs on an axis of its own. */
#ifndef ISO_CLI_HISTOGRAM_PICTURE_H
#define ISO_CLI_HISTOGRAM_PICTURE_H

#include <stdio.h>

#include "volume/value_histogram.h"

/* A count as a height of 0 to 1, the fullest bin's: 0 for none, and one voxel can be seen. */
double iso_histogram_height(const iso_value_histogram *h, size_t count);

/* The data block $NAME: where a bin begins, its height; steps of a line that begins and ends on the axis. */
void iso_histogram_put_data(FILE *gp, const char *name, const iso_value_histogram *h);
/* "set y2tics ...": powers of ten at their heights, as many as can be read. axis: "y" or "y2". */
void iso_histogram_put_ticks(FILE *gp, const char *axis, const iso_value_histogram *h);

/* `info --histogram`: the whole picture. */
iso_status iso_histogram_draw(const iso_value_histogram *h, const char *title, const char *output, iso_error *err);

/* The same in letters, for a terminal: rows of counts in logs over an axis of values. `indent` blanks before each line. */
void iso_histogram_print(const iso_value_histogram *h, int indent, FILE *f);

#endif
