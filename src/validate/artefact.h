/* SPDX-License-Identifier: MIT */
/* artefact.h - checks that exported files render as validated.
 *
 * Validation asks renderers for passes without a background, in private folders. Here a level is exported as by
 * `isoshade export`, the folder is moved, and the program is started again on it, as its page describes. The resulting
 * picture, background included, is compared with a picture that is known to be right:
 *
 *   renderer with known samples   the reference's picture of the same samples
 *   any other renderer            its own by the same steps; its limit is compared with the reference
 *
 * A file that holds colors of 0 to 1 is compared with the clipped picture of the reference. */
#pragma once

#include "targets/targets.h"
#include "validate/validate.h"

typedef struct iso_artefact {
    const iso_export_target *target;
    const iso_renderer_info *renderer;
    const iso_pyramid *pyramid;
    size_t level;
    const iso_view *view;
    int threads;
    void (*tamper)(const char *path); /* for planted faults: called before the folder is moved; or NULL */
    const iso_view *planted_view;     /* exported instead of `view`; or NULL */
} iso_artefact;

typedef struct iso_artefact_result {
    iso_image expected, picture;
    double value, limit; /* RMSE of the colors; NaN: no picture, `why` has the reason */
    const char *unit;
    char why[512];
    iso_status failure; /* of the program, or of its picture; ISO_OK: there is a picture */
} iso_artefact_result;

/* Returns ISO_OK also if the program fails on the export. Release with iso_artefact_release(), also after a failure. */
iso_status iso_artefact_compare(iso_renderers *renderers, const iso_artefact *a, iso_artefact_result *out,
                                const iso_progress *progress, iso_error *err);
void iso_artefact_release(iso_artefact_result *result);
