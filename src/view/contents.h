/* SPDX-License-Identifier: MIT */
/* contents.h - what a viewer's page carries: packed arrays, and the JSON that says what they are. */
#ifndef ISO_VIEW_CONTENTS_H
#define ISO_VIEW_CONTENTS_H

#include <jansson.h>

#include "view/pack.h"
#include "view/viewer.h"

enum { ISO_VIEWER_LEVELS = 16, ISO_VIEWER_ARRAYS = ISO_VIEWER_LEVELS * (ISO_VIEWER_CODES + 2) + 3 };

typedef struct iso_contents {
    json_t *root; /* owned */
    size_t count, first_count; /* the arrays; those of the coarsest level */
    struct iso_contents_array {
        char name[48];
        iso_packed packed; /* owned */
    } arrays[ISO_VIEWER_ARRAYS]; /* in the order in which the page is to read them */
    iso_viewer_size size;
} iso_contents;

iso_status iso_contents_make(const iso_viewer *v, const iso_progress *progress, iso_contents *contents, iso_error *err);
/* Packs an array under a name, and says in `json` how to unpack it. */
iso_status iso_contents_add_array(iso_contents *contents, const char *name, const iso_pack_array *array, json_t *json,
                                  iso_error *err);
/* What a page needs to know of a code: a new object. */
json_t *iso_contents_code_json(iso_code code);
void iso_contents_destroy(iso_contents *contents);

#endif
