/* SPDX-License-Identifier: MIT */
/* test_artefact.c - what is exported is moved, opened by the program itself, and shows what was validated; planted
 * faults of an export are seen. */
#define _GNU_SOURCE
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/parallel.h"
#include "base/process.h"
#include "tests/folder.h"
#include "validate/artefact.h"
#include "volume/synthetic.h"
#include "test.h"
#include "cycles.h"

static iso_renderers renderers;
static iso_pyramid pyramid;
static iso_view view;

static const char scene_text[] =
    "{\"schema\": \"isoshade.scene/1\", \"image\": {\"width\": 20, \"height\": 16},"
    " \"camera\": {\"projection\": \"perspective\", \"fit\": true, \"direction\": [1, 2, -1], \"up\": [0, 0, 1],"
    "  \"margin\": 1.1, \"fov_y_deg\": 25},"
    " \"lights\": [{\"direction\": [-0.3, 0.5, 1], \"space\": \"camera\", \"intensity\": 1}],"
    " \"shading\": {\"ambient\": 0.2, \"diffuse\": 0.6, \"specular\": 0.3, \"power\": 8},"
    " \"background\": [0.1, 0.5, 0.25], \"step_voxels\": 0.5,"
    " \"tf\": {\"schema\": \"isoshade.tf/1\", \"range\": \"fit\", \"unit_distance_voxels\": 1, \"color_space\": \"linear\","
    "  \"table_size\": 64, \"points\": [{\"value\": 0, \"r\": 0.9, \"g\": 0.3, \"b\": 0.1, \"opacity\": 0},"
    "  {\"value\": 1, \"r\": 0.2, \"g\": 0.5, \"b\": 0.9, \"opacity\": 0.2}]}}";

static int begin(void **state)
{
    const size_t size[3] = {11, 9, 12};
    const double spacing[3] = {1, 1.5, 1};
    const iso_field field = {.kind = ISO_FIELD_NOISE, .geometry = iso_geometry_axis_aligned(size, spacing), .seed = 5};
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_volume volume;
    iso_scene scene;
    json_t *root = json_loads(scene_text, 0, NULL);
    build.level_count = 1;
    if (make_folder(state) != 0)
        return -1;
    iso_status status = iso_field_sample(&field, ISO_U16, &volume, NULL);
    TRY(status, iso_pyramid_build(&volume, "noise", &build, &pyramid, NULL, NULL));
    iso_volume_destroy(&volume);
    TRY(status, iso_scene_from_json(root, "scene", &scene, NULL));
    const iso_level *l = &pyramid.levels[0];
    TRY(status, iso_scene_resolve(&scene, &l->geometry, l->min, l->max, &view, NULL));
    iso_scene_destroy(&scene);
    json_decref(root);
    return status == ISO_OK ? 0 : -1;
}

static int end(void **state)
{
    iso_view_destroy(&view);
    iso_pyramid_destroy(&pyramid);
    iso_renderers_end(&renderers);
    return remove_folder(state);
}

static iso_artefact_result open_export(const char *name, void (*tamper)(const char *), const iso_view *planted)
{
    iso_artefact a = {.pyramid = &pyramid, .view = &view, .threads = 1, .tamper = tamper, .planted_view = planted};
    iso_artefact_result r;
    for (size_t i = 0; i < iso_export_target_names.count; ++i)
        if (strcmp(iso_export_target_at(i)->name, name) == 0)
            a.target = iso_export_target_at(i);
    assert_ok(iso_renderer_from_name(a.target->renderer, &a.renderer, &err));
    assert_ok(iso_artefact_compare(&renderers, &a, &r, NULL, &err));
    return r;
}

/* 0.02 in one channel of the background: five steps of 8 bits. */
static iso_view off_background(void)
{
    iso_view v = view;
    v.background[1] -= 0.02;
    return v;
}

/* changes: what leaves a file that opens and shows something else; or NULL. */
static void expect_faults_are_seen(const char *name, void (*tamper)(const char *), void (*changes)(const char *))
{
    const iso_view off = off_background();
    iso_artefact_result r = open_export(name, NULL, NULL);
    printf("%s: %g, limit %g (%s)\n", name, r.value, r.limit, r.unit);
    if (!(r.value <= r.limit / 2)) /* not by a hair */
        fail_msg("%s: %g %s, limit %g: %s", name, r.value, r.unit, r.limit, r.why);
    iso_artefact_release(&r);
    r = open_export(name, NULL, &off);
    assert_more_than(r.value, 2 * r.limit);
    iso_artefact_release(&r);
    r = open_export(name, tamper, NULL);
    assert_false(r.value <= r.limit); /* another picture, or none: NaN */
    if (isnan(r.value))
        assert_true(r.why[0]);
    iso_artefact_release(&r);
    if (!changes)
        return;
    r = open_export(name, changes, NULL);
    if (!(r.value > 2 * r.limit)) /* a picture, and another one: not NaN */
        fail_msg("%s, changed: %g %s, limit %g: %s", name, r.value, r.unit, r.limit, r.why);
    iso_artefact_release(&r);
}

static void lose_values(const char *exported)
{
    FREED char *path = iso_path_join(exported, "scene_scalar.df3");
    assert_int_equal(unlink(path), 0);
}

static void lose_grids(const char *blend)
{
    FREED char *dir = iso_path_dir(blend), *path = iso_path_join(dir, "scene.vdb");
    assert_int_equal(unlink(path), 0);
}

/* The nodes read the values' grid for the directions and the directions' for the values, as a file would have it whose
 * grids were written under each other's name. Blender itself changes and saves it. */
static void swap_grids(const char *blend)
{
    FREED char *command = NULL;
    const int length =
        asprintf(&command,
                 "blender --background '%s' --python-expr \"import bpy\n"
                 "other = {'density': 'gradient', 'gradient': 'density'}\n"
                 "for tree in bpy.data.node_groups:\n"
                 "  for n in tree.nodes:\n"
                 "    if n.type == 'ATTRIBUTE': n.attribute_name = other.get(n.attribute_name, n.attribute_name)\n"
                 "bpy.ops.wm.save_mainfile()\n\" >/dev/null 2>&1",
                 blend);
    assert_more_than(length, 0);
    assert_int_equal(system(command), 0);
}

TEST(a_folder_of_povray_is_opened)
{
    expect_faults_are_seen("povray", lose_values, NULL);
}

VALUES_TEST(a_blend_is_opened)
{
    need_cycles();
    expect_faults_are_seen("blender", lose_grids, swap_grids);
}

/* In the place of POV-Ray until forget_povray(). */
static void take_as_povray(const char *script)
{
    FREED char *path = iso_path_join(folder, "false-povray");
    assert_ok(iso_file_write(path, script, strlen(script), &err));
    assert_int_equal(chmod(path, 0755), 0);
    assert_int_equal(setenv("ISOSHADE_POVRAY", path, 1), 0);
}

static void forget_povray(void)
{
    unsetenv("ISOSHADE_POVRAY");
}

static iso_scene any_scene = {.agreement = {.tier = ISO_TIER_CONVERGENCE}};

/* A validation whose one renderer is POV-Ray. */
static iso_validation open_validation(const char *name)
{
    const iso_report_about about = {.title = "t"};
    const iso_renderer_info *povray;
    FREED char *dir = iso_path_join(folder, name);
    iso_validation v = {.pyramid = &pyramid, .scene = &any_scene, .view = &view, .scene_name = "s", .threads = 1};
    assert_ok(iso_renderer_from_name("povray", &povray, &err));
    v.wanted[iso_renderer_index(povray)] = true;
    assert_ok(iso_report_create(&v.report, dir, &about, &err));
    return v;
}

static void close_validation(iso_validation *v)
{
    iso_report_destroy(v->report);
    iso_renderers_end(&v->renderers);
}

static const json_t *rows_of(const iso_validation *v, const char *list)
{
    return json_object_get(iso_report_json(v->report), list);
}

/* What the budget's end ended says nothing of the export: it is left out, as it is where the budget is over before. */
TEST(an_export_that_the_budget_ends_is_left_out)
{
    iso_validation v = open_validation("late");
    take_as_povray("#!/bin/sh\nexec sleep 1000\n");
    v.budget_seconds = 1;
    v.deadline = iso_clock_seconds() + v.budget_seconds;
    iso_process_set_deadline(v.deadline);
    assert_ok(iso_validate_artefacts(&v, &err));
    iso_process_set_deadline(0);
    forget_povray();
    const json_t *row = json_array_get(rows_of(&v, "agreement"), 0);
    assert_int_equal(json_array_size(rows_of(&v, "calibration")), 0);
    assert_int_equal(json_array_size(rows_of(&v, "agreement")), 1);
    assert_string_equal(iso_row_text(row, "variant"), "artefacts");
    assert_string_equal(iso_row_text(row, "not_compared"), "budget");
    close_validation(&v);
}

/* Nor does Ctrl-C: the run ends. The last test here, since nothing is to be begun after it. */
TEST(an_export_that_is_interrupted_ends_the_run)
{
    char script[128];
    iso_validation v = open_validation("stopped");
    snprintf(script, sizeof script, "#!/bin/sh\nkill -TERM %ld\nexec sleep 1000\n", (long)getpid());
    take_as_povray(script);
    assert_int_equal(setenv("ISOSHADE_SANDBOX", "off", 1), 0);
    assert_status(iso_validate_artefacts(&v, &err), ISO_E_PROGRAM);
    unsetenv("ISOSHADE_SANDBOX");
    forget_povray();
    assert_int_equal(json_array_size(rows_of(&v, "calibration")), 0);
    close_validation(&v);
}

TEST_MAIN(begin, end)
