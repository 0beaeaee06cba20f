/* SPDX-License-Identifier: MIT */
#include "tf/adapt.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

iso_adapt_options iso_adapt_defaults(void)
{
    return (iso_adapt_options){.weight = ISO_WEIGHT_FLAT,
                               .average = ISO_AVERAGE_OPACITY,
                               .bits = ISO_ADAPT_BITS,
                               .fall_back = true};
}

/* ---- weights -------------------------------------------------------------------- */

struct iso_adapter {
    iso_adapt_average average;
    iso_bins z, s;
    size_t *row_start; /* s.count + 1 */
    uint16_t *entry_z;
    float *entry_weight; /* sum 1 per row; rows without voxels are empty */
    double *row_count;   /* voxels per row */
    size_t row_count_of; /* number of rows: s.count for each bin of the second value */
};

void iso_adapter_destroy(iso_adapter *a)
{
    if (!a)
        return;
    free(a->row_start);
    free(a->entry_z);
    free(a->entry_weight);
    free(a->row_count);
    free(a);
}

/* Returns the default width. Flat: chosen from 1.5, 1.6, 1.75, 2 and 3, as the least SSIM dissimilarity among those
 * with no case worse than the original TF on six of seven volumes. Each left-out volume gave the same choice and no
 * worse case. */
static double default_window(iso_adapt_weight w)
{
    return w == ISO_WEIGHT_FLAT ? 1.75 : w == ISO_WEIGHT_GAUSS ? 3 : 2.5;
}

/* Returns the weight at x deviations from the mean, inside the window. */
static double weight_at(const iso_adapt_options *opt, double x)
{
    const double gauss = exp(-0.5 * x * x), triangle = fmax(0.4 * (1 - 0.4 * fabs(x)), 0);
    const double gauss_area = 2.5066282746310002 * erf(2.5 / 1.4142135623730951); /* over [-2.5, 2.5] */
    switch (opt->weight) {
    case ISO_WEIGHT_GAUSS: return gauss;
    case ISO_WEIGHT_TRIANGLE: return triangle;
    case ISO_WEIGHT_MIXED:
        return opt->mix_s * 0.2 + opt->mix_t * triangle + (1 - opt->mix_s - opt->mix_t) * gauss / gauss_area;
    case ISO_WEIGHT_FLAT:
    case ISO_WEIGHT_COUNT: break;
    }
    return 1;
}

typedef struct row_moments {
    double count, mean, deviation; /* in bins of z */
} row_moments;

static row_moments measure_row(const iso_joint *j, size_t row)
{
    row_moments m = {0};
    for (size_t i = j->row_start[row]; i < j->row_start[row + 1]; ++i) {
        m.count += (double)j->entry_count_of[i];
        m.mean += (double)j->entry_count_of[i] * j->entry_z[i];
    }
    if (m.count == 0)
        return m;
    m.mean /= m.count;
    double square = 0;
    for (size_t i = j->row_start[row]; i < j->row_start[row + 1]; ++i)
        square += (double)j->entry_count_of[i] * (j->entry_z[i] - m.mean) * (j->entry_z[i] - m.mean);
    /* At least half a bin, so that a row with one entry stays inside its window. */
    m.deviation = fmax(sqrt(square / m.count), 0.5);
    return m;
}

/* Appends the row's weighted entries; never none, since some entry lies within one deviation of the mean. */
static size_t weigh_row(iso_adapter *a, const iso_joint *j, const iso_adapt_options *opt, size_t row, size_t at)
{
    row_moments m = measure_row(j, row);
    double window = opt->window > 0 ? opt->window : default_window(opt->weight), sum = 0;
    size_t first = at;
    a->row_count[row] = m.count;
    for (size_t i = j->row_start[row]; i < j->row_start[row + 1]; ++i) {
        double x = (j->entry_z[i] - m.mean) / m.deviation;
        if (fabs(x) > window)
            continue;
        double w = weight_at(opt, x) * (double)j->entry_count_of[i];
        a->entry_z[at] = j->entry_z[i];
        a->entry_weight[at++] = (float)(w / m.count);
        sum += w / m.count;
    }
    for (size_t i = first; i < at; ++i)
        a->entry_weight[i] = (float)(a->entry_weight[i] / sum);
    return at;
}

static iso_status check_options(const iso_adapt_options *opt, iso_error *err)
{
    if (!(opt->window == 0 || (opt->window >= 1 && opt->window <= 100)))
        return iso_fail(err, ISO_E_RANGE, "adapt: window of %g deviations, must be 1 to 100", opt->window);
    if (!(opt->mix_s >= 0 && opt->mix_t >= 0 && opt->mix_s + opt->mix_t <= 1))
        return iso_fail(err, ISO_E_RANGE, "adapt: mixed weights %g and %g, must be at least 0 and together at most 1",
                        opt->mix_s, opt->mix_t);
    return ISO_OK;
}

iso_status iso_adapter_create(const iso_joint *j, const iso_adapt_options *opt, iso_adapter **adapter, iso_error *err)
{
    *adapter = NULL;
    NEED(check_options(opt, err));
    iso_adapter *a = calloc(1, sizeof *a);
    if (a) {
        *a = (iso_adapter){.average = opt->average, .z = j->z, .s = j->s, .row_count_of = iso_joint_row_count(j)};
        a->row_start = calloc(a->row_count_of + 1, sizeof *a->row_start);
        a->row_count = calloc(a->row_count_of, sizeof *a->row_count);
        a->entry_z = malloc((j->entry_count + 1) * sizeof *a->entry_z);
        a->entry_weight = malloc((j->entry_count + 1) * sizeof *a->entry_weight);
    }
    if (!a || !a->row_start || !a->row_count || !a->entry_z || !a->entry_weight) {
        iso_adapter_destroy(a);
        return iso_fail(err, ISO_E_MEMORY, "adapt: no memory for %zu entries", j->entry_count);
    }
    for (size_t row = 0; row < a->row_count_of; ++row)
        a->row_start[row + 1] = weigh_row(a, j, opt, row, a->row_start[row]);
    *adapter = a;
    return ISO_OK;
}

/* ---- Eq. 7 ------------------------------------------------------------------------ */

/* Sums along a row: color times weight, weight, and the largest extinction, which caps the mean. */
typedef struct weighted_tf {
    double rgbw[4];
    double plain[3]; /* color for rows without opacity */
    double extinction;
} weighted_tf;

static double averaged_quantity(iso_adapt_average average, double extinction, double length_mm)
{
    return average == ISO_AVERAGE_EXTINCTION ? extinction : -expm1(-extinction * length_mm);
}

static void prepare(const iso_adapter *a, const iso_tf_table *tf, double length_mm, weighted_tf *out)
{
    for (size_t i = 0; i < a->z.count; ++i) {
        double rgbs[4];
        iso_tf_lookup(tf, a->z.lo + (double)i * a->z.step, rgbs);
        double w = averaged_quantity(a->average, rgbs[3], length_mm),
               color_weight = a->average == ISO_AVERAGE_RGBA ? 1 : w;
        for (int c = 0; c < 3; ++c) {
            out[i].plain[c] = rgbs[c];
            out[i].rgbw[c] = color_weight * rgbs[c];
        }
        out[i].rgbw[3] = w;
        out[i].extinction = rgbs[3];
    }
}

/* Weighted sums of one row. */
typedef struct row_sums {
    double rgbw[4], plain[3], largest;
} row_sums;

static row_sums sum_row(const iso_adapter *a, const weighted_tf *tf, size_t row)
{
    row_sums r = {{0}, {0}, 0};
    for (size_t i = a->row_start[row]; i < a->row_start[row + 1]; ++i) {
        const weighted_tf *t = &tf[a->entry_z[i]];
        double w = a->entry_weight[i];
        for (int c = 0; c < 4; ++c)
            r.rgbw[c] += w * t->rgbw[c];
        for (int c = 0; c < 3; ++c)
            r.plain[c] += w * t->plain[c];
        r.largest = t->extinction > r.largest ? t->extinction : r.largest;
    }
    return r;
}

/* Converts the sums to color and extinction. */
static void finish_row(const iso_adapter *a, const row_sums *r, double length_mm, float entry[4])
{
    double mean = r->rgbw[3], color_sum = a->average == ISO_AVERAGE_RGBA ? 1 : mean;
    for (int c = 0; c < 3; ++c)
        entry[c] = (float)(color_sum > 0 ? r->rgbw[c] / color_sum : r->plain[c]);
    double extinction = a->average == ISO_AVERAGE_EXTINCTION ? mean : mean < 1 ? -log1p(-mean) / length_mm : r->largest;
    entry[3] = (float)fmin(extinction, r->largest);
}

/* Interpolates the rows between two filled ones on premultiplied entries. */
static void fill_between(iso_tf_table *t, size_t left, size_t right, double length_mm)
{
    const float *l = t->entries + 4 * left, *r = t->entries + 4 * right;
    double al = -expm1(-(double)l[3] * length_mm), ar = -expm1(-(double)r[3] * length_mm);
    for (size_t i = left + 1; i < right; ++i) {
        double f = (double)(i - left) / (double)(right - left), opacity = (1 - f) * al + f * ar;
        float *e = t->entries + 4 * i;
        for (int c = 0; c < 3; ++c)
            e[c] = (float)(opacity > 0 ? ((1 - f) * al * l[c] + f * ar * r[c]) / opacity : (1 - f) * l[c] + f * r[c]);
        double extinction = opacity < 1 ? -log1p(-opacity) / length_mm : INFINITY;
        e[3] = (float)fmin(extinction, fmax(l[3], r[3]));
    }
}

static void fill_empty_rows(const iso_adapter *a, iso_tf_table *t, double length_mm)
{
    size_t last = SIZE_MAX;
    for (size_t row = 0; row < a->s.count; ++row) {
        if (a->row_start[row] == a->row_start[row + 1])
            continue;
        if (last == SIZE_MAX)
            for (size_t i = 0; i < row; ++i)
                memcpy(t->entries + 4 * i, t->entries + 4 * row, 4 * sizeof *t->entries);
        else
            fill_between(t, last, row, length_mm);
        last = row;
    }
    for (size_t i = last + 1; last != SIZE_MAX && i < a->s.count; ++i)
        memcpy(t->entries + 4 * i, t->entries + 4 * last, 4 * sizeof *t->entries);
}

static double averaging_length_mm(const iso_adapter *a, const iso_geometry *level0, size_t level)
{
    double length_mm = iso_geometry_mean_spacing_mm(level0);
    return a->average == ISO_AVERAGE_TRANSMITTANCE ? length_mm * pow(2, 0.5 * (double)level) : length_mm;
}

iso_status iso_adapter_update(const iso_adapter *a, const iso_tf_table *tf, const iso_geometry *level0, size_t level,
                              iso_tf_table *table, iso_error *err)
{
    double row_length_mm = averaging_length_mm(a, level0, level);
    FREED weighted_tf *prepared = malloc(a->z.count * sizeof *prepared);
    if (!prepared || table->count != a->s.count)
        return prepared
                   ? iso_fail(err, ISO_E_RANGE, "adapt: the table has %zu entries, needs %zu", table->count, a->s.count)
                   : iso_fail(err, ISO_E_MEMORY, "adapt: out of memory");
    prepare(a, tf, row_length_mm, prepared);
    bool any = a->row_start[a->s.count] > 0;
    for (size_t row = 0; row < a->s.count; ++row) {
        double rgbs[4];
        row_sums sums = sum_row(a, prepared, row);
        finish_row(a, &sums, row_length_mm, table->entries + 4 * row);
        if (any)
            continue;
        iso_tf_lookup(tf, a->s.lo + (double)row * a->s.step, rgbs);
        for (int c = 0; c < 4; ++c)
            table->entries[4 * row + (size_t)c] = (float)rgbs[c];
    }
    fill_empty_rows(a, table, row_length_mm);
    return ISO_OK;
}

iso_status iso_adapter_apply(const iso_adapter *a, const iso_tf_table *tf, const iso_geometry *level0, size_t level,
                             iso_tf_table *table, iso_error *err)
{
    *table = (iso_tf_table){.count = a->s.count,
                            .lo = a->s.lo,
                            .hi = a->s.lo + a->s.step * (double)(a->s.count - 1),
                            .unit_mm = tf->unit_mm};
    table->entries = calloc(4 * table->count, sizeof *table->entries);
    if (!table->entries) {
        *table = (iso_tf_table){0};
        return iso_fail(err, ISO_E_MEMORY, "adapt: no memory for %zu entries", a->s.count);
    }
    iso_status status = iso_adapter_update(a, tf, level0, level, table, err);
    if (status != ISO_OK)
        iso_tf_table_destroy(table);
    return status;
}

/* ---- 2D transfer functions ------------------------------------------------------- */

/* Blends a row of the 2D transfer function with the 1D one by pseudo-counts: a few voxels give no reliable mean. */
static void blend_tf_2d_row(const row_sums *all, double count, row_sums *r)
{
    double own = count / (count + ISO_TF_2D_PSEUDO_COUNTS);
    for (int c = 0; c < 4; ++c)
        r->rgbw[c] = own * r->rgbw[c] + (1 - own) * all->rgbw[c];
    for (int c = 0; c < 3; ++c)
        r->plain[c] = own * r->plain[c] + (1 - own) * all->plain[c];
    r->largest = fmax(r->largest, all->largest);
}

static iso_status fill_tf_2d(const iso_adapter *all, const iso_adapter *second, const iso_tf_table *tf,
                             double length_mm, iso_tf_table rows[ISO_TF_2D_ROWS], iso_error *err)
{
    FREED weighted_tf *prepared = malloc(all->z.count * sizeof *prepared);
    NEED_MEMORY(prepared, err, "adapt: out of memory");
    prepare(all, tf, length_mm, prepared);
    for (size_t row = 0; row < all->s.count; ++row) {
        row_sums of_all = sum_row(all, prepared, row);
        for (size_t c = 0; c < ISO_TF_2D_ROWS; ++c) {
            row_sums own = sum_row(second, prepared, c * all->s.count + row);
            blend_tf_2d_row(&of_all, second->row_count[c * all->s.count + row], &own);
            finish_row(all, &own, length_mm, rows[c].entries + 4 * row);
        }
    }
    for (size_t c = 0; c < ISO_TF_2D_ROWS; ++c)
        fill_empty_rows(all, &rows[c], length_mm);
    return ISO_OK;
}

/* Allocates *bytes: the second value of each voxel of the level, one byte per voxel. ISO_E_MEMORY. */
static iso_status second_value_bytes(const iso_pyramid *p, size_t level, iso_second_value second, int threads,
                                     uint8_t **bytes, iso_error *err)
{
    size_t count = iso_geometry_voxel_count(&p->levels[level].geometry);
    FREED float *planes = malloc(count * sizeof *planes);
    *bytes = malloc(count);
    NEED_MEMORY(planes && *bytes, err, "adapt: no memory for the second value of %zu voxels", count);
    NEED(iso_joint_second_coordinates(p, level, second, threads, planes, err));
    for (size_t i = 0; i < count; ++i)
        (*bytes)[i] = (uint8_t)(planes[i] * (255.0f / (ISO_TF_2D_ROWS - 1)) + 0.5f);
    return ISO_OK;
}

iso_status iso_adapt_tf_2d(const iso_pyramid *p, size_t level, iso_second_value second, const iso_tf_table *tf,
                           const iso_adapt_options *opt, iso_tf_2d *out, iso_error *err)
{
    OWNED(iso_joint) joint = {0}, joint_2d = {0};
    iso_adapter *all = NULL, *by_second = NULL;
    *out = (iso_tf_2d){0};
    iso_adapt_options opt_2d = *opt; /* a wider window: the second value already separates a row's bulk from its tail */
    if (opt->window == 0 && opt->weight == ISO_WEIGHT_FLAT)
        opt_2d.window = ISO_TF_2D_WINDOW;
    iso_status status = iso_joint_obtain(p, opt->folder, &(iso_joint_key){level, opt->bits, ISO_SECOND_VALUE_NONE},
                                         opt->threads, &joint, err);
    if (status == ISO_OK)
        status = iso_joint_obtain(p, opt->folder, &(iso_joint_key){level, opt->bits, second}, opt->threads, &joint_2d,
                                  err);
    TRY(status, iso_adapter_create(&joint, &opt_2d, &all, err));
    TRY(status, iso_adapter_create(&joint_2d, &opt_2d, &by_second, err));
    for (size_t c = 0; c < ISO_TF_2D_ROWS && status == ISO_OK; ++c)
        status = iso_adapter_apply(all, tf, &p->levels[0].geometry, level, &out->rows[c], err);
    if (status == ISO_OK && joint.entry_count > 0)
        status = fill_tf_2d(all, by_second, tf, averaging_length_mm(all, &p->levels[0].geometry, level), out->rows,
                            err);
    TRY(status, second_value_bytes(p, level, second, opt->threads, &out->bytes, err));
    if (status != ISO_OK)
        iso_tf_2d_destroy(out);
    iso_adapter_destroy(all);
    iso_adapter_destroy(by_second);
    return status;
}
