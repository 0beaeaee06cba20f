/* SPDX-License-Identifier: MIT */
/* report.h - what a validation found, as a directory that explains itself.
 *
 *     DIR/index.html        self-contained: pictures inlined, no network
 *         report.json       the same as data (schema isoshade.validate/1)
 *         images/NAME.exr   what was compared;  NAME.png to look at
 *         charts/NAME.svg   by gnuplot, with the .csv and .gp that make them;
 *                           style.gp is the one file to restyle them all
 *
 * A report is built row by row and appears when it is finished, whole or not
 * at all. Rows may come in any order and from several threads: the page sorts the
 * worst first. Strings are copied. Severity of a row is its largest metric or gate over its limit:
 * above 1 it differs. */
#ifndef ISO_REPORT_H
#define ISO_REPORT_H

#include "base/json.h"
#include "compare/metrics.h"
#include "compare/signal.h"
#include "report/rows.h"

typedef struct iso_report iso_report;

typedef struct iso_report_about {
    const char *title;   /* what was validated, for the heading */
    const char *command; /* the line that makes this report again */
    const char *volume, *scene;
} iso_report_about;

/* An existing DIR is replaced only if it holds a report.json. ISO_E_IO, ISO_E_MEMORY. */
iso_status iso_report_create(iso_report **report, const char *dir, const iso_report_about *about, iso_error *err);
/* Removes a report that was not finished; accepts NULL. */
/* Does it stand in its folder? NULL does not. */
bool iso_report_is_finished(const iso_report *report);
void iso_report_destroy(iso_report *report);

/* The directory as it is called once the report is finished. */
const char *iso_report_path(const iso_report *report);
/* Where other files of the report may be written until it is finished (logs, scenes). */
const char *iso_report_dir(const iso_report *report);

/* A fact under "options", "versions", "machine" or "seconds". Takes the reference to value. */
void iso_report_put(iso_report *report, const char *section, const char *key, json_t *value);
/* Processor, cores, memory, system, under "machine". */
void iso_report_describe_machine(iso_report *report);

/* Saves NAME.exr and NAME.png; rows refer to the name: letters, digits, "-_.". notes as in
 * iso_image_save_exr(). ISO_E_RANGE: a bad name, or one that was used. */
iso_status iso_report_add_image(iso_report *report, const char *name, const iso_image *image, const char *caption,
                                const iso_image_note *notes, iso_error *err);

/* How wide a pixel of the image is, for scale bars; at the center of the box when the camera has a perspective. */
void iso_report_set_scale(iso_report *report, const char *name, double mm_per_pixel);

/* What is asked of two images besides their metrics: enum, key in report.json, name. */
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

/* The value has to be at most the limit. NaN fails. */
typedef struct iso_report_gate {
    iso_gate gate;
    double value, limit;
} iso_report_gate;
enum { ISO_REPORT_MAX_GATES = 6 };

/* Two images that should agree. */
typedef struct iso_report_agreement {
    size_t level, order; /* rows stand in ascending order, those of one order as they came */
    const char *scene;
    const char *a;                 /* what it is compared with: "reference", "closed form" ... */
    const char *renderer;          /* of image b: its name in the table of renderers */
    iso_comparison comparison;     /* how b was made */
    const char *variant;           /* directions and TF of b: "naive, adapted TF"; NULL or "": the scene's own */
    const char *image_a, *image_b; /* names given to iso_report_add_image(), or NULL */
    const char *tier;              /* which kind of agreement is asked: "tight", "convergence" ...; or NULL */
    iso_metrics metrics;
    double error_bar; /* RMSE that the discretization alone explains; NaN: not measured */
    iso_tolerances tolerances;
    size_t gate_count;
    iso_report_gate gates[ISO_REPORT_MAX_GATES];
    json_t *statistics;  /* what the gates were taken from: steps, order, seeds ...; borrowed, or NULL */
    const char *why;     /* why these tolerances */
    double seconds;      /* that rendering and comparing took; 0: not measured */
    const char *command; /* the line that repeats this case, or NULL */
    const char *refused; /* the calibration that failed, with its value; NULL: compared */
    iso_signal signal;   /* of the reference's image; least 0: not measured */
    /* Images that cannot be told apart are not compared, unless they differ: the reason, in a word and as a sentence. */
    iso_uncompared uncompared;
    const char *uncompared_why;
} iso_report_agreement;
/* Agree, differ, refused or not compared. */
iso_verdict iso_report_verdict(const iso_report_agreement *row);
/* The largest metric or gate over its limit. Infinite where nothing can be measured. */
double iso_report_severity(const iso_report_agreement *row);
/* Keeps the row with its verdict. */
iso_status iso_report_add_agreement(iso_report *report, const iso_report_agreement *row, iso_error *err);

/* How far a level is from level 0, which is always under the original TF, with one way to shade it. NaN: not measured.
 * In report.json: level, views, method, tf ("original", "adapted" or "scaled"), original_kept, the five figures, by_view, image and
 * reference_image. */
typedef struct iso_report_consistency {
    size_t level, views;
    const char *method;
    bool adapted;              /* the TF to the level */
    bool scaled;               /* shown with an extinction scale; tf "scaled" */
    const char *original_kept; /* why adapting was refused, so that the figures are the original's; else NULL */
    double ssim_dissimilarity_mean, flip_mean, rmse_mean, gradient_angle_mean_deg, gradient_angle_p95_deg;
    struct {
        const double *ssim_dissimilarity, *flip, *rmse;
    } by_view;                           /* `views` of each, whose means stand above; borrowed, or NULL */
    const char *image, *reference_image; /* one of the views at this level and at level 0, or NULL */
} iso_report_consistency;
iso_status iso_report_add_consistency(iso_report *report, const iso_report_consistency *row, iso_error *err);

/* How charts, figures, baselines and JUnit's XML call a row of report.json's "consistency": "moments" under the
 * original TF, "moments+adapted" under the adapted one, "moments+scaled" with an extinction scale. */
enum { ISO_CONSISTENCY_NAME_BYTES = 128 };
void iso_report_consistency_name(const json_t *row, char name[ISO_CONSISTENCY_NAME_BYTES]);

/* A renderer's fitness before it is compared. Passes when |value| <= limit; NaN: nothing could be measured, which
 * fails, but where it was not asked, since the renderer does not have what the check needs (detail). */
typedef struct iso_report_calibration {
    const char *renderer, *check;
    double value, limit;
    const char *unit, *detail; /* may be NULL */
    bool not_asked;
} iso_report_calibration;
iso_status iso_report_add_calibration(iso_report *report, const iso_report_calibration *row, iso_error *err);

typedef struct iso_report_summary {
    size_t agreed, differed, refused, not_compared; /* agreement rows: all that was asked for */
    size_t by_reason[ISO_UNCOMPARED_COUNT];         /* of not_compared */
    size_t unanswered;                              /* iso_rows_unanswered(): scenes, and renderers in them */
    size_t calibrations_passed, calibrations_failed;
    bool good;  /* no renderer differed, was refused or failed, and something was compared wherever it was asked for */
    bool holds; /* and no row of any section differs (sections.h): the report's verdict */
    char sentence[768];
} iso_report_summary;
iso_report_summary iso_report_summarize(const iso_report *report);

/* Charts, report.json and index.html; then the directory is put in place. Without gnuplot the
 * report has no charts and says so. */
iso_status iso_report_finish(iso_report *report, iso_error *err);

/* The rows as JUnit's XML, for continuous integration; before or after finish. Rows that differ and calibrations that
 * fail are failures, a renderer that is not there is an error, and rows that are refused or not compared are skipped;
 * where that leaves a question open (iso_rows_unanswered()) is a failure. Consistency is measured without a limit: its figures are
 * properties of a suite without cases. */
iso_status iso_report_write_junit(const iso_report *report, const char *path, iso_error *err);

/* The data model, borrowed. */
const json_t *iso_report_json(const iso_report *report);

#endif
