/* SPDX-License-Identifier: MIT */
/* look.h - the options for what a picture shows, alike in every command that takes a scene or a transfer function.
 *
 *     iso_cli_look look = {0};
 *     struct poptOption options[] = {ISO_CLI_LOOK_OPTIONS(&look), ..., POPT_TABLEEND};
 *     ... iso_cli_parse(...), iso_cli_look_check(&look, threads, &wanted, err) before any work,
 *         iso_subject_make_view(&wanted, &pyramid, &view, err) ...
 *
 * Commands to which a camera means nothing take ISO_CLI_TF_OPTIONS alone. */
#ifndef ISO_OPTIONS_LOOK_H
#define ISO_OPTIONS_LOOK_H

#include <math.h>
#include <popt.h>

#include "options/transfer.h"
#include "scene/subject.h"

typedef struct iso_cli_look {
    char *scene, *tf, *view, *size, *zoom; /* by popt; live until the process ends */
    iso_cli_transfer transfer;
} iso_cli_look;

/* clang-format off */
#define ISO_CLI_SCENE_OPTION(a)                                                                                             \
    {"scene", 0, POPT_ARG_STRING, &(a)->scene, 0, "camera, lights, shading and transfer function (a first picture of what is visible of the volume)", "SCENE.scene.json"}

#define ISO_CLI_TF_OPTIONS(a)                                                                                               \
    {"tf", 0, POPT_ARG_STRING, &(a)->tf, 0, "transfer function: a file, or a preset of isoshade list (the scene's; auto)", "FILE|PRESET"}, \
    ISO_CLI_TRANSFER_OPTIONS(&(a)->transfer)

#define ISO_CLI_ZOOM_OPTION(a)                                                                                              \
    {"zoom", 0, POPT_ARG_STRING, &(a)->zoom, 0, "enlarge the middle of the picture so many times (1)", "X"}

#define ISO_CLI_LOOK_OPTIONS(a)                                                                                             \
    ISO_CLI_SCENE_OPTION(a),                                                                                                \
    ISO_CLI_TF_OPTIONS(a),                                                                                                  \
    {"view", 0, POPT_ARG_STRING, &(a)->view, 0, "where to look from: a name of isoshade list, or degrees (the scene's; front of a patient, else iso)", "NAME|AZ,EL"}, \
    ISO_CLI_ZOOM_OPTION(a),                                                                                                 \
    {"size", 0, POPT_ARG_STRING, &(a)->size, 0, "image size instead of the scene's, or of 512x512", "WxH"}
/* clang-format on */

/* What --step is where it is not given: 0 and NaN are refused, as infinite numbers are of all options. */
#define ISO_STEP_OF_SCENE (-INFINITY)

/* How many times the middle of a picture is enlarged. ISO_E_USAGE with the text or the limits. */
iso_status iso_cli_zoom_parse(const char *text, double *zoom, iso_error *err);

/* None of them is given. */
bool iso_cli_look_is_empty(const iso_cli_look *a);

/* What is asked for, checked as far as it can be before the volume is read. Borrows the texts. ISO_E_USAGE with option and
 * value; what files say that are missing or damaged. */
iso_status iso_cli_look_check(const iso_cli_look *a, int threads, iso_subject_look *look, iso_error *err);
/* The same without looking into files: for commands whose --scene is no single file. */
iso_status iso_cli_look_take(const iso_cli_look *a, int threads, iso_subject_look *look, iso_error *err);

/* " --scene X --view front": the options that are given, as a command line has them; to be freed, NULL: no memory. */
char *iso_cli_look_line(const iso_cli_look *a);

#endif
