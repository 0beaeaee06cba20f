/* SPDX-License-Identifier: MIT */
/* nrrd_segments.c - the keys of a .seg.nrrd file, 3D Slicer's segmentation:
 *
 *     Segment0_ID:=Segment_1          Segment0_Name:=Head       Segment0_Color:=0.694118 0.478431 0.396078
 *     Segment0_LabelValue:=1          Segment0_Layer:=0         Segment0_Extent:=40 210 3 235 0 111
 *
 * Segments that overlap are in layers, which are the first axis of a 4D file. Files of before Slicer 4.11 have neither
 * values nor layers: a layer of zeros and ones a segment. */
#include <stdio.h>
#include <stdlib.h>
#include <teem/nrrd.h>

#include "volume/nrrd_segments.h"
#include "volume/segments.h"

enum { MOST_SEGMENTS = 65536 };

/* Returns the value of "SegmentN_KEY"; to be freed. NULL: the key is missing. */
static char *value_of(const Nrrd *nrrd, int number, const char *key)
{
    char name[64];
    snprintf(name, sizeof name, "Segment%d_%s", number, key);
    return nrrdKeyValueGet(nrrd, name);
}

/* Returns a whole number of the file, or `otherwise`. */
static long number_of(const Nrrd *nrrd, int number, const char *key, long otherwise)
{
    char *text = value_of(nrrd, number, key), *end = text;
    const long value = text ? strtol(text, &end, 10) : otherwise;
    const bool good = text && end != text && value >= ISO_SEGMENTS_LABEL_MIN && value <= ISO_SEGMENTS_LABEL_MAX;
    free(text);
    return good ? value : otherwise;
}

/* Reads three numbers; a color's are 0 to 1. */
static json_t *color_of(const Nrrd *nrrd, int number)
{
    char *text = value_of(nrrd, number, "Color"), *at = text;
    json_t *color = json_array();
    for (int c = 0; at && c < 3; ++c) {
        char *end = at;
        const double value = strtod(at, &end);
        if (end == at || !(value >= 0 && value <= 1))
            break;
        json_array_append_new(color, json_real(value));
        at = end;
    }
    free(text);
    if (json_array_size(color) == 3)
        return color;
    json_decref(color);
    return NULL;
}

static json_t *segment_of(const Nrrd *nrrd, int number, bool has_layers)
{
    FREED char *id = value_of(nrrd, number, "ID"), *name = value_of(nrrd, number, "Name");
    json_t *segment = NULL, *color;
    if (id || name) {
        const long label = number_of(nrrd, number, "LabelValue", has_layers ? 1 : number + 1);
        const long layer = number_of(nrrd, number, "Layer", has_layers ? number : 0);
        segment = json_pack("{sI so sI}", "label", (json_int_t)label, "name", iso_segments_text(name ? name : id),
                            "layer", (json_int_t)(layer > 0 ? layer : 0));
        if (segment && (color = color_of(nrrd, number)))
            json_object_set_new(segment, "color", color);
    }
    return segment;
}

json_t *iso_nrrd_segments(const Nrrd *nrrd, bool has_layers)
{
    json_t *segments = json_array(), *segment;
    for (int i = 0; i < MOST_SEGMENTS && (segment = segment_of(nrrd, i, has_layers)); ++i)
        json_array_append_new(segments, segment);
    if (json_array_size(segments) > 0)
        return segments;
    json_decref(segments);
    return NULL;
}
