/* SPDX-License-Identifier: MIT */
/* across.h - designs of coarse levels on their front: bytes and the time of a frame against the error across levels.
 *
 * A design is what a level stores and how it is shown (scalar filter, transfer function, directions). Its error at a level
 * is against level 0, as rendered and minified, where both images are averaged so that a pixel is about a voxel of the
 * level. Points are designs at levels; on the front are those for which no other is both as cheap and as exact, by the
 * error as rendered: minified ones of different levels are of pictures of different sizes. Below them each design's
 * errors stand over those of the first one, level by level. */
#ifndef ISO_CHART_ACROSS_H
#define ISO_CHART_ACROSS_H

#include <jansson.h>

#include "base/status.h"

typedef struct iso_across_row {
    const char *design, *summary, *scalar, *treatment, *directions;
    size_t level;
    double bytes, seconds, error, error_minified;
    int chosen_within; /* bytes of the budget within which --auto chooses the design, or 0 */
    /* By iso_across_rank(): */
    bool bytes_front, time_front;
    double ratio, ratio_minified; /* to the first design's at the level */
} iso_across_row;

/* A design of which all levels are taken together: geometric means of its ratios, and of those how many levels it has. */
typedef struct iso_across_design {
    const char *name;
    double ratio, ratio_minified, bytes, seconds; /* bytes: of its levels together; seconds: their mean */
    bool bytes_front, time_front;                 /* among designs, by the minified ratio */
    int chosen_within;
} iso_across_design;

/* Rows design by design, levels of each in the same order. */
void iso_across_rank(iso_across_row *rows, size_t count);
/* Designs of ranked rows; returns how many, at most `most`. */
size_t iso_across_designs(const iso_across_row *rows, size_t count, iso_across_design *designs, size_t most);

typedef struct iso_across_chart {
    const char *output, *volume, *tf, *metric, *style; /* style: a file, or NULL */
    int views, size;
} iso_across_chart;

/* DIR with across.svg, across.pdf, across.csv and chart.json. */
iso_status iso_across_write(const iso_across_chart *c, const iso_across_row *rows, size_t count, const json_t *json,
                            iso_error *err);
json_t *iso_across_to_json(const iso_across_chart *c, const iso_across_row *rows, size_t count);
void iso_across_print(const iso_across_row *rows, size_t count);

#endif
