/* SPDX-License-Identifier: MIT */
/* sampler.h - a level's scalar and shading normal at any point, in double precision.
 *
 * Points are in the level's index coordinates (voxel i has its center at i + 1/2).
 * The field's data are the floats and bytes of the level; all arithmetic on them
 * is double. Trilinear between voxel centers, clamped to the edge; labels are those of
 * the voxel that holds the point. */
#pragma once

#include "brick/bricks.h"
#include "scene/field.h"

/* On-the-fly normals are g / sqrt(|g|^2 + e^2), e this part of the level's
 * value range over its smallest spacing, of a constant level of its value or of 1: flat regions fade to ambient. */
#define ISO_ON_THE_FLY_EPS 1e-4

typedef struct iso_sampler {
    const iso_level *level;
    iso_code code;
    iso_direction_source source;
    float *owned;         /* lattice vectors or decoded directions, made here */
    const float *vectors; /* 3 a voxel, filtered; NULL: of_byte, or on the fly */
    /* The component that a byte of the level's codes stands for, in codes whose bytes are read one by one; or on the
     * fly. */
    float of_byte[256];
    bool by_bytes;
    iso_mat3 gradient_to_world;
    double on_the_fly_eps;         /* value per mm */
    const iso_brick_field *bricks; /* instead of the level's voxels; or NULL */
} iso_sampler;

/* Creates a sampler. ISO_E_RANGE if floats are requested and the level has none. */
iso_status iso_sampler_create(iso_sampler *s, const iso_level *level, iso_code code, iso_direction_source source,
                              iso_error *err);
/* Makes a sampler of bricks. *level gets the members of a level that the sampler uses, and has to outlive it. */
void iso_sampler_of_bricks(iso_sampler *s, const iso_brick_field *bricks, iso_level *level);
void iso_sampler_destroy(iso_sampler *s);

/* Reads the vector of a voxel that lookups filter; not for gradients on the fly. */
static inline void iso_sampler_vector(const iso_sampler *s, size_t voxel, float v[3])
{
    for (size_t a = 0; a < 3; ++a)
        v[a] = s->by_bytes ? s->of_byte[s->level->codes[3 * voxel + a]] : s->vectors[3 * voxel + a];
}

double iso_sample_scalar(const iso_sampler *s, iso_vec3 index);
/* Filters bytes, one per voxel of the level. */
double iso_sample_bytes(const iso_sampler *s, const uint8_t *bytes, iso_vec3 index);
/* The same for floats, `channels` for each voxel (at most ISO_SAMPLE_CHANNELS), into out. */
enum { ISO_SAMPLE_CHANNELS = 8 };
void iso_sample_floats(const iso_sampler *s, const float *values, size_t channels, iso_vec3 index, double *out);
/* Returns the normal in world axes, |n| <= 1; zero if the point has no direction. */
iso_vec3 iso_sample_normal(const iso_sampler *s, iso_vec3 index);
