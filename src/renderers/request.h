/* SPDX-License-Identifier: MIT */
/* request.h - a rendering request as files that any language reads: doc/reference/files-request.md.
 *
 *     DIR/request.json       scene, camera, lights, transfer function, the frames to write; names of the other files
 *         volume.nrrd        the level's values, float, x fastest
 *         directions.nrrd    its directions in the world, 3 floats per voxel; only if lights have an effect
 *
 * A program that evaluates the integral of doc/guide/judging-a-renderer.md, "The integral", draws the same picture. */
#pragma once

#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* One requested picture. */
typedef struct iso_request_frame {
    double step_voxels; /* of the ray, in the level's smallest spacing; 0: the view's */
    int samples, seed;  /* samples per pixel, and of random numbers: of renderers that use them */
    const char *file;   /* name of an OpenEXR picture in the folder */
} iso_request_frame;

typedef struct iso_request {
    const char *scene; /* for people; NULL: none */
    const iso_pyramid *pyramid;
    size_t level;
    const iso_view *view;
    const iso_request_frame *frames;
    size_t frame_count;
    int threads; /* 0: all cores */
} iso_request;

/* Key of "volume" and "directions": a checksum of the values, for a folder without these files. */
#define ISO_REQUEST_CHECKSUM "xxh3_64"

/* Writes the three files into an existing folder. ISO_E_USAGE: the view has a 2D transfer function, extinction
 * scales or a region of interest, which the format lacks. ISO_E_IO, ISO_E_MEMORY. */
iso_status iso_request_write(const iso_request *request, const char *dir, iso_error *err);
