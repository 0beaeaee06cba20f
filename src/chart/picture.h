/* SPDX-License-Identifier: MIT */
/* picture.h - a small picture of a setting, for the chart's page. */
#ifndef ISO_CHART_PICTURE_H
#define ISO_CHART_PICTURE_H

#include "image/image.h"

enum { ISO_CHART_PICTURE_PIXELS = 128 }; /* of its longer side, at most */

/* Averaged in linear light, sRGB, a PNG as a data URI; to be freed, NULL when memory ends. */
char *iso_chart_picture(const iso_image *image);

#endif
