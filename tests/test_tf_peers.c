/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
/* test_tf_peers.c - transfer functions of other programs against what those programs show.
 *
 * tests/tf/vtk_tables.json holds tables of VTK's own functions, made by tests/peers/vtk_tables.py, which says of which
 * version. */
#include "base/file.h"
#include "tf/ciede2000.h"
#include "tf/format.h"
#include "folder.h"
#include "test.h"

static iso_geometry unit_voxels(void)
{
    return iso_geometry_axis_aligned((size_t[]){1, 1, 1}, (double[]){1, 1, 1});
}

/* The largest difference of the TF `name` of `file` from the case's table, whose places are the entries. Colors that
 * cannot be seen are not compared: a range begins where something is seen. */
static double difference(const char *file, const char *name, const json_t *vtk_case)
{
    const json_t *table = json_object_get(vtk_case, "table"), *range = json_object_get(vtk_case, "range");
    const iso_geometry g = unit_voxels();
    const iso_tf_request request = {.name = name, .unit_mm = strstr(file, ".paraview") ? 1 : 0, .measure = true};
    double most = 0;
    OWNED(iso_tf) tf;
    OWNED(iso_tf_table) t;
    assert_ok(iso_tf_load_as(file, &request, &tf, &err));
    assert_true(tf.loss.measured);
    assert_at_most(tf.loss.color, 1.0 / 255);
    assert_at_most(tf.loss.opacity, 1.0 / 255);
    tf.table_size = json_array_size(table);
    tf.range[0] = json_number_value(json_array_get(range, 0)),
    tf.range[1] = json_number_value(json_array_get(range, 1));
    assert_ok(iso_tf_tabulate(&tf, 0, 1, &g, &t, &err));
    for (size_t i = 0; i < t.count; ++i) {
        const json_t *row = json_array_get(table, i);
        const float *e = t.entries + 4 * i;
        const double opacity = fmin(json_number_value(json_array_get(row, 3)), ISO_TF_MAX_OPACITY);
        most = fmax(most, fabs(-expm1(-(double)e[3] * tf.unit_distance) - opacity));
        for (size_t c = 0; c < 3 && opacity > 0; ++c)
            most = fmax(most, fabs(iso_linear_to_srgb((double)e[c]) - json_number_value(json_array_get(row, c))));
    }
    return most;
}

static const char *word(const json_t *object, const char *key)
{
    return json_string_value(json_object_get(object, key));
}

/* 1/255: what eight bits can show. Points are closer, a quarter of it, and the expected values have six digits. */
TEST(curves_are_those_of_vtk)
{
    json_auto_t *root;
    assert_ok(iso_json_load("tests/tf/vtk_tables.json", &root, &err));
    const json_t *cases = json_object_get(root, "cases");
    assert_int_equal(json_array_size(cases), 11);
    for (size_t i = 0; i < json_array_size(cases); ++i) {
        const json_t *c = json_array_get(cases, i);
        const double most = difference(word(c, "file"), word(c, "name"), c);
        const bool rounds = strcmp(word(c, "name"), "ciede2000") == 0; /* VTK rounds colors of this space to bytes */
        if (!(most <= (rounds ? 0.75 : 0.25) / 255 + 1e-6))
            fail_msg("%s of %s: %g/255 from VTK's table", word(c, "name"), word(c, "file"), 255 * most);
    }
    /* Hues that go the other way round, and straight ways instead of bent ones, are noticed. */
    const json_t *hsv = json_array_get(cases, 1), *bent = json_array_get(cases, 9);
    assert_string_equal(word(hsv, "name"), "hsv");
    assert_more_than(difference(word(hsv, "file"), "hsv, wrapped", hsv), 0.1);
    assert_more_than(difference(word(bent, "file"), "2", bent), 0.1);
}

/* VTK's own test of its class has this color in the middle, in bytes: (199, 0, 175). */
TEST(prolab_is_that_of_vtk)
{
    double rgb[3];
    iso_color_mix(ISO_SPACE_PROLAB, (double[]){1, 0, 0}, (double[]){0, 0, 1}, 0.5, 0, rgb);
    const double expected[3] = {199, 0, 175};
    for (int c = 0; c < 3; ++c)
        assert_within(255 * rgb[c], expected[c], 0.5);
}

/* Pairs of the table that comes with [sharma-2005], which has four digits. */
TEST(color_differences_are_those_published)
{
    static const double pairs[][7] = {{50, 2.6772, -79.7751, 50, 0, -82.7485, 2.0425},
                                      {50, -1, 2, 50, 0, 0, 2.3669},
                                      {50, 2.5, 0, 73, 25, -18, 27.1492},
                                      {60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644},
                                      {2.0776, 0.0795, -1.1350, 0.9033, -0.0636, -0.5514, 0.9082}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; ++i)
        assert_within(iso_ciede2000(pairs[i], pairs[i] + 3), pairs[i][6], 0.5e-4);
}

static char *write_file(const char *name, const void *text, size_t size)
{
    char *path = iso_path_join(folder, name);
    assert_ok(iso_file_write(path, text, size, &err));
    return path;
}

static iso_tf load(const char *name, const char *text, iso_tf_request request)
{
    iso_tf tf;
    FREED char *path = write_file(name, text, strlen(text));
    assert_ok(iso_tf_load_as(path, &request, &tf, &err));
    return tf;
}

/* Display color and opacity of a value, as the table has them. */
static void assert_shows(const iso_tf *tf, double value, const double rgba[4])
{
    const iso_geometry g = unit_voxels();
    OWNED(iso_tf_table) t;
    double found[4];
    assert_ok(iso_tf_tabulate(tf, 0, 1, &g, &t, &err));
    iso_tf_lookup(&t, value, found);
    for (int c = 0; c < 3; ++c)
        assert_within(iso_linear_to_srgb(found[c]), rgba[c], 0.5 / 255); /* half of what eight bits can show */
    assert_within(-expm1(-found[3] * tf->unit_distance), fmin(rgba[3], ISO_TF_MAX_OPACITY), 0.5 / 255);
}

TEST(steps_at_the_ends_hold_beyond_them)
{
    OWNED(iso_tf)
    tf = load("ends.vp", "1\n1\n1\n0\n0\n1\n8 10 0 10 0.4 20 0.4 20 0.8\n4 0 1 1 1\n8 10 1 1 1 20 1 1 1\n",
              (iso_tf_request){0});
    assert_shows(&tf, 9, (double[]){1, 1, 1, 0});
    assert_shows(&tf, 15, (double[]){1, 1, 1, 0.4});
    assert_shows(&tf, 21, (double[]){1, 1, 1, 0.8});
}

TEST(a_length_of_slicer_is_in_the_file)
{
    OWNED(iso_tf) tf;
    assert_ok(iso_tf_load_as("tests/tf/curves.vp.json", &(iso_tf_request){.name = "1"}, &tf, &err));
    assert_within(tf.unit_distance, 2.5, 0);
    assert_false(tf.unit_is_voxels);
}

static const char vp_lines[] = "1\n1\n0.9\n0.1\n0.2\n10\n6 0 0 50 0.25 100 0.75\n4 0 1 255 1\n"
                               "8 0 0 0 0 100 1 0.5 0.25\n";

TEST(older_properties_of_slicer)
{
    iso_tf tf = load("a.vp", vp_lines, (iso_tf_request){0});
    assert_within(tf.unit_distance, 1, 0);
    assert_shows(&tf, 25, (double[]){0.25, 0.125, 0.0625, 0.125});
    assert_shows(&tf, 75, (double[]){0.75, 0.375, 0.1875, 0.5});
    iso_tf_destroy(&tf);
    static const char mrml[] =
        "<MRML><VolumeProperty name=\"a\" scalarOpacity=\"4 0 0 100 1\" gradientOpacity=\"2 0 1\" "
        "colorTransfer=\"8 0 0 0 0 100 1 0.5 0.25\"/><VolumeProperty name=\"b\" scalarOpacity=\"4 0 0 10 1\" "
        "colorTransfer=\"8 0 0 0 0 10 1 1 1\"/></MRML>";
    tf = load("a.xml", mrml, (iso_tf_request){.name = "b", .unit_mm = 3}); /* Slicer's length is a default */
    assert_within(tf.range[1], 10, 0);
    assert_within(tf.unit_distance, 3, 0);
    assert_shows(&tf, 5, (double[]){0.5, 0.5, 0.5, 0.5});
    iso_tf_destroy(&tf);
}

TEST(maps_of_paraview_fit_the_volume)
{
    /* A comma before a bracket, as ParaView's own file has. */
    static const char json[] =
        "[{\"Name\": \"a, b]\", \"ColorSpace\": \"RGB\", \"RGBPoints\": [-1, 0, 0, 0, 1, 1, 1, 1,],},]";
    iso_tf tf = load("a.json", json, (iso_tf_request){.unit_mm = 2, .has_opacity = true, .opacity = {0.2, 0.6}});
    assert_true(tf.fit_range);
    assert_shows(&tf, 0.5, (double[]){0.5, 0.5, 0.5, 0.4});
    iso_tf_destroy(&tf);
    tf = load(
        "a.json", json,
        (iso_tf_request){.unit_mm = 2, .has_opacity = true, .opacity = {1, 1}, .has_range = true, .range = {-1, 1}});
    assert_false(tf.fit_range);
    assert_shows(&tf, 0, (double[]){0.5, 0.5, 0.5, 1});
    iso_tf_destroy(&tf);
    static const char xml[] =
        "<ColorMaps><ColorMap name=\"a\" space=\"RGB\"><Point x=\"-5\" o=\"0\" r=\"0\" g=\"0\" b=\"0\"/>"
        "<Point x=\"5\" o=\"1\" r=\"1\" g=\"1\" b=\"0\"/><NaN r=\"1\" g=\"0\" b=\"0\"/></ColorMap></ColorMaps>";
    tf = load("a.xml", xml, (iso_tf_request){.unit_mm = 1});
    assert_shows(&tf, 0, (double[]){0.5, 0.5, 0, 0.5});
    iso_tf_destroy(&tf);
}

TEST(maps_of_niivue_are_bytes_a_voxel)
{
    static const char text[] =
        "{\"min\": -10, \"max\": 92, \"R\": [0, 200, 255], \"G\": [0, 100, 255], \"B\": [0, 50, 255], "
        "\"A\": [0, 51, 102], \"I\": [0, 125, 255]}";
    OWNED(iso_tf) tf = load("a.json", text, (iso_tf_request){0});
    assert_true(tf.unit_is_voxels);
    assert_within(tf.unit_distance, 1, 0);
    assert_shows(&tf, 40, (double[]){200 / 255.0, 100 / 255.0, 50 / 255.0, 0.2});
}

TEST(points_of_inviwo_old_and_new)
{
    static const char *const texts[] = {
        "<?xml version=\"1.0\" ?><InviwoTreeData version=\"1.0\"><maskMin content=\"0\"/><maskMax content=\"1\"/><dataPoints>"
        "<point><pos x=\"0\" y=\"0\"/><rgba x=\"0\" y=\"0\" z=\"0\" w=\"0\"/></point>"
        "<point><pos x=\"0.5\" y=\"1\"/><rgba x=\"1\" y=\"0.5\" z=\"0.2\" w=\"0.8\"/></point></dataPoints></InviwoTreeData>",
        "<InviwoWorkspace version=\"3\"><Points><Point><pos content=\"0\"/><rgba x=\"0\" y=\"0\" z=\"0\" w=\"0\"/></Point>"
        "<Point><pos content=\"0.5\"/><rgba x=\"1\" y=\"0.5\" z=\"0.2\" w=\"0.8\"/></Point></Points></InviwoWorkspace>"};
    for (int i = 0; i < 2; ++i) {
        OWNED(iso_tf) tf = load("a.itf", texts[i], (iso_tf_request){.unit_mm = 1});
        assert_true(tf.fit_range);
        assert_shows(&tf, 0.25, (double[]){0.5, 0.25, 0.1, 0.4});
        assert_shows(&tf, 0.9, (double[]){1, 0.5, 0.2, 0.8});
    }
}

TEST(split_keys_of_voreen_are_steps)
{
    static const char text[] =
        "<VoreenData version=\"1\"><TransFuncIntensity><domain x=\"100\" y=\"200\"/><threshold x=\"0\" y=\"1\"/><Keys>"
        "<key><intensity value=\"0\"/><split value=\"false\"/><colorL r=\"0\" g=\"0\" b=\"0\" a=\"51\"/></key>"
        "<key><intensity value=\"0.505\"/><split value=\"true\"/><colorL r=\"0\" g=\"0\" b=\"0\" a=\"51\"/>"
        "<colorR r=\"255\" g=\"0\" b=\"51\" a=\"204\"/></key>"
        "<key><intensity value=\"1\"/><split value=\"false\"/><colorL r=\"255\" g=\"0\" b=\"51\" a=\"204\"/></key>"
        "</Keys></TransFuncIntensity></VoreenData>";
    OWNED(iso_tf) tf = load("a.tfi", text, (iso_tf_request){.unit_mm = 1});
    assert_shows(&tf, 150.4, (double[]){0, 0, 0, 0.2});
    assert_shows(&tf, 150.6, (double[]){1, 0, 0.2, 0.8});
}

TEST(lookup_tables_of_imagej)
{
    unsigned char bytes[800] = "ICOL";
    const iso_tf_request request = {.unit_mm = 1, .has_opacity = true, .opacity = {0.5, 0.5}};
    for (int i = 0; i < 256; ++i)
        bytes[32 + i] = (unsigned char)i, bytes[288 + i] = (unsigned char)(255 - i), bytes[544 + i] = 51;
    for (int header = 0; header < 2; ++header) {
        OWNED(iso_tf) tf;
        FREED char *path = write_file("a.lut", bytes + (header ? 0 : 32), header ? 800 : 768);
        assert_ok(iso_tf_load_as(path, &request, &tf, &err));
        assert_shows(&tf, 51 / 255.0, (double[]){0.2, 0.8, 0.2, 0.5});
    }
    char text[256 * 16] = "Index Red Green Blue\n";
    for (int i = 0; i < 256; ++i)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%d %d %d 51\n", i, i, 255 - i);
    OWNED(iso_tf) tf = load("b.lut", text, request);
    assert_shows(&tf, 51 / 255.0, (double[]){0.2, 0.8, 0.2, 0.5});
}

TEST(tables_of_display_colors)
{
    const iso_tf_request unit = {.unit_mm = 1};
    iso_tf tf = load("a.csv", "# of matplotlib\n0 0 0 0\n1.0 0.5 0.2 0.8\n", unit);
    assert_shows(&tf, 0.5, (double[]){0.5, 0.25, 0.1, 0.4});
    iso_tf_destroy(&tf);
    tf = load("a.csv", "Value,Red,Green,Blue,Alpha\n-10,0,0,0,0\n10,255,0,51,1\n", unit); /* bytes, and a fraction */
    assert_shows(&tf, 0, (double[]){0.5, 0, 0.1, 0.5});
    iso_tf_destroy(&tf);
}

TEST_MAIN(make_folder, remove_folder)
