/* SPDX-License-Identifier: MIT */
/* Mixed resolution has no seams: all bricks that hold a point agree on it, in every configuration. */
#include "noise_bricks.h"

#include <string.h>

#include "brick/occupancy.h"
#include "brick/pack.h"

/* Every choice of levels for the eight bricks round a corner: all faces, edges and corners there are. */
static void check_every_configuration(size_t brick_voxels, size_t level_count, int points)
{
    const size_t side = 2 * brick_voxels + 1, size[3] = {side, side, side};
    OWNED(iso_node_levels) n = noise_levels(size, brick_voxels, level_count, false);
    size_t configurations = (size_t)lrint(pow((double)level_count, 8));
    for (size_t k = 0; k < configurations; ++k) {
        uint8_t levels[8];
        bool mixed = false;
        for (size_t i = 0, rest = k; i < 8; ++i, rest /= level_count) {
            levels[i] = (uint8_t)(rest % level_count);
            mixed = mixed || levels[i] != levels[0];
        }
        iso_brick_field f = {.nodes = &n, .levels = levels, .faces = ISO_FACES_BAKED};
        double jump = worst_jump(&f, points);
        if (!(jump <= CONTINUOUS))
            fail_msg("levels %d%d%d%d%d%d%d%d: jump of %g", levels[0], levels[1], levels[2], levels[3], levels[4],
                     levels[5], levels[6], levels[7], jump);
        f.faces = ISO_FACES_OWN;
        if (mixed && level_count == 2)
            assert_more_than(worst_jump(&f, 2 * points), 0.02);
    }
}

TEST(every_configuration_of_two_levels_is_continuous_and_bricks_on_their_own_are_not)
{
    random_state = (iso_random){1};
    check_every_configuration(8, 2, 60);
}

TEST(every_configuration_of_three_levels_is_continuous)
{
    random_state = (iso_random){2};
    check_every_configuration(4, 3, 16);
}

TEST(random_layouts_of_four_levels_are_continuous_in_scalar_and_direction)
{
    random_state = (iso_random){3};
    static const size_t size[3] = {25, 33, 18}; /* the last axis ends inside a brick */
    OWNED(iso_node_levels) n = noise_levels(size, 8, 4, true);
    int rejected = 0;
    for (int layout = 0; layout < 1000; ++layout) {
        uint8_t levels[3 * 4 * 3];
        for (size_t i = 0; i < iso_brick_count(&n); ++i)
            levels[i] = (uint8_t)(4 * random_unit());
        iso_brick_field f = {.nodes = &n, .levels = levels, .faces = ISO_FACES_BAKED};
        double jump = worst_jump(&f, 12);
        if (!(jump <= CONTINUOUS))
            fail_msg("seed 3, layout %d: jump of %g", layout, jump);
        f.faces = ISO_FACES_OWN;
        rejected += worst_jump(&f, 12) > 0.02;
    }
    assert_int_equal(rejected, 1000);
}

/* Power of the test itself: at one known point the baked face has no jump, the brick's own nodes have one. */
TEST(a_face_of_own_nodes_is_found_out)
{
    random_state = (iso_random){4};
    static const size_t size[3] = {17, 17, 17};
    OWNED(iso_node_levels) n = noise_levels(size, 8, 2, false);
    uint8_t levels[8] = {0, 1, 1, 1, 1, 1, 1, 1};
    iso_brick_field f = {.nodes = &n, .levels = levels, .faces = ISO_FACES_BAKED};
    const double q[3] = {8, 3, 3};
    assert_at_most(jump_at(&f, q), CONTINUOUS);
    f.faces = ISO_FACES_OWN;
    assert_more_than(jump_at(&f, q), 1e-3);
}

/* Baking copies rows and finds bricks for ranges of nodes; node by node gives the same. */
static size_t bricks_unlike_their_nodes(const iso_brick_field *told, const iso_brick_field *f, const iso_tf_table *tf)
{
    const iso_node_levels *n = f->nodes;
    float baked[9 * 9 * 9 * ISO_NODE_CHANNELS];
    uint8_t visible[5 * 4 * 3];
    size_t unlike = 0;
    iso_brick_cull(told, tf, NULL, 1, visible);
    for (size_t i = 0; i < iso_brick_count(n); ++i) {
        const size_t *count = n->count, brick[3] = {i % count[0], i / count[0] % count[1], i / (count[0] * count[1])},
                     side = iso_brick_side(n, f->levels[i]);
        double min = INFINITY, max = -INFINITY;
        bool same = true;
        assert_ok(iso_brick_bake(told, brick, baked, &err));
        for (size_t k = 0; k < side * side * side; ++k) {
            double value[ISO_NODE_CHANNELS];
            iso_brick_node(f, brick, (const size_t[3]){k % side, k / side % side, k / (side * side)}, value);
            min = fmin(min, value[0]), max = fmax(max, value[0]);
            for (size_t c = 0; c < ISO_NODE_CHANNELS; ++c)
                same = same && baked[ISO_NODE_CHANNELS * k + c] == (float)value[c];
        }
        unlike += !same || visible[i] != iso_tf_shows(tf, min, max);
    }
    return unlike;
}

TEST(bricks_are_baked_and_told_by_their_nodes)
{
    random_state = (iso_random){6};
    static const size_t size[3] = {25, 33, 18};
    OWNED(iso_node_levels) n = noise_levels(size, 8, 4, true);
    size_t found = 0;
    for (int layout = 0; layout < 200; ++layout) {
        float entries[4 * 32] = {0};
        uint8_t levels[3 * 4 * 3];
        for (size_t i = 0; i < iso_brick_count(&n); ++i)
            levels[i] = (uint8_t)(4 * random_unit());
        entries[4 * (size_t)(32 * random_unit()) + 3] = 1; /* only a narrow band is visible */
        const iso_tf_table tf = {.count = 32, .lo = n.min, .hi = n.max, .entries = entries};
        const iso_brick_field f = {&n, levels, ISO_FACES_BAKED}, own = {&n, levels, ISO_FACES_OWN};
        if (bricks_unlike_their_nodes(&f, &f, &tf) > 0)
            fail_msg("seed 6, layout %d", layout);
        found += bricks_unlike_their_nodes(&own, &f, &tf) > 0; /* the fault: faces of its own */
    }
    assert_int_equal(found, 200);
}

TEST(interior_of_a_fine_brick_is_the_volume_itself)
{
    random_state = (iso_random){5};
    static const size_t size[3] = {17, 14, 17};
    OWNED(iso_node_levels) n = noise_levels(size, 8, 3, false);
    uint8_t levels[8] = {2, 1, 2, 1, 1, 2, 2, 0};
    iso_brick_field f = {.nodes = &n, .levels = levels, .faces = ISO_FACES_BAKED};
    for (size_t z = 9; z < 16; ++z)
        for (size_t x = 9; x < 16; ++x) {
            double value[ISO_NODE_CHANNELS];
            iso_brick_sample(&f, iso_v3((double)x + 0.5, 11.5, (double)z + 0.5), value);
            assert_within(value[0], (double)n.nodes[0][ISO_NODE_CHANNELS * (x + 17 * (11 + 17 * z))], 0);
        }
}

/* [1 2 1] keeps what is linear, and so do all interpolations: any layout shows the ramp. */
TEST(any_layout_reproduces_a_ramp_away_from_the_continued_edge)
{
    random_state = (iso_random){6};
    static const size_t size[3] = {33, 33, 33};
    iso_level level = {.geometry = iso_geometry_axis_aligned(size, (const double[3]){1, 1, 1}), .min = 0, .max = 224};
    OWNED(iso_node_levels) n;
    level.scalar = malloc(33 * 33 * 33 * sizeof *level.scalar);
    assert_non_null(level.scalar);
    for (size_t i = 0; i < 33 * 33 * 33; ++i)
        level.scalar[i] = (float)(i % 33 + 2 * (i / 33 % 33) + 4 * (i / 1089));
    assert_ok(iso_node_levels_create(&n, &level, 8, 3, true, 0, &err));
    for (int trial = 0; trial < 400; ++trial) {
        uint8_t levels[64];
        for (size_t i = 0; i < 64; ++i)
            levels[i] = (uint8_t)(3 * random_unit());
        iso_brick_field f = {.nodes = &n, .levels = levels, .faces = ISO_FACES_BAKED};
        /* Level 2 reaches 3 nodes around its own; its cell two of them 4 further. */
        double p[3], value[ISO_NODE_CHANNELS];
        for (int a = 0; a < 3; ++a)
            p[a] = 8 + 16 * random_unit();
        iso_brick_sample(&f, iso_v3(p[0] + 0.5, p[1] + 0.5, p[2] + 0.5), value);
        assert_within(value[0], p[0] + 2 * p[1] + 4 * p[2], 1e-4); /* floats up to 224 */
        assert_within(value[1], 1 / sqrt(21), 1e-6);
        assert_within(value[3], 4 / sqrt(21), 1e-6);
    }
    free(level.scalar);
}

/* ---- packing ------------------------------------------------------------------ */

/* What a GPU does: layout texel, local position, texels; in double, on the baked floats. */
static double fetch(const iso_node_levels *n, const iso_brick_pack *pack, const float *cache, const double q[3])
{
    size_t b[3], i = 0;
    for (int a = 2; a >= 0; --a) {
        b[a] = (size_t)(q[a] / (double)n->brick_voxels);
        b[a] = b[a] < n->count[a] ? b[a] : n->count[a] - 1;
        i = i * n->count[a] + b[a];
    }
    const float *layout = pack->layout + 4 * i;
    double value = 0, t[3];
    for (int a = 0; a < 3; ++a)
        t[a] = (double)layout[a] + (q[a] - (double)(b[a] * n->brick_voxels)) * (double)layout[3];
    for (int c = 0; c < 8; ++c) {
        double weight = 1;
        size_t texel[3];
        for (int a = 0; a < 3; ++a) {
            double part = t[a] - floor(t[a]);
            weight *= c >> a & 1 ? part : 1 - part;
            texel[a] = (size_t)t[a] + (size_t)(c >> a & 1);
        }
        if (weight > 0)
            value += weight * (double)cache[texel[0] + pack->size[0] * (texel[1] + pack->size[1] * texel[2])];
    }
    return value;
}

TEST(packed_bricks_do_not_overlap_and_give_the_field)
{
    random_state = (iso_random){7};
    static const size_t size[3] = {33, 41, 20};
    OWNED(iso_node_levels) n = noise_levels(size, 8, 4, false);
    size_t count = iso_brick_count(&n);
    uint8_t levels[4 * 5 * 3];
    for (size_t i = 0; i < count; ++i)
        levels[i] = (uint8_t)(4 * random_unit());
    iso_brick_field f = {.nodes = &n, .levels = levels, .faces = ISO_FACES_BAKED};
    OWNED(iso_brick_pack) pack;
    assert_ok(iso_brick_pack_create(&pack, &n, levels, NULL, 2048, 0, &err));
    assert_int_equal(pack.slot_side, 16);
    assert_int_equal(pack.brick_count, count);
    size_t texels = pack.size[0] * pack.size[1] * pack.size[2];
    FREED float *cache = malloc(texels * sizeof *cache);
    assert_non_null(cache);
    for (size_t i = 0; i < texels; ++i)
        cache[i] = NAN;
    for (size_t i = 0; i < count; ++i) {
        const size_t b[3] = {i % n.count[0], i / n.count[0] % n.count[1], i / (n.count[0] * n.count[1])};
        size_t side = iso_brick_side(&n, levels[i]);
        float baked[9 * 9 * 9 * ISO_NODE_CHANNELS];
        assert_ok(iso_brick_bake(&f, b, baked, &err));
        for (size_t k = 0; k < side * side * side; ++k) {
            size_t x = (size_t)pack.layout[4 * i] + k % side, y = (size_t)pack.layout[4 * i + 1] + k / side % side;
            size_t z = (size_t)pack.layout[4 * i + 2] + k / (side * side);
            float *texel = cache + x + pack.size[0] * (y + pack.size[1] * z);
            assert_true(isnan(*texel)); /* no other brick is there */
            *texel = baked[ISO_NODE_CHANNELS * k];
        }
    }
    for (int i = 0; i < 5000; ++i) {
        double q[3], value[ISO_NODE_CHANNELS];
        for (int a = 0; a < 3; ++a)
            q[a] = (double)(size[a] - 1) * random_unit();
        iso_brick_sample(&f, iso_v3(q[0] + 0.5, q[1] + 0.5, q[2] + 0.5), value);
        assert_within(fetch(&n, &pack, cache, q), value[0], 1e-7); /* baked values are rounded to float */
    }
}

TEST(eight_coarse_bricks_share_a_slot_and_hidden_ones_take_none)
{
    static const size_t size[3] = {129, 129, 33};
    OWNED(iso_node_levels) n = noise_levels(size, 32, 2, false);
    uint8_t levels[16], visible[16];
    memset(levels, 1, sizeof levels);
    memset(visible, 1, sizeof visible);
    size_t side;
    assert_int_equal(iso_brick_pack_slots(&n, levels, NULL, &side), 2);
    assert_int_equal(side, 34);
    levels[3] = 0;
    assert_int_equal(iso_brick_pack_slots(&n, levels, NULL, &side), 3);
    visible[3] = 0;
    assert_int_equal(iso_brick_pack_slots(&n, levels, visible, &side), 2);
    iso_brick_pack pack;
    assert_ok(iso_brick_pack_create(&pack, &n, levels, visible, 2048, 2, &err));
    assert_int_equal(pack.brick_count, 15);
    assert_within((double)pack.layout[4 * 3 + 3], 0, 0);
    iso_brick_pack_destroy(&pack);
    assert_status(iso_brick_pack_create(&pack, &n, levels, NULL, 2048, 2, &err), ISO_E_RANGE);
    /* A slot a texture: as many pages as slots; not even one slot in a texture. */
    assert_ok(iso_brick_pack_create(&pack, &n, levels, NULL, pack.slot_side, 0, &err));
    assert_int_equal(pack.page_count, 3);
    assert_int_equal(iso_brick_pack_texels(&n, levels, NULL, pack.slot_side),
                     3 * pack.slot_side * pack.slot_side * pack.slot_side);
    size_t slot_side = pack.slot_side;
    iso_brick_pack_destroy(&pack);
    assert_status(iso_brick_pack_create(&pack, &n, levels, NULL, slot_side - 1, 0, &err), ISO_E_RANGE);
}

/* A field of waves six voxels long and more, as a pyramid. */
static iso_pyramid make_waves(void)
{
    const size_t size[3] = {37, 41, 35};
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_pyramid p;
    iso_volume v = {.geometry = iso_geometry_axis_aligned(size, (const double[3]){1, 1, 1}), .type = ISO_F32};
    FREED float *values = malloc(size[0] * size[1] * size[2] * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < size[0] * size[1] * size[2]; ++i)
        values[i] = (float)(sin((double)(i % 37)) + cos(0.7 * (double)(i / 37 % 41)) +
                            sin(0.9 * (double)(i / 37 / 41)));
    v.data = values;
    build.level_count = 3;
    assert_ok(iso_pyramid_build(&v, "waves", &build, &p, NULL, &err));
    return p;
}

/* How far a whole level of nodes is from level 0 at its voxels, RMS. */
static double distance_to_level0(const iso_node_levels *n, const iso_level *level0, uint8_t level)
{
    FREED uint8_t *levels = malloc(iso_brick_count(n));
    assert_non_null(levels);
    memset(levels, level, iso_brick_count(n));
    const iso_brick_field f = {n, levels, ISO_FACES_BAKED};
    const size_t *size = level0->geometry.size;
    double sum = 0;
    size_t count = 0;
    for (size_t z = 5; z < 30; ++z)
        for (size_t y = 5; y < 36; ++y)
            for (size_t x = 5; x < 32; ++x, ++count) {
                double value[ISO_NODE_CHANNELS];
                iso_brick_sample(&f, iso_v3((double)x + 0.5, (double)y + 0.5, (double)z + 0.5), value);
                const double e = value[0] - (double)level0->scalar[x + size[0] * (y + size[1] * z)];
                sum += e * e;
            }
    return sqrt(sum / (double)count);
}

/* By [1 2 1] / 4 along each axis, levels 1 and 2 would be 0.457 and 1.098 away; at level 2 the waves are near the limit
 * of what nodes can show. */
TEST(nodes_are_nearer_to_the_volume_than_smoothed_ones_and_stay_in_range)
{
    OWNED(iso_pyramid) p = make_waves();
    OWNED(iso_node_levels) n;
    assert_ok(iso_node_levels_create(&n, &p.levels[0], 8, 3, false, 0, &err));
    assert_at_most(distance_to_level0(&n, &p.levels[0], 1), 0.95 * 0.457);
    assert_at_most(distance_to_level0(&n, &p.levels[0], 2), 0.95 * 1.098);
    for (size_t l = 0; l < 3; ++l)
        for (size_t i = 0, side = ((size_t)40 >> l) + 1; i < side * side * side; ++i) {
            assert_true((double)n.nodes[l][4 * i] >= p.levels[0].min && (double)n.nodes[l][4 * i] <= p.levels[0].max);
        }
}

/* ---- bricks by themselves -------------------------------------------------------- */

/* A volume of bytes that is read as it is, and levels for its bricks. */
typedef struct narrow_case {
    iso_volume volume;
    iso_level level;
    uint8_t levels[5 * 4 * 3];
} narrow_case;

static narrow_case make_narrow(void)
{
    const size_t size[3] = {37, 30, 21};
    narrow_case c = {.volume = {.geometry = iso_geometry_axis_aligned(size, (const double[3]){1, 0.8, 1.7}), .type = ISO_U8}};
    const size_t count = iso_geometry_voxel_count(&c.volume.geometry);
    uint8_t *bytes = malloc(count);
    assert_non_null(bytes);
    for (size_t i = 0; i < count; ++i)
        bytes[i] = (uint8_t)(256 * random_unit());
    for (size_t i = 0; i < sizeof c.levels; ++i)
        c.levels[i] = (uint8_t)(4 * random_unit());
    c.volume.data = bytes;
    c.level = (iso_level){.geometry = c.volume.geometry, .stored_type = ISO_U8, .min = 0, .max = 255};
    return c;
}

/* Bricks that differ from those of all nodes, in any bit. */
static size_t bricks_made_otherwise(narrow_case *c, const iso_node_levels *all, int threads)
{
    OWNED(iso_node_levels) made;
    size_t different = 0;
    c->level.samples = &c->volume;
    assert_ok(iso_node_levels_create_for(&made, &c->level, 8, 4, c->levels, NULL, threads, &err));
    assert_int_equal(iso_brick_count(&made), sizeof c->levels);
    const iso_brick_field a = {all, c->levels, ISO_FACES_OWN}, b = {&made, c->levels, ISO_FACES_OWN};
    for (size_t i = 0; i < sizeof c->levels; ++i) {
        const size_t at[3] = {i % 5, i / 5 % 4, i / 20}, side = iso_brick_side(all, c->levels[i]);
        const size_t bytes = side * side * side * ISO_NODE_CHANNELS * sizeof(float);
        float baked[2][9 * 9 * 9 * ISO_NODE_CHANNELS];
        assert_ok(iso_brick_make(&made, i, ISO_BRICK_WHOLE, &err));
        assert_ok(iso_brick_bake(&a, at, baked[0], &err));
        assert_ok(iso_brick_bake(&b, at, baked[1], &err));
        different += memcmp(baked[0], baked[1], bytes) != 0;
        iso_brick_forget(&made, i);
    }
    return different;
}

/* The planted fault: a plane of voxels that other bricks have, as far from a brick of level 3 as its nodes reach:
 * 2 (1 + 2 + 4) voxels. */
TEST(bricks_made_by_themselves_are_those_of_all_nodes_bit_by_bit)
{
    random_state = (iso_random){7};
    for (int threads = 1; threads <= 2; ++threads) {
        narrow_case c = make_narrow();
        const size_t count = iso_geometry_voxel_count(&c.level.geometry);
        FREED float *scalar = malloc(count * sizeof *scalar);
        OWNED(iso_node_levels) all;
        assert_non_null(scalar);
        iso_volume_floats(&c.volume, scalar);
        c.level.scalar = scalar;
        assert_ok(iso_node_levels_create(&all, &c.level, 8, 4, true, threads, &err));
        c.level.scalar = NULL;
        assert_int_equal(bricks_made_otherwise(&c, &all, threads), 0);
        memset(c.levels, 0, sizeof c.levels);
        c.levels[2] = 3; /* nodes 16 to 24 along x */
        for (size_t i = 16 - 14; i < count; i += c.level.geometry.size[0])
            ((uint8_t *)c.volume.data)[i] ^= 0x80;
        assert_int_equal(bricks_made_otherwise(&c, &all, threads), 12 + 1);
        iso_volume_destroy(&c.volume);
    }
}

/* Level 0 by brick, and ranges measured beforehand. The planted fault: a voxel that the begun nodes alone have. */
TEST(nodes_for_plans_have_the_bits_of_all_nodes)
{
    random_state = (iso_random){8};
    narrow_case c = make_narrow();
    OWNED(iso_node_levels) all, begun, other;
    c.level.samples = &c.volume;
    assert_ok(iso_node_levels_create(&all, &c.level, 8, 4, true, 2, &err));
    assert_ok(iso_node_levels_round(&all, 2, &err));
    assert_ok(iso_node_levels_begin(&begun, &c.level, 8, 4, 2, &err));
    assert_null(begun.nodes[1]);
    assert_ok(iso_node_levels_complete(&begun, 2, &err));
    for (int layout = 0; layout < 20; ++layout) {
        float entries[4 * 32] = {0};
        for (size_t i = 0; i < sizeof c.levels; ++i)
            c.levels[i] = (uint8_t)(4 * random_unit());
        entries[4 * (size_t)(32 * random_unit()) + 3] = 1;
        const iso_tf_table tf = {.count = 32, .lo = 0, .hi = 255, .entries = entries};
        const iso_brick_field f = {&all, c.levels, ISO_FACES_BAKED}, made = {&begun, c.levels, ISO_FACES_BAKED};
        assert_int_equal(bricks_unlike_their_nodes(&made, &f, &tf), 0);
        assert_int_equal(bricks_unlike_their_nodes(&f, &f, &tf), 0);
    }
    const iso_tf_table shows_all = {.count = 2, .lo = 0, .hi = 255, .entries = (float[]){1, 1, 1, 1, 1, 1, 1, 1}};
    memset(c.levels, 0, sizeof c.levels);
    ((uint8_t *)c.volume.data)[4 + 37 * (4 + 30 * 4)] ^= 0x80; /* in the first brick, away from its faces */
    assert_ok(iso_node_levels_begin(&other, &c.level, 8, 1, 1, &err));
    assert_int_equal(bricks_unlike_their_nodes(&(iso_brick_field){&other, c.levels, ISO_FACES_BAKED},
                                               &(iso_brick_field){&all, c.levels, ISO_FACES_BAKED}, &shows_all),
                     1);
    iso_volume_destroy(&c.volume);
}

TEST(bad_bricks_are_refused)
{
    float scalar = 0;
    iso_level level = {.geometry = iso_geometry_axis_aligned((const size_t[3]){1, 1, 1}, (const double[3]){1, 1, 1}),
                       .scalar = &scalar,
                       .max = 1};
    OWNED(iso_node_levels) n;
    assert_status(iso_node_levels_create(&n, &level, 24, 1, false, 1, &err), ISO_E_RANGE);
    assert_status(iso_node_levels_create(&n, &level, 128, 1, false, 1, &err), ISO_E_RANGE);
    assert_status(iso_node_levels_create(&n, &level, 4, 4, false, 1, &err), ISO_E_RANGE);
    assert_status(iso_node_levels_create(&n, &level, 4, 3, true, 1, &err), ISO_OK); /* one voxel is a volume */
}

TEST_MAIN(NULL, NULL)
