/* validate.h - the parts of `isoshade validate`, the main job.
 *
 *   calibrate      each renderer on volumes whose images are known (calibrate.h)
 *   agreement      each level: every renderer against the double-precision reference
 *   consistency    each level and each way to make directions, against level 0
 *
 * All of it goes into one report (compare/report.h). */
#ifndef ISO_CLI_VALIDATE_H
#define ISO_CLI_VALIDATE_H

#include "cli/renderers.h"
#include "compare/report.h"

typedef struct iso_validation {
    const iso_pyramid *pyramid;
    const iso_scene *scene;
    const iso_view *view;
    const char *volume_path, *scene_path, *scene_name;
    bool quick;
    bool wanted[ISO_RENDERER_COUNT];
    char refused[ISO_RENDERER_COUNT][512]; /* why a renderer is not compared; "" when it may be */
    size_t consistency_size, consistency_views;
    int threads;
    iso_renderers renderers;
    iso_report *report;
    const iso_progress *progress;
} iso_validation;

/* Versions and calibration of the wanted renderers; fills refused. A missing
 * program is a reason to refuse, not a failure. */
iso_status iso_validate_renderers(iso_validation *v, iso_error *err);

iso_status iso_validate_agreement(iso_validation *v, iso_error *err);

iso_status iso_validate_consistency(iso_validation *v, iso_error *err);

#endif
