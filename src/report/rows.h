/* SPDX-License-Identifier: MIT */
/* rows.h - the words of a report's rows, and reading rows again.
 *
 * Each word is defined once, in the tables here. */
#pragma once

#include <stddef.h>

#include "base/json.h"
#include "compare/metrics.h"

/* Verdict of a row: enum, word in report.json, uncertainty. A less certain verdict is worse, even if no error is
 * known: baselines compare it, and the page lists the worst first. */
/* clang-format off */
#define ISO_VERDICT_LIST(X)                                                                \
    X(ISO_VERDICT_AGREE, "agree", 0)               /* within all limits */                 \
    X(ISO_VERDICT_PASS, "pass", 0)                 /* same, for a calibration */           \
    X(ISO_VERDICT_NOT_COMPARED, "not compared", 1) /* too little signal */                 \
    X(ISO_VERDICT_REFUSED, "refused", 2)           /* the renderer is missing or unfit */  \
    X(ISO_VERDICT_DIFFER, "differ", 3)                                                     \
    X(ISO_VERDICT_FAIL, "fail", 3)                                                         \
    X(ISO_VERDICT_UNKNOWN, "", 4)                  /* no word, or an unknown one */
/* clang-format on */

typedef enum iso_verdict {
#define ISO_VERDICT_ENUM(name, word, doubt) name,
    ISO_VERDICT_LIST(ISO_VERDICT_ENUM)
#undef ISO_VERDICT_ENUM
} iso_verdict;

const char *iso_verdict_word(iso_verdict verdict);
int iso_verdict_doubt(iso_verdict verdict);
/* Parses a JSON string; and the verdict of a row. */
iso_verdict iso_verdict_from(const json_t *word);
iso_verdict iso_row_verdict(const json_t *row);

/* Why a row is not compared: enum, word in report.json, words of the sentence for one and for several. */
/* clang-format off */
#define ISO_UNCOMPARED_LIST(X)                                                             \
    X(ISO_UNCOMPARED_NOT, "", "", "") /* it is compared */                                 \
    X(ISO_UNCOMPARED_FAINT, "signal", "case that shows too little for its limit", "cases that show too little for their limits") \
    X(ISO_UNCOMPARED_TRAIT, "trait", "case with a feature that its renderer lacks", "cases with a feature that their renderer lacks") \
    X(ISO_UNCOMPARED_BUDGET, "budget", "case that the budget left out", "cases that the budget left out") \
    X(ISO_UNCOMPARED_FORMULA, "formula", "case of a level that no formula holds for", "cases of levels that no formula holds for") \
    X(ISO_UNCOMPARED_STAGE, "stage", "stage that did not run", "stages that did not run")
/* clang-format on */

typedef enum iso_uncompared {
#define ISO_UNCOMPARED_ENUM(name, word, one, several) name,
    ISO_UNCOMPARED_LIST(ISO_UNCOMPARED_ENUM)
#undef ISO_UNCOMPARED_ENUM
        ISO_UNCOMPARED_COUNT
} iso_uncompared;

const char *iso_uncompared_word(iso_uncompared reason);
const char *iso_uncompared_text(iso_uncompared reason, size_t count);
iso_uncompared iso_row_uncompared(const json_t *row);

/* Returns a new object: the scenes with unanswered comparisons, each with its renderers without any compared row
 * because the scene shows too little or the budget was over. An empty list: no row at all was compared. Key "": the
 * whole report. Lacking features and stages that did not run do not count if anything else was compared. */
json_t *iso_rows_unanswered(const json_t *rows);

/* How image b was compared: enum, word in report.json, word in the row's name. */
/* clang-format off */
#define ISO_COMPARISON_LIST(X)                                                             \
    X(ISO_COMPARISON_LOCK_STEP, "lock-step", "")             /* the same samples */        \
    X(ISO_COMPARISON_EXACT, "exact lookups", "exact lookups") /* and nothing rounded */    \
    X(ISO_COMPARISON_LIMIT, "limit", "limit")                /* extrapolated to step 0 */  \
    X(ISO_COMPARISON_STATED, "stated limits", "stated limits") /* of a renderer with few bits */\
    X(ISO_COMPARISON_FIRST_HIT, "first hit", "")                                           \
    X(ISO_COMPARISON_VERSIONS, "versions", "beside the first") /* limits of two versions of a program */ \
    X(ISO_COMPARISON_CLOSED_FORM, "closed form", "")         /* the reference itself */    \
    X(ISO_COMPARISON_STAGE, "stage", "stage")                /* its variant did not run */
/* clang-format on */

typedef enum iso_comparison {
#define ISO_COMPARISON_ENUM(name, word, in_name) name,
    ISO_COMPARISON_LIST(ISO_COMPARISON_ENUM)
#undef ISO_COMPARISON_ENUM
        ISO_COMPARISON_COUNT
} iso_comparison;

const char *iso_comparison_word(iso_comparison comparison);

/* Identity of a row of agreement. */
typedef struct iso_row_identity {
    char renderer[64];
    iso_comparison comparison;
    char variant[96]; /* directions and TF: "naive, adapted TF"; "" for the scene's own */
} iso_row_identity;
iso_row_identity iso_row_identify(const json_t *row);

/* Writes a row's name, which is its "b": "gl, limit, naive, adapted TF". */
enum { ISO_ROW_NAME_BYTES = 192 };
void iso_row_name(const char *renderer, iso_comparison comparison, const char *variant, char name[ISO_ROW_NAME_BYTES]);
void iso_row_name_of(const json_t *row, char name[ISO_ROW_NAME_BYTES]);

/* Returns the kind of comparison in plain words, "limit of halved steps", or "". */
const char *iso_row_comparison_words(const json_t *row);
/* Writes a row's name in plain words: "gl, limit of halved steps, naive, adapted TF". */
void iso_row_words_of(const json_t *row, char words[ISO_ROW_NAME_BYTES]);

/* Returns a value of a row; "" and NaN if there is none; gnuplot leaves NaN out. */
const char *iso_row_text(const json_t *row, const char *key);
double iso_row_number(const json_t *row, const char *key);
long long iso_row_level(const json_t *row); /* 0 if it has none */
/* Returns the value that a limit of this name applies to. */
double iso_row_metric(const json_t *row, const char *limit);
/* Returns the limits that are set: {"rmse", "max_abs", "p99_abs", "ssim_dissimilarity", "flip_mean"}. */
json_t *iso_tolerances_to_json(const iso_tolerances *limits);
