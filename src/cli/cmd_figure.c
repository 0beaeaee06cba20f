/* SPDX-License-Identifier: MIT */
/* cmd_figure.c - makes a publication figure of one of the kinds in src/figure. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/path.h"
#include "base/ranks.h"
#include "cli/rank_run.h"
#include "figure/job.h"
#include "options/cli.h"
#include "options/input.h"
#include "renderers/picture_store.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"

typedef struct figure_arguments {
    iso_figure_job job;
    char *output, *kind, *map, *zoom, *error, *background;
    char *rank_output; /* of a rank other than 0 */
} figure_arguments;

/* Reads --zoom: one number enlarges the middle of the picture, four choose a part of it. */
static iso_status parse_zoom(char *text, iso_figure_job *job, iso_error *err)
{
    double *z = job->inset;
    char after;
    const int count = sscanf(text, "%lf,%lf,%lf,%lf %c", &z[0], &z[1], &z[2], &z[3], &after);
    if (count == 1 && !strchr(text, ',')) {
        memset(job->inset, 0, sizeof job->inset);
        job->look.zoom = text;
        return iso_cli_zoom_parse(text, &(double){0}, err);
    }
    return count == 4 ? ISO_OK : iso_fail(err, ISO_E_USAGE, "--zoom is \"%s\", must be X or X,Y,W,H", text);
}

/* Reads --background: a name, or three parts of linear light. */
static iso_status parse_background(const char *text, iso_figure_job *job, iso_error *err)
{
    double *c = job->background;
    char after;
    job->has_background = true;
    c[0] = c[1] = c[2] = strcmp(text, "white") == 0;
    if (!strcmp(text, "white") || !strcmp(text, "black"))
        return ISO_OK;
    if (sscanf(text, "%lf,%lf,%lf %c", &c[0], &c[1], &c[2], &after) != 3)
        return iso_fail(err, ISO_E_USAGE, "--background is \"%s\", must be white, black or R,G,B", text);
    for (int i = 0; i < 3; ++i)
        if (!(c[i] >= 0 && c[i] <= 1))
            return iso_fail(err, ISO_E_RANGE, "--background is \"%s\", each part must be between 0 and 1", text);
    return ISO_OK;
}

static iso_status take_names(figure_arguments *a, iso_error *err)
{
    NEED(iso_figure_kind_from_name(&iso_figure_kind_names, a->kind ? a->kind : iso_figure_usual_kind(a->job.input),
                                   &a->job.kind, err));
    NEED(iso_colormap_from_name(a->map ? a->map : "magma", &a->job.map, err));
    if (a->error)
        NEED(iso_words_parse_error("--error", a->error, &a->job.error, err));
    if (a->background)
        NEED(parse_background(a->background, &a->job, err));
    return a->zoom ? parse_zoom(a->zoom, &a->job, err) : ISO_OK;
}

static void print_result(const figure_arguments *a)
{
    const iso_figure_job *job = &a->job;
    if (job->cli->json)
        iso_cli_print_results(job->cli,
                              json_pack("{s:{s:s, s:f, s:f, s:f, s:s}, s:s, s:O*}", "options", "kind", job->kind->name,
                                        "width_mm", job->width_mm, "height_mm", job->height_mm, "dpi", job->dpi, "map",
                                        job->map->name, "output", a->output, "facts",
                                        json_object_size(job->facts) ? job->facts : NULL));
    else
        printf("figure: %s\n", a->output);
}

static const iso_option options[] = {
    {"output", 'o', "folder for the figure", "DIR", ISO_IN(figure_arguments, output)},
    {"kind", 0, "kind of figure (levels; of a chart: chart)", "KIND", ISO_IN(figure_arguments, kind)},
    {"width", 0, "largest width; many journals have columns of 85", "MM", ISO_IN(figure_arguments, job.width_mm),
     .flags = ISO_SHOWN},
    {"height", 0, "largest height", "MM", ISO_IN(figure_arguments, job.height_mm), .flags = ISO_SHOWN},
    {"dpi", 0, "resolution of its pictures", "DPI", ISO_IN(figure_arguments, job.dpi), .flags = ISO_SHOWN},
    {"map", 0, "color map of its data (magma)", "MAP", ISO_IN(figure_arguments, map)},
    {"zoom", 0, "enlarge the middle by X, or inset a part, X,Y,W,H in 0 to 1", "X|X,Y,W,H",
     ISO_IN(figure_arguments, zoom)},
    {"background", 0, "background: white, black, or linear R,G,B in 0 to 1 (the scene's)", "COLOR",
     ISO_IN(figure_arguments, background)},
    {"letters", 0, "label the panels (a), (b) and so on", NULL, ISO_IN(figure_arguments, job.letters)},
    {"formats", 0, "formats besides PDF: svg, png, latex (all)", "LIST", ISO_IN(figure_arguments, job.formats)},
    {"sources", 0, "keep the gnuplot script and its pixels", NULL, ISO_IN(figure_arguments, job.with_sources)},
    {"with", 0, "volumes: the renderer (gl, or cpu without hardware OpenGL), or renderers to show (all)", "LIST",
     ISO_IN(figure_arguments, job.with)},
    {"level", 0, "level to show", "K", ISO_IN(figure_arguments, job.level), .flags = ISO_SHOWN, .most = 63},
    {"levels", 0, "number of levels, including level 0 (4)", "N", ISO_IN(figure_arguments, job.levels),
     .flags = ISO_NOT_ZERO, .least = 1, .most = ISO_FIGURE_MOST_LEVELS},
    {"adapt", 0, "volumes: adapt the transfer function to each level", NULL,
     ISO_IN(figure_arguments, job.adapted.wanted)},
    {"frames", 0, "frames of a turntable (8)", "N", ISO_IN(figure_arguments, job.frames), .flags = ISO_NOT_ZERO,
     .least = 2, .most = ISO_FIGURE_MOST_FRAMES},
    {"error", 0, "plan: largest allowed RMSE of the picture (1/255)", "1/255", ISO_IN(figure_arguments, error)},
    {"case", 0, "failure: entry of isoshade atlas (the first)", "NAME", ISO_IN(figure_arguments, job.atlas_case)},
    {"methods", 0, "methods, such as naive,moments+adapted (a report's first and last)", "LIST",
     ISO_IN(figure_arguments, job.methods)},
    {"variant", 0, "a report's renderers: comparisons of this name, such as naive (the scene's own)", "TEXT",
     ISO_IN(figure_arguments, job.variant)},
    ISO_OPTIONS_OF(figure_arguments, job.look, iso_scene_rows),
    {"tf", 0, "transfer function, a file or preset (the scene's; auto); repeatable for sheets", "FILE|PRESET",
     ISO_IN(figure_arguments, job.tfs)},
    ISO_OPTIONS_OF(figure_arguments, job.look.transfer, iso_transfer_rows),
    {"view", 0, "view direction, a name or degrees (the scene's; front or iso); repeatable for sheets", "NAME|AZ,EL",
     ISO_IN(figure_arguments, job.views)},
    {"size", 0, "aspect ratio of the pictures (the scene's, or 1x1)", "WxH", ISO_IN(figure_arguments, job.look.size)},
    ISO_OPTIONS_OF(figure_arguments, job.volume, iso_input_rows),
    ISO_OPTIONS_END,
};

/* Opens the pictures that this rank shares with others of its job; without others, nothing. */
static iso_status open_store(figure_arguments *a, const iso_cli *cli, iso_error *err)
{
    static const char *const without[] = {"threads", NULL};
    iso_figure_job *job = &a->job;
    const iso_ranks_place place = iso_ranks_find_place();
    if (iso_ranks_variable() && !(job->kind->takes & ISO_FIGURE_HAS_RANKS))
        return iso_fail(err, ISO_E_USAGE, "--kind %s: several ranks cannot share it; start one process",
                        job->kind->name);
    if (place.count == 1 || !job->output || !(job->kind->takes & ISO_FIGURE_HAS_RANKS))
        return ISO_OK;
    const char *rank_folder = iso_cli_rank_folder();
    char *folder = iso_cli_work_folder(job->output);
    iso_key *key = iso_cli_key(cli, without);
    iso_status status = folder && key ? iso_key_add_surroundings(key, err)
                                      : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK && rank_folder) {
        status = iso_picture_store_join(folder, key, &place, iso_cli_end_rank, &job->store, err);
        job->end_rank = iso_cli_end_rank;
        job->output = a->rank_output = iso_path_join(rank_folder, "figure");
    } else if (status == ISO_OK) {
        status = iso_picture_store_open(folder, &job->store, err);
        TRY(status, iso_picture_store_begin(job->store, false, key, &place, err));
    }
    iso_key_destroy(key);
    free(folder);
    return status;
}

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    figure_arguments *a = values;
    iso_figure_job *job = &a->job;
    job->cli = job->adapted.cli = cli;
    job->facts = json_object();
    job->look.tf = job->tfs ? job->tfs[0] : NULL;
    job->look.view = job->views ? job->views[0] : NULL;
    job->input = cli->argument_count ? cli->arguments[0] : NULL;
    job->output = a->output;
    iso_status status = take_names(a, err);
    TRY(status, open_store(a, cli, err));
    TRY(status, iso_figure_make(job, err));
    iso_picture_store_close(job->store, true);
    free(a->rank_output);
    if (status == ISO_OK)
        print_result(a);
    json_decref(job->facts);
    return status;
}

const iso_command iso_command_figure = {
    .name = "figure",
    .summary =
        "make a publication figure of a volume, a report or a chart: pictures at print size, difference maps, scale bar",
    .min_arguments = 0,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso|REPORT|CHART -o DIR [--kind KIND] [options]",
    .details =
        "DIR gets figure.pdf and figure.svg with vector text, figure.png, figure-latex.tex for \\input, whose text is set by LaTeX\n"
        "in the fonts of the paper, and caption.txt with the numbers. Pictures of a volume are rendered at print size,\n"
        "one pixel per dot, in the scene's view and aspect. REPORT is a folder that `isoshade\n"
        "validate` wrote; its pictures are enlarged by whole factors, and --scene names one scene of a suite.\n"
        "--sources keeps figure.gp: edit it or style.gp and run gnuplot there.\n"
        "--methods: on-the-fly, naive, eq1 and moments make directions in different ways, under the original transfer function;\n"
        "with +adapted, such as naive+adapted, under the one adapted to each level; optimized is the level of build --for.\n"
        "--kind levels takes default,optimized.\n"
        "Under mpirun or srun, ranks share the frames of --kind turntable by DIR.work, which all must see.",
    .lists = (const iso_names *const[]){&iso_figure_kind_names, &iso_colormap_names, &iso_tf_preset_names,
                                        &iso_viewpoint_names, NULL},
    .common =
        "output kind width height dpi with level levels scene tf view size zoom background letters formats threads",
    .examples =
        "  isoshade make shells --size 40x44x37 -o shells.nrrd\n"
        "  isoshade figure shells.nrrd --levels 3 --width 85 -o figure-volume\n"
        "  isoshade figure shells.nrrd --scene refscenes/shells.scene.json --kind renderers --with gl --width 85 --dpi 150 -o figure-two\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --with gl --size 32 -o report-fig\n"
        "  isoshade figure report-fig -o figure-levels --methods naive,moments,moments+adapted\n"
        "  isoshade figure report-fig -o figure-renderers --kind renderers --level 1\n"
        "  isoshade figure shells.nrrd --kind tf --width 85 -o figure-tf\n"
        "  isoshade figure shells.nrrd --kind sheet --tf auto --tf simulation --view front --view 30,20 --width 85 -o figure-sheet\n"
        "  isoshade figure --kind failure --case thin-plates --width 85 -o figure-failure\n",
    ISO_COMMAND_OPTIONS(figure_arguments, options,
                        .job = {.width_mm = 178, .height_mm = 230, .dpi = 300, .adapted = ISO_CLI_ADAPTED_DEFAULTS}),
    .run = run,
    .run_words = iso_cli_run_as_rank,
    .shares_ranks = true,
};
