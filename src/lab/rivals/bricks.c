/* SPDX-License-Identifier: MIT */
/* bricks.c - a transfer function adapted to each brick of a level, blended between the bricks' centers. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lab/rivals/rivals.h"
#include "render/reference_ray.h"
#include "render/sampler.h"
#include "tf/adapt.h"

typedef struct brick_field {
    size_t count[3];
    iso_tf_table tables[];
} brick_field;

static void release(void *field)
{
    brick_field *f = field;
    for (size_t i = 0; i < f->count[0] * f->count[1] * f->count[2]; ++i)
        iso_tf_table_destroy(&f->tables[i]);
    free(f);
}

/* Finds the brick whose center lies below, and the weight of the next one above, along an axis. */
static size_t place(double index, size_t count, double *above)
{
    const double q = fmin(fmax(index / ISO_RIVAL_BRICK - 0.5, 0), (double)(count - 1));
    const size_t i = (size_t)q;
    *above = q - (double)i;
    return i;
}

static double emit(const iso_emitter *e, const iso_emitter_place *at, double color[3])
{
    const brick_field *f = e->field;
    const double value = iso_sample_scalar(at->sampler, at->index);
    double above[3], extinction = 0, rgbs[4];
    const size_t low[3] = {place(at->index.x, f->count[0], &above[0]), place(at->index.y, f->count[1], &above[1]),
                           place(at->index.z, f->count[2], &above[2])};
    color[0] = color[1] = color[2] = 0;
    for (size_t corner = 0; corner < 8; ++corner) {
        size_t b[3];
        double weight = 1;
        for (size_t a = 0; a < 3; ++a) {
            const size_t up = corner >> a & 1;
            b[a] = low[a] + up;
            weight *= up ? above[a] : 1 - above[a];
        }
        if (!(weight > 0))
            continue;
        iso_tf_lookup(&f->tables[b[0] + f->count[0] * (b[1] + f->count[1] * b[2])], value, rgbs);
        extinction += weight * rgbs[3];
        for (int c = 0; c < 3; ++c)
            color[c] += weight * rgbs[3] * rgbs[c];
    }
    if (!(extinction > 0))
        return 0;
    const double shade = iso_shade(at->view, iso_sample_normal(at->sampler, at->index), at->to_viewer);
    for (int c = 0; c < 3; ++c)
        color[c] *= shade;
    return extinction;
}

/* Copies the voxels [lo, hi) of a level, with the level's range, so that histograms have the same bins. */
static iso_status crop(const iso_level *from, const size_t lo[3], const size_t hi[3], iso_level *to, iso_error *err)
{
    const size_t *n = from->geometry.size;
    *to = *from;
    to->codes = NULL;
    to->directions = NULL;
    to->magnitude = NULL;
    for (int a = 0; a < 3; ++a)
        to->geometry.size[a] = hi[a] - lo[a];
    const size_t row = to->geometry.size[0];
    to->scalar = malloc(iso_geometry_voxel_count(&to->geometry) * sizeof *to->scalar);
    NEED_MEMORY(to->scalar, err, "no memory for a brick");
    for (size_t z = lo[2], i = 0; z < hi[2]; ++z)
        for (size_t y = lo[1]; y < hi[1]; ++y, i += row)
            memcpy(to->scalar + i, from->scalar + lo[0] + n[0] * (y + n[1] * z), row * sizeof *to->scalar);
    return ISO_OK;
}

/* Adapts a table to the brick and a border of one coarse voxel, as a pyramid of two levels: level 0 and `level`. */
static iso_status adapt_brick(const iso_level_subject *s, const size_t brick[3], iso_tf_table *table, iso_error *err)
{
    const iso_pyramid *p = s->pyramid;
    const size_t *n = p->levels[s->level].geometry.size, *fine = p->levels[0].geometry.size;
    size_t lo[3], hi[3], fine_lo[3], fine_hi[3];
    for (int a = 0; a < 3; ++a) {
        lo[a] = brick[a] > 0 ? brick[a] * ISO_RIVAL_BRICK - 1 : 0;
        hi[a] = (brick[a] + 1) * ISO_RIVAL_BRICK + 1;
        hi[a] = hi[a] < n[a] ? hi[a] : n[a];
        fine_lo[a] = lo[a] << s->level;
        fine_hi[a] = hi[a] << s->level;
        fine_hi[a] = fine_hi[a] < fine[a] ? fine_hi[a] : fine[a];
    }
    iso_level levels[ISO_SCENE_LEVELS];
    iso_pyramid own = *p;
    memcpy(levels, p->levels, p->level_count * sizeof *levels);
    own.levels = levels;
    levels[0].scalar = levels[s->level].scalar = NULL;
    iso_joint joint = {0};
    iso_adapter *adapter = NULL;
    iso_adapt_options opt = iso_adapt_defaults();
    opt.threads = s->threads;
    iso_status status = crop(&p->levels[0], fine_lo, fine_hi, &levels[0], err);
    TRY(status, crop(&p->levels[s->level], lo, hi, &levels[s->level], err));
    TRY(status, iso_joint_compute(&own, s->level, opt.bits, ISO_SECOND_VALUE_NONE, s->threads, &joint, err));
    TRY(status, iso_adapter_create(&joint, &opt, &adapter, err));
    TRY(status, iso_adapter_apply(adapter, s->tf, &p->levels[0].geometry, s->level, table, err));
    iso_adapter_destroy(adapter);
    iso_joint_destroy(&joint);
    free(levels[0].scalar);
    free(levels[s->level].scalar);
    return status;
}

iso_status iso_rival_bricks(const iso_level_subject *s, iso_rival *r, iso_error *err)
{
    const size_t *n = s->pyramid->levels[s->level].geometry.size;
    size_t count[3];
    for (int a = 0; a < 3; ++a)
        count[a] = (n[a] + ISO_RIVAL_BRICK - 1) / ISO_RIVAL_BRICK;
    const size_t all = count[0] * count[1] * count[2];
    brick_field *f = calloc(1, sizeof *f + all * sizeof *f->tables);
    NEED_MEMORY(f, err, "no memory for the tables of %zu bricks", all);
    memcpy(f->count, count, sizeof count);
    *r = (iso_rival){{emit, f}, f, release};
    iso_status status = ISO_OK;
    for (size_t i = 0; i < all && status == ISO_OK; ++i)
        status = adapt_brick(s, (size_t[]){i % count[0], i / count[0] % count[1], i / (count[0] * count[1])},
                             &f->tables[i], err);
    if (status != ISO_OK)
        iso_rival_destroy(r);
    return status;
}
