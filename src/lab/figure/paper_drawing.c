/* SPDX-License-Identifier: MIT */
#include "lab/figure/paper_drawing.h"

iso_drawing iso_drawing_begin(FILE *gp, double panel_mm, double units)
{
    iso_drawing d = {.gp = gp, .middle = 0.5 * panel_mm, .scale = 0.5 * panel_mm / units};
    iso_drawing_look(&d, iso_v3(0.62, -1.0, 0.48));
    return d;
}

void iso_drawing_look(iso_drawing *d, iso_vec3 toward)
{
    d->toward = iso_normalize(toward);
    d->right = iso_normalize(iso_cross(iso_v3(0, 0, 1), d->toward));
    d->up = iso_cross(d->toward, d->right);
}

double iso_drawing_x(const iso_drawing *d, iso_vec3 p)
{
    return d->middle + d->scale * iso_dot(p, d->right);
}

double iso_drawing_y(const iso_drawing *d, iso_vec3 p)
{
    return d->middle + d->scale * iso_dot(p, d->up);
}

void iso_drawing_put_dot(const iso_drawing *d, iso_vec3 p)
{
    const double x = iso_drawing_x(d, p), y = iso_drawing_y(d, p);
    fprintf(d->gp, "%.3f %.3f\n%.3f %.3f\n\n", x, y, x + 0.002, y);
}

void iso_drawing_put_line(const iso_drawing *d, iso_vec3 a, iso_vec3 b)
{
    fprintf(d->gp, "%.3f %.3f\n%.3f %.3f\n\n", iso_drawing_x(d, a), iso_drawing_y(d, a), iso_drawing_x(d, b),
            iso_drawing_y(d, b));
}

void iso_drawing_put_triangle(const iso_drawing *d, const iso_vec3 corners[3])
{
    for (int i = 0; i < 4; ++i)
        fprintf(d->gp, "%.3f %.3f\n", iso_drawing_x(d, corners[i % 3]), iso_drawing_y(d, corners[i % 3]));
    fputc('\n', d->gp);
}

double iso_drawing_component(iso_vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

iso_vec3 iso_drawing_with(iso_vec3 v, int axis, double value)
{
    return iso_v3(axis == 0 ? value : v.x, axis == 1 ? value : v.y, axis == 2 ? value : v.z);
}
