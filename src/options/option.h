/* SPDX-License-Identifier: MIT */
/* option.h - a command's options: a static table whose rows name members of the command's struct.
 *
 *     typedef struct make_options {
 *         char *output;
 *         int gzip, runs;
 *     } make_options;
 *     static const iso_option options[] = {
 *         {"output", 'o', "NRRD file to write", "FILE", ISO_IN(make_options, output)},
 *         {"gzip", 0, "compress the samples", NULL, ISO_IN(make_options, gzip)},
 *         {"runs", 0, "run N times", "N", ISO_IN(make_options, runs), .flags = ISO_SHOWN, .least = 1, .most = 100},
 *         ISO_OPTIONS_OF(make_options, input, iso_input_rows),
 *         ISO_OPTIONS_END,
 *     };
 *
 * Parsing, --help, completion, the manual page and doc/reference read the same table. A member's type decides how its
 * text is read: char * takes a text, char ** a text each time, int, long, long long and double a number; an int without
 * a value's name is a flag. */
#pragma once

#include <popt.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

typedef enum iso_option_kind {
    ISO_OPTION_TABLE, /* rows of another table */
    ISO_OPTION_TEXT,
    ISO_OPTION_TEXTS,
    ISO_OPTION_INT,
    ISO_OPTION_LONG,
    ISO_OPTION_LONG_LONG,
    ISO_OPTION_DOUBLE
} iso_option_kind;

/* Flags of a row. */
enum {
    ISO_SHOWN = 1,    /* --help shows the default */
    ISO_HIDDEN = 2,   /* --help does not show the option */
    ISO_NOT_ZERO = 4, /* 0 in the member means "not given": 0 on the command line is refused */
    ISO_ONE_OF = 8,   /* `value` lists the texts that are allowed: "svg|pdf" */
};

typedef struct iso_option {
    const char *name;
    char letter;
    const char *help, *value;
    iso_option_kind kind;
    size_t at; /* offset of the member in the command's struct */
    unsigned flags;
    double least, most; /* limits of a number that is given; both 0: none */
    /* Returns the text for --help in memory to be freed, if it depends on other tables; `help` and `about` are for it. */
    char *(*describe)(const struct iso_option *option);
    unsigned about;
    const struct iso_option *table;
} iso_option;

/* Names the member that the option fills. */
#define ISO_IN(type, member) \
    .kind = _Generic(((type *)0)->member,                                                                              \
        char *: ISO_OPTION_TEXT,                                                                                       \
        const char *: ISO_OPTION_TEXT,                                                                                 \
        char **: ISO_OPTION_TEXTS,                                                                                     \
        int: ISO_OPTION_INT,                                                                                           \
        long: ISO_OPTION_LONG,                                                                                         \
        long long: ISO_OPTION_LONG_LONG,                                                                               \
        double: ISO_OPTION_DOUBLE),                                                                                    \
    .at = offsetof(type, member)
/* The rows of a table of options, whose struct is a member of the command's. */
#define ISO_OPTIONS_OF(type, member, rows) \
    { \
        .table = rows, .at = offsetof(type, member) \
    }
#define ISO_OPTIONS_END \
    { \
        0 \
    }

/* A table bound to a struct that it owns. popt[i] and rows[i] describe one option; nested tables are spelled out. */
typedef struct iso_bound_options {
    void *values; /* the command's struct */
    const void *defaults;
    struct poptOption *popt; /* ends with POPT_TABLEEND */
    const iso_option **rows;
    void **texts; /* texts and lists of texts that parsing allocated */
    size_t count;
    bool is_taken;
} iso_bound_options;

/* Makes a struct of `size` bytes with the defaults (NULL: zeros), and binds `rows` to it, which may be NULL.
 * ISO_E_MEMORY. */
iso_status iso_options_bind(const iso_option *rows, size_t size, const void *defaults, iso_bound_options *bound,
                            iso_error *err);

/* Ends parsing: from now on the command may replace its texts. Checks texts of ISO_ONE_OF, and numbers that are not the
 * defaults. ISO_E_USAGE names the option and its limits. */
iso_status iso_options_take(iso_bound_options *bound, iso_error *err);

/* Frees the struct and the texts that parsing put into it. */
void iso_options_unbind(iso_bound_options *bound);
