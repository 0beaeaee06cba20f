/* SPDX-License-Identifier: MIT */
#include "volume/rectilinear.h"

#include <math.h>
#include <stdlib.h>

#include "base/warnings.h"

/* Of its mean step, by which steps may differ: coordinates are decimals, or sums of rounded steps. */
#define EVEN_WITHIN 0.01
enum { MOST_TIMES = 64 }; /* samples that interpolation makes of one */

static double value_at(const void *data, iso_type type, size_t i)
{
    switch (type) {
/* clang-format off */
#define ISO_VALUE_CASE(name, text, ctype) case name: return (double)((const ctype *)data)[i];
    ISO_TYPE_LIST(ISO_VALUE_CASE)
#undef ISO_VALUE_CASE
    /* clang-format on */
    }
    return 0;
}

/* Reads all samples of the source, which is at its first. */
static iso_status read_all(iso_volume_source *source, void **data, iso_error *err)
{
    const iso_geometry *g = &source->header.geometry;
    *data = malloc(iso_geometry_voxel_count(g) * iso_type_bytes(source->header.type));
    return *data ? iso_source_read(source, g->size[2], *data, err)
                 : iso_fail(err, ISO_E_MEMORY, "%s: no memory for its samples", source->path);
}

iso_status iso_rectilinear_take(iso_rectilinear *r, int axis, iso_volume_source *row, iso_error *err)
{
    const size_t count = row->header.geometry.size[0];
    FREED void *data = NULL;
    NEED(read_all(row, &data, err));
    r->at[axis] = malloc(count * sizeof *r->at[axis]);
    NEED_MEMORY(r->at[axis], err, "%s: out of memory", row->path);
    for (size_t i = 0; i < count; ++i)
        r->at[axis][i] = value_at(data, row->header.type, i);
    r->count[axis] = count;
    return ISO_OK;
}

void iso_rectilinear_destroy(iso_rectilinear *r)
{
    for (int a = 0; a < 3; ++a)
        free(r->at[a]);
    *r = (iso_rectilinear){0};
}

static void find_steps(const iso_rectilinear *r, int axis, double *least, double *most)
{
    *least = (double)INFINITY, *most = -(double)INFINITY;
    for (size_t i = 1; i < r->count[axis]; ++i) {
        const double step = r->at[axis][i] - r->at[axis][i - 1];
        *least = fmin(*least, step);
        *most = fmax(*most, step);
    }
}

static bool is_uneven(const iso_rectilinear *r, int axis)
{
    double least, most;
    if (r->count[axis] < 2)
        return false;
    find_steps(r, axis, &least, &most);
    return !(most - least <=
             EVEN_WITHIN * fabs(r->at[axis][r->count[axis] - 1] - r->at[axis][0]) / (double)(r->count[axis] - 1));
}

iso_status iso_rectilinear_measure(const iso_rectilinear *r, const iso_volume_source *source, const size_t points[3],
                                   double first[3], double step[3], iso_error *err)
{
    for (int a = 0; a < 3; ++a) {
        double least, most;
        if (r->count[a] != points[a] || points[a] < 1)
            return iso_fail(err, ISO_E_FORMAT, "%s: has %zu coordinates along its %c axis, must be %zu", source->path,
                            r->count[a], 'x' + a, points[a]);
        find_steps(r, a, &least, &most);
        for (size_t i = 0; i < points[a]; ++i)
            if (!isfinite(r->at[a][i]))
                return iso_fail(err, ISO_E_FORMAT, "%s: coordinate %zu of its %c axis is not finite", source->path, i,
                                'x' + a);
        if (points[a] > 1 && !(least > 0))
            return iso_fail(err, ISO_E_FORMAT, "%s: the steps of its %c axis are %g to %g, must be above 0",
                            source->path, 'x' + a, least, most);
        if (is_uneven(r, a) && source->hints.uneven == ISO_UNEVEN_REFUSE)
            return iso_fail(
                err, ISO_E_FORMAT,
                "%s: the steps of its %c axis are %g to %g, must be equal within 1 %%; --resample interpolates at the "
                "smallest one, --force-spacing takes the average",
                source->path, 'x' + a, least, most);
        first[a] = r->at[a][0];
        step[a] = points[a] > 1 ? (r->at[a][points[a] - 1] - first[a]) / (double)(points[a] - 1) : 1;
    }
    return ISO_OK;
}

/* A new axis: each of its samples is between two old ones. */
typedef struct new_axis {
    size_t count, *before;
    double step, first, *weight; /* of the old sample after `before`; in the file's unit */
} new_axis;

/* Returns the place of an old sample: of a cell its center. */
static double place_of(const iso_rectilinear *r, int axis, bool of_cells, size_t i)
{
    return of_cells ? (r->at[axis][i] + r->at[axis][i + 1]) / 2 : r->at[axis][i];
}

/* Lays the new samples out; along an even axis they are the old ones. */
static void lay_out(const iso_rectilinear *r, int axis, size_t samples, new_axis *n)
{
    const bool of_cells = samples < r->count[axis];
    const double length = r->at[axis][r->count[axis] - 1] - r->at[axis][0];
    double least, most;
    find_steps(r, axis, &least, &most);
    const double steps = is_uneven(r, axis) ? fmax(1, round(length / least)) : (double)(r->count[axis] - 1);
    n->count = (size_t)fmin(steps, 1e9) + (of_cells ? 0 : 1);
    n->step = r->count[axis] > 1 ? length / fmax(steps, 1) : 1;
    n->first = r->at[axis][0] + (of_cells ? n->step / 2 : 0);
}

static bool fill_in(const iso_rectilinear *r, int axis, size_t samples, new_axis *n)
{
    const bool of_cells = samples < r->count[axis];
    n->before = malloc(n->count * sizeof *n->before);
    n->weight = malloc(n->count * sizeof *n->weight);
    for (size_t k = 0, i = 0; n->before && n->weight && k < n->count; ++k) {
        const double at = n->first + n->step * (double)k;
        while (i + 2 < samples && place_of(r, axis, of_cells, i + 1) <= at)
            ++i;
        const double from = place_of(r, axis, of_cells, i),
                     to = i + 1 < samples ? place_of(r, axis, of_cells, i + 1) : from;
        n->before[k] = i;
        n->weight[k] = to > from ? fmin(1, fmax(0, (at - from) / (to - from))) : 0;
        if (!is_uneven(r, axis))
            n->before[k] = k, n->weight[k] = 0;
    }
    return n->before && n->weight;
}

static void put_value(void *data, iso_type type, size_t i, double value)
{
    switch (type) {
/* clang-format off */
#define ISO_PUT_CASE(name, text, ctype) \
    case name: ((ctype *)data)[i] = (ctype)((ctype)0.5 == 0 ? nearbyint(value) : value); break;
    ISO_TYPE_LIST(ISO_PUT_CASE)
#undef ISO_PUT_CASE
    /* clang-format on */
    }
}

/* Returns the value between up to eight samples; no data if one of them has none. */
static double interpolate(const void *data, iso_type type, const size_t size[3], const new_axis n[3],
                          const size_t at[3])
{
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        size_t i = 0;
        double part = 1;
        for (int a = 2; a >= 0; --a) {
            const size_t after = corner >> a & 1;
            const double weight = n[a].weight[at[a]];
            part *= after ? weight : 1 - weight;
            i = i * size[a] + n[a].before[at[a]] + (part > 0 ? after : 0);
        }
        if (!(part > 0))
            continue;
        const double value = value_at(data, type, i);
        if (iso_is_no_data((float)value))
            return (double)ISO_NO_DATA;
        sum += part * value;
    }
    return sum;
}

/* Lets the source give samples that are in memory, from the first on. */
static void give(iso_volume_source *source, char *samples)
{
    free(source->preloaded);
    source->preloaded = samples;
    source->swap_bytes = source->scaled = false;
    source->form = ISO_FORM_TYPE;
    source->slope = 1, source->intercept = 0;
    source->planes_done = source->planes_read = 0;
    source->look.seen = 0;
    source->choice.inside_count = source->choice.volume_count = 1;
    source->choice.inside_at = source->choice.volume_at = 0;
    source->choice.luminance = false;
}

static iso_status make_samples(const iso_rectilinear *r, iso_volume_source *source, new_axis n[3], iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    const iso_type type = source->header.type;
    const size_t count = n[0].count * n[1].count * n[2].count, old[3] = {g->size[0], g->size[1], g->size[2]};
    void *data = NULL;
    char *made = malloc(count * iso_type_bytes(type)), text[640];
    bool well = made != NULL;
    for (int a = 0; a < 3 && well; ++a)
        well = fill_in(r, a, old[a], &n[a]);
    iso_status status = well ? read_all(source, &data, err)
                             : iso_fail(err, ISO_E_MEMORY, "%s: no memory for %zu samples", source->path, count);
    for (size_t i = 0; status == ISO_OK && i < count; ++i) {
        const size_t at[3] = {i % n[0].count, i / n[0].count % n[1].count, i / n[0].count / n[1].count};
        put_value(made, type, i, interpolate(data, type, old, n, at));
    }
    free(data);
    if (status != ISO_OK) {
        free(made);
        return status;
    }
    give(source, made);
    snprintf(text, sizeof text, "%.400s: %zu x %zu x %zu samples are interpolated of %zu x %zu x %zu", source->path,
             n[0].count, n[1].count, n[2].count, old[0], old[1], old[2]);
    iso_warn(text);
    return ISO_OK;
}

iso_status iso_rectilinear_resample(const iso_rectilinear *r, iso_volume_source *source, iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    new_axis n[3] = {{0}};
    double made = 1;
    if (!r->at[0] || source->hints.uneven != ISO_UNEVEN_RESAMPLE ||
        !(is_uneven(r, 0) || is_uneven(r, 1) || is_uneven(r, 2)))
        return ISO_OK;
    if (source->choice.luminance)
        iso_source_make_floats(source);
    for (int a = 0; a < 3; ++a) {
        lay_out(r, a, g->size[a], &n[a]);
        made *= (double)n[a].count;
    }
    if (made > MOST_TIMES * (double)iso_geometry_voxel_count(g))
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: --resample would make %zu x %zu x %zu samples, more than %d of each that it has; resample "
                        "it in VTK, or --force-spacing takes the average",
                        source->path, n[0].count, n[1].count, n[2].count, MOST_TIMES);
    iso_status status = make_samples(r, source, n, err);
    for (int a = 0; a < 3; ++a) {
        const iso_vec3 column = iso_column(g->index_to_world, a);
        const double old = (r->at[a][r->count[a] - 1] - r->at[a][0]) / (double)(r->count[a] > 1 ? r->count[a] - 1 : 1),
                     times = old > 0 ? n[a].step / old : 1;
        if (g->size[a] == r->count[a]) /* the first sample stays where it is: the corner moves by half a step */
            g->origin_mm = iso_madd(g->origin_mm, column, (1 - times) / 2);
        for (int row = 0; row < 3; ++row)
            g->index_to_world.m[row][a] *= times;
        g->size[a] = status == ISO_OK ? n[a].count : g->size[a];
        g->box_index[a] = (double)g->size[a];
        free(n[a].before);
        free(n[a].weight);
    }
    return status;
}
