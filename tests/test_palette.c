/* SPDX-License-Identifier: MIT */
/* Palettes: fixed tables against closed forms, fits against brute force, degenerate input, the annealed mesh. */
#define _GNU_SOURCE
#include "palette/palette.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/random.h"
#include "palette/palette_mesh.h"
#include "palette/palette_regular.h"
#include "palette_fits.h"
#include "test.h"
#include "volume/synthetic.h"

static double fitted_norm1(const iso_direction_set *set, iso_palette_method method, size_t directions)
{
    iso_palette p = fit(set, method, directions);
    double norm1 = norm1_of(set, &p);
    iso_palette_destroy(&p);
    return norm1;
}

/* ---- fixed tables ------------------------------------------------------------------------ */

static void regular_subdivision_has_the_published_counts(void **state)
{
    (void)state;
    const size_t faces[] = {60, 240, 960, 3840}, vertices[] = {32, 122, 482, 1922};
    for (int level = 0; level < 4; ++level) {
        assert_int_equal(iso_subdivision_faces(level), faces[level]);
        assert_int_equal(iso_subdivision_vertices(level), vertices[level]);
    }
    iso_direction_set none = set_of(NULL, NULL, 0);
    iso_palette p = fit(&none, ISO_PALETTE_FACES, 1022); /* the largest level that is not above */
    assert_int_equal(p.count, 961);
    iso_palette_destroy(&p);
    p = fit(&none, ISO_PALETTE_VERTICES, 254);
    assert_int_equal(p.count, 123);
    iso_palette_destroy(&p);
    iso_direction_set_destroy(&none);
}

/* Every fixed table: unit entries, the zero vector first, and no direction farther away than a covering of its size
 * may leave: the equal-area cap's angle is 2 asin(sqrt(1 / n)); a good table stays within twice of it, Glassner's
 * codes, stretched at the disc's edge, within six times. */
static void fixed_tables_cover_the_sphere(void **state)
{
    (void)state;
    const iso_palette_method methods[] = {ISO_PALETTE_FACES, ISO_PALETTE_VERTICES, ISO_PALETTE_FIBONACCI,
                                          ISO_PALETTE_GRID, ISO_PALETTE_SPIRAL};
    iso_random random = {7};
    float *v = malloc(3 * 4000 * sizeof *v);
    for (size_t i = 0; i < 4000; ++i)
        random_unit(&random, v + 3 * i);
    iso_direction_set set = set_of(v, NULL, 4000);
    for (size_t m = 0; m < 5; ++m) {
        iso_palette p = fit(&set, methods[m], 254);
        iso_palette_error e;
        assert_true(p.xyz[0] == 0 && p.xyz[1] == 0 && p.xyz[2] == 0);
        for (size_t i = 1; i < p.count; ++i) {
            const float *n = p.xyz + 3 * i;
            assert_within(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-6); /* rounding of floats */
        }
        assert_ok(iso_palette_measure(&set, &p, &e, &err));
        double cap = 2 * asin(sqrt(1.0 / (double)(p.count - 1))) * 180 / acos(-1);
        assert_at_most(e.max_deg, (m < 3 ? 2 : 6) * cap);
        iso_palette_destroy(&p);
    }
    iso_direction_set_destroy(&set);
    free(v);
}

/* Half of the faces of a centrally symmetric table are the others' opposites. */
static void regular_faces_come_in_opposite_pairs(void **state)
{
    (void)state;
    float xyz[3 * 240];
    assert_ok(iso_palette_subdivide(1, true, xyz, &err));
    for (size_t i = 0; i < 240; ++i) {
        double best = 1;
        for (size_t j = 0; j < 240; ++j)
            best = fmin(best, (double)(xyz[3 * i] * xyz[3 * j] + xyz[3 * i + 1] * xyz[3 * j + 1] +
                                       xyz[3 * i + 2] * xyz[3 * j + 2]));
        assert_within(best, -1, 1e-6); /* floats */
    }
}

/* ---- fits -------------------------------------------------------------------------------- */

static void default_reaches_the_errors_asked_for_on_the_ellipsoid(void **state)
{
    (void)state;
    float *v = ellipsoid(ELLIPSOID);
    iso_direction_set set = set_of(v, NULL, ELLIPSOID);
    const size_t sizes[] = {254, 1022};
    const double limits[] = {3.95, 0.51}; /* what swaps of centroids gave a prototype, and a little */
    for (int i = 0; i < 2; ++i)
        assert_at_most(fitted_norm1(&set, ISO_PALETTE_KMEANS, sizes[i]), limits[i]);
    /* Power: the simpler relatives must fail the same limit. */
    assert_more_than(fitted_norm1(&set, ISO_PALETTE_KMEANSPP, 254), limits[0]);
    assert_more_than(fitted_norm1(&set, ISO_PALETTE_LLOYD, 254), limits[0]);
    iso_direction_set_destroy(&set);
    free(v);
}

/* Table 1's shape: 254 annealed entries beat 240 regular ones by more than 2 (3.4 and 5.2 in the paper), and the
 * default beats annealing. */
static void methods_rank_as_published(void **state)
{
    (void)state;
    float *v = ellipsoid(2000);
    iso_direction_set set = set_of(v, NULL, 2000);
    double regular = fitted_norm1(&set, ISO_PALETTE_FACES, 254), annealed = fitted_norm1(&set, ISO_PALETTE_ANNEAL, 254);
    double kmeans = fitted_norm1(&set, ISO_PALETTE_KMEANS, 254), lbg = fitted_norm1(&set, ISO_PALETTE_LBG, 254);
    assert_more_than(regular, 2 * annealed);
    assert_more_than(annealed, kmeans);
    assert_more_than(lbg, kmeans);
    iso_direction_set_destroy(&set);
    free(v);
}

static void entries_are_the_resultants_of_their_directions(void **state)
{
    (void)state;
    float *v = ellipsoid(600);
    iso_direction_set set = set_of(v, NULL, 600);
    iso_palette p = fit(&set, ISO_PALETTE_KMEANSPP, 20);
    iso_palette_lookup *lookup;
    uint16_t index[600];
    double sums[21][3] = {{0}};
    assert_ok(iso_palette_lookup_create(&p, &lookup, &err));
    iso_palette_assign(lookup, set.xyz, index, set.count);
    for (size_t i = 0; i < set.count; ++i)
        for (size_t c = 0; c < 3; ++c)
            sums[index[i]][c] += (double)set.xyz[3 * i + c];
    for (size_t k = 1; k < p.count; ++k) {
        double n = sqrt(sums[k][0] * sums[k][0] + sums[k][1] * sums[k][1] + sums[k][2] * sums[k][2]), dot = 0;
        for (size_t c = 0; c < 3; ++c)
            dot += sums[k][c] / n * (double)p.xyz[3 * k + c];
        assert_within(dot, 1, 1e-6); /* a fixed point of Lloyd's, up to floats */
    }
    iso_palette_lookup_destroy(lookup);
    iso_palette_destroy(&p);
    iso_direction_set_destroy(&set);
    free(v);
}

static void fits_repeat_and_follow_their_seed(void **state)
{
    (void)state;
    float *v = ellipsoid(800);
    iso_direction_set set = set_of(v, NULL, 800);
    for (int m = 0; m <= ISO_PALETTE_ANNEAL; ++m) {
        iso_palette a = fit(&set, (iso_palette_method)m, 40), b = fit(&set, (iso_palette_method)m, 40);
        assert_memory_equal(a.xyz, b.xyz, 3 * a.count * sizeof *a.xyz);
        iso_palette_destroy(&a);
        iso_palette_destroy(&b);
    }
    iso_direction_set_destroy(&set);
    free(v);
}

static void multiplicity_is_the_same_as_repetition(void **state)
{
    (void)state;
    enum { N = 300 };
    float *v = ellipsoid(N), *repeated = malloc(3 * 3 * N * sizeof *repeated);
    double weights[N];
    size_t used = 0;
    for (size_t i = 0; i < N; ++i) {
        weights[i] = (double)(1 + i % 3);
        for (size_t k = 0; k < 1 + i % 3; ++k)
            memcpy(repeated + 3 * used++, v + 3 * i, 3 * sizeof *v);
    }
    iso_direction_set a = set_of(v, weights, N), b = set_of(repeated, NULL, used);
    assert_int_equal(a.count, b.count);
    assert_memory_equal(a.xyz, b.xyz, 3 * a.count * sizeof *a.xyz);
    assert_memory_equal(a.weight, b.weight, a.count * sizeof *a.weight); /* sums of small whole numbers: exact */
    iso_direction_set_destroy(&a);
    iso_direction_set_destroy(&b);
    free(v);
    free(repeated);
}

/* Weights move entries: the half of the sphere that counts a hundred times more gets the smaller error. */
static void weights_draw_entries(void **state)
{
    (void)state;
    enum { N = 3000 };
    float v[3 * N];
    double weights[N];
    iso_random random = {3};
    for (size_t i = 0; i < N; ++i) {
        random_unit(&random, v + 3 * i);
        weights[i] = v[3 * i] > 0 ? 100 : 1;
    }
    iso_direction_set plain = set_of(v, NULL, N), weighted = set_of(v, weights, N);
    iso_palette p = fit(&plain, ISO_PALETTE_KMEANS, 60), w = fit(&weighted, ISO_PALETTE_KMEANS, 60);
    assert_more_than(0.75 * norm1_of(&weighted, &p), norm1_of(&weighted, &w));
    assert_more_than(norm1_of(&plain, &w), norm1_of(&plain, &p));
    iso_palette_destroy(&p);
    iso_palette_destroy(&w);
    iso_direction_set_destroy(&plain);
    iso_direction_set_destroy(&weighted);
}

/* ---- degenerate input ----------------------------------------------------------------------- */

static void no_direction_at_all_gives_the_zero_vector_alone(void **state)
{
    (void)state;
    const float v[] = {0, 0, 0, NAN, 1, 0, INFINITY, 0, 0, 0, -0.0f, 0};
    iso_direction_set set = set_of(v, NULL, 4);
    assert_int_equal(set.count, 0);
    assert_within(set.undefined_weight, 4, 0);
    for (int m = 0; m < ISO_PALETTE_METHOD_COUNT; ++m) {
        iso_palette p = fit(&set, (iso_palette_method)m, 64);
        iso_palette_lookup *lookup;
        uint16_t index[4];
        assert_ok(iso_palette_lookup_create(&p, &lookup, &err));
        iso_palette_assign(lookup, v, index, 4);
        for (int i = 0; i < 4; ++i)
            assert_int_equal(index[i], 0);
        if (m < ISO_PALETTE_ANNEAL)
            assert_int_equal(p.count, 1);
        assert_within(norm1_of(&set, &p), 0, 0);
        iso_palette_lookup_destroy(lookup);
        iso_palette_destroy(&p);
    }
    iso_direction_set_destroy(&set);
}

static void fewer_directions_than_entries_are_kept_exactly(void **state)
{
    (void)state;
    /* Five vectors, three directions: lengths do not matter. */
    const float v[] = {2, 0, 0, 0, 0, -3, 4, 0, 0, 0.6f, 0.8f, 0, 1e-30f, 0, 0};
    iso_direction_set set = set_of(v, NULL, 5);
    assert_int_equal(set.count, 3);
    for (int m = 0; m < ISO_PALETTE_ANNEAL; ++m) {
        iso_palette p = fit(&set, (iso_palette_method)m, 254);
        assert_int_equal(p.count, 4);
        assert_within(norm1_of(&set, &p), 0, 1e-14); /* the square of a float's rounding */
        iso_palette_destroy(&p);
    }
    iso_direction_set_destroy(&set);
}

static void all_one_direction_is_one_entry(void **state)
{
    (void)state;
    float v[3 * 100];
    for (size_t i = 0; i < 100; ++i) {
        v[3 * i] = 0;
        v[3 * i + 1] = (float)(i + 1);
        v[3 * i + 2] = 0;
    }
    iso_direction_set set = set_of(v, NULL, 100);
    iso_palette p = fit(&set, ISO_PALETTE_KMEANS, 254);
    assert_int_equal(p.count, 2);
    assert_within(p.xyz[4], 1, 0);
    iso_palette_destroy(&p);
    /* A tessellation keeps its triangles, and turns one of them to the only direction. */
    p = fit(&set, ISO_PALETTE_ANNEAL, 60);
    assert_int_equal(p.count, 61);
    assert_at_most(norm1_of(&set, &p), 100 * (1 - cos(0.05)));
    iso_palette_destroy(&p);
    iso_direction_set_destroy(&set);
}

/* Two opposite directions in one cluster cancel: the entry must stay finite. */
static void opposite_directions_in_one_entry_stay_finite(void **state)
{
    (void)state;
    const float v[] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0};
    iso_direction_set set = set_of(v, NULL, 4);
    for (int m = 0; m < ISO_PALETTE_ANNEAL; ++m)
        for (size_t k = 1; k < 4; ++k) {
            iso_palette p = fit(&set, (iso_palette_method)m, k);
            for (size_t i = 3; i < 3 * p.count; ++i)
                assert_true(isfinite(p.xyz[i]));
            assert_at_most(norm1_of(&set, &p), 4);
            iso_palette_destroy(&p);
        }
    iso_direction_set_destroy(&set);
}

static void bad_options_and_weights_are_refused(void **state)
{
    (void)state;
    const float v[] = {1, 0, 0};
    const double negative = -1, nan = NAN;
    iso_direction_set set;
    iso_palette p;
    assert_status(iso_direction_set_create(&set, v, &negative, 1, &err), ISO_E_RANGE);
    assert_status(iso_direction_set_create(&set, v, &nan, 1, &err), ISO_E_RANGE);
    set = set_of(v, NULL, 1);
    iso_palette_options opt = iso_palette_defaults();
    opt.directions = 0;
    assert_status(iso_palette_fit(&set, &opt, &p, NULL, &err), ISO_E_RANGE);
    opt.directions = ISO_PALETTE_MAX + 1;
    assert_status(iso_palette_fit(&set, &opt, &p, NULL, &err), ISO_E_RANGE);
    opt.directions = 59;
    opt.method = ISO_PALETTE_FACES;
    assert_status(iso_palette_fit(&set, &opt, &p, NULL, &err), ISO_E_RANGE);
    opt.method = ISO_PALETTE_ANNEAL; /* an odd number of triangles */
    assert_status(iso_palette_fit(&set, &opt, &p, NULL, &err), ISO_E_RANGE);
    opt.directions = 60;
    opt.anneal.start_prob = 1;
    assert_status(iso_palette_fit(&set, &opt, &p, NULL, &err), ISO_E_RANGE);
    opt.anneal.start_prob = 0.2;
    opt.anneal.temp_fac = NAN;
    assert_status(iso_palette_fit(&set, &opt, &p, NULL, &err), ISO_E_RANGE);
    iso_palette_method method;
    assert_status(iso_palette_method_from_name("median-cut", &method, &err), ISO_E_USAGE);
    iso_direction_set_destroy(&set);
}

/* ---- the annealed mesh --------------------------------------------------------------------------- */

static void moved_mesh_stays_convex_and_reverts_exactly(void **state)
{
    (void)state;
    iso_random random = {2};
    mesh m;
    size_t kept = 0, refused = 0;
    assert_ok(iso_mesh_create_random(&m, 120, &random, &err));
    assert_int_equal(m.vertex_count, 62); /* Euler: faces / 2 + 2 */
    assert_true(iso_mesh_is_convex(&m));
    mesh_triangle *before = malloc(m.triangle_count * sizeof *before);
    for (int i = 0; i < 2000; ++i) {
        uint32_t vertex = (uint32_t)iso_random_below(&random, m.vertex_count);
        memcpy(before, m.triangle, m.triangle_count * sizeof *before);
        iso_vec3 position = m.position[vertex];
        bool moved = iso_mesh_move(&m, vertex, 0.1 + 1.2 * iso_random_unit(&random), &random);
        if (moved && i % 3) {
            assert_true(m.patch_count >= 3);
            iso_mesh_keep(&m);
            ++kept;
        } else {
            refused += !moved;
            if (moved)
                iso_mesh_revert(&m);
            assert_memory_equal(before, m.triangle, m.triangle_count * sizeof *before);
            assert_memory_equal(&position, &m.position[vertex], sizeof position);
        }
        if (i % 50 == 0)
            assert_true(iso_mesh_is_convex(&m));
    }
    assert_true(iso_mesh_is_convex(&m));
    assert_true(kept > 1000);
    assert_true(refused < 1000);
    /* Power: a vertex pushed across its neighbors without swaps is not convex. */
    m.position[5] = iso_scale(m.position[5], -1);
    assert_false(iso_mesh_is_convex(&m));
    free(before);
    iso_mesh_destroy(&m);
}

static void annealing_lowers_its_own_error_and_the_nearest_is_not_worse(void **state)
{
    (void)state;
    float *v = ellipsoid(1500);
    iso_direction_set set = set_of(v, NULL, 1500);
    iso_palette_options opt = iso_palette_defaults();
    opt.directions = 100;
    double assigned[2];
    for (int run = 0; run < 2; ++run) {
        iso_palette p;
        iso_tessellation t;
        opt.anneal.cycles = run ? 30 : 0;
        opt.anneal.steps = 500;
        opt.anneal.temp_fac = 0.8;
        assert_ok(iso_palette_anneal(&set, &opt, &p, &t, NULL, &err));
        assigned[run] = t.assigned_norm1;
        assert_int_equal(t.vertex_count, 52);
        assert_true(norm1_of(&set, &p) <= assigned[run] + 1e-3); /* entries rounded to floats */
        /* The error is the sum over the triangles in which the directions lie, counted again from nothing. */
        double again = 0;
        for (size_t i = 0; i < set.count; ++i) {
            const float *u = set.xyz + 3 * i;
            double best = -2, cost = 0;
            for (size_t f = 0; f < t.face_count; ++f) {
                double depth = 2;
                for (int e = 0; e < 3; ++e) {
                    const double *a = t.vertices + 3 * t.faces[f][e], *b = t.vertices + 3 * t.faces[f][(e + 1) % 3];
                    iso_vec3 n = iso_cross(iso_v3(a[0], a[1], a[2]), iso_v3(b[0], b[1], b[2]));
                    depth = fmin(depth, n.x * (double)u[0] + n.y * (double)u[1] + n.z * (double)u[2]);
                }
                if (depth > best) {
                    const float *n = p.xyz + 3 * (f + 1);
                    best = depth;
                    cost = 1 -
                           ((double)n[0] * (double)u[0] + (double)n[1] * (double)u[1] + (double)n[2] * (double)u[2]);
                }
            }
            again += cost;
        }
        assert_within(again, assigned[run], 1e-3); /* 1500 entries rounded to floats */
        iso_tessellation_destroy(&t);
        iso_palette_destroy(&p);
    }
    assert_more_than(assigned[0], 1.5 * assigned[1]);
    iso_direction_set_destroy(&set);
    free(v);
}

/* ---- norms, tables, files --------------------------------------------------------------------------- */

/* Table 1, foot, 254 normals: norm 1 3788.26, norm 2 43.52. By the paper's own Eq. 1 norm 2 were 87.04. */
static void printed_norm2_is_half_of_equation_1(void **state)
{
    (void)state;
    assert_within(sqrt(0.5 * 3788.26), 43.52, 0.005); /* two printed digits */
    const float v[] = {1, 0, 0, 0, 1, 0};
    iso_direction_set set = set_of(v, NULL, 2);
    iso_palette p;
    iso_palette_error e;
    assert_ok(iso_palette_create(&p, 1, &err));
    p.xyz[3] = 1; /* one direction hits, the other is at a right angle: 1 - cos = 1, |g - n|^2 = 2 */
    assert_ok(iso_palette_measure(&set, &p, &e, &err));
    assert_within(e.norm1, 1, 1e-12);
    assert_within(e.norm2, sqrt(2), 1e-12);
    assert_within(e.norm2_printed, sqrt(0.5), 1e-12);
    assert_within(e.max_deg, 90, 1e-6);
    iso_palette_destroy(&p);
    iso_direction_set_destroy(&set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(regular_subdivision_has_the_published_counts),
        cmocka_unit_test(fixed_tables_cover_the_sphere),
        cmocka_unit_test(regular_faces_come_in_opposite_pairs),
        cmocka_unit_test(default_reaches_the_errors_asked_for_on_the_ellipsoid),
        cmocka_unit_test(methods_rank_as_published),
        cmocka_unit_test(entries_are_the_resultants_of_their_directions),
        cmocka_unit_test(fits_repeat_and_follow_their_seed),
        cmocka_unit_test(multiplicity_is_the_same_as_repetition),
        cmocka_unit_test(weights_draw_entries),
        cmocka_unit_test(no_direction_at_all_gives_the_zero_vector_alone),
        cmocka_unit_test(fewer_directions_than_entries_are_kept_exactly),
        cmocka_unit_test(all_one_direction_is_one_entry),
        cmocka_unit_test(opposite_directions_in_one_entry_stay_finite),
        cmocka_unit_test(bad_options_and_weights_are_refused),
        cmocka_unit_test(moved_mesh_stays_convex_and_reverts_exactly),
        cmocka_unit_test(annealing_lowers_its_own_error_and_the_nearest_is_not_worse),
        cmocka_unit_test(printed_norm2_is_half_of_equation_1),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
