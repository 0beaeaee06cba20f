/* SPDX-License-Identifier: MIT */
/* What holds for any bricks of any levels, for their cache and their store, and for any plan (property.h). */
#include "folder.h"
#include "noise_bricks.h"
#include "property.h"

#include <jansson.h>

#include "brick/pack.h"
#include "brick/store.h"
#include "plan/plan.h"
#include "plan/planned.h"

static const char *because(const char *format, double a, double b)
{
    static char text[200];
    snprintf(text, sizeof text, format, a, b);
    return text;
}

/* ---- cases: a volume of noise in bricks ---- */

/* The numbers of a case: bricks of 2 << SIDE voxels, 1 + SIZE voxels along each axis, how many LEVELS, the SEED of the
 * noise, how many bricks are left out (HIDDEN), and the bricks' levels, which are repeated where there are more bricks.
 * A second layout differs in brick CHANGED, by CHANGE. */
enum { SIDE, SIZE, LEVELS = SIZE + 3, SEED, HIDDEN, CHANGED, CHANGE, LAYOUT, NUMBERS = LAYOUT + 24 };
#define ANY_BRICKS \
    { \
        [SIDE] = 2, [SIZE] = 10, [LEVELS] = 3, [SEED] = 1000, [HIDDEN] = 3, [CHANGED] = 100, [CHANGE] = 3, \
        [LAYOUT] = 3 \
    }

typedef struct layout {
    iso_node_levels nodes;
    size_t count;
    uint8_t *levels, *drawn;
} layout;

static layout layout_of(const unsigned *n)
{
    const size_t size[3] = {1 + n[SIZE], 1 + n[SIZE + 1], 1 + n[SIZE + 2]}, level_count = 1 + n[LEVELS] % (2 + n[SIDE]);
    random_state = (iso_random){n[SEED]};
    layout l = {.nodes = noise_levels(size, (size_t)2 << n[SIDE], level_count, true)};
    l.count = iso_brick_count(&l.nodes);
    l.levels = malloc(l.count);
    l.drawn = malloc(l.count);
    assert_non_null(l.levels);
    assert_non_null(l.drawn);
    for (size_t i = 0; i < l.count; ++i) {
        l.levels[i] = (uint8_t)(n[LAYOUT + i % (NUMBERS - LAYOUT)] % level_count);
        l.drawn[i] = i % 4 >= n[HIDDEN];
    }
    return l;
}

static void destroy_layout(layout *l)
{
    iso_node_levels_destroy(&l->nodes);
    free(l->levels);
    free(l->drawn);
}

static iso_brick_field field_of(const layout *l, iso_brick_faces faces)
{
    return (iso_brick_field){.nodes = &l->nodes, .levels = l->levels, .faces = faces};
}

static void brick_at(const iso_node_levels *n, size_t i, size_t b[3])
{
    b[0] = i % n->count[0], b[1] = i / n->count[0] % n->count[1], b[2] = i / (n->count[0] * n->count[1]);
}

/* ---- the field ---- */

/* Of the bricks whose closed boxes hold a voxel. */
static uint8_t coarsest_round(const layout *l, const size_t q[3])
{
    uint8_t coarsest = 0;
    for (size_t i = 0; i < l->count; ++i) {
        size_t b[3], side = l->nodes.brick_voxels;
        brick_at(&l->nodes, i, b);
        const bool holds = q[0] >= b[0] * side && q[0] <= (b[0] + 1) * side && q[1] >= b[1] * side &&
                           q[1] <= (b[1] + 1) * side && q[2] >= b[2] * side && q[2] <= (b[2] + 1) * side;
        coarsest = holds && l->levels[i] > coarsest ? l->levels[i] : coarsest;
    }
    return coarsest;
}

/* Every voxel is shown: as it is where no coarser brick touches it, else within the range of all. */
static const char *voxels_fail(const layout *l, const iso_brick_field *f)
{
    const iso_node_levels *n = &l->nodes;
    const size_t *size = n->geometry.size, nx = n->count[0] * n->brick_voxels + 1,
                 ny = n->count[1] * n->brick_voxels + 1;
    for (size_t i = 0; i < iso_geometry_voxel_count(&n->geometry); ++i) {
        const size_t q[3] = {i % size[0], i / size[0] % size[1], i / (size[0] * size[1])};
        const double own = (double)n->nodes[0][ISO_NODE_CHANNELS * (q[0] + nx * (q[1] + ny * q[2]))];
        double value[ISO_NODE_CHANNELS];
        iso_brick_sample(f, iso_v3((double)q[0] + 0.5, (double)q[1] + 0.5, (double)q[2] + 0.5), value);
        if (coarsest_round(l, q) == 0 && value[0] != own)
            return because("a voxel of %g is shown as %g", own, value[0]);
        if (!(value[0] >= n->min - 1e-6 && value[0] <= n->max + 1e-6)) /* nodes are floats */
            return because("a voxel of %g is shown as %g, out of the range", own, value[0]);
    }
    return NULL;
}

static const char *field_fails_with(const unsigned *n, iso_brick_faces faces)
{
    ENDED_BY(destroy_layout) layout l = layout_of(n);
    const iso_brick_field f = field_of(&l, faces);
    const double jump = worst_jump(&f, 40);
    const char *why = jump <= CONTINUOUS ? voxels_fail(&l, &f) : because("faces that bricks share jump by %g", jump, 0);
    return why;
}

static const char *field_fails(const unsigned *n)
{
    return field_fails_with(n, ISO_FACES_BAKED);
}

TEST(bricks_agree_on_shared_faces_and_show_each_voxel)
{
    static const iso_property p = {"bricks", NUMBERS, ANY_BRICKS, .cases = 200, .fails = field_fails};
    assert_property(&p);
}

/* ---- the cache ---- */

/* Each node of a drawn brick has a place of its own in the cache, within it. */
static const char *places_fail(const layout *l, const iso_brick_pack *pack)
{
    const size_t height = pack->size[2] * pack->page_count, texels = pack->size[0] * pack->size[1] * height;
    uint8_t *taken = calloc(texels, 1);
    size_t bricks = 0, nodes = 0;
    const char *why = taken ? NULL : "no memory";
    for (size_t i = 0; i < l->count && !why; ++i) {
        const float *at = pack->layout + 4 * i;
        const size_t side = iso_brick_side(&l->nodes, l->levels[i]),
                     from[3] = {(size_t)at[0], (size_t)at[1], (size_t)at[2]};
        if ((at[3] > 0) != (l->drawn[i] != 0) || (l->drawn[i] && at[3] != 1 / (float)(1 << l->levels[i])))
            return free(taken), because("brick %g has the scale %g", (double)i, (double)at[3]);
        for (size_t k = 0; l->drawn[i] && k < side * side * side && !why; ++k) {
            const size_t x = from[0] + k % side, y = from[1] + k / side % side, z = from[2] + k / (side * side);
            if (x >= pack->size[0] || y >= pack->size[1] || z >= height)
                why = because("brick %g leaves the cache at its node %g", (double)i, (double)k);
            else if (taken[x + pack->size[0] * (y + pack->size[1] * z)]++)
                why = because("node %g of brick %g lies on another's", (double)k, (double)i);
            ++nodes;
        }
        bricks += l->drawn[i];
    }
    free(taken);
    if (!why && (bricks != pack->brick_count || nodes != pack->node_count))
        why = because("the cache counts %g nodes of %g", (double)pack->node_count, (double)nodes);
    return why;
}

static const char *cache_fails_with(const unsigned *n, size_t moved)
{
    ENDED_BY(destroy_layout) layout l = layout_of(n);
    iso_brick_pack pack;
    iso_error err = {""};
    const char *why = "bricks cannot be packed";
    if (iso_brick_pack_create(&pack, &l.nodes, l.levels, l.drawn, 2048, 0, &err) == ISO_OK) {
        const size_t last = l.count - 1;
        for (int a = 0; a < 3 && moved && last > 0; ++a) /* planted: the last brick on the place of the one before */
            pack.layout[4 * last + (size_t)a] = pack.layout[4 * (last - 1) + (size_t)a];
        why = places_fail(&l, &pack);
        iso_brick_pack_destroy(&pack);
    }
    return why;
}

static const char *cache_fails(const unsigned *n)
{
    return cache_fails_with(n, 0);
}

TEST(each_node_has_a_place_of_its_own_in_the_cache)
{
    static const iso_property p = {"cache", NUMBERS, ANY_BRICKS, .cases = 300, .fails = cache_fails};
    assert_property(&p);
}

/* ---- the store ---- */

/* What is baked for a change is what is baked from nothing; without a change nothing is. */
static const char *store_fails_with(const unsigned *n, bool unnoticed)
{
    ENDED_BY(destroy_layout) layout l = layout_of(n);
    const iso_brick_field f = field_of(&l, ISO_FACES_BAKED);
    OWNED(iso_brick_store) kept = {0}, fresh = {0};
    iso_error err = {""};
    size_t again = 1;
    const char *why = NULL;
    if (iso_brick_store_update(&kept, &f, l.drawn, 1, NULL, &err) != ISO_OK ||
        iso_brick_store_update(&kept, &f, l.drawn, 1, &again, &err) != ISO_OK || again != 0)
        why = because("%g bricks are baked again though nothing changed", (double)again, 0);
    uint8_t *changed = l.levels + n[CHANGED] % l.count;
    *changed = (uint8_t)((*changed + n[CHANGE]) % l.nodes.level_count);
    /* Planted: the store is not told. */
    if (!why && ((!unnoticed && iso_brick_store_update(&kept, &f, l.drawn, 2, NULL, &err) != ISO_OK) ||
                 iso_brick_store_update(&fresh, &f, l.drawn, 1, NULL, &err) != ISO_OK ||
                 !iso_brick_store_equal(&kept, &fresh, &l.nodes)))
        why = "what is baked for a change is not what is baked from nothing";
    return why;
}

static const char *store_fails(const unsigned *n)
{
    return store_fails_with(n, false);
}

TEST(a_store_that_follows_a_change_is_one_made_from_nothing)
{
    static const iso_property p = {"store", NUMBERS, ANY_BRICKS, .cases = 100, .fails = store_fails};
    assert_property(&p);
}

/* ---- plans ---- */

enum { FORWARD = LAYOUT, PARALLEL = FORWARD + 3, OPACITY, ERRORS = OPACITY + 4, PLAN_NUMBERS = ERRORS + 4 };
#define ANY_PLAN \
    { \
        [SIDE] = 2, [SIZE] = 10, [LEVELS] = 3, [SEED] = 1000, [HIDDEN] = 0, [FORWARD] = 20, [PARALLEL] = 1, \
        [OPACITY] = 10, [ERRORS] = 100 \
    }
enum { ENTRIES = 4 };

/* Looked at from anywhere outside of the box, through four entries of any opacity. */
static iso_view view_of(const unsigned *n, const iso_geometry *g, float entries[4 * ENTRIES])
{
    const double radius = iso_geometry_box_radius_mm(g);
    iso_view v = {.width = 16, .height = 12, .shading = {.ambient = 0.2, .diffuse = 0.8}, .step_voxels = 1};
    v.camera.forward = iso_normalize(
        iso_v3((double)n[FORWARD] - 10, (double)n[FORWARD + 1] - 10.3, (double)n[FORWARD + 2]));
    v.camera.right = iso_normalize(
        iso_cross(v.camera.forward, fabs(v.camera.forward.z) < 0.9 ? iso_v3(0, 0, 1) : iso_v3(0, 1, 0)));
    v.camera.up = iso_cross(v.camera.right, v.camera.forward);
    v.camera.orthographic = n[PARALLEL] != 0;
    v.camera.half_height = v.camera.orthographic ? 0.8 * radius : 0.25;
    v.camera.position = iso_madd(iso_geometry_box_center_mm(g), v.camera.forward, -4 * radius);
    v.light_count = 1;
    v.lights[0] = (iso_light){.direction = iso_v3(0, 0, 1), .intensity = 1};
    for (int i = 0; i < ENTRIES; ++i) {
        entries[4 * i] = entries[4 * i + 1] = entries[4 * i + 2] = 0.25F * (float)(1 + i);
        entries[4 * i + 3] = 0.05F * (float)n[OPACITY + i];
    }
    v.tf = (iso_tf_table){.count = ENTRIES, .lo = 0, .hi = 1, .entries = entries};
    return v;
}

/* What a plan's levels cost, and the RMSE that its squares say of them. */
static double predicted_of(const iso_plan_errors *p, const iso_node_levels *n, size_t *nodes)
{
    double sum = 0;
    *nodes = 0;
    for (size_t i = 0; i < p->brick_count; ++i) {
        const size_t side = iso_brick_side(n, p->levels[i]);
        if (!p->shown[i] || !(p->footprints[i] > 0))
            continue;
        *nodes += side * side * side;
        sum += (double)p->squares[i * p->level_count + p->levels[i]];
    }
    return sqrt(sum / p->pixel_count);
}

/* A larger error allowed: no larger model, no smaller prediction, never above what is allowed. */
static const char *choices_fail(const unsigned *n, iso_plan_errors *p, const iso_node_levels *nodes, bool coarser)
{
    double allowed = 0, last = 0;
    size_t most = SIZE_MAX;
    for (size_t e = 0; e < 4; allowed += 1e-3 * n[ERRORS + e], ++e) {
        size_t taken;
        const double predicted = iso_plan_choose(p, nodes, allowed);
        for (size_t i = 0; coarser && i < p->brick_count; ++i) /* planted: levels that were not requested */
            p->levels[i] = (uint8_t)(p->level_count - 1);
        const double counted = predicted_of(p, nodes, &taken);
        for (size_t i = 0; i < p->brick_count; ++i)
            if (p->levels[i] >= p->level_count || (!coarser && p->levels[i] > 0 && !(p->footprints[i] > 0)))
                return because("brick %g has level %g", (double)i, p->levels[i]);
        /* Sums of the same numbers in the same order. */
        if (counted != predicted || !(predicted <= allowed))
            return because("an error of %g is predicted where %g is allowed", counted, allowed);
        if (taken > most || predicted < last)
            return because("%g nodes where less error allowed %g", (double)taken, (double)most);
        most = taken, last = predicted;
    }
    return NULL;
}

static const char *plan_fails_with(const unsigned *n, bool coarser)
{
    ENDED_BY(destroy_layout) layout l = layout_of(n);
    float entries[4 * ENTRIES];
    const iso_view view = view_of(n, &l.nodes.geometry, entries);
    iso_plan_errors plan;
    iso_error err = {""};
    const char *why = "there is no plan";
    if (iso_plan_errors_create(&plan, &l.nodes, &view, 1, 2, NULL, &err) == ISO_OK) {
        why = choices_fail(n, &plan, &l.nodes, coarser);
        for (size_t i = 0; i < plan.brick_count && !why; ++i)
            if (!(plan.footprints[i] >= 0 && plan.footprints[i] <= plan.pixel_count * (1 + 1e-6)) || /* float sums */
                plan.squares[i * plan.level_count] != 0)
                why = because("brick %g is seen by %g pixels", (double)i, (double)plan.footprints[i]);
        iso_plan_errors_destroy(&plan);
    }
    return why;
}

static const char *plan_fails(const unsigned *n)
{
    return plan_fails_with(n, false);
}

TEST(a_plan_stays_within_its_error_and_more_error_is_no_more_model)
{
    static const iso_property p = {"plan", PLAN_NUMBERS, ANY_PLAN, .cases = 400, .fails = plan_fails};
    assert_property(&p);
}

/* ---- the plan's file ---- */

static const char *file_fails_with(const unsigned *n, bool seen_is_lost)
{
    ENDED_BY(destroy_layout) layout l = layout_of(n);
    FREED char *path = iso_path_join(folder, "plan.json");
    FREED uint8_t *seen = malloc(l.count);
    OWNED(iso_plan_file) back = {0};
    iso_error err = {""};
    assert_non_null(path);
    assert_non_null(seen);
    for (size_t i = 0; i < l.count; ++i) /* what is drawn is seen; of the rest every second brick */
        seen[i] = l.drawn[i] || i % 2;
    json_auto_t *root = iso_plan_file_bricks(l.levels, l.drawn, seen, l.count);
    json_object_update_new(root, json_pack("{s:s, s:[i, i, i], s:i, s:i}", "schema", "isoshade.plan/1", "bricks",
                                           (int)l.nodes.count[0], (int)l.nodes.count[1], (int)l.nodes.count[2],
                                           "brick_voxels", (int)l.nodes.brick_voxels, "level_count",
                                           (int)l.nodes.level_count));
    const char *why = NULL;
    if (json_dump_file(root, path, 0) != 0 || iso_plan_file_load(path, &back, &err) != ISO_OK)
        why = "it cannot be read";
    for (size_t i = 0; seen_is_lost && i < l.count; ++i)
        seen[i] = 1;
    if (!why && (memcmp(back.levels, l.levels, l.count) != 0 || memcmp(back.drawn, l.drawn, l.count) != 0 ||
                 memcmp(back.seen, seen, l.count) != 0 || back.level_count != l.nodes.level_count ||
                 memcmp(back.count, l.nodes.count, sizeof back.count) != 0))
        why = "it is not read as it was written";
    return why;
}

static const char *file_fails(const unsigned *n)
{
    return file_fails_with(n, false);
}

TEST(a_plan_is_read_as_it_was_written)
{
    static const iso_property p = {"plan file", NUMBERS, ANY_BRICKS, .cases = 100, .fails = file_fails};
    assert_property(&p);
}

/* ---- planted faults ---- */

static const char *planted_faces(const unsigned *n)
{
    return field_fails_with(n, ISO_FACES_OWN);
}
static const char *planted_cache(const unsigned *n)
{
    return cache_fails_with(n, 1);
}
static const char *planted_store(const unsigned *n)
{
    return store_fails_with(n, true);
}
static const char *planted_plan(const unsigned *n)
{
    return plan_fails_with(n, true);
}
static const char *planted_file(const unsigned *n)
{
    return file_fails_with(n, true);
}

/* The smallest case that a property was shrunk to. */
static void assert_shrunk(const iso_property *p, const char *smallest)
{
    const char *failed = iso_property_try(p);
    assert_non_null(failed);
    if (!strstr(failed, smallest))
        fail_msg("%s; not %s", failed, smallest);
}

TEST(planted_faults_are_found_and_shrunk)
{
    static const iso_property planted[] = {{"faces", NUMBERS, ANY_BRICKS, .cases = 60, .fails = planted_faces},
                                           {"cache", NUMBERS, ANY_BRICKS, .cases = 60, .fails = planted_cache},
                                           {"store", NUMBERS, ANY_BRICKS, .cases = 60, .fails = planted_store},
                                           {"plan", PLAN_NUMBERS, ANY_PLAN, .cases = 60, .fails = planted_plan},
                                           {"file", NUMBERS, ANY_BRICKS, .cases = 60, .fails = planted_file}};
    static const char *const smallest[] = {
        "to 0 0 0 3 1 0 0 0 0 0 1 0 0 0",       /* two bricks of two voxels, one of them coarser */
        "to 0 0 0 3 0 0 0 0 0 0 0 0 0 0",       /* two bricks */
        "to 0 0 0 0 1 0 0 0 1 0 0 0 0 0",       /* one voxel, whose brick changes its level */
        "to 0 0 0 1 1 0 0 0 0 0 0 0 0 0 0 0 1", /* two voxels, two levels, one opacity above 0 */
        "to 0 0 0 0 0 0 1 0 0 0 0 0 0 0",       /* one brick, invisible */
    };
    for (size_t i = 0; i < sizeof planted / sizeof *planted; ++i)
        assert_shrunk(&planted[i], smallest[i]);
}

TEST_MAIN(make_folder, remove_folder)
