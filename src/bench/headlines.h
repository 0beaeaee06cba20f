/* SPDX-License-Identifier: MIT */
/* headlines.h - the project's headline figures, each with the command that measures it, its bar and its peer. */
#pragma once

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

/* A number in a command's JSON answer, or the ratio of two. Each has a path: keys separated by dots. For a list,
 * brackets select the first object with all their values, as in cases[tf=dense,loop=plain].milliseconds. "process"
 * holds the command's own seconds, processor_seconds and peak_bytes. */
typedef struct iso_headline {
    const char *name, *sentence;
    const char *command[2]; /* words separated by spaces; [1] is small and quick */
    const char *figure, *over; /* over: the divisor's path; NULL: no ratio */
    const char *unit, *peer;
    bool lower_is_better;
    double bar; /* NaN: no bar */
} iso_headline;

extern const iso_headline iso_headlines[];
extern const size_t iso_headline_count;

/* Computes the figure. ISO_E_FORMAT: no number at a path, or a division by zero. */
iso_status iso_headline_value(const iso_headline *h, const json_t *answer, double *value, iso_error *err);
