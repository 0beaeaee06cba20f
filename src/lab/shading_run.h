/* SPDX-License-Identifier: MIT */
/* shading_run.h - a run of `isoshade-lab consistency --shading`: shading.c measures, shading_report.c reports. */
#pragma once

#include "lab/shading_error.h"
#include "lab/shading_method.h"
#include "options/cli.h"
#include "options/input.h"

enum { ISO_SHADING_LEVELS = 8, ISO_SHADING_SUBJECTS = 96 };

/* Methods for directions; those from FIRST_ADAPTED on need --adapted. */
enum { ISO_SHADING_METHODS = 12, ISO_SHADING_ON_THE_FLY = 0, ISO_SHADING_DEFAULT = 5, ISO_SHADING_FIRST_ADAPTED = 10 };
extern const iso_shading_method iso_shading_methods[ISO_SHADING_METHODS];

typedef enum iso_shading_block {
    ISO_SHADING_REAL,
    ISO_SHADING_ANALYTIC,
    ISO_SHADING_HELD,
    ISO_SHADING_BLOCKS
} iso_shading_block;

/* A volume of a file, or an analytic one. */
typedef struct iso_shading_volume {
    iso_shading_block block;
    const char *name;
    const char *path; /* file, or NULL: made from the field */
    iso_field_kind kind;
    double noise; /* standard deviation of normal noise, added to values in [0, 1] */
} iso_shading_volume;

/* Results of a volume's level. */
typedef struct iso_shading_result {
    bool done;
    const char *left_out; /* why no mean counts it, or NULL */
    iso_shading_error error[ISO_SHADING_METHODS], floor;
    bool has_floor;
} iso_shading_result;

typedef struct iso_shading_run {
    const iso_cli *cli;
    iso_volume_input input;
    int views, size, levels, analytic_size, adapted, floor, quick, shading;
    double surface;
    char *held, *csv;
    iso_gl *gl;
    size_t subject_count;
    iso_shading_volume subjects[ISO_SHADING_SUBJECTS];
    iso_otsu_surface surfaces[ISO_SHADING_SUBJECTS];
    iso_shading_result *results; /* [subject][level] */
} iso_shading_run;

static inline iso_shading_result *iso_shading_result_of(const iso_shading_run *run, size_t at, size_t level)
{
    return &run->results[at * ISO_SHADING_LEVELS + level];
}

static inline int iso_shading_method_end(const iso_shading_run *run)
{
    return run->adapted ? ISO_SHADING_METHODS : ISO_SHADING_FIRST_ADAPTED;
}

/* Counts the views in which method m is better than gradients on the fly. */
int iso_shading_wins(const iso_shading_run *run, const iso_shading_result *r, int m);
/* Returns why a level counts in no mean, or NULL if it counts: it shows nothing under its original TF (no pixel of any
 * view has an alpha of 1/255), or no method has an error. */
const char *iso_shading_why_left_out(const iso_shading_run *run, const iso_shading_result *r);

/* Prints the table, exceptions and cases left out, or all of it as JSON. */
void iso_shading_report(const iso_shading_run *run);
iso_status iso_shading_write_csv(const iso_shading_run *run, iso_error *err);
