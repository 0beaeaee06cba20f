/* SPDX-License-Identifier: MIT */
/* headlines.h - the figures that the project stands for, each with the command that measures it, its bar and its peer. */
#ifndef ISO_BENCH_HEADLINES_H
#define ISO_BENCH_HEADLINES_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

/* A figure is a number of a command's JSON answer, or the ratio of two. Each is the way to it: keys with dots between
 * them, and for a list the first of its objects that has all the values in brackets, such as
 * cases[tf=dense,loop=plain].milliseconds. "process" holds what the command itself took: seconds, processor_seconds and
 * peak_bytes. */
typedef struct iso_headline {
    const char *name, *sentence;
    const char *command[2]; /* its words, spaces between them; the second one is small and quick */
    const char *figure, *over; /* over: NULL for a number */
    const char *unit, *peer;
    bool lower_is_better;
    double bar; /* NaN: none is set */
} iso_headline;

extern const iso_headline iso_headlines[];
extern const size_t iso_headline_count;

/* ISO_E_FORMAT: the answer has no number there, or it is divided by zero. */
iso_status iso_headline_value(const iso_headline *h, const json_t *answer, double *value, iso_error *err);

#endif
