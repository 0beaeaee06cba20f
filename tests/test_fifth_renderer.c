/* SPDX-License-Identifier: MIT */
/* A renderer that comes with nothing but its own file (fifth_renderer.c) is listed, calibrated and compared like the
 * others, and named in every row: without its planted shift it agrees; with a small one its lock-step differs; with a
 * large one its calibration refuses it. */
#include "tests/fifth_renderer.c"
#include "tests/folder.h"
#include "tests/test.h"
#include "validate/validate.h"
#include "volume/synthetic.h"

enum { pixels = 20 };

static int begin(void **state)
{
    return iso_renderers_register(&iso_renderer_shifted, NULL) == ISO_OK ? make_folder(state) : -1;
}

static iso_scene make_scene(void)
{
    static iso_tf_point points[] = {{0, {0.9, 0.7, 0.4}, 0}, {0.5, {1, 0.9, 0.6}, 0.2}, {1, {0.3, 0.6, 0.9}, 0.4}};
    return (iso_scene){.path = "test",
                       .width = pixels,
                       .height = pixels,
                       .camera_fit = true,
                       .fov_y_deg = 30,
                       .camera_direction = {1, 2, -0.7},
                       .camera_up = {0, 0, 1},
                       .margin = 1,
                       .light_count = 1,
                       .lights = {{.direction = {0.3, 0.5, 0.8}, .intensity = 1}},
                       .shading = {.ambient = 0.3, .diffuse = 0.7, .power = 1},
                       .step_voxels = 0.5,
                       .agreement = {.tier = ISO_TIER_CONVERGENCE, .why = "a smooth transfer function"},
                       .tf = {.fit_range = true,
                              .unit_distance = 1,
                              .unit_is_voxels = true,
                              .table_size = 64,
                              .point_count = 3,
                              .points = points}};
}

/* The report of a validation of the renderer with that shift, to be destroyed. */
static iso_report *validate(double shift, const char *name)
{
    const iso_field field = {.kind = ISO_FIELD_NOISE,
                             .seed = 5,
                             .geometry = iso_geometry_axis_aligned((size_t[]){13, 11, 9}, (double[]){1, 1.2, 0.9})};
    const iso_report_about about = {.title = name};
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_scene scene = make_scene();
    OWNED(iso_pyramid) pyramid;
    OWNED(iso_volume) volume;
    OWNED(iso_view) view;
    build.level_count = 1;
    assert_ok(iso_field_sample(&field, ISO_F32, &volume, &err));
    assert_ok(iso_pyramid_build(&volume, name, &build, &pyramid, NULL, &err));
    const iso_level *l = &pyramid.levels[0];
    assert_ok(iso_scene_resolve(&scene, &l->geometry, l->min, l->max, &view, &err));
    iso_validation v = {.pyramid = &pyramid,
                        .scene = &scene,
                        .view = &view,
                        .volume_path = "v.nrrd",
                        .scene_path = "s.scene.json",
                        .scene_name = name,
                        .image_prefix = "",
                        .variant = "",
                        .build_options = "",
                        .render_options = "",
                        .input_options = "",
                        .seeds = 2};
    FREED char *dir = iso_path_join(folder, name);
    shift_voxels = shift;
    assert_ok(iso_renderers_from_list("shifted", v.wanted, &err));
    assert_ok(iso_report_create(&v.report, dir, &about, &err));
    assert_ok(iso_validate_renderers(&v, &err));
    assert_ok(iso_validate_agreement(&v, &err));
    iso_renderers_end(&v.renderers);
    return v.report;
}

/* The verdict of the one row whose keys have these values. */
static const char *verdict_of(const iso_report *r, const char *list, const char *key, const char *value,
                              const char *key2, const char *value2)
{
    const char *found = NULL;
    json_t *row;
    size_t i;
    json_array_foreach(json_object_get(iso_report_json(r), list), i,
                       row) if (strcmp(json_string_value(json_object_get(row, key)), value) == 0 &&
                                strcmp(json_string_value(json_object_get(row, key2)), value2) == 0)
    {
        assert_null(found);
        found = json_string_value(json_object_get(row, "verdict"));
    }
    if (!found)
        fail_msg("%s has no row with %s %s and %s %s", list, key, value, key2, value2);
    return found;
}

static const char *calibration(const iso_report *r, const char *check)
{
    return verdict_of(r, "calibration", "renderer", "shifted", "check", check);
}

static void expect_trust(const iso_report *r)
{
    const char *const checks[] = {"placement", "slab",        "transfer function", "light",
                                  "order",     "view vector", "interpolation"};
    for (size_t i = 0; i < sizeof checks / sizeof *checks; ++i)
        if (strcmp(calibration(r, checks[i]), "pass") != 0)
            fail_msg("the check %s does not pass", checks[i]);
}

static const char *lock_step_of(const iso_report *r)
{
    return verdict_of(r, "agreement", "renderer", "shifted", "comparison", "lock-step");
}
static const char *limit_of(const iso_report *r)
{
    return verdict_of(r, "agreement", "renderer", "shifted", "comparison", "limit");
}

TEST(it_is_listed_with_the_others)
{
    char names[256];
    const iso_renderer_info *found;
    iso_renderers_with(0, ", ", " and ", names, sizeof names);
    assert_ptr_equal(strstr(names, "reference, gl, cpu, cycles, povray"), names);
    assert_string_equal(names + strlen(names) - strlen(" and shifted"), " and shifted");
    assert_ok(iso_renderer_from_name("shifted", &found, &err));
    assert_ptr_equal(found, &iso_renderer_shifted);
    iso_error why = {""};
    assert_int_equal(iso_renderer_from_name("shafted", &found, &why), ISO_E_USAGE);
    assert_non_null(strstr(why.text, " or shifted"));
    assert_status(iso_renderers_register(&iso_renderer_shifted, &err), ISO_E_USAGE); /* the name is taken */
}

TEST(what_it_does_not_have_is_refused_by_name)
{
    iso_renderers renderers = {0};
    iso_level level = {0};
    iso_pyramid p = {.level_count = 1, .levels = &level};
    const iso_view view = {.width = 1, .height = 1};
    iso_render_options opt = iso_render_defaults(&iso_renderer_shifted);
    iso_image image;
    iso_error why = {""};
    opt.isosurface = true;
    assert_int_equal(iso_render_with(&(iso_render_request){&renderers, &p, 0, &view, &opt, NULL}, &image, NULL, &why),
                     ISO_E_USAGE);
    assert_string_equal(why.text, "isosurfaces are rendered by reference, gl and povray, not by shifted");
}

TEST(without_its_shift_it_agrees)
{
    iso_report *r = validate(0, "right");
    expect_trust(r);
    assert_string_equal(lock_step_of(r), "agree");
    assert_string_equal(limit_of(r), "agree");
    iso_report_destroy(r);
}

/* So small a part of a voxel is less than calibration asks for; the same samples show it. */
TEST(with_a_small_shift_its_samples_differ)
{
    iso_report *r = validate(5e-5, "near");
    expect_trust(r);
    assert_string_equal(lock_step_of(r), "differ");
    iso_report_destroy(r);
}

VALUES_TEST(with_a_large_shift_its_calibration_refuses_it)
{
    iso_report *r = validate(0.5, "wrong");
    assert_string_equal(calibration(r, "placement"), "fail");
    assert_string_equal(lock_step_of(r), "refused");
    assert_string_equal(limit_of(r), "refused");
    iso_report_destroy(r);
}

TEST_MAIN(begin, remove_folder)
