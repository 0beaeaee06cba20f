/* SPDX-License-Identifier: MIT */
/* cast_paged.h - rays whose bricks come from a file: each goes on until it meets a brick that is not there, and waits.
 *
 * A ray's place follows from the number of its segment, without rounding (cast_field.h), so that waiting does not
 * change a ray's samples. Its sums are kept with their rounding errors: the picture has the same bits. Bricks hidden by
 * opaque ones are never requested. Included after cast_tile.h. */
#pragma once

/* Bricks ahead of a waiting ray, which are loaded as well if pages are free. */
enum { BRICKS_AHEAD = 3 };

CAST int count_of(vi mask)
{
    int count = 0;
    EACH_RAY(i) count -= mask[i];
    return count;
}

static void ask(uint8_t *asked, int32_t brick, int which)
{
    __atomic_store_n(asked + ISO_CAST_ASKED * (size_t)brick + which, 1, __ATOMIC_RELAXED);
}

static void ask_ahead(const iso_cast *c, const packet *p, const points *at, int i, uint8_t *asked)
{
    float longest = 0;
    for (int a = 0; a < 3; ++a)
        longest = fmaxf(longest, fabsf(p->step[a][i]));
    for (int j = 1; j <= BRICKS_AHEAD && longest > 0; ++j) {
        int32_t brick = 0;
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
            const int32_t cell = at->cell[a][i] + (int32_t)((float)(j * ISO_CAST_BRICK) * (p->step[a][i] / longest));
            inside = inside && cell >= 0 && cell <= c->size[a];
            brick += (cell >> ISO_CAST_BRICK_SHIFT) * c->brick_stride[a];
        }
        if (!inside)
            break;
        ask(asked, brick, ISO_CAST_AHEAD);
    }
}

/* ---- the state between two passes ---- */

static void restore(const iso_cast_rays *rays, size_t first, packet *p, sums *s)
{
    vi left;
    memcpy(&left, rays->k + first, sizeof left);
    while (any(left > 0)) {
        const vi n = select_int(left > 32000, all_int(32000), left);
        advance_by(p, n);
        left -= n;
    }
    for (int a = 0; a < 4; ++a) {
        memcpy(&s->sum[a], rays->sum[a] + first, sizeof s->sum[a]);
        memcpy(&s->rest[a], rays->rest[a] + first, sizeof s->rest[a]);
    }
}

static void save(const packet *p, const sums *s, vi wants, iso_cast_rays *rays, size_t first)
{
    memcpy(rays->k + first, &p->k, sizeof p->k);
    memcpy(rays->wants + first, &wants, sizeof wants);
    for (int a = 0; a < 4; ++a) {
        memcpy(rays->sum[a] + first, &s->sum[a], sizeof s->sum[a]);
        memcpy(rays->rest[a] + first, &s->rest[a], sizeof s->rest[a]);
    }
}

/* True if any of these rays can advance. */
static bool can_go_on(const iso_cast *c, const iso_cast_rays *rays, size_t first)
{
    EACH_RAY(i)
    {
        const int32_t wants = rays->wants[first + (size_t)i];
        if (wants == ISO_CAST_NEW || (wants >= 0 && c->slots[wants] >= 0))
            return true;
    }
    return false;
}

/* ---- the rays ---- */

/* One segment of the rays that look at something; returns those that found their brick missing. */
CAST vi look_in_pages(const iso_cast *c, packet *p, sums *s, vi looks, vi *wants, uint8_t *asked)
{
    vf whole;
    const points at = middles(p, &whole);
    const vi brick = brick_at(c, at.cell) & looks, missing = looks & (GATHER(c->slots, brick, 4) < 0);
    if (any(missing)) {
        *wants = select_int(missing, brick, *wants);
        EACH_RAY(i)
        if (missing[i]) {
            ask(asked, brick[i], ISO_CAST_WANTED);
            ask_ahead(c, p, &at, i, asked);
        }
    }
    const vi there = looks & ~missing;
    if (!any(there))
        return missing;
    sample found = look(c, p, there);
    const vi shows = there & (found.depth > 0);
    if (any(shows))
        blend(c, p, &found, shows, s);
    advance(p, there);
    return missing;
}

CAST size_t go_on(const iso_cast *c, size_t x, size_t y, iso_cast_rays *rays, size_t first, uint8_t *asked, float *rgba)
{
    packet p = begin(c, x, y);
    sums s = begin_sums();
    vi wants, waiting = all_int(0);
    memcpy(&wants, rays->wants + first, sizeof wants);
    const vi is_done = wants == ISO_CAST_DONE;
    if (any(wants != ISO_CAST_NEW))
        restore(rays, first, &p, &s);
    for (;;) {
        const vi active = (p.k < p.count) & (s.sum[3] >= 1e-7f) & ~waiting & ~is_done;
        if (!any(active))
            break;
        const vi unknown = active & (p.k >= p.until);
        if (any(unknown))
            leave_blocks_once(c, &p, unknown);
        const vi looks = active & (p.k < p.until) & (p.k < p.count);
        if (any(looks))
            waiting |= look_in_pages(c, &p, &s, looks, &wants, asked);
    }
    save(&p, &s, select_int(waiting, wants, all_int(ISO_CAST_DONE)), rays, first);
    EACH_RAY(i)
    if (!waiting[i] && !is_done[i])
        write_pixel(c, &s, i, x + (size_t)(i % PACKET_COLUMNS), y + (size_t)(i / PACKET_COLUMNS), rgba);
    return (size_t)count_of(waiting);
}

static size_t count_waiting(const iso_cast_rays *rays, size_t first)
{
    size_t count = 0;
    EACH_RAY(i) count += rays->wants[first + (size_t)i] >= 0;
    return count;
}

#define ISO_CAST_PAGED_TILE_OF(width) ISO_CAST_JOIN(iso_cast_paged_tile_, width)

size_t ISO_CAST_PAGED_TILE_OF(ISO_CAST_WIDTH)(const iso_cast *c, size_t x, size_t y, iso_cast_rays *rays,
                                              uint8_t *asked, float *rgba)
{
    size_t first = 0, waiting = 0;
    for (size_t row = 0; row < ISO_CAST_TILE; row += PACKET_ROWS)
        for (size_t column = 0; column < ISO_CAST_TILE; column += PACKET_COLUMNS, first += ISO_CAST_WIDTH)
            waiting += can_go_on(c, rays, first) ? go_on(c, x + column, y + row, rays, first, asked, rgba)
                                                 : count_waiting(rays, first);
    return waiting;
}
