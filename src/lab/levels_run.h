/* SPDX-License-Identifier: MIT */
/* levels_run.h - a run of `isoshade-lab levels`. levels.c is the command, levels_measure.c renders and measures. */
#pragma once

#include "lab/levels_report.h"
#include "options/cli.h"
#include "options/input.h"
#include "renderers/renderers.h"
#include "scene/views.h"

/* A change of a transfer function: a shift, in parts of the volume's range, and a factor of opacities. Levels for a
 * scene are made before it, and seen after it. */
typedef struct iso_levels_edit {
    const char *name;
    double shift, factor;
} iso_levels_edit;
extern const iso_names iso_levels_edit_names;

enum {
    ISO_LEVELS_MAX_VIEWS = ISO_FACE_VIEWS,
    ISO_LEVELS_MAX_LEVELS = 8,
    ISO_LEVELS_MAX_VOLUMES = 96,
    ISO_LEVELS_TF_COUNT = 5
};

/* Names of transfer functions: first the opaque ramp, then those of level_tfs.h. */
extern const char *const iso_levels_tf_names[ISO_LEVELS_TF_COUNT];

typedef struct iso_levels_run {
    const iso_cli *cli;
    iso_volume_input input;
    int views, size, levels, level, unshaded, quick, crop;
    double step_voxels, budget_seconds, start_seconds;
    const char *with, *tfs, *methods, *against;
    char *held, *csv, *have;
    bool wanted_tf[ISO_LEVELS_TF_COUNT];
    const char *edit;
    const iso_levels_edit *edited; /* never NULL */
    const iso_tf *own_tf; /* used instead of these, or NULL */
    bool silent;          /* does not print cases */
    const iso_renderer_info *renderer;
    iso_renderers renderers;
    size_t volume_count, named_count; /* volumes after the first named_count are held back */
    const char *volumes[ISO_LEVELS_MAX_VOLUMES];
    size_t at; /* index of the current volume */
    bool out_of_time;
    double frame_seconds; /* of the last frame */
    iso_level_cases cases;
    size_t had_count; /* of these, the first had_count are from earlier runs */
} iso_levels_run;

/* Finds an edit by its name. ISO_E_USAGE. */
iso_status iso_levels_edit_from_name(const char *name, const iso_levels_edit **edit, iso_error *err);

/* True if the budget is not used up. */
bool iso_levels_has_time(iso_levels_run *run);

/* Measures all cases of volume number run->at that earlier runs did not measure. */
iso_status iso_levels_run_volume(iso_levels_run *run, const iso_progress *progress, iso_error *err);
