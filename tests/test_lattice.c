/* SPDX-License-Identifier: MIT */
/* Lattices and stores: what a plan leaves is what the bricks show, and an update bakes no less than it must. */
#include "test.h"

#include "base/random.h"
#include "brick/lattice.h"
#include "brick/pack.h"
#include "brick/store.h"
#include "volume/synthetic.h"

enum { LEVELS = 3, BRICK = 4 };

typedef struct scene {
    iso_volume volume;
    iso_node_levels nodes;
    uint8_t *levels, *drawn, *seen;
    iso_tf_table tf; /* a band: transparent below and above */
    iso_brick_field field;
    iso_random random;
} scene;

static void make_scene(scene *s, iso_field_kind kind, unsigned seed)
{
    const size_t size[3] = {18, 21, 11};
    iso_field f = {.kind = kind,
                   .geometry = iso_geometry_axis_aligned(size, (const double[]){1, 0.7, 2}),
                   .seed = seed};
    assert_ok(iso_field_sample(&f, ISO_F32, &s->volume, &err));
    iso_volume_stats stats = iso_volume_measure(&s->volume);
    iso_level level = {.geometry = f.geometry, .scalar = s->volume.data, .min = stats.min, .max = stats.max};
    assert_ok(iso_node_levels_create(&s->nodes, &level, BRICK, LEVELS, true, 0, &err));
    size_t count = iso_brick_count(&s->nodes);
    s->levels = malloc(count), s->drawn = malloc(count), s->seen = malloc(count);
    s->tf = (iso_tf_table){.count = 65, .lo = stats.min, .hi = stats.max, .entries = calloc(4 * 65, sizeof(float))};
    for (size_t i = 40; i < 50; ++i)
        s->tf.entries[4 * i + 3] = 1;
    s->field = (iso_brick_field){&s->nodes, s->levels, ISO_FACES_BAKED};
    s->random = (iso_random){seed};
    for (size_t i = 0; i < count; ++i)
        s->levels[i] = (uint8_t)iso_random_below(&s->random, LEVELS);
    iso_brick_cull(&s->field, &s->tf, NULL, 1, s->drawn);
    for (size_t i = 0; i < count; ++i) {
        s->seen[i] = iso_random_below(&s->random, 4) > 0;
        s->drawn[i] = s->drawn[i] && s->seen[i];
    }
}

static void destroy_scene(scene *s)
{
    free(s->tf.entries);
    free(s->levels);
    free(s->drawn);
    free(s->seen);
    iso_node_levels_destroy(&s->nodes);
    iso_volume_destroy(&s->volume);
}

static double extinction(const scene *s, double value)
{
    double entry[4];
    iso_tf_lookup(&s->tf, value, entry);
    return entry[3];
}

/* What a program has at node coordinates q: trilinear among active nodes and background. */
static void sample_lattice(const iso_lattice *l, const double q[3], double out[ISO_NODE_CHANNELS])
{
    long lo[3];
    double part[3];
    for (int a = 0; a < 3; ++a) {
        double u = ldexp(q[a], -(int)l->level) - (double)l->first[a];
        lo[a] = (long)floor(u);
        part[a] = u - (double)lo[a];
    }
    memset(out, 0, ISO_NODE_CHANNELS * sizeof *out);
    for (int c = 0; c < 8; ++c) {
        double weight = 1;
        bool inside = true;
        size_t at[3] = {0};
        for (int a = 0; a < 3; ++a) {
            long i = lo[a] + (c >> a & 1);
            weight *= c >> a & 1 ? part[a] : 1 - part[a];
            inside = inside && i >= 0 && i < (long)l->size[a];
            at[a] = inside ? (size_t)i : 0;
        }
        inside = inside && iso_lattice_use_of(l, at[0], at[1], at[2]) != ISO_LATTICE_UNUSED;
        const float *node = iso_lattice_node(l, at[0], at[1], at[2]);
        for (int k = 0; k < ISO_NODE_CHANNELS; ++k)
            out[k] += weight * (inside ? (double)node[k] : k == 0 ? l->background : 0);
    }
}

/* Compares at random points of the volume; what a brick of another level or an unseen one shows is no matter of this
 * lattice. Returns the largest difference, of the scalar's range, where either of them is seen at all. */
static double largest_difference(const scene *s, const iso_lattice *l, bool merged, size_t *shown)
{
    double worst = 0, range = s->nodes.max - s->nodes.min;
    iso_random random = {6};
    *shown = 0;
    for (int i = 0; i < 20000; ++i) {
        double q[3], a[ISO_NODE_CHANNELS], b[ISO_NODE_CHANNELS];
        size_t brick[3];
        for (int k = 0; k < 3; ++k) {
            double last = (double)(s->nodes.geometry.size[k] - 1);
            /* Merged at level 0 the edge goes on, as far as the box. */
            double rim = merged && l->level == 0 ? 0.5 : 0;
            q[k] = -rim + (last + 2 * rim) * iso_random_unit(&random);
            double at = fmin(fmax(q[k], 0), last) / BRICK;
            brick[k] = (size_t)at < s->nodes.count[k] ? (size_t)at : s->nodes.count[k] - 1;
        }
        size_t index = iso_brick_index(&s->nodes, brick);
        if (!(merged ? s->seen[index] : s->drawn[index] && s->levels[index] == l->level))
            continue;
        sample_lattice(l, q, a);
        iso_brick_sample(&s->field, iso_v3(q[0] + 0.5, q[1] + 0.5, q[2] + 0.5), b);
        if (extinction(s, a[0]) == 0 && (extinction(s, b[0]) == 0 || !s->drawn[index]))
            continue;
        ++*shown;
        for (int k = 0; k < ISO_NODE_CHANNELS; ++k)
            worst = fmax(worst, fabs(a[k] - b[k]) / (k ? 1 : range));
    }
    return worst;
}

static iso_lattice_options options_of(const scene *s, bool merged, size_t level)
{
    return (iso_lattice_options){.drawn = s->drawn,
                                 .seen = s->seen,
                                 .tfs = &s->tf,
                                 .tf_count = 1,
                                 .merged = merged,
                                 .level = level,
                                 .threads = 1};
}

TEST(merged_lattice_shows_what_the_bricks_show)
{
    for (unsigned seed = 1; seed <= 5; ++seed) {
        ENDED_BY(destroy_scene) scene s;
        OWNED(iso_lattice) l;
        size_t shown;
        make_scene(&s, ISO_FIELD_NOISE, seed);
        iso_lattice_options o = options_of(&s, true, 0);
        assert_ok(iso_lattice_create(&l, &s.field, &o, &err));
        assert_int_equal(l.level, 0);
        assert_within(extinction(&s, l.background), 0, 0);
        /* Directions are rounded to 1/1024 where they are sampled. */
        assert_at_most(largest_difference(&s, &l, true, &shown), 0.5 / 1024 + 1e-6);
        assert_true(shown > 100);
        assert_true(l.active_count < l.size[0] * l.size[1] * l.size[2]);
    }
}

TEST(lattice_of_a_level_has_its_bricks_to_the_last_bit_of_a_float)
{
    size_t all = 0;
    for (unsigned seed = 1; seed <= 5; ++seed)
        for (size_t level = 0; level < LEVELS; ++level) {
            scene s;
            iso_lattice l;
            size_t shown;
            make_scene(&s, ISO_FIELD_NOISE, seed);
            iso_lattice_options o = options_of(&s, false, level);
            if (iso_lattice_create(&l, &s.field, &o, NULL) == ISO_E_RANGE) { /* no brick of this level is drawn */
                destroy_scene(&s);
                continue;
            }
            assert_int_equal(l.level, level);
            assert_at_most(largest_difference(&s, &l, false, &shown), 1e-6);
            all += shown;
            iso_lattice_destroy(&l);
            destroy_scene(&s);
        }
    assert_true(all > 1000);
}

/* Node i of a lattice, x fastest. */
static uint8_t *activity_of(const iso_lattice *l, size_t i)
{
    size_t in;
    iso_lattice_block *block = *iso_lattice_block_of(l, i % l->size[0], i / l->size[0] % l->size[1],
                                                     i / (l->size[0] * l->size[1]), &in);
    return block ? &block->use[in] : NULL;
}

/* Planted faults: without the halo values between an active node and the background show; without one needed node the
 * field is another. */
TEST(lattice_without_its_halo_or_a_node_is_seen_to_differ)
{
    ENDED_BY(destroy_scene) scene s;
    OWNED(iso_lattice) l;
    size_t shown, halo = 0;
    make_scene(&s, ISO_FIELD_RAMP, 1);
    iso_lattice_options o = options_of(&s, true, 0);
    assert_ok(iso_lattice_create(&l, &s.field, &o, &err));
    size_t count = l.size[0] * l.size[1] * l.size[2];
    FREED uint8_t *needed = calloc(count, 1);
    for (size_t z = 0; z + 1 < l.size[2]; ++z)
        for (size_t y = 0; y + 1 < l.size[1]; ++y)
            for (size_t x = 0; x + 1 < l.size[0]; ++x) {
                double min = INFINITY, max = -INFINITY;
                size_t corners[8];
                bool complete = true;
                for (size_t c = 0; c < 8; ++c) {
                    const size_t at[3] = {x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)};
                    const double value = (double)*iso_lattice_node(&l, at[0], at[1], at[2]);
                    corners[c] = at[0] + l.size[0] * (at[1] + l.size[1] * at[2]);
                    min = fmin(min, value);
                    max = fmax(max, value);
                    complete = complete && iso_lattice_use_of(&l, at[0], at[1], at[2]) != ISO_LATTICE_UNUSED;
                }
                bool shows = false;
                for (size_t i = 0; i + 1 < s.tf.count; ++i) {
                    double v = s.tf.lo + (double)i * (s.tf.hi - s.tf.lo) / 64,
                           w = s.tf.lo + (double)(i + 1) * (s.tf.hi - s.tf.lo) / 64;
                    shows = shows ||
                            ((s.tf.entries[4 * i + 3] > 0 || s.tf.entries[4 * i + 7] > 0) && w > min && v < max);
                }
                for (int c = 0; c < 8 && complete && shows; ++c)
                    needed[corners[c]] = 1;
            }
    FREED uint8_t *all = calloc(count, 1);
    assert_non_null(all);
    for (size_t i = 0; i < count; ++i) {
        uint8_t *active = activity_of(&l, i);
        all[i] = active && *active;
        halo += all[i] && !needed[i];
        if (active)
            *active = needed[i];
    }
    assert_true(halo > 0);
    assert_more_than(largest_difference(&s, &l, true, &shown), 0.05);
    for (size_t i = 0; i < count; ++i) {
        uint8_t *active = activity_of(&l, i);
        if (active)
            *active = all[i] && i % 50 != 0; /* one in fifty */
    }
    assert_more_than(largest_difference(&s, &l, true, &shown), 0.05);
}

/* The largest difference of a halo's scalars from the field, of its range. */
static double largest_halo_error(const scene *s, const iso_lattice *l, size_t *count)
{
    double worst = 0;
    for (size_t i = 0; i < l->size[0] * l->size[1] * l->size[2]; ++i) {
        const size_t at[3] = {i % l->size[0], i / l->size[0] % l->size[1], i / (l->size[0] * l->size[1])};
        double q[3], value[ISO_NODE_CHANNELS];
        if (iso_lattice_use_of(l, at[0], at[1], at[2]) != ISO_LATTICE_HALO)
            continue;
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
            q[a] = ldexp((double)(l->first[a] + (long)at[a]), (int)l->level);
            inside = inside && q[a] >= 0 && q[a] <= (double)(s->nodes.geometry.size[a] - 1);
        }
        if (!inside) /* the edge that is repeated */
            continue;
        iso_brick_sample(&s->field, iso_v3(q[0] + 0.5, q[1] + 0.5, q[2] + 0.5), value);
        worst = fmax(worst, fabs(value[0] - (double)*iso_lattice_node(l, at[0], at[1], at[2])));
        ++*count;
    }
    return worst / (s->nodes.max - s->nodes.min);
}

/* In bricks that are coarser than the lattice, of its level, and finer. The planted fault: the halo as background. */
TEST(a_halo_holds_the_scalars_of_the_field)
{
    size_t count = 0;
    for (unsigned seed = 1; seed <= 5; ++seed)
        for (size_t level = 0; level <= LEVELS; ++level) {
            ENDED_BY(destroy_scene) scene s;
            iso_lattice l;
            make_scene(&s, ISO_FIELD_NOISE, seed);
            iso_lattice_options o = options_of(&s, level == LEVELS, level);
            /* In the merged lattice bricks that are finer are hidden. */
            for (size_t i = 0; i < iso_brick_count(&s.nodes) && level == LEVELS; ++i)
                s.drawn[i] = s.drawn[i] && s.levels[i] > 0;
            if (iso_lattice_create(&l, &s.field, &o, NULL) == ISO_OK) {
                size_t of_this = 0;
                assert_at_most(largest_halo_error(&s, &l, &of_this), 1.0 / 65536); /* rounded where it is sampled */
                for (size_t i = 0; i < l.block_count[0] * l.block_count[1] * l.block_count[2]; ++i)
                    for (size_t k = 0; l.blocks[i] && k < ISO_LATTICE_CUBE; ++k)
                        if (l.blocks[i]->use[k] == ISO_LATTICE_HALO)
                            l.blocks[i]->nodes[k][0] = l.empty[0];
                if (of_this > 20)
                    assert_more_than(largest_halo_error(&s, &l, &count), 0.01);
                iso_lattice_destroy(&l);
            }
        }
    assert_true(count > 100);
}

TEST(nodes_of_a_lattice_stand_where_the_volume_has_them)
{
    ENDED_BY(destroy_scene) scene s;
    make_scene(&s, ISO_FIELD_NOISE, 2);
    for (size_t level = 0; level < LEVELS; ++level) {
        OWNED(iso_lattice) l;
        iso_lattice_options o = options_of(&s, false, level);
        o.whole_box = level == 1;
        assert_ok(iso_lattice_create(&l, &s.field, &o, &err));
        iso_vec3 center = iso_geometry_to_world(&l.geometry, iso_v3(0.5, 1.5, 2.5));
        iso_vec3 index = iso_geometry_to_index(&s.nodes.geometry, center);
        double step = (double)(1u << level);
        assert_within(index.x, step * (double)l.first[0] + 0.5, 1e-12);
        assert_within(index.y, step * (double)(l.first[1] + 1) + 0.5, 1e-12);
        assert_within(index.z, step * (double)(l.first[2] + 2) + 0.5, 1e-12);
        if (o.whole_box)
            assert_true(iso_lattice_use_of(&l, 0, 0, 0) != ISO_LATTICE_UNUSED &&
                        iso_lattice_use_of(&l, l.size[0] - 1, l.size[1] - 1, l.size[2] - 1) != ISO_LATTICE_UNUSED);
    }
}

TEST(what_has_no_lattice_is_refused)
{
    ENDED_BY(destroy_scene) scene s;
    iso_lattice l;
    make_scene(&s, ISO_FIELD_NOISE, 3);
    iso_lattice_options o = options_of(&s, true, 0);
    s.field.faces = ISO_FACES_OWN;
    assert_status(iso_lattice_create(&l, &s.field, &o, &err), ISO_E_RANGE);
    s.field.faces = ISO_FACES_BAKED;
    memset(s.drawn, 0, iso_brick_count(&s.nodes));
    assert_status(iso_lattice_create(&l, &s.field, &o, &err), ISO_E_RANGE);
    assert_null(l.blocks);
}

/* ---- the store ------------------------------------------------------------------ */

TEST(an_update_leaves_what_baking_from_nothing_leaves)
{
    ENDED_BY(destroy_scene) scene s;
    OWNED(iso_brick_store) store = {0};
    make_scene(&s, ISO_FIELD_NOISE, 4);
    size_t count = iso_brick_count(&s.nodes), rebaked = 0, changed = 0;
    for (int round = 0; round < 40; ++round) {
        OWNED(iso_brick_store) scratch = {0};
        size_t baked, all;
        for (int k = 0; k < round % 4; ++k, ++changed)
            s.levels[iso_random_below(&s.random, count)] = (uint8_t)iso_random_below(&s.random, LEVELS);
        if (round % 3 == 0)
            s.drawn[iso_random_below(&s.random, count)] ^= 1;
        assert_ok(iso_brick_store_update(&store, &s.field, s.drawn, 1 + round % 2, &baked, &err));
        assert_ok(iso_brick_store_update(&scratch, &s.field, s.drawn, 1, &all, &err));
        assert_true(iso_brick_store_equal(&store, &scratch, &s.nodes));
        assert_true(round == 0 ? baked == all : baked < all);
        rebaked += round > 0 ? baked : 0;
    }
    assert_true(rebaked > 0 && rebaked <= 27 * changed + 40);
}

/* The planted fault: a store that follows the levels but does not look at neighbors. */
TEST(bricks_beside_a_change_do_change)
{
    ENDED_BY(destroy_scene) scene s;
    OWNED(iso_brick_store) before = {0}, after = {0};
    make_scene(&s, ISO_FIELD_NOISE, 5);
    size_t count = iso_brick_count(&s.nodes), middle[3] = {2, 2, 1}, different = 0;
    memset(s.levels, 0, count);
    memset(s.drawn, 1, count);
    assert_ok(iso_brick_store_update(&before, &s.field, s.drawn, 1, NULL, &err));
    s.levels[iso_brick_index(&s.nodes, middle)] = 2;
    assert_ok(iso_brick_store_update(&after, &s.field, s.drawn, 1, NULL, &err));
    size_t bytes = 5 * 5 * 5 * ISO_NODE_CHANNELS * sizeof(float);
    for (size_t i = 0; i < count; ++i)
        different += after.levels[i] == 0 && memcmp(before.bricks[i], after.bricks[i], bytes) != 0;
    assert_int_equal(different, 26);
    assert_false(iso_brick_store_equal(&before, &after, &s.nodes));
}

TEST_MAIN(NULL, NULL)
