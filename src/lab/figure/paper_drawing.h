/* SPDX-License-Identifier: MIT */
/* paper_drawing.h - points, lines and triangles in space on a drawing of paper.h, by parallel projection. Output is a
 * block of gnuplot data, to be plotted "with lines". */
#pragma once

#include <stdio.h>

#include "base/linalg.h"

typedef struct iso_drawing {
    FILE *gp;
    iso_vec3 right, up, toward; /* toward the viewer */
    double middle, scale;       /* the panel's middle, and one unit, in mm */
} iso_drawing;

/* Begins a drawing with `units` from the middle to an edge, seen from the front right and above. */
iso_drawing iso_drawing_begin(FILE *gp, double panel_mm, double units);
/* Sets another viewing direction. */
void iso_drawing_look(iso_drawing *d, iso_vec3 toward);

double iso_drawing_x(const iso_drawing *d, iso_vec3 p);
double iso_drawing_y(const iso_drawing *d, iso_vec3 p);
/* Writes an invisibly short line whose round ends form the dot: PDF and SVG then hold all dots as one path. */
void iso_drawing_put_dot(const iso_drawing *d, iso_vec3 p);
void iso_drawing_put_line(const iso_drawing *d, iso_vec3 a, iso_vec3 b);
void iso_drawing_put_triangle(const iso_drawing *d, const iso_vec3 corners[3]);

/* Returns a component by its index, 0 to 2; the vector with that component replaced. */
double iso_drawing_component(iso_vec3 v, int axis);
iso_vec3 iso_drawing_with(iso_vec3 v, int axis, double value);
