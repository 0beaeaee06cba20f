/* SPDX-License-Identifier: MIT */
/* targets.h - the table of export targets: one row and one file each.
 *
 * A target's file, exporters/targets/target_NAME.c, defines iso_export_target_NAME, which targets.c lists;
 * doc/extending.md explains. The row lists the options that the target supports: others are refused, since they would
 * have no effect. */
#pragma once

#include <stdio.h>

#include "bake/grids.h"
#include "base/names.h"
#include "image/image.h"
#include "plan/planned.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* clang-format off */
#define ISO_EXPORT_TARGET_LIST(X) \
    X(vdb)                        \
    X(nanovdb)                    \
    X(blender)                    \
    X(povray)                     \
    X(pbrt)                       \
    X(paraview)
/* clang-format on */

/* enum, option that only some targets take */
/* clang-format off */
#define ISO_EXPORT_OPTION_LIST(X)             \
    X(ISO_EXPORT_LEVELS, "--levels")          \
    X(ISO_EXPORT_STEP, "--step")              \
    X(ISO_EXPORT_HALF, "--half")              \
    X(ISO_EXPORT_ISOSURFACE, "--isosurface")  \
    X(ISO_EXPORT_SCENE, "--scene")            \
    X(ISO_EXPORT_SIZE, "--size")              \
    X(ISO_EXPORT_ROI, "--roi")                \
    X(ISO_EXPORT_ADAPT, "--adapt")            \
    X(ISO_EXPORT_EXTINCTION_SCALE, "--extinction-scale") \
    X(ISO_EXPORT_GRIDS, "--grids")            \
    X(ISO_EXPORT_BAKE, "--bake and --for")    \
    X(ISO_EXPORT_MATERIAL, "--material")      \
    X(ISO_EXPORT_DENSE, "--dense")            \
    X(ISO_EXPORT_SHOWN, "--scene and --tf")   \
    X(ISO_EXPORT_BACKGROUND, "--background") \
    X(ISO_EXPORT_PLAN, "--plan")              \
    X(ISO_EXPORT_LATTICE, "--points and --supersample") /* without --bake: the target always bakes */
/* clang-format on */

typedef enum iso_export_option {
#define ISO_EXPORT_OPTION_ENUM(option, text) option,
    ISO_EXPORT_OPTION_LIST(ISO_EXPORT_OPTION_ENUM)
#undef ISO_EXPORT_OPTION_ENUM
        ISO_EXPORT_OPTION_COUNT
} iso_export_option;

/* An export to be written. */
typedef struct iso_export_job {
    const iso_pyramid *pyramid;
    const iso_volume *volume;  /* for narrow targets: scalars of level 0 if the pyramid has none; or NULL */
    size_t level, level_count; /* number of levels, from `level` on */
    const char *output;
    iso_view *view; /* for targets that take a scene, with a plan and with an extinction scale: the scene's own transfer
               * function */
    const iso_planned *planned; /* bricks of a plan; NULL: whole levels */
    bool merged;                /* True if a plan is written as one grid, otherwise one per level */
    double step_voxels;         /* 0: the scene's */
    bool half_float;
    bool nanovdb;                 /* for the target vdb: True to write a NanoVDB file */
    iso_bake_options lattice;     /* for targets with ISO_EXPORT_LATTICE; points 0: default */
    const iso_bake_request *bake; /* for targets that bake: requested grids, or NULL; with it `view` is the scene's */
    bool physical;                /* True if the file opens with the physical material (exporters/blender/blender.h) */
    bool is_shown; /* for targets with ISO_EXPORT_SHOWN: True if the user gave the views of view_of_level */
    bool dense;    /* True to store all voxels */
    bool force;   /* True if a foreign file next to the output is kept aside; otherwise it ends the export */
    const double *background; /* value of voxels that grids omit; NULL: chosen automatically, or none are omitted */
    const char *command;      /* noted in files, without folders */
    bool isosurface;
    double iso;
    int threads;
    const iso_progress *progress;
    /* Makes the view of a level with the user's options: a copy with its own table, which the caller destroys. */
    iso_status (*view_of_level)(const struct iso_export_job *job, size_t level, iso_view *view, iso_error *err);
    /* Frames of a series, for write_frames: their number, and a function that loads one; the caller destroys it. */
    size_t frame_count;
    iso_status (*load_frame)(void *user, size_t frame, iso_pyramid *p, iso_error *err);
    void *frame_user;
    /* Several volumes, for write_volumes: their number, and a function that loads one with its view, which the caller
     * destroys, and its name of up to 63 bytes. */
    size_t volume_count;
    iso_status (*load_volume)(void *user, size_t i, iso_pyramid *p, iso_view *view, char name[64], iso_error *err);
    void *volume_user;
    const void *user;
    json_t *results; /* results by keys; or NULL */
    FILE *notes;     /* results as lines of text; or NULL */
} iso_export_job;

typedef struct iso_export_target {
    const char *name;      /* "vdb" */
    const char *title;     /* "OpenVDB" */
    const char *summary;   /* contents of the output */
    const char *baked;     /* contents of the output if baking is requested; or NULL */
    const char *output;    /* form of -o: "NAME.vdb" */
    unsigned options;      /* of ISO_EXPORT_TAKES(option) */
    const char *stages[4]; /* stages of progress in order (base/progress.h), the last one longest; or none */
    iso_status (*write)(const iso_export_job *job, iso_error *err);
    /* Writes all frames of a series to one output, by job->load_frame; job->pyramid is NULL. If NULL, `write` makes one
     * output per frame, whose name ends in its number and `suffix`. */
    iso_status (*write_frames)(const iso_export_job *job, iso_error *err);
    const char *suffix;
    /* Writes several volumes to one output, by job->load_volume; job->pyramid is NULL. NULL: not supported. */
    iso_status (*write_volumes)(const iso_export_job *job, iso_error *err);

    /* Opens the output in its program, as the target's page describes, and loads the picture that it renders: colors
     * over the background, linear light. NULL: no program to start. */
    iso_status (*open)(const char *output, iso_image *picture, iso_error *err);
    const char *renderer; /* name in the table of renderers */
    bool narrow;          /* True if a single level may have its scalars in job.volume only (pyramid/narrow.h) */
    bool stamped;         /* True if people edit the output: it ends in a stamp (base/stamp.h), and an edited one is not
                   * overwritten */
    /* Called before the work: announces files written next to the output (base/inputs.h), and refuses to overwrite
     * other programs' files (base/stamp.h). roi: includes those of a region of interest. NULL: no such files. */
    iso_status (*guard)(const char *output, size_t level, size_t level_count, bool roi, bool force, iso_error *err);
    const char *example; /* example of -o */
    /* Samples of a ray in the output for a given step: intervals per piece, and planes between pieces. NULL: the output
     * stores the step itself. */
    void (*samples)(const iso_geometry *level, const iso_view *view, double step_voxels, size_t *intervals,
                    size_t *planes);
    bool clipped;    /* True if the picture's file clips to 0 to 1 */
    double limit;    /* limit of the RMSE to a picture of the same samples */
    const char *why; /* reason for this limit */
} iso_export_target;

#define ISO_EXPORT_TAKES(option) (1u << (option))

extern const iso_names iso_export_target_names;
const iso_export_target *iso_export_target_at(size_t row);
static inline bool iso_export_takes(const iso_export_target *t, iso_export_option option)
{
    return t->options & ISO_EXPORT_TAKES(option);
}
const char *iso_export_option_text(iso_export_option option);
