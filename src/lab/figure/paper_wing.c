/* SPDX-License-Identifier: MIT */
#include "lab/figure/paper_wing.h"

#include <math.h>

/* Returns half the thickness of a four-digit airfoil of thickness 1 at a fraction of its chord (NACA report 460, with a
 * closed trailing edge). */
static double half_thickness(double x)
{
    return 5 * (0.2969 * sqrt(x) + x * (-0.1260 + x * (-0.3516 + x * (0.2843 - x * 0.1036))));
}

/* Outline of a section of the wing: upper and lower half, denser towards the leading edge. */
enum { OUTLINE = 96 };
typedef struct section {
    double upper[OUTLINE][2], lower[OUTLINE][2]; /* y, z */
} section;

/* Returns the section at `span`, 0 at the root to 1 at the tip. The wing is tapered, swept back and cambered, with a
 * raised tip. Its trailing edge is just thick enough for the voxels. */
static section section_at(double span)
{
    const double chord = 0.92 - 0.50 * span, front = -0.50 + 0.42 * span;
    section s;
    for (int i = 0; i < OUTLINE; ++i) {
        const double x = pow((double)i / (OUTLINE - 1), 2);
        const double middle = 0.36 * chord * x * (1 - x) + 0.10 * span * span;
        const double half = 0.20 * chord * half_thickness(x) + 0.012 * sqrt(x);
        s.upper[i][0] = s.lower[i][0] = front + chord * x;
        s.upper[i][1] = middle + half, s.lower[i][1] = middle - half;
    }
    return s;
}

static double to_segment(const double a[2], const double b[2], double y, double z)
{
    const double dy = b[0] - a[0], dz = b[1] - a[1], length = dy * dy + dz * dz;
    const double t = length > 0 ? fmin(fmax(((y - a[0]) * dy + (z - a[1]) * dz) / length, 0), 1) : 0;
    return hypot(a[0] + t * dy - y, a[1] + t * dz - z);
}

/* Returns the signed distance to the section, negative inside. */
static double outside_section(const section *s, double y, double z)
{
    double nearest = to_segment(s->upper[OUTLINE - 1], s->lower[OUTLINE - 1], y, z);
    bool inside = false;
    for (int i = 0; i + 1 < OUTLINE; ++i) {
        nearest = fmin(nearest, fmin(to_segment(s->upper[i], s->upper[i + 1], y, z),
                                     to_segment(s->lower[i], s->lower[i + 1], y, z)));
        if (y >= s->upper[i][0] && y < s->upper[i + 1][0]) {
            const double t = (y - s->upper[i][0]) / (s->upper[i + 1][0] - s->upper[i][0]);
            inside = z < (1 - t) * s->upper[i][1] + t * s->upper[i + 1][1] &&
                     z > (1 - t) * s->lower[i][1] + t * s->lower[i + 1][1];
        }
    }
    return inside ? -nearest : nearest;
}

/* Makes a volume whose values fall from 1 inside to 0 outside over six voxels across the surface (value 1/2). */
iso_status iso_paper_make_wing(iso_volume *v, iso_error *err)
{
    const size_t size[3] = {160, 92, 36};
    const iso_geometry g = iso_geometry_axis_aligned(size, (const double[3]){1, 1, 1});
    const double unit = 2.0 / (double)size[0];
    NEED(iso_volume_create(v, &g, ISO_F32, "wing", err));
    float *out = v->data;
    for (size_t x = 0; x < size[0]; ++x) {
        const double span = (unit * ((double)x + 0.5) - 1 + 0.92) / 1.84, beyond = fmax(-span, span - 1) * 1.84;
        const section s = section_at(fmin(fmax(span, 0), 1));
        for (size_t z = 0; z < size[2]; ++z)
            for (size_t y = 0; y < size[1]; ++y) {
                double outside = outside_section(&s, unit * ((double)y + 0.5 - 0.5 * (double)size[1]),
                                                 unit * ((double)z + 0.5 - 0.36 * (double)size[2]));
                outside = beyond > 0 ? hypot(beyond, fmax(outside, 0)) : fmax(outside, beyond);
                out[(z * size[1] + y) * size[0] + x] = (float)fmin(fmax(0.5 - outside / (6 * unit), 0), 1);
            }
    }
    return ISO_OK;
}
