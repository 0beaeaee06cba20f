/* SPDX-License-Identifier: MIT */
/* Baked grids hold the optical depth, the colors and the place of what they are baked from, in every unit and on both
 * axes. */
#define _GNU_SOURCE
#include "lab/vdb_read.h"
#include "test.h"

#include "bake/grids.h"
#include "base/file.h"

enum { NX = 5, NY = 4, NZ = 3, VOXELS = NX * NY * NZ };
static const double spacing[3] = {2, 1, 0.5};

/* A level of these values, and a view that looks along x at it. */
typedef struct scene {
    float scalar[VOXELS], entries[8];
    uint8_t codes[3 * VOXELS];
    iso_level level;
    iso_view view;
} scene;

static void make_scene(scene *s)
{
    memset(s, 0, sizeof *s);
    memset(s->codes, 127, sizeof s->codes);
    s->level = (iso_level){.geometry = iso_geometry_axis_aligned((size_t[]){NX, NY, NZ}, spacing),
                           .scalar = s->scalar,
                           .codes = s->codes,
                           .max = 1};
    s->level.geometry.origin_mm = iso_v3(10, 20, 30);
    s->view = (iso_view){.width = 16,
                         .height = 8,
                         .camera = {.orthographic = true,
                                    .position = {-10, 22, 30.75},
                                    .forward = {1, 0, 0},
                                    .right = {0, -1, 0},
                                    .up = {0, 0, 1},
                                    .half_height = 1},
                         .shading = {.ambient = 1},
                         .step_voxels = 0.5,
                         .tf = {.count = 2, .lo = 0, .hi = 1, .entries = s->entries}};
}

/* Value 1 has this color and extinction; value 0 is green, bright and transparent: a color that must not be seen. */
static void set_tf(scene *s, float r, float g, float b, float extinction)
{
    const float entries[8] = {0, 9, 0, 0, r, g, b, extinction};
    memcpy(s->entries, entries, sizeof entries);
}

static size_t at(size_t x, size_t y, size_t z)
{
    return x + NX * (y + NY * z);
}

static iso_baked bake(const scene *s, size_t points, size_t samples)
{
    iso_baked b;
    const iso_bake_options o = {.points = points, .samples = samples, .threads = 1};
    assert_ok(iso_bake(&s->level, ISO_CODE_SNORM, &s->view, &o, &b, NULL, &err));
    return b;
}

static iso_bake_request request_of(const char *grids, const char *unit, const char *up)
{
    iso_bake_request r;
    const iso_bake_words words = {.grids = (char *)grids, .unit = (char *)unit, .up = (char *)up};
    assert_ok(iso_bake_request_make(&words, false, &r, &err));
    return r;
}

static void save(const iso_baked *b, const iso_bake_request *r, const char *path)
{
    assert_ok(iso_bake_save(b, r, 0, "/home/person/secret/head.nrrd", path, NULL, &err));
}

typedef struct folder {
    char *dir, *path;
} folder;
static int setup(void **state)
{
    folder *f = calloc(1, sizeof *f);
    f->dir = iso_make_temp_dir();
    f->path = iso_path_join(f->dir, "b.vdb");
    *state = f;
    return 0;
}
static int teardown(void **state)
{
    folder *f = *state;
    iso_remove_tree(f->dir);
    free(f->dir);
    free(f->path);
    free(f);
    return 0;
}

/* The sum along a line of points times their distance: what a program integrates of linearly interpolated points. */
static double optical_depth(const float *density, const size_t n[3], int axis, double distance)
{
    size_t p[3] = {n[0] / 2, n[1] / 2, n[2] / 2};
    double sum = 0;
    for (p[axis] = 0; p[axis] < n[axis]; ++p[axis])
        sum += (double)density[p[0] + n[0] * (p[1] + n[1] * p[2])] * distance;
    return sum;
}

/* The points of a grid, and where they are: its geometry begins at another index than 0. */
static void load_points(const char *path, const char *name, size_t channels, const size_t n[3], float *out,
                        iso_geometry *geometry)
{
    enum { FIRST = ISO_VDB_FIELDS_FIRST };
    const size_t m[3] = {n[0] + FIRST, n[1] + FIRST, n[2] + FIRST};
    FREED float *all = malloc(channels * m[0] * m[1] * m[2] * sizeof *all);
    iso_geometry whole;
    assert_ok(iso_vdb_load_grid(path, name, (int)channels, m, all, &whole, &err));
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y)
            memcpy(out + channels * n[0] * (y + n[1] * z),
                   all + channels * (FIRST + m[0] * (y + FIRST + m[1] * (z + FIRST))), channels * n[0] * sizeof *out);
    if (geometry) {
        *geometry = whole;
        geometry->origin_mm = iso_geometry_to_world(&whole, iso_v3(FIRST, FIRST, FIRST));
    }
}

/* A slab of extinction .3 / mm: 10 mm along x are 3, whatever the unit, the points, and the axis that is up. */
TEST_BETWEEN(a_slab_is_as_deep_in_every_unit, setup, teardown)
{
    const folder *f = *state;
    const char *const units[] = {"mm", "cm", "m", "inch"}, *const ups[] = {"z", "y"};
    const double mm[] = {1, 10, 1000, 25.4};
    scene s;
    make_scene(&s);
    set_tf(&s, 1, 1, 1, 0.3F);
    for (size_t i = 0; i < VOXELS; ++i)
        s.scalar[i] = 1;
    for (size_t points = 1; points <= 2; ++points)
        for (size_t u = 0; u < 8; ++u) {
            OWNED(iso_baked) b = bake(&s, points, 2);
            const size_t *n = b.geometry.size, count = n[0] * n[1] * n[2];
            const iso_bake_request r = request_of("density", units[u / 2], ups[u % 2]);
            FREED float *density = malloc(count * sizeof *density);
            iso_geometry back;
            save(&b, &r, f->path);
            load_points(f->path, "density", 1, n, density, &back);
            for (int a = 0; a < 3; ++a) {
                const double distance = spacing[a] / (double)points / mm[u / 2];
                /* floats of the grid: 6e-8 of each summand */
                assert_within(optical_depth(density, n, a, distance),
                              0.3 * spacing[a] *
                                  (a == 0   ? NX
                                   : a == 1 ? NY
                                            : NZ),
                              1e-6);
            }
            /* Read back it is where it was, in mm with z up. */
            for (int a = 0; a < 3; ++a)
                for (int c = 0; c < 3; ++c)
                    assert_within(back.index_to_world.m[a][c], b.geometry.index_to_world.m[a][c], 1e-12);
            assert_within(back.origin_mm.x, b.geometry.origin_mm.x, 1e-12);
            assert_within(back.origin_mm.y, b.geometry.origin_mm.y, 1e-12);
            assert_within(back.origin_mm.z, b.geometry.origin_mm.z, 1e-12);
        }
}

/* Where the file's own transform puts the one visible point, and whether it is a rotation. */
static bool is_placed(const double m[3][3], iso_vec3 found, iso_vec3 wanted)
{
    iso_mat3 turn;
    memcpy(turn.m, m, sizeof turn.m);
    return iso_mat3_det(turn) > 0 && iso_norm(iso_sub(found, wanted)) < 1e-12;
}

/* x, y, z in mm become x, z, -y in cm; a mirrored y is rejected. */
TEST(y_up_is_a_rotation)
{
    const iso_vdb_convention up = {.unit_mm = 10, .unit = "cm", .y_up = true};
    const iso_vec3 p = iso_vdb_in_scene(&up, iso_v3(10, 20, 30)), wanted = iso_v3(1, 3, -2);
    double m[3][3], mirrored[3][3];
    for (int c = 0; c < 3; ++c) {
        const iso_vec3 v = iso_vdb_turned(&up, iso_v3(c == 0, c == 1, c == 2));
        m[0][c] = mirrored[0][c] = v.x;
        m[1][c] = mirrored[1][c] = v.y;
        m[2][c] = v.z;
        mirrored[2][c] = -v.z;
    }
    assert_true(is_placed((const double(*)[3])m, p, wanted));
    assert_false(is_placed((const double(*)[3])mirrored, p, wanted));
    assert_false(is_placed((const double(*)[3])m, iso_v3(p.x, p.y, -p.z), wanted));
}

/* One voxel is visible: its point is at the voxel's center, of a left-handed level too. */
TEST(a_point_stays_at_its_place)
{
    scene s;
    make_scene(&s);
    set_tf(&s, 1, 1, 1, 1);
    s.scalar[at(3, 1, 2)] = 1;
    for (int left = 0; left < 2; ++left) {
        if (left) /* x the other way */
            s.level.geometry.index_to_world.m[0][0] *= -1;
        OWNED(iso_baked) b = bake(&s, 1, 1);
        assert_true(iso_mat3_det(b.geometry.index_to_world) > 0);
        assert_int_equal(b.reversed_x, left);
        assert_int_equal(b.visible_count, 1);
        const iso_vec3 center = iso_geometry_to_world(&s.level.geometry, iso_v3(3.5, 1.5, 2.5));
        const iso_vec3 p = iso_geometry_to_index(&b.geometry, center);
        const float *point = iso_baked_point(&b, (size_t)p.x, (size_t)p.y, (size_t)p.z);
        assert_non_null(point);
        assert_within((double)point[ISO_BAKE_EXTINCTION], 1, 0);
        assert_within(p.x - floor(p.x), 0.5, 1e-12);
        const iso_vec3 back = iso_baked_in_level(&b, p);
        assert_within(back.x, 3.5, 1e-12);
        assert_within(back.z, 2.5, 1e-12);
    }
}

/* A red point: all 26 neighbors are red without extinction, and half way there the color is still red, neither half
 * black nor the green that the transfer function has where it is transparent. */
TEST(transparent_neighbors_do_not_bleed)
{
    scene s;
    make_scene(&s);
    set_tf(&s, 0.8F, 0.1F, 0.2F, 2);
    s.scalar[at(2, 2, 1)] = 1;
    OWNED(iso_baked) b = bake(&s, 1, 1);
    assert_int_equal(b.color_count, 27);
    for (int i = 0; i < 2; ++i) {
        double color[3];
        const double extinction = iso_baked_sample(&b, (iso_baked_pair)i, iso_v3(3.9, 3.6, 2.4), color);
        assert_more_than(extinction, 0.1);
        /* rounding of floats */
        assert_within(color[0] / extinction, 0.8, 1e-6);
        assert_within(color[1] / extinction, 0.1, 1e-6);
        assert_within(color[2] / extinction, 0.2, 1e-6);
    }
    /* The planted fault: black neighbors darken the color at the same place. */
    for (size_t z = 0; z < b.geometry.size[2]; ++z)
        for (size_t y = 0; y < b.geometry.size[1]; ++y)
            for (size_t x = 0; x < b.geometry.size[0]; ++x) {
                float *p = (float *)iso_baked_point(&b, x, y, z);
                if (p && !(p[ISO_BAKE_EXTINCTION] > 0))
                    memset(p + ISO_BAKE_COLOR, 0, 3 * sizeof *p);
            }
    double color[3];
    const double extinction = iso_baked_sample(&b, ISO_BAKED_COLORS, iso_v3(3.9, 3.6, 2.4), color);
    assert_at_most(color[0] / extinction, 0.6);
}

/* Ramps of values: nothing is negative, emission is extinction times color, and points that are not active are 0. */
TEST_BETWEEN(grids_agree_and_are_never_negative, setup, teardown)
{
    const folder *f = *state;
    scene s;
    make_scene(&s);
    set_tf(&s, 0.5F, 0.25F, 1, 3);
    s.entries[0] = 0.1F;
    for (size_t i = 0; i < VOXELS; ++i)
        s.scalar[i] = (float)(sin(0.7 * (double)i));
    OWNED(iso_baked) b = bake(&s, 2, 2);
    const iso_bake_request r = request_of("density,Cd=color,emission,temperature", "cm", "z");
    const size_t *n = b.geometry.size, count = n[0] * n[1] * n[2];
    float *density = malloc(8 * count * sizeof *density), *color = density + count, *emission = color + 3 * count,
          *place = emission + 3 * count;
    save(&b, &r, f->path);
    load_points(f->path, "density", 1, n, density, NULL);
    load_points(f->path, "color", 3, n, color, NULL);
    load_points(f->path, "emission", 3, n, emission, NULL);
    load_points(f->path, "temperature", 1, n, place, NULL);
    size_t visible = 0;
    for (size_t i = 0; i < count; ++i) {
        visible += density[i] > 0;
        assert_true(density[i] >= 0 && place[i] >= 0 && place[i] <= 1);
        for (size_t c = 0; c < 3; ++c)
            assert_within((double)emission[3 * i + c], (double)density[i] * (double)color[3 * i + c],
                          1e-6 * (double)density[i]); /* two roundings to float */
    }
    assert_int_equal(visible, b.visible_count);
    assert_true(visible >= 1 && visible <= count - 1);
    for (size_t x = 0; x < n[0]; ++x)
        assert_true(density[x] == 0); /* the rim */
    free(density);
}

/* A clip plane through the middle of a voxel leaves half of what it had; a coarse level's last voxel that overhangs the
 * box by half likewise. */
TEST(cut_cells_keep_their_part)
{
    scene s;
    make_scene(&s);
    set_tf(&s, 1, 1, 1, 1);
    for (size_t i = 0; i < VOXELS; ++i)
        s.scalar[i] = 1;
    s.view.clip_count = 1;
    s.view.clips[0] = (iso_clip_plane){{1, 0, 0}, 10 + 2 * 2.5}; /* keeps what is right of index 2.5 */
    s.level.geometry.box_index[1] = 3.5;
    OWNED(iso_baked) b = bake(&s, 1, 1);
    const double wanted[NX] = {0, 0, 0.5, 1, 1};
    for (size_t x = 0; x < NX; ++x) {
        const float *inside = iso_baked_point(&b, x + 1, 2, 2), *last = iso_baked_point(&b, x + 1, NY, 2);
        assert_within(inside ? (double)inside[ISO_BAKE_EXTINCTION] : 0, wanted[x], 1e-6);
        assert_within(last ? (double)last[ISO_BAKE_EXTINCTION] : 0, wanted[x] / 2, 1e-6);
    }
}

/* The picture of a baked slab, 1 - exp(-sigma d) in its middle, and an error that is measured as 0 where nothing is
 * lost. */
TEST(the_picture_of_a_slab_is_exact)
{
    scene s;
    OWNED(iso_image) image = {0};
    iso_bake_error e;
    make_scene(&s);
    set_tf(&s, 0.5F, 1, 0.25F, 0.2F);
    for (size_t i = 0; i < VOXELS; ++i)
        s.scalar[i] = 1;
    OWNED(iso_baked) b = bake(&s, 1, 2);
    s.view.camera.half_height = 0.1; /* inside, away from the faces that fall off */
    assert_ok(iso_baked_render(&b, ISO_BAKED_EMISSION, &s.view, 0, &image, NULL, &err));
    const float *middle = image.rgba + 4 * (4 * image.width + 8);
    /* the reference's tolerance */
    assert_within((double)middle[3], 1 - exp(-0.2 * 10), 1e-5);
    assert_within((double)middle[0], 0.5 * (1 - exp(-0.2 * 10)), 1e-5);
    assert_ok(iso_bake_measure(&b, true, 8, &e, NULL, &err));
    assert_at_most(e.unlit.max_abs, 1e-4); /* steps of an eighth that end within the rim's slope */
    assert_at_most(e.emission.max_abs, 1e-4);
}

/* Finer lattices come nearer to the exact picture; with one that is wrong, a grid twice as dense, the error shows. */
TEST(the_error_is_that_of_the_grid)
{
    scene s;
    double before = INFINITY;
    make_scene(&s);
    set_tf(&s, 0.5F, 1, 0.25F, 2);
    for (size_t i = 0; i < VOXELS; ++i)
        s.scalar[i] = (float)(0.5 - 0.5 * cos(1.7 * (double)i));
    s.entries[4] = 0;
    for (size_t points = 1; points <= 4; points *= 2) {
        iso_bake_error e;
        OWNED(iso_baked) b = bake(&s, points, 2);
        assert_ok(iso_bake_measure(&b, true, 0, &e, NULL, &err));
        assert_int_equal(e.width, 16);
        assert_more_than(e.unlit.rmse, 0);
        assert_at_most(e.unlit.rmse, 0.7 * before); /* each doubling takes about half of it away */
        before = e.unlit.rmse;
        if (points == 4) {
            for (size_t i = 0; i < b.blocks[0] * b.blocks[1] * b.blocks[2]; ++i)
                for (size_t k = 0; b.block[i] && k < ISO_BAKE_CHANNELS * 512; k += ISO_BAKE_CHANNELS)
                    b.block[i][k] *= 2;
            assert_ok(iso_bake_measure(&b, true, 0, &e, NULL, &err));
            assert_more_than(e.unlit.rmse, 3 * before);
        }
    }
}

TEST(threads_change_nothing)
{
    scene s;
    make_scene(&s);
    set_tf(&s, 0.5F, 1, 0.25F, 2);
    for (size_t i = 0; i < VOXELS; ++i)
        s.scalar[i] = (float)sin((double)i);
    OWNED(iso_baked) one = bake(&s, 4, 2), four;
    const iso_bake_options o = {.points = 4, .samples = 2, .threads = 4};
    assert_ok(iso_bake(&s.level, ISO_CODE_SNORM, &s.view, &o, &four, NULL, &err));
    for (size_t i = 0; i < one.blocks[0] * one.blocks[1] * one.blocks[2]; ++i) {
        assert_int_equal(!one.block[i], !four.block[i]);
        if (one.block[i])
            assert_memory_equal(one.block[i], four.block[i], 512 * ISO_BAKE_CHANNELS * sizeof(float));
    }
}

/* Every point has the extinction that its place in the level has, 0 or not. */
static void assert_all_points(const scene *s, const iso_baked *b)
{
    OWNED(iso_sampler) sampler;
    const size_t *n = b->geometry.size;
    assert_ok(iso_sampler_create(&sampler, &s->level, ISO_CODE_SNORM, ISO_FROM_ON_THE_FLY, &err));
    for (size_t z = 1; z + 1 < n[2]; ++z)
        for (size_t y = 1; y + 1 < n[1]; ++y)
            for (size_t x = 1; x + 1 < n[0]; ++x) {
                const iso_vec3 p = iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5);
                const float *point = iso_baked_point(b, x, y, z);
                double rgbs[4];
                iso_tf_lookup(&s->view.tf, iso_sample_scalar(&sampler, iso_baked_in_level(b, p)), rgbs);
                const float extinction = point ? point[ISO_BAKE_EXTINCTION] : 0;
                assert_float_equal(extinction, (float)rgbs[3], 0);
            }
}

TEST(blocks_that_one_voxel_reaches_are_there)
{
    float entries[4 * 64] = {0}; /* transparent near 0, so that what is far from the voxel shows nothing */
    for (size_t i = 2; i < 64; ++i)
        entries[4 * i + 3] = (float)i;
    static const size_t places[][3] = {{0, 0, 0}, {2, 1, 1}, {NX - 1, NY - 1, NZ - 1}};
    for (size_t i = 0; i < sizeof places / sizeof *places; ++i)
        for (size_t points = 1; points <= ISO_BAKE_MOST_POINTS; ++points)
            for (int mirrored = 0; mirrored < 2; ++mirrored) {
                scene s;
                make_scene(&s);
                s.view.tf = (iso_tf_table){.count = 64, .hi = 1, .entries = entries};
                s.scalar[at(places[i][0], places[i][1], places[i][2])] = 1;
                s.level.geometry.index_to_world.m[0][0] *= mirrored ? -1 : 1;
                OWNED(iso_baked) b = bake(&s, points, 1);
                assert_int_equal(b.reversed_x, mirrored);
                assert_all_points(&s, &b);
            }
}

TEST(words_are_checked)
{
    static const iso_bake_words wrong[] = {{.grids = "Cd"},
                                           {.grids = "density,Cd,Cd"},
                                           {.grids = "density,albedo"},
                                           {.grids = "density,Cd=density"},
                                           {.grids = "density=a-b"},
                                           {.grids = "density", .unit = "parsec"},
                                           {.grids = "density", .up = "x"},
                                           {.grids = "density", .points = 9},
                                           {.grids = "density", .samples = -1},
                                           {.program = "maya"},
                                           {.unit = "m"},
                                           {.up = "y"},
                                           {.usd = 1}};
    iso_bake_request r;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
        assert_status(iso_bake_request_make(&wrong[i], false, &r, &err), ISO_E_USAGE);
    assert_ok(iso_bake_request_make(&(iso_bake_words){0}, true, &r, &err));
    assert_false(r.wanted);
    /* What is given stands instead of the program's row. */
    assert_ok(iso_bake_request_make(&(iso_bake_words){.program = "unreal", .unit = "m"}, false, &r, &err));
    assert_true(r.half && !r.convention.y_up && r.has[ISO_BAKE_CD] && !r.usd);
    assert_within(r.convention.unit_mm, 1000, 0);
    for (size_t i = 0; i < iso_grid_program_names.count; ++i) {
        const iso_bake_words row = {.program = (char *)iso_grid_program_at(i)->name};
        assert_ok(iso_bake_request_make(&row, false, &r, &err));
        assert_non_null(strstr(iso_grid_program_at(i)->source, "https://"));
    }
}

/* Voxels of a nanometer in scenes of meters: OpenVDB would call their transform singular. */
TEST_BETWEEN(a_unit_that_does_not_suit_is_refused, setup, teardown)
{
    const folder *f = *state;
    scene s;
    make_scene(&s);
    set_tf(&s, 1, 1, 1, 1);
    s.scalar[0] = 1;
    s.level.geometry.index_to_world = iso_mat3_scale(s.level.geometry.index_to_world, 1e-6);
    OWNED(iso_baked) b = bake(&s, 1, 1);
    const iso_bake_request r = request_of("density", "m", NULL), fine = request_of("density", "nm", NULL);
    assert_status(iso_bake_save(&b, &r, 0, "", f->path, NULL, &err), ISO_E_RANGE);
    assert_ok(iso_bake_save(&b, &fine, 0, "", f->path, NULL, &err));
}

TEST_MAIN(NULL, NULL)
