/* SPDX-License-Identifier: MIT */
#include "tf/suggest.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "tf/color_space.h"
#include "volume/segments.h"

enum { BINS = ISO_SURVEY_BINS };

/* Opacities are for two voxels: a surface is opaque after four. */
#define UNIT_VOXELS 2
#define SOLID 0.75
/* Opacity of all of a veil's material together. */
#define VEIL 0.45
/* An organ that was cut out: the part of the volume that has the least value at least, and the part of the voxels above
 * the background that its rim has at most. A brain's rim has .08; skin and bone of a whole head have .3. */
#define CUT_OUT 0.3
#define RIM 0.15

const char *iso_suggest_kind_text(iso_suggest_kind kind)
{
    static const char *const texts[] = {
        [ISO_SUGGEST_OBJECT] = "an object brighter than its background",
        [ISO_SUGGEST_DARK] = "an object darker than its background",
        [ISO_SUGGEST_SIGNED] = "values on both sides of the background",
        [ISO_SUGGEST_SHELL] = "no background: the steepest isosurface",
        [ISO_SUGGEST_LABELS] = "labels",
        [ISO_SUGGEST_FLAT] = "one value",
    };
    return texts[kind];
}

/* ---- profiles of one side of the background ---- */

/* The bins on one side of the background, counted away from it: upwards, or downwards for a dark object. */
typedef struct side {
    const iso_survey *survey;
    bool down;
    int first; /* first bin beyond the background; BINS: none */
    double count[BINS], flat[BINS], slope[BINS];
    double above; /* voxels from `first` on */
} side;

static int bin_of(const side *p, int i)
{
    return p->down ? BINS - 1 - i : i;
}

static double value_of(const side *p, double i)
{
    return iso_survey_value(p->survey, p->down ? BINS - 1 - i : i);
}

static void take_side(side *p, const iso_survey *s, bool down)
{
    *p = (side){.survey = s, .down = down};
    for (int i = 0; i < BINS; ++i) {
        const int bin = bin_of(p, i);
        p->count[i] = (double)s->count[bin];
        p->flat[i] = s->flat[bin];
        p->slope[i] = s->slope[bin];
    }
    const int end = bin_of(p, iso_survey_bin(s, down ? s->background_lo : s->background_hi));
    p->first = end + 1;
    for (int i = p->first; i < BINS; ++i)
        p->above += p->count[i];
}

static double sum_of(const double *x, int from, int to)
{
    double sum = 0;
    for (int i = from; i < to; ++i)
        sum += x[i];
    return sum;
}

static int steepest(const side *p, int from, int to)
{
    int best = from;
    for (int i = from; i < to; ++i)
        best = p->slope[i] > p->slope[best] ? i : best;
    return best;
}

/* ---- materials ---- */

typedef struct material {
    int peak, begins;
} material;

/* Finds peaks of flat voxels with at least 1/50 of the object; valleys between them have at most .7 of the lower
 * one. */
static int find_peaks(const side *p, material found[ISO_SUGGEST_MATERIALS])
{
    const double least = 0.02 * sum_of(p->flat, p->first, BINS);
    int count = 0, candidate = -1, lowest = p->first;
    for (int i = p->first; i < BINS; ++i) {
        if (p->flat[i] < p->flat[lowest])
            lowest = i;
        const bool is_top = i > p->first && i + 1 < BINS && p->flat[i] >= p->flat[i - 1] && p->flat[i] > p->flat[i + 1];
        if (!is_top)
            continue;
        const double valley = p->flat[lowest];
        if (candidate >= 0 && valley > 0.7 * fmin(p->flat[i], p->flat[candidate])) {
            if (p->flat[i] > p->flat[candidate])
                candidate = found[count - 1].peak = i;
            lowest = i;
            continue;
        }
        if (p->flat[i] <= 1.4 * valley ||
            sum_of(p->flat, lowest, i + (i - lowest) < BINS ? i + (i - lowest) : BINS) < least)
            continue;
        if (count == ISO_SUGGEST_MATERIALS)
            break;
        candidate = found[count++].peak = i;
        lowest = i;
    }
    return count;
}

/* Part of the height of an arch at which a material begins: RISEN between two materials. An arch without a peak at its
 * end has the height of the steepest structures, and dimmer ones have lower arches: LOW keeps them. */
#define RISEN 0.7
#define LOW 0.5

static int arch_begins(const side *p, int from, int to, double part)
{
    const double height = p->slope[steepest(p, from, to)];
    int i = from;
    while (i + 1 < to && p->slope[i] < part * height)
        ++i;
    return i;
}

/* Finds a material brighter than the last peak without a peak of its own, such as bone in a CT. It has at least 1/200
 * of the object, is at least half as far from the peak as the peak from the background, and is separate from the peak's
 * foot by the foot's width: the tail of an uneven MRI belongs to its peak. */
static bool find_tail(const side *p, const material *last, int background, material *tail)
{
    int end = last->peak;
    while (end + 1 < BINS && p->flat[end] > 0.1 * p->flat[last->peak])
        ++end;
    if (sum_of(p->count, end, BINS) < 0.005 * p->above || BINS - 1 - last->peak < (last->peak - background) / 2)
        return false;
    tail->begins = arch_begins(p, end, BINS, RISEN);
    tail->peak = (tail->begins + BINS) / 2;
    return tail->begins + 4 < BINS && tail->begins - last->peak > 2 * (end - last->peak);
}

/* Moves `begins` down until at least a tenth of the object is shown. If magnitudes grow with the value to the very end,
 * as in a simulation with a heavy tail, an arch has no foot. */
static int bounded(const side *p, int begins)
{
    double shown = sum_of(p->count, begins, BINS);
    while (begins > p->first && shown < 0.1 * p->above)
        shown += p->count[--begins];
    return begins;
}

static int find_materials(const side *p, material found[ISO_SUGGEST_MATERIALS])
{
    const int background = bin_of(p, iso_survey_bin(p->survey, p->survey->background));
    int count = find_peaks(p, found);
    if (count == 0) {
        found[0].begins = bounded(p, arch_begins(p, p->first, BINS, LOW));
        found[0].peak = (found[0].begins + BINS) / 2;
        return 1;
    }
    found[0].begins = arch_begins(p, p->first, found[0].peak + 1, RISEN);
    for (int k = 1; k < count; ++k)
        found[k].begins = arch_begins(p, (found[k - 1].peak + found[k].peak) / 2, found[k].peak + 1, RISEN);
    material tail;
    if (count < ISO_SUGGEST_MATERIALS && find_tail(p, &found[count - 1], background, &tail))
        found[count++] = tail;
    return count;
}

/* ---- points ---- */

static void add_point(iso_tf *tf, double value, const double srgb[3], double opacity)
{
    iso_tf_point *p = &tf->points[tf->point_count++];
    p->value = value;
    p->opacity = opacity;
    for (int c = 0; c < 3; ++c)
        p->rgb_linear[c] = iso_srgb_to_linear(srgb[c]);
}

static int by_value(const void *a, const void *b)
{
    const iso_tf_point *p = a, *q = b;
    if (p->value != q->value)
        return p->value > q->value ? 1 : -1;
    return (p->opacity > q->opacity) - (p->opacity < q->opacity);
}

static iso_status create_tf(const iso_survey *s, const iso_geometry *g, iso_tf *tf, iso_error *err)
{
    *tf = (iso_tf){.range = {s->lo, s->hi}, .table_size = 1024};
    tf->points = calloc(ISO_SUGGEST_POINTS, sizeof *tf->points);
    /* Two digits, for human readers. */
    const double unit = UNIT_VOXELS * iso_geometry_mean_spacing_mm(g), digit = pow(10, floor(log10(unit)) - 1);
    tf->unit_distance = round(unit / digit) * digit;
    if (!(tf->range[1] > tf->range[0]))
        tf->range[1] = tf->range[0] + fmax(1, fabs(tf->range[0]));
    return tf->points ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "no memory for a transfer function");
}

/* Returns the isosurface's area at a bin in voxels: by the coarea formula, the sum of magnitudes per value. */
static double area_of(const side *p, int begins)
{
    double sum = 0;
    const int from = begins > 1 ? begins - 1 : 0, to = begins + 2 < BINS ? begins + 2 : BINS;
    for (int i = from; i < to; ++i)
        for (int k = 0; k < ISO_SURVEY_SLOPES; ++k)
            sum += (double)p->survey->joint[bin_of(p, i)][k] * iso_survey_slope(p->survey, k);
    return sum / ((to - from) * (p->survey->hi - p->survey->lo) / BINS);
}

/* Returns the opacity at which a ray through the veil loses VEIL. The length of that ray is between a ball's diameter
 * and the mean chord 4 V / A, which holds for a body of any shape. */
static double veil_opacity(const side *p, int begins, double voxels)
{
    const double ball = cbrt(voxels), chord = fmin(ball, 4 * voxels / fmax(area_of(p, begins), 1));
    const double across = fmax(UNIT_VOXELS, sqrt(ball * fmax(chord, UNIT_VOXELS)));
    return fmin(SOLID, 1 - pow(1 - VEIL, UNIT_VOXELS / across));
}

static const double colors[ISO_SUGGEST_MATERIALS][3] = {{0.86, 0.55, 0.38}, {0.95, 0.80, 0.55}, {1.00, 0.97, 0.90}};

/* True for an organ that was cut out, such as a skull-stripped brain: much of the volume has the least value itself. */
static bool is_cut_out(const iso_survey *s, const iso_geometry *g)
{
    const double counted = (double)s->voxel_count / (double)iso_geometry_voxel_count(g); /* without padding */
    const bool has_least = s->has_padding ? s->padding == s->min && counted <= 1 - CUT_OUT
                                          : iso_survey_quantile(s, CUT_OUT) == s->min;
    return g->is_patient && !s->is_hounsfield && has_least;
}

/* Returns the first solid material: the last, or of an organ that was cut out the largest, if it is at least half as
 * bright as the last, as gray matter is beside white. Its surface is then the one to be seen; the few voxels below are
 * the rim of the cut. Skin and bone below are more, and stay a veil. */
static int first_solid(const side *p, bool cut_out, const material *m, int count)
{
    int largest = 0;
    double most = 0;
    for (int k = 0; k < count; ++k) {
        const double voxels = sum_of(p->count, m[k].begins, k + 1 < count ? m[k + 1].begins : BINS);
        largest = voxels > most ? k : largest;
        most = fmax(most, voxels);
    }
    const bool has_rim_only = sum_of(p->count, p->first, m[largest].begins) <= RIM * p->above,
               is_bright = 2 * (m[largest].peak - p->first) >= m[count - 1].peak - p->first;
    return cut_out && has_rim_only && is_bright ? largest : count - 1;
}

/* Adds all materials: opacity rises to a material's own around the value at which it begins. */
static void add_object(const side *p, bool cut_out, iso_suggestion *out)
{
    material m[ISO_SUGGEST_MATERIALS];
    int count = find_materials(p, m), solid = first_solid(p, cut_out, m, count);
    double before = 0;
    int from = p->first;
    if (solid < count - 1) { /* without the rim */
        count -= solid;
        memmove(m, m + solid, (size_t)count * sizeof *m);
        solid = 0;
    }
    out->material_count = (size_t)count;
    for (int k = 0; k < count; ++k) {
        const int to = k + 1 < count ? m[k + 1].begins : BINS;
        const double voxels = sum_of(p->count, m[k].begins, to);
        const double opacity = k < solid ? fmax(before, veil_opacity(p, m[k].begins, voxels)) : SOLID;
        const double *color = colors[count == 1 ? 0 : k + ISO_SUGGEST_MATERIALS - count];
        const double half = fmax(1, fmin(0.5 * (m[k].begins - from), 0.5 * (m[k].peak - m[k].begins)));
        add_point(&out->tf, value_of(p, m[k].begins - half), color, before);
        add_point(&out->tf, value_of(p, fmin(m[k].begins + half, BINS - 1)), color, opacity);
        out->materials[k] = (struct iso_suggest_material){value_of(p, m[k].begins), value_of(p, m[k].peak),
                                                          voxels / (double)p->survey->voxel_count, opacity};
        before = opacity;
        from = m[k].peak;
    }
    add_point(&out->tf, p->down ? p->survey->lo : p->survey->hi, (const double[3]){1, 1, 0.97}, before);
}

/* Adds both sides of the background, each from the beginning of its arch. */
static void add_signed(const side sides[2], iso_suggestion *out)
{
    static const double hue[2][2][3] = {{{0.95, 0.55, 0.20}, {1.00, 0.85, 0.55}},
                                        {{0.20, 0.50, 0.95}, {0.60, 0.85, 1.00}}};
    out->material_count = 2;
    for (int k = 0; k < 2; ++k) {
        const side *p = &sides[k];
        const int begins = bounded(p, arch_begins(p, p->first, BINS, LOW));
        const double half = fmax(1, 0.5 * (begins - p->first));
        add_point(&out->tf, value_of(p, begins - half), hue[k][0], 0);
        add_point(&out->tf, value_of(p, fmin(begins + half, BINS - 1)), hue[k][0], SOLID);
        add_point(&out->tf, p->down ? p->survey->lo : p->survey->hi, hue[k][1], SOLID);
        out->materials[k] = (struct iso_suggest_material){value_of(p, begins), value_of(p, (begins + BINS) / 2),
                                                          sum_of(p->count, begins, BINS) /
                                                              (double)p->survey->voxel_count,
                                                          SOLID};
    }
}

/* Adds the steepest isosurface among the middle values, a twentieth of the range thick. */
static void add_shell(const iso_survey *s, iso_suggestion *out)
{
    side p;
    take_side(&p, s, false);
    int at = BINS / 2;
    const int lo = iso_survey_bin(s, iso_survey_quantile(s, 0.2)), hi = iso_survey_bin(s, iso_survey_quantile(s, 0.8));
    if (hi > lo)
        at = steepest(&p, lo, hi);
    const double half = 0.025 * BINS, inner[3] = {1.00, 0.90, 0.70}, outer[3] = {0.45, 0.70, 0.95};
    add_point(&out->tf, value_of(&p, at - half), outer, 0);
    add_point(&out->tf, value_of(&p, at - 0.3 * half), outer, SOLID);
    add_point(&out->tf, value_of(&p, at + 0.3 * half), inner, SOLID);
    add_point(&out->tf, value_of(&p, at + half), inner, 0);
    out->material_count = 1;
    out->materials[0] = (struct iso_suggest_material){value_of(&p, at), value_of(&p, at),
                                                      sum_of(p.count, at - (int)half, at + (int)half + 1) /
                                                          (double)s->voxel_count,
                                                      SOLID};
}

/* ---- labels ---- */

/* Adds interpolated labels: all but the background's opaque, hues from blue over green to red by value, so that values
 * between two labels get a similar hue. */
static void add_labels(const iso_survey *s, iso_suggestion *out)
{
    static const double hues[6][3] = {{0.35, 0.55, 0.95}, {0.30, 0.80, 0.85}, {0.45, 0.80, 0.40},
                                      {0.95, 0.85, 0.35}, {0.95, 0.55, 0.25}, {0.90, 0.30, 0.30}};
    const double empty = s->has_padding ? s->padding : s->labels[0];
    const double begins = 0.5 * (empty + s->labels[s->has_padding ? 0 : 1]), last = s->labels[s->label_count - 1];
    out->tf.range[0] = fmin(empty, begins);
    out->tf.range[1] = last;
    add_point(&out->tf, begins, hues[0], 0);
    add_point(&out->tf, begins, hues[0], SOLID);
    if (s->label_count == (s->has_padding ? 1 : 2))
        return; /* a single label */
    for (int i = 0; i < 6 && last > begins; ++i)
        add_point(&out->tf, begins + (last - begins) * (i + 0.5) / 6, hues[i], SOLID);
}

/* True if the label is invisible: 0, or the smallest label if there is no 0; never one that is named by a segment. */
static bool is_empty(const iso_survey *s, double label)
{
    const bool has_zero = bsearch(&(double){0}, s->labels, s->label_count, sizeof *s->labels, iso_order_doubles) != NULL;
    return label == (has_zero ? 0 : s->labels[0]) && !iso_segments_find(s->segments, (long)label);
}

/* Computes a color from the label alone, the same in each file: hues a golden angle apart. */
static void palette_color(double label, double srgb[3])
{
    const double hue = 6 * (0.618033988749895 * label - floor(0.618033988749895 * label));
    for (int c = 0; c < 3; ++c) {
        const double away = fabs(fmod(hue + (double[3]){0, 4, 2}[c], 6) - 3) - 1; /* 0 to 1: none to full */
        srgb[c] = 0.95 - 0.55 * (1 - fmin(fmax(away, 0), 1));
    }
}

/* Sets the table's size: each label on an entry, with more of its plateau on both sides, as texture filters round. */
static iso_status size_table(iso_tf *tf, iso_error *err)
{
    const double span = tf->range[1] - tf->range[0];
    size_t each = 1;
    while (each * (size_t)span < 255 || (each < 3 && 3 * span < ISO_TF_MOST_ENTRIES))
        each += 2;
    tf->table_size = each * (size_t)span + 1;
    return tf->table_size <= ISO_TF_MOST_ENTRIES
               ? ISO_OK
               : iso_fail(err, ISO_E_RANGE,
                          "labels run from %g to %g: too many for the %d entries of a transfer function",
                          tf->range[0], tf->range[1], ISO_TF_MOST_ENTRIES);
}

static iso_status add_label_map(const iso_survey *s, iso_suggestion *out, iso_error *err)
{
    iso_tf_point *points = realloc(out->tf.points, 2 * s->label_count * sizeof *points);
    NEED_MEMORY(points, err, "no memory for %zu labels", s->label_count);
    out->tf.points = points;
    out->tf.range[0] = s->labels[0];
    out->tf.range[1] = fmax(s->labels[s->label_count - 1], s->labels[0] + 1);
    for (size_t i = 0; i < s->label_count; ++i) {
        const double label = s->labels[i], opacity = is_empty(s, label) ? 0 : SOLID;
        double srgb[3];
        if (!iso_segments_color(s->segments, (long)label, srgb))
            palette_color(label, srgb);
        add_point(&out->tf, label - 0.5, srgb, opacity);
        add_point(&out->tf, label + 0.5, srgb, opacity);
    }
    return size_table(&out->tf, err);
}

/* ---- all of it ---- */

/* Returns the number of voxels of a side, weighted by their distance from the background. */
static double weight_of(const side *p)
{
    double sum = 0;
    for (int i = p->first; i < BINS; ++i)
        sum += p->count[i] * (i - p->first + 1);
    return sum;
}

static void add_by_background(const iso_survey *s, bool cut_out, iso_suggestion *out)
{
    side sides[2];
    take_side(&sides[0], s, false);
    take_side(&sides[1], s, true);
    const double up = weight_of(&sides[0]), down = weight_of(&sides[1]);
    const int reach[2] = {BINS - sides[0].first, BINS - sides[1].first};
    const double less = fmin(up, down) / fmax(fmax(up, down), 1);
    if (up + down == 0) {
        out->kind = ISO_SUGGEST_SHELL;
        add_shell(s, out);
    } else if (less > 0.15 && 4 * reach[0] > reach[1] && 4 * reach[1] > reach[0]) {
        out->kind = ISO_SUGGEST_SIGNED;
        add_signed(sides, out);
    } else {
        out->kind = up >= down ? ISO_SUGGEST_OBJECT : ISO_SUGGEST_DARK;
        add_object(&sides[up < down], cut_out, out);
    }
}

iso_status iso_suggest(const iso_survey *s, const iso_geometry *level0, iso_suggestion *out, iso_error *err)
{
    *out = (iso_suggestion){.kind = ISO_SUGGEST_FLAT};
    iso_status status = create_tf(s, level0, &out->tf, err);
    if (status != ISO_OK)
        return status;
    if (s->is_label_map) {
        out->kind = ISO_SUGGEST_LABELS;
        status = add_label_map(s, out, err); /* keeps the order of labels */
        if (status != ISO_OK)
            iso_suggestion_destroy(out);
        return status;
    }
    if (s->label_count > 1 || (s->label_count == 1 && s->has_padding)) {
        out->kind = ISO_SUGGEST_LABELS;
        add_labels(s, out);
    } else if (!(s->hi > s->lo)) {
        add_point(&out->tf, s->lo, colors[1], 0.1);
    } else if (s->has_background) {
        add_by_background(s, is_cut_out(s, level0), out);
    } else {
        out->kind = ISO_SUGGEST_SHELL;
        add_shell(s, out);
    }
    qsort(out->tf.points, out->tf.point_count, sizeof *out->tf.points, by_value);
    return ISO_OK;
}

void iso_suggestion_destroy(iso_suggestion *suggestion)
{
    if (!suggestion)
        return;
    iso_tf_destroy(&suggestion->tf);
    *suggestion = (iso_suggestion){0};
}
