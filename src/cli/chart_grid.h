/* chart_grid.h - the settings that `isoshade chart` tries: a grid of renderer, step, quadrature, estimator, level, direction
 * filter, code, transfer function and plan, without those that would repeat each other. */
#ifndef ISO_CLI_CHART_GRID_H
#define ISO_CLI_CHART_GRID_H

#include "cli/renderers.h"
#include "compare/metrics.h"
#include "tf/histogram.h"

/* Palettes in the grid: one byte and ten bits an index. Each is fitted to the finest level and serves all. */
#define ISO_CHART_PALETTES 2
extern const size_t iso_chart_palettes[ISO_CHART_PALETTES];

#define ISO_CHART_MAX_LIST 16

/* What the user asked for; NULL is the default. */
typedef struct iso_chart_words {
    const char *with, *steps, *quadratures, *codes, *filters, *estimators, *plans;
} iso_chart_words;

/* Which values each axis of the grid has. */
typedef struct iso_chart_grid {
    bool with[ISO_RENDERER_COUNT], codes[ISO_CODE_COUNT], filters[ISO_DIRECTION_COUNT], estimators[ISO_GRADIENT_COUNT];
    bool midpoint, preintegrated;
    double steps[ISO_CHART_MAX_LIST], plans[ISO_CHART_MAX_LIST]; /* voxels; predicted errors */
    size_t step_count, plan_count;
} iso_chart_grid;

/* One setting of the grid, and what it gave. */
typedef struct iso_chart_case {
    iso_renderer renderer;
    size_t level;
    iso_gradient_method estimator;
    iso_direction_filter filter;
    iso_direction_source source;
    iso_code code;
    size_t palette;      /* which of iso_chart_palettes, with ISO_FROM_PALETTE */
    bool adapted;        /* the level's own transfer function */
    iso_joint_split table; /* adapted over two values (tf/class_tables.h), or ISO_SPLIT_NONE */
    bool preintegrated;
    double plan_error;   /* above 0: bricks of mixed resolution planned for this predicted RMSE, instead of a level */
    double step_voxels;
    double relative_cost; /* samples along all rays, times the fetches of one */
    double turn;          /* the least comes first */
    double seconds, bytes;
    iso_metrics metrics;
    bool done, on_time_front, on_bytes_front;
} iso_chart_case;

/* ISO_E_USAGE with the option and the word. */
iso_status iso_chart_grid_parse(const iso_chart_words *words, iso_chart_grid *g, iso_error *err);
/* "1/255" or "0.004": above 0, at most 1. */
iso_status iso_chart_parse_error(const char *option, const char *text, double *error, iso_error *err);

/* pyramids: by estimator and filter, empty where not asked for; `first` is what level 0 and on-the-fly settings use. Cheap
 * settings come first, and other codes than the pyramid's later, since they differ little; *cases is to be freed. */
typedef iso_pyramid iso_chart_pyramids[ISO_GRADIENT_COUNT][ISO_DIRECTION_COUNT];
iso_status iso_chart_grid_cases(const iso_chart_grid *g, iso_chart_pyramids pyramids, iso_gradient_method first_estimator,
                                iso_direction_filter first_filter, iso_chart_case **cases, size_t *count, iso_error *err);

/* "gl; level 1 adapted TF; fit moments; step 0.5 pre-integrated" */
void iso_chart_describe(const iso_chart_case *c, char *text, size_t size);
/* The code, palette or source. */
void iso_chart_name_gradients(const iso_chart_case *c, char *text, size_t size);
/* What has one colour in the chart. */
void iso_chart_describe_series(const iso_chart_case *c, char *text, size_t size);

#endif
