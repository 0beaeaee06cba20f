/* SPDX-License-Identifier: MIT */
/* palette_cube.h - cells of equal size on the faces of a cube, for directions.
 *
 *     face   2 axis + (component < 0), axis the largest component
 *     u, v   the other two components in cyclic order, divided by the largest
 *     cell   (face G + row of v) G + column of u */
#pragma once

#include <math.h>
#include <stdint.h>

typedef struct iso_cube_point {
    int axis;
    int negative;
    float u, v; /* in [-1, 1] */
} iso_cube_point;

/* Projects d on the cube. False for the zero vector and if a component is NaN or infinite. */
static inline int iso_cube_project(const float d[3], iso_cube_point *p)
{
    float ax = fabsf(d[0]), ay = fabsf(d[1]), az = fabsf(d[2]);
    int y_leads = ay > ax;
    float most = y_leads ? ay : ax;
    int z_leads = az > most;
    p->axis = z_leads ? 2 : y_leads;
    most = z_leads ? az : most;
    float major = z_leads ? d[2] : y_leads ? d[1] : d[0];
    float second = z_leads ? d[0] : y_leads ? d[2] : d[1];
    float third = z_leads ? d[1] : y_leads ? d[0] : d[2];
    p->negative = major < 0;
    p->u = second / most;
    p->v = third / most;
    /* NaN, infinity (inf / inf) and 0 / 0 all make this sum not finite. */
    return most > 0 && fabsf(p->u) + fabsf(p->v) + most * 0 <= 2;
}

static inline uint32_t iso_cube_cell(const iso_cube_point *p, int cells)
{
    float half = 0.5f * (float)cells;
    int column = (int)((p->u + 1) * half), row = (int)((p->v + 1) * half);
    column -= column == cells;
    row -= row == cells;
    return (uint32_t)(((2 * p->axis + p->negative) * cells + row) * cells + column);
}

/* Computes the vector, not normalized, at (u, v) of a face. */
static inline void iso_cube_vector(int face, double u, double v, double out[3])
{
    int axis = face / 2;
    out[axis] = face % 2 ? -1 : 1;
    out[(axis + 1) % 3] = u;
    out[(axis + 2) % 3] = v;
}
