/* SPDX-License-Identifier: MIT */
/* paper_drawing.h - points, lines and triangles of space on a drawing of paper.h, by parallel projection. What is put
 * is a block of gnuplot's data, to be plotted "with lines". */
#ifndef ISO_LAB_FIGURE_PAPER_DRAWING_H
#define ISO_LAB_FIGURE_PAPER_DRAWING_H

#include <stdio.h>

#include "base/linalg.h"

typedef struct iso_drawing {
    FILE *gp;
    iso_vec3 right, up, toward; /* toward the viewer */
    double middle, scale;       /* mm of the panel's middle, of one unit */
} iso_drawing;

/* `units` from the middle to an edge; from the front right and above, where no two axes coincide. */
iso_drawing iso_drawing_begin(FILE *gp, double panel_mm, double units);
/* From another side. */
void iso_drawing_look(iso_drawing *d, iso_vec3 toward);

double iso_drawing_x(const iso_drawing *d, iso_vec3 p);
double iso_drawing_y(const iso_drawing *d, iso_vec3 p);
/* A line too short to be seen, whose round ends are the dot: PDF and SVG then hold all dots as one path. */
void iso_drawing_put_dot(const iso_drawing *d, iso_vec3 p);
void iso_drawing_put_line(const iso_drawing *d, iso_vec3 a, iso_vec3 b);
void iso_drawing_put_triangle(const iso_drawing *d, const iso_vec3 corners[3]);

/* A component by its number, 0 to 2; the vector with another one. */
double iso_drawing_component(iso_vec3 v, int axis);
iso_vec3 iso_drawing_with(iso_vec3 v, int axis, double value);

#endif
