// SPDX-License-Identifier: MIT
// variants.h - the names of the ray caster's variants: raycast.glsl chooses by them, gl_variant.c defines them.
//
// DIRECTION_SOURCE: source of a direction.
#define SOURCE_CODES 0      // codes, decoded after the filter
#define SOURCE_VECTORS 1    // floats, or codes decoded before the upload
#define SOURCE_ON_THE_FLY 2 // differences of the scalar
#define SOURCE_PALETTE 3    // the palette's entries of eight voxels
#define SOURCE_NEAREST 4    // the palette's entry of one voxel
#define SOURCE_FLIPPED 5    // vectors, opposite ones turned to one side before they are filtered

// EXTINCTION_SCALE: place of the byte per voxel that scales the extinction (fit/extinction_scale.h).
#define SCALE_NONE 0
#define SCALE_WITH_DIRECTIONS 1 // in the alpha of the directions, which are fetched anyway
#define SCALE_ALONE 2           // in a texture of its own

// OUTPUT: quantity in a pixel.
#define OUTPUT_INTEGRAL 0  // the rendering equation
#define OUTPUT_HIT_COLOR 1 // the first hit of a surface: first_hit.glsl
#define OUTPUT_HIT_PLACE 2
#define OUTPUT_HIT_NORMAL 3
#define OUTPUT_POINTS 4 // the field at given places: points.glsl
