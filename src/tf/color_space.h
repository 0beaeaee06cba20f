/* SPDX-License-Identifier: MIT */
/* color_space.h - interpolation between display colors, as in the programs whose transfer functions we read.
 *
 * Display colors are sRGB, 0 to 1. The spaces and their constants are VTK's (vtkColorTransferFunction, vtkMath), so
 * that a curve looks as its author saw it. Lab is CIE 1976 with white point D65. */
#pragma once

#include "base/names.h"

typedef enum iso_color_space {
    ISO_SPACE_RGB,
    ISO_SPACE_HSV,       /* hue from red = 0, interpolated without wrapping */
    ISO_SPACE_WRAPPED,   /* HSV; hue takes the shorter way round the circle */
    ISO_SPACE_LAB,       /* CIE L*a*b* */
    ISO_SPACE_DIVERGING, /* Msh [moreland-2009]: through white if two saturated colors differ much in hue */
    ISO_SPACE_PROLAB,    /* [konovalenko-2021] */
    ISO_SPACE_STEP,      /* constant: each interval has the color of its upper point */
} iso_color_space;

extern const iso_names iso_color_space_names; /* rows in the order of the enum; names as ParaView writes them */

/* Interpolates between two colors at s, 0 to 1. sharpness: bends the curve in each component as VTK does; 0: a line. */
void iso_color_mix(iso_color_space space, const double from[3], const double to[3], double s, double sharpness,
                   double rgb[3]);
/* Interpolates between two numbers at s along the cubic of VTK's vtkPiecewiseFunction. */
double iso_sharp_mix(double from, double to, double s, double sharpness);

/* Converts to CIE L*a*b* with white point D65. */
void iso_color_to_lab(const double rgb[3], double lab[3]);

/* Applies the transfer curve of IEC 61966-2-1; its inverse. */
double iso_srgb_to_linear(double c);
double iso_linear_to_srgb(double c);
