/* SPDX-License-Identifier: MIT */
/* job.h - the options of a figure, and the table of kinds of figures.
 *
 * A kind is one struct: its name, a summary, its inputs and options, and a function that lays out a page (page.h)
 * and puts pictures, plots and text on it. kinds.c has the table; --kind, --help, `isoshade list` and the checks of
 * options read it. Files, formats and the caption are made from the page in the same way for all kinds. */
#pragma once

#include "figure/colormap.h"
#include "figure/page.h"
#include "options/adapted.h"
#include "options/look.h"
#include "options/roi.h"
#include "volume/input.h"

typedef struct iso_figure_info iso_figure_info;

/* The command line. Texts that are not given are NULL, numbers 0. */
typedef struct iso_figure_job {
    const iso_figure_info *kind;
    const iso_cli *cli;
    const char *input, *output; /* input: NULL for kinds without one */
    double width_mm, height_mm; /* largest size of the whole figure: 85 fits one column of many journals, 178 both */
    double dpi;                 /* of pictures */
    const iso_colormap *map;    /* for data */
    char *formats;              /* besides the PDF: "svg,png,latex"; NULL: all */
    int with_sources, letters;
    iso_volume_input volume;
    iso_cli_look look;   /* the scene of a report is a name; tf and view: the first of the lists below */
    char **tfs, **views; /* all given ones, NULL at the end; or NULL */
    iso_cli_adapted adapted;
    char *with, *methods, *variant, *atlas_case;
    double error; /* of a plan */
    bool has_background;
    double background[3]; /* in place of the scene's; linear */
    int level, levels, frames;
    const void *more; /* options of kinds of another table, or NULL */
    json_t *facts;    /* an object: counts and measurements of a kind, for --json */
    struct iso_picture_store *store; /* shared with other ranks of the job; borrowed, or NULL */
    void (*end_rank)(void);          /* of a rank other than 0, called after its pictures; does not return. Or NULL */
    double inset[4];  /* as parts of the picture: left, top, width, height; zeroed: none */
} iso_figure_job;

enum { ISO_FIGURE_MOST_LEVELS = 16, ISO_FIGURE_MOST_FRAMES = 360 };

/* Inputs and options of a kind. */
enum {
    ISO_FIGURE_OF_NOTHING = 1 << 0, /* needs no input */
    ISO_FIGURE_OF_VOLUME = 1 << 1,  /* or a pyramid */
    ISO_FIGURE_OF_REPORT = 1 << 2,  /* a folder of `isoshade validate` */
    ISO_FIGURE_OF_CHART = 1 << 3,   /* a folder of `isoshade chart` */
    /* Options, besides sizes and --map, which all kinds have. */
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
    ISO_FIGURE_HAS_RANKS = 1 << 20, /* ranks of one job share the pictures */
    ISO_FIGURE_HAS_MORE = 1 << 21,  /* the first of the options of kinds of another table */
};

struct iso_figure_info {
    const char *name;    /* --kind NAME */
    const char *summary; /* one line for people */
    unsigned takes;
    /* Draws the page and writes its caption. Called for a report or a chart only with that bit of `takes`. */
    iso_status (*draw)(const iso_figure_job *job, iso_page *page, iso_error *err);
};

extern const iso_figure_info *const iso_figure_kinds[]; /* ends with NULL */
extern const iso_names iso_figure_kind_names;

/* Finds a kind. ISO_E_USAGE, with the names that there are. */
iso_status iso_figure_kind_from_name(const iso_names *kinds, const char *name, const iso_figure_info **kind,
                                     iso_error *err);

/* Returns the default kind for an input, or for none. */
const char *iso_figure_usual_kind(const char *input);

/* Makes DIR with the figure in all formats and its caption, completely or not at all. ISO_E_USAGE and ISO_E_RANGE
 * for options; errors of reading, rendering and drawing. */
iso_status iso_figure_make(const iso_figure_job *job, iso_error *err);
