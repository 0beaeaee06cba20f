/* SPDX-License-Identifier: MIT */
/* OpenVDB files hold what the pyramid holds, where the pyramid has it. */
#define _GNU_SOURCE
#include "lab/vdb_read.h"
#include "sampled.h"

#include <dirent.h>
#include <signal.h>
#include <sys/resource.h>

#include "base/file.h"
#include "pyramid/pyramid.h"
#include "volume/synthetic.h"

/* Unequal sizes and spacings; rotated, and sheared on request. */
static iso_geometry skew_geometry(double shear)
{
    const size_t size[3] = {40, 56, 33};
    iso_geometry g = iso_geometry_axis_aligned(size, (double[]){1, 0.8, 2.5});
    const double c = cos(0.5), s = sin(0.5);
    const iso_mat3 turn = {{{c, -s * 0.6, s * 0.8}, {s, c * 0.6, -c * 0.8}, {0, 0.8, 0.6}}};
    const double spacing[3] = {1, 0.8, 2.5};
    for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k)
            g.index_to_world.m[r][k] = turn.m[r][k] * spacing[k] + (k == 1 ? shear * turn.m[r][0] : 0);
    g.origin_mm = iso_v3(-31.25, 7.5, 100.125);
    return g;
}

static void make_pyramid(const iso_geometry *g, iso_type type, size_t levels, iso_pyramid *p)
{
    iso_field field = {.kind = ISO_FIELD_NOISE, .geometry = *g, .seed = 3};
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = levels;
    *p = sampled_pyramid(&field, type, &opt);
}

typedef struct fixture {
    char *dir, *path;
    iso_pyramid pyramid;
} fixture;

static int setup(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    f->dir = iso_make_temp_dir();
    f->path = iso_path_join(f->dir, "v.vdb");
    iso_geometry g = skew_geometry(0.3);
    make_pyramid(&g, ISO_I16, 3, &f->pyramid);
    *state = f;
    return 0;
}

static int teardown(void **state)
{
    fixture *f = *state;
    iso_pyramid_destroy(&f->pyramid);
    iso_remove_tree(f->dir);
    free(f->dir);
    free(f->path);
    free(f);
    return 0;
}

/* Voxels of the grids that differ from level k's; NaN differs. */
static size_t count_differences(const iso_pyramid *p, size_t k, const char *path, const char *density,
                                const char *gradient, double tolerance)
{
    const iso_level *level = &p->levels[k];
    size_t voxels = iso_geometry_voxel_count(&level->geometry), bad = 0;
    FREED float *read = malloc(3 * voxels * sizeof *read), *decoded = malloc(3 * voxels * sizeof *decoded);
    assert_ok(iso_vdb_load_grid(path, density, 1, level->geometry.size, read, NULL, &err));
    double scale = fmax(fabs(level->min), fabs(level->max));
    for (size_t i = 0; i < voxels; ++i)
        bad += !(fabs((double)read[i] - (double)level->scalar[i]) <= tolerance * scale);
    assert_ok(iso_vdb_load_grid(path, gradient, 3, level->geometry.size, read, NULL, &err));
    iso_code_decode_all(p->options.code, level->codes, decoded, voxels);
    for (size_t i = 0; i < 3 * voxels; ++i)
        bad += !(fabs((double)read[i] - (double)decoded[i]) <= tolerance);
    return bad;
}

TEST(every_voxel_is_equal_when_read_back)
{
    fixture *f = *state;
    iso_vdb_options opt = iso_vdb_defaults();
    assert_ok(iso_vdb_save(&f->pyramid, 0, 1, f->path, &opt, NULL, &err));
    assert_int_equal(count_differences(&f->pyramid, 0, f->path, "density", "gradient", 0), 0);
}

TEST(several_levels_are_named_by_level)
{
    fixture *f = *state;
    iso_vdb_options opt = iso_vdb_defaults();
    assert_int_equal(f->pyramid.level_count, 3);
    assert_ok(iso_vdb_save(&f->pyramid, 0, 3, f->path, &opt, NULL, &err));
    for (size_t k = 0; k < 3; ++k) {
        char density[32], gradient[32];
        snprintf(density, sizeof density, "density_level_%zu", k);
        snprintf(gradient, sizeof gradient, "gradient_level_%zu", k);
        assert_int_equal(count_differences(&f->pyramid, k, f->path, density, gradient, 0), 0);
    }
    float one[3];
    assert_status(iso_vdb_load_grid(f->path, "density", 1, (size_t[]){1, 1, 1}, one, NULL, &err), ISO_E_FORMAT);
}

/* Levels that overhang the box (odd sizes), axes rotated and sheared. */
TEST(geometry_survives)
{
    fixture *f = *state;
    iso_vdb_options opt = iso_vdb_defaults();
    for (size_t k = 0; k < 3; ++k) {
        const iso_geometry *g = &f->pyramid.levels[k].geometry;
        iso_geometry back;
        FREED float *read = malloc(iso_geometry_voxel_count(g) * sizeof *read);
        assert_ok(iso_vdb_save(&f->pyramid, k, 1, f->path, &opt, NULL, &err));
        assert_ok(iso_vdb_load_grid(f->path, "density", 1, g->size, read, &back, &err));
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c)
                assert_within(back.index_to_world.m[r][c], g->index_to_world.m[r][c], 0);
            assert_within(back.box_index[r], g->box_index[r], 0);
        }
        /* The half voxel is added and taken away again: two roundings of about 100 mm. */
        assert_within(back.origin_mm.x, g->origin_mm.x, 1e-13);
        assert_within(back.origin_mm.y, g->origin_mm.y, 1e-13);
        assert_within(back.origin_mm.z, g->origin_mm.z, 1e-13);
    }
}

/* x from its other end, and the same voxels at the same places of the world. */
TEST(a_left_handed_grid_is_stored_right_handed)
{
    fixture *f = *state;
    iso_vdb_options opt = iso_vdb_defaults();
    iso_geometry g = skew_geometry(0.3), back;
    OWNED(iso_pyramid) p;
    for (int r = 0; r < 3; ++r)
        g.index_to_world.m[r][1] = -g.index_to_world.m[r][1];
    make_pyramid(&g, ISO_I16, 2, &p);
    opt.pad_voxels = 1;
    const iso_level *l = &p.levels[1];
    const size_t *n = l->geometry.size, first = opt.pad_voxels + 1, wide[3] = {n[0] + first, n[1] + first, n[2] + first};
    const size_t voxels = iso_geometry_voxel_count(&l->geometry), all = wide[0] * wide[1] * wide[2];
    FREED float *density = malloc(all * sizeof *density), *gradient = malloc(3 * all * sizeof *gradient);
    float d[3];
    assert_true(iso_vdb_reverses_x(&l->geometry));
    assert_ok(iso_vdb_save(&p, 1, 1, f->path, &opt, NULL, &err));
    assert_ok(iso_vdb_load_grid(f->path, "density", 1, wide, density, &back, &err));
    assert_ok(iso_vdb_load_grid(f->path, "gradient", 3, wide, gradient, NULL, &err));
    assert_more_than(iso_mat3_det(back.index_to_world), 0);
    for (size_t i = 0; i < voxels; ++i) {
        const size_t x = i % n[0], y = i / n[0] % n[1], z = i / n[0] / n[1];
        const size_t at[3] = {first + n[0] - 1 - x, first + y, first + z}, j = at[0] + wide[0] * (at[1] + wide[1] * at[2]);
        assert_within(density[j], l->scalar[i], 0);
        iso_code_decode_all(p.options.code, l->codes + 3 * i, d, 1);
        for (int c = 0; c < 3; ++c)
            assert_within(gradient[3 * j + (size_t)c], d[c], 0);
        iso_vec3 here = iso_geometry_to_world(&l->geometry, iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5));
        iso_vec3 there = iso_geometry_to_world(
            &back, iso_v3((double)at[0] + 0.5, (double)at[1] + 0.5, (double)at[2] + 0.5));
        assert_at_most(iso_norm(iso_sub(here, there)), 1e-12); /* roundings of about 100 mm */
    }
}

TEST(half_floats_are_near_and_smaller)
{
    fixture *f = *state;
    iso_vdb_options opt = iso_vdb_defaults();
    char *full;
    size_t full_bytes, half_bytes;
    assert_ok(iso_vdb_save(&f->pyramid, 1, 1, f->path, &opt, NULL, &err));
    assert_ok(iso_file_read(f->path, &full, &full_bytes, &err));
    free(full);
    opt.half_float = true;
    assert_ok(iso_vdb_save(&f->pyramid, 1, 1, f->path, &opt, NULL, &err));
    assert_ok(iso_file_read(f->path, &full, &half_bytes, &err));
    free(full);
    assert_true(half_bytes < full_bytes);
    /* A half has 11 significant bits: half a step is 2^-11 of the value at most. */
    assert_int_equal(count_differences(&f->pyramid, 1, f->path, "density", "gradient", ldexp(1, -11)), 0);
    assert_true(count_differences(&f->pyramid, 1, f->path, "density", "gradient", 0) > 0);
}

/* The rim and one voxel before it have the indices from 0, and voxels stay where they are in the world. */
TEST(a_rim_moves_no_voxel)
{
    fixture *f = *state;
    iso_vdb_options opt = iso_vdb_defaults();
    opt.pad_voxels = 2;
    assert_ok(iso_vdb_save(&f->pyramid, 1, 1, f->path, &opt, NULL, &err));
    const iso_level *l = &f->pyramid.levels[1];
    const size_t *n = l->geometry.size, wide[3] = {n[0] + 6, n[1] + 6, n[2] + 6};
    FREED float *read = malloc(wide[0] * wide[1] * wide[2] * sizeof *read);
    iso_geometry back;
    assert_ok(iso_vdb_load_grid(f->path, "density", 1, wide, read, &back, &err));
    for (size_t z = 0; z < wide[2]; ++z)
        for (size_t y = 0; y < wide[1]; ++y)
            for (size_t x = 0; x < wide[0]; ++x) {
                const size_t at[3] = {x, y, z};
                size_t inside[3];
                bool background = false; /* the outermost voxels; behind it the edges are repeated twice */
                for (int a = 0; a < 3; ++a) {
                    background = background || at[a] == 0 || at[a] == wide[a] - 1;
                    inside[a] = at[a] < 3 ? 0 : at[a] - 3 < n[a] ? at[a] - 3 : n[a] - 1;
                }
                const float wanted = background ? 0 : l->scalar[inside[0] + n[0] * (inside[1] + n[1] * inside[2])];
                assert_within((double)read[x + wide[0] * (y + wide[1] * z)], (double)wanted, 0);
            }
    const iso_vec3 here = iso_geometry_to_world(&l->geometry, iso_v3(0.5, 0.5, 0.5)),
                   there = iso_geometry_to_world(&back, iso_v3(3.5, 3.5, 3.5));
    assert_at_most(iso_norm(iso_sub(here, there)), 1e-12); /* roundings of about 100 mm */
}

/* The comparison above must see a swapped axis and a shift by one voxel. */
TEST(a_swapped_axis_and_a_shift_are_seen)
{
    fixture *f = *state;
    iso_vdb_options opt = iso_vdb_defaults();
    opt.gradient = true;
    assert_ok(iso_vdb_save(&f->pyramid, 2, 1, f->path, &opt, NULL, &err));
    iso_level *level = &f->pyramid.levels[2];
    size_t voxels = iso_geometry_voxel_count(&level->geometry);
    FREED float *kept = malloc(voxels * sizeof *kept);
    memcpy(kept, level->scalar, voxels * sizeof *kept);
    memmove(level->scalar + 1, level->scalar, (voxels - 1) * sizeof *kept);
    assert_true(count_differences(&f->pyramid, 2, f->path, "density", "gradient", 0) > voxels / 2);
    const size_t *n = level->geometry.size;
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y)
            for (size_t x = 0; x < n[0]; ++x)
                level->scalar[(x * n[1] + y) * n[2] + z] = kept[(z * n[1] + y) * n[0] + x];
    assert_true(count_differences(&f->pyramid, 2, f->path, "density", "gradient", 0) > voxels / 2);
    memcpy(level->scalar, kept, voxels * sizeof *kept);
}

TEST(single_voxels_and_plates_are_kept)
{
    fixture *f = *state;
    const size_t sizes[3][3] = {{1, 1, 1}, {1, 9, 17}, {8, 1, 8}};
    for (int i = 0; i < 3; ++i) {
        OWNED(iso_pyramid) p = {0};
        iso_geometry g = iso_geometry_axis_aligned(sizes[i], (double[]){1, 2, 3});
        make_pyramid(&g, ISO_F32, 1, &p);
        iso_vdb_options opt = iso_vdb_defaults();
        assert_ok(iso_vdb_save(&p, 0, 1, f->path, &opt, NULL, &err));
        assert_int_equal(count_differences(&p, 0, f->path, "density", "gradient", 0), 0);
    }
}

TEST(bad_calls_are_refused)
{
    fixture *f = *state;
    iso_vdb_options opt = iso_vdb_defaults();
    assert_status(iso_vdb_save(&f->pyramid, 0, 0, f->path, &opt, NULL, &err), ISO_E_RANGE);
    assert_status(iso_vdb_save(&f->pyramid, 2, 2, f->path, &opt, NULL, &err), ISO_E_RANGE);
    FREED char *nowhere = iso_path_join(f->dir, "missing/v.vdb");
    assert_status(iso_vdb_save(&f->pyramid, 2, 1, nowhere, &opt, NULL, &err), ISO_E_IO);
    float out[3];
    assert_status(iso_vdb_load_grid(nowhere, "density", 1, (size_t[]){1, 1, 1}, out, NULL, &err), ISO_E_IO);
    assert_ok(iso_vdb_save(&f->pyramid, 2, 1, f->path, &opt, NULL, &err));
    assert_status(iso_vdb_load_grid(f->path, "density", 3, (size_t[]){1, 1, 1}, out, NULL, &err), ISO_E_FORMAT);
    assert_status(iso_vdb_load_grid(f->path, "density", 2, (size_t[]){1, 1, 1}, out, NULL, &err), ISO_E_RANGE);
    assert_ok(iso_file_write(f->path, "no OpenVDB file", 15, &err));
    assert_status(iso_vdb_load_grid(f->path, "density", 1, (size_t[]){1, 1, 1}, out, NULL, &err), ISO_E_FORMAT);
}

TEST(a_full_disk_leaves_no_file)
{
    fixture *f = *state;
    FREED char *path = iso_path_join(f->dir, "full.vdb");
    const struct rlimit little = {.rlim_cur = 1000, .rlim_max = RLIM_INFINITY}, all = {RLIM_INFINITY, RLIM_INFINITY};
    iso_vdb_options opt = iso_vdb_defaults();
    signal(SIGXFSZ, SIG_IGN); /* as the program does: writing fails */
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &little), 0);
    iso_error err = {""};
    const iso_status status = iso_vdb_save(&f->pyramid, 2, 1, path, &opt, NULL, &err);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &all), 0);
    assert_int_equal(status, ISO_E_IO);
    assert_true(err.text[0] != 0);
    DIR *entries = opendir(f->dir);
    assert_non_null(entries);
    for (struct dirent *e; (e = readdir(entries));) {
        assert_null(strstr(e->d_name, "full.vdb"));
        assert_null(strstr(e->d_name, ".isoshade-"));
    }
    closedir(entries);
}

TEST_MAIN(setup, teardown)
