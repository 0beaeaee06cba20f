/* SPDX-License-Identifier: MIT */
/* bench.h - measures the settings of a chart: time, bytes and error of each. Pyramids, transfer functions of levels,
 * palettes, plans and the reference image are made when the first setting needs them. */
#ifndef ISO_CHART_BENCH_H
#define ISO_CHART_BENCH_H

#include "brick/bricks.h"
#include "chart/grid.h"
#include "scene/subject.h"
#include "volume/input.h"
#include "plan/plan.h"
#include "tf/tf_2d.h"

enum { ISO_CHART_MAX_LEVELS = 32, ISO_CHART_MAX_OTHERS = 12 };

typedef char iso_chart_version[320]; /* of a renderer, such as "Blender 3.4.1" */

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

/* One of the scenes of a chart, and what is made for it. */
typedef struct iso_chart_scene {
    const char *path; /* the file, or NULL: a first picture */
    char name[128];   /* "brain" of brain.scene.json; unlike the others' */
    iso_scene scene;
    iso_view view;
    iso_tf_table adapted[ISO_CHART_MAX_LEVELS];
    iso_tf_2d tf_2d[ISO_CHART_MAX_LEVELS][2]; /* by deviation and by gradient magnitude */
    iso_plan plan;
    iso_image reference;
    double reference_tolerance, reference_seconds;
} iso_chart_scene;

typedef struct iso_chart_bench {
    const char *path;
    const iso_volume_input *input;
    int threads;
    bool processor_time;
    bool hasty;        /* few frames a setting; of the metrics that take longer than a frame (FLIP, SSIM) none, unless needed */
    bool needs_visual; /* FLIP or SSIM is what the chart shows */
    iso_progress progress;
    bool is_volume;
    iso_pyramid first;                        /* of the first estimator and filter */
    iso_pyramid others[ISO_CHART_MAX_OTHERS]; /* as many as fit in memory, the oldest replaced */
    size_t other_count, replaced;
    iso_chart_scene scenes[ISO_CHART_MAX_SCENES];
    size_t scene_count;
    iso_palette palettes[ISO_CHART_PALETTES];
    iso_node_levels nodes;
    iso_chart_kept kept[ISO_CODE_COUNT * ISO_CHART_MAX_LEVELS];
    size_t kept_count;
    double kept_bytes;
    iso_renderers renderers;
    double metrics_seconds; /* of the last comparison */
    iso_chart_pace pace[ISO_MAX_RENDERERS];
} iso_chart_bench;

/* What a chart is of: a volume or pyramid, and what its pictures show, for each scene. */
typedef struct iso_chart_subject {
    const char *path;
    const iso_volume_input *input;
    const iso_subject_look *looks;
    size_t look_count, level_count;
} iso_chart_subject;

/* Makes the scenes and the first pyramid, which is built by the options of `grid` if the path is a volume. Keeps the
 * pointers. */
iso_status iso_chart_bench_open(iso_chart_bench *b, const iso_chart_subject *subject, const iso_chart_grid *grid,
                                int threads, const iso_progress *progress, iso_error *err);
void iso_chart_bench_close(iso_chart_bench *b); /* accepts empty */

/* A scene's reference image: level 0 of the first pyramid, the scene's own transfer function, no step left, directions as
 * floats where there are any. */
iso_status iso_chart_bench_reference(iso_chart_bench *b, size_t scene, double tolerance, iso_error *err);
/* A pixel's, where pieces of rays are halved: leaves an RMSE of 1e-6; or, where a budget is below 100 s, one that is cheaper and
 * leaves 2e-6 (the ch2 brain), a hundredth of what the finest usual step has. What is bounded: a thousandth, at most 1e-5. */
#define ISO_CHART_TOLERANCE 1e-3
#define ISO_CHART_HASTY_TOLERANCE 0.1
#define ISO_CHART_HASTY_SECONDS 100

/* The estimated seconds of a setting, with all that has to be made for it; a guess until its renderer has been
 * timed. */
double iso_chart_bench_foresee(const iso_chart_bench *b, const iso_chart_case *c);
/* The same of its frame alone; NaN until then. */
double iso_chart_bench_foresee_frame(const iso_chart_bench *b, const iso_chart_case *c);
/* Takes a setting that an earlier run measured for what it says of its renderer's pace. */
void iso_chart_bench_learn(iso_chart_bench *b, const iso_chart_case *c);

/* Fills took, stored_bytes of plans, metrics and done. Frames are drawn again while that is short. */
iso_status iso_chart_bench_measure(iso_chart_bench *b, iso_chart_case *c, iso_error *err);

/* Times a measured setting again. Timings of all settings are spread over the run, so that other work of the machine
 * affects all of them alike. */
iso_status iso_chart_bench_time_again(iso_chart_bench *b, iso_chart_case *c, iso_error *err);

#endif
