/* SPDX-License-Identifier: MIT */
/* contents.h - the data of a viewer's page: packed arrays, and JSON that describes them. */
#pragma once

#include <jansson.h>

#include "view/pack.h"
#include "view/viewer.h"

enum { ISO_VIEWER_LEVELS = 16, ISO_VIEWER_ARRAYS = ISO_VIEWER_LEVELS * (ISO_VIEWER_CODES + 3) + 4 };

typedef struct iso_contents {
    json_t *root; /* owned */
    size_t count, first_count; /* number of arrays; number of those of the coarsest level */
    struct iso_contents_array {
        char name[48];
        iso_packed packed; /* owned */
    } arrays[ISO_VIEWER_ARRAYS]; /* in reading order */
    iso_viewer_size size;
} iso_contents;

iso_status iso_contents_make(const iso_viewer *v, const iso_progress *progress, iso_contents *contents, iso_error *err);
/* Packs an array, and describes it under a name in `json`. */
iso_status iso_contents_add_array(iso_contents *contents, const char *name, const iso_pack_array *array, json_t *json,
                                  iso_error *err);
/* Returns a new object that describes a code. */
json_t *iso_contents_code_json(iso_code code);
void iso_contents_destroy(iso_contents *contents);
