/* SPDX-License-Identifier: MIT */
/* targets.h - the table of programs that a volume is exported to: a row and a file each.
 *
 * A target's file, exporters/targets/target_NAME.c, defines iso_export_target_NAME
 * and is listed below; doc/extending.md explains. The row says which options
 * have a meaning for it: others are refused, since they would change nothing. */
#ifndef ISO_TARGETS_H
#define ISO_TARGETS_H

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
    X(mitsuba)                    \
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
    X(ISO_EXPORT_LATTICE, "--points and --supersample") /* without --bake: what is written is baked always */
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
    const iso_volume *volume; /* of a narrow target: level 0's scalars if the pyramid has none; otherwise NULL */
    size_t level, level_count; /* levels from `level` on */
    const char *output;
    iso_view *
        view; /* of a target that takes a scene, with a plan and with an extinction scale: it has the scene's own transfer function */
    const iso_planned *planned; /* bricks of a plan, or NULL: whole levels */
    bool merged;                /* True if a plan is written as one grid, otherwise one per level */
    double step_voxels;         /* 0: the scene's */
    bool half_float;
    bool float_directions;    /* True if directions are not stored in half floats, for any omitted part */
    iso_bake_options lattice; /* of a target that takes ISO_EXPORT_LATTICE; points 0: as is usual */
    const iso_bake_request
        *bake;     /* of a target that bakes: the grids that are asked for, or NULL; then `view` is the scene's */
    bool physical; /* the material that the file opens with (exporters/blender/blender.h) */
    bool
        is_shown; /* of a target that takes ISO_EXPORT_SHOWN: the views that view_of_level makes are what the user gave */
    bool dense;   /* grids hold all voxels */
    bool force;   /* True if a foreign file next to the output is kept aside; otherwise it ends the export */
    const double *background; /* the value that stands for what grids leave out; NULL: chosen, or none is left out */
    const char *command;      /* to be noted in files: without folders */
    bool extinction_scale;    /* the views that view_of_level makes have one (fit/extinction_scale.h) */
    bool isosurface;
    double iso;
    int threads;
    const iso_progress *progress;
    /* The view of a level, with what the user asked for in it: a copy that owns its table, to be destroyed. */
    iso_status (*view_of_level)(const struct iso_export_job *job, size_t level, iso_view *view, iso_error *err);
    /* The frames of a series, of write_frames: how many, and one of them, which is to be destroyed. */
    size_t frame_count;
    iso_status (*load_frame)(void *user, size_t frame, iso_pyramid *p, iso_error *err);
    void *frame_user;
    /* Several volumes, of write_volumes: how many, and one of them with its view, to be destroyed; its name, 63
     * bytes. */
    size_t volume_count;
    iso_status (*load_volume)(void *user, size_t i, iso_pyramid *p, iso_view *view, char name[64], iso_error *err);
    void *volume_user;
    const void *user;
    json_t *results; /* results of the target, by keys, or NULL; */
    FILE *notes;     /* or the same for people, in lines, or NULL */
} iso_export_job;

typedef struct iso_export_target {
    const char *name;      /* "vdb" */
    const char *title;     /* "OpenVDB" */
    const char *summary;   /* contents of the output */
    const char *baked;     /* the same for a target that bakes, if baking is requested; or NULL */
    const char *output;    /* what -o names: "NAME.vdb" */
    unsigned options;      /* of ISO_EXPORT_TAKES(option) */
    const char *stages[4]; /* that writing reports (base/progress.h), in order; the last takes longest; or none */
    iso_status (*write)(const iso_export_job *job, iso_error *err);
    /* All frames of a series in one output, by job->load_frame; job->pyramid is NULL. NULL: an output a frame, by
     * write, whose names end in `suffix` behind the number. */
    iso_status (*write_frames)(const iso_export_job *job, iso_error *err);
    const char *suffix;
    /* Several volumes in one output, by job->load_volume; job->pyramid is NULL. NULL: there is no such thing. */
    iso_status (*write_volumes)(const iso_export_job *job, iso_error *err);

    /* What a person sees of it. open starts the program anew on what was written, as the target's page tells a person
     * to, and reads the picture that it leaves: colors with the background, in linear light. NULL: nothing to start. */
    iso_status (*open)(const char *output, iso_image *picture, iso_error *err);
    const char *renderer; /* its name among the renderers */
    bool narrow;  /* where a level is written by itself, level 0's scalars may be in job.volume alone (pyramid/narrow.h) */
    bool stamped; /* people edit the output: it ends in a stamp (base/stamp.h), and is not overwritten when changed */
    /* Before work: announces files that are written beside the output (base/inputs.h), and refuses where they are not
     * ours (base/stamp.h). roi: of a region of interest, too. NULL: there are none. */
    iso_status (*guard)(const char *output, size_t level, size_t level_count, bool roi, bool force, iso_error *err);
    const char *example; /* what -o may be called */
    /* The samples of a ray in what is written with this step: intervals in each piece, and the planes between pieces.
     * NULL: it has steps. */
    void (*samples)(const iso_geometry *level, const iso_view *view, double step_voxels, size_t *intervals,
                    size_t *planes);
    bool clipped;    /* the picture's file holds 0 to 1 */
    double limit;    /* RMSE to a picture of the same samples */
    const char *why; /* the cause of it */
} iso_export_target;

#define ISO_EXPORT_TAKES(option) (1u << (option))

extern const iso_names iso_export_target_names;
const iso_export_target *iso_export_target_at(size_t row);
static inline bool iso_export_takes(const iso_export_target *t, iso_export_option option)
{
    return t->options & ISO_EXPORT_TAKES(option);
}
const char *iso_export_option_text(iso_export_option option);


#endif
