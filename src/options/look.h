/* SPDX-License-Identifier: MIT */
/* look.h - options for the contents of a picture, shared by all commands that take a scene or a transfer function.
 *
 * Call iso_cli_look_check(&look, threads, &wanted, err) before any work, then iso_subject_make_view(&wanted, &pyramid,
 * &view, err). Commands without a camera take only iso_tf_rows. */
#pragma once

#include <math.h>

#include "options/transfer.h"
#include "scene/subject.h"

typedef struct iso_cli_look {
    char *scene, *tf, *view, *size, *zoom;
    iso_cli_transfer transfer;
} iso_cli_look;
extern const iso_option iso_look_rows[], iso_scene_rows[], iso_tf_rows[], iso_zoom_rows[];

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
