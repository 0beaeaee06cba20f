/* SPDX-License-Identifier: MIT */
/* Voxels without data: a ramp beside a half space of NaN. Values, gradients, means of levels, histograms and pictures
 * are those of the other half, up to the last voxel center that has data. */
#define _GNU_SOURCE
#include "difference.h"
#include "rendered.h"
#include "test.h"

#include <unistd.h>

#include "gl.h"

#include "gradient/gradient_kernel.h"
#include "pyramid/pyramid_verify.h"
#include "render/cpu/caster.h"
#include "render/reference.h"
#include "scene/level_view.h"
#include "tf/adapt.h"
#include "tf/suggest.h"
#include "volume/value_histogram.h"

enum { NX = 20, NY = 9, NZ = 7, COUNT = NX * NY * NZ, FIRST = 9 /* x of the first voxel with data */ };
static const double spacing[3] = {1, 1.5, 2};

/* Of small numbers of binary digits: all means and differences are exact. */
static double ramp(size_t x, size_t y, size_t z)
{
    return 3 + 2 * (double)x + 0.5 * (double)y - 0.25 * (double)z;
}

static bool every_second; /* planes have data, instead of a half space */

static bool is_there(size_t x)
{
    return every_second ? x % 2 == 1 : x >= FIRST;
}

/* Writes the ramp with NaN, and loads it. */
static iso_volume load_ramp(iso_type type)
{
    const size_t size[3] = {NX, NY, NZ};
    const iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    char path[] = "/tmp/isoshade-no-data-XXXXXX";
    iso_volume v, loaded;
    assert_ok(iso_volume_create(&v, &g, type, "ramp", &err));
    for (size_t i = 0; i < COUNT; ++i) {
        const size_t x = i % NX, y = i / NX % NY, z = i / (NX * NY);
        const double value = is_there(x) ? ramp(x, y, z) : (double)NAN;
        if (type == ISO_F32)
            ((float *)v.data)[i] = (float)value;
        else
            ((double *)v.data)[i] = value;
    }
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    assert_ok(iso_volume_save(&v, path, false, &err));
    iso_volume_destroy(&v);
    assert_ok(iso_volume_load(path, &loaded, &err));
    unlink(path);
    return loaded;
}

static iso_pyramid build_ramp(size_t levels)
{
    OWNED(iso_volume) v = load_ramp(ISO_F32);
    iso_pyramid p;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = levels;
    opt.keep_float = true;
    assert_ok(iso_pyramid_build(&v, "ramp", &opt, &p, NULL, &err));
    return p;
}

TEST(ranges_and_means_leave_no_data_out)
{
    for (int i = 0; i < 2; ++i) {
        OWNED(iso_volume) v = load_ramp(i ? ISO_F64 : ISO_F32);
        const iso_volume_stats s = iso_volume_measure(&v);
        assert_true(v.geometry.has_no_data);
        assert_int_equal(s.no_data_count, FIRST * NY * NZ);
        assert_within(s.min, ramp(FIRST, 0, NZ - 1), 0);
        assert_within(s.max, ramp(NX - 1, NY - 1, 0), 0);
        /* The mean of a linear field is its value in the middle; sums of double precision. */
        assert_within(s.mean, 3 + 2 * 0.5 * (FIRST + NX - 1) + 0.5 * 0.5 * (NY - 1) - 0.25 * 0.5 * (NZ - 1), 1e-12);
    }
}

TEST(a_rule_replaces_the_files_values)
{
    iso_no_data rule;
    assert_ok(iso_no_data_parse("-3024,-1025", &rule, &err));
    assert_true(rule.is_given && !rule.is_none);
    assert_within(rule.lo, -3024, 0);
    assert_within(rule.hi, -1025, 0);
    assert_ok(iso_no_data_parse("none", &rule, &err));
    assert_true(rule.is_none);
    assert_ok(iso_no_data_parse("1e20", &rule, &err));
    assert_within(rule.lo, rule.hi, 0);
    static const char *const bad[] = {"", "x", "1,", "2,1", "1,2,3", "nan"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i)
        assert_status(iso_no_data_parse(bad[i], &rule, &err), ISO_E_USAGE);
}

/* Largest error of the gradients of voxels with data, and of the zeros of the others. */
static double gradient_error(const iso_planes *p)
{
    static float scratch[4 * NX + 64];
    static float g[3][NX];
    const iso_mat3 identity = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const iso_gradient_matrix matrix = iso_gradient_matrix_from(identity);
    const double expected[3] = {2, 0.5, -0.25};
    double most = 0;
    for (size_t row = 0; row < NY * NZ; ++row) {
        iso_gradient_row(p, ISO_GRADIENT_CENTRAL, &matrix, row % NY, row / NY, scratch,
                         (float *const[3]){g[0], g[1], g[2]});
        for (size_t x = 0; x < NX; ++x)
            for (int a = 0; a < 3; ++a)
                most = fmax(most, fabs((double)g[a][x] - (is_there(x) ? expected[a] : 0)));
    }
    return most;
}

TEST(gradients_are_one_sided_beside_no_data)
{
    for (int i = 0; i < 2; ++i) {
        OWNED(iso_volume) v = load_ramp(i ? ISO_F64 : ISO_F32);
        iso_planes p = {v.data, v.type, {NX, NY, NZ}, 0, NZ, true};
        assert_within(gradient_error(&p), 0, 0);
        p.has_no_data = false; /* the planted fault: differences to the value that stands for none */
        assert_more_than(gradient_error(&p), 1e20);
    }
}

/* Returns the mean of level 0 over those voxels with data that a voxel of level k covers; NaN: none has. */
static double mean_of_children(size_t k, size_t x, size_t y, size_t z)
{
    double sum = 0;
    int count = 0;
    for (size_t c = 0; c < 8; ++c) {
        const size_t at[3] = {2 * x + (c & 1), 2 * y + (c >> 1 & 1), 2 * z + (c >> 2)};
        const size_t n[3] = {((NX - 1) >> (k - 1)) + 1, ((NY - 1) >> (k - 1)) + 1, ((NZ - 1) >> (k - 1)) + 1};
        size_t in[3];
        for (int a = 0; a < 3; ++a)
            in[a] = at[a] < n[a] ? at[a] : n[a] - 1;
        const double value = k > 1             ? mean_of_children(k - 1, in[0], in[1], in[2])
                             : is_there(in[0]) ? ramp(in[0], in[1], in[2])
                                               : (double)NAN;
        sum += isnan(value) ? 0 : value;
        count += !isnan(value);
    }
    return count ? sum / count : (double)NAN;
}

TEST(levels_are_means_of_the_children_with_data)
{
    OWNED(iso_pyramid) p = build_ramp(3);
    for (size_t k = 1; k < 3; ++k) {
        const iso_level *l = &p.levels[k];
        const size_t *n = l->geometry.size;
        size_t absent = 0;
        for (size_t i = 0; i < n[0] * n[1] * n[2]; ++i) {
            const double wanted = mean_of_children(k, i % n[0], i / n[0] % n[1], i / (n[0] * n[1]));
            absent += isnan(wanted);
            if (isnan(wanted))
                assert_true(iso_is_no_data(l->scalar[i]));
            else
                assert_within((double)l->scalar[i], wanted, 0);
        }
        assert_true(absent > 0);
        assert_true(l->geometry.has_no_data);
        assert_true(l->min >= p.levels[0].min && l->max <= p.levels[0].max);
    }
}

TEST(filters_that_need_more_are_refused)
{
    OWNED(iso_volume) v = load_ramp(ISO_F32);
    iso_pyramid p;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.scalar_filter = ISO_SCALAR_GAUSS;
    assert_status(iso_pyramid_build(&v, "ramp", &opt, &p, NULL, &err), ISO_E_RANGE);
    opt = iso_pyramid_defaults();
    opt.gradient.method = ISO_GRADIENT_SOBEL;
    assert_status(iso_pyramid_build(&v, "ramp", &opt, &p, NULL, &err), ISO_E_RANGE);
}

TEST(a_pyramid_keeps_it)
{
    char dir[] = "/tmp/isoshade-no-data-XXXXXX";
    assert_non_null(mkdtemp(dir));
    char path[64];
    snprintf(path, sizeof path, "%s/a.iso", dir);
    OWNED(iso_pyramid) p = build_ramp(2), loaded;
    assert_ok(iso_pyramid_save(&p, path, &err));
    assert_ok(iso_pyramid_load(path, &loaded, &err));
    iso_pyramid part;
    assert_status(iso_pyramid_load_from(path, 1, &part, &err), ISO_E_RANGE);
    iso_level_check checks[2];
    assert_ok(iso_pyramid_verify(&loaded, 1, checks, NULL, &err));
    assert_true(!checks[0].what && !checks[1].what);
    assert_true(loaded.levels[0].geometry.has_no_data && loaded.levels[1].geometry.has_no_data);
    assert_memory_equal(p.levels[1].scalar, loaded.levels[1].scalar,
                        iso_geometry_voxel_count(&p.levels[1].geometry) * sizeof(float));
    char command[96];
    snprintf(command, sizeof command, "rm -r %s", dir);
    assert_int_equal(system(command), 0);
}

TEST(histograms_and_surveys_leave_no_data_out)
{
    OWNED(iso_pyramid) p = build_ramp(2);
    OWNED(iso_joint) joint;
    FREED iso_survey *survey;
    assert_ok(iso_joint_compute(&p, 1, 8, ISO_SECOND_VALUE_NONE, 1, &joint, &err));
    /* Counted: voxels with data between coarse voxels with data. The coarse voxels from x = FIRST / 2 = 4 on have it;
     * fine voxel 9, whose center is right of that of coarse voxel 4, lies between 4 and 5. */
    assert_int_equal(joint.voxel_count, (NX - FIRST) * NY * NZ);
    assert_ok(iso_survey_make(&p.levels[0], 1, &survey, &err));
    assert_int_equal(survey->voxel_count, (NX - FIRST) * NY * NZ);
    assert_true(survey->lo >= p.levels[0].min && survey->hi <= p.levels[0].max);
}

/* ---- pictures ---- */

typedef enum caster { REFERENCE, CPU, OPENGL } caster;

/* Renders with samples at the same places for all; the reference may be exact instead. */
static iso_image draw(const iso_level *l, iso_code code, const iso_view *view, caster with, bool exact,
                      iso_direction_source source)
{
    iso_reference_options o = iso_reference_defaults();
    iso_cpu_options cpu = iso_cpu_defaults();
    iso_gl_options on_gl = iso_gl_defaults();
    iso_image image;
    o.quadrature = exact ? o.quadrature : ISO_QUADRATURE_MIDPOINT;
    o.source = cpu.source = on_gl.source = source;
    if (with == REFERENCE)
        assert_ok(iso_reference_render(l, code, view, &o, &image, NULL, &err));
    else if (with == CPU)
        assert_ok(iso_cpu_render(l, code, view, &cpu, &image, &err));
    else
        assert_ok(iso_gl_render(gl, l, code, view, &on_gl, &image, &err));
    return image;
}

/* Returns the opacity of a ray along x through the middle of a level. */
static double level_alpha(const iso_pyramid *p, size_t level, const iso_view *view, caster with, bool exact)
{
    OWNED(iso_image) image = draw(&p->levels[level], p->options.code, view, with, exact, ISO_FROM_CODES);
    return (double)image.rgba[4 * (image.width * (image.height / 2) + image.width / 2) + 3];
}

static double middle_alpha(const iso_pyramid *p, const iso_view *view, caster with, bool exact)
{
    return level_alpha(p, 0, view, with, exact);
}

/* Looks along x at a volume of one opacity per mm. */
static iso_scene even_scene(iso_tf_point points[2])
{
    points[0] = (iso_tf_point){0, {0.9, 0.3, 0.2}, 0.1};
    points[1] = (iso_tf_point){1, {0.2, 0.3, 0.9}, 0.1};
    iso_scene scene = scene_of_points(points, 2);
    scene.camera_direction = iso_v3(1, 0, 0);
    scene.tf.unit_is_voxels = false;
    scene.width = scene.height = 9;
    return scene;
}

TEST_BETWEEN(all_renderers_show_the_part_with_data, open_gl, close_gl)
{
    iso_tf_point points[2];
    OWNED(iso_pyramid) p = build_ramp(1);
    iso_scene scene = even_scene(points);
    OWNED(iso_view) view = view_of(&scene, &p);
    view.camera.orthographic = true;
    view.camera.half_height = 4;
    /* From the center of the first voxel with data to the box's face. Causes: the reference's tolerance. The planted
     * fault, data up to the voxel's face, is .016 off. */
    const double length = NX - FIRST - 0.5, wanted = 1 - pow(0.9, length);
    assert_within(middle_alpha(&p, &view, REFERENCE, true), wanted, 5e-6);
    assert_more_than(fabs(1 - pow(0.9, length + 0.5) - wanted), 1e-2);
    /* Segments begin at the camera and have one sample: the edge is off by at most half of one. All renderers have the
     * same samples, in floats. */
    const double samples = middle_alpha(&p, &view, REFERENCE, false);
    assert_within(samples, wanted, 1 - pow(0.9, length + 0.25) - wanted);
    assert_within(middle_alpha(&p, &view, CPU, false), samples, 5e-6);
    assert_within(middle_alpha(&p, &view, OPENGL, false), samples, 5e-6);
}

/* Of a level whose voxels all have data in one half, extinction is half that of the values: the scale's bytes hold
 * powers of two exactly. */
TEST_BETWEEN(levels_are_as_opaque_as_their_share_with_data, open_gl, close_gl)
{
    iso_tf_point points[2];
    bool found;
    every_second = true;
    OWNED(iso_pyramid) p = build_ramp(2);
    every_second = false;
    iso_scene scene = even_scene(points);
    OWNED(iso_view) view = view_of(&scene, &p);
    view.camera.orthographic = true;
    view.camera.half_height = 4;
    assert_ok(iso_view_take_level(&view, &p, 1, &found, &err));
    assert_true(!found && view.extinction_scale);
    const double wanted = 1 - pow(0.9, 0.5 * NX);
    assert_more_than(fabs(1 - pow(0.9, NX) - wanted), 0.2);                  /* the planted fault: no share */
    assert_within(level_alpha(&p, 1, &view, REFERENCE, true), wanted, 5e-6); /* the reference's tolerance */
    for (caster with = REFERENCE; with <= OPENGL; ++with) /* even extinction: samples are exact, rounding of floats */
        assert_within(level_alpha(&p, 1, &view, with, false), wanted, 5e-6);
}

TEST_BETWEEN(differences_on_the_fly_are_one_sided, open_gl, close_gl)
{
    iso_tf_point points[] = {{0, {0.9, 0.3, 0.2}, 0.1}, {1, {0.2, 0.3, 0.9}, 0.4}};
    OWNED(iso_pyramid) p = build_ramp(1);
    iso_scene scene = scene_of_points(points, 2);
    scene.width = scene.height = 15;
    OWNED(iso_view) view = view_of(&scene, &p);
    const iso_level *l = &p.levels[0];
    OWNED(iso_image) wanted = draw(l, p.options.code, &view, REFERENCE, false, ISO_FROM_ON_THE_FLY);
    for (caster with = CPU; with <= OPENGL; ++with) {
        OWNED(iso_image) seen = draw(l, p.options.code, &view, with, false, ISO_FROM_ON_THE_FLY);
        assert_at_most(difference_of(&seen, &wanted).max_abs,
                       1e-5); /* floats; differences to the value that stands for no data are .05 off */
    }
}

static double share_of_byte(uint8_t byte)
{
    return exp2(iso_extinction_scale_log2(byte));
}

TEST(shares_are_means_over_the_fine_voxels)
{
    OWNED(iso_pyramid) p = build_ramp(4);
    char dir[] = "/tmp/isoshade-no-data-XXXXXX", path[64], command[96];
    assert_non_null(mkdtemp(dir));
    snprintf(path, sizeof path, "%s/a.iso", dir);
    assert_ok(iso_pyramid_save(&p, path, &err));
    OWNED(iso_pyramid) loaded;
    assert_ok(iso_pyramid_load(path, &loaded, &err));
    for (size_t k = 1; k < p.level_count; ++k) {
        const iso_level *l = &p.levels[k];
        const size_t *n = l->geometry.size, side = (size_t)1 << k, split = FIRST / side;
        assert_non_null(l->scale);
        for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
            const size_t x = i % n[0];
            const double share = x == split ? (double)(side - FIRST % side) / (double)side : 1;
            if (x >= split) /* half a step of the bytes: 2^(1/56) */
                assert_within(share_of_byte(l->scale[i]) / share, 1, 0.0125);
        }
        assert_memory_equal(l->scale, loaded.levels[k].scale, iso_geometry_voxel_count(&l->geometry));
    }
    snprintf(command, sizeof command, "rm -r %s", dir);
    assert_int_equal(system(command), 0);
}

TEST(tables_end_below_the_values)
{
    float *entries = malloc(8 * sizeof *entries);
    const float two[8] = {1, 0, 0, 0.5f, 0, 1, 0, 2};
    memcpy(entries, two, sizeof two);
    OWNED(iso_tf_table) t = {.count = 2, .lo = 10, .hi = 12, .entries = entries};
    double rgbs[4];
    assert_ok(iso_tf_table_end_below(&t, 5, &err)); /* values from 5 on keep the first entry */
    iso_tf_lookup(&t, 5, rgbs);
    assert_within(rgbs[3], 0.5, 1e-7); /* rounding of places */
    iso_tf_lookup(&t, (double)ISO_NO_DATA, rgbs);
    assert_within(rgbs[3], 0, 0);
    iso_tf_lookup(&t, 12, rgbs);
    assert_within(rgbs[3], 2, 1e-7);
}

TEST_MAIN(NULL, NULL)
