/* SPDX-License-Identifier: MIT */
/* Grids without what a transfer function does not show: every reader that interpolates finds the same extinction. */
#define _GNU_SOURCE
#include "lab/vdb_read.h"
#include "sampled.h"

#include "base/file.h"
#include "brick/occupancy.h"
#include "pyramid/pyramid.h"
#include "vdb/vdb_sparse.h"
#include "volume/synthetic.h"

typedef struct fixture {
    char *dir, *path;
    iso_pyramid pyramid;
} fixture;

/* Odd sizes, so that leaves are cut and coarse levels overhang; left-handed where asked for. */
static iso_pyramid make_pyramid(iso_type type, bool left_handed)
{
    iso_field field = {.kind = ISO_FIELD_SHELLS,
                       .geometry = iso_geometry_axis_aligned((size_t[]){37, 29, 43}, (double[]){1, 0.8, 1.5})};
    if (left_handed)
        field.geometry.index_to_world.m[1][1] *= -1;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 3;
    iso_pyramid p = sampled_pyramid(&field, type, &opt);
    return p;
}

static int setup(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    f->dir = iso_make_temp_dir();
    f->path = iso_path_join(f->dir, "v.vdb");
    f->pyramid = make_pyramid(ISO_U8, false);
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

enum { ENTRIES = 64 };

/* Extinction 1 in [lo, hi], fractions of the level's range; 0 elsewhere. */
static void band(iso_tf_table *t, const iso_level *l, double lo, double hi)
{
    if (!t->entries)
        *t = (iso_tf_table){.count = ENTRIES,
                            .lo = l->min,
                            .hi = l->max,
                            .entries = calloc(4 * ENTRIES, sizeof *t->entries)};
    for (int i = 0; i < ENTRIES; ++i)
        if (i >= lo * (ENTRIES - 1) && i <= hi * (ENTRIES - 1))
            t->entries[4 * i + 3] = 1;
}

/* The grid dense, with a rim of a voxel; index first + i. */
typedef struct dense {
    size_t size[3];
    float *values;
} dense;

static dense read_back(const char *path, const char *grid, int channels, const iso_geometry *g)
{
    dense d = {{g->size[0] + 3, g->size[1] + 3, g->size[2] + 3}, NULL};
    d.values = malloc((size_t)channels * d.size[0] * d.size[1] * d.size[2] * sizeof *d.values);
    assert_ok(iso_vdb_load_grid(path, grid, channels, d.size, d.values, NULL, &err));
    return d;
}

static double extinction(const iso_tf_table *tfs, size_t count, double value)
{
    double sum = 0, rgbs[4];
    for (size_t i = 0; i < count; ++i) {
        iso_tf_lookup(&tfs[i], value, rgbs);
        sum += rgbs[3];
    }
    return sum;
}

/* Points of each cell, its corners among them, where the extinctions of two grids differ; seen: where there is any. */
static size_t cells_that_differ(const dense *a, const dense *b, const iso_tf_table *tfs, size_t count, size_t *seen)
{
    enum { PARTS = 3 };
    size_t differ = 0;
    *seen = 0;
    for (size_t z = 1; z + 1 < a->size[2]; ++z)
        for (size_t y = 1; y + 1 < a->size[1]; ++y)
            for (size_t x = 1; x + 1 < a->size[0]; ++x) {
                bool other = false, any = false;
                for (int p = 0; p < PARTS * PARTS * PARTS; ++p) {
                    const double at[3] = {p % PARTS / (PARTS - 1.0), p / PARTS % PARTS / (PARTS - 1.0),
                                          p / (PARTS * PARTS) / (PARTS - 1.0)};
                    double va = 0, vb = 0;
                    for (size_t c = 0; c < 8; ++c) {
                        const size_t i = x + (c & 1) + a->size[0] * (y + (c >> 1 & 1) + a->size[1] * (z + (c >> 2)));
                        const double w = (c & 1 ? at[0] : 1 - at[0]) * (c & 2 ? at[1] : 1 - at[1]) *
                                         (c & 4 ? at[2] : 1 - at[2]);
                        va += w * (double)a->values[i];
                        vb += w * (double)b->values[i];
                    }
                    const double ea = extinction(tfs, count, va);
                    other = other || ea != extinction(tfs, count, vb);
                    any = any || ea > 0;
                }
                differ += other;
                *seen += any;
            }
    return differ;
}

/* Writes level k whole and sparse, compares both cell by cell, and returns the active voxels of both. */
static void compare(fixture *f, const iso_pyramid *p, size_t k, const iso_vdb_shown *shown, size_t active[2])
{
    const iso_geometry *g = &p->levels[k].geometry;
    iso_vdb_options opt = iso_vdb_defaults();
    iso_vdb_stats stats;
    dense grids[2];
    size_t seen;
    opt.pad_voxels = 1;
    opt.gradient = false;
    for (int sparse = 0; sparse < 2; ++sparse) {
        opt.shown = sparse ? shown : NULL;
        assert_ok(iso_vdb_save(p, k, 1, f->path, &opt, NULL, &err));
        assert_ok(iso_vdb_measure(f->path, &stats, &err));
        active[sparse] = stats.active_voxels;
        grids[sparse] = read_back(f->path, "density", 1, g);
    }
    assert_int_equal(cells_that_differ(&grids[0], &grids[1], shown->tfs, shown->tf_count, &seen), 0);
    assert_true(seen > 0);
    free(grids[0].values);
    free(grids[1].values);
}

TEST_BETWEEN(every_cell_has_the_extinction_that_it_had, setup, teardown)
{
    fixture *f = *state;
    const double bands[][2] = {{0.5, 1}, {0, 0.3}, {0.4, 0.6}, {0.9, 0.95}};
    for (size_t k = 0; k < 3; ++k)
        for (size_t i = 0; i < 4; ++i) {
            OWNED(iso_tf_table) tf = {0};
            size_t active[2];
            band(&tf, &f->pyramid.levels[k], bands[i][0], bands[i][1]);
            compare(f, &f->pyramid, k, &(iso_vdb_shown){&tf, 1, false, 0}, active);
            assert_true(i == 1 || 4 * active[1] < active[0]); /* band 1 shows what is between the shells */
        }
}

TEST_BETWEEN(of_several_transfer_functions_any_shows, setup, teardown)
{
    fixture *f = *state;
    iso_tf_table tfs[2] = {{0}, {0}};
    size_t active[2];
    band(&tfs[0], &f->pyramid.levels[0], 0.2, 0.3);
    band(&tfs[1], &f->pyramid.levels[0], 0.8, 0.9);
    compare(f, &f->pyramid, 0, &(iso_vdb_shown){tfs, 2, false, 0}, active);
    iso_tf_table_destroy(&tfs[0]);
    iso_tf_table_destroy(&tfs[1]);
}

TEST_BETWEEN(a_left_handed_grid_is_as_sparse, setup, teardown)
{
    fixture *f = *state;
    OWNED(iso_pyramid) p = make_pyramid(ISO_U8, true);
    OWNED(iso_tf_table) tf = {0};
    size_t active[2], right[2];
    band(&tf, &p.levels[0], 0.5, 1);
    compare(f, &p, 0, &(iso_vdb_shown){&tf, 1, false, 0}, active);
    compare(f, &f->pyramid, 0, &(iso_vdb_shown){&tf, 1, false, 0}, right);
    assert_true(labs((long)active[1] - (long)right[1]) <= 2);
}

/* A band between two ranges that are not shown: values above it must not become the background below it. */
TEST_BETWEEN(voxels_beyond_visible_cells_stay, setup, teardown)
{
    fixture *f = *state;
    const iso_level *l = &f->pyramid.levels[0];
    OWNED(iso_tf_table) tf = {0};
    OWNED(iso_vdb_activity) a;
    band(&tf, l, 0.4, 0.5);
    assert_ok(iso_vdb_activity_create(&a, l, NULL, &(iso_vdb_shown){&tf, 1, false, 0}, 1, 0, &err));
    size_t beyond = 0, left_out = 0;
    for (size_t z = 0; z < l->geometry.size[2]; ++z)
        for (size_t y = 0; y < l->geometry.size[1]; ++y)
            for (size_t x = 0; x < l->geometry.size[0]; ++x) {
                const double v = (double)l->scalar[x + l->geometry.size[0] * (y + l->geometry.size[1] * z)];
                const bool other_side = ((double)a.background < 0.45 * l->max) != (v < 0.45 * l->max);
                beyond += other_side;
                left_out += other_side && !iso_vdb_activity_bit(&a, a.kept, (const size_t[]){x + 1, y + 1, z + 1});
            }
    assert_true(beyond > 0);
    assert_int_equal(left_out, 0);
}

/* Planted fault: a single voxel that is needed, and is not there, is found. */
TEST_BETWEEN(a_voxel_too_few_is_found, setup, teardown)
{
    fixture *f = *state;
    const iso_geometry *g = &f->pyramid.levels[0].geometry;
    iso_vdb_options opt = iso_vdb_defaults();
    OWNED(iso_tf_table) tf = {0};
    size_t seen;
    band(&tf, &f->pyramid.levels[0], 0.5, 1);
    opt.pad_voxels = 1;
    assert_ok(iso_vdb_save(&f->pyramid, 0, 1, f->path, &opt, NULL, &err));
    dense whole = read_back(f->path, "density", 1, g), hole = read_back(f->path, "density", 1, g);
    size_t i = hole.size[0] * hole.size[1] * (hole.size[2] / 2) + hole.size[0] * (hole.size[1] / 2);
    while (extinction(&tf, 1, (double)hole.values[i]) == 0)
        ++i;
    hole.values[i] = 0;
    assert_true(cells_that_differ(&whole, &hole, &tf, 1, &seen) > 0);
    free(whole.values);
    free(hole.values);
}

/* Directions where cells are seen, and nowhere else; there they are what they were. */
TEST_BETWEEN(directions_are_kept_where_something_is_seen, setup, teardown)
{
    fixture *f = *state;
    const iso_level *l = &f->pyramid.levels[0];
    iso_vdb_options opt = iso_vdb_defaults();
    OWNED(iso_tf_table) tf = {0};
    OWNED(iso_vdb_activity) a;
    band(&tf, l, 0.4, 0.5);
    const iso_vdb_shown shown = {&tf, 1, false, 0};
    opt.pad_voxels = 1;
    assert_ok(iso_vdb_save(&f->pyramid, 0, 1, f->path, &opt, NULL, &err));
    dense whole = read_back(f->path, "gradient", 3, &l->geometry);
    opt.shown = &shown;
    assert_ok(iso_vdb_save(&f->pyramid, 0, 1, f->path, &opt, NULL, &err));
    dense sparse = read_back(f->path, "gradient", 3, &l->geometry);
    assert_ok(iso_vdb_activity_create(&a, l, NULL, &shown, 1, 1, &err));
    assert_true(a.lit_count > 0 && a.lit_count < a.kept_count);
    size_t bad = 0;
    for (size_t z = 0; z < a.size[2]; ++z)
        for (size_t y = 0; y < a.size[1]; ++y)
            for (size_t x = 0; x < a.size[0]; ++x) {
                const size_t i = 3 * (x + 1 + whole.size[0] * (y + 1 + whole.size[1] * (z + 1)));
                const bool lit = iso_vdb_activity_bit(&a, a.lit, (const size_t[]){x, y, z});
                for (size_t c = 0; c < 3; ++c)
                    bad += sparse.values[i + c] != (lit ? whole.values[i + c] : 0);
            }
    assert_int_equal(bad, 0);
    free(whole.values);
    free(sparse.values);
}

/* No transfer function: what equals the background all round goes, and no value changes. */
TEST_BETWEEN(a_plain_background_changes_no_value, setup, teardown)
{
    fixture *f = *state;
    const iso_level *l = &f->pyramid.levels[0];
    iso_vdb_options opt = iso_vdb_defaults();
    const iso_vdb_shown shown = {NULL, 0, true, l->min};
    iso_vdb_stats whole_stats, stats;
    opt.pad_voxels = 1;
    assert_ok(iso_vdb_save(&f->pyramid, 0, 1, f->path, &opt, NULL, &err));
    assert_ok(iso_vdb_measure(f->path, &whole_stats, &err));
    dense whole = read_back(f->path, "density", 1, &l->geometry);
    opt.shown = &shown;
    assert_ok(iso_vdb_save(&f->pyramid, 0, 1, f->path, &opt, NULL, &err));
    assert_ok(iso_vdb_measure(f->path, &stats, &err));
    dense sparse = read_back(f->path, "density", 1, &l->geometry);
    for (size_t z = 1; z < whole.size[2]; ++z)
        for (size_t y = 1; y < whole.size[1]; ++y)
            assert_memory_equal(whole.values + 1 + whole.size[0] * (y + whole.size[1] * z),
                                sparse.values + 1 + whole.size[0] * (y + whole.size[1] * z),
                                (whole.size[0] - 1) * sizeof *whole.values);
    assert_true(stats.active_voxels < whole_stats.active_voxels);
    free(whole.values);
    free(sparse.values);
}

TEST_BETWEEN(a_background_that_shows_is_refused, setup, teardown)
{
    fixture *f = *state;
    const iso_level *l = &f->pyramid.levels[0];
    iso_vdb_options opt = iso_vdb_defaults();
    OWNED(iso_tf_table) tf = {0};
    band(&tf, l, 0.5, 1);
    opt.shown = &(iso_vdb_shown){&tf, 1, true, l->max};
    assert_status(iso_vdb_save(&f->pyramid, 0, 1, f->path, &opt, NULL, &err), ISO_E_RANGE);
}

/* c / 127 as c / 128 in half floats: not one bit of what the code held is lost. */
TEST_BETWEEN(half_directions_hold_what_the_code_held, setup, teardown)
{
    fixture *f = *state;
    const iso_level *l = &f->pyramid.levels[1];
    const size_t voxels = iso_geometry_voxel_count(&l->geometry);
    iso_vdb_options opt = iso_vdb_defaults();
    iso_vdb_stats full, half;
    FREED float *read = malloc(3 * voxels * sizeof *read);
    assert_ok(iso_vdb_save(&f->pyramid, 1, 1, f->path, &opt, NULL, &err));
    assert_ok(iso_vdb_measure(f->path, &full, &err));
    opt.half_directions = true;
    assert_ok(iso_vdb_save(&f->pyramid, 1, 1, f->path, &opt, NULL, &err));
    assert_ok(iso_vdb_measure(f->path, &half, &err));
    assert_ok(iso_vdb_load_grid(f->path, "gradient", 3, l->geometry.size, read, NULL, &err));
    assert_true(iso_vdb_direction_scale(f->pyramid.options.code) == 127.0 / 128);
    size_t bad = 0;
    for (size_t i = 0; i < 3 * voxels; ++i)
        bad += read[i] != (float)(int8_t)l->codes[i] / 128;
    assert_int_equal(bad, 0);
    assert_true(half.file_bytes < full.file_bytes);
}

/* Any number of threads marks the same. */
TEST_BETWEEN(threads_do_not_matter, setup, teardown)
{
    fixture *f = *state;
    const iso_level *l = &f->pyramid.levels[0];
    OWNED(iso_tf_table) tf = {0};
    OWNED(iso_vdb_activity) a, b;
    band(&tf, l, 0.4, 0.5);
    assert_ok(iso_vdb_activity_create(&a, l, NULL, &(iso_vdb_shown){&tf, 1, false, 0}, 1, 1, &err));
    assert_ok(iso_vdb_activity_create(&b, l, NULL, &(iso_vdb_shown){&tf, 1, false, 0}, 1, 3, &err));
    assert_memory_equal(a.kept, b.kept, a.row_bytes * a.size[1] * a.size[2]);
    assert_memory_equal(a.lit, b.lit, a.row_bytes * a.size[1] * a.size[2]);
    assert_int_equal(a.kept_count, b.kept_count);
}

/* What a file holds behind the header, in which OpenVDB notes a random number. */
static char *read_bytes(const char *path, size_t *size)
{
    enum { NUMBERS = 8 + 3 * 4 + 1, UUID = 36 };
    char *bytes = NULL;
    assert_ok(iso_file_read(path, &bytes, size, &err));
    assert_true(*size > NUMBERS + UUID);
    memset(bytes + NUMBERS, 0, UUID);
    return bytes;
}

static void save_by(fixture *f, int threads, bool half_directions, char **bytes, size_t *size)
{
    iso_vdb_options opt = iso_vdb_defaults();
    opt.threads = threads;
    opt.half_directions = half_directions;
    assert_ok(iso_vdb_save(&f->pyramid, 0, 2, f->path, &opt, NULL, &err));
    *bytes = read_bytes(f->path, size);
}

/* Of 120 leaves each thread writes some; by ZIP and as OpenVDB does it otherwise. */
TEST_BETWEEN(threads_write_the_same_bytes, setup, teardown)
{
    for (int half = 0; half < 2; ++half) {
        FREED char *by_one, *by_three;
        size_t size, size_by_three;
        save_by(*state, 1, half, &by_one, &size);
        save_by(*state, 3, half, &by_three, &size_by_three);
        assert_int_equal(size, size_by_three);
        assert_memory_equal(by_one, by_three, size);
    }
}

static bool holds(const char *path, const char *text)
{
    FREED char *bytes = NULL;
    size_t size = 0;
    assert_ok(iso_file_read(path, &bytes, &size, &err));
    const bool found = memmem(bytes, size, text, strlen(text)) != NULL;
    return found;
}

TEST_BETWEEN(files_say_what_they_are_and_no_folder, setup, teardown)
{
    fixture *f = *state;
    iso_vdb_options opt = iso_vdb_defaults();
    opt.command = "isoshade export shells.nrrd";
    assert_ok(iso_vdb_save(&f->pyramid, 0, 1, f->path, &opt, NULL, &err));
    assert_true(holds(f->path, "fog volume"));
    assert_true(holds(f->path, opt.command));
    assert_true(holds(f->path, "shells.nrrd"));
    assert_false(holds(f->path, "someone"));
    f->pyramid.levels[0].min = -5; /* values may be negative */
    assert_ok(iso_vdb_save(&f->pyramid, 0, 1, f->path, &opt, NULL, &err));
    assert_false(holds(f->path, "fog volume"));
}

TEST_MAIN(NULL, NULL)
