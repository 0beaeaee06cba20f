/* SPDX-License-Identifier: MIT */
/* grid.h - the settings that `isoshade chart` tries: a grid of renderer, step, quadrature, estimator, level, direction
 * filter, code, transfer function and plan, without those that would repeat each other, the most important first. */
#ifndef ISO_CHART_GRID_H
#define ISO_CHART_GRID_H

#include "renderers/renderers.h"
#include "compare/metrics.h"
#include "tf/histogram.h"

/* Palettes in the grid: one byte and ten bits an index. Each is fitted to the finest level and serves all. */
#define ISO_CHART_PALETTES 2
extern const size_t iso_chart_palettes[ISO_CHART_PALETTES];

/* Bricks of 16 voxels and three levels suit volumes from a chart's small ones on. */
enum { ISO_CHART_BRICK_VOXELS = 16, ISO_CHART_BRICK_LEVELS = 3 };

#define ISO_CHART_MAX_LIST 16

/* What the user asked for; NULL is the default, which `isoshade chart --help` prints from here. Of renderers it is all but
 * the reference, which everything is compared with: iso_chart_default_renderers(). */
typedef struct iso_chart_words {
    const char *with, *steps, *quadratures, *codes, *filters, *estimators, *tfs, *plans;
} iso_chart_words;
extern const iso_chart_words iso_chart_default_words; /* of renderers and codes NULL: the functions below */
/* All that a texture can filter, as a list, that of pyramids first; in text, which it returns. */
char *iso_chart_default_codes(char *text, size_t size);
const char *iso_chart_default_renderers(char *text, size_t size);

/* Which values each axis of the grid has. */
typedef struct iso_chart_grid {
    bool with[ISO_MAX_RENDERERS], codes[ISO_CODE_COUNT], filters[ISO_DIRECTION_COUNT], estimators[ISO_GRADIENT_COUNT];
    bool optional[ISO_MAX_RENDERERS]; /* in the default list: left out where it does not answer */
    bool midpoint, preintegrated;
    bool original, adapted, tf_2d;                               /* transfer functions of coarse levels */
    double steps[ISO_CHART_MAX_LIST], plans[ISO_CHART_MAX_LIST]; /* voxels; predicted errors */
    size_t step_count, plan_count;
    iso_gradient_method
        first_estimator; /* what the user named first: the reference's, and that of settings with the usual one */
    iso_direction_filter first_filter;
    iso_code first_code;
} iso_chart_grid;

/* One setting of the grid, and what it gave. */
typedef struct iso_chart_case {
    size_t scene;   /* which of the chart's */
    size_t setting; /* the same number for one setting of all scenes */
    const iso_renderer_info *renderer;
    size_t level;
    iso_gradient_method estimator;
    iso_direction_filter filter;
    iso_direction_source source;
    iso_code code;
    size_t palette;          /* which of iso_chart_palettes, with ISO_FROM_PALETTE */
    bool adapted;            /* the level's own transfer function */
    iso_second_value second; /* of a 2D transfer function (tf/tf_2d.h), or ISO_SECOND_VALUE_NONE */
    bool preintegrated;
    double plan_error; /* above 0: bricks of mixed resolution planned for this predicted RMSE, instead of a level */
    double step_voxels;
    size_t voxel_count;   /* of the level; a plan's is level 0's */
    double relative_cost; /* samples along all rays, times the fetches of one */
    size_t departures;    /* from the usual choice of each axis but level and step */
    size_t turn;          /* rises with what is less likely on a front: two for a departure, one for an adapted TF and for
                           * a step between powers of two */
    bool needs_pyramid;   /* by another estimator or filter than the first */
    iso_render_stats took;
    double stored_bytes; /* of the level in a pyramid on disk: scalars as stored, and directions; of a plan's nodes */
    iso_metrics metrics;
    bool done, kept;     /* kept: from an earlier run (chart/kept.h) */
    bool refused;        /* could not be rendered */
    bool put_off;        /* tried after those that may lie on a front (chart/order.h) */
    char *picture;       /* owned; a small one as a data URI, or NULL */
    bool on_time_front, on_bytes_front;           /* of its scene */
    bool on_renderer_time_front, on_renderer_bytes_front; /* of its scene and renderer */
    size_t number; /* of those on a front that are named in the chart, by falling error, from 1; else 0 */
} iso_chart_case;

enum { ISO_CHART_MAX_SCENES = 8 };

/* ISO_E_USAGE with the option and the word. */
iso_status iso_chart_grid_parse(const iso_chart_words *words, iso_chart_grid *g, iso_error *err);

/* first: the pyramid of the first estimator and filter; is_volume: the others can be built. *cases is to be released by
 * iso_chart_cases_free(). Their order: level and step alone, then adapted transfer functions and steps between powers of
 * two, then one departure from the usual choices, then two ..., cheap ones first within each, so that wherever the budget
 * ends, the chart covers all axes, if less densely. Codes and palettes, which differ little, and other programs, which take
 * long, count two; but one image of each other program comes early. Each setting stands there for every scene. */
iso_status iso_chart_grid_cases(const iso_chart_grid *g, const iso_pyramid *first, bool is_volume, size_t scene_count,
                                iso_chart_case **cases, size_t *count, iso_error *err);
void iso_chart_cases_free(iso_chart_case *cases, size_t count); /* accepts NULL */

/* "gl; level 1 adapted TF; fit moments; step 0.5 pre-integrated" */
void iso_chart_describe(const iso_chart_case *c, char *text, size_t size);
/* The code, palette or source. */
void iso_chart_name_shading(const iso_chart_case *c, char *text, size_t size);
/* "original", "adapted", "deviation" or "gradient" (2D transfer functions) */
const char *iso_chart_name_tf(const iso_chart_case *c);
/* What has one color in the chart. */
void iso_chart_describe_series(const iso_chart_case *c, char *text, size_t size);

#endif
