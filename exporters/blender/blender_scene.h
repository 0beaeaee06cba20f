/* SPDX-License-Identifier: MIT */
/* blender_scene.h - what is told to Blender, and how Blender is run; private to this folder.
 *
 *   blender.c        a level as a picture or as a file
 *   blender_plan.c   what a plan leaves of a volume
 *   sequence.c       frames of a series
 *   several.c        several volumes
 *   describe.c       the description that the scripts read
 *   labels.c         label maps as an image of class numbers
 *   run.c            a run of Blender with the scripts
 *   device.c         which Blender, and what its Cycles renders on */
#ifndef ISO_BLENDER_SCENE_H
#define ISO_BLENDER_SCENE_H

#include "base/file.h"
#include "base/json.h"
#include "blender/blender.h"
#include "vdb/vdb.h"

#define ISO_BLENDER_MAX_STEPS 65536 /* the most that Cycles takes along a ray */

/* Levels [level, level + count) are there, and the options are what Cycles can do. ISO_E_RANGE. */
iso_status iso_blender_check(const iso_pyramid *p, size_t level, size_t count, const iso_blender_options *opt,
                             iso_error *err);

/* One file a level, and one a region of interest, all with the same grid names, so that one material reads them. */
char *iso_blender_vdb_path(const char *blend_path, size_t k, size_t count, bool roi);

/* Before it is replaced: announces a file of grids, and refuses one that is not isoshade's, which force keeps aside. */
iso_status iso_blender_guard_grid(const char *path, bool force, iso_error *err);

/* ---- the description: all places in Blender's space ---- */

/* A place in Blender is units (world - origin_mm). A unit is a millimeter, but for volumes that are so small or so
 * large that single precision and Cycles' fixed offsets do not suit them. The origin is the world's, but for volumes
 * that stand so far from it that single precision would lose parts of a voxel: there it is in the volume. */
typedef struct iso_blender_space {
    double units; /* per mm */
    iso_vec3 origin_mm;
} iso_blender_space;
/* That of a volume whose level 0 is g, in mm. */
iso_blender_space iso_blender_space_of(const iso_geometry *g);
/* Writes the space into the metadata of a file of grids. */
void iso_blender_note_space(const iso_blender_space *space, iso_vdb_options *options);
/* How the grids of an export are written that a transfer function shows: `shown` is filled in and kept by the
 * caller. */
void iso_blender_grid_options(const iso_blender_options *opt, const iso_tf_table *tf, const iso_tf_2d *tf_2d,
                              iso_vdb_shown *shown, iso_vdb_options *options);
/* What the material needs to know of grids that are written so: eps is relative to the directions' length. */
void iso_blender_scale_directions(json_t *about, const iso_blender_options *opt, double scale);
iso_geometry iso_blender_in_space(const iso_geometry *mm, const iso_blender_space *space);

/* A copy that shares the voxels, its geometry in Blender's space. Free its levels. */
iso_status iso_blender_pyramid_in_space(const iso_pyramid *p, const iso_blender_space *space, iso_pyramid *copy,
                                        iso_error *err);

/* At most `limit` bytes, whole characters; what is not UTF-8 becomes '_'. */
json_t *iso_blender_text(const char *text, size_t limit);
/* mm: the geometry of the level, or of the whole box. */
json_t *iso_blender_describe_scene(const iso_view *view, const iso_blender_space *space, const iso_geometry *mm,
                                   const char *name, const iso_blender_options *opt);
/* The transfer function of each view, of levels from `first` on, row by row where it is 2D; then that of each region of
 * interest; and a ramp for each that differs from the others. */
json_t *iso_blender_describe_tf(const iso_view *views, size_t first, size_t count, double units);

/* A level and its grids. The paths are those that Blender sees: absolute, or relative to the .blend by a leading
 * "//". */
typedef struct blender_level {
    const iso_geometry *geometry; /* in mm */
    size_t number;
    size_t tables[2]; /* numbers of its table, and of its region's */
    const char *vdb, *roi_vdb;
} blender_level;

/* One volume object; geometry and step in Blender's space. */
json_t *iso_blender_describe_level(const iso_geometry *g, size_t k, size_t table, const char *vdb, double step);
/* The volume objects of a level: itself, and its region of interest. */
void iso_blender_append_level(json_t *levels, const blender_level *level, const iso_view *view,
                              const iso_blender_space *space, const iso_blender_options *opt);

/* Of a label map: the image of its class numbers in `folder`, where each of about's "levels" is in it, and tables by
 * class instead of by value. */
iso_status iso_blender_describe_labels(json_t *about, const iso_pyramid *p, const iso_blender_levels *levels,
                                       double units, const char *folder, iso_error *err);

/* ---- running Blender ---- */

/* A fresh folder for a scene, to be removed and freed: in that of the options' session, where its Blender may write.
 * NULL where none can be made. */
char *iso_blender_folder(const iso_blender_options *opt);

/* Runs a job description in Blender: in the session of the options, or in one that is started for it. Its files are
 * written into the folder. Takes `about`. */
iso_status iso_blender_run(json_t *about, const char *folder, const iso_blender_options *opt,
                           const iso_progress *progress, iso_error *err);
/* The seed that Cycles is given. It does not look at the last bit (the seeds 2 and 3 have the same noise), so that
 * seeds in a row are spread over all bits, by Knuth's multiplicative hash; 0 stays 0. */
int iso_blender_seed(int seed);
/* One entry a picture: what may change without building the scene again. */
json_t *iso_blender_describe_frames(double voxel, const char *folder, const iso_blender_options *frames, size_t count);
iso_status iso_blender_load_pictures(const char *folder, const iso_view *view, size_t count, iso_image *pictures,
                                     iso_error *err);

/* ISO_E_USAGE: not a path that Blender takes for a .blend. */
iso_status iso_blender_check_path(const char *blend_path, iso_error *err);
/* Reserves the .blend in *out, and puts in it what Blender saves in its folder of what `about` describes, which is
 * taken. */
iso_status iso_blender_save(json_t *about, const char *blend_path, iso_output *out, const char *folder,
                            const iso_blender_options *opt, const iso_progress *progress, iso_error *err);

#endif
