/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/scenes_write.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/provenance.h"
#include "base/words.h"
#include "cli/made_volume.h"
#include "renderers/pictures.h"
#include "scene/subject.h"
#include "validate/elsewhere.h"

enum { USUAL_STEPS = 4, USUAL_LEVELS = 4 };
static const char scene_ending[] = ".scene.json";

/* State of writing requests. */
typedef struct writing {
    const iso_scenes_write *asked;
    iso_output out;
    iso_elsewhere elsewhere;
} writing;

static void writing_destroy(writing *w)
{
    iso_output_abandon(&w->out);
    json_decref(w->elsewhere.pictures);
    json_decref(w->elsewhere.left_out);
}

static char *name_of_scene(const char *path)
{
    const char *base = iso_path_base(path);
    const size_t length = strlen(base), ending = strlen(scene_ending);
    return strndup(base, length > ending && iso_path_ends_with(base, scene_ending) ? length - ending : length);
}

/* Writes the request of a scene for a pyramid, in the size that the options give. */
static iso_status write_scene(const writing *w, iso_scene *scene, const iso_pyramid *p, const char *name,
                              iso_error *err)
{
    OWNED(iso_view) view = {0};
    if (w->asked->look.size)
        NEED(iso_subject_parse_image_size(w->asked->look.size, &scene->width, &scene->height, err));
    NEED(iso_scene_resolve(scene, &p->levels[0].geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), &view, err));
    return iso_elsewhere_write_scene(&w->elsewhere, p, scene, &view, name, err);
}

static iso_pyramid_options options_of(const iso_scenes_write *a, size_t usual_levels)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    build.threads = a->cli->threads;
    build.level_count = a->levels > 0 ? (size_t)a->levels : usual_levels;
    return build;
}

/* ---- a volume ---- */

static bool has_own_scene(const iso_cli_look *look)
{
    return !look->scene || look->tf || look->view || look->zoom;
}

/* Saves a scene without a file as DIR/scene.scene.json, and reads it again so that both are equal. */
static iso_status keep_scene(const writing *w, iso_scene *scene, iso_error *err)
{
    json_auto_t *root = iso_scene_to_json(scene);
    FREED char *path = iso_path_join(w->out.temp_path, "scene.scene.json");
    iso_scene_destroy(scene);
    NEED(root && path ? iso_scene_save_json(root, path, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    return iso_scene_load(path, scene, err);
}

static iso_status write_volume(const writing *w, iso_error *err)
{
    const iso_scenes_write *a = w->asked;
    const iso_pyramid_options build = options_of(a, USUAL_LEVELS);
    iso_progress progress = iso_cli_progress(a->cli);
    OWNED(iso_pyramid) pyramid = {0};
    OWNED(iso_scene) scene = {0};
    iso_subject_look look;
    const bool own = has_own_scene(&a->look);
    FREED char *name = own ? strdup("scene") : name_of_scene(a->look.scene);
    NEED(name ? iso_cli_look_check(&a->look, a->cli->threads, &look, err)
              : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    NEED(iso_subject_load_pyramid(a->cli->arguments[0], a->input, &build, &progress, &pyramid, err));
    NEED(iso_subject_make_scene(&look, &pyramid, &scene, err));
    if (own)
        NEED(keep_scene(w, &scene, err));
    return write_scene(w, &scene, &pyramid, name, err);
}

/* ---- a suite ---- */

static int is_scene(const struct dirent *entry)
{
    return entry->d_name[0] != '.' && iso_path_ends_with(entry->d_name, scene_ending);
}

static iso_status write_suite_scene(const writing *w, const char *file, const char *volume, iso_error *err)
{
    const iso_volume_input plain = {0};
    const iso_pyramid_options build = options_of(w->asked, 1);
    OWNED(iso_scene) scene = {0};
    OWNED(iso_pyramid) pyramid = {0};
    FREED char *path = iso_path_join(w->asked->suite, file), *name = name_of_scene(file);
    NEED(path && name ? iso_scene_load(path, &scene, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    if (!scene.suite_make)
        return iso_fail(err, ISO_E_FORMAT, "%s: has no \"suite\", which names its volume", path);
    const iso_status status = iso_cli_make_volume(scene.suite_make, volume, err);
    if (status != ISO_OK)
        return iso_fail_in(err, status, "%s", path);
    NEED(iso_subject_load_pyramid(volume, &plain, &build, NULL, &pyramid, err));
    return write_scene(w, &scene, &pyramid, name, err);
}

static iso_status write_suite(const writing *w, iso_error *err)
{
    struct dirent **entries;
    const int count = scandir(w->asked->suite, &entries, is_scene, alphasort);
    if (count < 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be listed: %s", w->asked->suite, strerror(errno));
    ENDED_BY(iso_end_temp_dir) char *scratch = iso_make_temp_dir();
    FREED char *volume = scratch ? iso_path_join(scratch, "volume.nrrd") : NULL;
    iso_status status = volume ? ISO_OK : iso_temp_dir_fail(err);
    if (status == ISO_OK && count == 0)
        status = iso_fail(err, ISO_E_USAGE, "%s: the folder has no .scene.json", w->asked->suite);
    for (int i = 0; i < count; ++i) {
        TRY(status, write_suite_scene(w, entries[i]->d_name, volume, err));
        free(entries[i]);
    }
    free(entries);
    return status;
}

/* ---- all requests ---- */

/* Returns the command that compares the pictures; to be freed. */
static char *validate_line(const iso_scenes_write *a)
{
    char *line = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&line, &size);
    if (!f)
        return NULL;
    fputs("isoshade validate ", f);
    if (a->suite) {
        fputs("--suite ", f);
        iso_provenance_put_word(f, a->suite);
    } else {
        iso_provenance_put_word(f, a->cli->arguments[0]);
        fputs(" --scene ", f);
        if (has_own_scene(&a->look)) {
            iso_provenance_put_word(f, a->dir);
            fputs("/scene.scene.json", f);
        } else {
            iso_provenance_put_word(f, a->look.scene);
        }
    }
    if (a->levels > 0)
        fprintf(f, " --levels %d", a->levels);
    if (a->look.size)
        fprintf(f, " --size %s", a->look.size);
    fputs(" --images NAME=", f);
    iso_provenance_put_word(f, a->dir);
    fputs(" -o report", f);
    fclose(f);
    return line;
}

static iso_status check(const iso_scenes_write *a, iso_error *err)
{
    static const char *const tiers[] = {"samples", "limit", "8 bits"};
    bool known = !a->tier;
    for (size_t i = 0; a->tier && i < sizeof tiers / sizeof *tiers; ++i)
        known = known || strcmp(a->tier, tiers[i]) == 0;
    if (!known)
        return iso_fail(err, ISO_E_USAGE, "--tier is \"%s\", must be samples, limit or \"8 bits\"", a->tier);
    if (a->tier && strcmp(a->tier, "limit") == 0 && a->steps >= 0 && a->steps < 2)
        return iso_fail(err, ISO_E_USAGE, "--steps is %d, a limit needs at least 2", a->steps);
    if (a->tier && strcmp(a->tier, "8 bits") == 0 && a->steps > 0)
        return iso_fail(err, ISO_E_USAGE,
                        "--steps has no effect for --tier \"8 bits\", which has no limit of small steps");
    if ((a->suite ? 0 : 1) != a->cli->argument_count)
        return iso_fail(err, ISO_E_USAGE,
                        a->suite ? "--suite makes its own volumes" : "a volume, a pyramid or --suite is missing");
    if (a->suite && (a->look.scene || a->look.tf || a->look.view || a->look.zoom))
        return iso_fail(err, ISO_E_USAGE, "--scene and --suite exclude each other, --tf, --view and --zoom too");
    return ISO_OK;
}

static void print_summary(const writing *w)
{
    const iso_cli *cli = w->asked->cli;
    size_t i, k, count = 0;
    json_t *one, *file;
    json_array_foreach (w->elsewhere.pictures, i, one)
        json_array_foreach (json_object_get(one, "files"), k, file)
            ++count;
    if (cli->json) {
        iso_cli_print_results(cli, json_pack("{s:s, s:O, s:O}", "output", w->asked->dir, "pictures",
                                             w->elsewhere.pictures, "left_out", w->elsewhere.left_out));
        return;
    }
    json_array_foreach (w->elsewhere.left_out, i, one)
        printf("left out: %s: %s\n", json_string_value(json_object_get(one, "scene")),
               json_string_value(json_object_get(one, "why")));
    const size_t requests = json_array_size(w->elsewhere.pictures);
    printf("%s: %zu picture%s to render for %zu request%s; %s/README.txt lists them\n", w->asked->dir, count,
           iso_words_plural(count), requests, iso_words_plural(requests), w->asked->dir);
}

iso_status iso_scenes_write_all(const iso_scenes_write *a, iso_error *err)
{
    const bool bits = a->tier && strcmp(a->tier, "8 bits") == 0;
    OWNED(writing) w = {.asked = a};
    NEED(check(a, err));
    NEED(iso_output_begin_dir(&w.out, a->dir, ISO_PICTURES_INDEX, err));
    FREED char *line = iso_cli_command_line(a->cli), *validate = validate_line(a);
    w.elsewhere = (iso_elsewhere){.dir = w.out.temp_path,
                                  .tier = a->tier ? a->tier : "samples",
                                  .steps = bits           ? 0
                                           : a->steps < 0 ? USUAL_STEPS
                                                          : (size_t)a->steps,
                                  .pictures = json_array(),
                                  .left_out = json_array()};
    if (!line || !validate)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    NEED(a->suite ? write_suite(&w, err) : write_volume(&w, err));
    NEED(iso_elsewhere_write_calibrations(&w.elsewhere, err));
    NEED(iso_elsewhere_finish(&w.elsewhere, line, validate, err));
    NEED(iso_output_commit(&w.out, err));
    print_summary(&w);
    return ISO_OK;
}
