/* SPDX-License-Identifier: MIT */
/* blender.h - Blender scenes of a volume, and Cycles as a renderer.
 *
 * Blender itself makes the .blend: it runs the embedded scripts on a JSON description. The .blend has a volume object
 * with a relative path to its VDB, the TF as a packed N x 1 float image, camera and render settings. Its material uses
 * the node group "isoshade", with shading constants and lights as group inputs. Cycles renders the same scene.
 *
 * A region of interest is a second volume object, "NAME roi", with its own VDB. The two overlap, and the material
 * weighs each by its part (scene/roi.h). At the border of the second object Cycles draws a new random offset for its
 * steps, which leaves an error of first order in the step; averaging over seeds removes it.
 *
 * Before its first scene, Blender renders a tiny known volume and measures its position: versions differ by half a
 * voxel in the placement of a grid. A build with any other placement is refused: ISO_E_UNTRUSTED. */
#pragma once

#include "base/names.h"
#include "base/progress.h"
#include "brick/lattice.h"
#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* Measurements of a render inside Blender. */
typedef struct iso_cycles_stats {
    double load_seconds;   /* from the start of the first picture to its first pixels: reading grids, making textures */
    double render_seconds; /* whole render */
    double device_bytes;   /* memory as reported by Cycles at that time: textures, meshes */
    double peak_rss_bytes; /* of the process */
    char device[128];      /* device that Cycles used: "CPU", "OPTIX NVIDIA H200" */
} iso_cycles_stats;

/* A Blender that stays open for the next scene, to save its start. Pictures are the same as from a fresh Blender. A
 * Blender that fails at a scene ends, and the next scene starts a new one. */
typedef struct iso_blender_session iso_blender_session;
/* Ends a session; accepts NULL. */
void iso_blender_session_end(iso_blender_session *session);

typedef struct iso_blender_options {
    const char *program; /* path, or a name in PATH; NULL: the default of iso_process_find() */
    double step_voxels;  /* Cycles' step, in smallest spacings of the level */
    int samples;         /* 1: exactly at pixel centers; more are spread by a filter */
    int seed;
    int threads;
    bool physical;            /* for exports: material that the file opens with (iso_blender_material_names) */
    bool dense;               /* for exports: grids hold all voxels, not only visible ones (vdb/vdb.h) */
    bool half;                /* for exports: grids in half floats */
    const char *command;      /* for exports: noted in the grid files; or NULL */
    const iso_volume *volume; /* for exports: scalars of level 0 if the pyramid has none (pyramid/narrow.h); or NULL */
    iso_cycles_stats *stats;  /* filled by renders for their first picture; or NULL */
    /* For pictures: points to NULL at first; the caller ends the session. NULL: a fresh Blender per call. */
    iso_blender_session **session;
} iso_blender_options;
iso_blender_options iso_blender_defaults(void);

/* Materials of an exported file: its property "physical" is the row. */
extern const iso_names iso_blender_material_names;

/* Finds Blender; the caller frees *path. program: as in iso_blender_options. ISO_E_MISSING. */
iso_status iso_blender_find(const char *program, char **path, iso_error *err);
/* Returns Blender's version, e.g. "3.4.1"; program: as in iso_blender_options. ISO_E_MISSING: not found, or older than
 * all tested versions. ISO_E_PROGRAM: it is not Blender, or fails. */
iso_status iso_blender_version(const char *program, char *version, size_t size, iso_error *err);

/* Returns the version, and the device of Cycles. ISO_E_MISSING with the reason, if Cycles of this Blender cannot show
 * volumes or lacks the requested device. Blender 5 needs NanoVDB, which a build may lack: then a tiny volume is
 * rendered as a test. */
typedef struct iso_cycles_about {
    char version[32], device[128];
} iso_cycles_about;
iso_status iso_cycles_ask(const char *program, iso_cycles_about *about, iso_error *err);

/* Sets the device of Cycles for this process: a row of the table. The default is the environment variable
 * ISOSHADE_CYCLES_DEVICE, or else the processor. ISO_E_USAGE: no such row. If a Blender lacks the device, its start
 * fails with ISO_E_MISSING. */
extern const iso_names iso_cycles_device_names;
iso_status iso_cycles_set_device(const char *name, iso_error *err); /* NULL: the default */
iso_status iso_cycles_device(const char **name, iso_error *err);

/* Announces the grids of a .blend of levels [level, level + level_count) before it is made (base/inputs.h), and refuses
 * to overwrite other programs' files (base/stamp.h). roi: includes the grids of a region of interest. */
iso_status iso_blender_guard_grids(const char *blend_path, size_t level, size_t level_count, bool roi, bool force,
                                   iso_error *err);

/* Levels [first, first + count), with a view for each. */
typedef struct iso_blender_levels {
    size_t first, count;
    const iso_view *views; /* count; they differ only in their transfer functions */
} iso_blender_levels;

/* Writes levels to one NAME.blend, with a NAME_level_K.vdb each, or one level with a NAME.vdb; all or none. The folder
 * can be moved. A Blender unit is a millimeter, or a power of ten of it for volumes smaller than 1 mm or larger than
 * 10 m; the VDB has the same unit. ISO_E_USAGE: blend_path does not end in .blend. A property "level" of the object NAME selects the
 * visible one. Material, shading and lights are shared; the color map has the rows of each level. */
iso_status iso_blender_export_levels(const iso_pyramid *p, const iso_blender_levels *levels, const char *blend_path,
                                     const iso_blender_options *opt, const iso_progress *progress, iso_error *err);

/* Levels [level, level + level_count) of each of `count` frames of a series, all with the same grid. */
typedef struct iso_blender_sequence {
    size_t level, level_count, count;
    const iso_view *view;                                                         /* of all frames */
    iso_status (*load)(void *user, size_t frame, iso_pyramid *p, iso_error *err); /* caller destroys p */
    void *user;
    bool force; /* True to keep foreign files of these names aside; false refuses */
} iso_blender_sequence;

/* Writes one NAME.blend, and NAME_0000.vdb, NAME_0001.vdb ... for the frames, which Blender plays as a sequence: its
 * frame 1 is file 0. Several levels are files NAME_level_K_0000.vdb ..., and the property "level" selects one. Loads
 * one frame at a time. ISO_E_USAGE for label maps. */
iso_status iso_blender_export_sequence(const iso_blender_sequence *sequence, const char *blend_path,
                                       const iso_blender_options *opt, const iso_progress *progress, iso_error *err);

/* Levels [level, level + level_count) of each of `count` volumes, placed by their world coordinates. */
enum { ISO_BLENDER_VOLUME_NAME = 64 };
typedef struct iso_blender_several {
    size_t level, level_count, count;
    /* Loads volume i; the caller destroys p and view. name: the unique name of its box, also the end of its file's
     * name. */
    iso_status (*load)(void *user, size_t i, iso_pyramid *p, iso_view *view, char name[ISO_BLENDER_VOLUME_NAME],
                       iso_error *err);
    void *user;
    bool force; /* as above */
} iso_blender_several;

/* Writes one NAME.blend with, per volume, a NAME_volume.vdb (of several levels NAME_volume_level_K.vdb), a box with the
 * properties "show" and "level", a material and a collection.
 * Camera, lights and background are the first volume's; so is the step if opt->step_voxels is 0. Loads one volume at a
 * time. Overlapping volumes add emission and extinction. */
iso_status iso_blender_export_several(const iso_blender_several *several, const char *blend_path,
                                      const iso_blender_options *opt, const iso_progress *progress, iso_error *err);

/* Renders a level with Cycles, including the background, like iso_reference_render. */
iso_status iso_cycles_render(const iso_pyramid *p, size_t level, const iso_view *view, const iso_blender_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err);

/* Pictures of one scene with different options. */
typedef struct iso_blender_frames {
    const iso_blender_options *options; /* count; threads: the first one's */
    size_t count;
    iso_image *pictures; /* count; created by the call */
} iso_blender_frames;

/* Renders several pictures of one scene with one run of Blender, which is started, calibrated and given its grids once:
 * pictures[i] equals iso_cycles_render() with options[i]. Creates all or none. */
iso_status iso_cycles_render_frames(const iso_pyramid *p, size_t level, const iso_view *view,
                                    const iso_blender_frames *frames, const iso_progress *progress, iso_error *err);

/* A planned volume (brick/lattice.h): one lattice with all bricks merged, made with whole_box. With a volume object per
 * level Cycles would evaluate all materials at each step, because the objects overlap. */
typedef struct iso_blender_plan {
    const iso_geometry *geometry; /* of level 0 */
    const iso_lattice *lattice;
    const char *source; /* source of the volume */
    const char *unit;   /* unit of its file's lengths; NULL or "": no name */
} iso_blender_plan;

/* Writes NAME.blend, and NAME.vdb next to it. step_voxels: in voxels of level 0. */
iso_status iso_blender_export_plan(const iso_blender_plan *plan, const iso_view *view, const char *blend_path,
                                   const iso_blender_options *opt, const iso_progress *progress, iso_error *err);
iso_status iso_cycles_render_plan(const iso_blender_plan *plan, const iso_view *view, const iso_blender_options *opt,
                                  iso_image *image, const iso_progress *progress, iso_error *err);

/* The TF as Blender's ColorRamp, for manual edits: at most 32 stops, which Cycles bakes to 256 or 257 entries. The
 * .blend has one for each different TF in the group "isoshade ramp", next to the exact image.
 *
 * Alpha is the opacity of unit_mm, as in a TF file; nodes after the ramp compute extinction = -ln(1 - alpha) / unit_mm.
 * So the stops are the TF's own points, if there are at most 32. Other TFs get the fewest stops that keep color and
 * opacity within 1/1024, or the best 32. The ramp spans the values between which the TF changes, or the table's range
 * if that is more accurate. */
#define ISO_RAMP_MAX_STOPS 32
typedef struct iso_color_ramp {
    size_t count;
    bool own_points;                     /* True if the stops are the TF's points */
    double lo, hi;                       /* values of positions 0 and 1 */
    double unit_mm;                      /* length for which alpha is the opacity */
    double position[ISO_RAMP_MAX_STOPS]; /* single precision, ascending without equals */
    double rgba[ISO_RAMP_MAX_STOPS][4];  /* linear color, opacity */
    /* Largest differences at the table's entries over both bakings: color (of entries with an opacity of at least
     * 1/1024) and opacity of unit_mm, both relative to 1, and extinction relative to the largest one. */
    double color_loss, opacity_loss, extinction_loss;
    double worst_value; /* value of the largest difference in color or opacity */
    double off;         /* share of entries with a difference in color or opacity above 1/255 */
} iso_color_ramp;
void iso_color_ramp_fit(const iso_tf_table *table, iso_color_ramp *ramp);
