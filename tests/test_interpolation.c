/* SPDX-License-Identifier: MIT */
/* Gather and scatter between a coarse grid and fine voxels: the sampler's interpolation, and its transpose. */
#include "test.h"

#include "base/random.h"
#include "fit/interpolation.h"
#include "render/sampler.h"

/* Sizes that overhang, that do not, flat ones, and one that is smaller than a coarse voxel. */
static const size_t sizes[][3] = {{16, 24, 8}, {19, 13, 22}, {37, 5, 9},  {1, 1, 1},
                                  {3, 70, 1},  {33, 1, 2},   {64, 31, 17}};
enum { SIZE_COUNT = sizeof sizes / sizeof sizes[0], LEVELS = 5 };

static float *random_grid(size_t count, iso_random *random)
{
    float *grid = malloc(count * sizeof *grid);
    for (size_t i = 0; i < count; ++i)
        grid[i] = (float)(iso_random_unit(random) - 0.5);
    return grid;
}

/* fine and coarse grids of random numbers for each size and level in turn */
typedef struct grids {
    iso_interpolation map;
    float *fine, *coarse;
} grids;

static void make_grids(grids *g, const size_t size[3], size_t level, uint64_t seed)
{
    iso_random random = (iso_random){seed};
    assert_ok(iso_interpolation_create(&g->map, size, level, &err));
    g->fine = random_grid(g->map.fine_count, &random);
    g->coarse = random_grid(g->map.coarse_count, &random);
}

static void drop_grids(grids *g)
{
    free(g->fine);
    free(g->coarse);
    iso_interpolation_destroy(&g->map);
}

#define FOR_ALL_GRIDS(g) \
    for (size_t s_ = 0; s_ < SIZE_COUNT; ++s_) \
        for (size_t level = 0; level < LEVELS; ++level) \
            for (bool once_ = (make_grids(&(g), sizes[s_], level, 1 + s_ * LEVELS + level), true); once_; \
                 once_ = (drop_grids(&(g)), false))

/* A level over the fine grid, for the sampler. */
static iso_level level_of(const grids *g, size_t level, iso_geometry *fine)
{
    const size_t size[3] = {g->map.axis[0].fine_size, g->map.axis[1].fine_size, g->map.axis[2].fine_size};
    *fine = iso_geometry_axis_aligned(size, (const double[]){1, 0.7, 2.5});
    iso_level l = {.geometry = *fine, .scalar = g->coarse, .min = -0.5, .max = 0.5};
    for (size_t k = 0; k < level; ++k)
        l.geometry = iso_geometry_coarser(&l.geometry);
    return l;
}

TEST(gather_is_what_the_sampler_shows)
{
    grids g;
    FOR_ALL_GRIDS(g)
    {
        iso_geometry fine;
        const iso_level l = level_of(&g, level, &fine);
        OWNED(iso_sampler) sampler;
        assert_ok(iso_sampler_create(&sampler, &l, (iso_code){0}, ISO_FROM_ON_THE_FLY, &err));
        assert_ok(iso_interpolation_gather(&g.map, g.coarse, g.fine, 0, &err));
        size_t i = 0;
        for (size_t z = 0; z < fine.size[2]; ++z)
            for (size_t y = 0; y < fine.size[1]; ++y)
                for (size_t x = 0; x < fine.size[0]; ++x, ++i) {
                    const iso_vec3 center = iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5);
                    const iso_vec3 index = iso_geometry_to_index(&l.geometry, iso_geometry_to_world(&fine, center));
                    /* three blends of numbers below 1 in float */
                    assert_within((double)g.fine[i], iso_sample_scalar(&sampler, index), 4e-7);
                }
    }
}

TEST(scatter_is_the_transpose_of_gather)
{
    grids g;
    FOR_ALL_GRIDS(g)
    {
        FREED float *shown = malloc(g.map.fine_count * sizeof *shown),
                    *back = malloc(g.map.coarse_count * sizeof *back);
        assert_ok(iso_interpolation_gather(&g.map, g.coarse, shown, 0, &err));
        assert_ok(iso_interpolation_scatter(&g.map, g.fine, back, 0, &err));
        double left = 0, right = 0, scale = 0;
        for (size_t i = 0; i < g.map.fine_count; ++i) {
            left += (double)shown[i] * (double)g.fine[i];
            scale += fabs((double)shown[i] * (double)g.fine[i]);
        }
        for (size_t i = 0; i < g.map.coarse_count; ++i)
            right += (double)g.coarse[i] * (double)back[i];
        assert_within(left, right, 1e-6 * scale); /* sums in float, of up to 32 terms along each axis */
    }
}

/* Weights of a fine voxel sum up to 1: so does what it scatters. */
TEST(weights_sum_to_one)
{
    grids g;
    FOR_ALL_GRIDS(g)
    {
        for (size_t i = 0; i < g.map.coarse_count; ++i)
            g.coarse[i] = 0.3f;
        assert_ok(iso_interpolation_gather(&g.map, g.coarse, g.fine, 0, &err));
        for (size_t i = 0; i < g.map.fine_count; ++i)
            assert_true(g.fine[i] == 0.3f); /* exactly: blends keep equal values */
        double sum = 0;
        for (size_t i = 0; i < g.map.fine_count; ++i)
            g.fine[i] = 1;
        assert_ok(iso_interpolation_scatter(&g.map, g.fine, g.coarse, 0, &err));
        for (size_t i = 0; i < g.map.coarse_count; ++i)
            sum += (double)g.coarse[i];
        assert_within(sum, (double)g.map.fine_count, 1e-6 * (double)g.map.fine_count);
    }
}

TEST(threads_do_not_matter)
{
    grids g;
    FOR_ALL_GRIDS(g)
    {
        const size_t bytes = g.map.coarse_count * sizeof(float);
        FREED float *one = malloc(bytes), *many = malloc(bytes);
        assert_ok(iso_interpolation_scatter(&g.map, g.fine, one, 1, &err));
        for (int threads = 2; threads <= 7; threads += 5) {
            assert_ok(iso_interpolation_scatter(&g.map, g.fine, many, threads, &err));
            assert_memory_equal(one, many, bytes);
        }
    }
}

/* Two outputs from two inputs and a fine grid: products of what they show. */
typedef struct product {
    const grids *g;
    size_t called; /* voxels */
} product;

static size_t voxel_of(const grids *g, const iso_fine_row *row, size_t v)
{
    return row->x + v + g->map.axis[0].fine_size * (row->y + g->map.axis[1].fine_size * row->z);
}

static void multiply(void *context, const iso_fine_row *row)
{
    product *p = context;
    for (size_t v = 0; v < row->count; ++v) {
        const float fine = p->g->fine[voxel_of(p->g, row, v)];
        row->results[0][v] = row->values[0][v] * fine;
        row->results[1][v] = row->values[1][v] + fine;
    }
    p->called += row->count;
}

TEST(runs_that_are_not_wanted_count_as_zero)
{
    grids g;
    FOR_ALL_GRIDS(g)
    {
        const iso_interpolation *map = &g.map;
        const size_t coarse = map->coarse_count, runs = iso_interpolation_run_count(map);
        const size_t length = map->axis[0].fine_size, in_row = (length + ISO_FIT_RUN - 1) / ISO_FIT_RUN;
        iso_random random = (iso_random){level + 9};
        float *second = random_grid(coarse, &random), *out[2], *expected[2], *shown[2], *fine[2];
        for (int o = 0; o < 2; ++o) {
            out[o] = malloc(coarse * sizeof(float)), expected[o] = malloc(coarse * sizeof(float));
            shown[o] = malloc(map->fine_count * sizeof(float)), fine[o] = malloc(map->fine_count * sizeof(float));
        }
        FREED uint8_t *wanted = malloc(runs);
        for (size_t r = 0; r < runs; ++r)
            wanted[r] = iso_random_unit(&random) < 0.4;
        const float *inputs[2] = {g.coarse, second};
        product p = {.g = &g};
        const iso_interpolation_pass pass = {.input_count = 2,
                                             .output_count = 2,
                                             .inputs = inputs,
                                             .outputs = out,
                                             .function = multiply,
                                             .context = &p,
                                             .wanted = wanted};
        assert_ok(iso_interpolation_run(map, &pass, 1, &err));
        size_t called = 0;
        for (int o = 0; o < 2; ++o)
            assert_ok(iso_interpolation_gather(map, inputs[o], shown[o], 0, &err));
        for (size_t i = 0; i < map->fine_count; ++i) {
            const bool counts = wanted[i % length / ISO_FIT_RUN + in_row * (i / length)];
            called += counts;
            fine[0][i] = counts ? shown[0][i] * g.fine[i] : 0;
            fine[1][i] = counts ? shown[1][i] + g.fine[i] : 0;
        }
        assert_int_equal(p.called, called);
        for (int o = 0; o < 2; ++o) {
            assert_ok(iso_interpolation_scatter(map, fine[o], expected[o], 0, &err));
            for (size_t i = 0; i < coarse; ++i) /* the same sums: zeros do not change them */
                assert_within((double)out[o][i], (double)expected[o][i], 1e-6);
        }
        for (int o = 0; o < 2; ++o)
            free(out[o]), free(expected[o]), free(shown[o]), free(fine[o]);
        free(second);
    }
}

TEST(sizes_and_grids_beyond_the_limits_are_refused)
{
    OWNED(iso_interpolation) map;
    assert_status(iso_interpolation_create(&map, (const size_t[]){4, 0, 4}, 1, &err), ISO_E_RANGE);
    assert_status(iso_interpolation_create(&map, (const size_t[]){4, 4, 4}, 32, &err), ISO_E_RANGE);
    assert_ok(iso_interpolation_create(&map, (const size_t[]){4, 5, 6}, 1, &err));
    const iso_interpolation_pass pass = {.input_count = ISO_FIT_GRIDS + 1};
    assert_status(iso_interpolation_run(&map, &pass, 0, &err), ISO_E_RANGE);
    iso_interpolation_destroy(NULL);
}

TEST_MAIN(NULL, NULL)
