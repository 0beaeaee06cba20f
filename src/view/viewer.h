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
#include "pyramid/pyramid.h"
#include "scene/scene.h"

enum { ISO_VIEWER_CODES = 8 };
/* Of the finest level of a page: half a gigabyte of textures, which graphics cards and telephones hold. */
#define ISO_VIEWER_MOST_VOXELS 32e6
/* The finest level of at most so many voxels, or the coarsest. */
size_t iso_viewer_finest_level(const iso_pyramid *p, double most_voxels);

typedef struct iso_viewer {
    const iso_pyramid *pyramid;
    const iso_scene *scene;
    const char *title;       /* the volume's name */
    const char *folder;      /* of the pyramid on disk, which keeps joint histograms; or NULL */
    size_t first, last;      /* levels that go in: the finest and the coarsest */
    size_t code_count;       /* codes that go in; those that are not the pyramid's need its floats */
    iso_code codes[ISO_VIEWER_CODES];
    bool floats;             /* no quantisation of what is stored in floats */
    bool errors;             /* say of each coarse level how far it is from level 0; else of the finest alone */
    bool adapted;            /* the page begins with adapted transfer functions */
    int threads;
} iso_viewer;

/* What a page is made of. */
typedef struct iso_viewer_size {
    size_t page_bytes;   /* the file */
    size_t data_bytes;   /* of them the volume's, as the page carries them */
    size_t voxel_bytes;  /* the same data before they are packed */
    double quantum;      /* the largest step that a scalar was rounded to, as a part of its level's range; 0: none was */
} iso_viewer_size;

/* ISO_E_USAGE: a code that the pyramid cannot make; ISO_E_IO, ISO_E_MEMORY. */
iso_status iso_viewer_save(const iso_viewer *v, const char *path, const iso_progress *progress, iso_viewer_size *size,
                           iso_error *err);

#endif
