/* SPDX-License-Identifier: MIT */
/* gradient_kernel.h - gradients of one row of samples in the type of their file. Cannot fail or allocate, and does
 * not depend on threads. */
#pragma once

#include "gradient/gradient.h"

/* Planes of a volume that are in memory: first .. first + count - 1. */
typedef struct iso_planes {
    const void *data;
    iso_type type;
    size_t size[3]; /* of the whole volume */
    size_t first, count;
    bool has_no_data; /* some samples are ISO_NO_DATA */
} iso_planes;

/* Sample types of the kernels: X(type, suffix, type in C, type that holds a difference exactly or in float). */
#define ISO_SAMPLE_TYPES(X) \
    X(ISO_U8, u8, uint8_t, int) \
    X(ISO_I8, i8, int8_t, int) \
    X(ISO_U16, u16, uint16_t, int) \
    X(ISO_I16, i16, int16_t, int) \
    X(ISO_U32, u32, uint32_t, float) \
    X(ISO_I32, i32, int32_t, float) \
    X(ISO_F32, f32, float, float) \
    X(ISO_F64, f64, double, float)

/* Returns the samples of the row (y, z), in their type. */
static inline const void *iso_planes_row_at(const iso_planes *p, size_t y, size_t z)
{
    const size_t row = (z - p->first) * p->size[1] + y;
    return (const char *)p->data + row * p->size[0] * iso_type_bytes(p->type);
}

/* The matrix, as float and row-major, and whether only its diagonal counts. */
typedef struct iso_gradient_matrix {
    float m[9];
    bool diagonal;
} iso_gradient_matrix;
iso_gradient_matrix iso_gradient_matrix_from(iso_mat3 to_world);

/* Returns the floats of scratch that iso_gradient_row needs for rows of nx voxels. */
size_t iso_gradient_scratch_count(size_t nx);

/* Computes gradients of the row (y, z), times the matrix, into the planar rows g. The volume's planes within reach
 * must be in memory. If the planes have voxels without data, gradients are central differences, one-sided next to these
 * voxels, and zero in them. */
void iso_gradient_row(const iso_planes *p, iso_gradient_method method, const iso_gradient_matrix *matrix, size_t y,
                      size_t z, float *scratch, float *const g[3]);

#define ISO_GRADIENT_DECLARE(method, row) extern const iso_gradient_info iso_gradient_##row;
ISO_GRADIENT_LIST(ISO_GRADIENT_DECLARE)
#undef ISO_GRADIENT_DECLARE

/* No estimator reaches farther. */
enum { ISO_GRADIENT_MOST_REACH = 12 };

/* Turns a row of index gradients into world gradients, in place. */
void iso_gradient_to_world(const iso_gradient_matrix *matrix, size_t n, float *restrict gx, float *restrict gy,
                           float *restrict gz);

/* Adds a row: sum += weight * row. */
void iso_add_weighted_row(float weight, const float *restrict row, size_t n, float *restrict sum);

/* Reads the row (y, z) as floats. */
void iso_planes_row(const iso_planes *p, size_t y, size_t z, float *restrict row);
