/* SPDX-License-Identifier: MIT */
/* request.h - a rendering request as files that any language reads: doc/reference/files-request.md.
 *
 *     DIR/request.json       scene, camera, lights, transfer function, the frames to write; names files beside it
 *         volume.nrrd        the level's values, float, x fastest
 *         directions.nrrd    its directions in the world, three floats a voxel; where a light can be seen alone
 *
 * Whoever evaluates the integral of doc/guide/judging-a-renderer.md, "The integral", on it draws the same picture. */
#ifndef ISO_RENDERERS_REQUEST_H
#define ISO_RENDERERS_REQUEST_H

#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* One picture that is asked for. */
typedef struct iso_request_frame {
    double step_voxels; /* of the ray, in the level's smallest spacing; 0: the view's */
    int samples, seed;  /* a pixel, and of random numbers: of renderers that have them */
    const char *file;   /* an OpenEXR picture, its name in the folder */
} iso_request_frame;

typedef struct iso_request {
    const char *scene; /* a name for people; NULL: none */
    const iso_pyramid *pyramid;
    size_t level;
    const iso_view *view;
    const iso_request_frame *frames;
    size_t frame_count;
    int threads; /* 0: all cores */
} iso_request;

/* Key of "volume" and "directions": a checksum of the values, for a folder whose files were left out. */
#define ISO_REQUEST_CHECKSUM "xxh3_64"

/* Writes the three files into a folder that is there. ISO_E_USAGE where the view has what the format does not: a 2D transfer
 * function, extinction scales, a region of interest. ISO_E_IO, ISO_E_MEMORY. */
iso_status iso_request_write(const iso_request *request, const char *dir, iso_error *err);

#endif
