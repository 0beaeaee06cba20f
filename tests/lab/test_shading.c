/* SPDX-License-Identifier: MIT */
/* How shading across levels is measured: what has to be zero is, and what is wrong shows. */
#include "tests/sampled.h"

#include "base/random.h"
#include "lab/shading_error.h"
#include "lab/shading_method.h"
#include "lab/quartiles.h"

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
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.keep_float = true;
    iso_pyramid p = sampled_pyramid(f, ISO_F32, &opt);
    return p;
}

static iso_field field_of(iso_field_kind kind)
{
    return (iso_field){.kind = kind,
                       .seed = 1,
                       .geometry = iso_geometry_axis_aligned((size_t[]){48, 54, 60}, (double[]){1, 0.9, 1.2})};
}

static const iso_shading_look look = {.view_count = 2, .image_size = 48, .surface = 0};

TEST(level_0_is_at_no_distance_from_itself)
{
    iso_field f = field_of(ISO_FIELD_TUBES);
    OWNED(iso_pyramid) p = pyramid_of(&f);
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
    assert_within(e.dssim_mean, 0, 1e-6); /* the scalar is resampled at its own centers */
    /* the fault that both must see: level 2 */
    assert_ok(iso_shading_measure(&s, &(iso_shading_shown){&p.levels[2], 2, ISO_CODE_SNORM, ISO_FROM_CODES, NULL, 0},
                                  &e, &err));
    assert_more_than(e.dssim_mean, 0.01);
    assert_ok(iso_shading_floor(&s, &p.levels[0], &p.levels[2], 2, ISO_CODE_SNORM, &e, &err));
    assert_more_than(e.dssim_mean, 0.01);
    iso_shading_end(&s);
}

/* Directions turned by a known angle, and mirrored ones, which two-sided light does not tell apart. */
TEST(angles_are_those_by_which_directions_were_turned)
{
    iso_field f = field_of(ISO_FIELD_PLATE); /* one direction everywhere */
    OWNED(iso_pyramid) p = pyramid_of(&f);
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
}

enum { edge = 20, cells = edge * edge * edge };

/* A cube of the values that a function of the distance to the middle, 0 to about 17, gives; the function may take
 * noise. */
static iso_level level_of(float values[cells], double (*value)(double distance, double x, iso_random *random))
{
    iso_level level = {.geometry = iso_geometry_axis_aligned((size_t[]){edge, edge, edge}, (double[]){1, 1, 1}),
                       .scalar = values,
                       .min = INFINITY,
                       .max = -INFINITY};
    iso_random random = {7};
    for (size_t i = 0; i < cells; ++i) {
        const iso_vec3 d = {(double)(i % edge) - 9.5, (double)(i / edge % edge) - 9.5,
                            (double)(i / (edge * edge)) - 9.5};
        values[i] = (float)value(iso_norm(d), d.x, &random);
        level.min = fmin(level.min, (double)values[i]);
        level.max = fmax(level.max, (double)values[i]);
    }
    return level;
}

/* Zeros, none below 60, and a brain of 60 to 100. */
static double zeros_gap_brain(double distance, double x, iso_random *random)
{
    (void)x;
    return distance < 7 ? 60 + 40 * iso_random_unit(random) : 0;
}

/* A negative lobe and a weaker positive one in zeros. */
static double signed_field(double distance, double x, iso_random *random)
{
    (void)random;
    return distance < 8 ? (x < 0 ? -1 : 0.4) * (8 - distance) : 0;
}

/* Around one value: the sum of twelve numbers in [0, 1) is nearly normal. */
static double unimodal_noise(double distance, double x, iso_random *random)
{
    double sum = 0;
    (void)distance, (void)x;
    for (int i = 0; i < 12; ++i)
        sum += iso_random_unit(random);
    return sum;
}

static double one_value(double distance, double x, iso_random *random)
{
    (void)distance, (void)x, (void)random;
    return 10;
}

/* Where neither side of the box is a background. */
static double two_halves(double distance, double x, iso_random *random)
{
    (void)distance;
    return (x < 0 ? 0.2 : 0.8) + 0.2 * iso_random_unit(random);
}

/* Opacity of a value, as a fraction of the range. */
static double opacity_at(const iso_otsu_surface *surface, double fraction)
{
    iso_surface_tf storage;
    const iso_tf tf = iso_surface_make_tf(surface, &storage);
    for (size_t i = 1; i < tf.point_count; ++i)
        if (fraction <= tf.points[i].value) {
            const iso_tf_point *a = &tf.points[i - 1], *b = &tf.points[i];
            return a->opacity + (fraction - a->value) / (b->value - a->value) * (b->opacity - a->opacity);
        }
    return NAN;
}

TEST(the_surface_lies_in_the_middle_of_a_gap)
{
    float values[cells];
    const iso_level level = level_of(values, zeros_gap_brain);
    const iso_otsu_surface s = iso_surface_find(&level);
    assert_null(s.left_out);
    assert_false(s.below);
    /* the gap is .004 to .60 of the range; the first threshold in it, .004, would leave its ramp in what air is
     * filtered to */
    assert_within(s.fraction, 0.3, 0.01);
    assert_within(s.border, 0, 0);
    assert_within(s.ramp, 0, 0);
    assert_within(opacity_at(&s, 0), 0, 0);
    assert_within(opacity_at(&s, 0.2), 0, 0); /* a fifth of brain and four of air */
    assert_within(opacity_at(&s, 0.6), 0.8, 1e-12);
}

TEST(a_signed_field_shows_the_lobe_and_not_its_background)
{
    float values[cells];
    const iso_level level = level_of(values, signed_field);
    const iso_otsu_surface s = iso_surface_find(&level);
    const double zero = (0 - level.min) / (level.max - level.min);
    assert_null(s.left_out);
    assert_true(s.below);
    assert_at_most(s.fraction, zero - ISO_SURFACE_HALF_RAMP);
    assert_within(s.border, 0, 0);
    assert_within(opacity_at(&s, zero), 0, 0);
    assert_within(opacity_at(&s, 0.01), 0.8, 1e-12);
    /* the fault: the values above the same threshold are an opaque box, which is refused */
    const iso_otsu_surface above = iso_surface_at(&level, s.fraction);
    assert_within(above.border, 1, 0);
    assert_non_null(strstr(above.left_out, "background"));
}

TEST(noise_around_one_value_has_no_surface)
{
    float values[cells];
    const iso_level noise = level_of(values, unimodal_noise);
    assert_non_null(strstr(iso_surface_find(&noise).left_out, "two classes"));
    const iso_level same = level_of(values, one_value);
    assert_non_null(strstr(iso_surface_find(&same).left_out, "constant"));
}

TEST(a_box_parted_evenly_keeps_its_surface)
{
    float values[cells];
    const iso_level level = level_of(values, two_halves);
    const iso_otsu_surface s = iso_surface_find(&level);
    assert_null(s.left_out);
    assert_within(s.fraction, 0.5, 0.01);
    assert_within(s.border, 0.5, 0);
}

/* Nothing is rendered, and what is asked of it ends well. */
TEST(a_volume_without_a_surface_is_left_out)
{
    iso_field f = field_of(ISO_FIELD_NOISE);
    OWNED(iso_pyramid) p = pyramid_of(&f);
    iso_shading_subject s;
    assert_ok(iso_shading_begin(&s, gl, &p.levels[0], ISO_CODE_SNORM, &f, &look, &err));
    assert_non_null(s.surface.left_out);
    assert_null(s.finest[0].rgba);
    assert_int_equal(s.point_count, 0);
    iso_shading_end(&s);
}

TEST(ratios_have_a_median_that_one_case_does_not_move)
{
    double ratios[] = {0.9, 0.8, 1.0, 0.7, 0.01};
    const iso_ratios r = iso_ratios_summarize(ratios, 5);
    assert_int_equal(r.count, 5);
    assert_within(r.median, 0.8, 1e-15);
    assert_within(r.lower, 0.7, 1e-15);
    assert_within(r.upper, 0.9, 1e-15);
    assert_within(r.geometric_mean, pow(0.9 * 0.8 * 0.7 * 0.01, 0.2), 1e-15); /* .35: what one case of five does */
    double two[] = {4, 1};
    assert_within(iso_ratios_summarize(two, 2).lower, 1.75, 1e-15); /* a quarter of the way */
    assert_true(isnan(iso_ratios_summarize(two, 0).median));
}

/* The sides of a tube point apart. The planted fault is the default with all lengths made equal. */
TEST(the_default_is_nearer_to_level_0_than_gradients_on_the_fly)
{
    iso_field f = field_of(ISO_FIELD_TUBES);
    OWNED(iso_pyramid) p = pyramid_of(&f);
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

TEST(views_are_evenly_spread_and_off_the_axes)
{
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

enum { sphere_edge = 32 };
static double mean_angle(const iso_field *field, const iso_volume *v, iso_gradient_method method)
{
    float *g = malloc(3 * sphere_edge * sphere_edge * sphere_edge * sizeof *g);
    double sum = 0, count = 0;
    assert_ok(iso_gradient_compute(v, &(iso_gradient_options){method, 1}, g, &err));
    for (size_t z = 4; z + 4 < sphere_edge; ++z)
        for (size_t y = 4; y + 4 < sphere_edge; ++y)
            for (size_t x = 4; x + 4 < sphere_edge; ++x) {
                const float *d = g + 3 * (x + sphere_edge * (y + sphere_edge * z));
                iso_vec3 truth;
                iso_field_value(field,
                                iso_geometry_to_world(&v->geometry,
                                                      iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5)),
                                &truth);
                if (iso_norm(truth) < 1e-9)
                    continue; /* beyond the sphere */
                sum += acos(
                    fmin(iso_dot(iso_normalize(iso_v3((double)d[0], (double)d[1], (double)d[2])), iso_normalize(truth)),
                         1));
                count += 1;
            }
    free(g);
    return sum / count;
}

/* The noise of the sum: weights' squares are .156 * .273^2 against .5 of central differences, a sixth of the
 * deviation. */
TEST(smooth_gradients_hold_noise_down)
{
    iso_field field;
    OWNED(iso_volume) v;
    assert_ok(iso_shading_sample(ISO_FIELD_SPHERE, sphere_edge, 0.01, &field, &v, &err));
    const double central = mean_angle(&field, &v, ISO_GRADIENT_CENTRAL),
                 sobel = mean_angle(&field, &v, ISO_GRADIENT_SOBEL),
                 smooth = mean_angle(&field, &v, ISO_GRADIENT_SMOOTH);
    assert_at_most(smooth, 0.25 * central);
    assert_at_most(smooth, 0.6 * sobel);
}

TEST_MAIN(make_gl, drop_gl)
