/* SPDX-License-Identifier: MIT */
/* segments.h - names and colors of a label map's labels, if its file has them (3D Slicer's .seg.nrrd).
 *
 * They are carried as JSON, which pyramids and descriptions for other programs store as it is:
 *     [ {"label": 1, "name": "liver", "color": [0.87, 0.51, 0.4]}, ... ]
 * Colors are of display (sRGB), 0 to 1, and left out where the file names none. Between reading and choosing among the
 * layers of overlapping segments each has its "layer", too. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include <jansson.h>

#include "base/json.h"

/* Labels are whole numbers of at most 32 bits, with or without a sign. */
#define ISO_SEGMENTS_LABEL_MIN (-2147483648L)
#define ISO_SEGMENTS_LABEL_MAX 4294967295L

/* Copies a text as UTF-8 without control characters; all others become '_'. A new string; NULL: out of memory. */
json_t *iso_segments_text(const char *text);

/* Refuses a list that differs from the form above, with ISO_E_FORMAT; a color's number beyond 0 to 1 with
 * ISO_E_RANGE. */
void iso_segments_check(iso_json_reader *r, const json_t *segments);

/* Returns the first segment of that label, or NULL. segments may be NULL. */
const json_t *iso_segments_find(const json_t *segments, long label);
/* Returns a label's name; "" if it has none. */
const char *iso_segments_name(const json_t *segments, long label);
/* Finds a label's display color; false if it has none. */
bool iso_segments_color(const json_t *segments, long label, double srgb[3]);

/* Finds the layer of the segment of this name, not sensitive to case. False: there is none. */
bool iso_segments_layer(const json_t *segments, const char *name, size_t *layer);
/* Writes "0 (head), 1 (mass, vessel)", cut if the text is full. */
void iso_segments_list_layers(const json_t *segments, size_t layer_count, char *text, size_t size);
/* Returns those of one layer, without "layer"; NULL if there are none. A new array. */
json_t *iso_segments_of_layer(const json_t *segments, size_t layer);
