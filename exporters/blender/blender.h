/* SPDX-License-Identifier: MIT */
/* blender.h - Blender scenes of a volume, and Cycles as a renderer.
 *
 * The .blend is made by Blender itself, running the embedded scripts on
 * a JSON description: a volume object with a relative path to its VDB, the TF as
 * a packed N x 1 float image, the material as a node group "isoshade" with the
 * shading constants and the lights as group inputs, camera and render settings.
 * Cycles renders the same scene.
 *
 * A region of interest is a second volume object, "NAME roi", with a VDB of its own:
 * the two overlap, and the material weighs each by its part (scene/roi.h). Where a
 * ray enters or leaves the second object Cycles draws a new random offset for its steps,
 * which leaves an error of first order in the step; averaging over seeds removes it.
 *
 * Before its first scene Blender renders a tiny known volume and looks where it is:
 * versions differ by half a voxel in where they put a grid. A build that puts it
 * anywhere else is refused: ISO_E_UNTRUSTED. */
#ifndef ISO_EXPORT_BLENDER_H
#define ISO_EXPORT_BLENDER_H

#include "base/names.h"
#include "base/progress.h"
#include "brick/lattice.h"
#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* Measurements of a render inside Blender. */
typedef struct iso_cycles_stats {
    double load_seconds;   /* from the start of the first picture until its pixels begin: grids read, textures made */
    double render_seconds; /* all of it */
    double device_bytes;   /* what Cycles says that it holds then: textures, meshes */
    double peak_rss_bytes; /* of the process */
    char device[128];      /* what Cycles rendered on: "CPU", "OPTIX NVIDIA H200" */
} iso_cycles_stats;

/* A Blender that stays for the next scene, which spares its start. Pictures are those of a Blender of their own, and
 * one that fails at a scene ends: the next scene has a new one. */
typedef struct iso_blender_session iso_blender_session;
/* NULL: nothing to do. */
void iso_blender_session_end(iso_blender_session *session);

typedef struct iso_blender_options {
    const char *program; /* a path of Blender, or a name that PATH finds; NULL: as iso_process_find() finds blender */
    double step_voxels; /* Cycles' step in the level's smallest spacing */
    int samples;        /* 1 goes exactly through the pixel centers; more are spread by a filter */
    int seed;
    int threads;
    bool physical; /* of exports: which material a file opens with (iso_blender_material_names) */
    bool dense;          /* of exports: grids hold all voxels, not only what the transfer functions show (vdb/vdb.h) */
    bool half;           /* of exports: grids in half floats */
    const char *command; /* of exports: noted in the grids' files; or NULL */
    const iso_volume *volume; /* of exports: level 0's scalars where the pyramid has none (pyramid/narrow.h); or NULL */
    iso_cycles_stats *stats; /* filled by renders, for their first picture; or NULL */
    iso_blender_session *
        *session; /* for pictures: NULL at first, to be ended by the caller; or NULL: a Blender of its own */
} iso_blender_options;
iso_blender_options iso_blender_defaults(void);

/* The materials of an exported file: its property "physical" is the row. */
extern const iso_names iso_blender_material_names;

/* program: as in iso_blender_options. To be freed. ISO_E_MISSING. */
iso_status iso_blender_find(const char *program, char **path, iso_error *err);
/* Version of a Blender (program: as in the options), such as "3.4.1". ISO_E_MISSING: it is not there, or older than any
 * that was tried. ISO_E_PROGRAM: it is not Blender, or fails. */
iso_status iso_blender_version(const char *program, char *version, size_t size, iso_error *err);

/* The same, and what Cycles renders on, when Cycles of this Blender shows volumes and has the device that is asked for:
 * ISO_E_MISSING with the reason when it does not. Blender 5 needs NanoVDB, which a build may lack: there a tiny volume
 * is rendered to see. */
typedef struct iso_cycles_about {
    char version[32], device[128];
} iso_cycles_about;
iso_status iso_cycles_ask(const char *program, iso_cycles_about *about, iso_error *err);

/* What Cycles renders on, in this process: a row of the table. Else the environment variable ISOSHADE_CYCLES_DEVICE
 * says it, else it is the processor. ISO_E_USAGE: no such row. A device that a Blender lacks is ISO_E_MISSING when it
 * starts. */
extern const iso_names iso_cycles_device_names;
iso_status iso_cycles_set_device(const char *name, iso_error *err); /* NULL: as nobody had said it */
iso_status iso_cycles_device(const char **name, iso_error *err);

/* Before work that writes a .blend of levels [level, level + level_count): its grids are announced (base/inputs.h), and
 * refused where files by their names are not isoshade's (base/stamp.h). roi: those of a region of interest, too. */
iso_status iso_blender_guard_grids(const char *blend_path, size_t level, size_t level_count, bool roi, bool force,
                                   iso_error *err);

/* NAME.blend and NAME.vdb beside it; both or none. The folder can be moved. A
 * Blender unit is a millimeter, or a power of ten of it where the volume is
 * smaller than 1 mm or larger than 10 m; the VDB is in the same unit.
 * ISO_E_USAGE when blend_path does not end in .blend. */
iso_status iso_blender_export(const iso_pyramid *p, size_t level, const iso_view *view, const char *blend_path,
                              const iso_blender_options *opt, const iso_progress *progress, iso_error *err);

/* Levels [first, first + count), each with its view. */
typedef struct iso_blender_levels {
    size_t first, count;
    const iso_view *views; /* count; they differ in their transfer functions alone */
} iso_blender_levels;

/* Levels in one NAME.blend, with a NAME_level_K.vdb each.
 * A property "level" of the object NAME chooses the one that is seen; material,
 * shading and lights are shared, and the color map has the rows of each level. */
iso_status iso_blender_export_levels(const iso_pyramid *p, const iso_blender_levels *levels, const char *blend_path,
                                     const iso_blender_options *opt, const iso_progress *progress, iso_error *err);

/* A level of each frame of a series, all on one grid. */
typedef struct iso_blender_sequence {
    size_t level, count;
    const iso_view *view;                                                         /* of all frames */
    iso_status (*load)(void *user, size_t frame, iso_pyramid *p, iso_error *err); /* to be destroyed */
    void *user;
    bool force; /* files of such names that are not isoshade's are kept aside; else refused */
} iso_blender_sequence;

/* One NAME.blend and a NAME_0000.vdb, NAME_0001.vdb ... for each frame, which Blender plays as a sequence: its frame 1
 * is the file of number 0. Frames are loaded one after the other. ISO_E_USAGE for label maps. */
iso_status iso_blender_export_sequence(const iso_blender_sequence *sequence, const char *blend_path,
                                       const iso_blender_options *opt, const iso_progress *progress, iso_error *err);

/* A level of each of several volumes, which stand where their coordinates say. */
enum { ISO_BLENDER_VOLUME_NAME = 64 };
typedef struct iso_blender_several {
    size_t level, count;
    /* To be destroyed, both. name: of its box, and what its file's name ends in; no two are alike. */
    iso_status (*load)(void *user, size_t i, iso_pyramid *p, iso_view *view, char name[ISO_BLENDER_VOLUME_NAME],
                       iso_error *err);
    void *user;
    bool force; /* as above */
} iso_blender_several;

/* opt->step_voxels 0: the first view's. One NAME.blend with a NAME_volume.vdb, a box, a material and a collection for
 * each, a property "show" of each box, and camera, lights and background of the first. Volumes are loaded one after the
 * other. Where they overlap their emission and their extinction add up. */
iso_status iso_blender_export_several(const iso_blender_several *several, const char *blend_path,
                                      const iso_blender_options *opt, const iso_progress *progress, iso_error *err);

/* Renders a level with Cycles: background included as in iso_reference_render. */
iso_status iso_cycles_render(const iso_pyramid *p, size_t level, const iso_view *view, const iso_blender_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err);

/* Pictures of one scene that differ in their options. */
typedef struct iso_blender_frames {
    const iso_blender_options *options; /* count; threads: of the first */
    size_t count;
    iso_image *pictures; /* count, to be created */
} iso_blender_frames;

/* Several pictures of one scene by one run of Blender, which is started, calibrated and given its grids once:
 * pictures[i] is what iso_cycles_render() gives with options[i]. All or none are created. */
iso_status iso_cycles_render_frames(const iso_pyramid *p, size_t level, const iso_view *view,
                                    const iso_blender_frames *frames, const iso_progress *progress, iso_error *err);

/* A planned volume (brick/lattice.h): one lattice, in which all bricks are merged. Of a volume object a level, which
 * overlap, Cycles evaluates all materials at each step. The lattice has to be made with whole_box. */
typedef struct iso_blender_plan {
    const iso_geometry *geometry; /* of level 0 */
    const iso_lattice *lattice;
    const char *source; /* source of the volume */
    const char *unit;   /* of the lengths of its file; NULL or "": not named */
} iso_blender_plan;

/* NAME.blend and NAME.vdb beside it. step_voxels: of level 0. */
iso_status iso_blender_export_plan(const iso_blender_plan *plan, const iso_view *view, const char *blend_path,
                                   const iso_blender_options *opt, const iso_progress *progress, iso_error *err);
iso_status iso_cycles_render_plan(const iso_blender_plan *plan, const iso_view *view, const iso_blender_options *opt,
                                  iso_image *image, const iso_progress *progress, iso_error *err);

/* The TF as Blender's ColorRamp, to be edited by hand: at most 32 stops, which Cycles bakes to 256 or 257 entries. The
 * .blend carries one for each different TF in the group "isoshade ramp", beside the exact image.
 *
 * Alpha is the opacity of unit_mm, as in a TF file; nodes behind the ramp make extinction = -ln(1 - alpha) / unit_mm of
 * it. So a TF's own points are the stops where there are at most 32. Others get the fewest stops that keep color and
 * opacity within 1/1024, or within more where 32 do not suffice. The ramp spans the values between which the TF
 * changes, or the table's range where that loses less. */
#define ISO_RAMP_MAX_STOPS 32
typedef struct iso_color_ramp {
    size_t count;
    bool own_points;                     /* the stops are the TF's points */
    double lo, hi;                       /* values of positions 0 and 1 */
    double unit_mm;                      /* that alpha is the opacity of */
    double position[ISO_RAMP_MAX_STOPS]; /* single precision, ascending without equals */
    double rgba[ISO_RAMP_MAX_STOPS][4];  /* linear color, opacity */
    /* The largest differences from the table after either baking, at its entries: color (of entries of an opacity of at
     * least 1/1024), opacity of unit_mm, both of 1, and extinction as a part of the largest one. */
    double color_loss, opacity_loss, extinction_loss;
    double worst_value; /* where color or opacity differ most */
    double off;         /* share of the entries where color or opacity differ by more than 1/255 */
} iso_color_ramp;
void iso_color_ramp_fit(const iso_tf_table *table, iso_color_ramp *ramp);

#endif
