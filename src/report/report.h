/* SPDX-License-Identifier: MIT */
/* report.h - the results of a validation, as a self-contained directory.
 *
 *     DIR/index.html        self-contained: pictures inlined, no network
 *         report.json       the same as data (schema isoshade.validate/1)
 *         images/NAME.exr   the compared images;  NAME.png for viewing
 *         charts/NAME.svg   by gnuplot, with its .csv and .gp;
 *                           style.gp restyles them all
 *
 * A report is built row by row, and appears once it is complete. Rows may come in any order and from several
 * threads: the page sorts the worst first. Strings are copied. The severity of a row is the largest ratio of a metric
 * or gate to its limit: above 1 it differs. */
#pragma once

#include "base/json.h"
#include "compare/metrics.h"
#include "compare/signal.h"
#include "report/rows.h"

typedef struct iso_report iso_report;

typedef struct iso_report_about {
    const char *title;   /* for the heading */
    const char *command; /* command that repeats this report */
    const char *volume, *scene;
} iso_report_about;

/* Begins a report. An existing DIR is replaced only if it has a report.json. ISO_E_IO, ISO_E_MEMORY. */
iso_status iso_report_create(iso_report **report, const char *dir, const iso_report_about *about, iso_error *err);
/* True once the report is in place; false for NULL. */
bool iso_report_is_finished(const iso_report *report);
/* Frees a report, and removes its files unless it is finished; accepts NULL. */
void iso_report_destroy(iso_report *report);

/* Returns the final path of the directory. */
const char *iso_report_path(const iso_report *report);
/* Returns the directory for other files of the report (logs, scenes) until it is finished. */
const char *iso_report_dir(const iso_report *report);

/* Sets a fact under "options", "versions", "machine" or "seconds". Takes the reference to value. */
void iso_report_put(iso_report *report, const char *section, const char *key, json_t *value);
/* Sets processor, cores, memory and system under "machine". */
void iso_report_describe_machine(iso_report *report);

/* Saves NAME.exr and NAME.png; rows refer to the name: letters, digits, "-_.". ISO_E_RANGE: an invalid name, or one that is taken. */
iso_status iso_report_add_image(iso_report *report, const char *name, const iso_image *image, const char *caption,
                                iso_error *err);

/* Sets the width of a pixel, for scale bars; in perspective views at the center of the box. */
void iso_report_set_scale(iso_report *report, const char *name, double mm_per_pixel);

/* Limits of two images besides those of their metrics: enum, key in report.json, name. */
/* clang-format off */
#define ISO_GATE_LIST(X)                                                                   \
    X(ISO_GATE_ERROR_BAR, "error_bar", "error bar")                                        \
    X(ISO_GATE_HALVING, "halving", "left of the error by halving the step")                \
    X(ISO_GATE_PIXELS, "pixels", "pixels beyond chance")                                   \
    X(ISO_GATE_BIAS, "bias", "bias beyond chance")
/* clang-format on */

typedef enum iso_gate {
#define ISO_GATE_ENUM(name, key, text) name,
    ISO_GATE_LIST(ISO_GATE_ENUM)
#undef ISO_GATE_ENUM
        ISO_GATE_COUNT
} iso_gate;
const char *iso_gate_name(iso_gate gate);

/* A value with an upper limit. NaN fails. */
typedef struct iso_report_gate {
    iso_gate gate;
    double value, limit;
} iso_report_gate;
enum { ISO_REPORT_MAX_GATES = 6 };

/* Two images that should agree. */
typedef struct iso_report_agreement {
    size_t level, order; /* rows are sorted by order; those of one order stay as they came */
    const char *scene;
    const char *a;                 /* description of image a: "reference", "closed form" ... */
    const char *renderer;          /* of image b: its name in the table of renderers */
    iso_comparison comparison;     /* kind of comparison */
    const char *variant;           /* directions and TF of b: "naive, adapted TF"; NULL or "": the scene's own */
    const char *image_a, *image_b; /* names given to iso_report_add_image(), or NULL */
    const char *tier;              /* kind of agreement: "tight", "convergence" ...; or NULL */
    iso_metrics metrics;
    double error_bar; /* RMSE due to the discretization alone; NaN: not measured */
    iso_tolerances tolerances;
    size_t gate_count;
    iso_report_gate gates[ISO_REPORT_MAX_GATES];
    json_t *statistics;  /* source of the gates: steps, order, seeds ...; borrowed, or NULL */
    const char *why;     /* reason for these tolerances */
    double seconds;      /* duration of rendering and comparing; 0: not measured */
    const char *command; /* command that repeats this case, or NULL */
    const char *refused; /* failed calibration, with its value; NULL: compared */
    iso_signal signal;   /* of the reference's image; least 0: not measured */
    /* Rows with too little signal are not compared, unless they differ: the reason, as a word and as a sentence. */
    iso_uncompared uncompared;
    const char *uncompared_why;
} iso_report_agreement;
/* Returns agree, differ, refused or not compared. */
iso_verdict iso_report_verdict(const iso_report_agreement *row);
/* Returns the largest ratio of a metric or gate to its limit; infinite if nothing can be measured. */
double iso_report_severity(const iso_report_agreement *row);
/* Adds the row with its verdict. */
iso_status iso_report_add_agreement(iso_report *report, const iso_report_agreement *row, iso_error *err);

/* Distance of a level from level 0 with one way to shade it; level 0 is always under the original TF. NaN: not
 * measured. In report.json: level, views, method, tf ("original", "adapted" or "scaled"), original_kept, the five
 * figures, by_view, image and reference_image. */
typedef struct iso_report_consistency {
    size_t level, views;
    const char *method;
    bool adapted;              /* True for the TF adapted to the level */
    bool scaled;               /* True if shown with an extinction scale; tf "scaled" */
    const char *original_kept; /* reason for which adapting was refused (the figures are the original's); or NULL */
    double ssim_dissimilarity_mean, flip_mean, rmse_mean, gradient_angle_mean_deg, gradient_angle_p95_deg;
    struct {
        const double *ssim_dissimilarity, *flip, *rmse;
    } by_view;                           /* `views` of each; the figures above are their means; borrowed, or NULL */
    const char *image, *reference_image; /* one of the views at this level and at level 0, or NULL */
} iso_report_consistency;
iso_status iso_report_add_consistency(iso_report *report, const iso_report_consistency *row, iso_error *err);

/* Writes the name of a row of report.json's "consistency" in charts, figures, baselines and JUnit's XML: "moments"
 * under the original TF, "moments+adapted" under the adapted one, "moments+scaled" with an extinction scale. */
enum { ISO_CONSISTENCY_NAME_BYTES = 128 };
void iso_report_consistency_name(const json_t *row, char name[ISO_CONSISTENCY_NAME_BYTES]);

/* A check of a renderer before it is compared. It passes if |value| <= limit. NaN: nothing could be measured, which
 * fails, unless the renderer lacks a feature that the check needs (not_asked; detail). */
typedef struct iso_report_calibration {
    const char *renderer, *check;
    double value, limit;
    const char *unit, *detail; /* may be NULL */
    bool not_asked;
} iso_report_calibration;
iso_status iso_report_add_calibration(iso_report *report, const iso_report_calibration *row, iso_error *err);

/* The known mistakes that explain the pictures of a renderer. */
typedef struct iso_report_mistake {
    const char *renderer, *text;
    const char *check;            /* the one of the pictures: */
    const iso_image *pictures[3]; /* wanted, got, and with the mistakes */
} iso_report_mistake;
iso_status iso_report_add_mistake(iso_report *report, const iso_report_mistake *mistake, iso_error *err);

typedef struct iso_report_summary {
    size_t agreed, differed, refused, not_compared; /* agreement rows: all requested ones */
    size_t by_reason[ISO_UNCOMPARED_COUNT];         /* of not_compared */
    size_t unanswered;                              /* iso_rows_unanswered(): scenes, and renderers in them */
    size_t calibrations_passed, calibrations_failed;
    bool good;  /* True if no renderer differed, was refused or failed, and no requested comparison is unanswered */
    bool holds; /* True if also no row of any section differs (sections.h): the report's verdict */
    char sentence[1024];
} iso_report_summary;
iso_report_summary iso_report_summarize(const iso_report *report);

/* Draws the charts, writes report.json and index.html, and puts the directory in place. Without gnuplot the report
 * has no charts; it contains a note. */
iso_status iso_report_finish(iso_report *report, iso_error *err);

/* Writes the rows as JUnit's XML, for continuous integration; before or after finish. Failures: rows that differ,
 * calibrations that fail, and unanswered comparisons (iso_rows_unanswered()). Errors: missing renderers. Skipped:
 * rows that are refused or not compared. Consistency has no limits: its figures are properties of a suite without
 * cases. */
iso_status iso_report_write_junit(const iso_report *report, const char *path, iso_error *err);

/* Returns the data model, borrowed. */
const json_t *iso_report_json(const iso_report *report);
