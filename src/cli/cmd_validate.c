/* SPDX-License-Identifier: MIT */
/* cmd_validate.c - the main job: validates a volume and a scene, and writes a report. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/manifest.h"
#include "base/parallel.h"
#include "base/process.h"
#include "base/provenance.h"
#include "base/ranks.h"
#include "base/unfinished.h"
#include "base/work.h"
#include "cli/made_volume.h"
#include "cli/rank_run.h"
#include "cli/renderer_help.h"
#include "cli/validate.h"
#include "options/visible.h"
#include "render/gl/raycaster.h"
#include "renderers/external.h"
#include "renderers/picture_store.h"
#include "renderers/pictures.h"
#include "report/markdown.h"
#include "scene/subject.h"
#include "scene/viewpoint.h"
#include "scene/views.h"
#include "tf/presets.h"
#include "view/viewer.h"

ISO_ENDING(end_key, iso_key, iso_key_destroy)

static void end_validation(iso_validation *v)
{
    iso_report_destroy(v->report);
    iso_renderers_end(&v->renderers);
    iso_validate_forget_tfs(v);
}

/* Writes DIR/viewer-SCENE.html, and "viewers" in the report, to link rows to their level in the page. Levels with more
 * voxels than a page may hold are left out. */
static iso_status save_viewer(const iso_validation *v, iso_error *err)
{
    FREED char *name = NULL, *path = NULL;
    iso_viewer_size size;
    iso_viewer page = {.pyramid = v->pyramid,
                       .scene = v->scene,
                       .title = iso_provenance_title(v->volume_path),
                       .input = v->input_options,
                       .folder = v->loaded ? v->volume_path : NULL,
                       .last = v->pyramid->level_count - 1,
                       .code_count = 1,
                       .codes = {v->pyramid->options.code},
                       .threads = v->threads};
    page.first = iso_viewer_finest_level(v->pyramid, ISO_VIEWER_MOST_VOXELS);
    if (asprintf(&name, "viewer-%s.html", v->scene_name) < 0 ||
        !(path = iso_path_join(iso_report_dir(v->report), name)))
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    NEED(iso_viewer_save(&page, path, NULL, &size, err));
    iso_report_put(v->report, "viewers", v->scene_name, json_string(name));
    return ISO_OK;
}

/* Takes the options that a scene and a suite share. */
static void take_options(const iso_validate_arguments *a, const iso_cli *cli, iso_picture_store *store,
                         const iso_progress *progress, iso_validation *v)
{
    v->image_prefix = v->variant = v->build_options = v->render_options = "";
    v->quick = a->quick;
    v->may_lack = !a->with;
    v->save_viewer = a->viewer ? save_viewer : NULL;
    v->threads = cli->threads;
    v->seeds = iso_validate_seeds(a);
    v->limit_size = iso_validate_limit_size(a);
    v->renderers.store = store;
    v->line = cli->progress;
    v->progress = progress;
}

/* Scales down a quick run, which keeps every stage and limit, to smaller images and fewer levels. */
static void scale_down(iso_validation *v, iso_scene *scene, const iso_validate_arguments *a)
{
    v->consistency_size = a->level_size ? (size_t)a->level_size : v->quick ? 96 : 160;
    v->may_add_views = !a->level_views;
    v->consistency_views = a->level_views ? (size_t)a->level_views : v->quick ? 3 : 6;
    if (v->quick && !a->look.size) {
        double scale = 96.0 / (double)(scene->width > scene->height ? scene->width : scene->height);
        scene->width = scale < 1 ? (size_t)(scale * (double)scene->width + 0.5) : scene->width;
        scene->height = scale < 1 ? (size_t)(scale * (double)scene->height + 0.5) : scene->height;
    }
}

static void describe_options(const iso_validate_arguments *a, const iso_validation *v, iso_code code)
{
    iso_report *r = v->report;
    iso_report_put(r, "options", "quick", json_boolean(a->quick));
    if (v->pyramid) {
        iso_report_put(r, "options", "levels", json_integer((json_int_t)v->pyramid->level_count));
        iso_report_put(r, "options", "image",
                       json_pack("[I,I]", (json_int_t)v->view->width, (json_int_t)v->view->height));
        iso_report_put(r, "options", "limit_size", json_integer((json_int_t)v->limit_size));
        iso_report_put(r, "options", "level_views", json_integer((json_int_t)v->consistency_views));
        iso_report_put(r, "options", "level_size", json_integer((json_int_t)v->consistency_size));
        if (v->scales != ISO_SCALES_NONE)
            iso_report_put(r, "options", "levels_shown_by",
                           json_string(v->scales == ISO_SCALES_ADAPTED ? "--adapt --extinction-scale"
                                                                       : "--extinction-scale"));
        iso_report_put(r, "options", "step_voxels", json_real(v->view->step_voxels));
        iso_report_put(r, "options", "direction_filter",
                       json_string(iso_direction_filter_name(v->pyramid->options.direction_filter)));
    }
    iso_report_put(r, "options", "code", json_string(iso_code_describe(code)->name));
    iso_report_put(r, "options", "seeds_of_cycles", json_integer((json_int_t)v->seeds));
    iso_report_put(r, "versions", "isoshade", json_string(ISO_VERSION));
    iso_report_describe_machine(r);
}

/* Runs a stage, and records its seconds. */
static iso_status run_stage(iso_validation *v, const char *name, iso_status (*run)(iso_validation *, iso_error *),
                            iso_error *err)
{
    const double start = iso_clock_seconds(), worked = iso_work_sum().processor_seconds;
    iso_progress_report(v->progress, name, 0);
    iso_status status = run(v, err);
    iso_report_put(v->report, "seconds", name, json_real(iso_clock_seconds() - start));
    iso_report_put(v->report, "processor_seconds", name, json_real(iso_work_sum().processor_seconds - worked));
    return status;
}

static iso_status run_stages(iso_validation *v, iso_error *err)
{
    iso_status status = run_stage(v, "levels", iso_validate_levels, err);
    TRY(status, run_stage(v, "calibration", iso_validate_renderers, err));
    /* The rest of the budget goes first to the checks that show most for their time. */
    iso_process_set_deadline(v->deadline);
    const bool hurried = v->deadline > 0;
    v->agreement_part = hurried ? ISO_VALIDATE_SAMPLES : ISO_VALIDATE_ALL;
    TRY(status, run_stage(v, "agreement", iso_validate_agreement, err));
    TRY(status, run_stage(v, "adaptation", iso_validate_adapt, err));
    TRY(status, iso_validate_scale(v, err));
    if (status == ISO_OK && hurried)
        status = run_stage(v, "consistency", iso_validate_consistency, err);
    v->agreement_part = ISO_VALIDATE_LIMITS;
    if (status == ISO_OK && hurried)
        status = run_stage(v, "limits", iso_validate_agreement, err);
    TRY(status, run_stage(v, "methods", iso_validate_methods, err));
    if (status == ISO_OK && !hurried)
        status = run_stage(v, "consistency", iso_validate_consistency, err);
    TRY(status, run_stage(v, "artefacts", iso_validate_artefacts, err));
    iso_process_set_deadline(0);
    return status;
}

/* Reports the started programs, the renders and their processor time. */
static void report_work(iso_report *r)
{
    json_auto_t *work = iso_work_to_json();
    json_t *value;
    const char *key;
    json_object_foreach (work, key, value)
        iso_report_put(r, "work", key, json_incref(value));
}

/* How to resume. Static, because the signal handler prints it. */
static char last_words[4200];

/* Keeps finished pictures next to the report until it is complete, so that an interrupted run can be resumed. Call it
 * before the input is read: it refuses a user's folder, and locks out other runs for the same report. */
static iso_status open_store(const iso_validate_arguments *a, iso_picture_store **store, iso_error *err)
{
    FREED char *folder = iso_cli_work_folder(a->output);
    snprintf(last_words, sizeof last_words, "isoshade validate: stopped; continue from %s with --resume\n",
             folder ? folder : "");
    return folder ? iso_picture_store_open(folder, store, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
}

static iso_status begin_store(const iso_validate_arguments *a, const iso_cli *cli, iso_picture_store **store,
                              iso_error *err)
{
    const iso_ranks_place place = iso_ranks_find_place();
    /* Options that choose the pictures; each picture's own hash has the rest. */
    static const char *const without[] = {"threads", "with",  "levels",     "budget", "anyway",
                                          "viewer",  "junit", "summary-md", NULL};
    ENDED_BY(end_key) iso_key *key = iso_cli_key(cli, without);
    NEED(key ? iso_key_add_surroundings(key, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    if (a->shared)
        return iso_picture_store_join(a->shared, key, &place, iso_cli_end_rank, store, err);
    NEED(iso_picture_store_begin(*store, a->resume, key, &place, err));
    iso_unfinished_say(last_words);
    return ISO_OK;
}

/* Closes the store if it is open. If a signal ended a program and so the run, adds to *err how to resume. */
static iso_status close_store(const iso_validate_arguments *a, iso_picture_store **store, bool remove,
                              iso_status status, iso_error *err)
{
    if (!*store)
        return status;
    FREED char *folder = iso_cli_work_folder(a->output);
    const iso_error why = *err;
    iso_unfinished_say(NULL);
    iso_picture_store_close(*store, remove);
    *store = NULL;
    if (status != ISO_OK && !remove && folder && iso_path_exists(folder) && iso_process_was_stopped())
        iso_fail(err, status, "%s; continue from %s with --resume", why.text, folder);
    return status;
}

/* True if the store is of no more use: the report is complete, or the input was refused and would be again. */
static bool has_no_use(const iso_validation *v, iso_status status)
{
    return iso_report_is_finished(v->report) || status == ISO_E_USAGE || status == ISO_E_FORMAT ||
           status == ISO_E_RANGE;
}

static void begin_budget(const iso_validate_arguments *a, iso_validation *v)
{
    if (a->budget == ISO_NO_BUDGET)
        return;
    v->budget_seconds = a->budget;
    v->deadline = iso_clock_seconds() + a->budget;
    iso_report_put(v->report, "options", "budget_seconds", json_real(a->budget));
}

/* Writes the report in other formats. Files in its folder are replaced with the next report. */
static iso_status write_other_forms(const iso_validate_arguments *a, iso_report *r, iso_error *err)
{
    if (a->junit) {
        NEED(iso_report_write_junit(r, a->junit, err));
        NEED(iso_manifest_add_output(a->output, a->junit, err));
    }
    if (!a->summary_md)
        return ISO_OK;
    FREED char *page = iso_path_join(iso_markdown_target(a->output), "index.html");
    NEED(iso_markdown_of_report(a->summary_md, iso_report_json(r), page, err));
    return iso_manifest_add_output(a->output, a->summary_md, err);
}

/* Writes summary, charts and page. Returns the verdict. */
static iso_status finish(const iso_validate_arguments *a, const iso_cli *cli, iso_validation *v, iso_error *err)
{
    iso_validate_describe_programs(v);
    report_work(v->report);
    if (a->resume)
        iso_report_put(v->report, "work", "pictures_taken",
                       json_integer((json_int_t)iso_picture_store_taken(v->renderers.store)));
    const iso_report_summary summary = iso_report_summarize(v->report);
    const iso_levels_summary levels = iso_levels_summarize(iso_report_json(v->report));
    iso_progress_report(v->progress, "report", 0);
    iso_status status = iso_report_finish(v->report, err);
    TRY(status, write_other_forms(a, v->report, err));
    iso_progress_line_hide(v->line);
    if (status != ISO_OK)
        return status;
    iso_cli_validate_print(a->output, cli, v, &summary, &levels);
    return iso_cli_validate_verdict(v, &summary, &levels, err);
}

/* Refuses a scene that shows almost nothing: all renderers and levels would agree, so a verdict would be
 * meaningless. */
static iso_status check_visible(const iso_validate_arguments *a, const iso_cli *cli, const iso_pyramid *p,
                                const iso_view *view, iso_error *err)
{
    const iso_visible v = iso_visible_measure(&p->levels[0], view, NULL, cli->threads);
    char text[900];
    if (a->anyway) {
        iso_cli_warn_visible(cli, &v);
        return ISO_OK;
    }
    return iso_visible_complaint(&v, cli->arguments[0], text, sizeof text)
               ? iso_fail(err, ISO_E_RANGE, "%s; validate it with --anyway", text)
               : ISO_OK;
}

/* Begins the report, and opens its pictures. */
static iso_status begin(const iso_validate_arguments *a, const iso_cli *cli, iso_validation *v,
                        const iso_report_about *about, iso_code code, iso_picture_store **store, iso_error *err)
{
    NEED(iso_report_create(&v->report, a->output, about, err));
    NEED(begin_store(a, cli, store, err));
    v->renderers.store = *store;
    describe_options(a, v, code);
    begin_budget(a, v);
    return ISO_OK;
}

static iso_status judge(const iso_validate_arguments *a, const iso_cli *cli, iso_validation *v,
                        const iso_report_about *about, iso_picture_store **store, iso_error *err)
{
    NEED(begin(a, cli, v, about, v->pyramid->options.code, store, err));
    iso_validate_report_asked(v);
    NEED(run_stages(v, err));
    if (v->save_viewer)
        NEED(v->save_viewer(v, err));
    return finish(a, cli, v, err);
}

static iso_status validate(const iso_validate_arguments *a, const iso_cli *cli, iso_pyramid *pyramid, iso_scene *scene,
                           iso_picture_store **store, iso_error *err)
{
    const iso_progress progress = iso_cli_progress(cli);
    OWNED(iso_view) view = {0};
    FREED char *line = iso_cli_command_line(cli), *name = iso_provenance_scene(a->look.scene, 0),
               *typed = iso_volume_input_line(&a->input), *input = typed ? iso_provenance_line(typed) : NULL;
    ENDED_BY(end_validation)
    iso_validation v = {.pyramid = pyramid,
                        .scene = scene,
                        .view = &view,
                        .volume_path = cli->arguments[0],
                        .scene_path = a->look.scene,
                        .scene_name = name,
                        .input_options = input ? input : "",
                        .loaded = iso_pyramid_is_one(cli->arguments[0]),
                        .scales = a->extinction_scale ? ISO_SCALES_ADAPTED : ISO_SCALES_NONE};
    const iso_report_about about = {.title = iso_provenance_title(cli->arguments[0]),
                                    .command = line,
                                    .volume = cli->arguments[0],
                                    .scene = a->look.scene};
    take_options(a, cli, *store, &progress, &v);
    scale_down(&v, scene, a);
    NEED(iso_renderers_from_list(a->with, v.wanted, err));
    NEED(iso_scene_resolve(scene, &pyramid->levels[0].geometry, iso_pyramid_lo(pyramid), iso_pyramid_hi(pyramid), &view,
                           err));
    NEED(check_visible(a, cli, pyramid, &view, err));
    iso_validate_assume(&pyramid->levels[0], &view, &scene->agreement);
    const iso_status status = judge(a, cli, &v, &about, store, err);
    return v.report ? close_store(a, store, has_no_use(&v, status), status, err) : status;
}

/* True if the scene has no file: it is written next to the report, so that commands can name it. */
static bool has_own_scene(const iso_validate_arguments *a)
{
    return !a->look.scene || a->look.tf || a->look.view || a->look.zoom;
}

/* Loads the scene file, which may be changed only by --size. Any other scene is written and read again, so that reports
 * can repeat it. */
static iso_status load_scene(iso_validate_arguments *a, const iso_subject_look *look, const iso_pyramid *pyramid,
                             char *own_path, iso_scene *scene, iso_error *err)
{
    NEED(iso_subject_make_scene(look, pyramid, scene, err));
    if (!own_path)
        return ISO_OK;
    OWNED(iso_view) view = {0};
    NEED(iso_scene_resolve(scene, &pyramid->levels[0].geometry, iso_pyramid_lo(pyramid), iso_pyramid_hi(pyramid), &view,
                           err)); /* no copy of a wrong one is kept */
    char of[sizeof scene->tf.of]; /* messages name the user's file, not its copy */
    memcpy(of, scene->tf.of, sizeof of);
    const iso_status status = iso_validate_scene_save(scene, own_path, err);
    iso_scene_destroy(scene);
    a->look.scene = own_path;
    NEED(status);
    NEED(iso_scene_load(own_path, scene, err));
    memcpy(scene->tf.of, of, sizeof of);
    return ISO_OK;
}

static iso_status load_and_validate(const iso_validate_arguments *given, const iso_cli *cli, iso_pyramid_options *build,
                                    iso_picture_store **store, iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    FREED char *own_scene = NULL;
    OWNED(iso_pyramid) pyramid = {0};
    OWNED(iso_scene) scene = {0};
    iso_validate_arguments a = *given;
    iso_subject_look look;
    bool wanted[ISO_MAX_RENDERERS];
    build->level_count = a.level_count > 0 ? (size_t)a.level_count : a.quick ? 3 : 4;
    NEED(iso_renderers_from_list(a.with, wanted, err));
    iso_validate_expect(cli->progress, wanted, build->level_count, a.budget != ISO_NO_BUDGET);
    if (has_own_scene(&a))
        NEED(iso_validate_scene_name(a.output, &own_scene, err));
    NEED(iso_cli_look_check(&a.look, cli->threads, &look, err));
    if (own_scene)
        NEED(iso_validate_scene_guard(own_scene, err));
    NEED(iso_subject_load_pyramid(cli->arguments[0], &a.input, build, &progress, &pyramid, err));
    NEED(load_scene(&a, &look, &pyramid, own_scene, &scene, err));
    return validate(&a, cli, &pyramid, &scene, store, err);
}

static iso_status judge_suite(const iso_validate_arguments *a, const iso_cli *cli, iso_validation *v,
                              iso_suite_options *suite, iso_picture_store **store, iso_error *err)
{
    FREED char *line = iso_cli_command_line(cli);
    const iso_report_about about = {.title = "scenes that break renderers", .command = line, .scene = a->suite};
    const double start = iso_clock_seconds();
    NEED(iso_renderers_from_list(a->with, v->wanted, err));
    if (a->look.size)
        NEED(iso_subject_parse_image_size(a->look.size, &suite->width, &suite->height, err));
    NEED(begin(a, cli, v, &about, suite->code, store, err));
    NEED(run_stage(v, "calibration", iso_validate_renderers, err));
    iso_process_set_deadline(v->deadline);
    const iso_status status = iso_validate_suite(v, suite, err);
    iso_process_set_deadline(0);
    NEED(status);
    iso_report_put(v->report, "seconds", "total", json_real(iso_clock_seconds() - start));
    return finish(a, cli, v, err);
}

static iso_status validate_suite(const iso_validate_arguments *a, const iso_cli *cli, const iso_pyramid_options *build,
                                 iso_picture_store **store, iso_error *err)
{
    enum { quick_pixels = 48 };
    const iso_progress progress = iso_cli_progress(cli);
    ENDED_BY(end_validation) iso_validation v = {.input_options = ""};
    iso_suite_options suite = {.folder = a->suite,
                               .make_volume = iso_cli_make_volume,
                               .level_count = a->level_count > 0 ? (size_t)a->level_count : 1,
                               .code = build->code,
                               .width = a->quick ? quick_pixels : 0,
                               .height = a->quick ? quick_pixels : 0};
    iso_cli_expect(cli, (const iso_cli_stage[]){{"calibration", 5}, {"scenes", 30}, {"report", 1}}, 3);
    take_options(a, cli, *store, &progress, &v);
    const iso_status status = judge_suite(a, cli, &v, &suite, store, err);
    return v.report ? close_store(a, store, has_no_use(&v, status), status, err) : status;
}

static iso_status check_and_run(const iso_validate_arguments *a, const iso_cli *cli, iso_error *err)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    const iso_renderer_info *unused;
    iso_picture_store *store = NULL;
    NEED(iso_renderers_load(a->renderers, err));
    for (size_t i = 0; a->images && a->images[i]; ++i)
        NEED(iso_pictures_register(a->images[i], &unused, err));
    build.threads = cli->threads;
    NEED(iso_validate_check_arguments(a, cli, &build, err));
    NEED(iso_cli_take_cycles(&a->cycles, a->with, err));
    if (!a->shared)
        NEED(open_store(a, &store, err));
    return close_store(a, &store, false,
                       a->suite ? validate_suite(a, cli, &build, &store, err)
                                : load_and_validate(a, cli, &build, &store, err),
                       err);
}

static const iso_option options[] = {
    {"output", 'o', "folder for the report", "DIR", ISO_IN(iso_validate_arguments, output)},
    ISO_OPTIONS_OF(iso_validate_arguments, look, iso_look_rows),
    {"suite", 0, "validate the scenes of a folder, which describe their volumes", "DIR",
     ISO_IN(iso_validate_arguments, suite)},
    {"quick", 0, "use smaller images, three levels and fewer views, with the same limits", NULL,
     ISO_IN(iso_validate_arguments, quick)},
    {"levels", 0, "number of levels, including the finest (4; 3 with --quick)", "N",
     ISO_IN(iso_validate_arguments, level_count), .flags = ISO_NOT_ZERO, .least = 1, .most = 16},
    {"with", 0, "renderers to compare with the reference (%s)", "LIST", ISO_IN(iso_validate_arguments, with),
     ISO_NAMES_USUAL(ISO_HAS_LIMIT)},
    ISO_CLI_RENDERERS_OPTION(iso_validate_arguments, renderers),
    ISO_CLI_CYCLES_OPTIONS(iso_validate_arguments, cycles,
                           "compare Cycles of these Blenders, given as paths or names in PATH", "A,B"),
    {"images", 0, "compare pictures rendered elsewhere for isoshade scenes --write; repeatable", "NAME=DIR",
     ISO_IN(iso_validate_arguments, images)},
    ISO_CLI_GL_DEVICE_OPTION(iso_validate_arguments, gl_device),
    {"seeds", 0, "renders with %s at each step, to test mean and scatter (4; 3 with --quick)", "N",
     ISO_IN(iso_validate_arguments, seeds), .flags = ISO_NOT_ZERO, ISO_NAMES_RENDERERS(ISO_IS_RANDOM), .least = 2,
     .most = 32},
    {"limit-size", 0, "largest edge in pixels of pictures at several steps (96; 64 with --quick)", "N",
     ISO_IN(iso_validate_arguments, limit_size), .flags = ISO_NOT_ZERO, .least = 8, .most = 65536},
    {"budget", 0, "time limit in seconds, calibration excluded; skipped checks are listed", "SECONDS",
     ISO_IN(iso_validate_arguments, budget)},
    {"resume", 0, "continue an interrupted run for the same folder", NULL, ISO_IN(iso_validate_arguments, resume)},
    {"level-views", 0, "views to judge the levels, at most 20 (6; 3 with --quick)", "N",
     ISO_IN(iso_validate_arguments, level_views), .flags = ISO_NOT_ZERO, .least = 2, .most = ISO_FACE_VIEWS},
    {"level-size", 0, "pixels per edge of these views (160; 96 with --quick)", "N",
     ISO_IN(iso_validate_arguments, level_size), .flags = ISO_NOT_ZERO, .least = 16, .most = 1024},
    {"extinction-scale", 0, "judge the levels with --adapt --extinction-scale", NULL,
     ISO_IN(iso_validate_arguments, extinction_scale)},
    {"code", 0, "direction code of the pyramid (fit)", "CODE", ISO_IN(iso_validate_arguments, code)},
    {"anyway", 0, "validate even a scene that shows almost nothing, or only a box", NULL,
     ISO_IN(iso_validate_arguments, anyway)},
    {"viewer", 0, "add a viewer page (isoshade view), to which rows link", NULL,
     ISO_IN(iso_validate_arguments, viewer)},
    {"junit", 0, "also write the results as JUnit XML", "FILE.xml", ISO_IN(iso_validate_arguments, junit)},
    {"summary-md", 0, "write a Markdown summary, for a CI page", "FILE.md", ISO_IN(iso_validate_arguments, summary_md)},
    ISO_OPTIONS_OF(iso_validate_arguments, input, iso_input_rows),
    ISO_OPTIONS_END,
};

/* Lets a rank other than 0 run the whole validation for the pictures. Its report is dropped with the folder. */
static iso_status be_other_rank(iso_validate_arguments *a, iso_error *err)
{
    if (!a->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing");
    a->shared = iso_cli_work_folder(a->output);
    a->output = iso_path_join(iso_cli_rank_folder(), "report");
    a->junit = a->summary_md = NULL;
    a->viewer = a->resume = 0;
    return a->shared && a->output ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
}

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    iso_validate_arguments a = *(iso_validate_arguments *)values; /* whose texts the caller frees */
    iso_cli of_rank = *cli;
    of_rank.quiet = cli->quiet || iso_cli_rank_folder();
    if (a.gl_device)
        setenv(ISO_GL_DEVICE_VARIABLE, a.gl_device, 1);
    iso_status status = iso_cli_rank_folder() ? be_other_rank(&a, err) : ISO_OK;
    TRY(status, check_and_run(&a, &of_rank, err));
    if (a.shared)
        free(a.output);
    free(a.shared);
    return status;
}

const iso_command iso_command_validate = {
    .name = "validate",
    .summary = "validate the shading at every level and in every renderer, and write a report (the main job)",
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso [--scene SCENE.scene.json] -o DIR [options] | --suite DIR -o DIR [options]",
    .details =
        "Answers four questions, in this order. Does each renderer show volumes correctly if their images are known in closed form\n"
        "(calibration)? Is its image that of the double-precision reference, with the same samples and in the limit of small\n"
        "steps, within the error bars of that limit? Does this hold for every way to make directions, and for transfer functions\n"
        "adapted to a level? Is each level within the scene's limits (\"levels\") of level 0, and no worse than\n"
        "gradients on the fly under the original transfer function? --suite asks the first two for a folder of scenes that\n"
        "are known to break renderers. DIR/index.html shows the results, DIR/report.json has them as data.\n"
        "Exports to a program are moved and opened in it as a user would do, and must show the same picture.\n"
        "A pyramid's levels are first built again from its level 0, and must be the same byte by byte.\n"
        "DIR.work keeps finished pictures until the report is complete: --resume continues from there, to the same report.\n"
        "A case is listed as \"not compared\", with the reason, if it shows too little for its limits, if --budget or a renderer's\n"
        "missing feature leaves it out, or if no renderer takes part in its stage.\n"
        "Exit code 0: all compared cases agree, and the levels hold; 1: something differs, or nothing was compared at all,\n"
        "in a scene, or of a renderer whose images in a scene show too little or were left out by the budget; 5: the scene\n"
        "shows less than .1 % of the voxels or of the picture, or a box whose faces are opaque to more than 98 % (--anyway);\n"
        "7: a renderer that --with names is missing (others are left out by name); 9: one failed its calibration.\n"
        "Without --scene, and with --tf, --view or --zoom, the scene is written to DIR.scene.json, for commands in the\n"
        "report. A file of that name is replaced only if validate wrote it and it is unchanged (otherwise exit code 3).\n"
        "Under mpirun or srun, such as mpirun -n 4 isoshade validate VOLUME -o DIR, ranks share the pictures by DIR.work,\n"
        "which all must see. Each has its own programs and temporary folder. If one dies, others draw its pictures.",
    .common =
        "output scene tf view size with levels quick images suite budget resume junit viewer renderers blender timeout",
    .examples =
        "  isoshade make shells --size 40x44x37 -o shells.nrrd\n"
        "  isoshade validate shells.nrrd --quick --levels 1 --size 32 --with gl -o first-report\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --levels 1 --size 16 --with cpu -o report\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --with gl --size 32 --summary-md gl.md -o report-gl\n"
        "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --with gl --size 32 --budget 20 -o report-hurried\n"
        "  isoshade validate --suite refscenes/suite --quick --with gl --size 16 --junit suite.xml -o report-suite\n",
    .lists = (const iso_names *const[]){&iso_tf_preset_names, &iso_viewpoint_names, NULL},
    ISO_COMMAND_OPTIONS(iso_validate_arguments, options, .budget = ISO_NO_BUDGET),
    .run = run,
    .run_words = iso_cli_run_as_rank,
    .shares_ranks = true,
};
