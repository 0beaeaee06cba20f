/* SPDX-License-Identifier: MIT */
/* shading.h - isoshade-lab consistency --shading: directions across levels; --filters, --holes: their failures. */
#ifndef ISO_LAB_SHADING_H
#define ISO_LAB_SHADING_H

#include "options/cli.h"

iso_status iso_lab_shading(int argc, const char **argv, iso_error *err);
iso_status iso_lab_filters(int argc, const char **argv, iso_error *err);

#endif
