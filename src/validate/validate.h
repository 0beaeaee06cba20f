/* SPDX-License-Identifier: MIT */
/* validate.h - the parts of `isoshade validate`, the main job.
 *
 *   levels         a pyramid's levels are those of its own level 0, byte by byte (pyramid/pyramid_verify.h)
 *   calibrate      each renderer on volumes whose images are known (calibrate.h)
 *   agreement      each level: every renderer against a closed form or the double-precision reference, by the same
 *                  samples and by extrapolated limits (limits.h), by the scene's tier
 *   adaptation     the TF of each level, or why the original is kept
 *   methods        agreement again, for each way to make directions, and for adapted TFs
 *   artefacts      checks that exports, moved and opened as by a person, render as validated (artefact.h)
 *   consistency    each level, each way to make directions, and either TF, against level 0
 *
 * All of it goes into one report (report/report.h). */
#pragma once

#include "validate/limits.h"
#include "base/progress_line.h"
#include "renderers/renderers.h"
#include "report/report.h"
#include "tf/adapt.h"

/* The adapted TF of a level, or its own (tf/level_look.h). Pyramids that differ only in their directions share it. */
typedef struct iso_level_tf {
    iso_tf_table table;          /* adapted to the level, or a copy of the original */
    iso_adapt_judgment judgment; /* use_original: the original is kept, as always at level 0 */
    /* For iso_validate_scale(), of coarse levels only: one byte per voxel, and the table that the bytes were made
     * for. */
    uint8_t *extinction_scale;
    iso_tf_table scaled_table;
    const uint8_t *own_scale; /* borrowed; goes with `table`, of a level that was made for the view's TF; or NULL */
} iso_level_tf;

/* Additional ways to show levels, besides their own transfer function. */
typedef enum iso_level_scales {
    ISO_SCALES_NONE,
    ISO_SCALES_ADAPTED, /* extinction scales on the adapted TF, also if small views prefer the original: --adapt
                         * --extinction-scale */
    ISO_SCALES_ORIGINAL /* on the original one: --extinction-scale */
} iso_level_scales;

/* Why a renderer is not compared. */
typedef struct iso_refusal {
    iso_status status; /* ISO_OK: it is compared; ISO_E_MISSING; ISO_E_UNTRUSTED: it failed its calibration */
    bool draws;        /* True if its pictures of the calibration are wrong, so that it can show the scene as well */
    char why[512];
} iso_refusal;

typedef struct iso_validation {
    const iso_pyramid *pyramid;
    const iso_scene *scene;
    const iso_view *view;
    const char *volume_path, *scene_path, *scene_name;
    const char *make;         /* of a scene of a suite: the argument of `isoshade make` for the volume; or NULL */
    const char *image_prefix; /* of the report's images: "" or "NAME-" */
    /* Names and options of rows with other directions or TFs; "" and ISO_FROM_CODES for the pyramid's own. */
    const char *variant, *build_options, *render_options;
    const char *input_options; /* of the volume's file, as the command line had them: " --raw-size ..." or "" */
    iso_direction_source source;
    bool loaded; /* the pyramid was read, not built for this validation: its levels are to be verified */
    bool
        is_as_made; /* True if the levels were verified or built here, so that they need not be made again */
    char foreign[512]; /* difference of the first level that is not made from level 0; or "" */
    bool quick;
    double deadline, budget_seconds; /* by iso_clock_seconds(), when nothing more is begun; 0: never */
    enum { ISO_VALIDATE_ALL, ISO_VALIDATE_SAMPLES, ISO_VALIDATE_LIMITS } agreement_part;
    size_t seeds;     /* of random renderers */
    size_t order;     /* in which the report lists the rows of this part */
    double row_start; /* start time of the row's comparison */
    bool wanted[ISO_MAX_RENDERERS];
    bool may_lack; /* True if nobody named the renderers: missing ones are left out, with a remark */
    iso_refusal refused[ISO_MAX_RENDERERS];
    size_t limit_size; /* pixels along the longer edge of the pictures of limits, at most; 0: as many as the others have */
    size_t consistency_size, consistency_views;
    bool may_add_views;      /* twenty, of a level that these leave open */
    iso_level_tf *level_tfs; /* one a level; by iso_validate_adapt() */
    iso_level_scales scales; /* ISO_SCALES_NONE, or the scales that the verdict on levels is based on */
    int threads;
    iso_renderers renderers;
    iso_report *report;
    iso_status (*save_viewer)(const struct iso_validation *v, iso_error *err); /* a page of the volume; or NULL */
    iso_progress_line *line;      /* progress line for the whole run; NULL: none */
    const iso_progress *progress; /* the same, for functions that report progress */
} iso_validation;

/* Adds a row of calibration per level, by the name of "pyramid". Without a loaded pyramid it adds none. */
iso_status iso_validate_levels(iso_validation *v, iso_error *err);

/* Reports versions and calibration of the wanted renderers; fills refused. A missing one is refused, or left out by
 * may_lack: its reason is in the report's "left_out". If that is the default one, the CPU ray caster takes its place. */
iso_status iso_validate_renderers(iso_validation *v, iso_error *err);

/* True if a program failed by itself, so that it is refused and the others go on. */
bool iso_validate_is_its_fault(const iso_renderer_info *which, iso_status status);
/* Returns ISO_E_UNTRUSTED, with the first refused row of a renderer that had passed its calibration; or ISO_OK. */
iso_status iso_validate_refused_later(const iso_validation *v, iso_error *err);
/* Writes how each program was run into the report's "programs". */
void iso_validate_describe_programs(const iso_validation *v);

/* True if the time of --budget has run out; for rows, the reason of skipped checks. */
bool iso_validate_is_out_of_time(const iso_validation *v);
void iso_validate_explain_budget(const iso_validation *v, char why[512]);

/* Compares all levels of v->pyramid, by v->agreement_part. */
iso_status iso_validate_agreement(iso_validation *v, iso_error *err);

/* Returns how many of `count` parts run at a time. */
size_t iso_validate_workers(const iso_validation *v, size_t count);
typedef iso_status (*iso_validation_part)(iso_validation *mine, size_t part, void *user, iso_error *err);
/* Runs parts 0 to count - 1, which do not depend on each other, iso_validate_workers() at a time: programs that start,
 * read and write leave a core idle. Each part gets a copy of *v with renderers of its own; the report lists their rows
 * in the order of the parts. The first failure ends the run. */
iso_status iso_validate_each(iso_validation *v, size_t count, iso_validation_part part, void *user, iso_error *err);

/* Compares one level of v->pyramid: in lock-step, or by extrapolated limits if the samples are not known. */
iso_status iso_validate_variant(iso_validation *v, size_t level, iso_error *err);

/* The ways to make directions. */
typedef struct iso_method {
    const char *name;
    iso_direction_filter filter;
    iso_direction_source source;
} iso_method;
extern const iso_method iso_method_stored; /* the pyramid's own directions; at level 0 those of all filters are equal */
extern const iso_method iso_methods[];
extern const size_t iso_method_count;
/* Builds level 0's scalar again with another direction filter. */
iso_status iso_validate_build_with(const iso_validation *v, iso_direction_filter filter, iso_pyramid *p,
                                   iso_error *err);

/* Adapts the view's TF to each level and sets level_tfs. iso_validate_forget_tfs() releases them; it accepts none. */
iso_status iso_validate_adapt(iso_validation *v, iso_error *err);
void iso_validate_forget_tfs(iso_validation *v);

/* Makes the extinction scales that v->scales asks for: of the pyramid's own scalars, for the view's TF. Needs
 * level_tfs. */
iso_status iso_validate_scale(iso_validation *v, iso_error *err);

/* Returns the view with at most `pixels` pixels along its longer edge (0: any), of the same scene; borrowed, so not to
 * be destroyed. A limit is judged by ratios of means over pixels, which a regular subset shows as well: isoshade-lab
 * power --sensitivity has both. */
iso_view iso_validate_small_view(const iso_view *view, size_t pixels);
enum { ISO_VALIDATE_LIMIT_PIXELS = 96, ISO_VALIDATE_LIMIT_PIXELS_QUICK = 64 };

/* Largest edge of images of other directions and transfer functions: there are many, and they test only arithmetic. */
enum { ISO_VALIDATE_METHOD_PIXELS = 64 };
/* Checks that renderers agree for all directions and transfer functions (methods.c). Needs level_tfs. */
iso_status iso_validate_methods(iso_validation *v, iso_error *err);
/* Measures each level against level 0 and judges it (consistency.c). Needs level_tfs. */
iso_status iso_validate_consistency(iso_validation *v, iso_error *err);

/* Assumes the tier of a scene that states none: smooth or sharp, by the error of a ray step through the TF on this
 * level. */
void iso_validate_assume(const iso_level *level0, const iso_view *view, iso_scene_agreement *agreement);
/* Writes the limits of all rows of the scene, and why, into the report's "asked", by the scene's name. */
void iso_validate_report_asked(const iso_validation *v);

/* Adds a row of the report for a stage that compared nothing, and why. */
iso_status iso_validate_stage_not_run(const iso_validation *v, const char *stage, const char *why, iso_error *err);
/* Adds a row for a stage that the budget left out. */
iso_status iso_validate_stage_left_out(const iso_validation *v, const char *stage, iso_error *err);

/* Compares two versions of a program by their limits of a level: the row that shows what changed between them. */
typedef struct iso_version_limit {
    const iso_renderer_info *renderer;
    const iso_extrapolated *limit; /* kept (validate/limits.h) */
    char image_name[96];           /* in the report */
    char options[64];              /* of the command that makes it again */
} iso_version_limit;
iso_status iso_validate_versions(iso_validation *v, size_t level, const iso_version_limit *first,
                                 const iso_version_limit *other, iso_error *err);
/* True if a limit of this renderer is compared with that of another version. */
bool iso_validate_has_versions(const iso_validation *v, const iso_renderer_info *renderer);

/* Returns a command line that renders image b of a row again and compares it with the report's image a; to be freed.
 * NULL if no command does that. options: of `isoshade render`, besides v's own. */
char *iso_validate_reproduce(const iso_validation *v, size_t level, const iso_renderer_info *renderer,
                             const char *options, const char *image_a, const iso_tolerances *tolerances);

/* Tolerances and gates of validation, which benchmarks and tests use too.
 *
 * The tolerances in lock-step, where a renderer takes the samples that the reference takes: differences come from float
 * instead of double arithmetic, or from the integers of its images, which are coarser the brighter the view can be; a
 * steep (sharp) TF multiplies them. */
iso_tolerances iso_validate_lock_step(const iso_renderer_info *renderer, const iso_view *view, bool sharp);
/* Returns the options for iso_limit_find(): the first step, and the end of the halving. */
iso_limit_options iso_validate_limit_options(const iso_scene_agreement *asked, const iso_renderer_info *renderer,
                                             size_t seeds, int threads);
/* Returns the error bar that the scene asks of a limit, RMSE. */
double iso_validate_error_bar(const iso_scene_agreement *asked);

/* Fills tolerances, gates and error_bar of *row for a limit. It has to meet the reference within its bars, the bars
 * have to be narrow, and the error has to fall at its order. Neither a pixel nor a bias may be beyond chance. */
void iso_validate_limit_row(const iso_scene_agreement *asked, const iso_extrapolated *limit, iso_report_agreement *row);
/* Returns the statistics of a limit, for its row of the report. */
json_t *iso_validate_limit_to_json(const iso_extrapolated *limit);

/* Adds a row of calibration for each program renderer: its export shows the validated picture (artefact.h). */
iso_status iso_validate_artefacts(iso_validation *v, iso_error *err);

/* Adds the steps of a validation of `level_count` levels to the line. hurried: True if there is a budget, which changes
 * their order. */
void iso_validate_expect(iso_progress_line *line, const bool *wanted, size_t level_count, bool hurried);
/* Tells v->line that a row is over: of agreement, not of a method. */
void iso_validate_end_row(const iso_validation *v, const iso_renderer_info *renderer, bool limit);

/* A folder of scenes with a "suite": each one's volume is made, and its agreement validated. */
typedef struct iso_suite_options {
    const char *folder;
    size_t width, height; /* of all images; 0: the scenes' own */
    size_t level_count;
    iso_code code;
    /* Writes the volume that `isoshade make` would make with these words as its arguments. */
    iso_status (*make_volume)(const char *words, const char *path, iso_error *err);
} iso_suite_options;
iso_status iso_validate_suite(iso_validation *v, const iso_suite_options *opt, iso_error *err);
