/* SPDX-License-Identifier: MIT */
/* bench.h - measures time, bytes and error of the settings of a chart. Pyramids, transfer functions of levels,
 * palettes, plans and reference images are made on first use. */
#pragma once

#include "brick/bricks.h"
#include "chart/grid.h"
#include "scene/subject.h"
#include "volume/input.h"
#include "plan/plan.h"

enum { ISO_CHART_MAX_LEVELS = 32, ISO_CHART_MAX_OTHERS = 12 };
/* Transfer functions of a level: original, adapted, 2D by deviation, 2D by gradient magnitude. */
enum { ISO_CHART_TFS = 4 };

typedef char iso_chart_version[320]; /* renderer name and version, e.g. "Blender 3.4.1" */

/* Bytes made for one setting and reused by others: a level in another code, or palette indices. */
typedef struct iso_chart_kept {
    iso_direction_source source;
    iso_code code;
    size_t palette, level;
    void *bytes;
} iso_chart_kept;

/* Observed speed of a renderer. */
typedef struct iso_chart_pace {
    double setup_seconds;          /* other programs: start and export; our own: per voxel of the level */
    double frame_seconds_per_cost; /* relative_cost: see iso_chart_case */
    bool is_known;
} iso_chart_pace;

/* A scene of the chart, with all objects made for it. */
typedef struct iso_chart_scene {
    const char *path; /* file; NULL: the first picture */
    char name[128];   /* "brain" of brain.scene.json; unique in the chart */
    iso_scene scene;
    iso_view view;
    iso_view *looks; /* of ISO_CHART_MAX_LEVELS levels under ISO_CHART_TFS transfer functions; empty: not made yet */
    iso_plan_errors plan;
    iso_image reference;
    double reference_tolerance, reference_seconds;
} iso_chart_scene;

typedef struct iso_chart_bench {
    const char *path;
    const iso_volume_input *input;
    int threads;
    bool processor_time;
    bool hasty;        /* True if time is short: fewer frames per setting; FLIP and SSIM only if needed */
    bool needs_visual; /* True if the chart shows FLIP or SSIM */
    iso_progress progress;
    bool is_volume;
    iso_pyramid first;                        /* with the first estimator and filter */
    iso_pyramid others[ISO_CHART_MAX_OTHERS]; /* as many as fit in memory; the oldest is replaced */
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

/* Subject of a chart: a volume or pyramid, and the views of each scene. */
typedef struct iso_chart_subject {
    const char *path;
    const iso_volume_input *input;
    const iso_subject_look *looks;
    size_t look_count, level_count;
} iso_chart_subject;

/* Makes the scenes and the first pyramid, which is built with the options of `grid` if the path is a volume. Keeps the
 * pointers. */
iso_status iso_chart_bench_open(iso_chart_bench *b, const iso_chart_subject *subject, const iso_chart_grid *grid,
                                int threads, const iso_progress *progress, iso_error *err);
void iso_chart_bench_close(iso_chart_bench *b); /* accepts empty */

/* Renders a scene's reference image: level 0 of the first pyramid, the scene's own transfer function, no ray step,
 * float directions if there are any. */
iso_status iso_chart_bench_reference(iso_chart_bench *b, size_t scene, double tolerance, iso_error *err);
/* Tolerances per pixel of the reference. The usual one leaves an RMSE of 1e-6. The hasty one, for budgets below 100 s,
 * leaves 2e-6 (the ch2 brain): a hundredth of the error of the finest usual step. Proved bounds are held to a
 * thousandth of the tolerance, at most 1e-5. */
#define ISO_CHART_TOLERANCE 1e-3
#define ISO_CHART_HASTY_TOLERANCE 0.1
#define ISO_CHART_HASTY_SECONDS 100

/* Estimates the seconds of a setting, with all objects that it still needs; a guess until its renderer has been
 * timed. */
double iso_chart_bench_estimate(const iso_chart_bench *b, const iso_chart_case *c);
/* Estimates the seconds of one frame; NaN until its renderer has been timed. */
double iso_chart_bench_estimate_frame(const iso_chart_bench *b, const iso_chart_case *c);
/* Updates a renderer's speed from a setting that an earlier run measured. */
void iso_chart_bench_learn(iso_chart_bench *b, const iso_chart_case *c);

/* Fills took, stored_bytes of plans, metrics and done. Repeats the frame while repeats are quick. */
iso_status iso_chart_bench_measure(iso_chart_bench *b, iso_chart_case *c, iso_error *err);

/* Times a measured setting again. Repeats are spread over the run, so that load on the machine affects all settings
 * equally. */
iso_status iso_chart_bench_time_again(iso_chart_bench *b, iso_chart_case *c, iso_error *err);
