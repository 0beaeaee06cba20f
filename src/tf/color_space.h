/* SPDX-License-Identifier: MIT */
/* color_space.h - between two display colors, as the programs that we read transfer functions of go.
 *
 * Display colors are sRGB, 0 to 1. The spaces and their constants are VTK's (vtkColorTransferFunction, vtkMath), so
 * that a curve is the one that its author saw; Lab is CIE 1976 of D65. */
#ifndef ISO_COLOR_SPACE_H
#define ISO_COLOR_SPACE_H

#include "base/names.h"

typedef enum iso_color_space {
    ISO_SPACE_RGB,
    ISO_SPACE_HSV,       /* straight on in hue, from red on */
    ISO_SPACE_WRAPPED,   /* HSV, the shorter way round the hues */
    ISO_SPACE_LAB,       /* CIE L*a*b* */
    ISO_SPACE_DIVERGING, /* Msh [moreland-2009]: by white where two saturated colors differ much in hue */
    ISO_SPACE_PROLAB,    /* [konovalenko-2021] */
    ISO_SPACE_STEP,      /* a point's color holds down to the point before it */
} iso_color_space;

extern const iso_names iso_color_space_names; /* rows in the order of the enum; names as ParaView writes them */

/* Where the way from one color to the other is at s of 0 to 1. bend: VTK's curve for a sharpness, 0 for a line; it bends
 * each component of the space by itself. */
void iso_color_mix(iso_color_space space, const double from[3], const double to[3], double s, double sharpness,
                   double rgb[3]);
/* The same for a number: s along the cubic of VTK's vtkPiecewiseFunction. */
double iso_sharp_mix(double from, double to, double s, double sharpness);

/* CIE L*a*b* of D65 */
void iso_color_to_lab(const double rgb[3], double lab[3]);

/* IEC 61966-2-1 */
double iso_srgb_to_linear(double c);
double iso_linear_to_srgb(double c);

#endif
