/* SPDX-License-Identifier: MIT */
/* rows.h - the words of a report's rows, and reading rows again.
 *
 * Each word stands once, in the tables here. */
#ifndef ISO_REPORT_ROWS_H
#define ISO_REPORT_ROWS_H

#include <stddef.h>

#include "base/json.h"

/* What is said of a row: enum, word in report.json, how little it says. What is less certain is worse, also where nothing
 * is known to be wrong: baselines are held by it, and the page lists the worst first. */
/* clang-format off */
#define ISO_VERDICT_LIST(X)                                                                \
    X(ISO_VERDICT_AGREE, "agree", 0)               /* all that is asked is held */         \
    X(ISO_VERDICT_PASS, "pass", 0)                 /* the same of a calibration */         \
    X(ISO_VERDICT_NOT_COMPARED, "not compared", 1) /* nothing to tell images apart by */   \
    X(ISO_VERDICT_REFUSED, "refused", 2)           /* the renderer is missing or unfit */  \
    X(ISO_VERDICT_DIFFER, "differ", 3)                                                     \
    X(ISO_VERDICT_FAIL, "fail", 3)                                                         \
    X(ISO_VERDICT_UNKNOWN, "", 4)                  /* no word, or none of these */
/* clang-format on */

typedef enum iso_verdict {
#define ISO_VERDICT_ENUM(name, word, doubt) name,
    ISO_VERDICT_LIST(ISO_VERDICT_ENUM)
#undef ISO_VERDICT_ENUM
} iso_verdict;

const char *iso_verdict_word(iso_verdict verdict);
int iso_verdict_doubt(iso_verdict verdict);
/* Of a JSON string; of a row of a report. */
iso_verdict iso_verdict_from(const json_t *word);
iso_verdict iso_row_verdict(const json_t *row);

/* Why a row is not compared: enum, word in report.json, how the sentence tells of one and of several. */
/* clang-format off */
#define ISO_UNCOMPARED_LIST(X)                                                             \
    X(ISO_UNCOMPARED_NOT, "", "", "") /* it is compared */                                 \
    X(ISO_UNCOMPARED_FAINT, "signal", "case that shows too little for its limit", "cases that show too little for their limits") \
    X(ISO_UNCOMPARED_TRAIT, "trait", "case that asks for what its renderer does not have", "cases that ask for what their renderer does not have") \
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

/* Of rows of agreement: the scenes that keep a question open, each with the renderers of which no row was compared because
 * the scene shows too little or the budget was over; an empty list where nothing at all was compared. "": of the whole report. A renderer that
 * does not have what a scene asks for, and a stage that did not run, keep no question open while something else is
 * compared. New. */
json_t *iso_rows_unanswered(const json_t *rows);

/* How image b was compared: enum, word in report.json, what the row's name says of it. */
/* clang-format off */
#define ISO_COMPARISON_LIST(X)                                                             \
    X(ISO_COMPARISON_LOCK_STEP, "lock-step", "")             /* the same samples */        \
    X(ISO_COMPARISON_EXACT, "exact lookups", "exact lookups") /* and nothing rounded */    \
    X(ISO_COMPARISON_LIMIT, "limit", "limit")                /* extrapolated to step 0 */  \
    X(ISO_COMPARISON_STATED, "stated limits", "stated limits") /* its own, of few bits */  \
    X(ISO_COMPARISON_FIRST_HIT, "first hit", "")                                           \
    X(ISO_COMPARISON_VERSIONS, "versions", "beside the first") /* limits of two versions of a program */ \
    X(ISO_COMPARISON_CLOSED_FORM, "closed form", "")         /* the reference itself */    \
    X(ISO_COMPARISON_STAGE, "stage", "stage")                /* its variant did not run */
/* clang-format on */

typedef enum iso_comparison {
#define ISO_COMPARISON_ENUM(name, word, said) name,
    ISO_COMPARISON_LIST(ISO_COMPARISON_ENUM)
#undef ISO_COMPARISON_ENUM
        ISO_COMPARISON_COUNT
} iso_comparison;

const char *iso_comparison_word(iso_comparison comparison);

/* What a row of agreement is of. */
typedef struct iso_row_identity {
    char renderer[64];
    iso_comparison comparison;
    char variant[96]; /* directions and TF: "naive, adapted TF"; "" for the scene's own */
} iso_row_identity;
iso_row_identity iso_row_identify(const json_t *row);

/* "gl, limit, naive, adapted TF": how the row is called, which is its "b". */
enum { ISO_ROW_NAME_BYTES = 192 };
void iso_row_name(const char *renderer, iso_comparison comparison, const char *variant, char name[ISO_ROW_NAME_BYTES]);
void iso_row_name_of(const json_t *row, char name[ISO_ROW_NAME_BYTES]);

/* By which pictures a row compares, in a reader's words: "limit of halved steps"; "" where there is nothing to say. */
const char *iso_row_comparison_words(const json_t *row);
/* "gl, limit of halved steps, naive, adapted TF": its name in a reader's words. */
void iso_row_words_of(const json_t *row, char words[ISO_ROW_NAME_BYTES]);

/* Of a row: "" and NaN where there is none; gnuplot leaves NaN out. */
const char *iso_row_text(const json_t *row, const char *key);
double iso_row_number(const json_t *row, const char *key);

#endif
