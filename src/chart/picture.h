/* SPDX-License-Identifier: MIT */
/* picture.h - a small picture of a setting, for the chart's page. */
#pragma once

#include "image/image.h"

enum { ISO_CHART_PICTURE_PIXELS = 128 }; /* of its longer side, at most */

/* Encodes a picture as a data URI of a PNG: averaged in linear light, then sRGB. The caller frees it; NULL if out of
 * memory. */
char *iso_chart_picture(const iso_image *image);
