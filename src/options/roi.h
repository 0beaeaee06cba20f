/* SPDX-License-Identifier: MIT */
/* roi.h - options for a region of interest: a finer level in a box of a coarse one (scene/roi.h). */
#pragma once

#include "options/adapted.h"
#include "scene/roi.h"

typedef struct iso_cli_roi {
    char *box;
    int level;
    double band;
} iso_cli_roi;
#define ISO_CLI_ROI_DEFAULTS \
    { \
        .band = ISO_ROI_BAND \
    }
extern const iso_option iso_roi_rows[];


/* The level around a region of interest. */
typedef struct iso_cli_roi_place {
    const iso_cli_adapted *adapted;
    const char *path; /* path of the pyramid or of its volume */
    const iso_pyramid *pyramid;
    size_t level;
    int threads;
} iso_cli_roi_place;

/* Sets view->roi if a box is given. Call it while view->tf is still the scene's: the level inside gets its own 1D
 * transfer function, adapted as `adapted` says. ISO_E_USAGE. */
iso_status iso_cli_roi_view(const iso_cli_roi *r, const iso_cli_roi_place *at, iso_view *view, iso_error *err);
