/* SPDX-License-Identifier: MIT */
/* shading.h - isoshade-lab consistency --shading: directions across levels. */
#ifndef ISO_LAB_SHADING_H
#define ISO_LAB_SHADING_H

#include "options/cli.h"

extern const iso_command iso_lab_shading;

#endif
