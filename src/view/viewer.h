/* SPDX-License-Identifier: MIT */
/* viewer.h - a pyramid and a scene as one page for a browser, without network, server or other files.
 *
 * The page draws with WebGL2 and the shaders of the ray caster itself (render/gl/shaders); es.glsl adds the functions
 * that GLSL ES lacks. Its data are those of the pyramid: scalars as stored if they are integers of at most 16 bits,
 * otherwise as 16 bits over the level's range, or as floats; the three bytes of each direction; and joint histograms,
 * with which the page adapts edited transfer functions. The coarsest level comes first, so that it is drawn while finer
 * ones are read. */
#pragma once

#include "base/progress.h"
#include "brick/bricks.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

enum { ISO_VIEWER_CODES = 8 };
/* For the finest level of a page: half a gigabyte of textures, which graphics cards and phones hold. */
#define ISO_VIEWER_MOST_VOXELS 32e6
/* Returns the finest level with at most `most_voxels` voxels, or the coarsest. */
size_t iso_viewer_finest_level(const iso_pyramid *p, double most_voxels);

/* Level 0 in bricks at the levels of a plan: for volumes that are too large for a page. */
typedef struct iso_viewer_plan {
    const char *name; /* of the plan's file */
    const iso_node_levels *nodes;
    const uint8_t *levels, *drawn; /* one byte per brick; drawn 0: left out */
    double predicted_rmse, measured_rmse; /* RMSE of the pictures of its views against level 0; NaN: unknown */
} iso_viewer_plan;

typedef struct iso_viewer {
    const iso_pyramid *pyramid;
    const iso_scene *scene;
    const char *title;       /* name of the volume */
    const char *input;       /* its file and the options that read it, as on a command line: "a.nii --frame 3" */
    const char *value_unit;  /* of values, "HU"; or NULL */
    const char *folder;      /* of the pyramid on disk, which keeps joint histograms; or NULL */
    size_t first, last;      /* finest and coarsest level of the page */
    size_t code_count;       /* codes of the page; those other than the pyramid's need its floats */
    iso_code codes[ISO_VIEWER_CODES];
    const iso_viewer_plan *plan; /* replaces level 0, next to levels first to last; or NULL */
    const iso_level *overlay;    /* second volume in the same picture; or NULL */
    const char *overlay_title;
    bool floats;             /* True to keep floats without quantization */
    bool errors;             /* True to add the error of each coarse level against level 0; false: of the finest only */
    bool compact;            /* True if the page starts with the picture alone, its panel one button away */
    bool adapted;            /* True if the page starts with adapted transfer functions */
    int threads;
} iso_viewer;

/* Sizes of a page. */
typedef struct iso_viewer_size {
    size_t page_bytes;   /* the file */
    size_t data_bytes;   /* the volume's part, as stored in the page */
    size_t voxel_bytes;  /* the same before packing */
    size_t plan_bricks, plan_texels; /* of the plan: bricks drawn, texels of their texture */
    double quantum;      /* largest rounding step of a scalar, as a part of its level's range; 0: none */
} iso_viewer_size;

/* Limit of WebGL2 graphics cards for a side of a plan's texture. */
enum { ISO_VIEWER_MOST_TEXELS = 2048 };

/* Writes the page. ISO_E_USAGE: a code that the pyramid cannot make. ISO_E_RANGE: too many bricks for a texture.
 * ISO_E_IO, ISO_E_MEMORY. */
iso_status iso_viewer_save(const iso_viewer *v, const char *path, const iso_progress *progress, iso_viewer_size *size,
                           iso_error *err);
