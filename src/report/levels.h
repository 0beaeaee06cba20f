/* SPDX-License-Identifier: MIT */
/* levels.h - the verdict on a level: what was asked of it, and what it was compared with.
 *
 * A level is shown by the default method, with the pyramid's own directions and under the TF that is adapted to it
 * where adapting is not refused. It holds when
 *  - each figure is at most what the scene asks for, where it asks;
 *  - it is not worse than the simple way, gradients on the fly under the original TF: in a figure beyond the scatter over
 *    the views (paired.h) and a margin below which nobody sees a difference, and better in no other figure;
 *  - what is stored is what level 0 makes;
 *  - extinction scales that it is handed over with are those that level 0 makes, and change its pictures;
 *  - its directions are not worse than gradients on the fly, both under the original TF: farther from level 0's by more than the
 *    interval and a margin, and with worse pictures by the same rule. Angles alone fail nothing;
 *  - its RMSE is not above its bound in any view, beyond the margin, which is for the renderer's steps: the bound is of
 *    images without any.
 * Other methods are rivals. One that is better in a figure by the same measure, and worse in none, is named with the
 * option that has it, and fails nothing; where the direction filter was chosen by the build, another one that is better
 * under the same TF says that the choice is wrong on this scene. */
#ifndef ISO_REPORT_LEVELS_H
#define ISO_REPORT_LEVELS_H

#include "compare/paired.h"
#include "report/report.h"

/* How far a level's pictures are from those of level 0, means over the views: enum, key in report.json, name. */
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
    const char *option;                        /* what chooses it */
    double value[ISO_LEVEL_FIGURE_COUNT];      /* its own figures */
    iso_paired behind[ISO_LEVEL_FIGURE_COUNT]; /* the default's figures less its own */
} iso_report_rival;

/* The bound of a level's RMSE that is known before it is drawn, beside what was measured; means over the views. */
typedef struct iso_report_bound {
    size_t views; /* the first of the level's; 0: there is no bound for the scene */
    double rmse, bound;
    double above; /* the most by which the RMSE of a view is above the bound; negative: it is below in all */
} iso_report_bound;

/* Extinction scales of the level (fit/extinction_scale.h). */
typedef struct iso_report_scale {
    bool judged;      /* false: it is shown without */
    size_t scaled;    /* voxels whose byte is not that of 1 */
    size_t differing; /* voxels whose byte is not the one that level 0 makes */
    bool has_effect;  /* a picture with them is not the picture without */
} iso_report_scale;

typedef struct iso_report_level {
    bool shown; /* level 0 shows something; else its pictures are alike whatever is wrong, and nothing is compared */
    size_t level, views;
    size_t views_before; /* of its rivals, and of itself where these views did not leave it open */
    const char *method;  /* the default */
    const char *chosen;  /* the direction filter that `build --direction-filter auto` chose for this level; or NULL */
    bool adapted, scaled; /* scaled: with an extinction scale */
    double confidence, margin;
    double value[ISO_LEVEL_FIGURE_COUNT];
    double asked[ISO_LEVEL_FIGURE_COUNT]; /* by the scene; NaN: not asked */
    iso_report_rival simple;
    size_t rival_count;
    const iso_report_rival *rivals;
    /* Against what level 0 makes: the scalar's largest difference as a part of the range, the mean angle between
     * directions, and what is allowed of them. */
    double scalar_off, scalar_limit, direction_off_deg, direction_limit_deg;
    /* The mean angle to level 0's directions where the scene's TF shows anything, of the default and of the simple way; their
     * difference with its interval, and a margin that is allowed; NaN where nothing has a direction. */
    double angle_deg, simple_angle_deg, angle_margin_deg;
    iso_paired angle_behind;
    iso_paired turned[ISO_LEVEL_FIGURE_COUNT]; /* the default's figures less the simple way's, both under the original TF */
    iso_report_bound bound;
    iso_report_scale scale;
} iso_report_level;

/* Keeps the row under "levels", with its verdict. */
iso_status iso_report_add_level(iso_report *report, const iso_report_level *row, iso_error *err);
/* Agree, differ, or not compared. */
iso_verdict iso_report_level_verdict(const iso_report_level *row);

typedef struct iso_levels_summary {
    size_t agreed, differed, not_compared;
    char sentence[2048]; /* "" where no level was to be judged */
} iso_levels_summary;
/* Of report.json. */
iso_levels_summary iso_levels_summarize(const json_t *report);

#endif
