/* SPDX-License-Identifier: MIT */
/* What the pyramid's directions promise by their structure, whatever the volume. Each promise is also put to something
 * that breaks it, so that the test is seen to notice.
 *
 *   exactness     a constant gradient is kept, at borders, odd sizes and on sheared grids; order 2 on smooth fields
 *   cone          a filtered direction lies among those that it is made of, and L is at least the cone's cosine
 *   coherence     length 1 where all agree, 0 where they cancel
 *   covariance    turned, mirrored, exchanged axes; V to aV + b; shifts by 2^k voxels
 *   linearity     moments of a level are sums of the next finer one's, not of what is stored
 *   locality      own children: a voxel reaches what lies above its stencil, and nothing else
 *
 * Sums over threads and slabs: test_pyramid.c, test_stream.c. */
#include "pyramids.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- shared ---- */

static iso_vec3 direction_at(const iso_level *l, size_t i)
{
    return iso_v3((double)l->directions[3 * i], (double)l->directions[3 * i + 1], (double)l->directions[3 * i + 2]);
}

/* Turned, sheared and of unequal spacing. */
static iso_geometry oblique(size_t nx, size_t ny, size_t nz)
{
    iso_geometry g = plain(nx, ny, nz);
    const double c = cos(0.6), s = sin(0.6);
    g.index_to_world = (iso_mat3){{{c, -0.75 * s, 0.4}, {s, 0.75 * c, 0}, {0.2, 0, 2.5}}};
    return g;
}

/* Gradients within a cone about x: slopes along y and z below 1/2 a step. */
static iso_volume cone_volume(const iso_geometry *g)
{
    iso_volume v;
    assert_ok(iso_volume_create(&v, g, ISO_F32, "test", &err));
    for (size_t i = 0; i < iso_geometry_voxel_count(g); ++i) {
        size_t at[3];
        place(g, i, at);
        ((float *)v.data)[i] = (float)((double)at[0] + 0.2 * sin((double)at[1]) + 0.5 * cos((double)at[2]));
    }
    return v;
}

/* ---- exactness ---- */

TEST(a_constant_gradient_is_kept_at_every_level)
{
    const iso_geometry g = oblique(9, 7, 11);
    const iso_vec3 slope = iso_v3(0.8, -1.1, 0.5), unit = iso_normalize(slope);
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "test", &err));
    for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i) {
        size_t at[3];
        place(&g, i, at);
        const iso_vec3 index = iso_v3((double)at[0] + 0.5, (double)at[1] + 0.5, (double)at[2] + 0.5);
        ((float *)v.data)[i] = (float)iso_dot(slope, iso_geometry_to_world(&g, index));
    }
    for (int filter = 0; filter < ISO_DIRECTION_COUNT; ++filter) {
        iso_pyramid_options opt = keeping((iso_direction_filter)filter);
        opt.gauss_radius = 3;
        OWNED(iso_pyramid) p = build(&v, &opt);
        for (size_t k = 0; k < p.level_count; ++k)
            for (size_t i = 0; i < iso_geometry_voxel_count(&p.levels[k].geometry); ++i) {
                /* values up to 30 in float, differences of about 1: 30 times 2^-24, and some sums */
                assert_at_most(iso_norm(iso_sub(direction_at(&p.levels[k], i), unit)), 1e-5);
                assert_within(p.levels[k].magnitude[i], iso_norm(slope), 1e-5);
            }
    }
    /* the fault: index gradients taken to the world as if they were points */
    const iso_vec3 index_slope = iso_mul(iso_mat3_transpose(g.index_to_world), slope);
    assert_more_than(iso_norm(iso_sub(iso_normalize(iso_mul(g.index_to_world, index_slope)), unit)), 0.1);
}

static double smooth(iso_vec3 p, iso_vec3 *gradient)
{
    *gradient = iso_v3(2 * cos(2 * p.x) - sin(1.5 * p.y + p.x),
                       -1.5 * sin(1.5 * p.y + p.x) + 0.7 * cos(1.7 * p.z + p.y), 1.19 * cos(1.7 * p.z + p.y));
    return sin(2 * p.x) + cos(1.5 * p.y + p.x) + 0.7 * sin(1.7 * p.z + p.y);
}

/* Root mean square of |gradient| sin(angle to the truth) over a level's voxels that no border reaches. */
static double smooth_error(size_t n, size_t level, iso_direction_filter filter, iso_gradient_method method)
{
    const double spacing[3] = {2.0 / (double)n, 2.0 / (double)n, 2.0 / (double)n};
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){n, n, n}, spacing);
    iso_volume v;
    iso_vec3 gradient;
    assert_ok(iso_volume_create(&v, &g, ISO_F64, "test", &err));
    for (size_t i = 0; i < n * n * n; ++i) {
        size_t at[3];
        place(&g, i, at);
        ((double *)v.data)[i] = smooth(iso_geometry_to_world(&g, iso_v3((double)at[0] + 0.5, (double)at[1] + 0.5,
                                                                        (double)at[2] + 0.5)),
                                       &gradient);
    }
    iso_pyramid_options opt = keeping(filter);
    opt.gradient.method = method;
    opt.level_count = level + 1;
    iso_pyramid p = build(&v, &opt);
    const iso_level *l = &p.levels[level];
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        size_t at[3];
        bool inside = true;
        place(&l->geometry, i, at);
        for (int a = 0; a < 3; ++a) /* the same part of the field at every size */
            inside = inside && 4 * at[a] >= l->geometry.size[a] && 4 * (at[a] + 1) <= 3 * l->geometry.size[a];
        if (!inside)
            continue;
        smooth(iso_geometry_to_world(&l->geometry,
                                     iso_v3((double)at[0] + 0.5, (double)at[1] + 0.5, (double)at[2] + 0.5)),
               &gradient);
        sum += pow(iso_norm(iso_cross(iso_normalize(direction_at(l, i)), gradient)), 2);
        ++count;
    }
    iso_pyramid_destroy(&p);
    iso_volume_destroy(&v);
    return sqrt(sum / (double)count);
}

TEST(directions_of_smooth_fields_converge_with_order_2)
{
    for (int filter = 0; filter < ISO_DIRECTION_COUNT; ++filter)
        for (size_t level = 1; level < 3; ++level) {
            const double coarse = smooth_error(32, level, (iso_direction_filter)filter, ISO_GRADIENT_CENTRAL);
            const double fine = smooth_error(64, level, (iso_direction_filter)filter, ISO_GRADIENT_CENTRAL);
            assert_more_than(log2(coarse / fine), 1.8); /* 2 in the limit */
        }
    /* the fault: differences to the next sample belong half a voxel further, which is of order 1 */
    const double coarse = smooth_error(32, 1, ISO_DIRECTION_MOMENTS, ISO_GRADIENT_INTERMEDIATE);
    const double fine = smooth_error(64, 1, ISO_DIRECTION_MOMENTS, ISO_GRADIENT_INTERMEDIATE);
    assert_at_most(log2(coarse / fine), 1.5);
}

/* ---- the cone ---- */

static size_t outside_cone(const iso_level *l, double cosine)
{
    size_t count = 0;
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i)
        count += !(iso_normalize(direction_at(l, i)).x > cosine - 1e-6); /* float rounding */
    return count;
}

/* Vectors of a cone, weighed by positive numbers, stay in it; so does the main axis of their tensor where the cone's
 * half angle is below 45 degrees, as T then maps the cone into itself (Perron and Frobenius). */
TEST(directions_stay_in_the_cone_of_their_children)
{
    const iso_geometry g = plain(16, 15, 17);
    OWNED(iso_volume) v = cone_volume(&g);
    const struct {
        iso_direction_filter filter;
        size_t radius, exponent;
    } cases[] = {{ISO_DIRECTION_MOMENTS, 2, 1}, {ISO_DIRECTION_NAIVE, 2, 1}, {ISO_DIRECTION_TENSOR, 2, 1},
                 {ISO_DIRECTION_EQ1, 1, 1},     {ISO_DIRECTION_EQ1, 3, 0},   {ISO_DIRECTION_EQ1, 2, 4}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        iso_pyramid_options opt = keeping(cases[c].filter);
        opt.gauss_radius = cases[c].radius;
        opt.eq1_exponent = cases[c].exponent;
        OWNED(iso_pyramid) p = build(&v, &opt);
        double cosine = 1;
        for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i)
            cosine = fmin(cosine, direction_at(&p.levels[0], i).x);
        assert_more_than(cosine, sqrt(0.5));
        for (size_t k = 1; k < p.level_count; ++k) {
            assert_int_equal(outside_cone(&p.levels[k], cosine), 0);
            for (size_t i = 0; i < iso_geometry_voxel_count(&p.levels[k].geometry); ++i) {
                const double length = iso_norm(direction_at(&p.levels[k], i));
                if (cases[c].filter == ISO_DIRECTION_MOMENTS)
                    assert_more_than(sqrt(length), cosine - 1e-6); /* L^2 is stored */
                if (cases[c].filter == ISO_DIRECTION_TENSOR)
                    assert_more_than(length, cosine - 1e-6); /* L is */
            }
        }
        /* the fault: a filter that sharpens, which has a negative weight */
        iso_level *l = &p.levels[1];
        float *d = l->directions;
        for (size_t i = 3 * iso_geometry_voxel_count(&l->geometry); i-- > 3;)
            d[i] = 3 * d[i] - 2 * d[i - 3];
        assert_true(outside_cone(l, cosine) > 0);
    }
}

/* ---- coherence ---- */

TEST(parallel_gradients_keep_their_length)
{
    iso_geometry g = plain(8, 6, 4);
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &g, ISO_U8, "test", &err));
    for (size_t i = 0; i < 192; ++i)
        ((uint8_t *)v.data)[i] = (uint8_t)(20 * (i % 8));
    iso_pyramid_options opt = keeping(ISO_DIRECTION_MOMENTS);
    iso_pyramid p = build(&v, &opt);
    for (size_t k = 0; k < p.level_count; ++k)
        for (size_t i = 0; i < iso_geometry_voxel_count(&p.levels[k].geometry); ++i) {
            const int8_t *code = (const int8_t *)p.levels[k].codes + 3 * i;
            assert_within(p.levels[k].directions[3 * i], 1, 1e-6); /* float rounding */
            assert_true(code[0] == 127 && code[1] == 0 && code[2] == 0);
        }
    iso_pyramid_destroy(&p);
    ((uint8_t *)v.data)[8 * 6 + 3] += 40; /* the fault: one voxel that sticks out */
    p = build(&v, &opt);
    assert_at_most(p.levels[1].directions[3 * 1], 0.9);
    iso_pyramid_destroy(&p);
}

/* 0 1 1 0 repeated has the gradients + + - - of one length: level 1 keeps them, level 2 has nothing left. */
TEST(opposite_gradients_cancel)
{
    iso_geometry g = plain(16, 4, 4);
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &g, ISO_U8, "test", &err));
    for (size_t i = 0; i < 256; ++i)
        ((uint8_t *)v.data)[i] = (uint8_t)((i % 4 + 1) / 2 % 2);
    iso_pyramid_options opt = keeping(ISO_DIRECTION_MOMENTS);
    iso_pyramid p = build(&v, &opt);
    for (size_t x = 1; x < 7; ++x) /* away from the border, whose differences are one-sided */
        assert_true(fabsf(p.levels[1].directions[3 * x]) == 1);
    for (size_t x = 1; x < 3; ++x) {
        assert_true(p.levels[2].directions[3 * x] == 0 && p.levels[2].magnitude[x] == 0.5f);
        assert_true(p.levels[2].codes[3 * x] == 0);
    }
    iso_pyramid_destroy(&p);
    ((uint8_t *)v.data)[16 + 6] = 2; /* the fault: one side steeper than the other */
    p = build(&v, &opt);
    assert_more_than(fabs((double)p.levels[2].directions[3]) + fabs((double)p.levels[2].directions[4]), 1e-3);
    iso_pyramid_destroy(&p);
}

TEST(volumes_without_gradients_have_no_directions)
{
    const size_t sizes[][3] = {{1, 1, 1}, {5, 1, 1}, {1, 4, 7}, {6, 6, 6}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; ++s)
        for (int filter = 0; filter < ISO_DIRECTION_COUNT; ++filter) {
            iso_geometry g = plain(sizes[s][0], sizes[s][1], sizes[s][2]);
            OWNED(iso_volume) v;
            assert_ok(iso_volume_create(&v, &g, ISO_F32, "test", &err));
            for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i)
                ((float *)v.data)[i] = 7.5f;
            iso_pyramid_options opt = keeping(filter);
            OWNED(iso_pyramid) p = build(&v, &opt);
            for (size_t k = 0; k < p.level_count; ++k)
                for (size_t i = 0; i < iso_geometry_voxel_count(&p.levels[k].geometry); ++i) {
                    const float *d = p.levels[k].directions + 3 * i;
                    assert_true(d[0] == 0 && d[1] == 0 && d[2] == 0 && p.levels[k].magnitude[i] == 0);
                    assert_true(p.levels[k].scalar[i] == 7.5f);
                }
        }
}

/* ---- covariance ---- */

static double largest_turned_difference(const iso_pyramid *p, const iso_pyramid *q, iso_mat3 turn)
{
    double largest = 0;
    for (size_t k = 0; k < p->level_count; ++k)
        for (size_t i = 0; i < iso_geometry_voxel_count(&p->levels[k].geometry); ++i) {
            const double d = iso_norm(
                iso_sub(iso_mul(turn, direction_at(&p->levels[k], i)), direction_at(&q->levels[k], i)));
            if (!(d <= largest))
                largest = d;
        }
    return largest;
}

TEST(turning_the_grid_turns_the_directions)
{
    const iso_vec3 a = iso_normalize(iso_v3(1, 2, -0.5));
    const double c = cos(0.9), s = sin(0.9), t = 1 - c;
    const iso_mat3 turn = {{{c + t * a.x * a.x, t * a.x * a.y - s * a.z, t * a.x * a.z + s * a.y},
                            {t * a.y * a.x + s * a.z, c + t * a.y * a.y, t * a.y * a.z - s * a.x},
                            {t * a.z * a.x - s * a.y, t * a.z * a.y + s * a.x, c + t * a.z * a.z}}};
    iso_geometry g = oblique(10, 9, 8), turned = g;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) {
            turned.index_to_world.m[row][column] = 0;
            for (int i = 0; i < 3; ++i)
                turned.index_to_world.m[row][column] += turn.m[row][i] * g.index_to_world.m[i][column];
        }
    for (int filter = 0; filter < ISO_DIRECTION_COUNT; ++filter) {
        /* one main axis everywhere: where two are as good, the tensor's choice follows no rotation */
        OWNED(iso_volume) v = cone_volume(&g), w = cone_volume(&turned);
        const iso_pyramid_options opt = keeping((iso_direction_filter)filter);
        OWNED(iso_pyramid) p = build(&v, &opt), q = build(&w, &opt);
        assert_at_most(largest_turned_difference(&p, &q, turn), 1e-5); /* another matrix of floats: some roundings */
        assert_more_than(largest_turned_difference(&p, &q, iso_mat3_transpose(turn)), 0.1);
    }
}

/* (x, y, z) becomes (z, x, y): sizes, spacings and samples alike. */
TEST(exchanging_axes_exchanges_components)
{
    const iso_geometry g = plain(10, 9, 8);
    iso_geometry other = iso_geometry_axis_aligned((size_t[]){8, 10, 9}, (double[]){2.5, 1, 0.75});
    const iso_mat3 turn = {{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}};
    for (int filter = 0; filter < ISO_DIRECTION_COUNT; ++filter) {
        OWNED(iso_volume) v = cone_volume(&g), w;
        assert_ok(iso_volume_create(&w, &other, ISO_F32, "test", &err));
        for (size_t i = 0; i < 720; ++i) {
            size_t at[3];
            place(&g, i, at);
            ((float *)w.data)[(at[1] * 10 + at[0]) * 8 + at[2]] = ((float *)v.data)[i];
        }
        const iso_pyramid_options opt = keeping((iso_direction_filter)filter);
        OWNED(iso_pyramid) p = build(&v, &opt), q = build(&w, &opt);
        double largest = 0, unturned = 0;
        for (size_t k = 0; k < p.level_count; ++k) {
            const size_t *n = q.levels[k].geometry.size;
            for (size_t i = 0; i < iso_geometry_voxel_count(&p.levels[k].geometry); ++i) {
                size_t at[3];
                place(&p.levels[k].geometry, i, at);
                const iso_vec3 a = direction_at(&p.levels[k], i),
                               b = direction_at(&q.levels[k], (at[1] * n[1] + at[0]) * n[0] + at[2]);
                largest = fmax(largest, iso_norm(iso_sub(iso_mul(turn, a), b)));
                unturned = fmax(unturned, iso_norm(iso_sub(a, b)));
            }
        }
        assert_at_most(largest, 1e-5); /* sums in another order */
        assert_more_than(unturned, 0.1);
    }
}

/* Mirrored volumes give mirrored bytes: pairs are summed alike in either order. */
TEST(flipping_an_axis_flips_the_codes)
{
    const size_t n[3] = {8, 16, 12};
    for (int axis = 0; axis < 3; ++axis)
        for (int filter = 0; filter < ISO_DIRECTION_COUNT; ++filter) {
            OWNED(iso_volume) v = noise(n[0], n[1], n[2]), w = noise(n[0], n[1], n[2]);
            for (size_t i = 0; i < n[0] * n[1] * n[2]; ++i) {
                size_t at[3];
                place(&v.geometry, i, at);
                at[axis] = n[axis] - 1 - at[axis];
                ((float *)w.data)[(at[2] * n[1] + at[1]) * n[0] + at[0]] = ((float *)v.data)[i];
            }
            iso_pyramid_options opt = keeping(filter);
            opt.level_count = 3;
            OWNED(iso_pyramid) p = build(&v, &opt), q = build(&w, &opt);
            /* Taps of a Gaussian and of a tent are summed in one order: a last bit may fall across a code's border. */
            const int tolerance = filter == ISO_DIRECTION_EQ1 || filter == ISO_DIRECTION_LEAST_SQUARES;
            size_t unflipped = 0; /* the fault: the voxels move, their directions do not turn */
            for (size_t k = 0; k < 3; ++k) {
                const iso_geometry *g = &p.levels[k].geometry;
                for (size_t i = 0; i < iso_geometry_voxel_count(g); ++i) {
                    size_t at[3];
                    place(g, i, at);
                    at[axis] = g->size[axis] - 1 - at[axis];
                    const int8_t *a = (const int8_t *)p.levels[k].codes + 3 * i;
                    const int8_t *b = (const int8_t *)q.levels[k].codes +
                                      3 * ((at[2] * g->size[1] + at[1]) * g->size[0] + at[0]);
                    unflipped += abs(a[axis] - b[axis]) > tolerance;
                    for (int c = 0; c < 3; ++c)
                        assert_true(abs(a[c] - (c == axis ? -b[c] : b[c])) <= tolerance);
                }
            }
            assert_true(unflipped > 100);
        }
}

/* Codes of p that differ from those of q, or from their opposites, by more than `tolerance` anywhere. */
static size_t codes_apart(const iso_pyramid *p, const iso_pyramid *q, bool opposite, int tolerance)
{
    size_t count = 0;
    for (size_t k = 0; k < p->level_count; ++k)
        for (size_t i = 0; i < 3 * iso_geometry_voxel_count(&p->levels[k].geometry); ++i) {
            int a = ((int8_t *)p->levels[k].codes)[i], b = ((int8_t *)q->levels[k].codes)[i];
            count += abs(a - (opposite ? -b : b)) > tolerance;
        }
    return count;
}

TEST(scaling_and_offsetting_the_values_changes_no_direction)
{
    const struct {
        double a, b;
    } maps[] = {{0x1p-90, 0}, {0x1p+100, 0}, {3, 0}, {-1, 0}, {0.25, 0.5}};
    for (int filter = 0; filter < ISO_DIRECTION_COUNT; ++filter) {
        OWNED(iso_volume) v = noise(9, 8, 10), w = noise(9, 8, 10);
        const iso_pyramid_options opt = keeping((iso_direction_filter)filter);
        iso_pyramid p = build(&v, &opt), q;
        for (size_t m = 0; m < sizeof maps / sizeof *maps; ++m) {
            for (size_t i = 0; i < 720; ++i)
                ((float *)w.data)[i] = (float)(maps[m].a * ((float *)v.data)[i] + maps[m].b);
            q = build(&w, &opt);
            /* 3 V is rounded once more than V: a last bit may fall across a code's border. */
            assert_int_equal(codes_apart(&p, &q, maps[m].a < 0, maps[m].a == 3), 0);
            iso_pyramid_destroy(&q);
        }
        for (size_t i = 0; i < 720; ++i) /* the fault: a map that is not linear */
            ((float *)w.data)[i] = powf(((float *)v.data)[i], 1.1f);
        q = build(&w, &opt);
        assert_true(codes_apart(&p, &q, false, 1) > 100);
        iso_pyramid_destroy(&q);
        iso_pyramid_destroy(&p);
    }
}

/* Voxels of level k, away from both ends, whose codes are not those `shift` fine voxels further. */
static size_t codes_not_shifted(const iso_pyramid *p, const iso_pyramid *q, size_t k, size_t shift, size_t margin)
{
    const size_t *m = p->levels[k].geometry.size, s = shift >> k;
    size_t count = 0;
    for (size_t row = 0; row < m[1] * m[2]; ++row)
        for (size_t x = margin; x + s + margin < m[0]; ++x)
            count += memcmp(q->levels[k].codes + 3 * (row * m[0] + x), p->levels[k].codes + 3 * (row * m[0] + x + s),
                            3) != 0;
    return count;
}

TEST(shifting_by_whole_coarse_voxels_shifts_the_codes)
{
    const size_t shift = 8, count = 64 * 12 * 9;
    for (int filter = 0; filter < ISO_DIRECTION_COUNT; ++filter) {
        OWNED(iso_volume) v = noise(64, 12, 9), w = noise(64, 12, 9);
        for (size_t i = 0; i + shift < count; ++i)
            ((float *)w.data)[i] = ((float *)v.data)[i + shift];
        const iso_pyramid_options opt = keeping((iso_direction_filter)filter);
        iso_pyramid p = build(&v, &opt), q = build(&w, &opt);
        /* what the ends reach: a stencil's voxel, the kernels of all levels below, or a tent and three rounds */
        for (size_t k = 0; k < 4; ++k)
            assert_int_equal(codes_not_shifted(&p, &q, k, shift,
                                               filter == ISO_DIRECTION_EQ1             ? 3
                                               : filter == ISO_DIRECTION_LEAST_SQUARES ? 5
                                               : k == 3                                ? 1
                                                                                       : (size_t)1 << (3 - k)),
                             0);
        /* the fault: half of a voxel of level 3 */
        for (size_t i = 0; i + 4 < count; ++i)
            ((float *)w.data)[i] = ((float *)v.data)[i + 4];
        iso_pyramid_destroy(&q);
        q = build(&w, &opt);
        assert_true(codes_not_shifted(&p, &q, 3, 4, 1) > 10);
        iso_pyramid_destroy(&p);
        iso_pyramid_destroy(&q);
    }
}

/* ---- linearity and locality ---- */

/* Levels of moments from what is stored of the next finer one: N = (d / |d|) L S with L = sqrt |d|, S = magnitude^2;
 * or, which is the fault, from its directions alone. The largest distance from what the build gave. */
static double moments_from_below(const iso_pyramid *p, bool directions_alone)
{
    double largest = 0;
    for (size_t k = 2; k < p->level_count; ++k) {
        const iso_level *fine = &p->levels[k - 1], *l = &p->levels[k];
        const size_t *n = fine->geometry.size;
        for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
            size_t at[3];
            iso_vec3 sum = {0, 0, 0};
            double square = 0;
            place(&l->geometry, i, at);
            for (size_t child = 0; child < 8; ++child) {
                size_t c[3];
                for (size_t a = 0; a < 3; ++a) {
                    c[a] = 2 * at[a] + (child >> a & 1);
                    c[a] = c[a] < n[a] ? c[a] : n[a] - 1;
                }
                const size_t j = (c[2] * n[1] + c[1]) * n[0] + c[0];
                const iso_vec3 d = direction_at(fine, j);
                const double s = directions_alone ? 1 : (double)fine->magnitude[j] * (double)fine->magnitude[j];
                sum = iso_madd(sum, iso_normalize(d), directions_alone ? 1 : sqrt(iso_norm(d)) * s);
                square += s;
            }
            const double coherence = iso_norm(sum) / square;
            largest = fmax(largest,
                           iso_norm(iso_sub(iso_scale(iso_normalize(sum), coherence * coherence), direction_at(l, i))));
        }
    }
    return largest;
}

TEST(moments_are_sums_of_those_below_and_not_of_stored_directions)
{
    OWNED(iso_volume) v = noise(19, 16, 13);
    const iso_pyramid_options opt = keeping(ISO_DIRECTION_MOMENTS);
    OWNED(iso_pyramid) p = build(&v, &opt);
    assert_at_most(moments_from_below(&p, false), 1e-5); /* floats taken apart and put together */
    assert_more_than(moments_from_below(&p, true), 0.1);
}

/* Voxels of coarse levels that differ although none of the stencil of fine voxel `changed` lies below them. */
static size_t changed_elsewhere(const iso_pyramid *p, const iso_pyramid *q, const size_t changed[3])
{
    size_t count = 0;
    for (size_t k = 0; k < p->level_count; ++k)
        for (size_t i = 0; i < iso_geometry_voxel_count(&p->levels[k].geometry); ++i) {
            size_t at[3];
            bool above = false;
            place(&p->levels[k].geometry, i, at);
            for (int s = 0; s < 6; ++s) {
                size_t fine[3] = {changed[0], changed[1], changed[2]};
                fine[s / 2] += s % 2 ? 1 : (size_t)-1;
                above = above || (fine[0] >> k == at[0] && fine[1] >> k == at[1] && fine[2] >> k == at[2]);
            }
            count += !above &&
                     memcmp(p->levels[k].directions + 3 * i, q->levels[k].directions + 3 * i, 3 * sizeof(float)) != 0;
        }
    return count;
}

TEST(a_voxel_reaches_only_what_lies_above_its_stencil)
{
    const size_t changed[3] = {13, 8, 7};
    for (int filter = 0; filter < ISO_DIRECTION_COUNT; ++filter) {
        OWNED(iso_volume) v = noise(24, 20, 16);
        const iso_pyramid_options opt = keeping((iso_direction_filter)filter);
        OWNED(iso_pyramid) p = build(&v, &opt);
        ((float *)v.data)[(changed[2] * 20 + changed[1]) * 24 + changed[0]] += 3;
        OWNED(iso_pyramid) q = build(&v, &opt);
        /* four taps an axis; tents and neighbors' systems: what breaks the promise, and is known to */
        if (filter == ISO_DIRECTION_EQ1 || filter == ISO_DIRECTION_LEAST_SQUARES)
            assert_true(changed_elsewhere(&p, &q, changed) > 10);
        else
            assert_int_equal(changed_elsewhere(&p, &q, changed), 0);
        assert_true(memcmp(p.levels[1].directions, q.levels[1].directions, 3 * 12 * 10 * 8 * sizeof(float)) != 0);
    }
}

TEST_MAIN(NULL, NULL)
