/* SPDX-License-Identifier: MIT */
/* levels_report.h - what the cases of `isoshade-lab levels` come to. */
#ifndef ISO_LAB_LEVELS_REPORT_H
#define ISO_LAB_LEVELS_REPORT_H

#include "base/json.h"
#include "lab/level_error.h"
#include "lab/level_methods.h"

/* Ratios above these count as worse. */
#define ISO_LEVELS_WORSE 1.02
#define ISO_LEVELS_MUCH_WORSE 1.05
/* Below it in each metric and under every method, a case tells nothing: nobody sees an error. */
#define ISO_LEVELS_NO_ERROR 1e-4

enum { ISO_LEVEL_CASE_FIGURES = 6, ISO_LEVEL_SETTINGS_BYTES = 128 };

/* A volume under a transfer function at a level; means over the views. */
typedef struct iso_level_case {
    const char *volume, *tf; /* borrowed, or of iso_level_cases_keep_text() */
    size_t size[3];          /* voxels of level 0 */
    size_t level;
    bool held;
    double finest_alpha; /* the largest of level 0's images */
    size_t box;          /* pixels along an edge of what minifying averages */
    struct iso_level_result {
        iso_level_error full, minified;
        double alpha;       /* the largest of its images */
        bool measured;      /* false: these are zeros */
        double seconds;     /* of the fastest frame of the views */
        bool kept_original; /* it adapts, and kept the original TF here */
    } results[ISO_LEVEL_MAX_METHODS];
} iso_level_case;

typedef struct iso_level_cases {
    size_t count, room;
    iso_level_case *cases;
    bool wanted[ISO_LEVEL_MAX_METHODS];
    size_t against; /* the method that the others are compared with */
    char settings[ISO_LEVEL_SETTINGS_BYTES]; /* that all cases were measured with: views, pixels, step, renderer */
    size_t text_count;
    char **texts; /* owned */
} iso_level_cases;

/* A new case, zeroed; NULL: no memory. */
iso_level_case *iso_level_cases_add(iso_level_cases *c);
void iso_level_cases_destroy(iso_level_cases *c);
/* A copy of the text that lives as long as the cases; NULL: no memory. */
const char *iso_level_cases_keep_text(iso_level_cases *c, const char *text);
/* The case of the same block, volume, transfer function and level; NULL: there is none. */
iso_level_case *iso_level_cases_find(const iso_level_cases *c, const iso_level_case *like);

/* Why no mean counts a case: level 0 shows nothing, or the level under no method (no pixel of any view has an alpha of
 * 1/255), or no method errs. NULL: it counts. */
const char *iso_level_case_left_out(const iso_level_cases *c, const iso_level_case *one);

/* The error of a method over that of the base; 1 where both are 0. */
double iso_level_ratio(double error, double base);

/* Of the pairs of a volume and a transfer function, their levels taken together (geometric mean): how many have a DSSIM by
 * the method that is at most ISO_LEVELS_WORSE of the best one of all wanted methods, and how far it is above the best's. */
typedef struct iso_level_nearness {
    size_t pairs, near_best;
    double over_best;
} iso_level_nearness;
iso_level_nearness iso_level_cases_nearness(const iso_level_cases *c, bool held, size_t method);

/* Blocks of what was named and of what was held back, by level and method. print: as tables as well. */
json_t *iso_levels_report(const iso_level_cases *c, bool print);
/* "dssim", "rmse", "flip", and the same of minified images. */
extern const char *const iso_level_figure_keys[ISO_LEVEL_CASE_FIGURES];
double iso_level_result_figure(const struct iso_level_result *r, int figure);

/* One object a case and method. */
json_t *iso_level_cases_to_json(const iso_level_cases *c);
/* A line a case and method that was measured. */
iso_status iso_level_cases_write_csv(const iso_level_cases *c, const char *path, iso_error *err);
/* Adds what such a table has to the cases. The first one sets c->settings where that is "". ISO_E_FORMAT: no such table,
 * measured with other settings, a volume of two sizes, or a case twice. */
iso_status iso_level_cases_read_csv(iso_level_cases *c, const char *path, iso_error *err);

#endif
