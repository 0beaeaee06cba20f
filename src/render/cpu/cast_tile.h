/* SPDX-License-Identifier: MIT */
/* cast_tile.h - a tile of pixels with empty space left out, by the packets of cast_packet.h.
 *
 * Pixels that can show nothing are written at once; the others' rays begin where their part of the picture can show
 * something and end behind it (render/screen_reach.h). */
#ifndef ISO_RENDER_CPU_CAST_TILE_H
#define ISO_RENDER_CPU_CAST_TILE_H

#include "render/cpu/cast_packet.h"
#include "render/screen_reach.h"

/* All rays of a tile, and the ones at work: rays that are done leave their place to the next of the tile, because most end
 * early and a packet would wait for its last. */
typedef struct tile {
    packet rays[ISO_CAST_TILE * ISO_CAST_TILE / ISO_CAST_WIDTH];
    uint8_t column[ISO_CAST_TILE * ISO_CAST_TILE / ISO_CAST_WIDTH], row[ISO_CAST_TILE * ISO_CAST_TILE / ISO_CAST_WIDTH];
    int next, count; /* rays */
    int at_work[ISO_CAST_WIDTH]; /* which ray; -1: none */
    packet p;
    sums s;
    sample found;
    vi shows; /* has found a sample, and waits for its light */
} tile;

/* Leaves out the segments in front of what a tile of pixels can show, and ends behind it. */
CAST void narrow(const iso_cast *c, const float reach_mm[2], packet *p)
{
    int32_t skip[ISO_CAST_WIDTH], end[ISO_CAST_WIDTH];
    const double from = floor(reach_mm[0] / c->step_mm), to = floor(reach_mm[1] / c->step_mm) + 1;
    EACH_RAY(i)
    {
        const double first = p->first[i], count = p->count[i];
        const double begin = from - first, stop = to - first;
        end[i] = (int32_t)(stop < count ? (stop > 0 ? stop : 0) : count);
        skip[i] = (int32_t)(begin > 0 ? (begin < end[i] ? begin : end[i]) : 0);
        skip[i] = skip[i] < 32000 ? skip[i] : 32000; /* what advance_by() takes; the rest is found empty */
    }
    vi n;
    memcpy(&n, skip, sizeof n);
    memcpy(&p->end, end, sizeof end);
    advance_by(p, n);
}

static void take_ray(tile *t, int i, int ray)
{
    const packet *from = &t->rays[ray / ISO_CAST_WIDTH];
    const int j = ray % ISO_CAST_WIDTH;
    packet *p = &t->p;
    p->count[i] = from->count[j];
    p->front_cut[i] = from->front_cut[j];
    p->back_cut[i] = from->back_cut[j];
    for (int a = 0; a < 3; ++a) {
        p->at.cell[a][i] = from->at.cell[a][j];
        p->at.part[a][i] = from->at.part[a][j];
        p->stride.cell[a][i] = from->stride.cell[a][j];
        p->stride.part[a][i] = from->stride.part[a][j];
        p->step[a][i] = from->step[a][j];
    }
    p->end[i] = from->end[j];
    p->k[i] = from->k[j];
    p->until[i] = 0;
    p->to_viewer.x[i] = from->to_viewer.x[j];
    p->to_viewer.y[i] = from->to_viewer.y[j];
    p->to_viewer.z[i] = from->to_viewer.z[j];
    for (int k = 0; k < 4; ++k)
        t->s.sum[k][i] = k == 3, t->s.rest[k][i] = 0;
    t->at_work[i] = ray;
}

/* Writes the pixels of the rays that are done, and gives their places to others. */
static void refill(const iso_cast *c, tile *t, vi done, size_t x, size_t y, float *rgba)
{
    EACH_RAY(i)
    {
        if (!done[i])
            continue;
        if (t->at_work[i] >= 0) {
            const int ray = t->at_work[i], packet_at = ray / ISO_CAST_WIDTH, j = ray % ISO_CAST_WIDTH;
            const int column = t->column[packet_at] + j % PACKET_COLUMNS;
            const int row = t->row[packet_at] + j / PACKET_COLUMNS;
            write_pixel(c, &t->s, i, x + (size_t)column, y + (size_t)row, rgba);
        }
        t->at_work[i] = -1;
        t->p.end[i] = 0;
        if (t->next < t->count)
            take_ray(t, i, t->next++);
    }
}

/* Rays that miss the volume are done when they are taken, and still have to be written. */
static bool is_empty(const tile *t)
{
    EACH_RAY(i)
    if (t->at_work[i] >= 0)
        return false;
    return true;
}

CAST int count_of(vi mask)
{
    int count = 0;
    EACH_RAY(i) count -= mask[i];
    return count;
}

/* The rays of the tile that can show anything; the pixels of the others are written. */
CAST void begin_tile(const iso_cast *c, tile *t, size_t x, size_t y, float *rgba)
{
    const sums nothing = begin_sums();
    t->count = 0;
    for (size_t row = 0; row < ISO_CAST_TILE && y + row < c->height; row += PACKET_ROWS)
        for (size_t column = 0; column < ISO_CAST_TILE && x + column < c->width; column += PACKET_COLUMNS) {
            const int at = t->count / ISO_CAST_WIDTH;
            const float *mm = c->reach_mm +
                              2 * ((y + row) / ISO_SCREEN_TILE * c->reach_columns + (x + column) / ISO_SCREEN_TILE);
            if (mm[0] <= mm[1]) {
                t->rays[at] = begin(c, x + column, y + row);
                narrow(c, mm, &t->rays[at]);
                t->column[at] = (uint8_t)column;
                t->row[at] = (uint8_t)row;
                t->count += ISO_CAST_WIDTH;
                continue;
            }
            EACH_RAY(i)
            write_pixel(c, &nothing, i, x + column + (size_t)(i % PACKET_COLUMNS),
                        y + row + (size_t)(i / PACKET_COLUMNS), rgba);
        }
}

/* Each ray by itself: past empty blocks, to its next sample that shows, and then it waits until half of the others have one,
 * too. */
CAST void cast_sparse_tile(const iso_cast *c, size_t x, size_t y, float *rgba)
{
    enum { HALF = (ISO_CAST_WIDTH + 1) / 2 };
    tile t;
    t.next = 0;
    t.p = (packet){0};
    t.found = (sample){0}; /* rays that wait for nothing yet are filtered with the others */
    t.shows = all_int(0);
    begin_tile(c, &t, x, y, rgba);
    t.s = begin_sums();
    EACH_RAY(i) t.at_work[i] = -1;
    for (;;) {
        vi active = (t.p.k < t.p.end) & (t.s.sum[3] >= 1e-7f);
        const int idle = ISO_CAST_WIDTH - count_of(active);
        if (idle >= HALF / 2 + 1 || idle == ISO_CAST_WIDTH) {
            refill(c, &t, ~(active | t.shows), x, y, rgba);
            active = (t.p.k < t.p.end) & (t.s.sum[3] >= 1e-7f);
            if (is_empty(&t))
                break;
        }
        const vi ask = active & ~t.shows & (t.p.k >= t.p.until);
        if (any(ask))
            leave_blocks_once(c, &t.p, ask);
        const vi looks = active & ~t.shows & (t.p.k < t.p.until) & (t.p.k < t.p.end);
        if (any(looks)) {
            const sample now = look(c, &t.p, looks);
            const vi news = looks & (now.depth > 0);
            keep(&t.found, &now, news);
            t.shows |= news;
            advance(&t.p, looks & ~news);
        }
        if (any(t.shows) && (count_of(t.shows) >= HALF || !any(active & ~t.shows & (t.p.k < t.p.end)))) {
            blend(c, &t.p, &t.found, t.shows, &t.s);
            advance(&t.p, t.shows);
            t.shows = all_int(0);
        }
    }
}

#define ISO_CAST_TILE_OF(width) ISO_CAST_JOIN(iso_cast_tile_, width)
#define ISO_CAST_JOIN(a, b) ISO_CAST_PASTE(a, b)
#define ISO_CAST_PASTE(a, b) a##b

void ISO_CAST_TILE_OF(ISO_CAST_WIDTH)(const iso_cast *c, size_t x, size_t y, float *rgba)
{
    if (c->distance) {
        cast_sparse_tile(c, x, y, rgba);
        return;
    }
    for (size_t row = y; row < y + ISO_CAST_TILE && row < c->height; row += PACKET_ROWS)
        for (size_t column = x; column < x + ISO_CAST_TILE && column < c->width; column += PACKET_COLUMNS)
            cast_packet(c, column, row, rgba);
}

#endif
