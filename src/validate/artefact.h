/* SPDX-License-Identifier: MIT */
/* artefact.h - is what a person is given what was validated?
 *
 * Renderers are asked for passes without a background, in private folders. Here a level is exported as `isoshade export`
 * does it, the folder is moved, the program is started anew on it as its page tells a person to, and the picture that it
 * leaves, background and all, is compared with the picture that is known to be right:
 *
 *   of a renderer whose samples are known   the reference's of the same samples
 *   else                                    the renderer's own by the same steps, which its limit holds to the reference
 *
 * A file that holds colors of 0 to 1 is compared with what the reference's picture is when it is clipped. */
#ifndef ISO_VALIDATE_ARTEFACT_H
#define ISO_VALIDATE_ARTEFACT_H

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
    double value, limit; /* RMSE of the colors; NaN: there is no picture, and `why` says the reason */
    const char *unit;
    char why[512];
    iso_status failure; /* of the program, or of what it left; ISO_OK: there is a picture */
} iso_artefact_result;

/* ISO_OK also where the program fails at what was exported. Release with iso_artefact_release(), which accepts what
 * failed. */
iso_status iso_artefact_compare(iso_renderers *renderers, const iso_artefact *a, iso_artefact_result *out,
                                const iso_progress *progress, iso_error *err);
void iso_artefact_release(iso_artefact_result *result);

#endif
