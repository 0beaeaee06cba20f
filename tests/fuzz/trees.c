/* SPDX-License-Identifier: MIT */
/* trees.c - what isoshade reads of its own: scenes, pyramids, histograms, plans, reports, renderers, lists of
 * files. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/file.h"
#include "base/manifest.h"
#include "plan/planned.h"
#include "pyramid/pyramid.h"
#include "renderers/external.h"
#include "report/difference.h"
#include "report/markdown.h"
#include "scene/scene.h"
#include "tests/fuzz/readers.h"
#include "tf/histogram.h"
#include "volume/synthetic.h"

static void must(iso_status status, const iso_error *err)
{
    if (status != ISO_OK)
        fuzz_fail("what this target stands on cannot be made: %s", err->text);
}

/* ---- scenes ---- */

static bool is_finite(iso_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static void check_view(const iso_scene *scene)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){9, 7, 8}, (double[]){0.5, 1, 2});
    iso_view view = {0};
    iso_error err = {""};
    const iso_status status = iso_scene_resolve(scene, &g, -1, 3, &view, &err);
    fuzz_check_status(status, &err);
    const iso_camera *c = &view.camera;
    if (status == ISO_OK) {
        if (!is_finite(c->position) || !is_finite(c->forward) || !is_finite(c->right) || !is_finite(c->up) ||
            !(c->half_height > 0) || !isfinite(c->half_height))
            fuzz_fail("a camera that is no numbers, of half height %g", c->half_height);
        if (!(fabs(iso_norm(c->forward) - 1) < 1e-9 && fabs(iso_norm(c->right) - 1) < 1e-9))
            fuzz_fail("the camera's axes are %.17g and %.17g long", iso_norm(c->forward), iso_norm(c->right));
        for (size_t i = 0; i < view.light_count; ++i)
            if (!(fabs(iso_norm(view.lights[i].direction) - 1) < 1e-9) || !isfinite(view.lights[i].intensity))
                fuzz_fail("light %zu has no direction", i);
        for (size_t i = 0; i < view.clip_count; ++i)
            if (!(fabs(iso_norm(view.clips[i].normal) - 1) < 1e-9) || !isfinite(view.clips[i].offset_mm))
                fuzz_fail("clip plane %zu has no place", i);
        if (!(view.step_voxels > 0) || view.width < 1 || view.height < 1)
            fuzz_fail("a step of %g in a picture of %zu x %zu", view.step_voxels, view.width, view.height);
    }
    iso_view_destroy(&view);
}

void fuzz_scene(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    iso_scene scene = {0}, again = {0};
    iso_error err = {""};
    const iso_status status = iso_scene_load(path, &scene, &err);
    fuzz_check_status(status, &err);
    if (status == ISO_OK) {
        fuzz_note_read();
        check_view(&scene);
        json_t *once = iso_scene_to_json(&scene);
        if (iso_scene_from_json(once, "again", &again, &err) != ISO_OK)
            fuzz_fail("what is written of a scene is refused: %s", err.text);
        json_t *twice = iso_scene_to_json(&again);
        fuzz_check_same("a scene", once, twice);
        json_decref(once);
        json_decref(twice);
    }
    iso_scene_destroy(&again);
    iso_scene_destroy(&scene);
}

/* ---- pyramids ---- */

enum { DIGITS = 16 };

/* The place of the digits of "KEY": "..." behind `from`; NULL: there is none. */
static uint8_t *digits_behind(uint8_t *from, uint8_t *end, const char *key)
{
    uint8_t *at = memmem(from, (size_t)(end - from), key, strlen(key));
    if (!at)
        return NULL;
    at += strlen(key);
    while (at < end && (*at == ' ' || *at == ':' || *at == '\n'))
        ++at;
    if (at + DIGITS + 2 > end || *at != '"' || at[DIGITS + 1] != '"')
        return NULL;
    return at + 1;
}

static void put_digits(uint8_t *at, uint64_t hash)
{
    char text[DIGITS + 1];
    snprintf(text, sizeof text, "%016llx", (unsigned long long)hash);
    memcpy(at, text, DIGITS);
}

static const char part_mark[] = "==== ";

/* The content of the file of a name. */
static bool find_part(uint8_t *data, size_t size, const char *name, uint8_t **content, size_t *length)
{
    char line[80];
    const int n = snprintf(line, sizeof line, "%s%s\n", part_mark, name);
    uint8_t *at = memmem(data, size, line, (size_t)n);
    if (!at)
        return false;
    *content = at + n;
    uint8_t *next = memmem(*content, (size_t)(data + size - *content), "\n==== ", 6);
    *length = (size_t)((next ? next : data + size) - *content);
    return true;
}

/* The checksum of each level's file, and then pyramid.json's of itself, as isoshade writes them: what is then refused
 * is refused for what it says. */
void fuzz_repair_pyramid(uint8_t *data, size_t size)
{
    uint8_t *text, *content;
    size_t text_size, length;
    if (!find_part(data, size, "pyramid.json", &text, &text_size))
        return;
    uint8_t *end = text + text_size;
    for (uint8_t *at = text; (at = memmem(at, (size_t)(end - at), "\"name\": \"level_", 15)); ++at) {
        char name[64] = "";
        sscanf((char *)at + 9, "%40[a-z0-9_.]", name);
        uint8_t *place = digits_behind(at, end, "\"xxh3_64\"");
        if (place && find_part(data, size, name, &content, &length))
            put_digits(place, XXH3_64bits(content, length));
    }
    /* It is the last key; its own place counts as zeros. */
    uint8_t *own = NULL;
    for (uint8_t *at = text, *next; (next = digits_behind(at, end, "\"xxh3_64\"")); at = next)
        own = next;
    if (!own)
        return;
    memset(own, '0', DIGITS);
    put_digits(own, XXH3_64bits(text, text_size));
}

static void check_levels(const iso_pyramid *p)
{
    for (size_t k = 0; k < p->level_count; ++k) {
        const iso_level *l = &p->levels[k];
        const size_t count = iso_geometry_voxel_count(&l->geometry);
        double lo = INFINITY, hi = -INFINITY;
        for (size_t i = 0; i < count; ++i)
            lo = fmin(lo, (double)l->scalar[i]), hi = fmax(hi, (double)l->scalar[i]);
        volatile uint8_t sum = 0;
        for (size_t i = 0; l->codes && i < 3 * count; ++i)
            sum = (uint8_t)(sum + l->codes[i]);
    }
}

void fuzz_pyramid(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    iso_pyramid p = {0};
    iso_error err = {""};
    iso_status status = iso_pyramid_load_outline(path, &p, &err);
    fuzz_check_status(status, &err);
    iso_pyramid_destroy(&p);
    if (status != ISO_OK)
        return;
    status = iso_pyramid_load(path, &p, &err);
    fuzz_check_status(status, &err);
    if (status == ISO_OK) {
        fuzz_note_read();
        check_levels(&p);
    }
    iso_pyramid_destroy(&p);
}

/* ---- what belongs to one volume ---- */

/* Shells of 17 x 9 x 13 in bytes, their pyramid, and a TF that shows them. */
static struct subject {
    bool is_made;
    iso_pyramid pyramid;
    iso_tf_table tf;
} subject;

static void make_subject(void)
{
    if (subject.is_made)
        return;
    iso_volume v = {0};
    iso_error err = {""};
    iso_field field = {.geometry = iso_geometry_axis_aligned((size_t[]){17, 9, 13}, (double[]){1, 1.5, 1})};
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.threads = 1;
    must(iso_field_from_name("shells", &field.kind, &err), &err);
    must(iso_field_sample(&field, ISO_U8, &v, &err), &err);
    must(iso_pyramid_build(&v, "shells", &opt, &subject.pyramid, NULL, &err), &err);
    iso_volume_destroy(&v);
    iso_tf_point points[] = {{.value = 0}, {.value = 1, .rgb_linear = {1, 1, 1}, .opacity = 0.5}};
    const iso_tf tf = {.point_count = 2, .points = points, .fit_range = true, .unit_distance = 1, .table_size = 64};
    const iso_level *l = &subject.pyramid.levels[0];
    must(iso_tf_tabulate(&tf, l->min, l->max, &l->geometry, &subject.tf, &err), &err);
    subject.is_made = true;
}

void fuzz_joint(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    make_subject();
    const iso_level *l = &subject.pyramid.levels[0];
    iso_bins z, s;
    iso_joint joint = {0};
    iso_error err = {""};
    char *dir = iso_path_dir(path);
    iso_joint_bins(l->min, l->max, ISO_U8, 8, &z, &s);
    const iso_status status = iso_joint_load(dir, &(iso_joint_key){1, 8, ISO_SECOND_VALUE_NONE}, &z, &s,
                                             iso_geometry_voxel_count(&l->geometry), &joint, &err);
    free(dir);
    fuzz_check_status(status, &err);
    uint64_t sum = 0;
    for (size_t i = 0; status == ISO_OK && i < joint.entry_count; ++i) {
        if (joint.entry_z[i] >= joint.z.count)
            fuzz_fail("bin %u of %zu", joint.entry_z[i], joint.z.count);
        sum += joint.entry_count_of[i];
    }
    if (status == ISO_OK)
        fuzz_note_read();
    if (status == ISO_OK && sum != joint.voxel_count)
        fuzz_fail("%llu voxels are counted of %llu", (unsigned long long)sum, (unsigned long long)joint.voxel_count);
    iso_joint_destroy(&joint);
}

void fuzz_plan(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    make_subject();
    iso_plan_file plan = {0};
    iso_error err = {""};
    iso_status status = iso_plan_file_load(path, &plan, &err);
    fuzz_check_status(status, &err);
    const size_t bricks = status == ISO_OK ? plan.count[0] * plan.count[1] * plan.count[2] : 0;
    for (size_t i = 0; i < bricks; ++i)
        if (plan.levels[i] >= plan.level_count || (plan.drawn[i] && !plan.seen[i]))
            fuzz_fail("brick %zu has level %u of %zu", i, plan.levels[i], plan.level_count);
    iso_plan_file_destroy(&plan);
    if (status != ISO_OK)
        return;
    const iso_planned_subject of = {&subject.pyramid.levels[0], subject.pyramid.options.code, &subject.tf, 1};
    iso_planned p = {0};
    status = iso_planned_create(path, &of, 1, &p, &err);
    fuzz_check_status(status, &err);
    iso_planned_lattices lattices = {0};
    if (status == ISO_OK) {
        fuzz_note_read();
        fuzz_check_status(iso_planned_lattices_create(&p, true, false, 1, &lattices, &err), &err);
        iso_planned_lattices_destroy(&lattices);
        iso_planned_destroy(&p);
    }
}

/* ---- reports ---- */

/* No change to itself, no worse than itself, and a summary. */
void fuzz_report(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    json_t *root = NULL, *difference = NULL;
    iso_error err = {""};
    iso_status status = iso_json_load(path, &root, &err);
    fuzz_check_status(status, &err);
    if (status != ISO_OK)
        return;
    status = iso_difference_of(root, root, false, 1, &difference, &err);
    fuzz_check_status(status, &err);
    if (status == ISO_OK) {
        fuzz_note_read();
        iso_difference_conclude(difference);
        const char *verdict = json_string_value(json_object_get(difference, "verdict"));
        if (!verdict || strcmp(verdict, "agree") != 0 || iso_difference_count_worse(difference))
            fuzz_fail("a report differs from itself");
    }
    fuzz_check_status(iso_markdown_of_report(fuzz_beside("summary.md"), root, "index.html", &err), &err);
    json_decref(difference);
    json_decref(root);
}

/* ---- lists ---- */

/* Rows that are good stay for as long as the process runs, until the table is full. */
void fuzz_renderers(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    iso_error err = {""};
    fuzz_check_read(iso_renderers_load(path, &err), &err);
}

void fuzz_manifest(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    iso_error err = {""};
    fuzz_check_read(iso_manifest_check(path, "the folder", &err), &err);
}

/* A reader with a fault: the fuzzing has to find it, or it finds none. */
void fuzz_planted(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    json_t *root = NULL;
    volatile int levels[8] = {0};
    if (iso_json_load(path, &root, NULL) != ISO_OK)
        return;
    const json_t *level = json_object_get(root, "level");
    if (json_is_integer(level) && json_integer_value(level) >= 0 && json_integer_value(level) <= 8) /* < 8 */
        ++levels[json_integer_value(level)];
    if (json_integer_value(level) == 9)
        fuzz_fail("level 9, planted");
    if (json_integer_value(level) == 10) /* as a library's assertion */
        abort();
    if (json_integer_value(level) == 12) { /* depends on an uninitialized value, which memcheck finds */
        static volatile int *volatile unset;
        unset = malloc(sizeof *unset);
        if (unset && *unset == 12)
            ++levels[0];
        free((void *)unset);
    }
    json_decref(root);
}
