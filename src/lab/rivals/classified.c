/* SPDX-License-Identifier: MIT */
/* classified.c - levels that store colors: fine voxels are classified first, then averaged. */
#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "lab/rivals/rivals.h"
#include "render/reference_ray.h"
#include "render/sampler.h"

/* Four floats per voxel: premultiplied color and amount: an extinction per mm, or the opacity of length_mm. */
typedef struct color_field {
    double length_mm; /* 0: amounts are extinctions */
    float rgba[];
} color_field;

static double emit(const iso_emitter *e, const iso_emitter_place *at, double color[3])
{
    const color_field *f = e->field;
    double v[4];
    iso_sample_floats(at->sampler, f->rgba, 4, at->index, v);
    if (!(v[3] > 0))
        return color[0] = color[1] = color[2] = 0;
    const double extinction = f->length_mm > 0 ? -log1p(-fmin(v[3], ISO_TF_MAX_OPACITY)) / f->length_mm : v[3];
    const double shade = iso_shade(at->view, iso_sample_normal(at->sampler, at->index), at->to_viewer);
    for (int c = 0; c < 3; ++c)
        color[c] = extinction * shade * v[c] / v[3];
    return extinction;
}

/* Computes the color and amount of a coarse voxel. */
typedef void (*voxel_maker)(const iso_level_subject *s, const iso_fine_box *box, double length_mm, double rgba[4]);

static iso_status make_field(const iso_level_subject *s, voxel_maker make, double length_mm, iso_rival *r,
                             iso_error *err)
{
    const size_t count = iso_geometry_voxel_count(&s->pyramid->levels[s->level].geometry);
    color_field *f = malloc(sizeof *f + 4 * count * sizeof *f->rgba);
    NEED_MEMORY(f, err, "no memory for the colors of %zu voxels", count);
    f->length_mm = length_mm;
    const int threads = iso_threads(s->threads);
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads)
    for (size_t i = 0; i < count; ++i) {
        const iso_fine_box box = iso_fine_box_of(s->pyramid, s->level, i);
        double rgba[4];
        make(s, &box, length_mm, rgba);
        for (size_t c = 0; c < 4; ++c)
            f->rgba[4 * i + c] = (float)rgba[c];
    }
    *r = (iso_rival){{emit, f}, f, free};
    return ISO_OK;
}

static double value_at(const iso_level *level0, size_t x, size_t y, size_t z)
{
    const size_t *n = level0->geometry.size;
    return (double)level0->scalar[x + n[0] * (y + n[1] * z)];
}

/* Averages amount and amount * color over the box. */
static void classify_box(const iso_level_subject *s, const iso_fine_box *b, double length_mm, double rgba[4])
{
    double count = 0, rgbs[4];
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 0;
    for (size_t z = b->lo[2]; z < b->hi[2]; ++z)
        for (size_t y = b->lo[1]; y < b->hi[1]; ++y)
            for (size_t x = b->lo[0]; x < b->hi[0]; ++x) {
                iso_tf_lookup(s->tf, value_at(&s->pyramid->levels[0], x, y, z), rgbs);
                const double amount = length_mm > 0 ? -expm1(-rgbs[3] * length_mm) : rgbs[3];
                for (int c = 0; c < 3; ++c)
                    rgba[c] += amount * rgbs[c];
                rgba[3] += amount;
                count += 1;
            }
    for (int c = 0; c < 4; ++c)
        rgba[c] /= count;
}

iso_status iso_rival_opacity(const iso_level_subject *s, iso_rival *r, iso_error *err)
{
    return make_field(s, classify_box, iso_geometry_mean_spacing_mm(&s->pyramid->levels[0].geometry), r, err);
}

iso_status iso_rival_extinction(const iso_level_subject *s, iso_rival *r, iso_error *err)
{
    return make_field(s, classify_box, 0, r, err);
}

/* ---- transmittance ---- */

/* Follows a line of fine voxels through the box along an axis: transmittance, and the color seen from both ends. */
static double look_along(const iso_level_subject *s, const iso_fine_box *b, int axis, const size_t start[3],
                         double color[3])
{
    const iso_level *level0 = &s->pyramid->levels[0];
    double spacing[3], sum[3] = {0}, rgbs[4], front = 1;
    iso_geometry_spacing_mm(&level0->geometry, spacing);
    size_t at[3] = {start[0], start[1], start[2]};
    double whole = 0;
    for (at[axis] = b->lo[axis]; at[axis] < b->hi[axis]; ++at[axis]) {
        iso_tf_lookup(s->tf, value_at(level0, at[0], at[1], at[2]), rgbs);
        whole += rgbs[3] * spacing[axis];
    }
    const double all = exp(-whole);
    for (at[axis] = b->lo[axis]; at[axis] < b->hi[axis]; ++at[axis]) {
        iso_tf_lookup(s->tf, value_at(level0, at[0], at[1], at[2]), rgbs);
        const double t = exp(-rgbs[3] * spacing[axis]);
        const double back = front * t > 0 ? all / (front * t) : 0; /* of the voxels after this one */
        for (int c = 0; c < 3; ++c)
            sum[c] += 0.5 * (front + back) * (1 - t) * rgbs[c];
        front *= t;
    }
    for (int c = 0; c < 3; ++c)
        color[c] += sum[c];
    return all;
}

/* Averages -ln(mean transmittance) / length over the axes; the color is the mean of those seen along them. */
static void keep_transmittance(const iso_level_subject *s, const iso_fine_box *b, double length_mm, double rgba[4])
{
    double spacing[3], color[3] = {0}, opacity = 0;
    (void)length_mm;
    iso_geometry_spacing_mm(&s->pyramid->levels[0].geometry, spacing);
    rgba[3] = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        double sum = 0, lines = 0, seen[3] = {0};
        size_t at[3];
        for (at[v] = b->lo[v]; at[v] < b->hi[v]; ++at[v])
            for (at[u] = b->lo[u]; at[u] < b->hi[u]; ++at[u]) {
                at[axis] = b->lo[axis];
                sum += look_along(s, b, axis, at, seen);
                lines += 1;
            }
        const double length = (double)(b->hi[axis] - b->lo[axis]) * spacing[axis];
        rgba[3] += -log(fmax(sum / lines, 1e-30)) / length / 3;
        opacity += 1 - sum / lines;
        for (int c = 0; c < 3; ++c)
            color[c] += seen[c] / lines;
    }
    for (int c = 0; c < 3; ++c)
        rgba[c] = opacity > 0 ? rgba[3] * color[c] / opacity : 0;
}

iso_status iso_rival_transmittance(const iso_level_subject *s, iso_rival *r, iso_error *err)
{
    return make_field(s, keep_transmittance, 0, r, err);
}

/* ---- two Gaussians ---- */

typedef struct cluster {
    double count, sum, squares;
} cluster;

static void add_to(cluster *c, double v)
{
    c->count += 1;
    c->sum += v;
    c->squares += v * v;
}

/* Finds two means [linde-1980], starting from the box's extreme values. */
static void two_clusters(const iso_level *level0, const iso_fine_box *b, cluster out[2])
{
    enum { rounds = 8 };
    double low = INFINITY, high = -INFINITY;
    for (int round = 0; round <= rounds; ++round) {
        cluster c[2] = {{0}};
        for (size_t z = b->lo[2]; z < b->hi[2]; ++z)
            for (size_t y = b->lo[1]; y < b->hi[1]; ++y)
                for (size_t x = b->lo[0]; x < b->hi[0]; ++x) {
                    const double v = value_at(level0, x, y, z);
                    if (round == 0)
                        low = fmin(low, v), high = fmax(high, v);
                    else
                        add_to(&c[fabs(v - high) < fabs(v - low)], v);
                }
        if (round == 0)
            continue;
        out[0] = c[0];
        out[1] = c[1];
        low = c[0].count > 0 ? c[0].sum / c[0].count : low;
        high = c[1].count > 0 ? c[1].sum / c[1].count : high;
    }
}

static void mix_gaussians(const iso_level_subject *s, const iso_fine_box *b, double length_mm, double rgba[4])
{
    cluster c[2];
    two_clusters(&s->pyramid->levels[0], b, c);
    const double count = c[0].count + c[1].count;
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 0;
    for (int g = 0; g < 2; ++g) {
        if (!(c[g].count > 0))
            continue;
        const double mean = c[g].sum / c[g].count, variance = fmax(c[g].squares / c[g].count - mean * mean, 0);
        double part[4];
        iso_tf_under_gaussian(s->tf, length_mm, mean, sqrt(variance), part);
        for (int k = 0; k < 4; ++k)
            rgba[k] += c[g].count / count * part[k];
    }
}

iso_status iso_rival_two_gaussians(const iso_level_subject *s, iso_rival *r, iso_error *err)
{
    return make_field(s, mix_gaussians, iso_geometry_mean_spacing_mm(&s->pyramid->levels[0].geometry), r, err);
}
