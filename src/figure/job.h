/* SPDX-License-Identifier: MIT */
/* job.h - what a figure is asked for, and the kinds of figures there are.
 *
 * A kind is one struct: its name, a sentence, which inputs and options it takes, and a function that lays a page (page.h)
 * out and puts pictures, plots and text on it. kinds.c has the table; --kind, --help, `isoshade list` and the checks of
 * options read it. The files, their forms and the caption are made from the page, alike for all kinds. */
#ifndef ISO_FIGURE_JOB_H
#define ISO_FIGURE_JOB_H

#include "figure/colormap.h"
#include "figure/page.h"
#include "options/adapted.h"
#include "options/look.h"
#include "options/roi.h"
#include "volume/input.h"

typedef struct iso_figure_info iso_figure_info;

/* Everything that the command line says. Texts that are not given are NULL, numbers 0. */
typedef struct iso_figure_job {
    const iso_figure_info *kind;
    const iso_cli *cli;
    const char *input, *output; /* input: NULL where the kind takes none */
    double width_mm, height_mm; /* of the whole figure, at most: 85 fits one column of many journals, 178 both */
    double dpi;                 /* of its pictures */
    const iso_colormap *map;    /* of its data */
    char *formats;              /* beside the PDF: "svg,png,latex"; NULL: all */
    int with_sources, letters;
    iso_volume_input volume;
    iso_cli_look look;   /* of a report the scene is a name; tf and view: the first of those below */
    char **tfs, **views; /* all that are given, NULL at the end; or NULL */
    iso_cli_adapted adapted;
    char *with, *methods, *variant, *atlas_case;
    double error; /* of a plan */
    bool has_background;
    double background[3]; /* instead of the scene's; linear */
    int level, levels, frames;
    const void *more; /* options that only kinds of another table take, or NULL */
    json_t *facts;   /* an object: what a kind counts and measures, for --json */
    double inset[4]; /* parts of the picture: from the left, from the top, wide, high; zeroed: none */
} iso_figure_job;

enum { ISO_FIGURE_MOST_LEVELS = 16, ISO_FIGURE_MOST_FRAMES = 360 };

/* What a kind takes. */
enum {
    ISO_FIGURE_OF_NOTHING = 1 << 0, /* needs no input */
    ISO_FIGURE_OF_VOLUME = 1 << 1,  /* or of a pyramid */
    ISO_FIGURE_OF_REPORT = 1 << 2,  /* a folder that `isoshade validate` wrote */
    ISO_FIGURE_OF_CHART = 1 << 3,   /* a folder that `isoshade chart` wrote */
    /* Options, beside sizes and --map, which all have. */
    ISO_FIGURE_HAS_LOOK = 1 << 8, /* --scene, --tf, --view, --size */
    ISO_FIGURE_HAS_WITH = 1 << 9,
    ISO_FIGURE_HAS_LEVEL = 1 << 10,
    ISO_FIGURE_HAS_LEVELS = 1 << 11,
    ISO_FIGURE_HAS_METHODS = 1 << 12,
    ISO_FIGURE_HAS_VARIANT = 1 << 13,
    ISO_FIGURE_HAS_ADAPT = 1 << 14,
    ISO_FIGURE_HAS_FRAMES = 1 << 15,
    ISO_FIGURE_HAS_INSET = 1 << 16,
    ISO_FIGURE_HAS_CASE = 1 << 17,
    ISO_FIGURE_HAS_ERROR = 1 << 18,
    ISO_FIGURE_HAS_LOOKS = 1 << 19, /* several of --tf and --view */
    ISO_FIGURE_HAS_MORE = 1 << 20,  /* the first of the options that only kinds of another table take */
};

struct iso_figure_info {
    const char *name;    /* --kind NAME */
    const char *summary; /* what the figure shows, for people */
    unsigned takes;
    /* Of a report or a chart only kinds that take one are asked. The page's caption is written here too. */
    iso_status (*draw)(const iso_figure_job *job, iso_page *page, iso_error *err);
};

extern const iso_figure_info *const iso_figure_kinds[]; /* ends with NULL */
extern const iso_names iso_figure_kind_names;

/* ISO_E_USAGE, with the names that there are. */
iso_status iso_figure_kind_from_name(const iso_names *kinds, const char *name, const iso_figure_info **kind,
                                     iso_error *err);

/* The kind of figure of an input, or of none, where nobody names one. */
const char *iso_figure_usual_kind(const char *input);

/* DIR with the figure in all its forms and its caption, whole or not at all. ISO_E_USAGE and ISO_E_RANGE as the options are;
 * what reading, rendering and drawing give. */
iso_status iso_figure_make(const iso_figure_job *job, iso_error *err);

#endif
