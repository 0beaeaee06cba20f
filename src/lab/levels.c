/* SPDX-License-Identifier: MIT */
/* levels.c - compares all methods to make and show coarse levels, over volumes, transfer functions and views.
 *
 * Level 0 with its own gradients is rendered once per view, and so is every level by every method. Results form two
 * blocks: the volumes by which methods were chosen, and those held back from all choices. */
#include <stdio.h>
#include <string.h>

#include "base/parallel.h"
#include "lab/lab.h"
#include "lab/levels_run.h"
#include "lab/volumes.h"
#include "cli/renderer_help.h"

static const iso_names tf_table = ISO_NAMES_OF_STRINGS("transfer function", iso_levels_tf_names);

static iso_status choose(iso_levels_run *run, iso_error *err)
{
    size_t t;
    iso_status status = iso_level_methods_choose(run->methods, run->cases.wanted, err);
    if (status != ISO_OK)
        return iso_fail_in(err, ISO_E_USAGE, "--methods");
    if (iso_names_find(&iso_level_method_names, run->against, &run->cases.against, err) != ISO_OK)
        return iso_fail_in(err, ISO_E_USAGE, "--against");
    if (iso_renderer_from_name(run->with, &run->renderer, err) != ISO_OK)
        return iso_fail_in(err, ISO_E_USAGE, "--with");
    if (iso_levels_edit_from_name(run->edit, &run->edited, err) != ISO_OK)
        return iso_fail_in(err, ISO_E_USAGE, "--edit");
    run->cases.wanted[run->cases.against] = true;
    for (const char *at = run->tfs; *at;) {
        char name[32];
        const size_t length = strcspn(at, ",");
        snprintf(name, sizeof name, "%.*s", (int)length, at);
        if (iso_names_find(&tf_table, name, &t, err) != ISO_OK)
            return iso_fail_in(err, ISO_E_USAGE, "--tfs");
        run->wanted_tf[t] = true;
        at += length + (at[length] == ',');
    }
    return ISO_OK;
}

/* Lists the given volumes, then those held back (separated by commas, cut here). */
static iso_status list_volumes(iso_levels_run *run, iso_error *err)
{
    for (size_t i = 0; i < run->cli->argument_count && run->volume_count < ISO_LEVELS_MAX_VOLUMES; ++i)
        run->volumes[run->volume_count++] = run->cli->arguments[i];
    run->named_count = run->volume_count;
    for (char *at = run->held; at && *at && run->volume_count < ISO_LEVELS_MAX_VOLUMES;) {
        char *comma = strchr(at, ',');
        if (comma)
            *comma = 0;
        if (*at)
            run->volumes[run->volume_count++] = at;
        at = comma ? comma + 1 : NULL;
    }
    return run->volume_count > 0 || run->have ? ISO_OK : iso_fail(err, ISO_E_USAGE, "no volume given");
}

/* ---- cases of earlier runs ---- */

/* Reads comma-separated tables. Without a volume the tables define the settings. */
static iso_status read_tables(iso_levels_run *run, iso_error *err)
{
    iso_level_cases *c = &run->cases;
    iso_status status = ISO_OK;
    if (run->volume_count > 0)
        snprintf(c->settings, sizeof c->settings, "%d views of %d pixels; step %g; %s; %s%s%s", run->views, run->size,
                 run->step_voxels, run->renderer->name, run->unshaded ? "unshaded" : "shaded",
                 run->edited->shift != 0 || run->edited->factor != 1 ? "; " : "",
                 run->edited->shift != 0 || run->edited->factor != 1 ? run->edit : "");
    for (char *at = run->have; at && *at && status == ISO_OK;) {
        char *comma = strchr(at, ',');
        if (comma)
            *comma = 0;
        status = iso_level_cases_read_csv(c, at, err);
        at = comma ? comma + 1 : NULL;
    }
    run->had_count = c->count;
    return status == ISO_OK || status == ISO_E_IO ? status : iso_fail_in(err, status, "--have");
}

/* Keeps the methods that all cases have: only these can be compared. */
static iso_status keep_methods_of_all(iso_levels_run *run, iso_error *err)
{
    iso_level_cases *c = &run->cases;
    for (size_t m = 0; m < iso_level_method_count(); ++m) {
        const bool asked = c->wanted[m];
        for (size_t i = 0; i < c->count; ++i)
            c->wanted[m] = c->wanted[m] && c->cases[i].results[m].measured;
        if (asked && !c->wanted[m] && run->volume_count > 0 && !run->cli->json)
            printf("%s: left out of the tables, not measured in all cases\n", iso_level_method_at(m)->name);
    }
    return c->wanted[c->against] ? ISO_OK
                                 : iso_fail(err, ISO_E_USAGE, "--against %s: not measured in all cases", run->against);
}

static iso_status check_options(iso_levels_run *run, iso_error *err)
{
    iso_status status = iso_lab_check_pictures(&(iso_lab_pictures){run->views, ISO_LEVELS_MAX_VIEWS, run->size,
                                                                   run->levels, ISO_LEVELS_MAX_LEVELS},
                                               err);
    TRY(status, iso_words_check_range("--level", run->level, 0, run->levels - 1, err));
    TRY(status, choose(run, err));
    if (status == ISO_OK && run->crop)
        status = iso_words_check_range("--crop", run->crop, 16, 4096, err);
    TRY(status, list_volumes(run, err));
    return status == ISO_OK ? read_tables(run, err) : status;
}

static void report(const iso_levels_run *run)
{
    json_t *root = iso_cli_json(run->cli);
    if (!run->cli->json && run->out_of_time)
        printf("\ntime limit reached: some volumes and transfer functions were not measured\n");
    json_object_update_new(json_object_get(root, "options"),
                           json_pack("{s:i, s:i, s:i, s:b, s:f, s:s}", "views", run->views, "size", run->size, "levels",
                                     run->levels, "shaded", !run->unshaded, "step_voxels", run->step_voxels, "with",
                                     run->renderer->name));
    json_object_set_new(root, "against", json_string(iso_level_method_at(run->cases.against)->name));
    json_object_set_new(root, "settings", json_string(run->cases.settings));
    json_object_set_new(root, "complete", json_boolean(!run->out_of_time));
    json_object_set_new(root, "blocks", iso_levels_report(&run->cases, !run->cli->json));
    json_object_set_new(root, "cases", iso_level_cases_to_json(&run->cases));
    if (run->cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
}

static iso_status run_all(iso_levels_run *run, iso_error *err)
{
    if (run->quick) {
        run->views = run->views < 2 ? run->views : 2;
        run->size = run->size < 96 ? run->size : 96;
    }
    const iso_progress progress = iso_cli_progress(run->cli);
    iso_status status = check_options(run, err);
    run->start_seconds = iso_clock_seconds();
    iso_cli_expect(run->cli, &(iso_cli_stage){"levels", 1}, 1);
    if (status == ISO_OK && !run->cli->json && run->volume_count > 0) {
        printf("DSSIM; o: the original TF was kept\n%-24s %-12s k", "volume", "tf");
        for (size_t m = 0; m < iso_level_method_count(); ++m)
            if (run->cases.wanted[m])
                printf(" %8s", iso_level_method_at(m)->name);
        printf("\n");
    }
    for (run->at = 0; run->at < run->volume_count && status == ISO_OK; ++run->at)
        if (iso_levels_has_time(run))
            status = iso_levels_run_volume(run, &progress, err);
    if (status == ISO_OK && run->csv)
        status = iso_level_cases_write_csv(&run->cases, run->csv, err);
    TRY(status, keep_methods_of_all(run, err));
    if (status == ISO_OK)
        report(run);
    iso_level_cases_destroy(&run->cases);
    iso_renderers_end(&run->renderers);
    return status;
}

static const iso_option options[] = {
    {"held", 0, "report these volumes in a separate block", "FILE,FILE", ISO_IN(iso_levels_run, held)},
    {"methods", 0, "compare these methods, or all", "NAMES", ISO_IN(iso_levels_run, methods), .flags = ISO_SHOWN},
    {"against", 0, "divide all errors by this method's", "NAME", ISO_IN(iso_levels_run, against), .flags = ISO_SHOWN},
    {"tfs", 0, "use only these transfer functions", "NAMES", ISO_IN(iso_levels_run, tfs), .flags = ISO_SHOWN},
    {"edit", 0, "change them after levels for a scene were made, by name", "EDIT", ISO_IN(iso_levels_run, edit)},
    {"views", 0, "use N views from an icosahedron's faces, at most 20", "N", ISO_IN(iso_levels_run, views),
     .flags = ISO_SHOWN},
    {"size", 0, "render N x N pixels", "N", ISO_IN(iso_levels_run, size), .flags = ISO_SHOWN},
    {"levels", 0, "use N levels, counting level 0", "N", ISO_IN(iso_levels_run, levels), .flags = ISO_SHOWN},
    {"level", 0, "measure only this level", "K", ISO_IN(iso_levels_run, level)},
    {"step", 0, "set the ray step in voxels of the level", "VOXELS", ISO_IN(iso_levels_run, step_voxels),
     .flags = ISO_SHOWN, .least = 0.01, .most = 4},
    {"unshaded", 0, "show only emission, without a light", NULL, ISO_IN(iso_levels_run, unshaded)},
    {"with", 0, "%s", "RENDERER", ISO_IN(iso_levels_run, with), .flags = ISO_SHOWN,
     ISO_NAMES_CHOICE(ISO_READS_SOURCE | ISO_HAS_2D_TFS)},
    {"quick", 0, "use two views of 96 pixels", NULL, ISO_IN(iso_levels_run, quick)},
    {"budget", 0, "start no new transfer function after this time", "SECONDS", ISO_IN(iso_levels_run, budget_seconds),
     .most = 1e6},
    {"crop", 0, "crop larger volumes to the middle N voxels along each axis", "N", ISO_IN(iso_levels_run, crop)},
    {"csv", 0, "write all cases, updated after each transfer function", "FILE", ISO_IN(iso_levels_run, csv)},
    {"have", 0, "skip cases that are in these tables", "FILE,FILE", ISO_IN(iso_levels_run, have)},
    ISO_OPTIONS_OF(iso_levels_run, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    iso_levels_run *r = values;
    r->cli = cli;
    return run_all(r, err);
}

static const iso_names *const lists[] = {&iso_level_method_names, &iso_levels_edit_names, NULL};

const iso_command iso_lab_levels = {
    .name = "levels",
    .summary = "methods to make and show coarse levels, compared with level 0 and each other",
    .max_arguments = 64,
    .usage = "VOLUME... [--held VOLUME,...] [options]",
    .details =
        "Compares each method's image of a level with that of level 0 with its own gradients, under five transfer\n"
        "functions: an opaque ramp at the surface between the volume's two classes [otsu-1979], and four that are\n"
        "fractions of its range. The reference renders rivals (methods of the literature), --with renders all\n"
        "others.\n"
        "Errors are means over the views of DSSIM = (1 - SSIM) / 2, RMSE and FLIP over visible pixels, and the same\n"
        "of minified images, averaged so that a pixel is about one voxel of the level. The tables contain their\n"
        "ratios to one method's, in two blocks: the given volumes, and those of --held. Cases that show nothing, and\n"
        "those without an error, are left out and counted.\n"
        "Continue an interrupted run with --have TABLE --csv TABLE; without a volume --have prints the tables'\n"
        "summary. --edit changes thresholds by 5 % of the range, or opacities: levels for a scene were made before.",
    .lists = lists,
    .examples =
        "  isoshade make shells --size 48 --type uint8 -o shells.nrrd\n"
        "  isoshade-lab levels shells.nrrd --quick --levels 3 --methods default,original,on-the-fly --csv shells.csv\n"
        "  isoshade-lab levels --have shells.csv --methods default,original\n",
    ISO_COMMAND_OPTIONS(iso_levels_run, options, .views = ISO_LEVELS_MAX_VIEWS, .size = 192, .levels = 4,
                        .step_voxels = 0.5, .with = "gl", .tfs = "opaque,shell,soft,two-material,colored",
                        .methods = "own", .against = "default", .edit = "none"),
    .run = run,
};
