/* SPDX-License-Identifier: MIT */
/* planned.h - a plan file, and the model that is left of a volume by it.
 *
 *   { "schema": "isoshade.plan/1", ...
 *     "bricks": [nx, ny, nz], "brick_voxels": n, "level_count": L,
 *     "levels": "0010...",   a digit a brick, x fastest
 *     "use": "dhu..." }      a letter a brick: drawn, hidden by the transfer function, unseen by any view */
#pragma once

#include <jansson.h>

#include "brick/lattice.h"
#include "scene/scene.h"

typedef struct iso_plan_file {
    size_t count[3], brick_voxels, level_count;
    uint8_t *levels; /* owned; of the bricks that are left out too: faces follow the coarsest brick, drawn or not */
    uint8_t *drawn;  /* owned; 0: left out */
    uint8_t *seen;   /* owned; 0: left out because no view sees it */
} iso_plan_file;

iso_status iso_plan_file_load(const char *path, iso_plan_file *plan, iso_error *err);
/* Reads the object of such a file, which is `name` in messages. */
iso_status iso_plan_file_from_json(const json_t *root, const char *name, iso_plan_file *plan, iso_error *err);
/* Returns an object with "levels" and "use"; NULL: no memory. */
json_t *iso_plan_file_bricks(const uint8_t *levels, const uint8_t *drawn, const uint8_t *seen, size_t count);
void iso_plan_file_destroy(iso_plan_file *plan); /* accepts empty and NULL */

/* A volume reduced by a plan. */
typedef struct iso_planned {
    iso_plan_file plan;
    iso_node_levels nodes; /* of single bricks; directions as the pyramid's code has them */
    const iso_tf_table *tfs;
    size_t tf_count;
    double build_seconds;
} iso_planned;

/* Subject of a plan: a volume, the code of its directions, and its transfer functions. */
typedef struct iso_planned_subject {
    const iso_level *level0; /* its scalars or samples are kept, not copied */
    iso_code code;
    const iso_tf_table *tfs; /* kept, not copied */
    size_t tf_count;
} iso_planned_subject;
/* Reduces the volume by the plan. ISO_E_RANGE: it was made for another volume or for other transfer functions. */
iso_status iso_planned_create(const char *path, const iso_planned_subject *subject, int threads, iso_planned *p,
                              iso_error *err);
/* Does the same with a plan that is loaded, which it takes over in any case. */
iso_status iso_planned_create_of(iso_plan_file *plan, const char *name, const iso_planned_subject *subject, int threads,
                                 iso_planned *p, iso_error *err);
void iso_planned_destroy(iso_planned *p);

typedef struct iso_planned_lattices {
    size_t count;
    iso_lattice items[ISO_BRICK_MAX_LEVELS];
} iso_planned_lattices;

/* Makes one merged lattice, or one per level in use, finest first. whole_box as in lattice.h. */
iso_status iso_planned_lattices_create(const iso_planned *p, bool merged, bool whole_box, int threads,
                                       iso_planned_lattices *lattices, iso_error *err);
void iso_planned_lattices_destroy(iso_planned_lattices *lattices);

/* The merged lattice as a level for programs without sparse grids. It is cropped to the needed part; scalars have the
 * stored type if nothing is sampled. The exported grid is dense, but read from the lattice row by row: the level has
 * neither scalars nor codes. box: place of the volume's own box, in voxels of the level. Release with
 * iso_planned_crop_destroy(). */
typedef struct iso_planned_crop {
    iso_lattice lattice; /* of the level's voxels */
    iso_level level;
    double box[2][3];
    double quantum; /* all scalars are whole multiples of it; 0: not known */
} iso_planned_crop;
iso_status iso_planned_crop_create(const iso_planned *p, const iso_level *level0, int threads, iso_planned_crop *crop,
                                   iso_error *err);
void iso_planned_crop_destroy(iso_planned_crop *crop);
