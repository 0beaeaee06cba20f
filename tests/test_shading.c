/* SPDX-License-Identifier: MIT */
/* How shading across levels is measured: what has to be zero is, and what is wrong shows. */
#include "test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/shading_error.h"

static iso_gl *gl;

static int make_gl(void **state)
{
    (void)state;
    iso_error why = {""};
    if (iso_gl_create(&gl, NULL, &why) == ISO_OK)
        return 0;
    printf("%s\n", why.text);
    return -1;
}

static int drop_gl(void **state)
{
    (void)state;
    iso_gl_destroy(gl);
    return 0;
}

static iso_pyramid pyramid_of(const iso_field *f)
{
    iso_volume v;
    iso_pyramid p;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.keep_float = true;
    assert_ok(iso_field_sample(f, ISO_F32, &v, &err));
    assert_ok(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err));
    iso_volume_destroy(&v);
    return p;
}

static iso_field field_of(iso_field_kind kind)
{
    return (iso_field){.kind = kind,
                       .seed = 1,
                       .geometry = iso_geometry_axis_aligned((size_t[]){48, 54, 60}, (double[]){1, 0.9, 1.2})};
}

static const iso_shading_look look = {.view_count = 2, .image_size = 48, .surface = 0};

static void level_0_is_at_no_distance_from_itself(void **state)
{
    (void)state;
    iso_field f = field_of(ISO_FIELD_TUBES);
    iso_pyramid p = pyramid_of(&f);
    iso_shading_subject s;
    iso_shading_error e;
    assert_ok(iso_shading_begin(&s, gl, &p.levels[0], ISO_CODE_SNORM, &f, &look, &err));
    assert_true(s.point_count > 500);
    assert_ok(iso_shading_measure(&s, &(iso_shading_shown){&p.levels[0], 0, ISO_CODE_SNORM, ISO_FROM_CODES, NULL, 0},
                                  &e, &err));
    assert_within(e.dssim_mean, 0, 1e-12);    /* equal sums, rounded */
    assert_within(e.angle_mean_deg, 0, 1e-4); /* acos near 1 turns 1e-16 into 1e-6 degrees */
    assert_more_than(e.truth_mean_deg, 0.01); /* central differences are not the truth, */
    assert_at_most(e.truth_mean_deg, 8);      /* but near it: a tube is a few voxels thick */
    assert_ok(iso_shading_floor(&s, &p.levels[0], &p.levels[0], 0, ISO_CODE_SNORM, &e, &err));
    assert_within(e.dssim_mean, 0, 1e-6); /* the scalar is resampled at its own centres */
    /* the fault that both must see: level 2 */
    assert_ok(iso_shading_measure(&s, &(iso_shading_shown){&p.levels[2], 2, ISO_CODE_SNORM, ISO_FROM_CODES, NULL, 0},
                                  &e, &err));
    assert_more_than(e.dssim_mean, 0.01);
    assert_ok(iso_shading_floor(&s, &p.levels[0], &p.levels[2], 2, ISO_CODE_SNORM, &e, &err));
    assert_more_than(e.dssim_mean, 0.01);
    iso_shading_end(&s);
    iso_pyramid_destroy(&p);
}

/* Directions turned by a known angle, and mirrored ones, which two-sided light does not tell apart. */
static void angles_are_those_by_which_directions_were_turned(void **state)
{
    (void)state;
    iso_field f = field_of(ISO_FIELD_PLATE); /* one direction everywhere */
    iso_pyramid p = pyramid_of(&f);
    iso_shading_subject s;
    iso_shading_error e;
    assert_ok(iso_shading_begin(&s, gl, &p.levels[0], ISO_CODE_SNORM, &f, &look, &err));
    const size_t count = iso_geometry_voxel_count(&p.levels[0].geometry);
    float *turned = p.levels[0].directions;
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        /* the plate's normal (1, 2, 4) turned by 10 degrees towards (2, -1, 0), which is at right angles to it */
        const iso_vec3 n = iso_normalize(iso_v3(1, 2, 4)), t = iso_normalize(iso_v3(2, -1, 0));
        const double angle = 10 * 3.14159265358979323846 / 180, sign = mirrored ? -1 : 1;
        const iso_vec3 d = iso_scale(iso_madd(iso_scale(n, cos(angle)), t, sin(angle)), sign);
        for (size_t i = 0; i < count; ++i) {
            turned[3 * i] = (float)d.x;
            turned[3 * i + 1] = (float)d.y;
            turned[3 * i + 2] = (float)d.z;
        }
        assert_ok(iso_shading_measure(&s,
                                      &(iso_shading_shown){&p.levels[0], 0, ISO_CODE_SNORM, ISO_FROM_FLOAT, NULL, 0},
                                      &e, &err));
        assert_within(e.truth_mean_deg, 10,
                      0.01); /* the sampler's epsilon shortens, it does not turn; floats do by 1e-5 */
    }
    memset(turned, 0, 3 * count * sizeof *turned);
    assert_ok(iso_shading_measure(&s, &(iso_shading_shown){&p.levels[0], 0, ISO_CODE_SNORM, ISO_FROM_FLOAT, NULL, 0},
                                  &e, &err));
    assert_within(e.angle_mean_deg, 90, 1e-9); /* no direction */
    iso_shading_end(&s);
    iso_pyramid_destroy(&p);
}

static void otsu_parts_two_classes_between_them(void **state)
{
    (void)state;
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){10, 10, 10}, (double[]){1, 1, 1});
    float values[1000];
    iso_level level = {.geometry = g, .scalar = values, .min = 10, .max = 50};
    for (size_t i = 0; i < 1000; ++i) /* a tenth of the voxels at 40 and above, the others at 20 and below */
        values[i] = i % 10 == 0 ? (float)(40 + i % 11) : (float)(10 + i % 11);
    const double fraction = iso_otsu_fraction(&level);
    assert_more_than(fraction, 0.25); /* 20 of 10 to 50 */
    assert_at_most(fraction, 0.75);
    for (size_t i = 0; i < 1000; ++i)
        values[i] = 10;
    level.max = 10;
    assert_within(iso_otsu_fraction(&level), 0.5, 0); /* one value: any is as good */
}

/* The sides of a tube point apart. The planted fault is the default with all lengths made equal. */
static void the_default_is_nearer_to_level_0_than_gradients_on_the_fly(void **state)
{
    (void)state;
    iso_field f = field_of(ISO_FIELD_TUBES);
    iso_pyramid p = pyramid_of(&f);
    iso_shading_subject s;
    assert_ok(iso_shading_begin(&s, gl, &p.levels[0], ISO_CODE_SNORM, &f, &look, &err));
    iso_shading_error own, fly, unit;
    iso_level *l = &p.levels[1];
    assert_ok(iso_shading_measure(&s, &(iso_shading_shown){l, 1, ISO_CODE_SNORM, ISO_FROM_CODES, NULL, 0}, &own, &err));
    assert_ok(
        iso_shading_measure(&s, &(iso_shading_shown){l, 1, ISO_CODE_SNORM, ISO_FROM_ON_THE_FLY, NULL, 0}, &fly, &err));
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        float *d = l->directions + 3 * i;
        const float length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (int c = 0; c < 3 && length > 0; ++c)
            d[c] /= length;
    }
    assert_ok(
        iso_shading_measure(&s, &(iso_shading_shown){l, 1, ISO_CODE_SNORM, ISO_FROM_FLOAT, NULL, 0}, &unit, &err));
    /* measured: DSSIM .0287 against .0303 and, without lengths, .0291; 4.7 degrees against 10.5 and 6.3 */
    assert_at_most(own.dssim_mean, 0.96 * fly.dssim_mean);
    assert_at_most(own.truth_mean_deg, 0.55 * fly.truth_mean_deg);
    assert_more_than(unit.truth_mean_deg, 0.55 * fly.truth_mean_deg);
    iso_shading_end(&s);
    iso_pyramid_destroy(&p);
}

/* Cosine of the two views that are nearest to each other, up to sign where axes count. */
static double nearest(const iso_vec3 *views, int count, bool axes)
{
    double most = -1;
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < i; ++j) {
            const double c = iso_dot(views[i], views[j]);
            most = fmax(most, axes ? fabs(c) : c);
        }
    return most;
}

static void views_are_evenly_spread_and_off_the_axes(void **state)
{
    (void)state;
    iso_vec3 faces[ISO_FACE_VIEWS], diagonals[ISO_DIAGONAL_VIEWS];
    for (int i = 0; i < ISO_FACE_VIEWS; ++i)
        faces[i] = iso_view_through_face(i);
    for (int i = 0; i < ISO_DIAGONAL_VIEWS; ++i)
        diagonals[i] = iso_view_along_diagonal(i);
    assert_within(nearest(faces, ISO_FACE_VIEWS, false), sqrt(5) / 3, 1e-12); /* a dodecahedron's edge: 41.8 degrees */
    assert_within(nearest(diagonals, ISO_DIAGONAL_VIEWS, true), 1 / sqrt(5),
                  1e-12); /* six equal angles, 63.4 degrees */
    for (int i = 0; i < ISO_FACE_VIEWS + ISO_DIAGONAL_VIEWS; ++i) {
        const iso_vec3 d = i < ISO_FACE_VIEWS ? faces[i] : diagonals[i - ISO_FACE_VIEWS];
        assert_within(iso_norm(d), 1, 1e-15);
        assert_at_most(fmax(fabs(d.x), fmax(fabs(d.y), fabs(d.z))), 0.95);
        assert_at_most(fabs(iso_dot(d, iso_view_up(d))), 0.95);
    }
    faces[3] = faces[2]; /* the fault: a view twice */
    assert_more_than(nearest(faces, ISO_FACE_VIEWS, false), 0.99);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(level_0_is_at_no_distance_from_itself),
        cmocka_unit_test(angles_are_those_by_which_directions_were_turned),
        cmocka_unit_test(views_are_evenly_spread_and_off_the_axes),
        cmocka_unit_test(otsu_parts_two_classes_between_them),
        cmocka_unit_test(the_default_is_nearer_to_level_0_than_gradients_on_the_fly),
    };
    return cmocka_run_group_tests(tests, make_gl, drop_gl);
}
