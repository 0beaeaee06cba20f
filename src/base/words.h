/* SPDX-License-Identifier: MIT */
/* words.h - words of command lines and files: numbers, sizes and quotients read with the end checked, and words quoted
 * for a shell. Errors name the option and its text. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "base/control.h"
#include "base/status.h"

/* Prints a word of a command line, quoted for a shell if needed. */
void iso_words_put_quoted(FILE *f, const char *word);

/* Appends to a text in a buffer of `size` bytes; the rest is cut off. */
void iso_words_append(char *text, size_t size, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* The name nearest to a mistyped word, of those that iso_guess_try() was given. {0}: none yet. */
typedef struct iso_guess {
    const char *name;
    size_t edits;
} iso_guess;
/* Takes `name` if fewer letters than before, and at most one in four of the word and one more, must be changed, added,
 * dropped or swapped. */
void iso_guess_try(iso_guess *guess, const char *word, const char *name);
/* Writes " (did you mean NAME?)" with the prefix before the name, or "" without a guess. Returns text. */
const char *iso_guess_text(const iso_guess *guess, const char *prefix, char text[80]);

/* Returns the ending of a plural: "" for one, otherwise "s". */
const char *iso_words_plural(size_t count);

/* Reads "40x56x33", "1x1x2.5", or one number for all three. ISO_E_USAGE with the text. */
iso_status iso_words_parse_sizes(const char *text, const char *option, size_t out[3], iso_error *err);
iso_status iso_words_parse_numbers(const char *text, const char *option, double out[3], iso_error *err);
/* Reads a number, or a quotient such as "1/255"; *end as strtod has it. */
double iso_words_read_quotient(const char *text, char **end);
/* Reads an image error, "1/255" or "0.004": above 0, at most 1. ISO_E_USAGE with the text. */
iso_status iso_words_parse_error(const char *option, const char *text, double *error, iso_error *err);
/* Checks that a value is in [lo, hi]. ISO_E_USAGE "--option is VALUE, must be LO to HI". NaN fails. */
iso_status iso_words_check_range(const char *option, double value, double lo, double hi, iso_error *err);
