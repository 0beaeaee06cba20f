/* SPDX-License-Identifier: MIT */
#include "volume/overview.h"

#include <math.h>
#include <stdlib.h>

#include <jansson.h>

#include "base/parallel.h"

enum { FINE_BINS = 16384 };
#define USUAL_KEPT_BYTES ((size_t)256 << 20)
#define USUAL_SLAB_BYTES ((size_t)32 << 20)

const double iso_overview_percents[ISO_OVERVIEW_PERCENTS] = {1, 25, 50, 75, 99};

/* The counts of one thread. */
typedef struct counts {
    size_t *fine;
    iso_value_histogram shown, drawn;
    float *row;
} counts;

typedef struct slab_reading {
    const char *path;
    const iso_volume_input *input;
    const iso_overview_options *opt;
    const iso_progress *progress;
    iso_overview *out;
    iso_volume slab; /* planes that were read; all of them where is_kept */
    bool is_kept, are_whole;
    size_t planes; /* that a slab has at most */
    double sum;
    int threads;
    counts *counts; /* of each thread */
} slab_reading;

typedef iso_status slab_visitor(slab_reading *s, size_t first_plane, iso_error *err);

/* ---- reading ---- */

static iso_status read_slabs(slab_reading *s, iso_volume_source *source, double done, slab_visitor *visit,
                             iso_error *err)
{
    const size_t nz = s->out->header.geometry.size[2];
    for (size_t z = 0; z < nz; z += s->planes) {
        s->slab.geometry.size[2] = nz - z < s->planes ? nz - z : s->planes;
        iso_progress_report(s->progress, "read", done + 0.5 * (double)z / (double)nz);
        NEED(iso_source_read(source, s->slab.geometry.size[2], s->slab.data, err));
        NEED(visit(s, z, err));
    }
    return ISO_OK;
}

/* Visits each slab. done: part of all work before this half of it. */
static iso_status each_slab(slab_reading *s, double done, slab_visitor *visit, iso_error *err)
{
    ENDED_BY(iso_source_close_owned) iso_volume_source *source = NULL;
    if (s->is_kept)
        return visit(s, 0, err);
    NEED(iso_volume_input_open(s->path, s->input, &source, err));
    return read_slabs(s, source, done, visit, err);
}

/* Prepares the header and one slab of a volume that is too large to keep in memory. */
static iso_status make_slab(slab_reading *s, const iso_volume *header, size_t plane_bytes, iso_error *err)
{
    const size_t bytes = s->opt->slab_bytes ? s->opt->slab_bytes : USUAL_SLAB_BYTES, nz = header->geometry.size[2];
    s->out->header = *header;
    s->out->header.segments = json_incref(header->segments);
    s->planes = bytes / plane_bytes < nz ? bytes / plane_bytes : nz;
    s->planes = s->planes ? s->planes : 1;
    s->slab = (iso_volume){.geometry = header->geometry, .type = header->type};
    s->slab.data = malloc(s->planes * plane_bytes);
    NEED_MEMORY(s->slab.data, err, "%s: no memory for %zu planes", s->path, s->planes);
    iso_label_facts facts;
    iso_volume *own = &s->out->header;
    const iso_status status = iso_volume_input_look(s->path, s->input, &own->notes.label_count, &facts, err);
    if (status == ISO_OK && own->notes.label_count > 0 && facts.is_sparse) {
        json_t *names = iso_labels_names(&facts, own->segments);
        json_decref(own->segments);
        own->segments = names;
    }
    return status;
}

static iso_status keep_all(slab_reading *s, iso_volume_source *source, iso_error *err)
{
    iso_progress_report(s->progress, "read", 0);
    NEED(iso_volume_input_load_source(source, s->path, s->input, &s->slab, err));
    s->is_kept = true;
    s->out->header = s->slab;
    s->out->header.data = NULL;
    s->slab.segments = NULL;
    return ISO_OK;
}

static iso_status open_volume(slab_reading *s, iso_error *err)
{
    const size_t kept = s->opt->kept_bytes ? s->opt->kept_bytes : USUAL_KEPT_BYTES;
    iso_volume_source *source = NULL;
    NEED(iso_volume_input_open(s->path, s->input, &source, err));
    const iso_volume *header = iso_source_volume(source);
    const size_t *n = header->geometry.size, plane_bytes = n[0] * n[1] * iso_type_bytes(header->type);
    if (plane_bytes * n[2] <= kept)
        return keep_all(s, source, err);
    iso_status status = make_slab(s, header, plane_bytes, err);
    iso_source_close(source);
    return status;
}

/* ---- range and rounding ---- */

/* Returns the sample itself, if a row of floats would round it. */
static double exact_sample(const iso_volume *v, size_t at)
{
    switch (v->type) {
    case ISO_U32: return ((const uint32_t *)v->data)[at];
    case ISO_I32: return ((const int32_t *)v->data)[at];
    case ISO_F64: return ((const double *)v->data)[at];
    default: return NAN;
    }
}

static void measure_rounding(const iso_volume *v, iso_overview *out)
{
    if (v->type != ISO_U32 && v->type != ISO_I32 && v->type != ISO_F64)
        return;
    const size_t count = iso_geometry_voxel_count(&v->geometry);
    for (size_t i = 0; i < count; ++i) {
        const double value = exact_sample(v, i), lost = fabs(value - (double)(float)value);
        out->rounded += lost > 0;
        out->most_rounded = fmax(out->most_rounded, lost);
    }
}

static iso_status refuse_nonfinite(const slab_reading *s, size_t first_plane, const iso_volume_stats *stats,
                                   iso_error *err)
{
    const size_t *at = stats->first_nonfinite;
    return iso_fail(err, ISO_E_RANGE,
                    "%s: voxel (%zu, %zu, %zu) is NaN or infinite, none may be; --no-data inf leaves infinite ones out",
                    s->path, at[0], at[1], first_plane + at[2]);
}

static iso_status measure_slab(slab_reading *s, size_t first_plane, iso_error *err)
{
    const iso_volume_stats stats = iso_volume_measure(&s->slab);
    iso_volume_stats *all = &s->out->stats;
    const size_t counted = iso_geometry_voxel_count(&s->slab.geometry) - stats.no_data_count;
    if (stats.nonfinite_count > 0)
        return refuse_nonfinite(s, first_plane, &stats, err);
    all->min = fmin(all->min, stats.min);
    all->max = fmax(all->max, stats.max);
    all->no_data_count += stats.no_data_count;
    s->sum += counted > 0 ? stats.mean * (double)counted : 0;
    s->are_whole = s->are_whole && iso_volume_is_whole(&s->slab);
    measure_rounding(&s->slab, s->out);
    return ISO_OK;
}

static iso_status measure(slab_reading *s, iso_error *err)
{
    s->out->stats = (iso_volume_stats){.min = INFINITY, .max = -INFINITY};
    s->are_whole = true;
    NEED(each_slab(s, 0, measure_slab, err));
    const size_t count = iso_geometry_voxel_count(&s->out->header.geometry), without = s->out->stats.no_data_count;
    s->out->stats.mean = s->sum / (double)(count - without);
    s->out->header.geometry.has_no_data = without > 0;
    return iso_volume_check_stats(&s->out->stats, &s->out->header.geometry, s->path, err);
}

/* ---- counting ---- */

static iso_status begin_counts(slab_reading *s, counts *c, iso_error *err)
{
    const iso_volume_stats *stats = &s->out->stats;
    c->row = malloc(s->out->header.geometry.size[0] * sizeof *c->row);
    c->fine = calloc(FINE_BINS, sizeof *c->fine);
    NEED_MEMORY(c->row && c->fine, err, "%s: no memory for counts", s->path);
    NEED(iso_value_histogram_begin(s->are_whole, stats->min, stats->max, ISO_OVERVIEW_BINS, &c->shown, err));
    return s->opt->drawn_bins
               ? iso_value_histogram_begin(s->are_whole, stats->min, stats->max, s->opt->drawn_bins, &c->drawn, err)
               : ISO_OK;
}

static void end_counts(counts *c)
{
    free(c->row);
    free(c->fine);
    iso_value_histogram_destroy(&c->shown);
    iso_value_histogram_destroy(&c->drawn);
}

static void count_row(const slab_reading *s, counts *c)
{
    const size_t nx = s->out->header.geometry.size[0];
    const double lo = s->out->stats.min, width = s->out->stats.max - lo;
    for (size_t x = 0; x < nx; ++x) {
        const double at = width > 0 ? ((double)c->row[x] - lo) / width * FINE_BINS : 0;
        c->fine[at < 0 ? 0 : at < FINE_BINS ? (size_t)at : FINE_BINS - 1] += !iso_is_no_data(c->row[x]);
    }
    iso_value_histogram_add(&c->shown, c->row, nx);
    if (s->opt->drawn_bins)
        iso_value_histogram_add(&c->drawn, c->row, nx);
}

static iso_status count_slab(slab_reading *s, size_t first_plane, iso_error *err)
{
    (void)first_plane;
    (void)err;
    const size_t *n = s->slab.geometry.size, rows = n[1] * n[2];
#pragma omp parallel for schedule(static) num_threads(s->threads)
    for (size_t r = 0; r < rows; ++r) {
        counts *c = &s->counts[iso_thread_index()];
        iso_volume_row(&s->slab, r % n[1], r / n[1], c->row);
        count_row(s, c);
    }
    return ISO_OK;
}

static void add_counts(slab_reading *s)
{
    for (int t = 1; t < s->threads; ++t) {
        for (size_t b = 0; b < FINE_BINS; ++b)
            s->counts[0].fine[b] += s->counts[t].fine[b];
        iso_value_histogram_add_all(&s->counts[0].shown, &s->counts[t].shown);
        iso_value_histogram_add_all(&s->counts[0].drawn, &s->counts[t].drawn);
    }
    iso_value_histogram_end(&s->counts[0].shown);
    iso_value_histogram_end(&s->counts[0].drawn);
}

static void find_percentiles(iso_overview *out, const size_t *fine)
{
    const double count = (double)(iso_geometry_voxel_count(&out->header.geometry) - out->stats.no_data_count),
                 bin = (out->stats.max - out->stats.min) / FINE_BINS;
    double below = 0;
    for (int b = 0, p = 0; b < FINE_BINS; ++b) {
        out->bins[b * ISO_OVERVIEW_BINS / FINE_BINS] += fine[b];
        below += (double)fine[b];
        for (; p < ISO_OVERVIEW_PERCENTS && below >= iso_overview_percents[p] / 100 * count; ++p)
            out->percentile[p] = out->stats.min + bin * b;
    }
}

static iso_status count_all(slab_reading *s, iso_error *err)
{
    s->counts = calloc((size_t)s->threads, sizeof *s->counts);
    iso_status status = s->counts ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: no memory for counts", s->path);
    for (int t = 0; t < s->threads && status == ISO_OK; ++t)
        status = begin_counts(s, &s->counts[t], err);
    TRY(status, each_slab(s, 0.5, count_slab, err));
    if (status == ISO_OK) {
        add_counts(s);
        find_percentiles(s->out, s->counts[0].fine);
        s->out->shown = s->counts[0].shown;
        s->out->drawn = s->counts[0].drawn;
        s->counts[0].shown = s->counts[0].drawn = (iso_value_histogram){0};
    }
    for (int t = 0; s->counts && t < s->threads; ++t)
        end_counts(&s->counts[t]);
    free(s->counts);
    return status;
}

iso_status iso_overview_run(const char *path, const iso_volume_input *input, const iso_overview_options *opt,
                            iso_overview *out, const iso_progress *progress, iso_error *err)
{
    slab_reading s = {.path = path,
                      .input = input,
                      .opt = opt,
                      .progress = progress,
                      .out = out,
                      .threads = iso_threads(opt->threads)};
    *out = (iso_overview){0};
    iso_status status = open_volume(&s, err);
    TRY(status, measure(&s, err));
    TRY(status, count_all(&s, err));
    iso_volume_destroy(&s.slab);
    if (status != ISO_OK)
        iso_overview_destroy(out);
    return status;
}

void iso_overview_destroy(iso_overview *s)
{
    iso_volume_destroy(&s->header);
    iso_value_histogram_destroy(&s->shown);
    iso_value_histogram_destroy(&s->drawn);
}
