/* SPDX-License-Identifier: MIT */
/* blender_scene.h - descriptions for Blender, and runs of Blender; private to this folder.
 *
 *   blender.c        a level as a picture or as a file
 *   blender_plan.c   the bricks of a plan
 *   several.c        frames of a series, and several volumes
 *   describe.c       the description that the scripts read
 *   labels.c         label maps as an image of class numbers
 *   run.c            a run of Blender with the scripts
 *   device.c         finding Blender, and the device of its Cycles */
#pragma once

#include "base/file.h"
#include "base/json.h"
#include "blender/blender.h"
#include "vdb/vdb.h"

#define ISO_BLENDER_MAX_STEPS 65536 /* limit of Cycles along a ray */

/* Checks that levels [level, level + count) exist, and that Cycles supports the options. ISO_E_RANGE. */
iso_status iso_blender_check(const iso_pyramid *p, size_t level, size_t count, const iso_blender_options *opt,
                             iso_error *err);

/* Returns the path of a grid file. Each level and each region of interest has one, all with the same grid names for a
 * common material. */
char *iso_blender_vdb_path(const char *blend_path, size_t k, size_t count, bool roi);

/* Announces a grid file before it is replaced. Refuses if another program made it; force keeps it aside instead. */
iso_status iso_blender_guard_grid(const char *path, bool force, iso_error *err);

/* ---- the description: all positions in Blender's space ---- */

/* A position in Blender is units (world - origin_mm). A unit is a millimeter, except for volumes too small or too large
 * for single precision and for Cycles' fixed offsets. The origin is the world's, except for volumes so far from it that
 * single precision would lose parts of a voxel: then it is in the volume. */
typedef struct iso_blender_space {
    double units; /* per mm */
    iso_vec3 origin_mm;
} iso_blender_space;
/* Returns the space of a volume with level 0 geometry g, in mm. */
iso_blender_space iso_blender_space_of(const iso_geometry *g);
/* Writes the space into the metadata of a file of grids. */
void iso_blender_note_space(const iso_blender_space *space, iso_vdb_options *options);
/* Sets the options for grids that show only what a transfer function shows. Fills `shown`, which the caller keeps. */
void iso_blender_grid_options(const iso_blender_options *opt, const iso_tf_table *tf, const iso_tf_2d *tf_2d,
                              iso_vdb_shown *shown, iso_vdb_options *options);
/* Notes the scale of the directions for the material: eps is relative to their length. */
void iso_blender_scale_directions(json_t *about, const iso_blender_options *opt, double scale);
iso_geometry iso_blender_in_space(const iso_geometry *mm, const iso_blender_space *space);

/* Copies a pyramid with its geometry in Blender's space; the voxels are shared. The caller frees its levels. */
iso_status iso_blender_pyramid_in_space(const iso_pyramid *p, const iso_blender_space *space, iso_pyramid *copy,
                                        iso_error *err);

/* Makes a string of at most `limit` bytes in whole characters; invalid UTF-8 becomes '_'. */
json_t *iso_blender_text(const char *text, size_t limit);
/* Describes a scene. mm: geometry of the level, or of the whole box, in mm. */
json_t *iso_blender_describe_scene(const iso_view *view, const iso_blender_space *space, const iso_geometry *mm,
                                   const char *name, const iso_blender_options *opt);
/* Describes the transfer function of each view, for levels from `first` on, row by row if it is 2D; then that of each
 * region of interest; and a ramp for each different one. */
json_t *iso_blender_describe_tf(const iso_view *views, size_t first, size_t count, double units);

/* Does the same for `count` levels with one view, without a region of interest. NULL: out of memory. */
json_t *iso_blender_describe_one_tf(const iso_view *view, size_t first, size_t count, double units);

/* A level and its grids. Paths are those that Blender sees: absolute, or with a leading "//" relative to the .blend. */
typedef struct blender_level {
    const iso_geometry *geometry; /* in mm */
    size_t number;
    size_t tables[2]; /* numbers of its table, and of its region's table */
    const char *vdb, *roi_vdb;
    bool is_optimized;
} blender_level;

/* Describes a volume object; geometry and step in Blender's space. */
json_t *iso_blender_describe_level(const iso_geometry *g, size_t k, size_t table, const char *vdb, double step);
/* Appends the volume objects of a level: the level, and its region of interest. */
void iso_blender_append_level(json_t *levels, const blender_level *level, const iso_view *view,
                              const iso_blender_space *space, const iso_blender_options *opt);

/* Describes a label map: writes the image of its class numbers to `folder`, notes the part of each of about's "levels"
 * in it, and makes tables by class instead of by value. */
iso_status iso_blender_describe_labels(json_t *about, const iso_pyramid *p, const iso_blender_levels *levels,
                                       double units, const char *folder, iso_error *err);

/* ---- running Blender ---- */

/* Makes a new folder for a scene, in that of the options' session, if any, where its Blender may write. The caller
 * removes and frees it. NULL on failure. */
char *iso_blender_folder(const iso_blender_options *opt);

/* Runs a job description in Blender: in the session of the options, or in a new one. Output files go to the folder.
 * Takes `about`. */
iso_status iso_blender_run(json_t *about, const char *folder, const iso_blender_options *opt,
                           const iso_progress *progress, iso_error *err);
/* Starts a Blender for an export: it calibrates itself while the grids are written. iso_blender_end() ends it, also after
 * an error, and removes the folder, to which Blender may write. */
typedef struct iso_blender_started {
    iso_blender_options options; /* with the session */
    iso_blender_session *session;
    char *folder;
} iso_blender_started;
iso_status iso_blender_begin(const iso_blender_options *opt, iso_blender_started *e, iso_error *err);
void iso_blender_end(iso_blender_started *e);

/* Returns the seed for Cycles. Cycles ignores the last bit (seeds 2 and 3 have the same noise), so consecutive seeds
 * are spread over all bits by Knuth's multiplicative hash; 0 stays 0. */
int iso_blender_seed(int seed);
/* Describes the pictures: per picture, the settings that do not need a new scene. */
json_t *iso_blender_describe_frames(double voxel, const char *folder, const iso_blender_options *frames, size_t count);
iso_status iso_blender_load_pictures(const char *folder, const iso_view *view, size_t count, iso_image *pictures,
                                     iso_error *err);

/* Checks the path. ISO_E_USAGE: not a path that Blender accepts for a .blend. */
iso_status iso_blender_check_path(const char *blend_path, iso_error *err);
/* Runs `about`, which it takes, in Blender, and copies the .blend from Blender's folder to *out, which it reserves. */
iso_status iso_blender_save(json_t *about, const char *blend_path, iso_output *out, const char *folder,
                            const iso_blender_options *opt, const iso_progress *progress, iso_error *err);
