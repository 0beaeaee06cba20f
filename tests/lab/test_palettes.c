/* SPDX-License-Identifier: MIT */
/* The palettes of the paper and their rivals: fixed tables against closed forms, the order of the paper's Table 1,
 * degenerate input, the annealed mesh. */
#include "lab/rivals/palettes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lab/rivals/palette_mesh.h"
#include "lab/rivals/palette_tables.h"
#include "tests/palette_fits.h"

static iso_rival_options few_steps(iso_palette_rival method, size_t directions)
{
    iso_rival_options opt = iso_rival_defaults();
    opt.method = method;
    opt.fit.directions = directions;
    opt.fit.swap_trials = 4;
    opt.anneal.cycles = 40;
    opt.anneal.steps = 400;
    opt.anneal.temp_fac = 0.85;
    return opt;
}

static iso_palette rival(const iso_direction_set *set, iso_palette_rival method, size_t directions)
{
    const iso_rival_options opt = few_steps(method, directions);
    iso_palette p;
    assert_ok(iso_rival_palette_fit(set, &opt, &p, &err));
    return p;
}

static double fitted_norm1(const iso_direction_set *set, iso_palette_rival method, size_t directions)
{
    OWNED(iso_palette) p = rival(set, method, directions);
    double norm1 = norm1_of(set, &p);
    return norm1;
}

TEST(regular_subdivision_has_the_published_counts)
{
    const size_t faces[] = {60, 240, 960, 3840};
    for (int level = 0; level < 4; ++level)
        assert_int_equal(iso_subdivision_faces(level), faces[level]);
    OWNED(iso_direction_set) none = set_of(NULL, NULL, 0);
    OWNED(iso_palette) p = rival(&none, ISO_RIVAL_FACES, 1022); /* the largest level that is not above */
    assert_int_equal(p.count, 961);
}

TEST(fixed_tables_cover_the_sphere)
{
    OWNED(iso_direction_set) set = random_directions();
    OWNED(iso_palette) p = rival(&set, ISO_RIVAL_FACES, 254);
    expect_a_cover(&set, &p);
}

/* Half of the faces of a centrally symmetric table are the others' opposites. */
TEST(regular_faces_come_in_opposite_pairs)
{
    float xyz[3 * 240];
    assert_ok(iso_palette_subdivide(1, xyz, &err));
    for (size_t i = 0; i < 240; ++i) {
        double best = 1;
        for (size_t j = 0; j < 240; ++j)
            best = fmin(best, (double)(xyz[3 * i] * xyz[3 * j] + xyz[3 * i + 1] * xyz[3 * j + 1] +
                                       xyz[3 * i + 2] * xyz[3 * j + 2]));
        assert_within(best, -1, 1e-6); /* floats */
    }
}

/* Table 1's shape: 254 annealed entries beat 240 regular ones by more than 2 (3.4 and 5.2 in the paper), and the
 * default beats annealing. */
TEST(methods_rank_as_published)
{
    FREED float *v = ellipsoid(2000);
    OWNED(iso_direction_set) set = set_of(v, NULL, 2000);
    double regular = fitted_norm1(&set, ISO_RIVAL_FACES, 254), annealed = fitted_norm1(&set, ISO_RIVAL_ANNEAL, 254);
    assert_more_than(regular, 2 * annealed);
    assert_more_than(annealed, fitted_norm1(&set, ISO_RIVAL_KMEANS, 254));
}

/* The product's default does not reach its errors by this: tests/test_palette.c has the limit. */
TEST(a_simpler_relative_misses_the_default_s_limit)
{
    FREED float *v = ellipsoid(ELLIPSOID);
    OWNED(iso_direction_set) set = set_of(v, NULL, ELLIPSOID);
    assert_more_than(fitted_norm1(&set, ISO_RIVAL_KMEANSPP, 254), 3.95);
}

TEST(entries_are_the_resultants_of_their_directions)
{
    FREED float *v = ellipsoid(600);
    OWNED(iso_direction_set) set = set_of(v, NULL, 600);
    OWNED(iso_palette) p = rival(&set, ISO_RIVAL_KMEANSPP, 20);
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
}

TEST(fits_repeat_and_follow_their_seed)
{
    FREED float *v = ellipsoid(800);
    OWNED(iso_direction_set) set = set_of(v, NULL, 800);
    for (int m = 0; m <= ISO_RIVAL_ANNEAL; ++m) {
        OWNED(iso_palette) a = rival(&set, (iso_palette_rival)m, 40), b = rival(&set, (iso_palette_rival)m, 40);
        assert_memory_equal(a.xyz, b.xyz, 3 * a.count * sizeof *a.xyz);
    }
}

TEST(no_direction_at_all_gives_the_zero_vector_alone)
{
    const float v[] = {0, 0, 0, NAN, 1, 0, INFINITY, 0, 0, 0, -0.0f, 0};
    OWNED(iso_direction_set) set = set_of(v, NULL, 4);
    assert_int_equal(set.count, 0);
    assert_within(set.undefined_weight, 4, 0);
    for (int m = 0; m < ISO_RIVAL_COUNT; ++m) {
        OWNED(iso_palette) p = rival(&set, (iso_palette_rival)m, 64);
        expect_the_zero_vector(&set, &p, v, 4);
        if (m < ISO_RIVAL_ANNEAL)
            assert_int_equal(p.count, 1);
    }
}

TEST(fewer_directions_than_entries_are_kept_exactly)
{
    /* Five vectors, three directions: lengths do not matter. */
    const float v[] = {2, 0, 0, 0, 0, -3, 4, 0, 0, 0.6f, 0.8f, 0, 1e-30f, 0, 0};
    OWNED(iso_direction_set) set = set_of(v, NULL, 5);
    assert_int_equal(set.count, 3);
    for (int m = 0; m < ISO_RIVAL_ANNEAL; ++m) {
        OWNED(iso_palette) p = rival(&set, (iso_palette_rival)m, 254);
        assert_int_equal(p.count, 4);
        assert_within(norm1_of(&set, &p), 0, 1e-14); /* the square of a float's rounding */
    }
}

/* Two opposite directions in one cluster cancel: the entry must stay finite. */
TEST(opposite_directions_in_one_entry_stay_finite)
{
    const float v[] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0};
    OWNED(iso_direction_set) set = set_of(v, NULL, 4);
    for (int m = 0; m < ISO_RIVAL_ANNEAL; ++m)
        for (size_t k = 1; k < 4; ++k) {
            OWNED(iso_palette) p = rival(&set, (iso_palette_rival)m, k);
            for (size_t i = 3; i < 3 * p.count; ++i)
                assert_true(isfinite(p.xyz[i]));
            assert_at_most(norm1_of(&set, &p), 4);
        }
}

TEST(a_tessellation_turns_to_the_only_direction)
{
    float v[3 * 100] = {0};
    for (size_t i = 0; i < 100; ++i)
        v[3 * i + 1] = (float)(i + 1);
    OWNED(iso_direction_set) set = set_of(v, NULL, 100);
    OWNED(iso_palette) p = rival(&set, ISO_RIVAL_ANNEAL, 60);
    assert_int_equal(p.count, 61);
    assert_at_most(norm1_of(&set, &p), 100 * (1 - cos(0.05)));
}

TEST(bad_options_are_refused)
{
    const float v[] = {1, 0, 0};
    iso_palette p;
    OWNED(iso_direction_set) set = set_of(v, NULL, 1);
    iso_rival_options opt = few_steps(ISO_RIVAL_FACES, 59);
    assert_status(iso_rival_palette_fit(&set, &opt, &p, &err), ISO_E_RANGE);
    opt.method = ISO_RIVAL_ANNEAL; /* an odd number of triangles */
    assert_status(iso_rival_palette_fit(&set, &opt, &p, &err), ISO_E_RANGE);
    opt.fit.directions = 60;
    opt.anneal.start_prob = 1;
    assert_status(iso_rival_palette_fit(&set, &opt, &p, &err), ISO_E_RANGE);
    opt.anneal.start_prob = 0.2;
    opt.anneal.temp_fac = NAN;
    assert_status(iso_rival_palette_fit(&set, &opt, &p, &err), ISO_E_RANGE);
}

/* ---- the annealed mesh --------------------------------------------------------------------------- */

TEST(moved_mesh_stays_convex_and_reverts_exactly)
{
    iso_random random = {2};
    mesh m;
    size_t kept = 0, refused = 0;
    assert_ok(iso_mesh_create_random(&m, 120, &random, &err));
    assert_int_equal(m.vertex_count, 62); /* Euler: faces / 2 + 2 */
    assert_true(iso_mesh_is_convex(&m));
    FREED mesh_triangle *before = malloc(m.triangle_count * sizeof *before);
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
    iso_mesh_destroy(&m);
}

TEST(annealing_lowers_its_own_error_and_the_nearest_is_not_worse)
{
    FREED float *v = ellipsoid(1500);
    OWNED(iso_direction_set) set = set_of(v, NULL, 1500);
    iso_rival_options opt = iso_rival_defaults();
    opt.fit.directions = 100;
    double assigned[2];
    for (int run = 0; run < 2; ++run) {
        OWNED(iso_palette) p;
        OWNED(iso_tessellation) t;
        opt.anneal.cycles = run ? 30 : 0;
        opt.anneal.steps = 500;
        opt.anneal.temp_fac = 0.8;
        assert_ok(iso_rival_palette_anneal(&set, &opt, &p, &t, &err));
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
    }
    assert_more_than(assigned[0], 1.5 * assigned[1]);
}

TEST_MAIN(NULL, NULL)
