/* SPDX-License-Identifier: MIT */
/* levels_report.h - summary of the cases of `isoshade-lab levels`. */
#pragma once

#include "base/json.h"
#include "lab/level_error.h"
#include "lab/level_methods.h"

/* Ratios above these count as worse. */
#define ISO_LEVELS_WORSE 1.02
#define ISO_LEVELS_MUCH_WORSE 1.05
/* A case with smaller errors in all metrics and methods is left out: these errors are invisible. */
#define ISO_LEVELS_NO_ERROR 1e-4

enum { ISO_LEVEL_CASE_FIGURES = 6, ISO_LEVEL_SETTINGS_BYTES = 128 };

/* A volume under a transfer function at a level; means over the views. */
typedef struct iso_level_case {
    const char *volume, *tf; /* borrowed, or by iso_level_cases_keep_text() */
    size_t size[3];          /* voxels of level 0 */
    size_t level;
    bool held;
    double finest_alpha; /* largest alpha of level 0's images */
    size_t box;          /* pixels along an edge of a minified pixel */
    struct iso_level_result {
        iso_level_error full, minified;
        double alpha;       /* largest alpha of its images */
        bool measured;      /* false: all values are 0 */
        double seconds;     /* of the fastest frame of all views */
        bool kept_original; /* the method adapts, but kept the original TF here */
    } results[ISO_LEVEL_MAX_METHODS];
} iso_level_case;

typedef struct iso_level_cases {
    size_t count, room;
    iso_level_case *cases;
    bool wanted[ISO_LEVEL_MAX_METHODS];
    size_t against;                          /* the base method */
    char settings[ISO_LEVEL_SETTINGS_BYTES]; /* common settings of all cases: views, pixels, step, renderer */
    size_t text_count;
    char **texts; /* owned */
} iso_level_cases;

/* Adds a zeroed case. NULL: out of memory. */
iso_level_case *iso_level_cases_add(iso_level_cases *c);
void iso_level_cases_destroy(iso_level_cases *c);
/* Copies the text for the lifetime of the cases. NULL: out of memory. */
const char *iso_level_cases_keep_text(iso_level_cases *c, const char *text);
/* Finds the case of the same block, volume, transfer function and level, or NULL. */
iso_level_case *iso_level_cases_find(const iso_level_cases *c, const iso_level_case *like);

/* Returns why a case does not count, or NULL if it does: level 0 shows nothing, the level shows nothing by any method
 * (no pixel has an alpha of 1/255), or no method has an error. */
const char *iso_level_case_left_out(const iso_level_cases *c, const iso_level_case *one);

/* Returns the error of a method over that of the base; 1 if both are 0. */
double iso_level_ratio(double error, double base);

/* Counts pairs of a volume and a transfer function, with the geometric mean over their levels. Near best: DSSIM at most
 * ISO_LEVELS_WORSE times that of the best wanted method. over_best: mean factor over the best method's DSSIM. */
typedef struct iso_level_nearness {
    size_t pairs, near_best;
    double over_best;
} iso_level_nearness;
iso_level_nearness iso_level_cases_nearness(const iso_level_cases *c, bool held, size_t method);

/* Reports the blocks of given and of held-back volumes, by level and method. print: also prints tables. */
json_t *iso_levels_report(const iso_level_cases *c, bool print);
/* "dssim", "rmse", "flip", and these three of minified images. */
extern const char *const iso_level_figure_keys[ISO_LEVEL_CASE_FIGURES];
double iso_level_result_figure(const struct iso_level_result *r, int figure);

/* Returns one object per case and method. */
json_t *iso_level_cases_to_json(const iso_level_cases *c);
/* Writes one line per case and measured method. */
iso_status iso_level_cases_write_csv(const iso_level_cases *c, const char *path, iso_error *err);
/* Adds the cases of a table. Sets c->settings from the table if it is "". ISO_E_FORMAT: not such a table, other
 * settings, a volume with two sizes, or a repeated case. */
iso_status iso_level_cases_read_csv(iso_level_cases *c, const char *path, iso_error *err);
