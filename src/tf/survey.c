/* SPDX-License-Identifier: MIT */
#include "tf/survey.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "base/simd.h"
#include "pyramid/narrow.h"

enum { BINS = ISO_SURVEY_BINS, SLOPES = ISO_SURVEY_SLOPES, SAMPLES = 1 << 20, FEW_LABELS = 24 };

double iso_survey_quantile(const iso_survey *s, double part)
{
    const double x = fmin(fmax(part, 0), 1) * ISO_SURVEY_QUANTILES, i = fmin(floor(x), ISO_SURVEY_QUANTILES - 1);
    return s->quantile[(size_t)i] + (x - i) * (s->quantile[(size_t)i + 1] - s->quantile[(size_t)i]);
}

double iso_survey_value(const iso_survey *s, double bin)
{
    return s->lo + (s->hi - s->lo) * (bin + 0.5) / BINS;
}

int iso_survey_bin(const iso_survey *s, double value)
{
    const double x = s->hi > s->lo ? (value - s->lo) / (s->hi - s->lo) * BINS : 0;
    return x >= BINS ? BINS - 1 : x > 0 ? (int)x : 0;
}

/* Returns a bin's magnitude. Bins are spaced as squares: smooth volumes have small magnitudes. At most half the range
 * per axis. */
double iso_survey_slope(const iso_survey *s, double slope)
{
    const double root = (slope + 0.5) / SLOPES;
    return root * root * 0.5 * (s->hi - s->lo);
}

/* ---- quantiles, padding, labels ---- */

/* Sorts floats by digits of 11 bits. spare: of the same size. Returns the array that holds the result. */
static float *sort_floats(float *values, float *spare, size_t count)
{
    enum { BITS = 11, DIGITS = 1 << BITS };
    const uint32_t sign = 0x80000000u;
    for (int shift = 0; shift < 32; shift += BITS) {
        size_t start[DIGITS] = {0}, sum = 0;
#define KEY(bits) ((((bits)&sign ? ~(bits) : (bits) | sign) >> shift) % DIGITS)
        for (size_t i = 0; i < count; ++i) {
            uint32_t bits;
            memcpy(&bits, values + i, sizeof bits);
            ++start[KEY(bits)];
        }
        for (int k = 0; k < DIGITS; ++k) {
            const size_t own = start[k];
            start[k] = sum;
            sum += own;
        }
        for (size_t i = 0; i < count; ++i) {
            uint32_t bits;
            memcpy(&bits, values + i, sizeof bits);
            spare[start[KEY(bits)]++] = values[i];
        }
#undef KEY
        float *sorted = spare;
        spare = values;
        values = sorted;
    }
    return values;
}

/* Returns voxels at a fixed stride that meets every column and row, sorted. NULL: no memory. */
static float *sorted_samples(const iso_level *l, size_t *count)
{
    const size_t n = iso_geometry_voxel_count(&l->geometry);
    size_t stride = n / SAMPLES + 1;
    while (stride > 1 && (l->geometry.size[0] % stride == 0 || stride % 2 == 0))
        ++stride;
    const size_t most = n / stride + 1;
    float *samples = malloc(2 * most * sizeof *samples);
    *count = 0;
    for (size_t i = 0; samples && i < n; i += stride)
        if (!iso_is_no_data(samples[*count] = (float)iso_level_value(l, i) + 0.0f)) /* not -0, which equals 0 */
            ++*count;
    if (!samples)
        return NULL;
    const float *sorted = sort_floats(samples, samples + most, *count);
    if (sorted != samples)
        memcpy(samples, sorted, *count * sizeof *samples);
    return samples;
}

static bool is_on_face(const size_t n[3], size_t x, size_t y, size_t z)
{
    return x == 0 || y == 0 || z == 0 || x + 1 == n[0] || y + 1 == n[1] || z + 1 == n[2];
}

/* Counts the voxels of the box's faces that have the value. */
static uint64_t count_on_faces(const iso_level *l, float value)
{
    const size_t *n = l->geometry.size;
    uint64_t count = 0;
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y) {
            const bool whole = z == 0 || y == 0 || z + 1 == n[2] || y + 1 == n[1];
            for (size_t x = 0; x < n[0]; x += whole || n[0] == 1 ? 1 : n[0] - 1)
                count += (float)iso_level_value(l, (z * n[1] + y) * n[0] + x) == value;
        }
    return count;
}

/* Finds padding: one value at the low end and on the faces, separated from the others by at least a tenth of their
 * span. Returns its count in `sample`; 0: none. */
static size_t find_padding(const iso_level *l, const float *sample, size_t count, iso_survey *s)
{
    size_t run = 1;
    while (run < count && sample[run] == sample[0])
        ++run;
    if (run == count || (double)run < 0.001 * (double)count)
        return 0;
    const size_t rest = count - run;
    const double gap = (double)sample[run] - sample[0];
    const double span = (double)sample[run + rest - 1 - rest / 1000] - sample[run + rest / 1000];
    if (gap <= 0.1 * span || (double)sample[run] == 0 || (s->face_padding = count_on_faces(l, sample[0])) == 0)
        return 0;
    s->has_padding = true;
    s->padding = sample[0];
    return run;
}

/* Stores all labels of a label map, even rare ones. With more than ISO_SURVEY_LABELS it is treated as other volumes. */
static iso_status take_labels(const iso_level *l, iso_survey *s, iso_error *err)
{
    enum { LEAST = -32768, SPAN = 65536 + 32768 };
    const size_t count = iso_geometry_voxel_count(&l->geometry);
    FREED char *seen = calloc(SPAN, 1);
    NEED_MEMORY(seen, err, "no memory for labels");
    for (size_t i = 0; i < count; ++i) {
        const double value = iso_level_value(l, i);
        if (value >= LEAST && value < LEAST + SPAN)
            seen[(int)value - LEAST] = 1;
    }
    s->label_count = 0;
    s->is_label_map = true;
    s->segments = l->segments;
    for (int i = 0; i < SPAN && s->is_label_map; ++i)
        if (seen[i] && s->label_count < ISO_SURVEY_LABELS)
            s->labels[s->label_count++] = i + LEAST;
        else if (seen[i])
            s->is_label_map = false;
    return ISO_OK;
}

/* Finds labels: few distinct whole numbers, each with many voxels. */
static void find_labels(const float *sample, size_t count, iso_survey *s)
{
    size_t found = 0;
    for (size_t i = 0; i < count;) {
        size_t run = i;
        while (run < count && sample[run] == sample[i])
            ++run;
        if (found == FEW_LABELS || sample[i] != floorf(sample[i]))
            return;
        s->labels[found++] = sample[i];
        i = run;
    }
    s->label_count = found;
}

static double part_between(const float *sample, size_t count, double lo, double hi)
{
    size_t inside = 0;
    for (size_t i = 0; i < count; ++i)
        inside += sample[i] >= lo && sample[i] <= hi;
    return (double)inside / (double)count;
}

static void summarize(const float *sample, size_t count, iso_survey *s)
{
    for (size_t i = 0; i <= ISO_SURVEY_QUANTILES; ++i)
        s->quantile[i] = sample[(size_t)((double)(count - 1) * (double)i / ISO_SURVEY_QUANTILES)];
    s->lo = sample[(size_t)(0.0005 * (double)(count - 1))];
    s->hi = sample[(size_t)(0.9995 * (double)(count - 1))];
    if (!(s->hi > s->lo)) { /* almost all voxels have one value */
        s->lo = sample[0];
        s->hi = sample[count - 1];
    }
    s->is_hounsfield = part_between(sample, count, -1100, -850) > 0.01 &&
                       part_between(sample, count, -200, 300) > 0.01 &&
                       part_between(sample, count, -1100, 32767) > 0.98 && s->hi > 100 && s->hi < 20000;
    find_labels(sample, count, s);
}

/* ---- histograms ---- */

enum { BLOCK = 128, ROWS = 5 }; /* voxels of a row that are counted at once; rows with their neighbors */

/* Consecutive voxels of a row and their neighbors: [axis][0] before, [axis][1] after; at a border the voxels
 * themselves. */
typedef struct neighbors {
    const float *at, *side[3][2];
    size_t count;
} neighbors;

/* Voxels of level 0: where they and their neighbors are. */
typedef struct segment {
    const iso_level *level;
    size_t first, count;
    size_t ends[2];        /* of neighbors in the row: 0 at a border, otherwise 1 */
    size_t rows[ROWS - 1]; /* first neighbors along y and z; `first` at a border */
} segment;

static segment find_segment(const iso_level *l, size_t x, size_t y, size_t z, size_t count)
{
    const size_t *n = l->geometry.size, place[3] = {x, y, z}, step[3] = {1, n[0], n[0] * n[1]};
    segment s = {.level = l, .first = x + n[0] * (y + n[1] * z), .count = count, .ends = {x > 0, x + count < n[0]}};
    for (int a = 1; a < 3; ++a) {
        s.rows[2 * a - 2] = place[a] > 0 ? s.first - step[a] : s.first;
        s.rows[2 * a - 1] = place[a] + 1 < n[a] ? s.first + step[a] : s.first;
    }
    return s;
}

/* True if all voxels and neighbors are the same bytes. */
static bool is_flat(const segment *s)
{
    const iso_level *l = s->level;
    const size_t bytes = l->scalar ? sizeof *l->scalar : iso_type_bytes(l->samples->type);
    const char *data = l->scalar ? (const char *)l->scalar : l->samples->data, *at = data + bytes * s->first;
    const size_t row = s->count + s->ends[0] + s->ends[1];
    const char *begin = at - bytes * s->ends[0];
    if (memcmp(begin, begin + bytes, bytes * (row - 1)) != 0)
        return false;
    for (int i = 0; i < ROWS - 1; ++i)
        if (memcmp(at, data + bytes * s->rows[i], bytes * s->count) != 0)
            return false;
    return true;
}

/* Reads the voxels. buffer: for levels whose floats are not in memory. */
static neighbors read_segment(const segment *s, float buffer[ROWS][BLOCK + 2])
{
    const float *row = iso_level_floats(s->level, s->first - s->ends[0], s->count + s->ends[0] + s->ends[1], buffer[0]);
    neighbors v = {.at = row + s->ends[0], .count = s->count};
    v.side[0][0] = row;
    v.side[0][1] = v.at + s->ends[1];
    for (int i = 0; i < ROWS - 1; ++i)
        v.side[1 + i / 2][i % 2] = iso_level_floats(s->level, s->rows[i], s->count, buffer[1 + i]);
    return v;
}

/* True if the value is of a voxel without data, or padding. */
static bool is_left_out(const iso_survey *s, float value)
{
    return iso_is_no_data(value) || (s->has_padding && (double)value == s->padding);
}

/* Computes iso_survey_bin() of each voxel. */
ISO_SIMD static void bin_values(const neighbors *v, double lo, double hi, int *restrict bins)
{
    const double range = hi > lo ? hi - lo : 1, count = hi > lo ? BINS : 0;
    const float *values = v->at;
    for (size_t i = 0; i < v->count; ++i) {
        const double x = ((double)values[i] - lo) / range * count;
        bins[i] = (int)(x >= BINS ? BINS - 1 : x > 0 ? x : 0);
    }
}

/* Bins the square root of the gradient, in value per voxel of the mean spacing. scale: 1 / (2 h). */
ISO_SIMD static void bin_slopes(const neighbors *v, const double scale[3], double largest, int *restrict bins)
{
    const float *x0 = v->side[0][0], *x1 = v->side[0][1], *y0 = v->side[1][0], *y1 = v->side[1][1];
    const float *z0 = v->side[2][0], *z1 = v->side[2][1];
    for (size_t i = 0; i < v->count; ++i) {
        const double dx = ((double)x1[i] - (double)x0[i]) * scale[0];
        const double dy = ((double)y1[i] - (double)y0[i]) * scale[1];
        const double dz = ((double)z1[i] - (double)z0[i]) * scale[2];
        const double magnitude = sqrt(dx * dx + dy * dy + dz * dz);
        const double bin = magnitude < largest ? SLOPES * sqrt(magnitude / largest) : SLOPES;
        bins[i] = (int)(bin >= SLOPES ? SLOPES - 1 : bin);
    }
}

/* Distance of a place among bins, computed in floats, from a whole number below which doubles have to decide: the
 * errors of floats are below 4e-5 of a bin. */
#define UNSURE 2e-4f

/* Rounds places down to bins. False if one is too close to a whole number; 0 is exact. */
ISO_SIMD static bool take_bins(const float *restrict x, size_t count, int *restrict bins)
{
    int unsure = 0;
    for (size_t i = 0; i < count; ++i) {
        const int bin = (int)x[i];
        const float off = fabsf(x[i] - (float)bin - 0.5f);
        bins[i] = bin;
        unsure |= (off > 0.5f - UNSURE ? 1 : 0) & (x[i] > 0 ? 1 : 0);
    }
    return !unsure;
}

/* Computes places of bin_values() in floats. lo is a float. */
ISO_SIMD static void place_values(const float *restrict at, size_t count, float lo, float scale, float *restrict x)
{
    for (size_t i = 0; i < count; ++i) {
        const float place = (at[i] - lo) * scale, above = place > 0 ? place : 0;
        x[i] = above < BINS ? above : BINS - 0.5f;
    }
}

/* Computes places of bin_slopes() in floats. scale: divided by the largest magnitude. */
ISO_SIMD static void place_slopes(const neighbors *v, const float scale[3], float *restrict x)
{
    const float *x0 = v->side[0][0], *x1 = v->side[0][1], *y0 = v->side[1][0], *y1 = v->side[1][1];
    const float *z0 = v->side[2][0], *z1 = v->side[2][1], sx = scale[0], sy = scale[1], sz = scale[2];
    for (size_t i = 0; i < v->count; ++i) {
        const float dx = (x1[i] - x0[i]) * sx, dy = (y1[i] - y0[i]) * sy, dz = (z1[i] - z0[i]) * sz;
        const float place = SLOPES * sqrtf(sqrtf(dx * dx + dy * dy + dz * dz));
        x[i] = place < SLOPES ? place : SLOPES - 0.5f;
    }
}

/* Marks voxels without data or with the padding's value: 1; and those beside one, whose difference to it is no
 * gradient: 2. Returns whether there are any. */
ISO_SIMD static bool mark_gaps(const neighbors *v, float padding, int *restrict gap)
{
    int found = 0;
    for (size_t i = 0; i < v->count; ++i)
        gap[i] = (v->at[i] == ISO_NO_DATA) | (v->at[i] == padding);
    for (int a = 0; a < 3; ++a)
        for (int k = 0; k < 2; ++k) {
            const float *restrict side = v->side[a][k];
            for (size_t i = 0; i < v->count; ++i)
                gap[i] |= ((side[i] == ISO_NO_DATA) | (side[i] == padding)) << 1;
        }
    for (size_t i = 0; i < v->count; ++i)
        found |= gap[i];
    return found;
}

/* Scales of bins. */
typedef struct bin_scales {
    double slope[3], largest; /* 1 / (2 h); the magnitude of the last bin's end */
    float slope_fast[3], value_fast;
    bool is_fast; /* floats hold them */
} bin_scales;

static bin_scales find_scales(const iso_geometry *g, const iso_survey *s)
{
    double spacing[3];
    iso_geometry_spacing_mm(g, spacing);
    const double mean = cbrt(spacing[0] * spacing[1] * spacing[2]), range = s->hi - s->lo;
    bin_scales b = {.largest = 0.5 * range,
                    .value_fast = (float)(BINS / range),
                    .is_fast = range > 1e-30 && range < 1e30};
    for (int a = 0; a < 3; ++a) {
        b.slope[a] = 0.5 * mean / spacing[a];
        b.slope_fast[a] = (float)(b.slope[a] / b.largest);
        b.is_fast = b.is_fast && b.slope_fast[a] > 1e-30f && b.slope_fast[a] < 1e30f;
    }
    return b;
}

/* Counts voxels with gaps among them or next to them, those next to a gap without their magnitude. */
static void count_with_gaps(const neighbors *v, const int *gap, bool face, const int *values, const int *slopes,
                            iso_survey *s)
{
    for (size_t i = 0; i < v->count; ++i) {
        if (gap[i] & 1) {
            s->face_padding += face && iso_is_no_data(v->at[i]);
            continue;
        }
        s->face[values[i]] += face;
        if (gap[i])
            ++s->count[values[i]];
        else
            ++s->joint[values[i]][slopes[i]];
    }
}

static void count_flat(float value, size_t count, bool face, iso_survey *s)
{
    const int bin = iso_survey_bin(s, (double)value);
    if (iso_is_no_data(value))
        s->face_padding += face ? count : 0;
    if (is_left_out(s, value))
        return;
    s->face[bin] += face ? count : 0;
    s->joint[bin][0] += count;
}

static void count_block(const neighbors *v, bool face, const bin_scales *b, iso_survey *s)
{
    int values[BLOCK], slopes[BLOCK], gap[BLOCK];
    float places[BLOCK];
    place_values(v->at, v->count, (float)s->lo, b->value_fast, places);
    if (!b->is_fast || !take_bins(places, v->count, values))
        bin_values(v, s->lo, s->hi, values);
    place_slopes(v, b->slope_fast, places);
    if (!b->is_fast || !take_bins(places, v->count, slopes))
        bin_slopes(v, b->slope, b->largest, slopes);
    if ((s->has_padding || s->has_no_data) && mark_gaps(v, s->has_padding ? (float)s->padding : ISO_NO_DATA, gap)) {
        count_with_gaps(v, gap, face, values, slopes, s);
        return;
    }
    for (size_t i = 0; i < v->count; ++i)
        ++s->joint[values[i]][slopes[i]];
    for (size_t i = 0; face && i < v->count; ++i)
        ++s->face[values[i]];
}

/* Adds the voxels with a magnitude to those without. */
static void sum_up(iso_survey *s)
{
    for (int i = 0; i < BINS; ++i) {
        for (int k = 0; k < SLOPES; ++k)
            s->count[i] += s->joint[i][k];
        s->voxel_count += s->count[i];
    }
}

/* Counts a row. Its first and last voxels are counted by themselves: they are on faces and have a neighbor less. */
static void count_row(const iso_level *l, size_t y, size_t z, const bin_scales *b, iso_survey *s)
{
    const size_t *n = l->geometry.size;
    float buffer[ROWS][BLOCK + 2];
    for (size_t x = 0, count; x < n[0]; x += count) {
        const bool is_end = x == 0 || x + 1 == n[0], face = is_on_face(n, x, y, z);
        const size_t left = n[0] - 1 - x;
        count = is_end ? 1 : left < BLOCK ? left : BLOCK;
        const segment at = find_segment(l, x, y, z, count);
        s->face_count += face ? count : 0;
        if (b->is_fast && is_flat(&at)) {
            count_flat((float)iso_level_value(l, at.first), count, face, s);
            continue;
        }
        const neighbors v = read_segment(&at, buffer);
        count_block(&v, face, b, s);
    }
}

static void add_counts(iso_survey *sum, const iso_survey *part)
{
    sum->face_count += part->face_count;
    sum->face_padding += part->face_padding;
    for (int i = 0; i < BINS; ++i) {
        sum->count[i] += part->count[i];
        sum->face[i] += part->face[i];
        for (int k = 0; k < SLOPES; ++k)
            sum->joint[i][k] += part->joint[i][k];
    }
}

static iso_status count_all(const iso_level *l, int threads, iso_survey *s, iso_error *err)
{
    const size_t *n = l->geometry.size;
    const bin_scales scales = find_scales(&l->geometry, s);
    bool complete = true;
#pragma omp parallel num_threads(iso_threads(threads))
    {
        iso_survey *mine = calloc(1, sizeof *mine);
        if (mine) {
            mine->lo = s->lo, mine->hi = s->hi;
            mine->has_padding = s->has_padding, mine->padding = s->padding;
            mine->has_no_data = s->has_no_data;
        }
#pragma omp for schedule(static)
        for (size_t z = 0; z < n[2]; ++z)
            for (size_t y = 0; mine && y < n[1]; ++y)
                count_row(l, y, z, &scales, mine);
#pragma omp critical
        {
            complete = complete && mine;
            if (mine)
                add_counts(s, mine);
        }
        free(mine);
    }
    sum_up(s);
    return complete ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for a histogram of value and gradient");
}

/* Smooths with a Gaussian of sigma bins; the ends are repeated. */
static void smooth(const double *in, double sigma, double *out)
{
    const int reach = (int)ceil(3 * sigma);
    for (int i = 0; i < BINS; ++i) {
        double sum = 0, weight = 0;
        for (int k = -reach; k <= reach; ++k) {
            if (i + k < 0 || i + k >= BINS)
                continue;
            const double w = exp(-0.5 * k * k / (sigma * sigma));
            sum += w * in[i + k];
            weight += w;
        }
        out[i] = sum / weight;
    }
}

/* Computes the profiles. Flat: below a quarter of the steepest mean. Sums of g and of g^2 are smoothed separately, so
 * that bins with few voxels follow their neighbors. */
static void profile(iso_survey *s)
{
    double sum[BINS] = {0}, squares[BINS] = {0}, flat[BINS] = {0}, steepest = 0;
    for (int i = 0; i < BINS; ++i)
        for (int k = 0; k < SLOPES; ++k) {
            const double g = iso_survey_slope(s, k), n = (double)s->joint[i][k];
            sum[i] += n * g;
            squares[i] += n * g * g;
        }
    smooth(sum, 2, s->slope);
    smooth(squares, 2, s->flat);
    for (int i = 0; i < BINS; ++i) {
        s->slope[i] = s->slope[i] > 0 ? s->flat[i] / s->slope[i] : 0;
        steepest = fmax(steepest, s->slope[i]);
    }
    for (int i = 0; i < BINS; ++i)
        for (int k = 0; k < SLOPES && iso_survey_slope(s, k) < 0.25 * steepest; ++k)
            flat[i] += (double)s->joint[i][k];
    smooth(flat, 3, s->flat);
}

/* ---- the background ---- */

/* Walks from the peak to the first bin with less than 3 % of it, or after which it rises again by half. */
static int walk(const double *density, int peak, int way)
{
    double least = density[peak];
    int at = peak, lowest = peak;
    for (at = peak; at + way >= 0 && at + way < BINS; at += way) {
        const double next = density[at + way];
        if (next < least) {
            least = next;
            lowest = at + way;
        }
        if (next < 0.03 * density[peak])
            return at + way;
        if (least < 0.5 * density[peak] && next > 1.5 * least)
            return lowest;
    }
    return at;
}

/* Smooths counts and finds the bins of their highest peak: first, peak, last. The peak is below bin `end`. */
static void find_peak(const uint64_t count[BINS], int end, int bins[3])
{
    double own[BINS], density[BINS];
    int peak = 0;
    for (int i = 0; i < BINS; ++i)
        own[i] = (double)count[i];
    smooth(own, 1, density);
    for (int i = 0; i < end; ++i)
        peak = density[i] > density[peak] ? i : peak;
    bins[0] = walk(density, peak, -1);
    bins[1] = peak;
    bins[2] = walk(density, peak, 1);
}

static void take_background(iso_survey *s, const int bins[3])
{
    s->has_background = true;
    s->background = iso_survey_value(s, bins[1]);
    s->background_lo = iso_survey_value(s, bins[0]);
    s->background_hi = iso_survey_value(s, bins[2]);
}

/* Finds the air of a CT whose body reaches the box's faces, or all that padding leaves of them: it is inside, or in
 * gaps. */
static void find_air(iso_survey *s)
{
    enum { AIR = -800 }; /* Hounsfield units; the lungs are above */
    int bins[3];
    find_peak(s->count, iso_survey_bin(s, AIR) + 1, bins);
    if (s->face_padding > 0) {
        take_background(s, bins);
        return;
    }
    s->has_background = true;
    s->background = s->background_lo = s->lo;
    s->background_hi = AIR;
}

/* Finds the background: half of the faces, padding included, in at most half of the range. */
static void find_background(iso_survey *s)
{
    double part = (double)s->face_padding;
    int bins[3];
    find_peak(s->face, BINS, bins);
    for (int i = bins[0]; i <= bins[2]; ++i)
        part += (double)s->face[i];
    const bool is_found = s->face_count > 0 && part >= 0.5 * (double)s->face_count && bins[2] - bins[0] < BINS / 2;
    const bool is_padded_ct = s->is_hounsfield && s->face_padding > 0 && iso_survey_value(s, bins[1]) > -800;
    /* If padding covers most of the faces, their other values are the background only if they are dark. Otherwise they
     * are the object, which was cut out or touches the faces. */
    const bool is_padded = s->face_padding * 10 > s->face_count * 9 ||
                           (s->face_padding * 2 > s->face_count && bins[1] > BINS / 4);
    take_background(s, bins);
    s->has_background = is_found;
    if (s->is_hounsfield && (is_padded_ct || !is_found)) {
        find_air(s);
    } else if (is_padded && !s->is_hounsfield) {
        s->has_background = true;
        s->background = s->background_lo = s->background_hi = s->has_padding ? fmax(s->padding, s->lo) : s->lo;
    }
}

iso_status iso_survey_make(const iso_level *level0, int threads, iso_survey **survey, iso_error *err)
{
    *survey = NULL;
    if (!level0->scalar && !level0->samples)
        return iso_fail(err, ISO_E_RANGE, "cannot survey a level without its values");
    size_t count = 0;
    iso_survey *s = calloc(1, sizeof *s);
    FREED float *sample = sorted_samples(level0, &count);
    iso_status status = s && sample ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory to survey a volume's values");
    if (status == ISO_OK) {
        s->has_no_data = level0->geometry.has_no_data;
        s->min = level0->min;
        s->max = level0->max;
        const size_t padding = find_padding(level0, sample, count, s);
        summarize(sample + padding, count - padding, s);
        status = level0->labels ? take_labels(level0, s, err) : ISO_OK;
    }
    TRY(status, count_all(level0, threads, s, err));
    if (status == ISO_OK) {
        profile(s);
        find_background(s);
        *survey = s;
    } else {
        free(s);
    }
    return status;
}
