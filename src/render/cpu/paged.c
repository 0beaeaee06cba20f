/* SPDX-License-Identifier: MIT */
#include "render/cpu/paged.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "brick/occupancy.h"
#include "render/cpu/cast_bricks.h"
#include "render/cpu/cast_scene.h"

enum { BLOCK = 1 << ISO_CAST_BLOCK_SHIFT, BLOCK_ROWS = BLOCK + 1, LEAST_PAGES = 64 };
enum { MISSING = -1, EMPTY = -2 }; /* of slots: to be loaded; nothing of it shows, so that no ray asks for it */

typedef struct paged {
    iso_cast cast;
    iso_cast_paged_tile *tile;
    const iso_level *level;
    const iso_level_pages *pages;
    iso_cast_scalars scalars;
    bool is_lit;
    int threads;
    size_t brick_count[3], bricks, block_count[3], blocks, tiles[2];
    /* owned */
    float *entries;
    uint8_t *distance, *asked;
    int32_t *slots;
    iso_cast_rays *rays; /* a tile each */
    /* the pool */
    size_t pool, next;  /* pages, and the one that is replaced next: the oldest */
    iso_cast_pool voxels;
    int32_t *holds; /* the brick of each page, or -1 */
    int32_t *list;  /* the pages to be loaded */
    iso_paged_stats *stats;
} paged;

static size_t page_bytes(const paged *p)
{
    return ISO_CAST_VOXELS * iso_cast_voxel_bytes(&p->scalars, p->is_lit) + sizeof *p->holds + sizeof *p->list;
}

static double fixed_bytes(const paged *p, const iso_view *view)
{
    return (double)p->blocks + (double)p->bricks * (sizeof *p->slots + ISO_CAST_ASKED) +
           (double)(p->tiles[0] * p->tiles[1]) * sizeof *p->rays + 16.0 * (double)view->width * (double)view->height;
}

/* ---- making ---- */

static iso_status check_view(const iso_view *view, double step_voxels, iso_error *err)
{
    if (view->roi || view->tf_2d || view->extinction_scale)
        return iso_fail(
            err, ISO_E_USAGE,
            "paged: regions of interest, 2D transfer functions and scales of extinction need all of the volume");
    if (!(step_voxels > 0 && isfinite(step_voxels)))
        return iso_fail(err, ISO_E_RANGE, "paged: step %g voxels, must be above 0", step_voxels);
    return ISO_OK;
}

static void measure(paged *p, const iso_view *view)
{
    const size_t *size = p->level->geometry.size;
    int32_t stride = 1;
    p->bricks = p->blocks = 1;
    for (int a = 0; a < 3; ++a) {
        p->bricks *= p->brick_count[a] = size[a] / ISO_CAST_BRICK + 1;
        p->blocks *= p->block_count[a] = size[a] / BLOCK + 1;
        p->cast.size[a] = (int32_t)size[a];
        p->cast.brick_stride[a] = stride;
        p->cast.block_count[a] = (int32_t)p->block_count[a];
        stride *= (int32_t)p->brick_count[a];
    }
    p->tiles[0] = (view->width + ISO_CAST_TILE - 1) / ISO_CAST_TILE;
    p->tiles[1] = (view->height + ISO_CAST_TILE - 1) / ISO_CAST_TILE;
}

/* Rounds up to a tenth of a megabyte, so that the parts add up to the sum. */
static double tenths_of_mb(double bytes)
{
    return ceil(bytes / 104857.6) / 10;
}

static iso_status say_what_is_needed(double given, double empty, double rays, double pages, iso_error *err)
{
    const double parts[] = {tenths_of_mb(empty), tenths_of_mb(rays), tenths_of_mb(pages)};
    return iso_fail(err, ISO_E_RANGE,
                    "paged: %.1f MB are too little, this picture needs %.1f MB: %.1f for empty space, %.1f for rays "
                    "and the image, %.1f for %d pages",
                    given / 1048576, parts[0] + parts[1] + parts[2], parts[0], parts[1], parts[2], (int)LEAST_PAGES);
}

/* Allocates everything but the pool, which takes the rest of the memory. */
static iso_status allocate(paged *p, const iso_view *view, double memory_bytes, iso_error *err)
{
    const double fixed = fixed_bytes(p, view), pages = LEAST_PAGES * (double)page_bytes(p);
    if (!(memory_bytes >= fixed + pages))
        return say_what_is_needed(memory_bytes, (double)p->blocks, fixed - (double)p->blocks, pages, err);
    const double room = (memory_bytes - fixed) / (double)page_bytes(p);
    const size_t most = (size_t)(INT32_MAX / ISO_CAST_VOXELS) - 1;
    p->pool = room < (double)most ? (size_t)room : most;
    p->pool = p->pool < p->bricks ? p->pool : p->bricks;
    const size_t tiles = p->tiles[0] * p->tiles[1];
    size_t bytes;
    p->distance = malloc(p->blocks + 4); /* four bytes are fetched for one */
    p->asked = calloc(p->bricks, ISO_CAST_ASKED);
    p->slots = malloc(p->bricks * sizeof *p->slots);
    p->rays = calloc(tiles, sizeof *p->rays);
    p->holds = malloc(p->pool * sizeof *p->holds);
    p->list = malloc(p->pool * sizeof *p->list);
    NEED_MEMORY(p->distance && p->asked && p->slots && p->rays && p->holds && p->list &&
                    iso_cast_pool_create(&p->voxels, &p->scalars, p->is_lit, p->pool, &bytes),
                err, "paged: no memory for %zu pages", p->pool);
    memset(p->distance + p->blocks, 0, 4);
    for (size_t i = 0; i < p->pool; ++i)
        p->holds[i] = -1;
    for (size_t i = 0; i < tiles; ++i)
        for (size_t k = 0; k < ISO_CAST_RAYS; ++k)
            p->rays[i].wants[k] = ISO_CAST_NEW;
    iso_cast_pool_use(&p->voxels, &p->cast);
    p->cast.slots = p->slots;
    p->cast.distance = p->distance;
    p->stats->pool_bricks = p->pool;
    p->stats->bricks_of_level = p->bricks;
    p->stats->memory_bytes = fixed + (double)(p->pool * page_bytes(p));
    return ISO_OK;
}

static void release(paged *p)
{
    free(p->entries);
    free(p->distance);
    free(p->asked);
    free(p->slots);
    free(p->rays);
    free(iso_cast_pool_array(&p->voxels));
    free(p->holds);
    free(p->list);
}

static iso_status set_scene(paged *p, iso_code code, const iso_view *view, double step_voxels, iso_error *err)
{
    const iso_geometry *g = &p->level->geometry;
    size_t bytes;
    iso_cast *c = &p->cast;
    iso_cast_set_camera(c, g, view, step_voxels * iso_geometry_min_spacing_mm(iso_view_step_geometry(view, g)));
    iso_cast_set_light(c, view);
    c->labels = p->level->labels;
    c->has_integers = p->scalars.are_integers;
    c->voxel_words = iso_cast_voxel_words(&p->scalars);
    iso_cast_set_code(c, code, p->is_lit);
    p->entries = iso_cast_set_tf(c, view, p->level->min, iso_cast_unit(&p->scalars), &bytes);
    return p->entries ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "paged: no memory for the transfer function");
}

/* ---- empty space ---- */

static bool block_shows(const iso_tf_table *tf, const float *rows, size_t nx, size_t row_count, size_t bx)
{
    const size_t lo = iso_cast_inner(bx * BLOCK, nx), hi = iso_cast_inner(bx * BLOCK + BLOCK, nx);
    float min = rows[lo], max = min;
    for (size_t r = 0; r < row_count; ++r)
        for (size_t x = lo; x <= hi; ++x) {
            const float v = rows[r * nx + x];
            min = v < min ? v : min;
            max = v > max ? v : max;
        }
    return iso_tf_shows(tf, (double)min, (double)max);
}

/* Finds the visible blocks of a row along x; b[1], b[2]: its place in y and z. rows: buffer for BLOCK_ROWS^2 rows. */
static iso_status find_row_of_blocks(paged *p, const iso_tf_table *tf, const size_t b[3], float *rows, iso_error *err)
{
    const size_t *size = p->level->geometry.size;
    size_t first[3] = {0}, count[3] = {size[0]};
    for (int a = 1; a < 3; ++a) {
        first[a] = iso_cast_inner(b[a] * BLOCK, size[a]);
        count[a] = iso_cast_inner(b[a] * BLOCK + BLOCK, size[a]) - first[a] + 1;
    }
    const iso_status status = iso_level_pages_scalars(p->pages, first, count, rows, err);
    uint8_t *out = p->distance + p->block_count[0] * (b[1] + p->block_count[1] * b[2]);
    for (size_t x = 0; x < p->block_count[0] && status == ISO_OK; ++x)
        out[x] = block_shows(tf, rows, size[0], count[1] * count[2], x) ? 0 : 255;
    return status;
}

/* Keeps the first failure of several threads. */
static void keep_first(iso_status found, const iso_error *what, iso_status *status, iso_error *err)
{
    if (found == ISO_OK)
        return;
#pragma omp critical(iso_paged_failure)
    if (*status == ISO_OK) {
        *status = found;
        if (err)
            *err = *what;
    }
}

/* Marks bricks without a visible block as empty, all others as missing. */
static void mark_empty_bricks(paged *p)
{
    enum { BLOCKS = ISO_CAST_BRICK / BLOCK };
    for (size_t i = 0; i < p->bricks; ++i)
        p->slots[i] = EMPTY;
    for (size_t z = 0; z < p->block_count[2]; ++z)
        for (size_t y = 0; y < p->block_count[1]; ++y)
            for (size_t x = 0; x < p->block_count[0]; ++x)
                if (p->distance[x + p->block_count[0] * (y + p->block_count[1] * z)] == 0)
                    p->slots[x / BLOCKS + p->brick_count[0] * (y / BLOCKS + p->brick_count[1] * (z / BLOCKS))] =
                        MISSING;
}

static iso_status find_empty(paged *p, const iso_tf_table *tf, const iso_progress *progress, iso_error *err)
{
    const size_t rows_of_blocks = p->block_count[1] * p->block_count[2];
    iso_status status = ISO_OK;
    size_t done = 0;
#pragma omp parallel num_threads(p->threads)
    {
        float *rows = malloc(BLOCK_ROWS * BLOCK_ROWS * p->level->geometry.size[0] * sizeof *rows);
        iso_error own = {""};
#pragma omp for schedule(dynamic, 16)
        for (size_t i = 0; i < rows_of_blocks; ++i) {
            const size_t b[3] = {0, i % p->block_count[1], i / p->block_count[1]};
            keep_first(rows ? find_row_of_blocks(p, tf, b, rows, &own)
                            : iso_fail(&own, ISO_E_MEMORY, "paged: no memory for rows of the level"),
                       &own, &status, err);
            const size_t before = __atomic_fetch_add(&done, 1, __ATOMIC_RELAXED);
            if (iso_thread_index() == 0 && before % 64 == 0)
                iso_progress_report(progress, "empty space", (double)before / (double)rows_of_blocks);
        }
        free(rows);
    }
    if (status != ISO_OK)
        return status;
    mark_empty_bricks(p);
    iso_occupancy_distance(p->block_count, p->distance);
    return ISO_OK;
}

/* ---- pages ---- */

static iso_status load_page(paged *p, size_t page, iso_error *err)
{
    float scalars[ISO_CAST_VOXELS];
    uint8_t codes[3 * ISO_CAST_VOXELS];
    const iso_cast_box box = iso_cast_box_of(p->level->geometry.size, p->brick_count, (size_t)p->holds[page]);
    NEED(iso_level_pages_scalars(p->pages, box.first, box.count, scalars, err));
    if (p->is_lit)
        NEED(iso_level_pages_codes(p->pages, box.first, box.count, codes, err));
    iso_cast_pool_fill(&p->voxels, &p->scalars, p->cast.is_signed, p->level->geometry.size, &box, scalars, codes, page);
    return ISO_OK;
}

/* Gives the oldest page to a brick. Its own brick has to be asked for again. */
static void assign(paged *p, size_t brick, size_t *count)
{
    const size_t page = p->next;
    p->next = (p->next + 1) % p->pool;
    if (p->holds[page] >= 0)
        p->slots[p->holds[page]] = MISSING;
    p->holds[page] = (int32_t)brick;
    p->slots[brick] = (int32_t)(page * ISO_CAST_VOXELS);
    p->list[(*count)++] = (int32_t)page;
}

/* Chooses the pages of the next pass: bricks that rays wait for, then those ahead, until the pool is full. */
static size_t choose(paged *p)
{
    size_t count = 0;
    for (size_t i = 0; i < p->bricks && count < p->pool; ++i)
        if (p->asked[ISO_CAST_ASKED * i + ISO_CAST_WANTED]) {
            p->asked[ISO_CAST_ASKED * i + ISO_CAST_WANTED] = 0;
            if (p->slots[i] < 0)
                assign(p, i, &count);
        }
    const size_t wanted = count;
    for (size_t i = 0; i < p->bricks; ++i) {
        uint8_t *ahead = p->asked + ISO_CAST_ASKED * i + ISO_CAST_AHEAD;
        if (*ahead && wanted > 0 && count < p->pool && p->slots[i] == MISSING)
            assign(p, i, &count);
        *ahead = 0;
    }
    return count;
}

static iso_status load_pages(paged *p, size_t count, iso_error *err)
{
    iso_status status = ISO_OK;
#pragma omp parallel for schedule(dynamic, 16) num_threads(p->threads)
    for (size_t i = 0; i < count; ++i) {
        iso_error own = {""};
        keep_first(load_page(p, (size_t)p->list[i], &own), &own, &status, err);
    }
    p->stats->bricks += count;
    return status;
}

/* ---- passes ---- */

static size_t cast_all(paged *p, float *rgba)
{
    size_t waiting = 0;
#pragma omp parallel for schedule(dynamic) num_threads(p->threads) reduction(+ : waiting)
    for (size_t i = 0; i < p->tiles[0] * p->tiles[1]; ++i)
        waiting += p->tile(&p->cast, i % p->tiles[0] * ISO_CAST_TILE, i / p->tiles[0] * ISO_CAST_TILE, &p->rays[i],
                           p->asked, rgba);
    return waiting;
}

static iso_status draw(paged *p, iso_image *image, const iso_progress *progress, iso_error *err)
{
    const double rays = (double)image->width * (double)image->height;
    for (size_t waiting = 1; waiting > 0;) {
        waiting = cast_all(p, image->rgba);
        ++p->stats->passes;
        iso_progress_report(progress, "draw", fmax(0, 1 - (double)waiting / rays));
        if (waiting > 0)
            NEED(load_pages(p, choose(p), err));
    }
    return ISO_OK;
}

iso_status iso_cpu_render_paged(const iso_level *level, iso_code code, const iso_level_pages *pages,
                                const iso_view *view, const iso_paged_options *opt, iso_image *image,
                                iso_paged_stats *stats, const iso_progress *progress, iso_error *err)
{
    const double start = iso_clock_seconds(), read_before = iso_level_pages_bytes_read(pages),
                 step_voxels = opt->step_voxels > 0 ? opt->step_voxels : view->step_voxels;
    paged p = {.level = level,
               .pages = pages,
               .scalars = iso_cast_scalars_of(level),
               .is_lit = iso_view_is_lit(view),
               .threads = iso_threads(opt->threads),
               .stats = stats,
               .tile = iso_cast_paged_tile_of(opt->width ? opt->width : iso_cpu_widest())};
    *image = (iso_image){0};
    *stats = (iso_paged_stats){0};
    iso_status status = check_view(view, step_voxels, err);
    if (status == ISO_OK && !p.tile)
        status = iso_fail(err, ISO_E_RANGE, "paged: this machine does not cast %d rays at a time", (int)opt->width);
    measure(&p, view);
    TRY(status, allocate(&p, view, opt->memory_bytes, err));
    TRY(status, set_scene(&p, code, view, step_voxels, err));
    TRY(status, find_empty(&p, &view->tf, progress, err));
    TRY(status, iso_image_create(image, view->width, view->height, err));
    TRY(status, draw(&p, image, progress, err));
    release(&p);
    stats->bytes_read = iso_level_pages_bytes_read(pages) - read_before;
    stats->seconds = iso_clock_seconds() - start;
    if (status != ISO_OK)
        iso_image_destroy(image);
    return status;
}
