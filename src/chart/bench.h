/* SPDX-License-Identifier: MIT */
/* bench.h - what the settings of a chart are measured on: pyramids, transfer functions of levels, palettes and plans,
 * each made when the first setting needs it; the arbiter's image; and one setting's time, bytes and error. */
#ifndef ISO_CHART_BENCH_H
#define ISO_CHART_BENCH_H

#include "brick/bricks.h"
#include "chart/grid.h"
#include "volume/input.h"
#include "plan/plan.h"
#include "tf/tf_2d.h"

enum { ISO_CHART_MAX_LEVELS = 32, ISO_CHART_MAX_OTHERS = 12 };

/* Bytes that were made for one setting and serve others: another code of a level, or a palette's indices. */
typedef struct iso_chart_kept {
    iso_direction_source source;
    iso_code code;
    size_t palette, level;
    void *bytes;
} iso_chart_kept;

/* How long a renderer takes, as far as it has been seen. */
typedef struct iso_chart_pace {
    double setup_seconds;          /* other programs: of their start and export; else a voxel of the model */
    double frame_seconds_per_cost; /* by iso_chart_case.relative_cost */
    bool is_known;
} iso_chart_pace;

typedef struct iso_chart_bench {
    const char *path;
    const iso_volume_input *input;
    int threads;
    bool processor_time;
    iso_progress progress;
    bool is_volume;
    iso_pyramid first;          /* of the first estimator and filter */
    iso_pyramid others[ISO_CHART_MAX_OTHERS]; /* as many as fit in memory, the oldest replaced */
    size_t other_count, replaced;
    iso_view view;
    iso_tf_table adapted[ISO_CHART_MAX_LEVELS];
    iso_tf_2d tf_2d[ISO_CHART_MAX_LEVELS][2]; /* by deviation and by gradient magnitude */
    iso_palette palettes[ISO_CHART_PALETTES];
    iso_node_levels nodes;
    iso_plan plan;
    iso_chart_kept kept[ISO_CODE_COUNT * ISO_CHART_MAX_LEVELS];
    size_t kept_count;
    double kept_bytes;
    iso_renderers renderers;
    iso_image reference;
    double reference_seconds, metrics_seconds; /* of the last comparison */
    iso_chart_pace pace[ISO_MAX_RENDERERS];
} iso_chart_bench;

/* Loads what the chart stands on: the first pyramid, by `grid` where the path is a volume, and the scene. The pointers are
 * kept. */
iso_status iso_chart_bench_open(iso_chart_bench *b, const char *path, const iso_volume_input *input, const char *scene, const char *size,
                                size_t level_count, const iso_chart_grid *grid, int threads, const iso_progress *progress, iso_error *err);
void iso_chart_bench_close(iso_chart_bench *b); /* accepts empty */

/* The arbiter: level 0 of the first pyramid, the scene's own transfer function, no step left, directions as floats where
 * there are any. A tolerance of 1e-3 a pixel costs a quarter of the default and leaves an RMSE of 1e-6. */
iso_status iso_chart_bench_reference(iso_chart_bench *b, iso_error *err);

/* Seconds that a setting will take with all that has to be made for it; a guess until its renderer has been seen. */
double iso_chart_bench_foresee(const iso_chart_bench *b, const iso_chart_case *c);

/* Fills took, stored_bytes of plans, metrics and done. Frames are drawn again while that is short. */
iso_status iso_chart_bench_measure(iso_chart_bench *b, iso_chart_case *c, iso_error *err);

/* Adds frames to those of a setting that is done: spread over the run, what else the machine does meets all alike. */
iso_status iso_chart_bench_time_again(iso_chart_bench *b, iso_chart_case *c, iso_error *err);

#endif
