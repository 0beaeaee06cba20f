/* SPDX-License-Identifier: MIT */
/* The pyramid against direct sums in double precision, and its files. Its structural promises: test_promises.c. */
#include "folder.h"
#include "same_levels.h"
#include "test.h"

#include "base/file.h"
#include "pyramids.h"

static size_t clamp_index(long i, size_t n)
{
    return i < 0 ? 0 : i >= (long)n ? n - 1 : (size_t)i;
}

/* ---- the same in double precision, by direct sums ---- */

typedef struct field { /* 3 or 1 doubles a voxel */
    size_t size[3];
    double *data;
} field;

static field field_of_gradients(const iso_volume *v)
{
    const size_t *n = v->geometry.size, count = n[0] * n[1] * n[2];
    field f = {{n[0], n[1], n[2]}, malloc(3 * count * sizeof(double))};
    FREED float *g = malloc(3 * count * sizeof *g);
    iso_gradient_options opt = iso_gradient_defaults();
    assert_ok(iso_gradient_compute(v, &opt, g, &err));
    for (size_t i = 0; i < 3 * count; ++i)
        f.data[i] = g[i];
    return f;
}

typedef void (*visit)(const double g[3], double weight, double sum[4]);

static void visit_moments(const double g[3], double weight, double sum[4])
{
    double m = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    for (int c = 0; c < 3; ++c)
        sum[c] += weight * m * m * (m > 0 ? g[c] / m : 0);
    sum[3] += weight * m * m;
}

static size_t eq1_exponent = 1;
static void visit_eq1(const double g[3], double weight, double sum[4]) /* [diaz-garcia-2017] Eq. 1, m to an exponent */
{
    double m = pow(sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]), (double)eq1_exponent);
    for (int c = 0; c < 3; ++c)
        sum[c] += g[c] * m * weight;
    sum[3] += m * weight;
}

static void visit_vector(const double g[3], double weight, double sum[4])
{
    for (int c = 0; c < 3; ++c)
        sum[c] += g[c] * weight;
    sum[3] += weight;
}

/* Sums over the 2 radius fine voxels around each axis' center, clamped to the edge. */
static void direct_sum(const field *fine, const size_t at[3], long radius, double sigma, visit take, double sum[4])
{
    memset(sum, 0, 4 * sizeof *sum);
    for (long z = 1 - radius; z <= radius; ++z)
        for (long y = 1 - radius; y <= radius; ++y)
            for (long x = 1 - radius; x <= radius; ++x) {
                double ox = (double)x - 0.5, oy = (double)y - 0.5, oz = (double)z - 0.5;
                double weight = exp(-0.5 * (ox * ox + oy * oy + oz * oz) / (sigma * sigma));
                size_t sx = clamp_index((long)(2 * at[0]) + x, fine->size[0]),
                       sy = clamp_index((long)(2 * at[1]) + y, fine->size[1]),
                       sz = clamp_index((long)(2 * at[2]) + z, fine->size[2]);
                take(fine->data + 3 * ((sz * fine->size[1] + sy) * fine->size[0] + sx), weight, sum);
            }
}

/* The fine voxel below voxel i of the given level: each level continues its edge. `path` picks the child, a bit a
 * level. */
static size_t descend(size_t i, size_t level, size_t path, size_t fine_size)
{
    for (size_t k = level; k-- > 0;) {
        const size_t size = (fine_size + ((size_t)1 << k) - 1) >> k;
        i = clamp_index((long)(2 * i + (path >> k & 1)), size);
    }
    return i;
}

/* Sums over all 8^level fine children. */
static void sum_children(const field *fine, const size_t at[3], size_t level, visit take, double sum[4])
{
    memset(sum, 0, 4 * sizeof *sum);
    for (size_t path = 0; path < (size_t)1 << 3 * level; ++path) {
        const size_t mask = ((size_t)1 << level) - 1;
        size_t x = descend(at[0], level, path & mask, fine->size[0]);
        size_t y = descend(at[1], level, path >> level & mask, fine->size[1]);
        size_t z = descend(at[2], level, path >> 2 * level & mask, fine->size[2]);
        take(fine->data + 3 * ((z * fine->size[1] + y) * fine->size[0] + x), 1, sum);
    }
}

static double largest_difference(const iso_level *l, const double *expected)
{
    double largest = 0;
    for (size_t i = 0; i < 3 * iso_geometry_voxel_count(&l->geometry); ++i)
        if (!(fabs(l->directions[i] - expected[i]) <= largest))
            largest = fabs(l->directions[i] - expected[i]);
    return largest;
}

/* Directions from float sums of at most 512 terms of one sign or less: 1e-5 is 100 roundings of 2^-24 of a
 * unit vector that cancellation has shortened to a tenth. */
static const double float_sums = 1e-5;

TEST(moments_equal_the_direct_sum_over_all_fine_children)
{
    OWNED(iso_volume) v = noise(11, 6, 9);
    iso_pyramid_options opt = keeping(ISO_DIRECTION_MOMENTS);
    OWNED(iso_pyramid) p = build(&v, &opt);
    field fine = field_of_gradients(&v);
    assert_int_equal(p.level_count, 4);
    for (size_t k = 1; k < p.level_count; ++k) {
        const iso_level *l = &p.levels[k];
        const size_t count = iso_geometry_voxel_count(&l->geometry);
        FREED double *expected = malloc(3 * count * sizeof *expected), *linear = malloc(3 * count * sizeof *linear);
        for (size_t i = 0; i < count; ++i) {
            size_t at[3];
            double s[4];
            place(&l->geometry, i, at);
            sum_children(&fine, at, k, visit_moments, s);
            double length = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
            for (int c = 0; c < 3; ++c) {
                expected[3 * i + (size_t)c] = s[c] / length * (length / s[3]) * (length / s[3]);
                linear[3 * i + (size_t)c] = s[c] / s[3];
            }
            double rms = sqrt(s[3] / pow(8, (double)k));
            assert_within(l->magnitude[i], rms, 1e-5 * rms);
        }
        assert_at_most(largest_difference(l, expected), float_sums);
        assert_more_than(largest_difference(l, linear), float_sums); /* L instead of L^2 */
    }
    free(fine.data);
}

/* One level of Eq. 1 from the next finer one, by direct sums: 3 doubles a voxel. */
static double *direct_eq1(const field *fine, const iso_geometry *g, size_t radius, double sigma, size_t exponent)
{
    double *out = malloc(3 * iso_geometry_voxel_count(g) * sizeof *out);
    eq1_exponent = exponent;
    for (size_t i = 0; i < iso_geometry_voxel_count(g); ++i) {
        size_t at[3];
        double s[4];
        place(g, i, at);
        direct_sum(fine, at, (long)radius, sigma, visit_eq1, s);
        for (size_t c = 0; c < 3; ++c)
            out[3 * i + c] = s[c] / s[3];
    }
    return out;
}

/* Largest distance of the level's filtered gradients (direction times magnitude) from the expected ones. */
static double eq1_difference(const iso_level *l, const double *expected)
{
    double largest = 0;
    for (size_t i = 0; i < 3 * iso_geometry_voxel_count(&l->geometry); ++i) {
        const double difference = fabs((double)l->directions[i] * (double)l->magnitude[i / 3] - expected[i]);
        if (!(difference <= largest))
            largest = difference;
    }
    return largest;
}

typedef struct eq1_case {
    size_t radius, exponent, size[3];
    double sigma;
} eq1_case;

/* Every level from the one below as it is expected, so that no rounding is handed on. What options change must show. */
static void check_eq1(const eq1_case *c)
{
    OWNED(iso_volume) v = noise(c->size[0], c->size[1], c->size[2]);
    iso_pyramid_options opt = keeping(ISO_DIRECTION_EQ1);
    opt.gauss_radius = c->radius;
    opt.gauss_sigma_voxels = c->sigma;
    opt.eq1_exponent = c->exponent;
    opt.level_count = 3;
    OWNED(iso_pyramid) p = build(&v, &opt);
    field fine = field_of_gradients(&v);
    for (size_t k = 1; k < p.level_count; ++k) {
        const iso_level *l = &p.levels[k];
        double *expected = direct_eq1(&fine, &l->geometry, c->radius, c->sigma, c->exponent);
        /* gradients are below 2; weights, products and sums of up to 32^3 float terms, of which few weigh: 20
         * roundings */
        assert_at_most(eq1_difference(l, expected), 3e-6);
        const struct {
            size_t radius, exponent;
            double sigma;
        } faults[] = {{c->radius + 1, c->exponent, c->sigma},
                      {c->radius, c->exponent + 1, c->sigma},
                      {c->radius, c->exponent, 0.8 * c->sigma}};
        for (size_t f = 0; f < 3; ++f) {
            /* at radius 1 all eight weights are one, and nearly so under a flat Gaussian; beyond 2 sigma a tap more is
             * little */
            const double reach = (double)c->radius / c->sigma;
            const bool shows = f == 0 ? reach <= 2 : f == 1 || (c->radius > 1 && reach > 0.1);
            FREED double *other = direct_eq1(&fine, &l->geometry, faults[f].radius, faults[f].sigma,
                                             faults[f].exponent);
            if (shows)
                assert_more_than(eq1_difference(l, other), 1e-4);
        }
        free(fine.data);
        fine = (field){{l->geometry.size[0], l->geometry.size[1], l->geometry.size[2]}, expected};
    }
    free(fine.data);
}

TEST(equation_1_equals_its_direct_sum_iterated_from_the_finest_gradients)
{
    const eq1_case cases[] = {
        {2, 1, {9, 12, 7}, 1},   {1, 1, {9, 12, 7}, 0.7}, {3, 1, {9, 12, 7}, 1.6}, /* radius, with sigma */
        {2, 1, {8, 6, 10}, 0.4}, {2, 1, {8, 6, 10}, 100}, /* a narrow Gaussian, and a flat one */
        {2, 0, {9, 12, 7}, 1},   {2, 2, {9, 12, 7}, 1},   {1, 3, {6, 9, 7}, 1},
        {3, 4, {6, 9, 7}, 1.2},                                                 /* exponents */
        {2, 1, {5, 1, 3}, 1},    {3, 2, {1, 7, 2}, 1},    {2, 1, {1, 1, 9}, 1}, /* axes of one voxel */
        {16, 1, {5, 6, 7}, 6},   {9, 1, {3, 20, 5}, 3}, /* kernels wider than the volume: all border */
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c)
        check_eq1(&cases[c]);
}

TEST(naive_directions_are_unit_means)
{
    OWNED(iso_volume) v = noise(7, 8, 5);
    iso_pyramid_options opt = keeping(ISO_DIRECTION_NAIVE);
    OWNED(iso_pyramid) p = build(&v, &opt);
    field fine = field_of_gradients(&v);
    for (size_t k = 1; k < p.level_count; ++k) {
        const iso_level *l = &p.levels[k];
        const size_t count = iso_geometry_voxel_count(&l->geometry);
        FREED double *unit = malloc(3 * count * sizeof *unit);
        for (size_t i = 0; i < count; ++i) {
            size_t at[3];
            double s[4];
            place(&l->geometry, i, at);
            sum_children(&fine, at, k, visit_vector, s);
            double length = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
            for (size_t c = 0; c < 3; ++c)
                unit[3 * i + c] = s[c] / length;
        }
        assert_at_most(largest_difference(l, unit), 1e-4);
    }
    free(fine.data);
}

/* The main axis of a symmetric matrix by many plain power iterations; *gap is how far the second eigenvalue lies
 * below. */
static iso_vec3 main_axis(const double t[6], double *gap)
{
    const iso_mat3 m = {{{t[0], t[3], t[4]}, {t[3], t[1], t[5]}, {t[4], t[5], t[2]}}};
    iso_vec3 e = iso_v3(0.5, 0.6, 0.7), f = iso_v3(0.3, -0.8, 0.4);
    for (int i = 0; i < 2000; ++i)
        e = iso_normalize(iso_mul(m, e));
    for (int i = 0; i < 2000; ++i) {
        f = iso_mul(m, f);
        f = iso_normalize(iso_madd(f, e, -iso_dot(f, e)));
    }
    *gap = 1 - iso_dot(f, iso_mul(m, f)) / iso_dot(e, iso_mul(m, e));
    return e;
}

TEST(tensor_directions_are_the_main_axis_on_the_mean_s_side)
{
    OWNED(iso_volume) v = noise(12, 10, 8);
    iso_pyramid_options opt = keeping(ISO_DIRECTION_TENSOR);
    OWNED(iso_pyramid) p = build(&v, &opt);
    field fine = field_of_gradients(&v);
    const iso_level *l = &p.levels[1];
    size_t compared = 0;
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        size_t at[3];
        double n[4], t[6] = {0}, gap;
        static const int pair[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
        place(&l->geometry, i, at);
        sum_children(&fine, at, 1, visit_moments, n);
        for (size_t child = 0; child < 8; ++child) {
            size_t x = descend(at[0], 1, child & 1, 12), y = descend(at[1], 1, child >> 1 & 1, 10),
                   z = descend(at[2], 1, child >> 2, 8);
            const double *g = fine.data + 3 * ((z * 10 + y) * 12 + x);
            for (int c = 0; c < 6; ++c)
                t[c] += g[pair[c][0]] * g[pair[c][1]];
        }
        iso_vec3 e = main_axis(t, &gap), mean = iso_v3(n[0], n[1], n[2]);
        if (gap < 0.2 || fabs(iso_dot(e, mean)) < 1e-3 * iso_norm(mean))
            continue; /* 0.8^64 = 6e-7 of another axis is left at most; a side must be there */
        e = iso_scale(e, (iso_dot(e, mean) < 0 ? -1 : 1) * iso_norm(mean) / n[3]);
        for (int c = 0; c < 3; ++c)
            assert_within(l->directions[3 * i + (size_t)c], c == 0 ? e.x : c == 1 ? e.y : e.z, 2e-5);
        ++compared;
    }
    assert_true(compared > 60);
    free(fine.data);
}

/* ---- scalars ---- */

TEST(mean_scalars_continue_the_edge_at_odd_sizes)
{
    OWNED(iso_volume) v = noise(5, 1, 10);
    iso_pyramid_options opt = iso_pyramid_defaults();
    OWNED(iso_pyramid) p = build(&v, &opt);
    const size_t wanted[][3] = {{5, 1, 10}, {3, 1, 5}, {2, 1, 3}, {1, 1, 2}};
    assert_int_equal(p.level_count, 4);
    for (size_t k = 0; k < 4; ++k) {
        const iso_level *l = &p.levels[k];
        assert_memory_equal(l->geometry.size, wanted[k], sizeof wanted[k]);
        for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
            size_t at[3];
            double sum = 0;
            place(&l->geometry, i, at);
            for (size_t path = 0; path < (size_t)1 << 2 * k; ++path)
                sum += ((float *)v.data)[descend(at[2], k, path >> k, 10) * 5 +
                                         descend(at[0], k, path & (((size_t)1 << k) - 1), 5)];
            assert_within(l->scalar[i], sum / pow(4, (double)k), 4e-7); /* float sums of values below 1 */
            assert_true(l->min <= l->scalar[i] && l->scalar[i] <= l->max);
        }
    }
}

TEST(gaussian_scalars_equal_their_direct_sum)
{
    OWNED(iso_volume) v = noise(7, 6, 5);
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.scalar_filter = ISO_SCALAR_GAUSS;
    opt.gauss_sigma_voxels = 1.3;
    opt.level_count = 2;
    OWNED(iso_pyramid) p = build(&v, &opt);
    const iso_level *l = &p.levels[1];
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        size_t at[3];
        double sum = 0, weights = 0;
        place(&l->geometry, i, at);
        for (long z = -1; z < 3; ++z)
            for (long y = -1; y < 3; ++y)
                for (long x = -1; x < 3; ++x) {
                    double r2 = pow((double)x - 0.5, 2) + pow((double)y - 0.5, 2) + pow((double)z - 0.5, 2);
                    double w = exp(-0.5 * r2 / (1.3 * 1.3));
                    weights += w;
                    sum += w * ((float *)v.data)[(clamp_index((long)(2 * at[2]) + z, 5) * 6 +
                                                  clamp_index((long)(2 * at[1]) + y, 6)) *
                                                     7 +
                                                 clamp_index((long)(2 * at[0]) + x, 7)];
                }
        assert_within(l->scalar[i], sum / weights, 1e-6); /* float sums of 64 values below 1 */
    }
}

/* ---- which levels, and which bytes ---- */

TEST(levels_of_a_single_voxel_are_left_out)
{
    const struct {
        size_t size[3], levels;
    } cases[] = {{{4, 1, 1}, 2}, {{1, 1, 1}, 1}, {{8, 5, 2}, 3}, {{9, 1, 1}, 4}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        OWNED(iso_volume) v = noise(cases[c].size[0], cases[c].size[1], cases[c].size[2]);
        iso_pyramid_options opt = iso_pyramid_defaults();
        opt.level_count = 12;
        OWNED(iso_pyramid) p = build(&v, &opt);
        assert_int_equal(p.level_count, cases[c].levels);
    }
}

TEST(thread_counts_give_the_same_bytes)
{
    OWNED(iso_volume) v = noise(17, 13, 11);
    for (int filter = 0; filter < ISO_DIRECTION_COUNT; ++filter) {
        iso_pyramid_options opt = keeping(filter);
        opt.scalar_filter = filter % ISO_SCALAR_COUNT;
        opt.threads = 1;
        OWNED(iso_pyramid) one = build(&v, &opt);
        opt.threads = 3;
        OWNED(iso_pyramid) three = build(&v, &opt);
        assert_true(same_levels(&one, &three));
        three.levels[1].codes[5] ^= 1; /* the comparison must see one bit */
        assert_false(same_levels(&one, &three));
    }
}

/* Straight from the rows (fit, snorm) or by triples, with the floats or without: the bytes of the encoder. A shift
 * by one voxel, the planted fault, is not what is stored. */
TEST(codes_are_those_of_the_directions_of_their_level)
{
    OWNED(iso_volume) v = noise(13, 9, 10);
    for (iso_code code = 0; code < ISO_CODE_COUNT; ++code)
        for (iso_direction_filter f = 0; f < ISO_DIRECTION_COUNT && iso_code_describe(code)->is_textured; ++f) {
            iso_pyramid_options opt = keeping(f), bare = opt;
            opt.code = bare.code = code;
            bare.keep_float = bare.keep_magnitude = false;
            OWNED(iso_pyramid) p = build(&v, &opt), q = build(&v, &bare);
            for (size_t k = 0; k < p.level_count; ++k) {
                const iso_level *level = &p.levels[k];
                const size_t count = iso_geometry_voxel_count(&level->geometry);
                FREED uint8_t *wanted = malloc(3 * count);
                iso_code_encode(code, level->directions, wanted, count);
                assert_memory_equal(level->codes, wanted, 3 * count);
                assert_memory_equal(q.levels[k].codes, wanted, 3 * count);
                if (count > 8) {
                    iso_code_encode(code, level->directions + 3, wanted, count - 1);
                    assert_true(memcmp(level->codes, wanted, 3 * (count - 1)) != 0);
                }
            }
        }
}

TEST(bad_options_and_voxels_are_refused)
{
    OWNED(iso_volume) v = noise(4, 4, 4);
    iso_pyramid p;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 0;
    assert_status(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err), ISO_E_RANGE);
    opt = iso_pyramid_defaults();
    opt.gauss_sigma_voxels = NAN;
    assert_status(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err), ISO_E_RANGE);
    opt = iso_pyramid_defaults();
    opt.gauss_radius = 0;
    assert_status(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err), ISO_E_RANGE);
    opt = iso_pyramid_defaults();
    ((float *)v.data)[9] = NAN;
    assert_status(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err), ISO_E_RANGE);
    ((float *)v.data)[9] = INFINITY;
    assert_status(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err), ISO_E_RANGE);
    iso_pyramid_destroy(&p); /* empty after a failure */
}

TEST_MAIN(make_folder, remove_folder)
