/* SPDX-License-Identifier: MIT */
/* viewer.h - a pyramid and a scene as one page that a browser opens: no network, no server, no other file.
 *
 * The page draws with WebGL2, by the shaders of the ray caster itself (render/gl/shaders); what GLSL ES lacks is in
 * es.glsl. Its data are what the pyramid has: the scalar of a level as it is stored where that is an integer of at most 16
 * bits, else in 16 bits over the level's range, or in floats; the three bytes of each direction; joint histograms, so that a
 * transfer function that is changed in the page is adapted there. The coarsest level stands first, so that it is drawn
 * while the finer ones are still read. */
#ifndef ISO_VIEW_VIEWER_H
#define ISO_VIEW_VIEWER_H

#include "base/progress.h"
#include "brick/bricks.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

enum { ISO_VIEWER_CODES = 8 };
/* Of the finest level of a page: half a gigabyte of textures, which graphics cards and telephones hold. */
#define ISO_VIEWER_MOST_VOXELS 32e6
/* The finest level of at most so many voxels, or the coarsest. */
size_t iso_viewer_finest_level(const iso_pyramid *p, double most_voxels);

/* Level 0 in bricks, each at the level that a plan has for it: for volumes that are too large for a page. */
typedef struct iso_viewer_plan {
    const char *name; /* of the plan's file */
    const iso_node_levels *nodes;
    const uint8_t *levels, *drawn; /* one byte a brick; drawn 0: left out */
    double predicted_rmse, measured_rmse; /* of the pictures of its views, against level 0; NaN: not told */
} iso_viewer_plan;

typedef struct iso_viewer {
    const iso_pyramid *pyramid;
    const iso_scene *scene;
    const char *title;       /* the volume's name */
    const char *input;       /* options by which its file was read, as a command line has them: " --frame 3"; NULL: none */
    const char *folder;      /* of the pyramid on disk, which keeps joint histograms; or NULL */
    size_t first, last;      /* levels that go in: the finest and the coarsest */
    size_t code_count;       /* codes that go in; those that are not the pyramid's need its floats */
    iso_code codes[ISO_VIEWER_CODES];
    const iso_viewer_plan *plan; /* stands for level 0, beside levels first to last; or NULL */
    bool floats;             /* no quantization of what is stored in floats */
    bool errors;             /* say of each coarse level how far it is from level 0; else of the finest alone */
    bool adapted;            /* the page begins with adapted transfer functions */
    int threads;
} iso_viewer;

/* What a page is made of. */
typedef struct iso_viewer_size {
    size_t page_bytes;   /* the file */
    size_t data_bytes;   /* of them the volume's, as the page carries them */
    size_t voxel_bytes;  /* the same data before they are packed */
    size_t plan_bricks, plan_texels; /* of the plan: drawn, and of the texture that holds them */
    double quantum;      /* the largest step that a scalar was rounded to, as a part of its level's range; 0: none was */
} iso_viewer_size;

/* Of a side of the texture that holds a plan's bricks: what WebGL2's graphics cards take. */
enum { ISO_VIEWER_MOST_TEXELS = 2048 };

/* ISO_E_USAGE: a code that the pyramid cannot make; ISO_E_RANGE: a plan whose bricks are too many for a texture; ISO_E_IO, ISO_E_MEMORY. */
iso_status iso_viewer_save(const iso_viewer *v, const char *path, const iso_progress *progress, iso_viewer_size *size,
                           iso_error *err);

#endif
