/* SPDX-License-Identifier: MIT */
/* level_methods.h - the methods that `isoshade-lab levels` compares: contents of a coarse level, and its display.
 *
 * A method is a row of the table in level_methods.c. Common properties are its fields: filters of the build, source of
 * directions, treatment of the transfer function. Anything else is done by `make`, which modifies a copy of the built
 * level. To add a method, add a row. */
#pragma once

#include "lab/rivals/rivals.h"
#include "pyramid/pyramid.h"
#include "scene/field.h"
#include "tf/adapt.h"

/* Treatment of the transfer function at a level. */
typedef enum iso_level_treatment {
    ISO_LEVEL_TF_ORIGINAL, /* unchanged */
    ISO_LEVEL_TF_ADAPTED,  /* adapted if small views favor it (tf/adapt.h) */
    ISO_LEVEL_TF_ALWAYS,   /* always adapted */
    ISO_LEVEL_TF_2D        /* 2D, of value and deviation */
} iso_level_treatment;

/* A coarse level prepared for display. */
typedef struct iso_level_shown {
    iso_level level; /* a copy of the pyramid's that shares its arrays */
    iso_tf_table tf;
    iso_tf_2d tf_2d;
    bool has_tf_2d;
    iso_adapt_judgment judgment;
    float *scalar;   /* array that `make` puts into the level; freed with this struct */
    uint8_t *bytes;  /* the same */
    iso_rival rival; /* if it has an emitter, the reference renders it instead of the level's scalar and the TF */
    uint8_t *extinction_scale; /* one byte per voxel (fit/extinction_scale.h), or NULL; freed with this struct */
} iso_level_shown;

typedef struct iso_level_method {
    const char *name, *summary;
    iso_scalar_filter scalar;
    iso_direction_filter directions;
    iso_direction_source source;
    iso_level_treatment treatment;
    /* Modifies *shown after the fields above have been applied; or NULL. */
    iso_status (*make)(const iso_level_subject *s, iso_level_shown *shown, iso_error *err);
    iso_status (*rival)(const iso_level_subject *s, iso_rival *r, iso_error *err); /* NULL: not a rival */
    double bytes;                                                                  /* per voxel, without the scalar */
    double fetches; /* per sample, of all textures of the level */
} iso_level_method;

enum { ISO_LEVEL_MAX_METHODS = 64 };
size_t iso_level_method_count(void);
const iso_level_method *iso_level_method_at(size_t index);
extern const iso_names iso_level_method_names;

/* Parses a list of names, "all", "own" (all but rivals) or "rivals" into wanted[]. ISO_E_USAGE. */
iso_status iso_level_methods_choose(const char *text, bool wanted[ISO_LEVEL_MAX_METHODS], iso_error *err);

/* Prepares the level for display by method m. ISO_E_MEMORY, ISO_E_RANGE. */
iso_status iso_level_show(const iso_level_method *m, const iso_level_subject *s, iso_level_shown *shown,
                          iso_error *err);
void iso_level_shown_destroy(iso_level_shown *shown);
