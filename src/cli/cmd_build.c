/* SPDX-License-Identifier: MIT */
/* cmd_build.c - builds the pyramid of a volume. */
#define _GNU_SOURCE
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/parallel.h"
#include "base/provenance.h"
#include "options/cli.h"
#include "options/input.h"
#include "options/look.h"
#include "options/visible.h"
#include "plan/optimize.h"
#include "plan/scene_levels.h"
#include "pyramid/agreement.h"
#include "pyramid/pyramid.h"
#include "pyramid/pyramid_stream.h"
#include "scene/scene.h"
#include "scene/subject.h"
#include "tf/presets.h"
#include "volume/format.h"
#include "volume/frames_all.h"
#include "volume/input.h"

typedef struct build_options {
    char *output, *estimator, *scalar_filter, *direction_filter, *code, *scene, *frames, *effort; /* scene: --for */
    iso_volume_input input;
    iso_cli_look look; /* only its transfer function */
    int is_auto;
    int levels, gauss_radius, eq1_exponent, keep_float, keep_magnitude, resume;
    double gauss_sigma, memory_mb, save_seconds;
} build_options;

/* Returns NAME.iso in the current folder; to be freed. */
static char *default_output(const char *input)
{
    const char *name = iso_path_base(input);
    const size_t length = strlen(name) - iso_volume_format_suffix_bytes(name);
    char *path = NULL;
    return asprintf(&path, "%.*s.iso", (int)length, name) < 0 ? NULL : path;
}

static iso_status to_pyramid_options(const build_options *in, const iso_cli *cli, iso_pyramid_options *out,
                                     iso_error *err)
{
    *out = iso_pyramid_defaults();
    if (in->is_auto) {
        out->scalar_filter = ISO_SCALAR_DAMPED;
        out->direction_filter = ISO_DIRECTION_AUTO;
    }
    if (in->estimator)
        NEED(iso_gradient_from_name(in->estimator, &out->gradient.method, err));
    if (in->scalar_filter)
        NEED(iso_scalar_filter_from_name(in->scalar_filter, &out->scalar_filter, err));
    if (in->direction_filter)
        NEED(iso_direction_filter_from_name(in->direction_filter, &out->direction_filter, err));
    if (in->code)
        NEED(iso_code_from_name(in->code, &out->code, err));
    out->level_count = (size_t)in->levels;
    out->gauss_radius = (size_t)in->gauss_radius;
    out->eq1_exponent = (size_t)in->eq1_exponent;
    out->gauss_sigma_voxels = in->gauss_sigma;
    out->keep_float = in->keep_float;
    out->keep_magnitude = in->keep_magnitude;
    out->threads = cli->threads;
    return ISO_OK;
}

static json_t *levels_to_json(const iso_stream_report *r)
{
    json_t *levels = json_array();
    for (size_t k = 0; k < r->level_count; ++k) {
        const size_t *n = r->levels[k].geometry.size;
        json_array_append_new(levels,
                              json_pack("{s:[I,I,I], s:s, s:f, s:f}", "size", (json_int_t)n[0], (json_int_t)n[1],
                                        (json_int_t)n[2], "type", iso_type_name(r->levels[k].type), "min",
                                        r->levels[k].min, "max", r->levels[k].max));
        if (k > 0 && r->choice.is_made)
            json_object_update_new(json_array_get(levels, k), json_pack("{s:s, s:f, s:f}", "direction_filter",
                                                                        iso_direction_filter_name(r->choice.filter[k]),
                                                                        "mean_agreement", r->choice.mean_agreement[k],
                                                                        "axis_agreement", r->choice.axis_agreement[k]));
    }
    return levels;
}

static json_t *to_json(const iso_cli *cli, const iso_pyramid_options *opt, const iso_stream_report *r,
                       const char *output)
{
    json_t *root = iso_cli_json(cli), *options = json_object_get(root, "options");
    json_object_set_new(options, "scalar_filter", json_string(iso_scalar_filter_name(opt->scalar_filter)));
    json_object_set_new(options, "direction_filter", json_string(iso_direction_filter_name(opt->direction_filter)));
    json_object_set_new(options, "estimator", json_string(iso_gradient_name(opt->gradient.method)));
    json_object_set_new(options, "code", json_string(iso_code_describe(opt->code)->name));
    json_object_set_new(root, "output", json_string(output));
    json_object_set_new(root, "levels", levels_to_json(r));
    json_object_set_new(root, "seconds",
                        json_pack("{s:f, s:f, s:f, s:f}", "read", r->seconds_read, "build", r->seconds_build, "write",
                                  r->seconds_write, "total", r->seconds_total));
    json_object_set_new(root, "slab_planes", json_integer((json_int_t)r->slab_planes));
    json_object_set_new(root, "buffer_bytes", json_integer((json_int_t)r->buffer_bytes));
    json_object_set_new(root, "resumed_at_plane", json_integer((json_int_t)r->resumed_at_plane));
    json_object_set_new(root, "peak_rss_bytes", json_real(iso_peak_rss_bytes()));
    return root;
}

static void print_text(const iso_stream_report *r, const char *output, bool is_auto)
{
    for (size_t k = 0; k < r->level_count; ++k) {
        const size_t *n = r->levels[k].geometry.size;
        char text[128];
        printf("level %zu  %zu x %zu x %zu  %s  %.6g to %.6g", k, n[0], n[1], n[2], iso_type_name(r->levels[k].type),
               r->levels[k].min, r->levels[k].max);
        if (k > 0 && r->choice.is_made)
            printf("  %s", iso_direction_choice_text(&r->choice, k, text, sizeof text));
        printf("\n");
    }
    if (r->resumed_at_plane > 0)
        printf("resumed at plane %zu\n", r->resumed_at_plane);
    if (is_auto)
        printf("show the levels with --adapt --extinction-scale\n");
    printf("%s\n", output);
}

typedef struct build_job {
    const iso_cli *cli;
    const iso_volume_input *input;
    const build_options *options;
    iso_ranks *ranks;
} build_job;

/* Options that do not change the pyramid. */
static const char *const not_in_key[] = {"threads", "memory", "save-every", NULL};

static void warn_of_new_start(const iso_cli *cli, const iso_stream_report *r)
{
    if (!r->not_resumed[0] || cli->quiet)
        return;
    iso_progress_line_hide(cli->progress);
    fprintf(stderr, "isoshade build: --resume: %s; the build starts from the beginning\n", r->not_resumed);
}

/* Builds one pyramid. *json receives the printed JSON unless it is NULL; to be freed. */
static iso_status build_one(const build_job *job, const iso_pyramid_options *opt, const char *output, json_t **json,
                            iso_error *err)
{
    const iso_cli *cli = job->cli;
    const char *path = cli->arguments[0];
    iso_stream_report report;
    iso_progress progress = iso_cli_progress(cli);
    const iso_cli_stage stages[] = {{"directions", 1}, {"build", 2}};
    const bool is_given = opt->direction_filter != ISO_DIRECTION_AUTO;
    iso_cli_expect(cli, stages + is_given, 2 - (size_t)is_given);
    iso_subject_file file = {path, job->input};
    const iso_stream_input source = {iso_subject_open, &file, path};
    iso_key *key = iso_cli_key(cli, not_in_key);
    NEED_MEMORY(key, err, "out of memory");
    const iso_stream_options stream = {.memory_bytes = (size_t)(job->options->memory_mb * 1048576),
                                       .resume = job->options->resume,
                                       .save_seconds = job->options->save_seconds,
                                       .key = key,
                                       .ranks = job->ranks};
    const iso_status status = iso_pyramid_stream(&source, opt, &stream, output, &report, &progress, err);
    iso_key_destroy(key);
    NEED(status);
    warn_of_new_start(cli, &report);
    if (cli->json)
        *json = to_json(cli, opt, &report, output);
    else
        print_text(&report, output, job->options->is_auto);
    return ISO_OK;
}

/* Builds a pyramid of each frame, NAME_0000.iso and so on, with the range of all frames. */
static iso_status build_frames(const build_job *job, iso_pyramid_options *opt, const char *output, iso_error *err)
{
    iso_frames_facts facts;
    json_auto_t *all = json_array();
    NEED(iso_frames_measure(job->cli->arguments[0], job->input, &facts, err));
    memcpy(opt->value_range, facts.range, sizeof facts.range);
    for (size_t k = 0; k < facts.count; ++k) {
        char number[24];
        json_t *one = NULL;
        snprintf(number, sizeof number, "%zu", k);
        iso_volume_input input = *job->input;
        input.frame = number;
        build_job frame = *job;
        frame.input = &input;
        FREED char *name = iso_frames_name(output, ".iso", k);
        NEED(name ? build_one(&frame, opt, name, &one, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
        if (one)
            json_array_append_new(all, one);
    }
    if (job->cli->json)
        iso_cli_print_results(job->cli, json_pack("{s:o, s:O}", "value_range", iso_json_numbers(opt->value_range, 2),
                                                  "frames", all));
    else
        printf("%zu frame%s, values %.9g to %.9g\n", facts.count, iso_words_plural(facts.count), opt->value_range[0],
               opt->value_range[1]);
    return ISO_OK;
}

static iso_status check_frames(const build_options *in, const iso_volume_input *input, iso_error *err)
{
    if (in->frames && strcmp(in->frames, "all") != 0)
        return iso_fail(err, ISO_E_USAGE, "--frames is \"%s\", must be all; build one with --frame K", in->frames);
    if (in->frames && (input->frame || in->scene))
        return iso_fail(err, ISO_E_USAGE, "--frames all and %s exclude each other", in->scene ? "--for" : "--frame");
    return ISO_OK;
}

/* Chooses majorities for label maps, which other filters would mix. */
static iso_status choose_filter(const build_job *job, iso_pyramid_options *opt, iso_error *err)
{
    const char *path = job->cli->arguments[0];
    size_t labels = 0;
    const iso_status status = job->options->frames ? iso_frames_labels(path, job->input, &labels, err)
                                                   : iso_volume_input_labels(path, job->input, &labels, err);
    if (status != ISO_OK || labels == 0)
        return status;
    const bool is_named = job->options->scalar_filter || job->options->is_auto;
    if (job->options->scene || (is_named && opt->scalar_filter != ISO_SCALAR_MAJORITY))
        return iso_fail(err, ISO_E_USAGE,
                        "%s: a label map of %zu labels, which %s cannot interpolate; --no-labels reads intensities",
                        path, labels,
                        job->options->scene     ? "--for"
                        : job->options->is_auto ? "--auto"
                                                : "--scalar-filter");
    opt->scalar_filter = ISO_SCALAR_MAJORITY;
    if (!job->cli->json && !job->cli->quiet)
        printf("label map, %zu labels: levels by majority, without interpolation (intensities: --no-labels)\n", labels);
    return ISO_OK;
}

/* Value in --for's list instead of a scene file. */
#define ISO_BUILD_FOR_FIRST "first"

/* The levels that best show scenes or a first picture (plan/scene_levels.h), made in memory and by one process. */
typedef struct made_for {
    const build_job *job;
    size_t scene_count;
    iso_scene scenes[ISO_SCENES_MOST];
    iso_pyramid pyramid;
    iso_scene_level levels[32];
} made_for;

static void made_for_destroy(made_for *m)
{
    iso_pyramid_destroy(&m->pyramid);
    for (size_t i = 0; i < m->scene_count; ++i)
        iso_scene_destroy(&m->scenes[i]);
}

/* Estimates the memory before reading. ISO_E_MEMORY if the levels need more than --memory. */
static iso_status check_memory(const build_job *job, size_t scene_count, iso_effort effort, iso_error *err)
{
    const char *path = job->cli->arguments[0];
    ENDED_BY(iso_source_close_owned) iso_volume_source *source = NULL;
    NEED(iso_volume_input_open(path, job->input, &source, err));
    const iso_volume *v = iso_source_volume(source);
    const double needed = (double)iso_scene_levels_bytes(&v->geometry, v->type, scene_count, effort) / 1048576;
    if (needed > job->options->memory_mb)
        return iso_fail(err, ISO_E_MEMORY, "%s: --for works in memory and needs %.0f MB, --memory is %g", path, needed,
                        job->options->memory_mb);
    return ISO_OK;
}

static const char *scene_name(const iso_scene *scene)
{
    return scene->path ? iso_provenance_name(scene->path) : ISO_BUILD_FOR_FIRST;
}

/* Prints "level 2: fitted, 1 - SSIM .041 (as-built .063, least-squares .049)", with several scenes for each of them. */
static void print_level(const made_for *m, size_t level)
{
    const iso_scene_level *made = &m->levels[level];
    const iso_level_way *way = &iso_level_ways[made->chosen];
    for (size_t s = 0; s < m->scene_count; ++s) {
        const iso_level_candidate *chosen = &made->candidates[s][made->chosen];
        const char *before = " (";
        printf("level %zu: %s%s%s, 1 - SSIM %.4f", level, iso_level_scalar_name(way->scalar),
               way->scaled ? ", scaled" : "", chosen->adapted ? ", under its own TF" : "",
               chosen->seen.ssim_dissimilarity);
        if (m->scene_count > 1)
            printf(", %.2f of the best for %s alone", iso_scene_level_ratio(made, s), scene_name(&m->scenes[s]));
        for (int i = 0; i < ISO_LEVEL_WAY_COUNT; ++i) {
            const iso_level_candidate *c = &made->candidates[s][i];
            if (c == chosen || !c->tried)
                continue;
            printf("%s%s%s %.4f", before, iso_level_scalar_name(iso_level_ways[i].scalar),
                   iso_level_ways[i].scaled ? " scaled" : "", c->seen.ssim_dissimilarity);
            before = ", ";
        }
        printf(")\n");
    }
}

/* Warns of scenes that a level of their own would show better. */
static void warn_of_ratio(const made_for *m, size_t level)
{
    const iso_cli *cli = m->job->cli;
    for (size_t s = 0; s < m->scene_count && !cli->quiet; ++s) {
        const double ratio = iso_scene_level_ratio(&m->levels[level], s);
        if (!(ratio > 1 + ISO_LEVEL_GATE_GAIN))
            continue;
        iso_progress_line_hide(cli->progress);
        fprintf(stderr,
                "isoshade build: warning: level %zu has %.2f times the 1 - SSIM of the best level for %s alone; build "
                "a pyramid for it\n",
                level, ratio, scene_name(&m->scenes[s]));
    }
}

static void print(const made_for *m, const char *output)
{
    const iso_pyramid *p = &m->pyramid;
    for (size_t k = 1; k < p->level_count; ++k)
        warn_of_ratio(m, k);
    if (m->job->cli->json) {
        json_t *seconds = json_array();
        for (size_t k = 1; k < p->level_count; ++k)
            json_array_append_new(seconds, json_real(m->levels[k].seconds));
        iso_cli_print_results(m->job->cli,
                              json_pack("{s:{s:s}, s:s, s:O*, s:o}", "options", "for", m->job->options->scene, "output",
                                        output, "made_for", p->made_for, "seconds_of_levels", seconds));
        return;
    }
    for (size_t k = 0; k < p->level_count; ++k) {
        const iso_level *l = &p->levels[k];
        printf("level %zu  %zu x %zu x %zu  %s  %.6g to %.6g\n", k, l->geometry.size[0], l->geometry.size[1],
               l->geometry.size[2], iso_type_name(l->stored_type), l->min, l->max);
    }
    for (size_t k = 1; k < p->level_count; ++k)
        print_level(m, k);
    printf("%s\n", output);
}

/* Warns if the scene shows nothing, since its levels would be useless. */
static iso_status warn(const made_for *m, const iso_scene *scene, iso_error *err)
{
    OWNED(iso_view) view = {0};
    const iso_level *level0 = &m->pyramid.levels[0];
    NEED(iso_scene_resolve(scene, &level0->geometry, level0->min, level0->max, &view, err));
    iso_cli_warn_view(m->job->cli, &m->pyramid, &view, NULL, &(bool){false});
    return ISO_OK;
}

/* ---- Ctrl-C ends optimizing, and keeps the levels so far ---- */

static volatile sig_atomic_t stop;

static void note_signal(int number)
{
    (void)number;
    stop = 1;
}

static iso_status make_levels(made_for *m, iso_effort effort, const iso_progress *progress, iso_error *err)
{
    const iso_cli *cli = m->job->cli;
    const iso_optimize_options opt = {.effort = effort, .seed = 1, .stop = &stop};
    const bool is_optimized = effort != ISO_EFFORT_NONE;
    struct sigaction own = {.sa_handler = note_signal, .sa_flags = SA_RESTART | SA_RESETHAND}, before;
    sigemptyset(&own.sa_mask);
    if (is_optimized)
        sigaction(SIGINT, &own, &before);
    const iso_status status = iso_scene_levels_make(&m->pyramid, 1, m->scenes, m->scene_count,
                                                    is_optimized ? &opt : NULL, cli->threads, m->levels, progress, err);
    if (is_optimized)
        sigaction(SIGINT, &before, NULL);
    if (stop && !cli->quiet) {
        iso_progress_line_hide(cli->progress);
        fprintf(stderr, "isoshade build: interrupted: the levels are the best so far\n");
    }
    return status;
}

/* Makes a look for each scene of the list. */
static iso_status check_looks(const build_job *job, char *list, iso_subject_look *looks, size_t *count, iso_error *err)
{
    iso_cli_look asked = job->options->look;
    NEED_MEMORY(list, err, "out of memory");
    for (char *rest = list, *name; (name = strsep(&rest, ","));) {
        if (*count == ISO_SCENES_MOST)
            return iso_fail(err, ISO_E_USAGE, "--for: more than %d scenes", ISO_SCENES_MOST);
        asked.scene = strcmp(name, ISO_BUILD_FOR_FIRST) == 0 ? NULL : name;
        NEED(iso_cli_look_check(&asked, job->cli->threads, &looks[(*count)++], err));
    }
    return ISO_OK;
}

static iso_status build_for(const build_job *job, iso_pyramid_options *opt, const char *output, iso_error *err)
{
    const iso_cli *cli = job->cli;
    const char *path = cli->arguments[0];
    const iso_progress progress = iso_cli_progress(cli);
    iso_subject_look looks[ISO_SCENES_MOST];
    FREED char *list = strdup(job->options->scene);
    OWNED(made_for) m = {.job = job};
    OWNED(iso_volume) volume = {0};
    size_t effort = ISO_EFFORT_NORMAL;
    if (job->options->effort)
        NEED(iso_names_find(&iso_effort_names, job->options->effort, &effort, err));
    NEED(check_looks(job, list, looks, &m.scene_count, err));
    NEED(choose_filter(job, opt, err));
    iso_cli_expect(cli, (const iso_cli_stage[]){{"pyramid", 1}, {"levels for the scene", 4}}, 2);
    NEED(check_memory(job, m.scene_count, (iso_effort)effort, err));
    NEED(iso_volume_input_load(path, job->input, &volume, err));
    NEED(iso_pyramid_build(&volume, path, opt, &m.pyramid, &progress, err));
    iso_volume_destroy(&volume); /* the levels need memory */
    for (size_t i = 0; i < m.scene_count; ++i) {
        NEED(iso_subject_make_scene(&looks[i], &m.pyramid, &m.scenes[i], err));
        NEED(warn(&m, &m.scenes[i], err));
    }
    NEED(make_levels(&m, (iso_effort)effort, &progress, err));
    NEED(iso_pyramid_save(&m.pyramid, output, err));
    print(&m, output);
    return ISO_OK;
}

static iso_status check(const build_job *job, iso_error *err)
{
    const build_options *in = job->options;
    const char *path = job->cli->arguments[0];
    if (iso_pyramid_is_one(path))
        return iso_fail(err, ISO_E_USAGE, "%s: a pyramid, which already has levels; give a volume", path);
    if (in->is_auto && (in->scene || in->scalar_filter || in->direction_filter))
        return iso_fail(err, ISO_E_USAGE, "--auto excludes --for, --scalar-filter and --direction-filter");
    if (in->scene && in->resume)
        return iso_fail(err, ISO_E_USAGE, "--for and --resume exclude each other: levels for a scene are made at once");
    if (in->scene && job->ranks)
        return iso_fail(err, ISO_E_USAGE, "--for: levels for a scene are made by one process, without MPI");
    if (!in->scene && in->effort)
        return iso_fail(err, ISO_E_USAGE, "--effort needs --for");
    if (!in->scene && !iso_cli_look_is_empty(&in->look))
        return iso_fail(err, ISO_E_USAGE, "--tf needs --for %s", ISO_BUILD_FOR_FIRST);
    return ISO_OK;
}

static iso_status build(const build_job *job, iso_error *err)
{
    const build_options *in = job->options;
    const char *path = job->cli->arguments[0];
    FREED char *output = in->output ? strdup(in->output) : default_output(path);
    iso_pyramid_options opt;
    json_t *json = NULL;
    NEED(check(job, err));
    NEED(output ? to_pyramid_options(in, job->cli, &opt, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    if (in->scene)
        return build_for(job, &opt, output, err);
    NEED(choose_filter(job, &opt, err));
    if (in->frames)
        return build_frames(job, &opt, output, err);
    NEED(build_one(job, &opt, output, &json, err));
    if (json)
        iso_cli_print_json(json);
    return ISO_OK;
}

/* Silences all ranks but one: results, help and messages are the same in each. */
static iso_status silence_others(iso_error *err)
{
    if (iso_ranks_is_other() && !freopen("/dev/null", "w", stdout))
        return iso_fail(err, ISO_E_IO, "/dev/null: cannot be opened");
    return ISO_OK;
}

static const iso_option options[] = {
    {"output", 'o', "folder of the pyramid (the input's name with .iso)", "NAME.iso", ISO_IN(build_options, output)},
    {"levels", 0, "number of levels, including the finest", "N", ISO_IN(build_options, levels), .flags = ISO_SHOWN,
     .least = 1, .most = 32},
    {"estimator", 0, "gradient estimator of the list below (central)", "NAME", ISO_IN(build_options, estimator)},
    {"scalar-filter", 0, "scalar filter of the list below (mean)", "NAME", ISO_IN(build_options, scalar_filter)},
    {"direction-filter", 0, "direction filter of the list below (moments)", "NAME",
     ISO_IN(build_options, direction_filter)},
    {"code", 0, "direction code of the list below (fit)", "NAME", ISO_IN(build_options, code)},
    {"for", 0, "make coarse levels for these scenes, or for the volume's first picture", "SCENE,SCENE|first",
     ISO_IN(build_options, scene)},
    {"effort", 0, "--for: time for optimized levels (normal)", "none|fast|normal|best", ISO_IN(build_options, effort)},
    {"frames", 0, "build a pyramid of each time step, with one range of values", "all", ISO_IN(build_options, frames)},
    {"auto", 0, "damped scalars and auto directions, for --adapt --extinction-scale", NULL,
     ISO_IN(build_options, is_auto)},
    ISO_OPTIONS_OF(build_options, look, iso_tf_rows),
    {"gauss-radius", 0, "gauss, eq1: radius of the Gaussian in voxels of the finer level", "N",
     ISO_IN(build_options, gauss_radius), .flags = ISO_SHOWN, .least = 1, .most = 16},
    {"gauss-sigma", 0, "gauss, eq1: standard deviation of the Gaussian", "VOXELS", ISO_IN(build_options, gauss_sigma),
     .flags = ISO_SHOWN, .least = 0.1, .most = 100},
    {"eq1-exponent", 0, "eq1: exponent of the gradient magnitude in the weights", "P",
     ISO_IN(build_options, eq1_exponent), .flags = ISO_SHOWN, .most = 4},
    {"keep-float", 0, "also store the directions as floats", NULL, ISO_IN(build_options, keep_float)},
    {"keep-magnitude", 0, "also store the gradient magnitudes", NULL, ISO_IN(build_options, keep_magnitude)},
    {"memory", 0, "limit of the memory for buffers", "MB", ISO_IN(build_options, memory_mb), .flags = ISO_SHOWN,
     .most = 1e9},
    {"resume", 0, "resume a killed build of the same volume and options", NULL, ISO_IN(build_options, resume)},
    {"save-every", 0, "seconds between saved states for --resume; 0: after each slab", "SECONDS",
     ISO_IN(build_options, save_seconds), .flags = ISO_SHOWN, .most = 1e6},
    ISO_OPTIONS_OF(build_options, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    build_options *in = values;
    iso_cli of_rank = *cli;
    iso_ranks *ranks = NULL;
    of_rank.quiet = cli->quiet || iso_ranks_is_other();
    iso_status status = iso_ranks_open(&ranks, err);
    TRY(status, check_frames(in, &in->input, err));
    TRY(status, build(&(build_job){&of_rank, &in->input, in, ranks}, err));
    iso_ranks_close(ranks);
    return status;
}

/* Returns an error on rank 0 only: mpirun ends all ranks when one fails, perhaps before rank 0 has reported the
 * reason. */
static iso_status run_alone_or_as_rank(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    iso_status status = silence_others(err);
    TRY(status, iso_command_parse_and_run(self, argc, argv, err));
    return iso_ranks_is_other() ? ISO_OK : status;
}

const iso_command iso_command_build = {
    .name = "build",
    .summary = "build the pyramid of a volume: scalars and encoded shading directions at several levels",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME [-o NAME.iso] [options]",
    .details =
        "The pyramid is a folder of plain NRRD files and a pyramid.json. The directions of all levels come from\n"
        "the gradients of the finest one. The volume is read in slabs, so it may be larger than memory. Until it is complete\n"
        "the folder is called .NAME.iso.partial. A coarse voxel is the mean of 2x2x2 finer ones. With --scalar-filter\n"
        "least-squares its lookup is as near to level 0 as possible (doc/method/least-squares-levels.md): levels look more\n"
        "similar, but their values may leave the range of level 0; damped levels ring less. (Bricks\n"
        "of mixed resolution, isoshade plan, are made in memory from level 0: doc/results/mixed-resolution.md.)\n"
        "With --direction-filter auto each coarse level gets moments, or tensor if the gradients below its voxels agree\n"
        "better on an axis than in a direction, by 0.4 and more; the volume is read once more for that, and the figures\n"
        "are printed.\n"
        "With --direction-filter least-squares the lookup of directions is nearest to level 0's, weighted by the\n"
        "squared gradient; slabs then keep eight times the planes of scalars (doc/method/least-squares-levels.md).\n"
        "Under mpirun (Open MPI), such as mpirun -n 4 isoshade build big.nrrd, the ranks share the slabs and write the same\n"
        "files together; each rank takes --memory, and --resume works with any number of ranks.\n"
        "With --for each coarse level is the one that shows this scene most like level 0: as built, by least squares,\n"
        "damped, fitted to the scene's transfer function, or optimized by rendering; adapted, or with an extinction\n"
        "scale. Pictures of each decide, and commands show it so. Ctrl-C ends optimizing and keeps the best so far.\n"
        "For several scenes, with transfer functions of one study, each level has a transfer function for each.\n"
        "For each scene the error is printed as a part of that of the best level for it alone.\n"
        "Such levels are made in memory, and suit other scenes less well (doc/method/scene-levels.md). Bricks\n"
        "(isoshade plan) do not need them. --effort none keeps levels that info --verify can make again from level 0.\n"
        "With --auto scalars are damped and directions as with --direction-filter auto. Show such levels with --adapt\n"
        "--extinction-scale: over many volumes this is nearest to level 0, for one more byte per voxel (doc/results/auto.md).",
    .common =
        "output levels for effort auto scalar-filter direction-filter estimator code memory resume spacing frame channel "
        "threads",
    .examples =
        "  isoshade make marschner-lobb --size 40x56x33 --spacing 1x1x2.5 -o v.nrrd\n"
        "  isoshade build v.nrrd -o v.iso --levels 4\n"
        "  isoshade build v.nrrd -o eq1.iso --direction-filter eq1 --gauss-radius 2 --gauss-sigma 1\n"
        "  isoshade build v.nrrd -o ls.iso --scalar-filter least-squares\n"
        "  isoshade build v.nrrd -o for.iso --for refscenes/marschner-lobb.scene.json --effort fast\n"
        "  isoshade build v.nrrd -o two.iso --for refscenes/marschner-lobb.scene.json,refscenes/solid.scene.json "
        "--effort fast\n"
        "  isoshade build v.nrrd -o auto.iso --auto --levels 3\n",
    .lists = (const iso_names *const[]){&iso_gradient_names, &iso_scalar_filter_names, &iso_direction_filter_names,
                                        &iso_code_names, &iso_tf_preset_names, NULL},
    ISO_COMMAND_OPTIONS(build_options, options, .levels = 4, .gauss_radius = 2, .eq1_exponent = 1, .gauss_sigma = 1,
                        .memory_mb = 900, .save_seconds = ISO_STREAM_SAVE_SECONDS),
    .run = run,
    .run_words = run_alone_or_as_rank,
    .shares_ranks = true,
};
