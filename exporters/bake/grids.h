/* SPDX-License-Identifier: MIT */
/* grids.h - the grids of `export --to vdb --bake`, with names that the user chooses.
 *
 *   name         type   holds
 *   density      float  extinction per scene unit, never negative
 *   Cd           vec3s  linear color
 *   emission     vec3s  extinction times linear color, per scene unit: light of an emitting and absorbing medium
 *   temperature  float  position in the transfer function's range, 0 to 1: for a color ramp. Not in kelvins
 *
 * "Cd=color" writes Cd with the name color. */
#pragma once


#include "bake/bake_error.h"
#include "bake/programs.h"
#include "vdb/fields.h"

typedef enum iso_bake_grid {
    ISO_BAKE_DENSITY,
    ISO_BAKE_CD,
    ISO_BAKE_EMISSION,
    ISO_BAKE_TEMPERATURE,
    ISO_BAKE_GRIDS
} iso_bake_grid;
extern const iso_names iso_bake_grid_names;

/* Words of the options. 0 and NULL: not given. */
typedef struct iso_bake_words {
    char *grids, *unit, *up, *program;
    int points, samples, usd;
    bool lattice_alone; /* True if points and samples may be set without grids or program */
} iso_bake_words;

typedef struct iso_bake_request {
    bool wanted; /* if false, the other fields are unused */
    bool has[ISO_BAKE_GRIDS];
    char name[ISO_BAKE_GRIDS][64]; /* names in the file */
    iso_bake_options lattice;
    iso_vdb_convention convention;
    bool unit_is_asked; /* True if set by --scene-unit; if false, another unit may replace it for voxels that OpenVDB
                         * cannot hold */
    bool half, usd, nanovdb; /* nanovdb: write a NanoVDB file */
    const iso_grid_program *program; /* or NULL */
    size_t error_pixels;             /* for bake_error.h */
} iso_bake_request;

/* Makes the request. ISO_E_USAGE names option and value. */
iso_status iso_bake_request_make(const iso_bake_words *words, bool half, iso_bake_request *request, iso_error *err);

/* Saves the grids to path, and NAME.usda next to it if requested; path then ends in .vdb. */
iso_status iso_bake_save(const iso_baked *b, const iso_bake_request *request, int level, const char *made_from,
                         const char *path, const iso_progress *progress, iso_error *err);

/* Announces NAME.usda next to path before the work (base/inputs.h), and checks its stamp (base/stamp.h). */
iso_status iso_bake_guard_usda(const char *path, bool force, iso_error *err);

/* Returns the text of a .usda, which the caller frees; NULL if out of memory. path: the grid file in the same
 * folder. */
char *iso_bake_usda(const iso_baked *b, const iso_bake_request *request, const char *path);
