/* SPDX-License-Identifier: MIT */
/* The library's interface: what its header promises, by that header alone. Errors come back as a status and a sentence,
 * and leave nothing behind (the sanitizers see to that). */
#define _GNU_SOURCE
#include <dirent.h>
#include <sys/wait.h>
#include <unistd.h>

#include "isoshade.h"
#include "tests/folder.h"
#include "tests/test.h"

enum { NX = 20, NY = 17, NZ = 12 };

static const char scene_text[] =
    "{\"schema\": \"isoshade.scene/1\", \"image\": {\"width\": 24, \"height\": 20},"
    " \"camera\": {\"projection\": \"orthographic\", \"fit\": true, \"direction\": [0, 1, 0], \"up\": [0, 0, 1]},"
    " \"lights\": [{\"direction\": [0, 0, 1], \"space\": \"camera\", \"intensity\": 1}],"
    " \"shading\": {\"ambient\": 0.3, \"diffuse\": 0.7},"
    " \"tf\": {\"schema\": \"isoshade.tf/1\", \"range\": \"fit\", \"unit_distance_mm\": 2, \"color_space\": \"linear\","
    "  \"points\": [{\"value\": 0, \"r\": 0, \"g\": 0.5, \"b\": 1, \"opacity\": 0},"
    "               {\"value\": 1, \"r\": 1, \"g\": 0.5, \"b\": 0, \"opacity\": 0.5}]}}";

/* A ramp along (1, 2, 3) with unequal spacings, so that a swapped axis shows. */
static iso_grid ramp_grid(void)
{
    return iso_grid_axis_aligned((size_t[3]){NX, NY, NZ}, (double[3]){1, 2, 0.5});
}

static iso_volume *ramp(void)
{
    FREED float *samples = malloc(NX * NY * NZ * sizeof *samples);
    const iso_grid grid = ramp_grid();
    iso_volume *volume = NULL;
    assert_non_null(samples);
    for (size_t z = 0, i = 0; z < NZ; ++z)
        for (size_t y = 0; y < NY; ++y)
            for (size_t x = 0; x < NX; ++x)
                samples[i++] = (float)(1 * (double)x + 2 * 2 * (double)y + 3 * 0.5 * (double)z);
    assert_ok(iso_volume_from_memory(&grid, "float", samples, &volume, &err));
    return volume;
}

static iso_pyramid *ramp_pyramid(bool keep_float)
{
    iso_volume *volume = ramp();
    iso_pyramid *pyramid = NULL;
    iso_build_options o = iso_build_defaults();
    o.levels = 3;
    o.keep_float = o.keep_magnitude = keep_float;
    assert_ok(iso_build(volume, &o, &pyramid, &err));
    iso_volume_free(volume);
    return pyramid;
}

static iso_scene *a_scene(void)
{
    iso_scene *scene = NULL;
    assert_ok(iso_scene_from_text(scene_text, &scene, &err));
    return scene;
}

TEST(versions_agree)
{
    char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", ISO_VERSION_MAJOR, ISO_VERSION_MINOR, ISO_VERSION_PATCH);
    assert_string_equal(ISO_VERSION, text);
    assert_string_equal(iso_version(), text);
    assert_int_equal(iso_version_number(), ISO_VERSION_NUMBER);
    assert_int_equal(ISO_VERSION_NUMBER / 1000 % 1000, ISO_VERSION_MINOR);
}

TEST(statuses_have_texts)
{
    assert_string_equal(iso_status_text(ISO_E_IO), "a file could not be read or written");
    assert_string_equal(iso_status_text((iso_status)77), "unknown status");
}

/* Each list holds the defaults, ends, and has no name twice. */
TEST(choices_are_listed)
{
    const iso_build_options build = iso_build_defaults();
    const iso_frame_options frame = iso_frame_defaults();
    const struct {
        iso_choice what;
        const char *holds;
    } lists[] = {{ISO_CHOICE_VOXEL_TYPE, "double"},
                 {ISO_CHOICE_CODE, build.code},
                 {ISO_CHOICE_ESTIMATOR, build.estimator},
                 {ISO_CHOICE_SCALAR_FILTER, build.scalar_filter},
                 {ISO_CHOICE_DIRECTION_FILTER, build.direction_filter},
                 {ISO_CHOICE_SHADING, frame.shading},
                 {ISO_CHOICE_RENDERER, frame.renderer},
                 {ISO_CHOICE_EXPORT, "povray"},
                 {ISO_CHOICE_TF, "ct-bone"},
                 {ISO_CHOICE_VIEW, "front"}};
    for (size_t l = 0; l < sizeof lists / sizeof *lists; ++l) {
        bool found = false;
        size_t i = 0;
        for (const char *name; (name = iso_choice_name(lists[l].what, i)); ++i) {
            assert_true(i < 64);
            found = found || strcmp(name, lists[l].holds) == 0;
            for (size_t j = 0; j < i; ++j)
                assert_string_not_equal(name, iso_choice_name(lists[l].what, j));
        }
        assert_true(found && i >= 2);
        assert_null(iso_choice_name(lists[l].what, i + 1));
    }
    assert_null(iso_choice_name((iso_choice)99, 0));
}

TEST(a_volume_is_what_memory_held)
{
    iso_volume *volume = ramp();
    const iso_grid grid = iso_volume_grid(volume), made = ramp_grid();
    double spacing_mm[3];
    assert_memory_equal(&grid, &made, sizeof grid);
    iso_grid_spacing_mm(&grid, spacing_mm);
    assert_within(spacing_mm[0], 1, 0);
    assert_within(spacing_mm[1], 2, 0);
    assert_within(spacing_mm[2], 0.5, 0);
    assert_within(grid.index_to_world[1][3], -17, 0); /* half of 17 voxels of 2 mm */
    iso_volume_free(volume);
    iso_volume_free(NULL);
}

TEST(a_level_is_read_in_place)
{
    iso_pyramid *pyramid = ramp_pyramid(true);
    iso_level_view level;
    assert_int_equal(iso_pyramid_level_count(pyramid), 3);
    assert_ok(iso_pyramid_level(pyramid, 1, &level, &err));
    assert_int_equal(level.grid.size[0], 10);
    assert_int_equal(level.grid.size[1], 9);
    assert_int_equal(level.grid.size[2], 6);
    assert_within(level.grid.box_index[1], 8.5, 0);
    /* the mean of a linear ramp over the first 2 x 2 x 2 voxels; the values are multiples of 1/4 */
    assert_within((double)level.values[0], 0.5 * (1 + 4 + 1.5), 0);
    assert_within((double)level.values[1] - (double)level.values[0], 2, 0);
    const double length = sqrt(14);
    /* the gradient (1, 2, 3) by float arithmetic on values up to 100, a few of their roundings */
    for (int c = 0; c < 3; ++c)
        assert_within((double)level.directions[c], (c + 1) / length, 1e-5);
    assert_within((double)level.magnitudes[0], length, 1e-4);
    assert_string_equal(level.code, "fit");
    iso_pyramid_free(pyramid);
    iso_pyramid_free(NULL);
}

TEST(directions_of_a_level_are_decoded)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    iso_level_view level;
    assert_ok(iso_pyramid_level(pyramid, 1, &level, &err));
    assert_null(level.directions);
    assert_null(level.magnitudes);
    const size_t count = level.grid.size[0] * level.grid.size[1] * level.grid.size[2];
    FREED float *directions = malloc(3 * count * sizeof *directions), *again = malloc(3 * count * sizeof *again);
    assert_true(directions && again);
    assert_ok(iso_pyramid_directions(pyramid, 1, directions, &err));
    assert_ok(iso_directions_decode(level.code, level.codes, count, again, &err));
    assert_memory_equal(directions, again, 3 * count * sizeof *again);
    for (size_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) /* a code step is 1/127 */
            assert_within((double)directions[3 * i + (size_t)c], (c + 1) / sqrt(14), 1.0 / 127);
    iso_pyramid_free(pyramid);
}

TEST(directions_survive_each_code)
{
    const float d[6] = {0.6f, 0, -0.8f, 0.48f, 0.6f, 0.64f};
    const char *code;
    for (size_t i = 0; (code = iso_choice_name(ISO_CHOICE_CODE, i)); ++i) {
        uint8_t bytes[2 * 16];
        float back[6];
        assert_true(iso_directions_bytes(code) >= 1 && iso_directions_bytes(code) <= 16);
        assert_ok(iso_directions_encode(code, d, 2, bytes, &err));
        assert_ok(iso_directions_decode(code, bytes, 2, back, &err));
        for (int k = 0; k < 2; ++k) {
            const float *a = d + 3 * k, *b = back + 3 * k;
            const double dot = (double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2];
            const double length = sqrt((double)b[0] * b[0] + (double)b[1] * b[1] + (double)b[2] * b[2]);
            assert_more_than(dot / length, cos(0.02)); /* rad; the coarsest code has cells of 1/127 */
        }
    }
    assert_int_equal(iso_directions_bytes("no such code"), 0);
}

TEST(a_pyramid_is_saved_and_opened)
{
    iso_pyramid *made = ramp_pyramid(false), *opened = NULL;
    char path[512];
    snprintf(path, sizeof path, "%s/ramp.iso", folder);
    assert_ok(iso_pyramid_save(made, path, &err));
    assert_ok(iso_pyramid_open(path, &opened, &err));
    iso_level_view a, b;
    for (size_t k = 0; k < 3; ++k) {
        assert_ok(iso_pyramid_level(made, k, &a, &err));
        assert_ok(iso_pyramid_level(opened, k, &b, &err));
        const size_t count = a.grid.size[0] * a.grid.size[1] * a.grid.size[2];
        assert_memory_equal(a.values, b.values, count * sizeof *a.values);
        assert_memory_equal(a.codes, b.codes, 3 * count);
    }
    iso_pyramid_free(made);
    iso_pyramid_free(opened);
}

TEST(a_volume_is_saved_and_opened)
{
    iso_volume *made = ramp(), *opened = NULL;
    char path[512];
    snprintf(path, sizeof path, "%s/ramp.nrrd", folder);
    assert_ok(iso_volume_save(made, path, false, &err));
    assert_ok(iso_volume_open(path, &opened, &err));
    const iso_grid a = iso_volume_grid(made), b = iso_volume_grid(opened);
    assert_memory_equal(&a, &b, sizeof a);
    iso_volume_free(made);
    iso_volume_free(opened);
}

TEST(a_tf_is_evaluated_and_saved)
{
    const iso_tf_point points[] = {{0, {0, 0, 0}, 0}, {10, {1, 0.5, 0.25}, 0.5}};
    const double values[] = {-5, 5, 10, 99};
    double entries[4][4], again[4][4];
    char path[512];
    iso_pyramid *pyramid = ramp_pyramid(false);
    iso_tf *tf = NULL, *opened = NULL;
    assert_ok(iso_tf_from_points(points, 2, 2, &tf, &err));
    assert_ok(iso_tf_evaluate(tf, pyramid, values, 4, entries, &err));
    assert_within(entries[0][3], 0, 0);
    assert_within(entries[1][0], 0.5, 1e-6); /* floats of the table */
    assert_within(entries[1][3], -log(0.75) / 2, 1e-6);
    assert_within(entries[2][3], -log(0.5) / 2, 1e-6);
    assert_memory_equal(entries[2], entries[3], sizeof entries[3]);
    snprintf(path, sizeof path, "%s/a.tf.json", folder);
    assert_ok(iso_tf_save(tf, path, &err));
    assert_ok(iso_tf_open(path, &opened, &err));
    assert_ok(iso_tf_evaluate(opened, pyramid, values, 4, again, &err));
    assert_memory_equal(entries, again, sizeof again);
    iso_tf_free(tf);
    iso_tf_free(opened);
    iso_tf_free(NULL);
    iso_pyramid_free(pyramid);
}

TEST(an_adapted_tf_renders)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    iso_scene *scene = a_scene();
    iso_tf *tf = NULL, *adapted = NULL;
    double own[4];
    OWNED(iso_image) image, other;
    iso_metrics m;
    const iso_tf_point points[] = {{0, {1, 1, 1}, 0}, {90, {1, 0, 0}, 0.5}};
    iso_frame_options o = iso_frame_defaults();
    assert_ok(iso_tf_from_points(points, 2, 1, &tf, &err));
    assert_ok(iso_tf_adapt(tf, pyramid, 1, &adapted, &err));
    o.level = 1;
    o.width = o.height = 16;
    o.tf = adapted;
    assert_ok(iso_render(pyramid, scene, &o, &image, &err));
    assert_int_equal(image.width, 16);
    o.tf = NULL; /* the scene's own is blue where this one is white: another image */
    assert_ok(iso_render(pyramid, scene, &o, &other, &err));
    assert_ok(iso_metrics_measure(&image, &other, &m, &err));
    assert_more_than(m.max_abs, 0.05);
    assert_ok(iso_metrics_measure(&image, &image, &m, &err));
    assert_within(m.max_abs, 0, 0);
    assert_ok(iso_tf_evaluate(iso_scene_tf(scene), pyramid, (double[1]){1e9}, 1, &own, &err));
    assert_within(own[3], -log(0.5) / 2, 1e-6); /* its last entry, a float */
    iso_tf_free(tf);
    iso_tf_free(adapted);
    iso_scene_free(scene);
    iso_scene_free(NULL);
    iso_pyramid_free(pyramid);
}

/* A constant medium seen along an axis: alpha is 1 - exp(-sigma depth), and does not depend on the step. */
TEST(a_slab_has_its_closed_form)
{
    const iso_grid grid = iso_grid_axis_aligned((size_t[3]){4, 6, 5}, (double[3]){1, 0.5, 1});
    uint8_t samples[4 * 6 * 5];
    memset(samples, 200, sizeof samples);
    samples[0] = 199; /* a range that is not empty */
    iso_volume *volume = NULL;
    iso_pyramid *pyramid = NULL;
    iso_scene *scene = a_scene();
    iso_tf *tf = NULL;
    iso_image image;
    const iso_tf_point points[] = {{0, {1, 1, 1}, 0.3}, {255, {1, 1, 1}, 0.3}};
    assert_ok(iso_volume_from_memory(&grid, "uint8", samples, &volume, &err));
    assert_ok(iso_build(volume, NULL, &pyramid, &err));
    assert_ok(iso_tf_from_points(points, 2, 1, &tf, &err));
    iso_frame_options o = iso_frame_defaults();
    o.tf = tf;
    for (int i = 0; i < 2; ++i) {
        o.step_voxels = i * 0.7;
        assert_ok(iso_render(pyramid, scene, &o, &image, &err));
        /* 3 mm along y; the converged quadrature stops at 1e-9 or so of a pixel, the image is float */
        assert_within((double)image.rgba[4 * (10 * image.width + 12) + 3], 1 - pow(0.7, 3), 2e-7);
        iso_image_destroy(&image);
    }
    iso_tf_free(tf);
    iso_scene_free(scene);
    iso_pyramid_free(pyramid);
    iso_volume_free(volume);
}

TEST(a_vdb_is_exported)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    char path[512];
    snprintf(path, sizeof path, "%s/ramp.vdb", folder);
    iso_export_options o = iso_export_defaults();
    o.level_count = 3;
    assert_ok(iso_export(pyramid, NULL, "vdb", path, &o, &err));
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fclose(file);
    iso_pyramid_free(pyramid);
}

TEST(a_povray_scene_is_exported)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    iso_scene *scene = a_scene();
    char path[512], file_path[600];
    snprintf(path, sizeof path, "%s/ramp-pov", folder);
    assert_ok(iso_export(pyramid, scene, "povray", path, NULL, &err));
    snprintf(file_path, sizeof file_path, "%s/ramp-pov.ini", path);
    FILE *file = fopen(file_path, "rb");
    assert_non_null(file);
    fclose(file);
    iso_scene_free(scene);
    iso_pyramid_free(pyramid);
}

static bool progress_is_told(void *user, const char *stage, double fraction)
{
    assert_non_null(stage);
    assert_true(fraction >= 0 && fraction <= 1);
    ++*(int *)user;
    return true;
}

TEST(work_reports_its_progress)
{
    int calls = 0;
    iso_volume *volume = ramp();
    iso_pyramid *pyramid = NULL;
    iso_build_options o = iso_build_defaults();
    o.progress = progress_is_told;
    o.progress_user = &calls;
    assert_ok(iso_build(volume, &o, &pyramid, &err));
    assert_true(calls > 0);
    iso_pyramid_free(pyramid);
    iso_volume_free(volume);
}

/* Goes on for a number of reports, then cancels. No report may follow. */
typedef struct patience {
    int left, late;
} patience;

static bool cancel_in_the_end(void *user, const char *stage, double fraction)
{
    patience *p = user;
    (void)stage;
    (void)fraction;
    p->late += p->left < 0;
    return p->left-- > 0;
}

static size_t file_count(void)
{
    struct dirent **names = NULL;
    const int count = scandir(folder, &names, NULL, NULL);
    for (int i = 0; i < count; ++i)
        free(names[i]);
    free(names);
    return count > 0 ? (size_t)count : 0;
}

TEST(canceled_work_leaves_nothing)
{
    iso_volume *volume = ramp();
    iso_pyramid *pyramid = ramp_pyramid(false), *other = pyramid;
    iso_scene *scene = a_scene();
    char path[512], *html = path;
    snprintf(path, sizeof path, "%s/canceled", folder);
    const size_t files = file_count();
    iso_error err = {""};
    for (int after = 0; after < 3; ++after) {
        patience p = {.left = after};
        iso_build_options build = iso_build_defaults();
        build.progress = cancel_in_the_end;
        build.progress_user = &p;
        assert_int_equal(iso_build(volume, &build, &other, &err), after < 1 ? ISO_E_CANCELED : ISO_OK);
        assert_true(p.late == 0 && (after > 0) == (other != NULL)); /* it reports its slab, then its end */
        iso_pyramid_free(other);

        iso_frame_options frame = iso_frame_defaults();
        iso_image image;
        p = (patience){.left = after};
        frame.progress = cancel_in_the_end;
        frame.progress_user = &p;
        assert_int_equal(iso_render(pyramid, scene, &frame, &image, &err), ISO_E_CANCELED);
        assert_true(p.late == 0 && !image.rgba && strstr(err.text, "canceled"));

        iso_export_options export = iso_export_defaults();
        p = (patience){.left = after % 2};
        export.progress = cancel_in_the_end;
        export.progress_user = &p;
        assert_int_equal(iso_export(pyramid, NULL, "vdb", path, &export, &err), ISO_E_CANCELED);
        p = (patience){.left = after % 2};
        assert_int_equal(iso_export(pyramid, scene, "povray", path, &export, &err), ISO_E_CANCELED);
        assert_int_equal(p.late, 0);
    }
    for (int after = 0; after < 3; ++after) {
        patience p = {.left = after};
        iso_plan_options plan = iso_plan_defaults();
        iso_plan_result result;
        plan.error = 1e-5;
        plan.progress = cancel_in_the_end;
        plan.progress_user = &p;
        assert_int_equal(iso_plan(pyramid, scene, &plan, &result, &err), ISO_E_CANCELED);
        assert_true(p.late == 0 && !result.json);
    }
    patience p = {.left = 0};
    const iso_page_options page = {.progress = cancel_in_the_end, .progress_user = &p};
    assert_int_equal(iso_view_page(pyramid, scene, &page, &html, &err), ISO_E_CANCELED);
    assert_null(html);
    assert_int_equal(file_count(), files);
    iso_scene_free(scene);
    iso_pyramid_free(pyramid);
    iso_volume_free(volume);
}

/* The parent has threads, which a child does not inherit: without care it waits for them, until the alarm. */
TEST(a_forked_child_works_on)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    iso_scene *scene = a_scene();
    iso_frame_options o = iso_frame_defaults();
    iso_image image, other;
    iso_metrics m;
    int result;
    o.threads = 4;
    assert_ok(iso_render(pyramid, scene, &o, &image, &err));
    const pid_t child = fork();
    if (child == 0) {
        alarm(60);
        _exit(iso_render(pyramid, scene, &o, &other, NULL) != ISO_OK ||
              iso_metrics_measure(&image, &other, &m, NULL) != ISO_OK || !(m.max_abs <= 0));
    }
    assert_true(child > 0 && waitpid(child, &result, 0) == child);
    assert_true(WIFEXITED(result) && WEXITSTATUS(result) == 0);
    iso_image_destroy(&image);
    iso_scene_free(scene);
    iso_pyramid_free(pyramid);
}

/* Sample (x, y, z) of an array of 3 x 2 x 2 is x + 10 y + 100 z, in each type that arrays have. */
TEST(arrays_of_any_type_and_order_are_taken)
{
    static const int16_t backward[] = {112, 111, 110, 102, 101, 100, 12, 11, 10, 2, 1, 0}; /* last to first */
    static const int64_t spread[] = {0, 100, 10, 110, 1, 101, 11, 111, 2, 102, 12, 112};   /* z fastest, then y */
    static const uint16_t halves[] = {0x0000, 0x3c00, 0x4000, 0x4900, 0x4980, 0x4a00,
                                      0x5640, 0x5650, 0x5660, 0x56e0, 0x56f0, 0x5700}; /* 0, 1, 2, 10 ... 112 */
    const iso_grid grid = iso_grid_axis_aligned((size_t[3]){3, 2, 2}, (double[3]){1, 1, 1});
    const struct {
        const char *type, *stored;
        const void *first;
        ptrdiff_t strides[3];
    } arrays[] = {{"int16", "int16", backward + 11, {-2, -6, -12}},
                  {"int64", "double", spread, {32, 16, 8}},
                  {"uint64", "double", spread, {32, 16, 8}},
                  {"float16", "float", halves, {2, 6, 12}}};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; ++i) {
        iso_volume *volume;
        float values[12];
        assert_ok(iso_volume_from_array(&grid, arrays[i].type, arrays[i].first, arrays[i].strides, &volume, &err));
        assert_string_equal(iso_volume_type(volume), arrays[i].stored);
        iso_volume_values(volume, values);
        for (int v = 0; v < 12; ++v)
            assert_within((double)values[v], v % 3 + 10 * (v / 3 % 2) + 100 * (v / 6), 0);
        iso_volume_free(volume);
    }
    const uint8_t flags[12] = {0, 1, 2, 0};
    iso_volume *volume;
    assert_ok(iso_volume_from_memory(&grid, "bool", flags, &volume, &err));
    const uint8_t *samples = iso_volume_samples(volume);
    assert_true(samples[0] == 0 && samples[1] == 1 && samples[2] == 1 && samples[3] == 0);
    iso_volume_free(volume);
}

TEST(a_raw_file_is_opened_by_its_options)
{
    char path[512];
    iso_volume *volume;
    float values[6];
    snprintf(path, sizeof path, "%s/plain.bin", folder);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite("head\0\1\0\2\0\3\0\4\0\5\0\6", 1, 16, file), 16);
    fclose(file);
    const iso_open_options o = {.raw_size = {3, 2, 1},
                                .raw_type = "uint16",
                                .raw_skip_bytes = 4,
                                .raw_is_big_endian = true,
                                .unit = "cm",
                                .spacing = {1, 2, 3},
                                .labels = -1};
    assert_ok(iso_volume_open_with(path, &o, &volume, &err));
    iso_volume_values(volume, values);
    for (int i = 0; i < 6; ++i)
        assert_within((double)values[i], i + 1, 0);
    const iso_grid grid = iso_volume_grid(volume);
    double spacing_mm[3];
    iso_grid_spacing_mm(&grid, spacing_mm);
    assert_within(spacing_mm[1], 20, 1e-12);
    iso_volume_free(volume);
}

static void keep_text(void *user, const char *text)
{
    snprintf(user, 512, "%s", text);
}

/* A rectilinear grid whose coordinates are not even: 0, 1 and 3. */
TEST(uneven_coordinates_and_no_data_are_options)
{
    char path[512];
    iso_volume *volume;
    float values[16];
    snprintf(path, sizeof path, "%s/uneven.vtk", folder);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fputs("# vtk DataFile Version 3.0\nt\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 3 2 2\nX_COORDINATES 3 float\n0 1 3\n"
          "Y_COORDINATES 2 float\n0 1\nZ_COORDINATES 2 float\n0 1\nPOINT_DATA 12\nSCALARS s float\nLOOKUP_TABLE default\n"
          "1 2 6 1 2 6 1 2 6 1 2 6\n",
          file);
    fclose(file);
    iso_open_options o = {0};
    assert_int_equal(iso_volume_open_with(path, &o, &volume, NULL), ISO_E_FORMAT);
    o.resample = true;
    char warning[512] = "";
    iso_warnings_to(keep_text, warning);
    assert_ok(iso_volume_open_with(path, &o, &volume, &err));
    iso_warnings_to(NULL, NULL);
    assert_non_null(strstr(warning, "4 x 2 x 2 samples are interpolated of 3 x 2 x 2"));
    assert_int_equal(iso_volume_grid(volume).size[0], 4);
    iso_volume_values(volume, values);
    assert_within((double)values[2], 4, 0);
    iso_volume_free(volume);
    o.force_spacing = true;
    assert_int_equal(iso_volume_open_with(path, &o, &volume, NULL), ISO_E_USAGE);
    o.resample = false;
    o.no_data = "5,7";
    assert_ok(iso_volume_open_with(path, &o, &volume, &err));
    assert_int_equal(iso_volume_grid(volume).size[0], 3);
    iso_volume_values(volume, values);
    assert_within((double)values[2], -0x1p100, 0);
    iso_volume_free(volume);
}

TEST(a_scene_is_made_changed_and_written)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    iso_scene *scene, *again;
    iso_tf *tf, *other;
    iso_tf_point points[64];
    char *text, *text2;
    const iso_look_options look = {.tf = "simulation", .view = "left", .width = 20, .height = 30};
    assert_ok(iso_scene_automatic(pyramid, &look, &scene, &err));
    assert_ok(iso_scene_set(scene, "{\"background\": [0, 1, 0.5]}", &err));
    assert_ok(iso_tf_suggest(pyramid, NULL, &tf, &err));
    assert_ok(iso_scene_set_tf(scene, tf, &err));
    const size_t count = iso_tf_points(iso_scene_tf(scene), points, 64);
    assert_true(count >= 2 && count <= 8 && iso_tf_points(tf, points, 0) == count);
    assert_true(points[0].value < points[count - 1].value);
    assert_ok(iso_scene_text(scene, &text, &err));
    assert_non_null(strstr(text, "\"width\": 20"));
    assert_ok(iso_scene_from_text(text, &again, &err));
    assert_ok(iso_scene_text(again, &text2, &err));
    assert_string_equal(text, text2);
    iso_free(text2);
    iso_scene_free(again);
    char path[512];
    snprintf(path, sizeof path, "%s/made.scene.json", folder);
    assert_ok(iso_scene_save(scene, path, &err));
    assert_ok(iso_scene_open(path, &again, &err));
    assert_ok(iso_scene_text(again, &text2, &err));
    assert_string_equal(text, text2);
    iso_free(text2);
    assert_ok(iso_tf_text(tf, &text2, &err));
    assert_ok(iso_tf_from_text(text2, &other, &err));
    assert_int_equal(iso_tf_points(other, points, 64), count);
    assert_int_equal(iso_scene_set(scene, "{\"lamp\": 1}", NULL), ISO_E_FORMAT);
    iso_free(text2);
    assert_ok(iso_scene_text(scene, &text2, &err)); /* unchanged by the failure */
    assert_string_equal(text, text2);
    iso_free(text);
    iso_free(text2);
    iso_tf_free(tf);
    iso_tf_free(other);
    iso_scene_free(scene);
    iso_scene_free(again);
    iso_pyramid_free(pyramid);
}

static void assert_holds(const char *path, const unsigned char *bytes, size_t size)
{
    unsigned char read[65536];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fread(read, 1, sizeof read, file), size);
    assert_memory_equal(read, bytes, size);
    fclose(file);
}

TEST(images_in_memory_are_those_of_files)
{
    iso_image image;
    unsigned char *bytes;
    size_t size;
    char path[512];
    assert_ok(iso_image_create(&image, 7, 5, &err));
    for (size_t i = 0; i < 4 * 7 * 5; ++i)
        image.rgba[i] = (float)i / 140;
    snprintf(path, sizeof path, "%s/m.png", folder);
    assert_ok(iso_image_save_png(&image, path, 1.5, &err));
    assert_ok(iso_image_png(&image, 1.5, &bytes, &size, &err));
    assert_holds(path, bytes, size);
    iso_free(bytes);
    iso_image loaded;
    assert_ok(iso_image_load_png(path, &loaded, &err));
    assert_true(loaded.width == 7 && loaded.height == 5);
    for (size_t i = 0; i < 4 * 7 * 5; ++i) /* half a step of 8 bits where sRGB's curve has its largest slope, 2.28 */
        assert_within(loaded.rgba[i], i % 4 == 3 ? 1 : fmin(1.5 * (double)image.rgba[i], 1), 2.28 / 510);
    iso_image_destroy(&loaded);
    snprintf(path, sizeof path, "%s/m.exr", folder);
    assert_ok(iso_image_save_exr(&image, path, NULL, &err));
    assert_ok(iso_image_exr(&image, &bytes, &size, &err));
    assert_holds(path, bytes, size);
    iso_free(bytes);
    iso_image_destroy(&image);
    assert_int_equal(iso_image_png(&image, 1, &bytes, &size, NULL), ISO_E_RANGE);
    assert_int_equal(iso_image_save_png(&image, path, NAN, NULL), ISO_E_RANGE);
    assert_null(bytes);
}

TEST(a_page_is_one_text)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    char *html;
    assert_ok(iso_view_page(pyramid, NULL, &(iso_page_options){.title = "a ramp"}, &html, &err));
    assert_true(strncmp(html, "<!DOCTYPE html>", 15) == 0 || strncmp(html, "<!doctype html>", 15) == 0);
    assert_non_null(strstr(html, "a ramp"));
    iso_free(html);
    iso_pyramid_free(pyramid);
}

/* ---- errors -------------------------------------------------------------------- */

/* clang-format off */
#define assert_fails(call, wanted, words)                                       \
    do {                                                                        \
        iso_error err = {""};                                                   \
        const iso_status status_ = (call);                                      \
        if (status_ != (wanted) || !strstr(err.text, words))                    \
            fail_msg("%s: status %d, wanted %d: %s", #call, (int)status_, (int)(wanted), err.text); \
    } while (0)
/* clang-format on */

TEST(missing_files_are_named)
{
    iso_volume *volume = (iso_volume *)state;
    iso_pyramid *pyramid = (iso_pyramid *)state;
    iso_tf *tf = (iso_tf *)state;
    iso_scene *scene = (iso_scene *)state;
    iso_image image = {.width = 1};
    assert_fails(iso_volume_open("/no/such.nrrd", &volume, &err), ISO_E_IO, "/no/such.nrrd");
    assert_fails(iso_pyramid_open("/no/such.iso", &pyramid, &err), ISO_E_IO, "/no/such.iso");
    assert_fails(iso_tf_open("/no/such.tf.json", &tf, &err), ISO_E_IO, "/no/such.tf.json");
    assert_fails(iso_scene_open("/no/such.scene.json", &scene, &err), ISO_E_IO, "/no/such.scene.json");
    assert_fails(iso_image_load_exr("/no/such.exr", &image, &err), ISO_E_IO, "/no/such.exr");
    assert_null(volume);
    assert_null(pyramid);
    assert_null(tf);
    assert_null(scene);
    assert_null(image.rgba);
    assert_int_equal(iso_volume_open("/no/such.nrrd", &volume, NULL), ISO_E_IO); /* without a message */
}

TEST(bad_volumes_are_refused)
{
    iso_volume *volume;
    const float samples[2] = {1, INFINITY}, absent[2] = {NAN, NAN};
    iso_grid grid = iso_grid_axis_aligned((size_t[3]){2, 1, 1}, (double[3]){1, 1, 1});
    assert_fails(iso_volume_from_memory(&grid, "float", samples, &volume, &err), ISO_E_RANGE, "(1, 0, 0)");
    assert_null(volume);
    assert_fails(iso_volume_from_memory(&grid, "float", absent, &volume, &err), ISO_E_RANGE, "none of its 2 voxels");
    assert_fails(iso_volume_from_memory(&grid, "float8", samples, &volume, &err), ISO_E_USAGE, "float8");
    grid.size[1] = 0;
    assert_fails(iso_volume_from_memory(&grid, "uint8", samples, &volume, &err), ISO_E_RANGE, "0");
    grid.size[0] = grid.size[1] = grid.size[2] = (size_t)1 << 31; /* a product of 2^93 */
    assert_fails(iso_volume_from_memory(&grid, "uint8", samples, &volume, &err), ISO_E_RANGE, "2147483648");
    grid = iso_grid_axis_aligned((size_t[3]){2, 1, 1}, (double[3]){1, 0, 1});
    assert_fails(iso_volume_from_memory(&grid, "uint8", samples, &volume, &err), ISO_E_RANGE, "");
    assert_null(volume);
}

TEST(bad_options_are_refused)
{
    iso_volume *volume = ramp();
    iso_pyramid *pyramid;
    iso_build_options build = iso_build_defaults();
    build.levels = 33;
    assert_fails(iso_build(volume, &build, &pyramid, &err), ISO_E_RANGE, "33");
    build = iso_build_defaults();
    build.estimator = "best";
    assert_fails(iso_build(volume, &build, &pyramid, &err), ISO_E_USAGE, "best");
    assert_null(pyramid);

    iso_scene *scene = a_scene();
    iso_image image;
    pyramid = ramp_pyramid(false);
    iso_frame_options frame = iso_frame_defaults();
    frame.level = 3;
    assert_fails(iso_render(pyramid, scene, &frame, &image, &err), ISO_E_RANGE, "levels 0 to 2");
    frame = iso_frame_defaults();
    frame.renderer = "mental-ray";
    assert_fails(iso_render(pyramid, scene, &frame, &image, &err), ISO_E_USAGE, "mental-ray");
    frame = iso_frame_defaults();
    frame.samples = 4; /* the reference has no noise */
    assert_fails(iso_render(pyramid, scene, &frame, &image, &err), ISO_E_USAGE, "samples");
    frame = iso_frame_defaults();
    frame.step_voxels = NAN;
    assert_fails(iso_render(pyramid, scene, &frame, &image, &err), ISO_E_RANGE, "step_voxels");
    frame = iso_frame_defaults();
    frame.width = 20000;
    assert_fails(iso_render(pyramid, scene, &frame, &image, &err), ISO_E_RANGE, "20000");
    frame = iso_frame_defaults();
    frame.shading = "float"; /* the pyramid kept none */
    assert_fails(iso_render(pyramid, scene, &frame, &image, &err), ISO_E_RANGE, "");
    assert_null(image.rgba);

    char path[512];
    snprintf(path, sizeof path, "%s/none", folder);
    iso_export_options export = iso_export_defaults();
    assert_fails(iso_export(pyramid, scene, "obj", path, &export, &err), ISO_E_USAGE, "obj");
    assert_fails(iso_export(pyramid, NULL, "povray", path, &export, &err), ISO_E_USAGE, "scene");
    export.half_float = true;
    assert_fails(iso_export(pyramid, scene, "povray", path, &export, &err), ISO_E_USAGE, "half");
    export = iso_export_defaults();
    export.width = 8;
    assert_fails(iso_export(pyramid, scene, "vdb", path, &export, &err), ISO_E_USAGE, "has no scene");
    export = iso_export_defaults();
    export.level = 1;
    export.level_count = 3;
    assert_fails(iso_export(pyramid, NULL, "vdb", path, &export, &err), ISO_E_RANGE, "levels 0 to 2");
    FILE *file = fopen(path, "rb");
    assert_null(file);
    iso_scene_free(scene);
    iso_pyramid_free(pyramid);
    iso_volume_free(volume);
}

/* A region that is the whole volume shows level 0; an extinction scale brings a coarse level nearer to level 0. */
TEST(a_region_and_an_extinction_scale_are_rendered)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    iso_scene *scene = a_scene();
    OWNED(iso_image) fine, coarse, inside, scaled;
    iso_metrics far, near;
    const iso_region whole = {.hi = {NX, NY, NZ}};
    iso_region wrong = iso_region_of(whole.lo, whole.hi);
    iso_frame_options o = iso_frame_defaults();
    o.width = o.height = 24;
    assert_ok(iso_render(pyramid, scene, &o, &fine, &err));
    o.level = 2;
    assert_ok(iso_render(pyramid, scene, &o, &coarse, &err));
    o.region = &whole;
    assert_ok(iso_render(pyramid, scene, &o, &inside, &err));
    assert_ok(iso_metrics_measure(&fine, &coarse, &far, &err));
    assert_ok(iso_metrics_measure(&fine, &inside, &near, &err));
    assert_more_than(far.max_abs, 1e-2);
    assert_within(near.max_abs, 0, 1e-5); /* levels place the same samples by other roundings of an index */
    o.region = NULL;
    o.extinction_scale = true;
    assert_ok(iso_render(pyramid, scene, &o, &scaled, &err));
    assert_ok(iso_metrics_measure(&coarse, &scaled, &far, &err));
    assert_more_than(far.max_abs, 1e-4);
    wrong.level = 2;
    o.region = &wrong;
    iso_image none;
    assert_fails(iso_render(pyramid, scene, &o, &none, &err), ISO_E_RANGE, "must be finer than level 2");
    wrong.level = 0;
    wrong.band = 65;
    assert_fails(iso_render(pyramid, scene, &o, &none, &err), ISO_E_RANGE, "band is 65");
    iso_scene_free(scene);
    iso_pyramid_free(pyramid);
}

/* Length of a file; fails the test if there is none. */
static long file_length(const char *path)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    const long length = ftell(file);
    fclose(file);
    return length;
}

TEST(a_vdb_in_memory_is_that_of_a_file)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    iso_scene *scene = a_scene();
    unsigned char *bytes, *scaled;
    size_t size, scaled_size;
    char path[512];
    snprintf(path, sizeof path, "%s/memory.vdb", folder);
    iso_export_options o = iso_export_defaults();
    o.level = 1;
    assert_ok(iso_export(pyramid, NULL, "vdb", path, &o, &err));
    assert_ok(iso_export_bytes(pyramid, NULL, "vdb", &o, &bytes, &size, &err));
    assert_int_equal(size, file_length(path));
    assert_memory_equal(bytes, " BDV", 4);
    o.extinction_scale = true; /* one more grid */
    assert_ok(iso_export_bytes(pyramid, scene, "vdb", &o, &scaled, &scaled_size, &err));
    assert_more_than(scaled_size, size);
    iso_free(bytes);
    iso_free(scaled);
    assert_fails(iso_export_bytes(pyramid, NULL, "vdb", &o, &bytes, &size, &err), ISO_E_USAGE, "for a scene");
    assert_null(bytes);
    assert_fails(iso_export_bytes(pyramid, scene, "povray", NULL, &bytes, &size, &err), ISO_E_USAGE, "one file");
    const iso_region whole = {.hi = {NX, NY, NZ}};
    o = iso_export_defaults();
    o.region = &whole;
    assert_fails(iso_export(pyramid, NULL, "vdb", path, &o, &err), ISO_E_USAGE, "no region");
    iso_scene_free(scene);
    iso_pyramid_free(pyramid);
}

TEST(a_plan_keeps_its_limit_and_is_exported)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    iso_scene *scene = a_scene();
    iso_plan_options o = iso_plan_defaults();
    iso_plan_result rough, fine, small;
    unsigned char *bytes;
    size_t size;
    o.brick_voxels = 4;
    o.levels = 3;
    o.views = 2;
    o.error = 0.05;
    assert_ok(iso_plan(pyramid, scene, &o, &rough, &err));
    o.error = 1e-4;
    assert_ok(iso_plan(pyramid, scene, &o, &fine, &err));
    assert_true(rough.measured_rmse <= 0.05 && fine.measured_rmse <= 1e-4);
    assert_true(rough.bytes < fine.bytes && fine.bytes <= fine.full_bytes && rough.blank_rmse > 0.05);
    assert_int_equal(fine.brick_count, 5 * 4 * 3); /* of NX - 1, NY - 1, NZ - 1 cells */
    o.memory_bytes = rough.bytes;
    assert_ok(iso_plan(pyramid, scene, &o, &small, &err));
    assert_true(small.bytes <= rough.bytes && small.drawn_count > 0);

    iso_export_options export = iso_export_defaults();
    export.plan = rough.json;
    assert_ok(iso_export_bytes(pyramid, scene, "vdb", &export, &bytes, &size, &err));
    assert_memory_equal(bytes, " BDV", 4);
    iso_free(bytes);
    assert_fails(iso_export_bytes(pyramid, NULL, "vdb", &export, &bytes, &size, &err), ISO_E_USAGE, "for a scene");
    export.adapt = true;
    assert_fails(iso_export(pyramid, scene, "povray", "none", &export, &err), ISO_E_USAGE, "fixes the levels");
    export = iso_export_defaults();
    export.plan = "{\"schema\": \"isoshade.plan/1\"}";
    assert_fails(iso_export_bytes(pyramid, scene, "vdb", &export, &bytes, &size, &err), ISO_E_FORMAT, "bricks");
    iso_plan_result_destroy(&rough);
    iso_plan_result_destroy(&fine);
    iso_plan_result_destroy(&small);
    assert_null(small.json);
    iso_scene_free(scene);
    iso_pyramid_free(pyramid);
}

TEST(plans_out_of_limits_are_refused)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    iso_scene *scene = a_scene();
    iso_plan_result plan;
    const struct {
        iso_plan_options options;
        const char *words;
    } bad[] = {{{.error = NAN, .levels = 1, .brick_voxels = 4, .views = 1}, "error is nan"},
               {{.error = 0.1, .levels = 8, .brick_voxels = 4, .views = 1}, "levels is 8, must be 1 to 7"},
               {{.error = 0.1, .levels = 1, .brick_voxels = 5, .views = 1}, "5"},
               {{.error = 0.1, .levels = 1, .brick_voxels = 4, .views = 0}, "views is 0"},
               {{.error = 0.1, .levels = 1, .brick_voxels = 4, .views = 1, .width = 20000}, "width is 20000"},
               {{.error = 0.1, .memory_bytes = 1, .levels = 1, .brick_voxels = 4, .views = 1}, "needs"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        assert_fails(iso_plan(pyramid, scene, &bad[i].options, &plan, &err), ISO_E_RANGE, bad[i].words);
        assert_null(plan.json);
    }
    iso_scene_free(scene);
    iso_pyramid_free(pyramid);
}

TEST(levels_that_are_not_there_are_refused)
{
    iso_pyramid *pyramid = ramp_pyramid(false);
    iso_level_view view;
    iso_tf *tf = NULL, *adapted;
    float none[3];
    const iso_tf_point points[] = {{0, {1, 1, 1}, 0}, {1, {1, 1, 1}, 1}};
    assert_ok(iso_tf_from_points(points, 2, 1, &tf, &err));
    assert_fails(iso_pyramid_level(pyramid, 3, &view, &err), ISO_E_RANGE, "level 3: the pyramid has levels 0 to 2");
    assert_null(view.values);
    assert_fails(iso_pyramid_directions(pyramid, (size_t)-1, none, &err), ISO_E_RANGE, "levels 0 to 2");
    assert_fails(iso_tf_adapt(tf, pyramid, 7, &adapted, &err), ISO_E_RANGE, "level 7");
    assert_null(adapted);
    assert_fails(iso_tf_suggest(pyramid, "bones", &adapted, &err), ISO_E_USAGE, "ct-bone");
    assert_null(adapted);
    iso_tf_free(tf);
    iso_pyramid_free(pyramid);
}

TEST(bad_points_are_refused)
{
    iso_tf *tf;
    const iso_tf_point falling[] = {{1, {0, 0, 0}, 0}, {0, {0, 0, 0}, 0}},
                       bright[] = {{0, {0, 0, 0}, 0}, {1, {0, 2, 0}, 0}},
                       flat[] = {{1, {0, 0, 0}, 0}, {1, {0, 0, 0}, 0}},
                       opaque[] = {{0, {0, 0, 0}, 0}, {1, {0, 0, 0}, NAN}};
    assert_fails(iso_tf_from_points(falling, 1, 1, &tf, &err), ISO_E_RANGE, "1 points");
    assert_fails(iso_tf_from_points(falling, 2, 1, &tf, &err), ISO_E_RANGE, "point 1");
    assert_fails(iso_tf_from_points(bright, 2, 1, &tf, &err), ISO_E_RANGE, "point 1");
    assert_fails(iso_tf_from_points(opaque, 2, 1, &tf, &err), ISO_E_RANGE, "opacity");
    assert_fails(iso_tf_from_points(flat, 2, 1, &tf, &err), ISO_E_RANGE, "range");
    assert_fails(iso_tf_from_points(flat, 2, 0, &tf, &err), ISO_E_RANGE, "mm");
    assert_null(tf);
}

/* Each component is rounded to a float. */
#define LONGEST (1 + 2e-7)

static double length_of(const float *d)
{
    return sqrt((double)d[0] * (double)d[0] + (double)d[1] * (double)d[1] + (double)d[2] * (double)d[2]);
}

/* Of three bytes all 2^24, of six (half floats) each number in each place. No direction is longer than it may be, and
 * each is one that can be encoded again; what is no lattice vector's own code may come back as another that is as
 * near. */
TEST(each_code_decodes_to_a_direction)
{
    static const char *const codes[] = {"snorm",    "fit",     "shell", "free", "cube",
                                        "region48", "oct24", "half"};
    enum { BATCH = 1 << 16, APART = 251 };
    FREED uint8_t *bytes = malloc(6 * BATCH), *again = malloc(6 * BATCH);
    FREED float *d = malloc(3 * BATCH * sizeof *d), *back = malloc(3 * BATCH * sizeof *back);
    assert_true(bytes && again && d && back);
    for (size_t c = 0; c < sizeof codes / sizeof *codes; ++c) {
        const size_t width = iso_directions_bytes(codes[c]), batches = width == 3 ? 256 : 3;
        double longest = 0, farthest = 0;
        for (size_t batch = 0; batch < batches; batch += ISO_SANITIZED && width == 3 ? 15 : 1) {
            memset(bytes, 0, 6 * BATCH);
            for (size_t i = 0; i < BATCH; ++i) {
                const uint16_t low = (uint16_t)i;
                memcpy(bytes + width * i + (width == 3 ? 0 : 2 * batch), &low, 2);
                if (width == 3)
                    bytes[3 * i + 2] = (uint8_t)batch;
            }
            assert_ok(iso_directions_decode(codes[c], bytes, BATCH, d, &err));
            for (size_t i = 0; i < BATCH; ++i)
                longest = fmax(longest, length_of(d + 3 * i) >= 0 ? length_of(d + 3 * i) : 9); /* 9: no number */
            size_t some = 0;
            for (size_t i = batch % APART; i < BATCH; i += APART, ++some)
                memcpy(d + 3 * some, d + 3 * i, 3 * sizeof *d);
            assert_ok(iso_directions_encode(codes[c], d, some, again, &err));
            assert_ok(iso_directions_decode(codes[c], again, some, back, &err));
            for (size_t i = 0; i < 3 * some; ++i) {
                const double length = fmax(length_of(d + i / 3 * 3), 1e-9),
                             other = fmax(length_of(back + i / 3 * 3), 1e-9);
                if (length > 1.0 / 3)
                    farthest = fmax(farthest, fabs((double)d[i] / length - (double)back[i] / other));
            }
        }
        assert_true(longest <= LONGEST);
        assert_true(farthest < 0.025); /* 1.5 steps of the lattice at the length of 1/3; 1/127 / (1/3) = .024 */
    }
    /* Planted: a vector of the lattice as it is. */
    const uint8_t corner[3] = {127, 127, 127};
    assert_ok(iso_directions_decode("snorm", corner, 1, d, &err));
    assert_true(length_of(d) <= LONGEST && !(sqrt(3) <= LONGEST));
}

TEST(bad_directions_are_refused)
{
    const float d[6] = {1, 0, 0, 1, 1, 0}, nan[3] = {NAN, 0, 0};
    uint8_t bytes[6];
    float back[6];
    assert_fails(iso_directions_encode("snorm", d, 2, bytes, &err), ISO_E_RANGE, "direction 1");
    assert_fails(iso_directions_encode("snorm", nan, 1, bytes, &err), ISO_E_RANGE, "direction 0");
    assert_fails(iso_directions_encode("none", d, 1, bytes, &err), ISO_E_USAGE, "none");
    assert_fails(iso_directions_decode("none", bytes, 1, back, &err), ISO_E_USAGE, "none");
}

TEST(bad_scenes_are_refused)
{
    iso_scene *scene;
    assert_fails(iso_scene_from_text("{", &scene, &err), ISO_E_FORMAT, "not JSON");
    assert_fails(iso_scene_from_text("[]", &scene, &err), ISO_E_FORMAT, "object");
    assert_fails(iso_scene_from_text("{\"schema\": \"isoshade.scene/1\", \"lamp\": 1}", &scene, &err), ISO_E_FORMAT,
                 "lamp");
    assert_null(scene);
}

TEST(images_of_other_sizes_are_not_compared)
{
    OWNED(iso_image) a, b;
    iso_metrics m;
    assert_ok(iso_image_create(&a, 4, 4, &err));
    assert_ok(iso_image_create(&b, 4, 5, &err));
    assert_fails(iso_metrics_measure(&a, &b, &m, &err), ISO_E_RANGE, "");
}

TEST_MAIN(make_folder, remove_folder)
