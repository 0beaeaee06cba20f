/* SPDX-License-Identifier: MIT */
/* test_tf.c - transfer functions and scenes: files to tables and views. */
#include "base/file.h"
#include "scene/scene.h"
#include "tf/adapt.h"
#include "tf/format.h"
#include "folder.h"
#include "test.h"

static char *write_text(const char *name, const char *text)
{
    char *path = iso_path_join(folder, name);
    assert_ok(iso_file_write(path, text, strlen(text), &err));
    return path;
}

#define TF_HEAD "{\"schema\": \"isoshade.tf/1\", \"color_space\": \"linear\", "
#define TF_POINTS \
    "\"points\": [{\"value\": 0, \"r\": 0, \"g\": 0.5, \"b\": 1, \"opacity\": 0}, {\"value\": 10, \"r\": 1, \"g\": 0.5, \"b\": 0, \"opacity\": 0.5}]}"

static iso_geometry box(void)
{
    const size_t size[3] = {10, 20, 40};
    const double spacing[3] = {1, 2, 0.5};
    return iso_geometry_axis_aligned(size, spacing);
}

TEST(opacity_becomes_extinction_over_its_unit_distance)
{
    FREED char *path = write_text("a.tf.json", TF_HEAD
                                  "\"range\": [0, 10], \"unit_distance_mm\": 2, \"table_size\": 11, " TF_POINTS);
    OWNED(iso_tf) tf;
    OWNED(iso_tf_table) table;
    iso_geometry g = box();
    assert_ok(iso_tf_load(path, &tf, &err));
    assert_ok(iso_tf_tabulate(&tf, 0, 1, &g, &table, &err));
    assert_int_equal(table.count, 11);
    for (size_t i = 0; i < 11; ++i) { /* 1e-7: entries are floats */
        assert_within(table.entries[4 * i], 0.1 * (double)i, 1e-7);
        assert_within(table.entries[4 * i + 3], -log(1 - 0.05 * (double)i) / 2, 1e-7);
    }
    double rgbs[4];
    iso_tf_lookup(&table, 2.5, rgbs); /* halfway between two entries, each component by itself */
    assert_within(rgbs[3], 0.5 * ((double)table.entries[11] + (double)table.entries[15]), 1e-12);
    iso_tf_lookup(&table, -5, rgbs);
    assert_within(rgbs[2], 1, 0);
    iso_tf_lookup(&table, 99, rgbs);
    assert_within(rgbs[0], 1, 0);
}

TEST(a_fitted_range_follows_the_volume_and_voxels_follow_the_spacing)
{
    FREED char *path = write_text(
        "b.tf.json",
        "{\"schema\": \"isoshade.tf/1\", \"color_space\": \"srgb\", \"range\": \"fit\", "
        "\"unit_distance_voxels\": 3, \"points\": [{\"value\": 0.5, \"r\": 0.5, \"g\": 0, \"b\": 1, \"opacity\": 1}]}");
    OWNED(iso_tf) tf;
    iso_tf_table table;
    iso_geometry g = box();
    assert_ok(iso_tf_load(path, &tf, &err));
    assert_ok(iso_tf_tabulate(&tf, -1000, 3000, &g, &table, &err));
    assert_within(table.lo, -1000, 0);
    assert_within(table.hi, 3000, 0);
    assert_within(table.entries[0], 0.21404114048223255, 1e-7); /* sRGB 0.5, IEC 61966-2-1 */
    assert_within(table.entries[3], -log(1 - ISO_TF_MAX_OPACITY) / 3,
                  1e-5); /* the mean spacing is 1; opacity 1 is capped */
    iso_tf_table_destroy(&table);
    assert_ok(iso_tf_tabulate(&tf, 7, 7, &g, &table, &err)); /* a constant volume */
    assert_true(table.hi > table.lo);
    iso_tf_table_destroy(&table);
    assert_status(iso_tf_tabulate(&tf, NAN, 7, &g, &table, &err), ISO_E_RANGE);
}

TEST(two_points_of_one_value_make_a_step)
{
    FREED char *path = write_text(
        "c.tf.json", TF_HEAD
        "\"range\": [0, 4], \"unit_distance_mm\": 1, \"table_size\": 5, \"points\": ["
        "{\"value\": 0, \"r\": 0, \"g\": 0, \"b\": 0, \"opacity\": 0}, {\"value\": 1.5, \"r\": 0, \"g\": 0, \"b\": 0, \"opacity\": 0},"
        "{\"value\": 1.5, \"r\": 1, \"g\": 1, \"b\": 1, \"opacity\": 0.5}, {\"value\": 4, \"r\": 1, \"g\": 1, \"b\": 1, \"opacity\": 0.5}]}");
    const float expected[5] = {0, 0, 1, 1, 1};
    OWNED(iso_tf) tf;
    OWNED(iso_tf_table) table;
    iso_geometry g = box();
    assert_ok(iso_tf_load(path, &tf, &err));
    assert_ok(iso_tf_tabulate(&tf, 0, 1, &g, &table, &err));
    for (size_t i = 0; i < 5; ++i)
        assert_within(table.entries[4 * i], (double)expected[i], 0);
}

/* Values 0 to 65535 in 4096 entries: 16 values from one to the next. */
TEST(a_peak_between_two_entries_is_refused)
{
    iso_tf_point peak[] = {
        {.value = 0}, {.value = 1001}, {.value = 1004, .opacity = 0.8}, {.value = 1007}, {.value = 65535}};
    iso_tf tf = {.points = peak, .point_count = 5, .range = {0, 65535}, .unit_distance = 1, .table_size = 4096};
    iso_tf_table table;
    const iso_geometry g = box();
    iso_error e = {""};
    assert_int_equal(iso_tf_tabulate(&tf, 0, 1, &g, &table, &e), ISO_E_RANGE);
    assert_non_null(strstr(e.text, "point at 1004 with opacity 0.8 is lost between two of its table's 4096 entries"));
    tf.range[0] = 900, tf.range[1] = 1100;
    assert_ok(iso_tf_tabulate(&tf, 0, 1, &g, &table, &err));
    double at[4];
    iso_tf_lookup(&table, 1004, at);
    assert_within(-expm1(-at[3]), 0.8, 0.02); /* an entry is .05 wide, the flank rises by .27 a value */
    iso_tf_table_destroy(&table);
    peak[1].value = 900, peak[3].value = 1100; /* as wide as several entries: its top lies nearly at its height */
    tf.range[0] = 0, tf.range[1] = 65535;
    assert_ok(iso_tf_tabulate(&tf, 0, 1, &g, &table, &err));
    iso_tf_table_destroy(&table);
}

TEST(a_saved_tf_loads_as_the_same_table)
{
    FREED char *path = write_text("d.tf.json", TF_HEAD "\"range\": [0, 10], \"unit_distance_mm\": 2, " TF_POINTS);
    FREED char *again = iso_path_join(folder, "again.tf.json");
    OWNED(iso_tf) a, b;
    OWNED(iso_tf_table) ta, tb;
    iso_geometry g = box();
    assert_ok(iso_tf_load(path, &a, &err));
    assert_ok(iso_tf_save(&a, again, &err));
    assert_ok(iso_tf_load(again, &b, &err));
    assert_ok(iso_tf_tabulate(&a, 0, 1, &g, &ta, &err));
    assert_ok(iso_tf_tabulate(&b, 0, 1, &g, &tb, &err));
    assert_memory_equal(ta.entries, tb.entries, ta.count * 16);
}

TEST(bad_transfer_functions_are_refused_by_key_and_value)
{
    static const struct {
        const char *text, *named;
        iso_status status;
    } cases[] = {
        {"{", "not JSON", ISO_E_FORMAT},
        {"[]", "no JSON object", ISO_E_FORMAT},
        {"{\"schema\": \"isoshade.tf/2\"}", "isoshade.tf/2", ISO_E_FORMAT},
        {"{}", "lacks \"schema\", \"range\", \"unit_distance_mm\", \"color_space\", \"points\"; an example: {",
         ISO_E_FORMAT},
        {TF_HEAD "\"range\": \"auto\", \"unit_distance_mm\": 1, " TF_POINTS, "must be [lo, hi] or \"fit\"", ISO_E_FORMAT},
        {TF_HEAD "\"range\": \"fit\", \"unit_distance_mm\": 1, \"points\": [{\"value\": 0, \"r\": 1}]}",
         "a point lacks \"g\", \"b\", \"opacity\"", ISO_E_FORMAT},
        {TF_HEAD "\"range\": [0, 1], \"unit_distance_mm\": 1, \"points\": []}", "0 points", ISO_E_RANGE},
        {TF_HEAD "\"range\": [1, 1], \"unit_distance_mm\": 1, " TF_POINTS, "range", ISO_E_RANGE},
        {TF_HEAD "\"range\": [0, 1], \"unit_distance_mm\": 0, " TF_POINTS, "unit_distance_mm", ISO_E_RANGE},
        {TF_HEAD "\"range\": [0, 1], " TF_POINTS, "unit_distance_mm", ISO_E_FORMAT},
        {TF_HEAD "\"range\": [0, 1], \"unit_distance_mm\": 1, \"tabel_size\": 3, " TF_POINTS, "tabel_size",
         ISO_E_FORMAT},
        {TF_HEAD "\"range\": [0, 1], \"unit_distance_mm\": 1, \"table_size\": 20000, " TF_POINTS, "16384", ISO_E_RANGE},
        {TF_HEAD
         "\"range\": [0, 1], \"unit_distance_mm\": 1, \"points\": [{\"value\": 0, \"r\": 0, \"g\": 0, \"b\": 0, \"opacity\": 1.5}]}",
         "1.5", ISO_E_RANGE},
        {TF_HEAD
         "\"range\": [0, 1], \"unit_distance_mm\": 1, \"points\": [{\"value\": 1, \"r\": 0, \"g\": 0, \"b\": 0, \"opacity\": 1}, {\"value\": 0, \"r\": 0, \"g\": 0, \"b\": 0, \"opacity\": 1}]}",
         "ascend", ISO_E_RANGE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        FREED char *path = write_text("bad.tf.json", cases[i].text);
        iso_tf tf;
        iso_error e = {""};
        assert_int_equal(iso_tf_load(path, &tf, &e), cases[i].status);
        if (!strstr(e.text, cases[i].named) || !strstr(e.text, "bad.tf.json"))
            fail_msg("case %zu: \"%s\" does not name %s and the file", i, e.text, cases[i].named);
    }
}

/* clang-format off */
#define SCENE(camera, lights, shading)                                                                        \
    "{\"schema\": \"isoshade.scene/1\", \"camera\": {" camera "}, \"lights\": [" lights "], \"shading\": {" shading "}, \"tf\": " TF_HEAD \
    "\"range\": [0, 10], \"unit_distance_mm\": 2, " TF_POINTS "}"
/* clang-format on */
#define FIT_CAMERA "\"projection\": \"perspective\", \"fit\": true, \"direction\": [1, 1, 0]"
#define ONE_LIGHT "{\"direction\": [0, 0, 2], \"space\": \"camera\"}"
#define PLAIN_SHADING "\"ambient\": 0.3, \"diffuse\": 0.7"

TEST(a_fitted_camera_frames_the_whole_box)
{
    FREED char *path = write_text("a.scene.json", SCENE(FIT_CAMERA, ONE_LIGHT, PLAIN_SHADING));
    OWNED(iso_scene) scene;
    OWNED(iso_view) view;
    iso_geometry g = box();
    assert_ok(iso_scene_load(path, &scene, &err));
    assert_ok(iso_scene_resolve(&scene, &g, 0, 1, &view, &err));
    for (int corner = 0; corner < 8; ++corner) {
        iso_vec3 index = {corner & 1 ? 10 : 0, corner & 2 ? 20 : 0, corner & 4 ? 40 : 0};
        iso_vec3 p = iso_sub(iso_geometry_to_world(&g, index), view.camera.position);
        double depth = iso_dot(p, view.camera.forward);
        assert_more_than(depth, 0);
        assert_at_most(fabs(iso_dot(p, view.camera.right)) / depth, view.camera.half_height);
        assert_at_most(fabs(iso_dot(p, view.camera.up)) / depth, view.camera.half_height);
    }
    /* a light at the viewer's back shines along the view */
    assert_within(iso_dot(view.lights[0].direction, view.camera.forward), -1, 1e-12);
}

TEST(rays_leave_through_pixel_centers_with_row_0_on_top)
{
    iso_camera c = {.forward = {0, 1, 0}, .right = {1, 0, 0}, .up = {0, 0, 1}, .half_height = 0.5};
    iso_ray ray = iso_camera_ray(&c, 4, 2, 3, 0);
    assert_within(ray.direction.x / ray.direction.y, 0.75, 1e-12);
    assert_within(ray.direction.z / ray.direction.y, 0.25, 1e-12);
    c.orthographic = true;
    ray = iso_camera_ray(&c, 4, 2, 0, 1);
    assert_within(ray.origin.x, -0.75, 1e-12);
    assert_within(ray.origin.z, -0.25, 1e-12);
    assert_within(ray.direction.y, 1, 0);
}

TEST(a_ray_meets_the_box_between_its_faces)
{
    iso_geometry g = box(); /* 10 x 40 x 20 mm round the origin */
    double t0, t1;
    iso_ray ray = {{-20, 0, 0}, {1, 0, 0}};
    assert_true(iso_ray_box(&ray, &g, &t0, &t1));
    assert_within(t0, 15, 1e-12);
    assert_within(t1, 25, 1e-12);
    ray.origin.x = 0; /* from inside */
    assert_true(iso_ray_box(&ray, &g, &t0, &t1));
    assert_within(t0, 0, 0);
    assert_within(t1, 5, 1e-12);
    ray.origin = iso_v3(-20, 0, 10.1);
    assert_false(iso_ray_box(&ray, &g, &t0, &t1));
    ray = (iso_ray){{20, 0, 0}, {1, 0, 0}}; /* behind */
    assert_false(iso_ray_box(&ray, &g, &t0, &t1));
}

TEST(bad_scenes_are_refused_by_key_and_value)
{
    static const struct {
        const char *text, *named;
        iso_status status;
    } cases[] = {
        {SCENE(FIT_CAMERA, "", PLAIN_SHADING), "0 lights", ISO_E_RANGE},
        {SCENE(FIT_CAMERA, "{\"direction\": [0, 0, 0]}", PLAIN_SHADING), "direction", ISO_E_RANGE},
        {SCENE(FIT_CAMERA, ONE_LIGHT, "\"ambient\": 0.5, \"diffuse\": 0.7"), "1.2", ISO_E_RANGE},
        {SCENE(FIT_CAMERA, ONE_LIGHT, "\"ambient\": 0.5"), "diffuse", ISO_E_FORMAT},
        {SCENE("\"projection\": \"fisheye\"", ONE_LIGHT, PLAIN_SHADING), "fisheye", ISO_E_FORMAT},
        {SCENE("\"projection\": \"perspective\", \"fit\": true, \"direction\": [0, 0, 1]", ONE_LIGHT, PLAIN_SHADING),
         "up", ISO_E_RANGE},
        {SCENE("\"projection\": \"orthographic\", \"position\": [0,0,0], \"look_at\": [1,0,0]", ONE_LIGHT,
               PLAIN_SHADING),
         "height_mm", ISO_E_FORMAT},
        {SCENE("\"projection\": \"perspective\", \"position\": [1,0,0], \"look_at\": [1,0,0]", ONE_LIGHT,
               PLAIN_SHADING),
         "coincide", ISO_E_RANGE},
        {"{\"schema\": \"isoshade.scene/1\", \"camera\": {" FIT_CAMERA "}, \"lights\": [" ONE_LIGHT
         "], \"shading\": {" PLAIN_SHADING "}, \"tf\": \"none.tf.json\"}",
         "none.tf.json", ISO_E_IO},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        FREED char *path = write_text("bad.scene.json", cases[i].text);
        iso_scene scene;
        iso_error e = {""};
        assert_int_equal(iso_scene_load(path, &scene, &e), cases[i].status);
        if (!strstr(e.text, cases[i].named))
            fail_msg("case %zu: \"%s\" does not name %s", i, e.text, cases[i].named);
    }
}

TEST(the_reference_scenes_load)
{
    static const char *const names[] = {"refscenes/brain.scene.json", "refscenes/marschner-lobb.scene.json",
                                        "refscenes/shells.scene.json"};
    iso_geometry g = box();
    for (size_t i = 0; i < 3; ++i) {
        OWNED(iso_scene) scene;
        OWNED(iso_view) view;
        assert_ok(iso_scene_load(names[i], &scene, &err));
        assert_ok(iso_scene_resolve(&scene, &g, 0, 255, &view, &err));
    }
}

/* The densest that a file can state is read back from what is written of its table; a table that is denser is
 * refused. */
TEST(the_densest_table_is_read_back_and_a_denser_one_refused)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){4, 4, 4}, (double[]){1, 1, 1});
    iso_tf_point ends[] = {{.value = 0}, {.value = 1, .opacity = 1}};
    const iso_tf densest = {
        .point_count = 2, .points = ends, .range = {0, 1}, .unit_distance = ISO_TF_LEAST_UNIT, .table_size = 2};
    OWNED(iso_tf_table) table, back;
    iso_tf written, read;
    iso_error why = {""};
    assert_ok(iso_tf_tabulate(&densest, 0, 1, &g, &table, &err));
    assert_ok(iso_tf_from_table(&table, &written, &err));
    json_auto_t *file = iso_tf_to_json(&written);
    assert_ok(iso_tf_from_json(file, "densest", &read, &err));
    assert_ok(iso_tf_tabulate(&read, 0, 1, &g, &back, &err));
    assert_within(back.entries[7], table.entries[7], 1e-6 * table.entries[7]); /* floats */
    iso_tf_destroy(&written);
    iso_tf_destroy(&read);
    table.entries[7] *= 1.001f;
    assert_int_equal(iso_tf_from_table(&table, &written, &why), ISO_E_RANGE);
    assert_non_null(strstr(why.text, "exceeds the limit of transfer functions"));
}

/* What is written and read comes back as the same table: float entries, and opacities stated in 17 digits. Formats of
 * other programs have display colors on lines, so their own limits hold: nodes within 1/2048 of the table, or bytes. */
TEST(each_format_that_is_written_and_read_keeps_the_table)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){4, 4, 4}, (double[]){1, 1, 1});
    float entries[4 * 16];
    for (int i = 0; i < 64; ++i)
        entries[i] = (float)(i * 37 % 64) / 64;
    const iso_tf_table table = {.count = 16, .lo = -3, .hi = 12, .entries = entries};
    iso_tf points;
    int own = 0, others = 0;
    assert_ok(iso_tf_from_table(&table, &points, &err));
    for (size_t f = 0; iso_tf_format_at(f); ++f) {
        const iso_tf_format *format = iso_tf_format_at(f);
        const iso_tf_request request = {.unit_mm = format->has_no_unit ? 1 : 0};
        const bool is_own = strcmp(format->name, "json") == 0 || strcmp(format->name, "csv") == 0;
        char path[512];
        snprintf(path, sizeof path, "%s/table%s", folder, format->suffix);
        assert_true(format->name[0] && format->summary[0] && (format->load || format->save));
        assert_ptr_equal(iso_tf_format_of(path), format);
        if (!format->save)
            continue;
        assert_ok(format->save(&(iso_tf_output){&points, &table, 1}, path, &err));
        if (!format->load)
            continue;
        OWNED(iso_tf) tf;
        OWNED(iso_tf_table) back;
        assert_ok(iso_tf_load_as(path, &request, &tf, &err));
        assert_ok(iso_tf_tabulate(&tf, 0, 1, &g, &back, &err));
        if (is_own)
            assert_int_equal(back.count, 16);
        for (int i = 0; i < 16; ++i) {
            double was[4], is[4];
            iso_tf_lookup(&table, i - 3, was);
            iso_tf_lookup(&back, i - 3, is);
            for (int c = 0; c < 3; ++c)
                assert_within(iso_linear_to_srgb(is[c]), iso_linear_to_srgb(was[c]), is_own ? 1e-6 : 2.0 / 255);
            assert_within(-expm1(-is[3]), -expm1(-was[3]), is_own ? 1e-6 : 2.0 / 255);
        }
        ++*(is_own ? &own : &others);
    }
    iso_tf_destroy(&points);
    assert_int_equal(own, 2);
    assert_int_equal(others, 3);
    char written[128];
    assert_string_equal(iso_tf_format_written(written, sizeof written),
                        ".csv, .tf.json, .vp.json, .paraview.json, .niivue.json or .png");
}

TEST_MAIN(make_folder, remove_folder)
