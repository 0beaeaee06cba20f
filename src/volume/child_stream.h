/* SPDX-License-Identifier: MIT */
/* child_stream.h - output of the programs that read volumes for isoshade (isoshade-itk, isoshade-arrays, isoshade-vdb).
 * They write an iso_child_header. If it is good, an iso_child_answer follows for each plane, and its samples if the
 * answer is good.
 * They are separate programs, since libraries of many formats may crash on a damaged file, which then ends only that
 * program. They are started as
 * PROGRAM PATH PART FRAME CHANNEL UNEVEN: "" for an unnamed part, numbers from 0, and one of iso_uneven. */
#pragma once

#include <stdbool.h>

#include "volume/type.h"

typedef struct iso_child_answer {
    iso_status status;
    iso_error error;
} iso_child_answer;

/* The meaning of the axes of the file's world. */
typedef enum iso_child_world {
    ISO_CHILD_LPS,     /* left, posterior, superior */
    ISO_CHILD_RAS,     /* right, anterior, superior */
    ISO_CHILD_OWN,     /* its own */
    ISO_CHILD_CENTERED /* its own, around the box's center: the file gives no place */
} iso_child_world;

enum { ISO_CHILD_CHANNELS = 32, ISO_CHILD_SEGMENTS = 1024 }; /* that may have names */

typedef struct iso_child_segment {
    uint16_t label;
    char name[62];
} iso_child_segment;

typedef struct iso_child_header {
    char version[16]; /* ISO_VERSION */
    iso_child_answer answer;
    size_t size[3];
    iso_type type;
    iso_child_world world;
    double first[3];         /* center of the first sample */
    double step[3][3];       /* step[a]: from a sample to the next along axis a */
    char unit[3][32];        /* of the world's axes; "" if the file has none, which is mm */
    double slope, intercept; /* physical value = slope * sample + intercept */
    char value_unit[16];     /* of physical values; "" if the file has none */
    double box[3];           /* the box in index coordinates, if it is smaller than the grid; 0: as the grid */
    bool is_labels;          /* True if the file is a label map by its own words */
    iso_child_segment segment[ISO_CHILD_SEGMENTS]; /* of a label map; their end has no name */
    bool is_whole;           /* doubles that are integers of 64 bits in the file */
    size_t fill_count;       /* values that stand for none, and which */
    double fill[3];
    size_t frames, channels; /* that the file has, of which one each is given; 0 or 1: there is one */
    bool is_color; /* red, green, blue, and alpha if there are four; channel number `channels` is their luminance */
    char channel_name[ISO_CHILD_CHANNELS][48];
    double frame_step; /* distance of frames; 0: not given */
    char frame_unit[16];
    char unspaced[160]; /* "", or the spacing that is missing in the file: "between its slices" */
    char warning[320];  /* "", or a warning for the user, such as a file that is left out */
} iso_child_header;
