/* SPDX-License-Identifier: MIT */
/* level_methods.h - the methods that `isoshade-lab levels` compares: what a coarse level stores, and how it is shown.
 *
 * A method is a row of the table in level_methods.c. What rows have in common (filters of the build, where directions
 * come from, what becomes of the transfer function) are its fields. What else a method needs it does in `make`, which is
 * given the level as it was built and changes a copy of it. To add a method, add a row. */
#ifndef ISO_LAB_LEVEL_METHODS_H
#define ISO_LAB_LEVEL_METHODS_H

#include "lab/rivals/rivals.h"
#include "pyramid/pyramid.h"
#include "scene/field.h"
#include "tf/adapt.h"

/* What becomes of the transfer function at a level. */
typedef enum iso_level_treatment {
    ISO_LEVEL_TF_ORIGINAL, /* it stays */
    ISO_LEVEL_TF_ADAPTED,  /* adapted where small views say that it helps (tf/adapt.h) */
    ISO_LEVEL_TF_ALWAYS,   /* adapted */
    ISO_LEVEL_TF_2D        /* a 2D one, over the deviation */
} iso_level_treatment;

/* What is shown instead of level 0. */
typedef struct iso_level_shown {
    iso_level level; /* a copy of the pyramid's that shares its arrays */
    iso_tf_table tf;
    iso_tf_2d tf_2d;
    bool has_tf_2d;
    iso_adapt_judgment judgment;
    float *scalar;   /* an array that `make` puts into the level; freed with this */
    uint8_t *bytes;  /* likewise */
    iso_rival rival; /* rendered by the reference instead of the level's scalar and the TF, where it has an emitter */
    uint8_t *extinction_scale; /* a byte a voxel (fit/extinction_scale.h), or NULL; freed with this */
} iso_level_shown;

typedef struct iso_level_method {
    const char *name, *summary;
    iso_scalar_filter scalar;
    iso_direction_filter directions;
    iso_direction_source source;
    iso_level_treatment treatment;
    /* Changes *shown, which has been filled by the fields above; NULL: it stays as it is. */
    iso_status (*make)(const iso_level_subject *s, iso_level_shown *shown, iso_error *err);
    iso_status (*rival)(const iso_level_subject *s, iso_rival *r, iso_error *err); /* NULL: it is no rival */
    double bytes;                                                                  /* a voxel beside the scalar */
    double fetches; /* a sample, all textures of the level together */
} iso_level_method;

enum { ISO_LEVEL_MAX_METHODS = 64 };
size_t iso_level_method_count(void);
const iso_level_method *iso_level_method_at(size_t index);
extern const iso_names iso_level_method_names;

/* "all", "own" (all but rivals), "rivals", or names, with commas between them, into wanted[]. ISO_E_USAGE with option and word. */
iso_status iso_level_methods_choose(const char *text, bool wanted[ISO_LEVEL_MAX_METHODS], iso_error *err);

/* What m shows of the level. ISO_E_MEMORY, ISO_E_RANGE. */
iso_status iso_level_show(const iso_level_method *m, const iso_level_subject *s, iso_level_shown *shown,
                          iso_error *err);
void iso_level_shown_destroy(iso_level_shown *shown);

#endif
