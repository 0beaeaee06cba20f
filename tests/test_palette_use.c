/* SPDX-License-Identifier: MIT */
/* What palettes are fitted to, and what is done with them: lookups, files, shading. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "palette_fits.h"
#include "volume/synthetic.h"

/* ---- the nearest entry -------------------------------------------------------------------------- */

/* How many of the directions get an entry that is farther than the nearest by more than rounding. */
static size_t wrong_assignments(const iso_palette *p, const iso_palette_lookup *lookup, const float *v, size_t count)
{
    size_t wrong = 0;
    FREED uint16_t *index = malloc(count * sizeof *index);
    iso_palette_assign(lookup, v, index, count);
    for (size_t i = 0; i < count; ++i) {
        double n = sqrt((double)v[3 * i] * (double)v[3 * i] + (double)v[3 * i + 1] * (double)v[3 * i + 1] +
                        (double)v[3 * i + 2] * (double)v[3 * i + 2]);
        double best = -2, own = -2;
        for (size_t k = 1; k < p->count; ++k) {
            double dot = 0;
            for (size_t c = 0; c < 3; ++c)
                dot += (double)v[3 * i + c] / n * (double)p->xyz[3 * k + c];
            best = fmax(best, dot);
            own = k == index[i] ? dot : own;
        }
        wrong += !(own >= best - 4e-7); /* the rounding of a dot product of floats */
    }
    return wrong;
}

TEST(lookup_finds_the_nearest_entry)
{
    enum { N = 3000 };
    FREED float *data = ellipsoid(ELLIPSOID), *v = malloc(3 * 2 * N * sizeof *v);
    iso_random random = {11};
    memcpy(v, data, 3 * N * sizeof *v);
    for (size_t i = N; i < 2 * N; ++i) {
        random_unit(&random, v + 3 * i);
        float length = i % 3 == 0 ? 1e-38f : i % 3 == 1 ? 1e37f : 1; /* lengths do not matter */
        for (size_t c = 0; c < 3; ++c) {
            v[3 * i + c] *= length;
            if (i % 7 == c)
                v[3 * i + c] = 0; /* onto the planes where the cube's faces and quarters meet */
        }
        if (i % 11 == 0)
            v[3 * i] = v[3 * i + 1]; /* and onto its edges */
    }
    OWNED(iso_direction_set) set = set_of(data, NULL, ELLIPSOID);
    const size_t sizes[] = {1, 2, 3, 17, 254, 1022};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; ++s) {
        OWNED(iso_palette) p = fit(&set, ISO_PALETTE_KMEANS, sizes[s]);
        iso_palette_lookup *lookup;
        assert_ok(iso_palette_lookup_create(&p, &lookup, &err));
        assert_int_equal(wrong_assignments(&p, lookup, v, 2 * N), 0);
        if (sizes[s] == 254) {
            /* Power: the lookup of a palette with every other entry turned by a degree is caught. */
            OWNED(iso_palette) turned = fit(&set, ISO_PALETTE_KMEANS, sizes[s]);
            for (size_t k = 1; k < turned.count; k += 2) {
                float *e = turned.xyz + 3 * k, x = e[0];
                e[0] = (float)(cos(0.0175) * (double)x - sin(0.0175) * (double)e[1]);
                e[1] = (float)(sin(0.0175) * (double)x + cos(0.0175) * (double)e[1]);
            }
            assert_true(wrong_assignments(&turned, lookup, v, 2 * N) > 0);
        }
        iso_palette_lookup_destroy(lookup);
    }
}

TEST(bytes_and_words_agree_and_decode)
{
    enum { N = 1000 };
    FREED float *v = ellipsoid(N);
    float decoded[3 * N];
    uint16_t wide[N];
    uint8_t narrow[N];
    v[3 * 5] = NAN;
    v[3 * 6] = v[3 * 6 + 1] = v[3 * 6 + 2] = 0;
    OWNED(iso_direction_set) set = set_of(v, NULL, N);
    OWNED(iso_palette) p = fit(&set, ISO_PALETTE_KMEANS, 255);
    iso_palette_lookup *lookup;
    assert_int_equal(iso_palette_bits(&p), 8);
    assert_ok(iso_palette_lookup_create(&p, &lookup, &err));
    iso_palette_assign(lookup, v, wide, N);
    iso_palette_assign8(lookup, v, narrow, N);
    for (size_t i = 0; i < N; ++i)
        assert_int_equal(wide[i], narrow[i]);
    assert_int_equal(narrow[5], 0);
    assert_int_equal(narrow[6], 0);
    wide[7] = 9999; /* beyond the palette */
    iso_palette_decode(&p, wide, decoded, N);
    assert_memory_equal(decoded, p.xyz + 3 * (size_t)wide[0], 3 * sizeof *decoded);
    assert_true(decoded[21] == 0 && decoded[22] == 0 && decoded[23] == 0);
    iso_palette_lookup_destroy(lookup);
}

/* ---- pooling ---------------------------------------------------------------------------------- */

static iso_direction_set pooled(const float *v, const float *weights, size_t count, int threads, size_t slab)
{
    iso_direction_pool *pool;
    iso_direction_set set;
    assert_ok(iso_direction_pool_create(&pool, threads, &err));
    for (size_t i = 0; i < count; i += slab)
        iso_direction_pool_add(pool, v + 3 * i, weights ? weights + i : NULL, count - i < slab ? count - i : slab);
    assert_ok(iso_direction_pool_finish(pool, &set, &err));
    iso_direction_pool_destroy(pool);
    return set;
}

static void assert_sets_equal(const iso_direction_set *a, const iso_direction_set *b)
{
    assert_int_equal(a->count, b->count);
    assert_memory_equal(a->xyz, b->xyz, 3 * a->count * sizeof *a->xyz);
    assert_memory_equal(a->weight, b->weight, a->count * sizeof *a->weight);
    assert_memory_equal(a->length, b->length, a->count * sizeof *a->length);
    assert_within(a->undefined_weight, b->undefined_weight, 0);
}

TEST(pool_does_not_depend_on_threads_or_slabs)
{
    enum { N = 20000 };
    FREED float *v = ellipsoid(N), *w = malloc(N * sizeof *w);
    iso_random random = {5};
    for (size_t i = 0; i < N; ++i) {
        w[i] = (float)iso_random_unit(&random);
        for (size_t c = 0; c < 3 && i % 17 == 0; ++c)
            v[3 * i + c] = i % 2 ? 0 : NAN;
    }
    OWNED(iso_direction_set) one = pooled(v, w, N, 1, N), many = pooled(v, w, N, 3, 777);
    assert_sets_equal(&one, &many);
    assert_more_than(one.undefined_weight, 100);
}

/* Bundling loses nothing of the error where a cell's members share an entry; what is left is fixed point (1e-7 of a
 * weight each) and cells that an entry's border crosses. */
TEST(pool_keeps_the_error)
{
    enum { N = 30000 };
    FREED float *v = ellipsoid(N);
    OWNED(iso_direction_set) exact = set_of(v, NULL, N), bundled = pooled(v, NULL, N, 2, N), coarse;
    assert_true(bundled.count < exact.count);
    assert_ok(iso_direction_set_coarsen(&bundled, 48, &coarse, &err));
    assert_true(coarse.count < bundled.count);
    OWNED(iso_palette) p = fit(&bundled, ISO_PALETTE_KMEANS, 254);
    double truth = norm1_of(&exact, &p);
    assert_within(norm1_of(&bundled, &p), truth, 0.01 * truth);
    assert_within(norm1_of(&coarse, &p), truth, 0.25 * truth);
}

static void make_volume(iso_volume *v)
{
    const size_t size[3] = {70, 66, 150}; /* more than one slab of half a million voxels */
    const double spacing[3] = {1, 0.8, 2.5};
    iso_field field = {.kind = ISO_FIELD_MARSCHNER_LOBB, .geometry = iso_geometry_axis_aligned(size, spacing)};
    assert_ok(iso_field_sample(&field, ISO_U16, v, &err));
}

TEST(streaming_a_volume_equals_the_volume_in_memory)
{
    OWNED(iso_volume) v;
    make_volume(&v);
    FREED char *dir = iso_make_temp_dir(), *path = iso_path_join(dir, "v.nrrd");
    assert_ok(iso_volume_save(&v, path, false, &err));
    iso_gradient_options gradient = iso_gradient_defaults();
    float table[2] = {0, 1};
    const iso_palette_weighting w = {.by_magnitude = true,
                                     .value_span = 65535,
                                     .by_value = table,
                                     .by_value_count = 2,
                                     .by_value_lo = 0,
                                     .by_value_hi = 65535};
    for (int weighted = 0; weighted < 2; ++weighted) {
        iso_direction_pool *a, *b;
        OWNED(iso_direction_set) in_memory, streamed;
        iso_volume_source *source;
        assert_ok(iso_direction_pool_create(&a, 1, &err));
        assert_ok(iso_direction_pool_create(&b, 2, &err));
        assert_ok(iso_palette_sample_volume(a, &v, &gradient, weighted ? &w : NULL, NULL, &err));
        assert_ok(iso_source_open(path, &source, &err));
        assert_ok(iso_palette_sample_source(b, source, &gradient, weighted ? &w : NULL, NULL, &err));
        assert_ok(iso_direction_pool_finish(a, &in_memory, &err));
        assert_ok(iso_direction_pool_finish(b, &streamed, &err));
        assert_sets_equal(&in_memory, &streamed);
        assert_true(in_memory.count > 1000);
        iso_source_close(source);
        iso_direction_pool_destroy(a);
        iso_direction_pool_destroy(b);
    }
    iso_remove_tree(dir);
}

/* A TF that shows only one half of the values: the weights of the others are 0, and they are left out. */
TEST(weights_by_value_leave_out_what_is_not_seen)
{
    const float vectors[] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, scalars[] = {0.1f, 0.7f, NAN};
    const float table[] = {0, 0, 1, 1};
    const iso_palette_weighting w = {.by_value = table, .by_value_count = 4, .by_value_lo = 0, .by_value_hi = 0.9};
    iso_direction_pool *pool;
    OWNED(iso_direction_set) set;
    assert_ok(iso_direction_pool_create(&pool, 1, &err));
    assert_ok(iso_palette_sample_field(pool, vectors, scalars, NULL, 3, &w, &err));
    assert_ok(iso_direction_pool_finish(pool, &set, &err));
    assert_int_equal(set.count, 1);
    assert_within(set.xyz[1], 1, 0);
    assert_within(set.weight[0], 1, 0);
    iso_direction_pool_destroy(pool);
}

TEST(shading_table_is_the_shading_of_each_entry)
{
    OWNED(iso_palette) p;
    assert_ok(iso_palette_create(&p, 2, &err));
    p.xyz[3] = 1;
    p.xyz[8] = -1;
    const iso_palette_light light = {{0.6, 0, 0.8}, 0.5};
    const iso_palette_shading shading = {0.2, 0.6, 0.4, 2, &light, 1, {0, 0, 1}};
    float shade[3];
    iso_palette_shade(&p, &shading, shade);
    double hh = 0.36 + 1.8 * 1.8; /* |l + v|^2 */
    assert_within(shade[0], 0.2, 1e-7);
    assert_within(shade[1], 0.2 + 0.5 * (0.6 * 0.6 + 0.4 * 0.36 / hh), 1e-7);      /* floats */
    assert_within(shade[2], 0.2 + 0.5 * (0.6 * 0.8 + 0.4 * 1.8 * 1.8 / hh), 1e-7); /* two-sided */
}

TEST(csv_survives_and_bad_ones_are_refused)
{
    FREED float *v = ellipsoid(500);
    OWNED(iso_direction_set) set = set_of(v, NULL, 500);
    OWNED(iso_palette) p = fit(&set, ISO_PALETTE_KMEANS, 30), q;
    FREED char *dir = iso_make_temp_dir(), *path = iso_path_join(dir, "p.csv");
    assert_ok(iso_palette_save_csv(&p, path, &err));
    assert_ok(iso_palette_load_csv(path, &q, &err));
    assert_int_equal(p.count, q.count);
    assert_memory_equal(p.xyz, q.xyz, 3 * p.count * sizeof *p.xyz);
    iso_palette_destroy(&q);
    const char *const bad[] = {"",
                               "index,x,y,z\n",
                               "a,b\n0,0,0,0\n",
                               "index,x,y,z\n0,0,0,1\n",
                               "index,x,y,z\n0,0,0,0\n1,1,1,0\n",
                               "index,x,y,z\n0,0,0,0\n2,1,0,0\n",
                               "index,x,y,z\n0,0,0,0\n1,nan,0,0\n",
                               "index,x,y,z\n0,0,0,0\n1,1,0\n",
                               "index,x,y,z\n0,0,0,0\n1,1,0,0 x\n"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        assert_ok(iso_file_write(path, bad[i], strlen(bad[i]), &err));
        assert_status(iso_palette_load_csv(path, &q, &err), ISO_E_FORMAT);
        assert_null(q.xyz);
    }
    iso_remove_tree(dir);
}

TEST_MAIN(NULL, NULL)
