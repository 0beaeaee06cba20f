/* SPDX-License-Identifier: MIT */
/* look.h - options for the contents of a picture, shared by all commands that take a scene or a transfer function.
 *
 *     iso_cli_look look = {0};
 *     struct poptOption options[] = {ISO_CLI_LOOK_OPTIONS(&look), ..., POPT_TABLEEND};
 *     ... iso_cli_parse(...), iso_cli_look_check(&look, threads, &wanted, err) before any work,
 *         iso_subject_make_view(&wanted, &pyramid, &view, err) ...
 *
 * Commands without a camera take only ISO_CLI_TF_OPTIONS. */
#ifndef ISO_OPTIONS_LOOK_H
#define ISO_OPTIONS_LOOK_H

#include <math.h>
#include <popt.h>

#include "options/transfer.h"
#include "scene/subject.h"

typedef struct iso_cli_look {
    char *scene, *tf, *view, *size, *zoom; /* set by popt, live until the process ends */
    iso_cli_transfer transfer;
} iso_cli_look;

/* clang-format off */
#define ISO_CLI_SCENE_OPTION(a)                                                                                             \
    {"scene", 0, POPT_ARG_STRING, &(a)->scene, 0, "camera, lights, shading and transfer function (a first picture)", "SCENE.scene.json"}

#define ISO_CLI_TF_OPTIONS(a)                                                                                               \
    {"tf", 0, POPT_ARG_STRING, &(a)->tf, 0, "transfer function, a file or preset (the scene's; auto)", "FILE|PRESET"}, \
    ISO_CLI_TRANSFER_OPTIONS(&(a)->transfer)

#define ISO_CLI_ZOOM_OPTION(a)                                                                                              \
    {"zoom", 0, POPT_ARG_STRING, &(a)->zoom, 0, "factor to enlarge the middle of the picture (1)", "X"}

#define ISO_CLI_LOOK_OPTIONS(a)                                                                                             \
    ISO_CLI_SCENE_OPTION(a),                                                                                                \
    ISO_CLI_TF_OPTIONS(a),                                                                                                  \
    {"view", 0, POPT_ARG_STRING, &(a)->view, 0, "view direction, a name or degrees (the scene's; front or iso)", "NAME|AZ,EL"}, \
    ISO_CLI_ZOOM_OPTION(a),                                                                                                 \
    {"size", 0, POPT_ARG_STRING, &(a)->size, 0, "image size in pixels (the scene's, or 512x512)", "WxH"}
/* clang-format on */

/* Value of --step if not given: 0, NaN and infinite numbers are refused as options. */
#define ISO_STEP_OF_SCENE (-INFINITY)

/* Reads the factor of --zoom. ISO_E_USAGE names the text or the limits. */
iso_status iso_cli_zoom_parse(const char *text, double *zoom, iso_error *err);

/* True if none of the options is given. */
bool iso_cli_look_is_empty(const iso_cli_look *a);

/* Fills `look` from the options, which it borrows, and checks them as far as possible without the volume. ISO_E_USAGE
 * names the option and its value; missing or damaged files have the statuses of their readers. */
iso_status iso_cli_look_check(const iso_cli_look *a, int threads, iso_subject_look *look, iso_error *err);
/* Does the same without opening files, for commands whose --scene is not a single file. */
iso_status iso_cli_look_take(const iso_cli_look *a, int threads, iso_subject_look *look, iso_error *err);

/* Returns the options that are given as in a command line, " --scene X --view front"; to be freed. NULL: no memory. */
char *iso_cli_look_line(const iso_cli_look *a);

#endif
