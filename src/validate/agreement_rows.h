/* SPDX-License-Identifier: MIT */
/* agreement_rows.h - the images that a level is compared with, and the report's rows about them. Shared by the
 * comparisons of the same samples (agreement.c) and of limits (agreement_limits.c). */
#pragma once

#include "validate/validate.h"

/* The image that a level is compared with, rendered once. */
typedef struct iso_truth {
    const char *name; /* "closed form", "reference" */
    char image_name[96];
    iso_image image;
} iso_truth;

typedef struct iso_level_truths {
    iso_truth main;     /* closed form, or the reference from the codes */
    iso_truth exported; /* the reference from decoded directions, if that is another image */
    bool differ;
} iso_level_truths;

static inline void iso_truth_destroy(iso_truth *t)
{
    iso_image_destroy(&t->image);
}

static inline void iso_level_truths_destroy(iso_level_truths *t)
{
    iso_truth_destroy(&t->main);
    iso_truth_destroy(&t->exported);
}

/* An image that is compared with a truth, and its renderer. */
typedef struct iso_compared {
    const char *what; /* in the image's name */
    const iso_image *image;
    const iso_renderer_info *renderer;
    const char *options; /* of the command that makes it again */
    double held_to;      /* tolerance of an extrapolated limit's whole image; 0: the row's tolerances */
} iso_compared;

/* Returns the source of the directions that exports take, so that the reference takes the same. */
iso_direction_source iso_validate_exported_source(const iso_validation *v);

/* Writes the name of an image of the report. */
void iso_validate_name_image(const iso_validation *v, size_t level, const char *what, char name[96]);
iso_status iso_validate_add_image(iso_validation *v, const char *name, const iso_image *image, const char *caption,
                                  iso_error *err);

/* Starts a row: its name for the progress line, and its clock. */
void iso_validate_begin_row(iso_validation *v, size_t level, const char *what);
/* Adds a row with its image and its comparison image; *row has its comparison, tier, tolerances and gates. */
iso_status iso_validate_add_row(iso_validation *v, size_t level, iso_report_agreement *row, const iso_truth *a,
                                const iso_compared *with, iso_error *err);

/* True if nothing can be compared: the renderer is missing, failed its calibration or lacks a feature of the scene, or
 * time has run out. Then *row states the reason from `why` and is added without images. */
bool iso_validate_cannot_compare(const iso_validation *v, const iso_renderer_info *renderer, iso_report_agreement *row,
                                 char why[512]);
iso_status iso_validate_add_without_images(iso_validation *v, size_t level, iso_report_agreement row, const char *a,
                                           const iso_renderer_info *renderer, iso_error *err);
/* Handles a renderer that failed with this status: adds a row with the failure, or fails the run. */
iso_status iso_validate_refuse_failed(iso_validation *v, size_t level, iso_report_agreement row, const char *a,
                                      const iso_renderer_info *renderer, iso_status status, const iso_error *why,
                                      iso_error *err);

/* Renders the view of the validation. */
iso_status iso_validate_render(iso_validation *v, size_t level, const iso_render_options *opt, iso_image *image,
                               iso_error *err);
/* Renders the reference. intervals: of a quadrature that has them. */
iso_status iso_validate_render_reference(iso_validation *v, size_t level, iso_quadrature quadrature, size_t intervals,
                                         iso_direction_source source, iso_image *image, iso_error *err);
/* True if no formula holds for the level. A formula of level 0 need not hold for coarser levels: voxels at the faces of
 * a ramp are means of fewer values. If level 0 itself lacks the formula, the scene is wrong, which is reported when it
 * is drawn. */
bool iso_validate_has_no_formula(const iso_validation *v, size_t level, iso_error *why);
/* Finds the closed form or the reference of a level; the reference is compared with the formula if there is one. If the
 * level has no formula, nothing is found, and rows report that. */
iso_status iso_validate_find_truths(iso_validation *v, size_t level, iso_level_truths *t, iso_error *err);

/* ---- limits (agreement_limits.c) ---- */

struct iso_version_limit_kept; /* a limit that stays until the versions of its program are compared */

/* Compares a renderer's limit with the reference. kept: takes the limit, if it is compared; or NULL. */
iso_status iso_validate_compare_limit(iso_validation *v, size_t level, const iso_renderer_info *renderer,
                                      const iso_level_truths *t, struct iso_version_limit_kept *kept, iso_error *err);
/* Compares all selected renderers, with at most v->limit_size pixels. */
iso_status iso_validate_limits_at(iso_validation *v, size_t level, iso_error *err);
