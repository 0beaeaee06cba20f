/* SPDX-License-Identifier: MIT */
/* Least-squares directions: against the dense system in double precision, and by what they promise. Slabs, resumed
 * builds and ranks: test_stream.c, check_ranks.sh. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "pyramids.h"

/* As in pyramid/cascade_weighted.c. */
enum { ROUNDS = 3 };
static const double least = 0.15;

/* A level's dense system: A looks the level up, clamped and trilinear, at the centers of n fine voxels. */
typedef struct dense {
    size_t n, m;
    double *a, *w, *d; /* n x m, n, n x 3 */
} dense;

static double tent(size_t fine, size_t k, size_t coarse_count, size_t j)
{
    const double at = fmin(fmax(((double)fine + 0.5) / ldexp(1, (int)k) - 0.5, 0), (double)coarse_count - 1);
    return fmax(0, 1 - fabs(at - (double)j));
}

/* Of the directions and magnitudes that the pyramid keeps of level 0. */
static dense dense_of(const iso_pyramid *p, size_t k)
{
    const iso_level *fine = &p->levels[0], *coarse = &p->levels[k];
    dense s = {iso_geometry_voxel_count(&fine->geometry), iso_geometry_voxel_count(&coarse->geometry), NULL, NULL, NULL};
    s.a = malloc(s.n * s.m * sizeof *s.a);
    s.w = malloc(s.n * sizeof *s.w);
    s.d = malloc(3 * s.n * sizeof *s.d);
    for (size_t i = 0; i < s.n; ++i) {
        size_t x[3], j[3];
        place(&fine->geometry, i, x);
        s.w[i] = pow((double)fine->magnitude[i], 2);
        for (size_t c = 0; c < 3; ++c)
            s.d[3 * i + c] = (double)fine->directions[3 * i + c];
        for (size_t v = 0; v < s.m; ++v) {
            place(&coarse->geometry, v, j);
            s.a[i * s.m + v] = 1;
            for (int axis = 0; axis < 3; ++axis)
                s.a[i * s.m + v] *= tent(x[axis], k, coarse->geometry.size[axis], j[axis]);
        }
    }
    return s;
}

static void destroy(dense *s)
{
    free(s->a);
    free(s->w);
    free(s->d);
}

/* residual = W^-1 A^T w (d - A x) of one component. */
static void residual_of(const dense *s, size_t c, const double *x, double *residual)
{
    FREED double *weight = calloc(s->m, sizeof *weight);
    memset(residual, 0, s->m * sizeof *residual);
    for (size_t i = 0; i < s->n; ++i) {
        double e = s->d[3 * i + c];
        for (size_t v = 0; v < s->m; ++v)
            e -= s->a[i * s->m + v] * x[v];
        for (size_t v = 0; v < s->m; ++v) {
            residual[v] += s->a[i * s->m + v] * s->w[i] * e;
            weight[v] += s->a[i * s->m + v] * s->w[i];
        }
    }
    for (size_t v = 0; v < s->m; ++v)
        residual[v] /= weight[v];
}

/* The same rounds; x: m. */
static void iterate(const dense *s, size_t c, size_t rounds, double *x)
{
    const double middle = (1 + least) / 2, half = (1 - least) / 2, sigma = middle / half;
    FREED double *residual = malloc(s->m * sizeof *residual), *step = calloc(s->m, sizeof *step);
    double rho = 1 / sigma;
    memset(x, 0, s->m * sizeof *x);
    for (size_t round = 0; round <= rounds; ++round) {
        const double next = 1 / (2 * sigma - rho);
        const double keep = round > 1 ? next * rho : 0, gain = round == 0 ? 1
                                                               : round == 1 ? 1 / middle
                                                                            : 2 * next / half;
        if (round > 1)
            rho = next;
        residual_of(s, c, x, residual);
        for (size_t v = 0; v < s->m; ++v) {
            step[v] = keep * step[v] + gain * residual[v];
            x[v] += step[v];
        }
    }
}

/* sum w |A D - d|^2, 3 floats a voxel: of D itself, or stored as D |D|. */
static double misfit(const dense *s, const float *values, bool stored)
{
    double sum = 0, *directions = malloc(3 * s->m * sizeof *directions);
    for (size_t v = 0; v < s->m; ++v) {
        const float *d = values + 3 * v;
        const double length = sqrt(pow((double)d[0], 2) + pow((double)d[1], 2) + pow((double)d[2], 2));
        for (size_t c = 0; c < 3; ++c)
            directions[3 * v + c] = (double)d[c] / (stored && length > 0 ? sqrt(length) : 1);
    }
    for (size_t i = 0; i < s->n; ++i)
        for (size_t c = 0; c < 3; ++c) {
            double e = s->d[3 * i + c];
            for (size_t v = 0; v < s->m; ++v)
                e -= s->a[i * s->m + v] * directions[3 * v + c];
            sum += s->w[i] * e * e;
        }
    free(directions);
    return sum;
}

/* Of waves longer than some voxels: what neighbors agree on is most of it. */
static iso_volume waves(size_t nx, size_t ny, size_t nz, double noise_part)
{
    iso_volume v = noise(nx, ny, nz);
    for (size_t i = 0; i < nx * ny * nz; ++i) {
        size_t at[3];
        place(&v.geometry, i, at);
        ((float *)v.data)[i] = (float)(sin(0.5 * (double)at[0]) + cos(0.4 * (double)at[1] + 0.3 * (double)at[2]) +
                                       noise_part * (double)((float *)v.data)[i]);
    }
    return v;
}

/* The largest distance of a level's directions from those of so many rounds. */
static double largest_difference(const dense *s, const float *directions, size_t rounds)
{
    double *x[3], largest = 0;
    for (size_t c = 0; c < 3; ++c) {
        x[c] = malloc(s->m * sizeof *x[c]);
        iterate(s, c, rounds, x[c]);
    }
    for (size_t i = 0; i < s->m; ++i) {
        const double length = sqrt(x[0][i] * x[0][i] + x[1][i] * x[1][i] + x[2][i] * x[2][i]),
                     factor = length > 1 ? 1 / length : length;
        for (size_t c = 0; c < 3; ++c)
            largest = fmax(largest, fabs((double)directions[3 * i + c] - x[c][i] * factor));
    }
    for (size_t c = 0; c < 3; ++c)
        free(x[c]);
    return largest;
}

TEST(levels_are_the_rounds_of_the_dense_system)
{
    iso_volume v = noise(9, 10, 27); /* at level 1 two blocks of planes, at level 2 one, overhanging */
    iso_pyramid_options opt = keeping(ISO_DIRECTION_LEAST_SQUARES);
    opt.level_count = 3;
    OWNED(iso_pyramid) p = build(&v, &opt);
    for (size_t k = 1; k < 3; ++k) {
        dense s = dense_of(&p, k);
        /* floats: sums of some hundred terms, amplified by the rounds */
        assert_at_most(largest_difference(&s, p.levels[k].directions, ROUNDS), 2e-5);
        assert_more_than(largest_difference(&s, p.levels[k].directions, ROUNDS - 1), 1e-3); /* the fault: one too few */
        destroy(&s);
    }
    iso_volume_destroy(&v);
}

/* Nearer to level 0's directions than moments are, by the sum that is made small; and not far above the least. */
VALUES_TEST(the_misfit_is_below_that_of_moments)
{
    const double parts[] = {0, 0.2, 1};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) {
        OWNED(iso_volume) v = waves(12, 11, 10, parts[i]);
        const iso_pyramid_options moments = keeping(ISO_DIRECTION_MOMENTS), opt = keeping(ISO_DIRECTION_LEAST_SQUARES);
        OWNED(iso_pyramid) p = build(&v, &moments), q = build(&v, &opt);
        for (size_t k = 1; k < 3; ++k) {
            dense s = dense_of(&q, k);
            FREED float *solved = malloc(3 * s.m * sizeof *solved);
            FREED double *x = malloc(s.m * sizeof *x);
            for (size_t c = 0; c < 3; ++c) {
                iterate(&s, c, 400, x);
                for (size_t j = 0; j < s.m; ++j)
                    solved[3 * j + c] = (float)x[j];
            }
            const double mine = misfit(&s, q.levels[k].directions, true),
                         theirs = misfit(&s, p.levels[k].directions, true), lowest = misfit(&s, solved, false);
            assert_at_most(mine, theirs);
            assert_at_most(lowest, mine * (1 + 1e-6));
            assert_at_most(mine - lowest, 0.75 * (theirs - lowest));
            destroy(&s);
        }
    }
}

TEST(directions_are_no_longer_than_1_and_magnitudes_those_of_moments)
{
    OWNED(iso_volume) v = noise(17, 13, 21);
    const iso_pyramid_options moments = keeping(ISO_DIRECTION_MOMENTS), opt = keeping(ISO_DIRECTION_LEAST_SQUARES);
    OWNED(iso_pyramid) p = build(&v, &moments), q = build(&v, &opt);
    size_t at_limit = 0;
    for (size_t k = 1; k < q.level_count; ++k)
        for (size_t i = 0; i < iso_geometry_voxel_count(&q.levels[k].geometry); ++i) {
            const float *d = q.levels[k].directions + 3 * i;
            const double length = sqrt((double)d[0] * (double)d[0] + (double)d[1] * (double)d[1] +
                                       (double)d[2] * (double)d[2]);
            assert_at_most(length, 1 + 1e-6);
            at_limit += length > 1 - 1e-6;
            assert_true(p.levels[k].magnitude[i] == q.levels[k].magnitude[i]);
        }
    assert_true(at_limit > 0); /* the limit is needed */
}

/* Half of the volume is flat: no directions there, and none that leak far in. */
TEST(a_flat_part_has_none)
{
    OWNED(iso_volume) v = noise(40, 8, 8);
    for (size_t i = 0; i < 40 * 8 * 8; ++i)
        if (i % 40 >= 16)
            ((float *)v.data)[i] = 0.5f;
    iso_pyramid_options opt = keeping(ISO_DIRECTION_LEAST_SQUARES);
    opt.level_count = 2;
    OWNED(iso_pyramid) p = build(&v, &opt);
    size_t empty = 0;
    for (size_t i = 0; i < 20 * 4 * 4; ++i) { /* gradients end at fine voxel 16, in coarse voxel 8; a tent reaches 9 */
        const float *d = p.levels[1].directions + 3 * i;
        const bool is_zero = d[0] == 0 && d[1] == 0 && d[2] == 0;
        empty += is_zero;
        assert_true(is_zero == (i % 20 > 8));
    }
    assert_int_equal(empty, 11 * 16);
}

/* Voxels of 32 and more have moments, as doc/method/least-squares-levels.md says. */
TEST(levels_above_the_fourth_have_moments)
{
    OWNED(iso_volume) v = noise(70, 5, 3);
    iso_pyramid_options moments = keeping(ISO_DIRECTION_MOMENTS), opt = keeping(ISO_DIRECTION_LEAST_SQUARES);
    moments.level_count = opt.level_count = 7;
    OWNED(iso_pyramid) p = build(&v, &moments), q = build(&v, &opt);
    assert_true(q.level_count > 5);
    for (size_t k = 0; k < q.level_count; ++k) {
        const size_t bytes = 3 * iso_geometry_voxel_count(&q.levels[k].geometry) * sizeof(float);
        assert_true((memcmp(p.levels[k].directions, q.levels[k].directions, bytes) == 0) == (k == 0 || k > 4));
    }
}

TEST_MAIN(NULL, NULL)
