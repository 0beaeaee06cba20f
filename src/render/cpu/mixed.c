/* SPDX-License-Identifier: MIT */
#include "render/cpu/mixed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/simd.h"
#include "brick/occupancy.h"
#include "brick/pack.h"
#include "render/brick_visible.h"
#include "render/cpu/cast_scene.h"

enum { MOST_NODES = 1 << (31 - ISO_CAST_LEVEL_BITS), ROOM = 4 }; /* ROOM: nodes that a fetch may reach beyond the
                                                                  * last */

iso_cpu_brick_options iso_cpu_brick_defaults(void)
{
    return (iso_cpu_brick_options){.shaded = true, .node_bits = 16};
}

/* Data made from the bricks. */
typedef struct mixed {
    iso_cpu_scene *scene;
    const iso_brick_field *field;
    const iso_view *view;
    const iso_cpu_brick_options *opt;
    bool is_lit;
    size_t node_count;
    int32_t *places;
    void *nodes; /* as cast.h has them: integers, floats, small_nodes or large_nodes */
    iso_cast_blocks blocks;
    iso_tf_shown shown;
} mixed;

/* ---- where the nodes of each brick are ---- */

static size_t nodes_of(const iso_brick_field *f, size_t i)
{
    const size_t side = iso_brick_side(f->nodes, f->levels[i]);
    return side * side * side;
}

static void coordinates(const iso_node_levels *n, size_t i, size_t brick[3])
{
    brick[0] = i % n->count[0];
    brick[1] = i / n->count[0] % n->count[1];
    brick[2] = i / (n->count[0] * n->count[1]);
}

static int32_t *place_of(const mixed *m, size_t i)
{
    size_t brick[3];
    coordinates(m->field->nodes, i, brick);
    const int32_t *shift = m->scene->cast.places_shift;
    return m->places + (brick[0] + (brick[1] << shift[0]) + (brick[2] << shift[1]));
}

static iso_status place_bricks(mixed *m, iso_error *err)
{
    const iso_node_levels *n = m->field->nodes;
    const size_t count = iso_brick_count(n), places = n->count[2] << m->scene->cast.places_shift[1];
    FREED uint8_t *visible = malloc(count);
    m->places = malloc(places * sizeof *m->places);
    NEED(iso_cast_own(m->scene, m->places, places * sizeof *m->places, err));
    NEED_MEMORY(visible, err, "cpu: no memory for %zu bricks", count);
    iso_brick_visible(m->field, m->view, &m->view->tf, m->opt->wanted, m->scene->threads, visible);
    for (size_t i = 0; i < count; ++i) {
        int32_t *place = place_of(m, i);
        *place = -1;
        if (!visible[i])
            continue;
        *place = (int32_t)(m->node_count << ISO_CAST_LEVEL_BITS | m->field->levels[i]);
        m->node_count += nodes_of(m->field, i);
        if (m->node_count > MOST_NODES)
            return iso_fail(err, ISO_E_RANGE, "cpu: the bricks have more than %d nodes", (int)MOST_NODES);
    }
    return ISO_OK;
}

/* ---- the nodes ---- */

static size_t bytes_a_node(const mixed *m)
{
    return (m->is_lit ? ISO_NODE_CHANNELS : 1) * (size_t)m->opt->node_bits / 8;
}

/* Converts all channels of nodes as if they were components of directions. */
ISO_SIMD static void directions_to_16(const float *restrict nodes, size_t count, uint16_t *restrict out)
{
    for (size_t i = 0; i < ISO_NODE_CHANNELS * count; ++i) {
        const float above = nodes[i] > -1 ? nodes[i] : -1, inside = above < 1 ? above : 1;
        out[i] = (uint16_t)(int16_t)rintf(32767 * inside);
    }
}

/* Turns baked nodes into the stored form. The scalars are changed to their stored values. */
static void keep_small(const mixed *m, size_t first, size_t count, float *baked)
{
    const iso_node_levels *n = m->field->nodes;
    const size_t channels = m->is_lit ? ISO_NODE_CHANNELS : 1;
    uint16_t *out = (uint16_t *)m->nodes + channels * first;
    if (m->is_lit) /* three components, then the scalar: one place earlier than in a node */
        directions_to_16(baked + 1, count - 1, out);
    const size_t last = ISO_NODE_CHANNELS * (count - 1);
    for (size_t a = 0; m->is_lit && a < 3; ++a)
        out[last + a] = (uint16_t)iso_node_direction16(baked[last + 1 + a]);
    for (size_t i = 0; i < count; ++i) {
        float *scalar = baked + ISO_NODE_CHANNELS * i;
        const uint16_t kept = iso_node_scalar16(n, *scalar);
        out[channels * i + channels - 1] = kept;
        *scalar = (float)(n->min + (n->max - n->min) * kept / 65535);
    }
}

static void keep_large(const mixed *m, size_t first, size_t count, const float *baked)
{
    const size_t channels = m->is_lit ? ISO_NODE_CHANNELS : 1;
    float *out = (float *)m->nodes + channels * first;
    for (size_t i = 0; i < count; ++i, out += channels) {
        const float *node = baked + ISO_NODE_CHANNELS * i;
        memcpy(out, node + 1, (channels - 1) * sizeof *out);
        out[channels - 1] = (float)iso_node_part(m->field->nodes, node[0]);
    }
}

static void keep_nodes(const mixed *m, size_t first, size_t count, float *baked)
{
    if (m->opt->node_bits == 16)
        keep_small(m, first, count, baked);
    else
        keep_large(m, first, count, baked);
}

/* ---- empty space ---- */

/* Returns the index of a cell's block; word_of() and bit_of() find the cell in it. Counts include the cells before the
 * first node. */
static size_t block_of(const iso_cast_blocks *b, const size_t cell[3])
{
    return (cell[0] >> ISO_CAST_BLOCK_SHIFT) +
           b->count[0] * ((cell[1] >> ISO_CAST_BLOCK_SHIFT) + b->count[1] * (cell[2] >> ISO_CAST_BLOCK_SHIFT));
}
static size_t word_of(const iso_cast_blocks *b, const size_t cell[3])
{
    return 2 * block_of(b, cell) + (cell[2] >> 1 & 1);
}
static uint32_t bit_of(const size_t cell[3])
{
    return (uint32_t)1 << ((cell[0] & 3) + ((cell[1] & 3) << 2) + ((cell[2] & 1) << 4));
}

/* Cells of one word, to be marked at once: a word is shared by several bricks, thus threads. */
typedef struct cell_marks {
    size_t word;
    uint32_t bits;
} cell_marks;

static void flush_marks(const iso_cast_blocks *b, cell_marks *marks)
{
    uint32_t *word = b->cells + marks->word;
    if (marks->bits != 0)
#pragma omp atomic
        *word |= marks->bits;
    marks->bits = 0;
}

static void show_cell(const iso_cast_blocks *b, const size_t cell[3], cell_marks *marks)
{
    const size_t word = word_of(b, cell);
    if (word != marks->word)
        flush_marks(b, marks);
    marks->word = word;
    marks->bits |= bit_of(cell);
}

/* Marks the cells of level 0 within a brick's cell `at`, clipped at the end of the volume. */
static void show_cells(const mixed *m, const size_t brick[3], const size_t at[3], size_t level, cell_marks *marks)
{
    const iso_node_levels *n = m->field->nodes;
    const int32_t *last = m->scene->cast.last_cell;
    size_t from[3], to[3];
    for (int a = 0; a < 3; ++a) {
        from[a] = brick[a] * n->brick_voxels + (at[a] << level);
        to[a] = from[a] + ((size_t)1 << level);
        to[a] = to[a] <= (size_t)last[a] ? to[a] : (size_t)last[a] + 1;
    }
    for (size_t z = from[2]; z < to[2]; ++z)
        for (size_t y = from[1]; y < to[1]; ++y)
            for (size_t x = from[0]; x < to[0]; ++x)
                show_cell(&m->blocks, (const size_t[3]){x + ISO_CAST_OUTER, y + ISO_CAST_OUTER, z + ISO_CAST_OUTER},
                          marks);
}

static void show_brick(const mixed *m, size_t i, const float *baked)
{
    const iso_node_levels *n = m->field->nodes;
    cell_marks marks = {0};
    size_t brick[3];
    coordinates(n, i, brick);
    const size_t level = m->field->levels[i], side = iso_brick_side(n, level), row = ISO_NODE_CHANNELS * side;
    for (size_t z = 0; z + 1 < side; ++z)
        for (size_t y = 0; y + 1 < side; ++y)
            for (size_t x = 0; x + 1 < side; ++x) {
                const float *node = baked + ISO_NODE_CHANNELS * x + row * (y + side * z);
                float min = INFINITY, max = -INFINITY;
                for (size_t k = 0; k < 8; ++k) {
                    const float v = node[ISO_NODE_CHANNELS * (k & 1) + row * ((k >> 1 & 1) + side * (k >> 2))];
                    min = v < min ? v : min;
                    max = v > max ? v : max;
                }
                if (iso_tf_shown_in(&m->shown, (double)min, (double)max))
                    show_cells(m, brick, (const size_t[3]){x, y, z}, level, &marks);
            }
    flush_marks(&m->blocks, &marks);
}

/* Marks the layers of outer cells, whose positions are clamped to the outermost nodes: cells before the first node and
 * after the last along each axis, including those of earlier axes. */
static void show_outer_cells(const mixed *m)
{
    const int32_t *last = m->scene->cast.last_cell;
    const iso_cast_blocks *b = &m->blocks;
    cell_marks marks = {0};
    size_t from[3], to[3];
    for (int a = 0; a < 3; ++a) {
        from[a] = ISO_CAST_OUTER;
        to[a] = ISO_CAST_OUTER + (size_t)last[a];
    }
    for (int a = 0; a < 3; ++a) {
        const int u = (a + 1) % 3, v = (a + 2) % 3;
        for (size_t i = from[u]; i <= to[u]; ++i)
            for (size_t k = from[v]; k <= to[v]; ++k) {
                size_t inner[3], outer[3];
                inner[u] = outer[u] = i;
                inner[v] = outer[v] = k;
                inner[a] = from[a], outer[a] = from[a] - 1;
                if (b->cells[word_of(b, inner)] & bit_of(inner))
                    show_cell(b, outer, &marks);
                inner[a] = to[a], outer[a] = to[a] + 1;
                if (b->cells[word_of(b, inner)] & bit_of(inner))
                    show_cell(b, outer, &marks);
                flush_marks(b, &marks); /* the next cells look at them */
            }
        --from[a];
        ++to[a];
    }
}

static iso_status begin_blocks(mixed *m, iso_error *err)
{
    iso_cast_blocks *b = &m->blocks;
    b->blocks = 1;
    for (int a = 0; a < 3; ++a)
        b->blocks *= b->count[a] = (size_t)(m->scene->cast.last_cell[a] + 1 + ISO_CAST_OUTER) / 4 + 1;
    b->cells = calloc(2 * b->blocks, sizeof *b->cells);
    b->octants = malloc(ISO_OCTANTS * b->blocks + 4); /* four bytes are fetched for one */
    uint32_t *next = malloc(m->view->tf.count * sizeof *next);
    m->shown = (iso_tf_shown){.next = next};
    NEED_MEMORY(b->cells && b->octants && next, err, "cpu: no memory for %zu blocks", b->blocks);
    m->shown = iso_tf_shown_of(&m->view->tf, next);
    return ISO_OK;
}

static iso_status end_blocks(mixed *m, iso_error *err)
{
    iso_cast_blocks *b = &m->blocks;
    size_t occupied = 0;
    uint8_t *empty = malloc(b->blocks);
    NEED_MEMORY(empty, err, "cpu: no memory for %zu blocks", b->blocks);
    show_outer_cells(m);
    for (size_t i = 0; i < b->blocks; ++i) {
        empty[i] = !(b->cells[2 * i] | b->cells[2 * i + 1]);
        occupied += !empty[i];
    }
    b->occupied = (double)occupied / (double)b->blocks;
    memset(b->octants + ISO_OCTANTS * b->blocks, 0, 4);
    iso_occupancy_octants(b->count, empty, m->scene->threads, b->octants);
    free(empty);
    if (m->opt->skip == ISO_CPU_SKIP_ALWAYS || b->occupied <= ISO_CPU_SKIP_OCCUPIED)
        return iso_cast_use_blocks(m->scene, &m->field->nodes->geometry, m->view, b, err);
    return ISO_OK;
}

/* ---- all of it ---- */

static iso_status bake_bricks(const mixed *m, iso_error *err)
{
    const iso_node_levels *n = m->field->nodes;
    const size_t side = n->brick_voxels + 1, most = side * side * side;
    int failed = 0;
#pragma omp parallel num_threads(m->scene->threads) reduction(+ : failed)
    {
        float *baked = malloc(most * ISO_NODE_CHANNELS * sizeof *baked);
        failed += !baked;
#pragma omp for schedule(dynamic)
        for (size_t i = 0; i < iso_brick_count(n); ++i) {
            const int32_t place = *place_of(m, i);
            size_t brick[3];
            if (place < 0 || !baked)
                continue;
            coordinates(n, i, brick);
            if (iso_brick_bake(m->field, brick, baked, NULL) != ISO_OK) {
                ++failed;
                continue;
            }
            keep_nodes(m, (size_t)place >> ISO_CAST_LEVEL_BITS, nodes_of(m->field, i), baked);
            if (m->blocks.cells)
                show_brick(m, i, baked);
        }
        free(baked);
    }
    return failed ? iso_fail(err, ISO_E_MEMORY, "cpu: no memory for a brick of %zu nodes", most) : ISO_OK;
}

/* Makes the nodes. Omitted rays look at node 0 and at the nodes that follow in a brick of level 0. */
static iso_status make_nodes(mixed *m, iso_error *err)
{
    const size_t side = m->field->nodes->brick_voxels + 1, least = side * side * side;
    const size_t count = (m->node_count > least ? m->node_count : least) + ROOM, bytes = count * bytes_a_node(m);
    iso_cast *c = &m->scene->cast;
    const bool is_small = m->opt->node_bits == 16;
    m->nodes = calloc(bytes, 1);
    if (m->is_lit && is_small)
        c->small_nodes = m->nodes;
    else if (m->is_lit)
        c->large_nodes = m->nodes;
    else if (is_small)
        c->integers = m->nodes;
    else
        c->floats = m->nodes;
    c->normals = m->is_lit ? ISO_CAST_NODES : ISO_CAST_UNLIT;
    c->places = m->places;
    return iso_cast_own(m->scene, m->nodes, bytes, err);
}

static iso_status check(const mixed *m, double step_voxels, iso_error *err)
{
    const iso_view *view = m->view;
    const int bits = m->opt->node_bits;
    if (!(step_voxels > 0 && isfinite(step_voxels)) || (bits != 16 && bits != 32))
        return iso_fail(err, ISO_E_RANGE, "cpu: step %g voxels must be above 0, nodes of %d bits 16 or 32", step_voxels,
                        bits);
    if (view->tf_2d || view->extinction_scale || view->roi)
        return iso_fail(err, ISO_E_RANGE,
                        "cpu: bricks have no 2D transfer function, extinction scale or region of interest");
    return ISO_OK;
}

/* Returns the least b with 2^b >= n. */
static int32_t bits_for(size_t n)
{
    int32_t bits = 0;
    while ((size_t)1 << bits < n)
        ++bits;
    return bits;
}

static void set_volume(const mixed *m, double step_voxels)
{
    const iso_node_levels *n = m->field->nodes;
    iso_cast *c = &m->scene->cast;
    iso_cast_set_camera(c, &n->geometry, m->view, step_voxels * iso_geometry_min_spacing_mm(&n->geometry));
    iso_cast_set_light(c, m->view);
    if (!m->is_lit)
        c->light_count = 0;
    c->cells_before = ISO_CAST_OUTER - 0.5;
    c->cells_shift = bits_for(n->brick_voxels);
    c->places_shift[0] = bits_for(n->count[0]);
    c->places_shift[1] = c->places_shift[0] + bits_for(n->count[1]);
    for (int a = 0; a < 3; ++a)
        c->last_cell[a] = n->geometry.size[a] > 1 ? (int32_t)n->geometry.size[a] - 2 : 0;
}

static iso_status fill(mixed *m, iso_error *err)
{
    const iso_node_levels *n = m->field->nodes;
    const double step_voxels = m->opt->step_voxels > 0 ? m->opt->step_voxels : m->view->step_voxels;
    const double unit = (n->max - n->min) / (m->opt->node_bits == 16 ? 65535 : 1);
    NEED(check(m, step_voxels, err));
    set_volume(m, step_voxels);
    NEED(place_bricks(m, err));
    NEED(make_nodes(m, err));
    NEED(iso_cast_own_tf(m->scene, m->view, n->min, unit, err));
    if (m->opt->skip != ISO_CPU_SKIP_NEVER)
        NEED(begin_blocks(m, err));
    NEED(bake_bricks(m, err));
    return m->blocks.cells ? end_blocks(m, err) : ISO_OK;
}

iso_status iso_cpu_prepare_bricks(iso_cpu_scene **scene, const iso_brick_field *field, const iso_view *view,
                                  const iso_cpu_brick_options *opt, iso_error *err)
{
    mixed m = {.field = field, .view = view, .opt = opt, .is_lit = opt->shaded && iso_view_is_lit(view)};
    iso_status status = iso_cast_begin(scene, opt->width, opt->threads, err);
    m.scene = *scene;
    TRY(status, fill(&m, err));
    iso_cast_blocks_destroy(&m.blocks);
    free(m.shown.next);
    if (status != ISO_OK) {
        iso_cpu_release(*scene);
        *scene = NULL;
    }
    return status;
}

iso_status iso_cpu_render_bricks(const iso_brick_field *field, const iso_view *view, const iso_cpu_brick_options *opt,
                                 iso_image *image, iso_error *err)
{
    iso_cpu_scene *scene;
    *image = (iso_image){0};
    iso_status status = iso_cpu_prepare_bricks(&scene, field, view, opt, err);
    TRY(status, iso_image_create(image, view->width, view->height, err));
    if (status == ISO_OK)
        iso_cpu_draw(scene, image);
    iso_cpu_release(scene);
    return status;
}
