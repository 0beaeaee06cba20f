/* SPDX-License-Identifier: MIT */
/* The verdict on levels: what is asked of them, what they are compared with, and that a wrong level fails. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "render/image_bound.h"
#include "tests/validated.h"
#include "validate/measured.h"
#include "volume/synthetic.h"

enum { pixels = 48, levels = 3 };
static const subject_size size = {pixels, levels, ISO_DIAGONAL_VIEWS};

/* ---- a volume, its levels, and what is measured of them ---- */

static iso_scene make_scene(void)
{
    static iso_tf_point points[] = {{0, {0.9, 0.7, 0.4}, 0},
                                    {0.3, {0.9, 0.7, 0.4}, 0},
                                    {0.45, {1, 0.9, 0.6}, 0.6},
                                    {1, {0.9, 0.8, 0.7}, 0.6}};
    return scene_of_points(points, 4, pixels, 0.2);
}

static iso_field field_of(iso_field_kind kind, const iso_geometry *geometry)
{
    return (iso_field){.kind = kind, .seed = 3, .geometry = *geometry};
}

static iso_geometry plain_geometry(void)
{
    return iso_geometry_axis_aligned((size_t[]){26, 24, 21}, (double[]){1, 1.2, 0.9});
}

static void open_subject(subject *s, iso_field_kind kind, const char *name)
{
    const iso_geometry geometry = plain_geometry();
    const iso_field field = field_of(kind, &geometry);
    open_field(s, &field, make_scene(), name, size);
}

static iso_levels_summary judge(subject *s)
{
    measure_levels(s);
    return iso_levels_summarize(iso_report_json(s->validation.report));
}

static const json_t *row_of(const subject *s, size_t level)
{
    return json_array_get(json_object_get(iso_report_json(s->validation.report), "levels"), level - 1);
}

static bool holds(const subject *s, size_t level)
{
    return iso_row_verdict(row_of(s, level)) == ISO_VERDICT_AGREE;
}

static double stored(const subject *s, size_t level, const char *key)
{
    return json_number_value(json_object_get(json_object_get(row_of(s, level), "stored"), key));
}

/* ---- clean volumes ---- */

/* About an axis, by Rodrigues' formula. */
static iso_vec3 turn(iso_vec3 v, iso_vec3 axis, double angle)
{
    const iso_vec3 a = iso_normalize(axis);
    const iso_vec3 across = iso_scale(iso_cross(a, v), sin(angle));
    return iso_add(iso_madd(iso_scale(v, cos(angle)), a, iso_dot(a, v) * (1 - cos(angle))), across);
}

static iso_mat3 turned(iso_mat3 m, iso_vec3 axis, double angle)
{
    for (int c = 0; c < 3; ++c) {
        const iso_vec3 column = turn(iso_column(m, c), axis, angle);
        m.m[0][c] = column.x;
        m.m[1][c] = column.y;
        m.m[2][c] = column.z;
    }
    return m;
}

static void noise_on(iso_volume *v, double deviation)
{
    iso_random random = {5};
    float *data = v->data;
    for (size_t i = 0; i < iso_geometry_voxel_count(&v->geometry); ++i) {
        double normal = -6;
        for (int k = 0; k < 12; ++k)
            normal += iso_random_unit(&random);
        data[i] += (float)(deviation * normal);
    }
}

/* Signed values, an oblique grid, anisotropic voxels, and noise of a fiftieth of the range. */
VALUES_TEST(clean_volumes_hold)
{
    static const struct clean {
        iso_field_kind kind;
        bool oblique, is_signed;
        double spacing[3], noise;
    } cleans[] = {
        {ISO_FIELD_TUBES, false, true, {1, 1, 1}, 0},
        {ISO_FIELD_SHELLS, true, false, {1, 1, 1}, 0},
        {ISO_FIELD_BALLS, false, false, {0.7, 1, 2.5}, 0},
        {ISO_FIELD_TUBES, true, true, {1.3, 0.8, 1}, 0.02},
    };
    for (size_t i = 0; i < sizeof cleans / sizeof *cleans; ++i) {
        const struct clean *c = &cleans[i];
        ENDED_BY(close_subject) subject s;
        OWNED(iso_volume) volume;
        char name[32];
        iso_geometry g = iso_geometry_axis_aligned((size_t[]){26, 24, 21}, c->spacing);
        if (c->oblique)
            g.index_to_world = turned(g.index_to_world, iso_v3(1, 2, 3), 0.5);
        const iso_field field = field_of(c->kind, &g);
        assert_ok(iso_field_sample(&field, ISO_F32, &volume, &err));
        noise_on(&volume, c->noise);
        for (size_t k = 0; c->is_signed && k < iso_geometry_voxel_count(&volume.geometry); ++k)
            ((float *)volume.data)[k] = 200 * ((float *)volume.data)[k] - 100;
        snprintf(name, sizeof name, "clean-%zu", i);
        open_volume(&s, &volume, make_scene(), name, size);
        const iso_levels_summary summary = judge(&s);
        if (summary.differed > 0)
            fail_msg("%s: %s", name, summary.sentence);
        assert_int_equal(summary.agreed, levels - 1);
        for (size_t level = 1; level < levels; ++level) {
            assert_within(stored(&s, level, "scalar"), 0, 0); /* the same sums in the same order */
            assert_within(stored(&s, level, "direction_deg"), 0, 0);
        }
    }
}

/* ---- planted faults ---- */

/* All directions of a level by 30 degrees about an axis. */
static void turn_directions(iso_pyramid *p, size_t level)
{
    iso_level *l = &p->levels[level];
    const size_t count = iso_geometry_voxel_count(&l->geometry);
    FREED float *directions = calloc(3 * count, sizeof *directions);
    for (size_t i = 0; i < count; ++i) {
        double e[3], d[3];
        iso_code_lattice(p->options.code, l->codes + 3 * i, e);
        iso_code_decode(p->options.code, e, d);
        const iso_vec3 now = turn(iso_v3(d[0], d[1], d[2]), iso_v3(1, 1, 0), 30 * 3.14159265358979323846 / 180);
        const double length = fmax(iso_norm(now), 1); /* a decoded one may be longer by its rounding */
        directions[3 * i] = (float)(now.x / length);
        directions[3 * i + 1] = (float)(now.y / length);
        directions[3 * i + 2] = (float)(now.z / length);
    }
    iso_code_encode(p->options.code, directions, l->codes, count);
}

/* Half a voxel along x: the mean of two neighbors. */
static void shift_scalar(iso_pyramid *p, size_t level)
{
    iso_level *l = &p->levels[level];
    const size_t *n = l->geometry.size;
    for (size_t i = 0; i + 1 < iso_geometry_voxel_count(&l->geometry); ++i)
        if (i % n[0] + 1 < n[0])
            l->scalar[i] = 0.5f * (l->scalar[i] + l->scalar[i + 1]);
}

/* Each is seen in what is stored, and in the pictures of directions or values that are off by so much, too. */
TEST(a_level_with_turned_directions_fails)
{
    ENDED_BY(close_subject) subject s;
    open_subject(&s, ISO_FIELD_TUBES, "turned");
    turn_directions(&s.pyramid, 1);
    const iso_levels_summary summary = judge(&s);
    assert_int_equal(summary.differed, 1);
    assert_false(holds(&s, 1));
    assert_true(holds(&s, 2));
    assert_within(stored(&s, 1, "scalar"), 0, 0);
    /* by 30 degrees at right angles to the axis, by less near it */
    assert_more_than(stored(&s, 1, "direction_deg"), 15);
    assert_at_most(stored(&s, 1, "direction_deg"), 31);
    assert_non_null(strstr(summary.sentence, "Level 1 differs from one made of level 0"));
}

VALUES_TEST(a_level_with_a_shifted_scalar_fails)
{
    ENDED_BY(close_subject) subject s;
    open_subject(&s, ISO_FIELD_TUBES, "shifted");
    shift_scalar(&s.pyramid, 2);
    const iso_levels_summary summary = judge(&s);
    assert_int_equal(summary.differed, 1);
    assert_true(holds(&s, 1));
    assert_false(holds(&s, 2));
    assert_more_than(stored(&s, 2, "scalar"), 0.05);
    assert_within(stored(&s, 2, "direction_deg"), 0, 0);
}

/* No picture shows one value that is off by a ten-thousandth of the range: what is stored does. */
VALUES_TEST(one_value_that_is_slightly_off_fails)
{
    ENDED_BY(close_subject) subject s;
    open_subject(&s, ISO_FIELD_TUBES, "slightly");
    iso_level *l = &s.pyramid.levels[1];
    const size_t middle = iso_geometry_voxel_count(&l->geometry) / 2;
    l->scalar[middle] += (float)(1e-4 * (l->max - l->min));
    const iso_levels_summary summary = judge(&s);
    assert_int_equal(summary.differed, 1);
    assert_false(holds(&s, 1));
    assert_within(stored(&s, 1, "scalar"), 1e-4, 1e-6); /* floats */
}

/* A thin plate whose first level got the tensor filter, which shades it worse than moments: pictures say that the
 * choice is wrong, and with which option it is right. Nothing fails, as the level is still nearer than gradients on the
 * fly. */
VALUES_TEST(a_wrong_choice_of_auto_is_named)
{
    ENDED_BY(close_subject) subject s;
    const iso_geometry geometry = iso_geometry_axis_aligned((size_t[]){40, 40, 40}, (double[]){1, 1, 1});
    const iso_field field = field_of(ISO_FIELD_PLATE, &geometry);
    iso_pyramid_options build = iso_pyramid_defaults();
    open_field(&s, &field, make_scene(), "auto", size);
    iso_pyramid_destroy(&s.pyramid);
    build.direction_filter = ISO_DIRECTION_TENSOR;
    build.level_count = levels;
    s.pyramid = sampled_pyramid(&field, ISO_F32, &build);
    s.pyramid.options.direction_filter = ISO_DIRECTION_AUTO;
    s.pyramid.options.choice = (iso_direction_choice){.is_made = true};
    for (size_t k = 1; k < levels; ++k)
        s.pyramid.options.choice.filter[k] = ISO_DIRECTION_TENSOR;
    s.validation.is_as_made = true; /* by pictures alone */
    const iso_levels_summary summary = judge(&s);
    print_message("%s\n", summary.sentence);
    assert_non_null(strstr(summary.sentence, "Level 1: auto chose tensor, but "));
    assert_non_null(strstr(summary.sentence, "build --direction-filter "));
    assert_string_equal(json_string_value(json_object_get(row_of(&s, 1), "chosen_filter")), "tensor");
}

static iso_report_level row_with(const double own[], const double fly[], size_t views, double asked);

/* The mean over the first views of the levels, each by itself. */
static double bound_of(const subject *s, size_t level, size_t views)
{
    double sum = 0;
    for (size_t i = 0; i < views; ++i) {
        OWNED(iso_view) view = {0};
        double rmse;
        assert_ok(iso_validate_level_view(&s->validation, i, &view, &err));
        const iso_image_bound_input in = {.fine = &s->pyramid.levels[0],
                                          .coarse = &s->pyramid.levels[level],
                                          .level = level,
                                          .code = s->pyramid.options.code,
                                          .source = ISO_FROM_CODES,
                                          .view = &view,
                                          .coarse_tf = strcmp(iso_row_text(row_of(s, level), "tf"), "adapted") == 0
                                                           ? &s->validation.level_tfs[level].table
                                                           : &view.tf,
                                          .threads = 1};
        assert_ok(iso_image_bound_rmse(&in, &rmse, &err));
        sum += rmse / (double)views;
    }
    return sum;
}

/* The bound is of the level that is drawn and knows nothing of the pictures: what is measured is below it, and a figure
 * above it, planted, fails by itself. */
TEST(what_is_measured_is_held_to_its_bound)
{
    ENDED_BY(close_subject) subject s;
    const iso_geometry geometry = plain_geometry();
    const iso_field field = field_of(ISO_FIELD_TUBES, &geometry);
    /* fewer views than there are diagonals: another one is none of them */
    open_field(&s, &field, make_scene(), "bound", (subject_size){pixels, levels, ISO_DIAGONAL_VIEWS / 2});
    judge(&s);
    for (size_t level = 1; level < levels; ++level) {
        const json_t *bound = json_object_get(row_of(&s, level), "bound");
        assert_true(json_is_true(json_object_get(bound, "held")));
        assert_more_than(json_number_value(json_object_get(bound, "rmse")), 1e-3);
        assert_more_than(json_number_value(json_object_get(bound, "bound")),
                         json_number_value(json_object_get(bound, "rmse")));
    }
    const json_t *bound = json_object_get(row_of(&s, 1), "bound");
    assert_within(json_number_value(json_object_get(bound, "bound")),
                  bound_of(&s, 1, (size_t)json_integer_value(json_object_get(bound, "views"))), 1e-9);
    const double own[] = {0.07, 0.08, 0.06, 0.07, 0.09, 0.05};
    iso_report_level row = row_with(own, own, 6, NAN);
    row.bound = (iso_report_bound){.views = 6, .rmse = 0.07, .bound = 0.2, .above = -0.1};
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_AGREE);
    row.bound.above = 5e-4; /* less than steps may make */
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_AGREE);
    row.bound.above = 2e-3;
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_DIFFER);
    row.bound.above = NAN;
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_DIFFER);
}

/* The gate by pictures alone: with the original TF, directions that point anywhere look less like level 0 than
 * gradients on the fly. The rebuilt levels are made equal to the stored ones by judging numbers that were measured. */
static iso_report_level row_with(const double own[], const double fly[], size_t views, double asked)
{
    iso_report_level row = {.shown = true,
                            .level = 1,
                            .views = views,
                            .method = "moments",
                            .adapted = true,
                            .confidence = 0.95,
                            .margin = 1e-3,
                            .asked = {asked, NAN, NAN},
                            .simple = {.method = "on-the-fly", .option = "--shading-from on-the-fly"},
                            .scalar_limit = 1e-5,
                            .direction_limit_deg = 0.1};
    for (int k = 0; k < ISO_LEVEL_FIGURE_COUNT; ++k)
        for (size_t i = 0; i < views; ++i) {
            row.value[k] += own[i] / (double)views;
            row.simple.value[k] += fly[i] / (double)views;
            row.simple.deficit[k] = iso_paired_compare(own, fly, views, 0.95);
        }
    return row;
}

TEST(a_level_is_held_to_its_limit_and_to_the_simple_way)
{
    const double own[] = {0.071, 0.081, 0.061, 0.071, 0.091, 0.051},
                 less[] = {0.067, 0.078, 0.056, 0.067, 0.0872, 0.047},
                 scatter[] = {0.051, 0.091, 0.061, 0.081, 0.061, 0.071},
                 near[] = {0.0705, 0.0805, 0.0605, 0.0705, 0.0905, 0.0505};
    iso_report_level row = row_with(own, own, 6, NAN);
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_AGREE);
    row = row_with(own, own, 6, 0.0711); /* their mean is .071 */
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_AGREE);
    row = row_with(own, own, 6, 0.0709);
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_DIFFER);
    /* behind by .004 in every view: the views differ by more, the differences do not */
    row = row_with(own, less, 6, NAN);
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_DIFFER);
    /* the same two views are not enough to tell */
    row = row_with(own, less, 1, NAN);
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_AGREE);
    /* behind by .0017, sometimes far behind and sometimes far ahead: scatter */
    row = row_with(own, scatter, 6, NAN);
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_AGREE);
    /* behind in every view, by less than anybody sees */
    row = row_with(own, near, 6, NAN);
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_AGREE);
    /* what is no number is never held */
    row = row_with(own, own, 6, 0.08);
    row.value[ISO_LEVEL_SSIM] = NAN;
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_DIFFER);
    row = row_with(own, own, 6, NAN);
    row.direction_off_deg = NAN;
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_DIFFER);
    row = row_with(own, own, 6, NAN);
    row.scalar_off = 2e-5;
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_DIFFER);
    /* where nothing is shown nothing agrees; what is stored is looked at all the same */
    row.shown = false;
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_DIFFER);
    row.scalar_off = 0;
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_NOT_COMPARED);
}

/* The sentence names the figure that fails a level. Figures that contradict each other fail none: SSIM takes structures
 * that do not match for worse than none, so that a level that shows less may be nearer by it. */
TEST(figures_that_contradict_each_other_decide_nothing)
{
    const iso_report_about about = {.title = "mixed"};
    const double own[] = {0.071, 0.081, 0.061, 0.071, 0.091, 0.051},
                 less[] = {0.067, 0.078, 0.056, 0.067, 0.0872, 0.047};
    FREED char *dir = iso_path_join(folder, "mixed");
    iso_report *report;
    iso_report_level row = row_with(own, less, 6, NAN);
    assert_ok(iso_report_create(&report, dir, &about, &err));
    assert_ok(iso_report_add_level(report, &row, &err));
    iso_levels_summary s = iso_levels_summarize(iso_report_json(report));
    assert_int_equal(s.differed, 1);
    assert_non_null(strstr(s.sentence, "1-SSIM 0.067 against 0.071, 0.004 +- "));
    row.simple.deficit[ISO_LEVEL_RMSE] = (iso_paired){-0.02, 0.01};
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_AGREE);
    row.simple.deficit[ISO_LEVEL_RMSE] = (iso_paired){-0.02, 0.03}; /* within its interval it contradicts nothing */
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_DIFFER);
    iso_report_destroy(report);
}

/* Student's t at 95 %, as every table has it; the interval of differences 1, 2, 3 is 2 +- 4.303 / sqrt(3). */
TEST(intervals_are_students)
{
    const double a[] = {2, 4, 6}, b[] = {1, 2, 3};
    const iso_paired p = iso_paired_compare(a, b, 3, 0.95);
    assert_within(iso_student_quantile(0.95, 2), 4.30265, 1e-5); /* the tables' digits */
    assert_within(iso_student_quantile(0.95, 5), 2.57058, 1e-5);
    assert_within(iso_student_quantile(0.99, 19), 2.86093, 1e-5);
    assert_within(p.difference, 2, 1e-15);
    assert_within(p.half_width, 4.30265 / sqrt(3), 1e-5);
    assert_true(isinf(iso_paired_compare(a, b, 1, 0.95).half_width));
    assert_false(iso_paired_is_larger(p, 0));
    assert_true(iso_paired_is_larger((iso_paired){NAN, 1}, 0));
}

/* Two voxels of a block say what one says: groups of equal differences have the interval of one value each. */
TEST(differences_that_scatter_together_count_once)
{
    const double twice[] = {1, 1, 2, 2, 3, 3};
    const size_t group[] = {4, 4, 0, 0, 2, 2}, alone[] = {1, 1, 1, 1, 1, 1};
    iso_paired p;
    assert_ok(iso_paired_of_groups(twice, group, 6, 5, 0.95, &p, &err));
    assert_within(p.difference, 2, 1e-15);
    assert_within(p.half_width, 4.30265 / sqrt(3), 1e-5);
    assert_ok(iso_paired_of_groups(twice, alone, 6, 5, 0.95, &p, &err));
    assert_true(p.difference == 2 && isinf(p.half_width));
    assert_ok(iso_paired_of_groups(twice, alone, 0, 5, 0.95, &p, &err));
    assert_true(isnan(p.difference));
}

/* However far the directions are from level 0's: pictures decide. */
TEST(angles_fail_no_level)
{
    const double own[] = {0.07, 0.08, 0.06, 0.07, 0.09, 0.05}, better[] = {0.05, 0.06, 0.04, 0.05, 0.07, 0.03};
    iso_report_level row = row_with(own, own, 6, NAN);
    row.angle_deficit = (iso_paired){30, 4};
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_AGREE);
    row = row_with(own, better, 6, NAN);
    row.angle_deficit = (iso_paired){-30, 4};
    assert_int_equal(iso_report_level_verdict(&row), ISO_VERDICT_DIFFER);
}

TEST(what_a_scene_asks_is_held_in_the_run)
{
    iso_scene scene = make_scene();
    const iso_geometry geometry = plain_geometry();
    const iso_field field = field_of(ISO_FIELD_TUBES, &geometry);
    ENDED_BY(close_subject) subject s;
    scene.levels.rmse = (iso_scene_level_limits){2, {0.5, 1e-4}};
    open_field(&s, &field, scene, "asked", size);
    const iso_levels_summary summary = judge(&s);
    assert_true(holds(&s, 1));
    assert_false(holds(&s, 2));
    assert_non_null(strstr(summary.sentence, "Level 2: RMSE is"));
    assert_non_null(strstr(summary.sentence, "the limit is 0.0001"));
}

TEST(limits_are_read_by_level)
{
    const char *text =
        "{\"schema\": \"isoshade.scene/1\", \"camera\": {\"projection\": \"orthographic\", \"fit\": true, "
        "\"direction\": [0, 1, 0]}, \"lights\": [{\"direction\": [0, 0, 1], \"space\": \"camera\", \"intensity\": 0}], \"shading\": {\"ambient\": 1, \"diffuse\": 0}, \"tf\": {\"schema\": \"isoshade.tf/1\", \"range\": \"fit\", "
        "\"unit_distance_voxels\": 1, \"color_space\": \"linear\", \"points\": [{\"value\": 0, \"r\": 1, \"g\": 1, \"b\": 1, \"opacity\": 0}, "
        "{\"value\": 1, \"r\": 1, \"g\": 1, \"b\": 1, \"opacity\": 1}]}, \"levels\": %s}";
    const struct {
        const char *levels;
        iso_status status;
    } cases[] = {
        {"{\"ssim_dissimilarity\": 0.1, \"flip\": [0.05, 0.1]}", ISO_OK},
        {"{\"flip\": []}", ISO_E_FORMAT},
        {"{\"flip\": [0.1, \"much\"]}", ISO_E_FORMAT},
        {"{\"psnr\": 3}", ISO_E_FORMAT},
        {"{\"rmse\": -1}", ISO_E_RANGE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char json[1024];
        iso_scene scene;
        snprintf(json, sizeof json, text, cases[i].levels);
        iso_error err = {""};
        json_auto_t *root = json_loads(json, 0, NULL);
        assert_non_null(root);
        const iso_status status = iso_scene_from_json(root, "x.scene.json", &scene, &err);
        if ((status == ISO_OK) != (cases[i].status == ISO_OK))
            fail_msg("%s: status %d, %s", cases[i].levels, (int)status, err.text);
        assert_true(status == ISO_OK || status == ISO_E_FORMAT || status == ISO_E_RANGE);
        if (status == ISO_OK) {
            assert_within(iso_scene_level_limit(&scene.levels.ssim_dissimilarity, 1), 0.1, 0);
            assert_within(iso_scene_level_limit(&scene.levels.ssim_dissimilarity, 9), 0.1, 0);
            assert_within(iso_scene_level_limit(&scene.levels.flip, 1), 0.05, 0);
            assert_within(iso_scene_level_limit(&scene.levels.flip, 2), 0.1, 0);
            assert_within(iso_scene_level_limit(&scene.levels.flip, 3), 0.1, 0);
            assert_true(isnan(iso_scene_level_limit(&scene.levels.rmse, 1)));
            iso_scene_destroy(&scene);
        }
    }
}

/* ---- angles ---- */

/* Directions that turn about y as x grows: `degrees` a voxel, from those of level 0, which all point along x. */
static void turn_along_x(iso_pyramid *p, size_t level, double degrees)
{
    iso_level *l = &p->levels[level];
    const size_t count = iso_geometry_voxel_count(&l->geometry);
    FREED float *directions = calloc(3 * count, sizeof *directions);
    for (size_t i = 0; i < count; ++i) {
        const double angle = degrees * (double)(i % l->geometry.size[0]) * (3.14159265358979323846 / 180);
        directions[3 * i] = (float)cos(angle);
        directions[3 * i + 2] = (float)sin(angle);
    }
    iso_code_encode(p->options.code, directions, l->codes, count);
}

/* A ramp along x, whose directions are along x; level 1's turn by 4 degrees a voxel. Between two voxels the sampled
 * direction turns evenly, to a thousandth of a degree, and before the first and behind the last it does not turn. */
TEST(angles_are_those_of_the_place_and_in_degrees)
{
    enum { n = 20 };
    const double turn = 4;
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){n, 8, 8}, (double[]){1, 1, 1});
    OWNED(iso_volume) volume;
    ENDED_BY(close_subject) subject s;
    assert_ok(iso_volume_create(&volume, &g, ISO_F32, "ramp", &err));
    for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i)
        ((float *)volume.data)[i] = (float)(i % n);
    iso_scene scene = make_scene(); /* shows what is above .3 of the range: x of 6 and more */
    open_volume(&s, &volume, scene, "angles", size);
    turn_along_x(&s.pyramid, 1, turn);
    double sum = 0, most = 0, angles[n];
    size_t count = 0;
    for (size_t x = 6; x < n; ++x) {
        const double at = fmin(fmax(((double)x + 0.5) / 2 - 0.5, 0), n / 2 - 1);
        angles[count++] = turn * at;
        sum += turn * at;
        most = turn * at;
    }
    iso_level_angles measured;
    assert_ok(iso_validate_angles(&s.validation, &s.pyramid, 1, ISO_FROM_CODES, &measured, &err));
    const double code_error = 0.3; /* of the code `fit`, as its page has it, at most */
    assert_within(measured.mean, sum / (double)count, code_error);
    assert_within(measured.p95, angles[(size_t)(0.95 * (double)(count - 1))], code_error + turn / 2);
    assert_at_most(measured.p95, most + code_error);
    /* planted: level 0 against itself has none, and against the other way round 180 degrees */
    assert_ok(iso_validate_angles(&s.validation, &s.pyramid, 0, ISO_FROM_CODES, &measured, &err));
    assert_within(measured.mean, 0, 1e-5);
    iso_level *l = &s.pyramid.levels[1];
    turn_along_x(&s.pyramid, 1, 0);
    assert_ok(iso_validate_angles(&s.validation, &s.pyramid, 1, ISO_FROM_CODES, &measured, &err));
    assert_within(measured.mean, 0, code_error);
    float back[3] = {-1, 0, 0};
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i)
        iso_code_encode(s.pyramid.options.code, back, l->codes + 3 * i, 1);
    assert_ok(iso_validate_angles(&s.validation, &s.pyramid, 1, ISO_FROM_CODES, &measured, &err));
    assert_within(measured.mean, 180, code_error);
}

/* ---- more views where these leave a level open ---- */

/* The interval of two views is 12.7 standard errors to each side: turned directions are behind by the mean, and not
 * beyond that. Twenty views tell. */
VALUES_TEST(a_level_that_few_views_leave_open_is_judged_by_twenty)
{
    subject s;
    for (int may = 0; may < 2; ++may) {
        open_subject(&s, ISO_FIELD_BALLS, may ? "judged" : "open");
        turn_directions(&s.pyramid, 1);
        s.validation.consistency_views = 2;
        s.validation.may_add_views = may;
        const iso_levels_summary summary = judge(&s);
        const json_t *row = row_of(&s, 1);
        assert_int_equal(json_integer_value(json_object_get(row, "views")), may ? ISO_FACE_VIEWS : 2);
        assert_int_equal(json_integer_value(json_object_get(row, "views_before")), 2);
        assert_true(json_is_true(json_object_get(row, "simple_held")) == !may);
        assert_true((strstr(summary.sentence, "Level 1 was undecided after 2 views: 20 were used.") != NULL) == may);
        assert_int_equal(s.validation.consistency_views, 2);
        close_subject(&s);
    }
}

/* The quick run draws twenty views of what few say is behind, and of nothing else. */
TEST(a_quick_run_confirms_what_would_fail)
{
    for (int turned = 0; turned < 2; ++turned) {
        ENDED_BY(close_subject) subject s;
        open_subject(&s, ISO_FIELD_BALLS, turned ? "confirmed" : "quick");
        if (turned)
            turn_directions(&s.pyramid, 1);
        s.validation.quick = s.validation.may_add_views = true;
        judge(&s);
        const json_t *row = row_of(&s, 1);
        assert_int_equal(json_integer_value(json_object_get(row, "views")),
                         turned ? ISO_FACE_VIEWS : ISO_DIAGONAL_VIEWS);
        assert_true(json_is_true(json_object_get(row, "simple_held")) == !turned);
    }
}

TEST_MAIN(make_folder, end_renderers_and_folder)
