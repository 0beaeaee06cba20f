/* SPDX-License-Identifier: MIT */
/* What a plan leaves of a volume of bytes: the same from samples as from floats, and files that hold it without a
 * loss. */
#include "lab/vdb_read.h"
#include "test.h"

#include <jansson.h>

#include "base/file.h"
#include "base/json.h"
#include "base/random.h"
#include "brick/pack.h"
#include "plan/planned.h"
#include "povray/povray.h"
#include "scene/scene.h"
#include "volume/synthetic.h"

enum { BRICK = 8, LEVELS = 3 };

typedef struct fixture {
    char *dir, *plan;
    iso_volume volume;
    iso_level level0; /* in floats */
    iso_tf_table tf;
    iso_view view;
} fixture;

/* A plan of any levels that draws what the transfer function shows. */
static void write_plan(const fixture *f)
{
    OWNED(iso_node_levels) n;
    assert_ok(iso_node_levels_create(&n, &f->level0, BRICK, LEVELS, false, 1, &err));
    const size_t count = iso_brick_count(&n);
    FREED uint8_t *levels = malloc(count), *drawn = malloc(count), *seen = malloc(count);
    iso_random random = {5};
    for (size_t i = 0; i < count; ++i)
        levels[i] = (uint8_t)iso_random_below(&random, LEVELS);
    memset(seen, 1, count);
    const iso_brick_field field = {&n, levels, ISO_FACES_BAKED};
    iso_brick_cull(&field, &f->tf, NULL, 1, drawn);
    json_auto_t *plan = json_pack("{s:s, s:[iii], s:i, s:i}", "schema", "isoshade.plan/1", "bricks", (int)n.count[0],
                                  (int)n.count[1], (int)n.count[2], "brick_voxels", BRICK, "level_count", LEVELS);
    json_auto_t *bricks = iso_plan_file_bricks(levels, drawn, seen, count);
    json_object_update(plan, bricks);
    assert_ok(iso_json_save(f->plan, plan, &err));
}

static int setup(void **state)
{
    const size_t size[3] = {40, 33, 29};
    fixture *f = calloc(1, sizeof *f);
    f->dir = iso_make_temp_dir();
    f->plan = iso_path_join(f->dir, "plan.json");
    const iso_field field = {.kind = ISO_FIELD_NOISE,
                             .geometry = iso_geometry_axis_aligned(size, (const double[]){1, 0.8, 1.5}),
                             .seed = 2};
    assert_ok(iso_field_sample(&field, ISO_U8, &f->volume, &err));
    const iso_volume_stats stats = iso_volume_measure(&f->volume);
    float *floats = malloc(size[0] * size[1] * size[2] * sizeof *floats);
    iso_volume_floats(&f->volume, floats);
    f->level0 = (iso_level){
        .geometry = field.geometry, .stored_type = ISO_U8, .min = stats.min, .max = stats.max, .scalar = floats};
    OWNED(iso_scene) scene;
    assert_ok(iso_scene_load("refscenes/shells.scene.json", &scene, &err));
    scene.width = scene.height = 8;
    assert_ok(iso_scene_resolve(&scene, &field.geometry, stats.min, stats.max, &f->view, &err));
    f->tf = (iso_tf_table){.count = 65, .lo = stats.min, .hi = stats.max, .entries = calloc(4 * 65, sizeof(float))};
    for (size_t i = 40; i < 50; ++i) /* a band: cells with background in them show, too */
        f->tf.entries[4 * i + 3] = 1;
    write_plan(f);
    *state = f;
    return 0;
}

static int teardown(void **state)
{
    fixture *f = *state;
    iso_remove_tree(f->dir);
    iso_view_destroy(&f->view);
    iso_volume_destroy(&f->volume);
    free(f->level0.scalar);
    free(f->tf.entries);
    free(f->plan);
    free(f->dir);
    free(f);
    return 0;
}

/* narrow: from the volume's samples. */
static void open_plan(const fixture *f, bool narrow, int threads, iso_planned *p)
{
    iso_level level0 = f->level0;
    if (narrow) {
        level0.scalar = NULL;
        level0.samples = &f->volume;
    }
    assert_ok(iso_planned_create(f->plan, &(iso_planned_subject){&level0, ISO_CODE_FIT, &f->tf, 1}, threads, p, &err));
}

/* Nodes that two lattices of one box do not have alike, to the last bit. */
static size_t unlike(const iso_lattice *a, const iso_lattice *b)
{
    size_t different = 0;
    assert_memory_equal(a->first, b->first, sizeof a->first);
    assert_memory_equal(a->size, b->size, sizeof a->size);
    for (size_t i = 0; i < a->size[0] * a->size[1] * a->size[2]; ++i) {
        const size_t x = i % a->size[0], y = i / a->size[0] % a->size[1], z = i / (a->size[0] * a->size[1]);
        different += iso_lattice_use_of(a, x, y, z) != iso_lattice_use_of(b, x, y, z) ||
                     memcmp(iso_lattice_node(a, x, y, z), iso_lattice_node(b, x, y, z), sizeof a->empty) != 0;
    }
    return different;
}

/* A voxel within a brick of level 0 that the lattice has, where it is lit. */
static size_t voxel_of(const iso_lattice *l, const iso_planned *p)
{
    const size_t *size = p->nodes.geometry.size, *count = p->nodes.count;
    for (size_t i = 0; i < l->size[0] * l->size[1] * l->size[2]; ++i) {
        const size_t x = i % l->size[0], y = i / l->size[0] % l->size[1], z = i / (l->size[0] * l->size[1]);
        const long at[3] = {l->first[0] + (long)x, l->first[1] + (long)y, l->first[2] + (long)z};
        bool inside = iso_lattice_use_of(l, x, y, z) == ISO_LATTICE_LIT;
        size_t brick[3];
        for (int a = 0; a < 3; ++a) {
            inside = inside && at[a] > 0 && at[a] + 1 < (long)size[a] && at[a] % BRICK != 0;
            brick[a] = (size_t)(at[a] / BRICK);
        }
        if (inside && p->plan.levels[brick[0] + count[0] * (brick[1] + count[1] * brick[2])] == 0)
            return (size_t)at[0] + size[0] * ((size_t)at[1] + size[1] * (size_t)at[2]);
    }
    fail_msg("no voxel is lit");
    return 0;
}

/* The planted fault: one sample of a brick that is drawn. */
TEST_BETWEEN(a_lattice_depends_neither_on_threads_nor_on_how_level_0_is_stored, setup, teardown)
{
    fixture *f = *state;
    iso_planned_lattices from_floats, from_bytes, from_others;
    OWNED(iso_planned) floats, bytes;
    open_plan(f, false, 1, &floats);
    open_plan(f, true, 2, &bytes);
    for (int merged = 0; merged < 2; ++merged) {
        assert_ok(iso_planned_lattices_create(&floats, merged, false, 1, &from_floats, &err));
        assert_ok(iso_planned_lattices_create(&bytes, merged, false, 2, &from_bytes, &err));
        assert_int_equal(from_floats.count, from_bytes.count);
        for (size_t i = 0; i < from_floats.count; ++i)
            assert_int_equal(unlike(&from_floats.items[i], &from_bytes.items[i]), 0);
        const size_t changed = voxel_of(&from_bytes.items[0], &bytes);
        ((uint8_t *)f->volume.data)[changed] ^= 1;
        assert_ok(iso_planned_lattices_create(&bytes, merged, false, 2, &from_others, &err));
        ((uint8_t *)f->volume.data)[changed] ^= 1;
        assert_true(unlike(&from_floats.items[0], &from_others.items[0]) > 0);
        iso_planned_lattices_destroy(&from_floats);
        iso_planned_lattices_destroy(&from_bytes);
        iso_planned_lattices_destroy(&from_others);
    }
}

/* The largest difference of a grid's directions, once they are divided by what they were multiplied by, from the
 * lattice's; scalars are compared by their bits. */
static double largest_loss(const fixture *f, const iso_lattice *l)
{
    FREED char *path = iso_path_join(f->dir, "v.vdb");
    iso_vdb_options o = iso_vdb_defaults();
    o.half_directions = true;
    assert_ok(iso_vdb_save_lattices(l, 1, "bytes", path, &o, NULL, &err));
    size_t shift[3], size[3];
    for (int a = 0; a < 3; ++a) { /* as vdb_grids.c begins a lattice */
        shift[a] = (size_t)(l->first[a] + (l->first[a] < 2 ? 8 * ((2 - l->first[a] + 7) / 8) : 0));
        size[a] = shift[a] + l->size[a];
    }
    const size_t count = size[0] * size[1] * size[2];
    FREED float *scalars = malloc(count * sizeof *scalars), *directions = malloc(3 * count * sizeof *directions);
    assert_ok(iso_vdb_load_grid(path, "density", 1, size, scalars, NULL, &err));
    assert_ok(iso_vdb_load_grid(path, "gradient", 3, size, directions, NULL, &err));
    double worst = 0;
    for (size_t i = 0; i < l->size[0] * l->size[1] * l->size[2]; ++i) {
        const size_t x = i % l->size[0], y = i / l->size[0] % l->size[1], z = i / (l->size[0] * l->size[1]);
        const size_t at = x + shift[0] + size[0] * (y + shift[1] + size[1] * (z + shift[2]));
        const float *node = iso_lattice_node(l, x, y, z);
        assert_memory_equal(&scalars[at], &node[0], sizeof *node);
        for (size_t c = 0; c < 3; ++c)
            worst = fmax(worst, fabs((double)directions[3 * at + c] / ISO_VDB_LINEAR_SCALE - (double)node[1 + c]));
    }
    return worst;
}

/* Directions are floats of multiples of 1/2032. The planted fault: of 1/1000, which half floats do not hold. */
TEST_BETWEEN(half_floats_of_a_lattice_lose_nothing, setup, teardown)
{
    fixture *f = *state;
    OWNED(iso_planned_lattices) lattices;
    OWNED(iso_planned) p;
    open_plan(f, true, 1, &p);
    assert_ok(iso_planned_lattices_create(&p, true, false, 1, &lattices, &err));
    iso_lattice *l = &lattices.items[0];
    size_t halo = 0, lit = 0;
    for (size_t i = 0; i < l->size[0] * l->size[1] * l->size[2]; ++i) {
        const size_t x = i % l->size[0], y = i / l->size[0] % l->size[1], z = i / (l->size[0] * l->size[1]);
        const iso_lattice_use use = iso_lattice_use_of(l, x, y, z);
        const float *node = iso_lattice_node(l, x, y, z);
        halo += use == ISO_LATTICE_HALO;
        lit += use == ISO_LATTICE_LIT;
        if (use != ISO_LATTICE_LIT) /* nothing is lit there */
            assert_true(node[1] == 0 && node[2] == 0 && node[3] == 0);
    }
    if (getenv("ISOSHADE_TEST_VERBOSE"))
        printf("%zu nodes of a halo, %zu lit, background %g, %zu active, box %zu %zu %zu\n", halo, lit, l->background,
               l->active_count, l->size[0], l->size[1], l->size[2]);
    assert_true(halo > 0 && lit > 1000);
    assert_at_most(largest_loss(f, l), 1e-7);
    for (size_t i = 0; i < l->block_count[0] * l->block_count[1] * l->block_count[2]; ++i)
        for (size_t k = 0; l->blocks[i] && k < ISO_LATTICE_CUBE; ++k)
            for (size_t c = 1; c < ISO_NODE_CHANNELS; ++c)
                l->blocks[i]->nodes[k][c] = rintf(1000 * l->blocks[i]->nodes[k][c]) / 1000;
    assert_more_than(largest_loss(f, l), 1e-5);
}

/* A scene of a crop; to be freed: the bytes of its file of that suffix, whose samples have `bits`. */
static uint8_t *write_df3(const fixture *f, const iso_planned_crop *crop, const char *suffix, size_t *bits)
{
    const size_t *n = crop->level.geometry.size;
    const iso_pyramid p = {.options = {.code = ISO_CODE_FIT},
                           .source = "bytes",
                           .level_count = 1,
                           .levels = (iso_level *)&crop->level};
    iso_povray_options o = iso_povray_defaults();
    char *dir = iso_path_join(f->dir, "pov"), name[32], *data;
    snprintf(name, sizeof name, "pov_%s.df3", suffix);
    FREED char *path = iso_path_join(dir, name);
    size_t size;
    o.box = (const double(*)[3])crop->box;
    o.quantum = crop->quantum;
    o.lattice = &crop->lattice;
    assert_ok(iso_povray_export(&p, 0, &f->view, dir, &o, NULL, &err));
    assert_ok(iso_file_read(path, &data, &size, &err));
    *bits = 8 * (size - 6) / ((n[0] + 2) * (n[1] + 2) * (n[2] + 2));
    free(dir);
    return (uint8_t *)data;
}

/* Of a DF3 file the sample of voxel i, whose rim is one voxel. */
static const uint8_t *sample_at(const uint8_t *data, const size_t n[3], size_t i, size_t bytes)
{
    const size_t x = i % n[0] + 1, y = i / n[0] % n[1] + 1, z = i / (n[0] * n[1]) + 1;
    return data + 6 + bytes * (x + (n[0] + 2) * (y + (n[1] + 2) * z));
}

static const float *node_at(const iso_lattice *l, size_t i)
{
    return iso_lattice_node(l, i % l->size[0], i / l->size[0] % l->size[1], i / (l->size[0] * l->size[1]));
}

static size_t lit_node(const iso_lattice *l)
{
    size_t i = 0;
    while (iso_lattice_use_of(l, i % l->size[0], i / l->size[0] % l->size[1], i / (l->size[0] * l->size[1])) !=
           ISO_LATTICE_LIT)
        ++i;
    return i;
}

/* Of the scalars of a scene's DF3 file, in steps of their coding; bits: of the file. */
static double largest_df3_error(const fixture *f, const iso_planned_crop *crop, size_t *bits)
{
    const size_t *n = crop->level.geometry.size;
    const double lo = floor(crop->level.min / crop->quantum) * crop->quantum;
    FREED uint8_t *data = write_df3(f, crop, "scalar", bits);
    double worst = 0;
    for (size_t i = 0; i < n[0] * n[1] * n[2] && *bits == 16; ++i) {
        const uint8_t *at = sample_at(data, n, i, 2);
        worst = fmax(worst, fabs(lo + crop->quantum * (256 * at[0] + at[1]) - (double)node_at(&crop->lattice, i)[0]));
    }
    return worst / crop->quantum;
}

/* The planted faults: a value between two steps, and steps that are too many for 16 bits. */
TEST_BETWEEN(sixteen_bits_of_a_crop_lose_nothing, setup, teardown)
{
    fixture *f = *state;
    OWNED(iso_planned) p;
    OWNED(iso_planned_crop) crop;
    size_t bits;
    open_plan(f, true, 1, &p);
    assert_ok(iso_planned_crop_create(&p, &f->level0, 1, &crop, &err));
    assert_more_than(crop.quantum, 0);
    assert_at_most(largest_df3_error(f, &crop, &bits), 0);
    assert_int_equal(bits, 16);
    ((float *)node_at(&crop.lattice, lit_node(&crop.lattice)))[0] += (float)(0.25 * crop.quantum);
    assert_more_than(largest_df3_error(f, &crop, &bits), 0.2);
    crop.quantum /= 4;
    largest_df3_error(f, &crop, &bits);
    assert_int_equal(bits, 32);
}

/* Voxels whose component in a scene's DF3 file is not the one that the lattice's direction is coded as. */
static size_t wrong_directions(const fixture *f, const iso_planned_crop *crop, size_t axis)
{
    static const char *const suffixes[3] = {"dx", "dy", "dz"};
    const size_t *n = crop->level.geometry.size;
    size_t wrong = 0, bits;
    FREED uint8_t *data = write_df3(f, crop, suffixes[axis], &bits);
    assert_int_equal(bits, 8);
    for (size_t i = 0; i < n[0] * n[1] * n[2]; ++i) {
        uint8_t code[3];
        iso_code_encode(ISO_CODE_FIT, node_at(&crop->lattice, i) + 1, code, 1);
        wrong += *sample_at(data, n, i, 1) != (uint8_t)(128 + (int8_t)code[axis]);
    }
    return wrong;
}

/* The planted fault: a node that is not lit has a direction, which no file may have. */
TEST_BETWEEN(directions_of_a_crop_are_those_of_its_lit_nodes, setup, teardown)
{
    fixture *f = *state;
    OWNED(iso_planned) p;
    OWNED(iso_planned_crop) crop;
    open_plan(f, true, 1, &p);
    assert_ok(iso_planned_crop_create(&p, &f->level0, 1, &crop, &err));
    for (size_t axis = 0; axis < 3; ++axis)
        assert_int_equal(wrong_directions(f, &crop, axis), 0);
    iso_lattice *l = &crop.lattice;
    const size_t lit = lit_node(l);
    size_t in;
    (*iso_lattice_block_of(l, lit % l->size[0], lit / l->size[0] % l->size[1], lit / (l->size[0] * l->size[1]), &in))
        ->use[in] = ISO_LATTICE_HALO;
    size_t wrong = 0;
    for (size_t axis = 0; axis < 3; ++axis)
        wrong += wrong_directions(f, &crop, axis);
    assert_true(wrong > 0 && wrong <= 3);
}

TEST_MAIN(NULL, NULL)
