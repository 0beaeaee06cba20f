/* SPDX-License-Identifier: MIT */
/* levels.h - the verdict on a level.
 *
 * A level is shown by the default method: the pyramid's own directions, and the TF that is adapted to it, unless
 * adapting was refused. It holds if
 *  - each figure is within the scene's limit, if the scene has one;
 *  - it is not worse than the simple way, gradients on the fly under the original TF: not worse in one figure, by more
 *    than the scatter over the views (paired.h) and a margin that is invisible, without being better in another;
 *  - the stored level equals one made of level 0;
 *  - its extinction scales equal those made of level 0, and change its pictures;
 *  - its directions are not worse than gradients on the fly, both under the original TF: farther from level 0's by more
 *    than the interval and a margin, and with worse pictures by the same rule. Angles alone cannot fail;
 *  - its RMSE is not above its bound in any view. The margin covers the renderer's steps: the bound is for images
 *    without steps.
 *
 * Other methods are rivals. A rival that is better in one figure by the same measure, and worse in none, is reported
 * with its option, and fails nothing. If the build chose the direction filter, and another filter is better under
 * the same TF, the choice is wrong for this scene. */
#pragma once

#include "compare/paired.h"
#include "report/report.h"

/* Distances of a level's pictures from those of level 0, means over the views: enum, key in report.json, name. */
/* clang-format off */
#define ISO_LEVEL_FIGURE_LIST(X)                       \
    X(ISO_LEVEL_SSIM, "ssim_dissimilarity", "1-SSIM")  \
    X(ISO_LEVEL_FLIP, "flip", "FLIP")                  \
    X(ISO_LEVEL_RMSE, "rmse", "RMSE")
/* clang-format on */

typedef enum iso_level_figure {
#define ISO_LEVEL_FIGURE_ENUM(name, key, text) name,
    ISO_LEVEL_FIGURE_LIST(ISO_LEVEL_FIGURE_ENUM)
#undef ISO_LEVEL_FIGURE_ENUM
        ISO_LEVEL_FIGURE_COUNT
} iso_level_figure;

/* Another way to show the level. */
typedef struct iso_report_rival {
    const char *method;
    bool adapted;
    const char *option;                        /* command-line option that selects it */
    double value[ISO_LEVEL_FIGURE_COUNT];      /* its own figures */
    iso_paired deficit[ISO_LEVEL_FIGURE_COUNT]; /* the default's figures minus its own */
} iso_report_rival;

/* The bound of a level's RMSE, which is known before drawing, and the measured RMSE; means over the views. */
typedef struct iso_report_bound {
    size_t views; /* number of views, the first ones of the level; 0: the scene has no bound */
    double rmse, bound;
    double above; /* largest excess of a view's RMSE over the bound; negative if all are below */
} iso_report_bound;

/* Extinction scales of the level (fit/extinction_scale.h). */
typedef struct iso_report_scale {
    bool judged;      /* False if it is shown without */
    size_t scaled;    /* voxels whose byte is not that of 1 */
    size_t differing; /* voxels whose byte differs from one made of level 0 */
    bool has_effect;  /* True if the scales change a picture */
} iso_report_scale;

typedef struct iso_report_level {
    bool shown; /* True if level 0 shows anything; otherwise all pictures are equal, and nothing is compared */
    size_t level, views;
    size_t views_before; /* of its rivals; also of the level itself unless these views left it undecided */
    const char *method;  /* the default */
    const char *chosen;  /* the direction filter that `build --direction-filter auto` chose for this level; or NULL */
    bool adapted, scaled; /* scaled: with an extinction scale */
    double confidence, margin;
    double value[ISO_LEVEL_FIGURE_COUNT];
    double asked[ISO_LEVEL_FIGURE_COUNT]; /* limits of the scene; NaN: none */
    iso_report_rival simple;
    size_t rival_count;
    const iso_report_rival *rivals;
    /* Compared with a level made of level 0: the scalar's largest difference as a part of the range, the mean angle
     * between directions, and the limits of both. */
    double scalar_off, scalar_limit, direction_off_deg, direction_limit_deg;
    /* The mean angle to level 0's directions at voxels that the scene's TF shows, of the default and of the simple way,
     * and their difference with its interval; NaN if nothing has a direction. Reported, but pictures decide. */
    double angle_deg, simple_angle_deg;
    iso_paired angle_deficit;
    iso_report_bound bound;
    iso_report_scale scale;
} iso_report_level;

/* Adds the row to "levels", with its verdict. */
iso_status iso_report_add_level(iso_report *report, const iso_report_level *row, iso_error *err);
/* Returns agree, differ, or not compared. */
iso_verdict iso_report_level_verdict(const iso_report_level *row);

typedef struct iso_levels_summary {
    size_t agreed, differed, not_compared;
    char sentence[2048]; /* "" if no level was to be judged */
} iso_levels_summary;
/* Summarizes the levels of a report.json. */
iso_levels_summary iso_levels_summarize(const json_t *report);
