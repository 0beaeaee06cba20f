/* SPDX-License-Identifier: MIT */
/* grid.h - the settings that `isoshade chart` tries, most important first: a grid of renderer, step, quadrature,
 * estimator, level, direction filter, code, transfer function and plan. Settings that would repeat others are left
 * out. */
#pragma once

#include "renderers/renderers.h"
#include "compare/metrics.h"
#include "tf/histogram.h"

/* Palettes in the grid: one byte and ten bits per index. Each is fitted to the finest level and used for all levels. */
#define ISO_CHART_PALETTES 2
extern const size_t iso_chart_palettes[ISO_CHART_PALETTES];

/* Bricks of 16 voxels and three levels suit even small volumes. */
enum { ISO_CHART_BRICK_VOXELS = 16, ISO_CHART_BRICK_LEVELS = 3 };

#define ISO_CHART_MAX_LIST 16

/* The user's lists; NULL selects the default, which `isoshade chart --help` prints from here. The default renderers are
 * all except the reference: iso_chart_default_renderers(). */
typedef struct iso_chart_words {
    const char *with, *steps, *quadratures, *codes, *filters, *estimators, *tfs, *plans;
} iso_chart_words;
/* clang-format off */
#define ISO_CHART_DEFAULT_WORDS /* renderers and codes: see the functions below */ \
    {.steps = "4,2,1.5,1,0.75,0.5,0.25,0.125", .quadratures = "midpoint,preintegrated", .filters = "moments,eq1,naive", \
     .estimators = "central,sobel", .tfs = "original,adapted,tf-2d", .plans = "16/255,4/255,1/255"}
/* clang-format on */
/* Lists all codes that a texture can filter, the usual code of pyramids first. Returns text. */
char *iso_chart_default_codes(char *text, size_t size);
const char *iso_chart_default_renderers(char *text, size_t size);

/* Values of each axis of the grid. */
typedef struct iso_chart_grid {
    bool with[ISO_MAX_RENDERERS], codes[ISO_CODE_COUNT], filters[ISO_DIRECTION_COUNT], estimators[ISO_GRADIENT_COUNT];
    bool optional[ISO_MAX_RENDERERS]; /* in the default list: left out if it is missing */
    bool midpoint, preintegrated;
    bool original, adapted, tf_2d;                               /* transfer functions of coarse levels */
    double steps[ISO_CHART_MAX_LIST], plans[ISO_CHART_MAX_LIST]; /* in voxels; predicted RMSE */
    size_t step_count, plan_count;
    iso_gradient_method first_estimator; /* the user's first choices: used by the reference */
    iso_direction_filter first_filter;
    iso_code first_code;
} iso_chart_grid;

/* A setting of the grid, with its measurements. */
typedef struct iso_chart_case {
    size_t scene;   /* index of a scene of the chart */
    size_t setting; /* same number in all scenes */
    const iso_renderer_info *renderer;
    size_t level;
    iso_gradient_method estimator;
    iso_direction_filter filter;
    iso_direction_source source;
    iso_code code;
    size_t palette;          /* index of iso_chart_palettes, with ISO_FROM_PALETTE */
    bool adapted;            /* with the level's own transfer function */
    iso_second_value second; /* of a 2D transfer function (tf/tf_2d.h), or ISO_SECOND_VALUE_NONE */
    bool preintegrated;
    double plan_error; /* above 0: bricks of mixed resolution, planned for this predicted RMSE, instead of a level */
    double step_voxels;
    size_t voxel_count;   /* of the level; of level 0 for a plan */
    double relative_cost; /* samples along all rays, times fetches per sample */
    size_t departures;    /* number of axes, except level and step, that differ from the usual choice */
    size_t turn;          /* grows as a place on a front gets less likely: 2 per departure, 1 for an adapted TF or a
                           * step between powers of two */
    bool needs_pyramid;   /* needs another estimator or filter than the first pyramid */
    iso_render_stats took;
    double stored_bytes;  /* of the level in a pyramid on disk: scalars, directions, scale; of a plan's nodes */
    double build_seconds; /* of an optimized level (plan/scene_levels.h); or 0 */
    iso_metrics metrics;
    bool done, kept;                    /* kept: measured in an earlier run (chart/kept.h) */
    bool refused;                       /* could not be rendered */
    bool put_off;                       /* tried after settings that may lie on a front (chart/order.h) */
    char *picture;                      /* owned; small picture as a data URI, or NULL */
    bool on_time_front, on_bytes_front; /* of its scene */
    bool on_renderer_time_front, on_renderer_bytes_front; /* of its scene and renderer */
    size_t number; /* number in the chart, from 1, by falling error; 0: not named there */
} iso_chart_case;

enum { ISO_CHART_MAX_SCENES = 8 };

/* Parses the lists. ISO_E_USAGE names the option and the word. */
iso_status iso_chart_grid_parse(const iso_chart_words *words, iso_chart_grid *g, iso_error *err);

/* Lists the settings in the order in which they are tried; free *cases with iso_chart_cases_free(). first: pyramid of
 * the first estimator and filter; is_volume: others can be built. Level and step vary first; then adapted transfer
 * functions and steps between powers of two; then one departure from the usual choices, then two, and so on; cheap
 * settings first in each group. So a chart covers all axes when the budget ends, if less densely. Codes and palettes,
 * which differ little, and other programs, which are slow, count as two departures; one image of each other program
 * comes early. Each setting is repeated for every scene. */
iso_status iso_chart_grid_cases(const iso_chart_grid *g, const iso_pyramid *first, bool is_volume, size_t scene_count,
                                iso_chart_case **cases, size_t *count, iso_error *err);
void iso_chart_cases_free(iso_chart_case *cases, size_t count); /* accepts NULL */

/* Writes a setting, e.g. "gl; level 1 adapted TF; fit moments; step 0.5 pre-integrated". */
void iso_chart_describe(const iso_chart_case *c, char *text, size_t size);
/* Writes the code, palette or source. */
void iso_chart_name_shading(const iso_chart_case *c, char *text, size_t size);
/* Returns "original", "adapted", "deviation" or "gradient" (2D transfer functions). */
const char *iso_chart_name_tf(const iso_chart_case *c);
/* Writes the series of a setting: those of a series share a color in the chart. */
void iso_chart_describe_series(const iso_chart_case *c, char *text, size_t size);
