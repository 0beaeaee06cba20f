/* SPDX-License-Identifier: MIT */
/* grids.h - what `export --to vdb --bake` writes: the grids that a person names, in a file that other programs read.
 *
 *   name         type   holds
 *   density      float  extinction per scene unit, never negative
 *   Cd           vec3s  linear color
 *   emission     vec3s  extinction times linear color, per scene unit: light of a medium that emits and absorbs
 *   temperature  float  the value's place on the transfer function's range, 0 to 1: for a ramp of the other program. No kelvins
 *
 * "Cd=color" writes Cd by the name color. */
#ifndef ISO_BAKE_GRIDS_H
#define ISO_BAKE_GRIDS_H

#include <popt.h>

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

/* By popt; live until the process ends. 0 and NULL: not given. */
typedef struct iso_bake_words {
    char *grids, *unit, *up, *program;
    int points, samples, usd;
    bool lattice_alone; /* points and samples have a meaning without grids and program */
} iso_bake_words;

/* clang-format off */
#define ISO_BAKE_OPTIONS(a)                                                                                                        \
    {"bake", 0, POPT_ARG_STRING, &(a)->grids, 0, "vdb, nanovdb: what other programs read in place of the scalar: extinction and color by the scene's transfer function", "density,Cd,..."}, \
    {"for", 0, POPT_ARG_STRING, &(a)->program, 0, "vdb, nanovdb: the program that the file is for, of the list below: sets --bake, --scene-unit, --up, --half and --usd", "PROGRAM"}, \
    {"scene-unit", 0, POPT_ARG_STRING, &(a)->unit, 0, "vdb, nanovdb, baked: the length of one scene unit (mm)", "m|cm|mm|..."},             \
    {"up", 0, POPT_ARG_STRING, &(a)->up, 0, "vdb, nanovdb, baked: the scene's axis that points up (z)", "z|y"},                             \
    {"points", 0, POPT_ARG_INT, &(a)->points, 0, "vdb, nanovdb, baked; pbrt, mitsuba: points of the grid along a voxel's side (1)", "N"},                  \
    {"supersample", 0, POPT_ARG_INT, &(a)->samples, 0, "vdb, nanovdb, baked; pbrt, mitsuba: samples along a point's cell, which are averaged (2)", "N"},   \
    {"usd", 0, POPT_ARG_NONE, &(a)->usd, 0, "vdb, baked: a .usda beside the file, which names its grids", NULL}
/* clang-format on */

typedef struct iso_bake_request {
    bool wanted; /* else the rest has no meaning */
    bool has[ISO_BAKE_GRIDS];
    char name[ISO_BAKE_GRIDS][64]; /* in the file */
    iso_bake_options lattice;
    iso_vdb_convention convention;
    bool unit_is_asked; /* true if --scene-unit names it; if not, voxels that OpenVDB cannot hold in it get another */
    bool half, usd;
    const iso_grid_program *program; /* or NULL */
    size_t error_pixels;             /* of bake_error.h */
} iso_bake_request;

/* ISO_E_USAGE with option and value. */
iso_status iso_bake_request_make(const iso_bake_words *words, bool half, iso_bake_request *request, iso_error *err);

/* The file, and NAME.usda beside it where it is wanted. path ends in .vdb there. */
iso_status iso_bake_save(const iso_baked *b, const iso_bake_request *request, int level, const char *made_from,
                         const char *path, const iso_progress *progress, iso_error *err);

/* Before work that writes NAME.usda beside path: it is announced (base/inputs.h), and guarded (base/stamp.h). */
iso_status iso_bake_guard_usda(const char *path, bool force, iso_error *err);

/* The text of a .usda; to be freed. NULL: no memory. path: of the file of grids, which lies beside it. */
char *iso_bake_usda(const iso_baked *b, const iso_bake_request *request, const char *path);

#endif
