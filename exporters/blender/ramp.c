/* SPDX-License-Identifier: MIT */
/* ramp.c - reduces a table of thousands of entries to 32 stops, and measures the error. */
#include <math.h>
#include <string.h>

#include "blender/blender.h"

/* Cycles evaluates a ramp at i / 255 (Blender 3.4) or at i / 256 (4.3) and interpolates, as tests/addon_buttons.py
 * measured. */
static const double baked_steps[] = {255, 256};
static const double close_enough = 1.0 / 1024; /* for fitted stops: invisible, with few stops to edit */
static const double same = 1e-4; /* for a TF's own points: allows for floats of the table near the largest opacity, but
                                  * not for another curve */

static double opacity_of(double extinction, double unit_mm)
{
    return -expm1(-extinction * unit_mm);
}

static double extinction_of(double opacity, double unit_mm)
{
    return -log1p(-fmin(opacity, ISO_TF_MAX_OPACITY)) / unit_mm;
}

static double value_of_entry(const iso_tf_table *t, size_t i)
{
    return t->lo + (double)i / (double)(t->count - 1) * (t->hi - t->lo);
}

static void entry_of(const iso_tf_table *t, size_t i, double unit_mm, double rgba[4])
{
    for (int c = 0; c < 4; ++c)
        rgba[c] = (double)t->entries[4 * i + (size_t)c];
    rgba[3] = opacity_of(rgba[3], unit_mm);
}

static double larger_difference(const double a[4], const double b[4])
{
    double most = 0;
    for (int c = 0; c < 4; ++c)
        most = fmax(most, fabs(a[c] - b[c]));
    return most;
}

/* Returns the largest visible difference. Colors of transparent entries do not count. */
static double visible_difference(const double want[4], const double have[4])
{
    return want[3] < close_enough ? fabs(want[3] - have[3]) : larger_difference(want, have);
}

/* Evaluates a ramp like Blender: of stops at the same position, the later one counts. */
static void ramp_at(const iso_color_ramp *ramp, double x, double rgba[4])
{
    size_t above = 0;
    while (above < ramp->count && ramp->position[above] <= x)
        ++above;
    const size_t i = above > 0 ? above - 1 : 0, next = above < ramp->count ? above : ramp->count - 1;
    const double span = ramp->position[next] - ramp->position[i];
    const double f = span > 0 ? fmin(fmax((x - ramp->position[i]) / span, 0), 1) : 0;
    for (int c = 0; c < 4; ++c)
        rgba[c] = (1 - f) * ramp->rgba[i][c] + f * ramp->rgba[next][c];
}

static void baked_at(const iso_color_ramp *ramp, double steps, double x, double rgba[4])
{
    const double at = fmin(fmax(x, 0), 1) * steps, whole = floor(at), f = at - whole;
    double next[4];
    ramp_at(ramp, whole / steps, rgba);
    ramp_at(ramp, fmin(whole + 1, steps) / steps, next);
    for (int c = 0; c < 4; ++c)
        rgba[c] = (1 - f) * rgba[c] + f * next[c];
}

static double place(const iso_color_ramp *ramp, double value)
{
    return (value - ramp->lo) / (ramp->hi - ramp->lo);
}

/* Inserts a stop by position, after those at the same one. False: there are already 32. */
static bool add_stop(iso_color_ramp *ramp, double x, const double rgba[4])
{
    size_t i = ramp->count;
    const double position = (double)(float)fmin(fmax(x, 0), 1);
    if (ramp->count == ISO_RAMP_MAX_STOPS)
        return false;
    for (; i > 0 && ramp->position[i - 1] > position; --i) {
        ramp->position[i] = ramp->position[i - 1];
        memcpy(ramp->rgba[i], ramp->rgba[i - 1], sizeof ramp->rgba[i]);
    }
    ramp->position[i] = position;
    memcpy(ramp->rgba[i], rgba, sizeof ramp->rgba[i]);
    ++ramp->count;
    return true;
}

/* Moves stops at the same position apart: Blender sorts stops, and could swap the two of a step. */
static void separate(iso_color_ramp *ramp)
{
    static const double apart = 1.0 / (1 << 23); /* resolution of single precision below 1 */
    double *x = ramp->position;
    for (size_t i = 1; i < ramp->count; ++i)
        x[i] = fmax(x[i], x[i - 1] + apart);
    x[ramp->count - 1] = fmin(x[ramp->count - 1], 1);
    for (size_t i = ramp->count - 1; i-- > 0;)
        x[i] = fmin(x[i], x[i + 1] - apart);
}

/* ---- a TF's own points ---- */

/* Interpolates the points' color and opacity at a value; `before`: before a step there. */
static void points_at(const iso_tf_table *t, double value, bool before, double rgba[4])
{
    size_t above = 0;
    while (above < t->point_count && (before ? t->points[above].value < value : t->points[above].value <= value))
        ++above;
    const iso_tf_point *a = &t->points[above > 0 ? above - 1 : 0];
    const iso_tf_point *b = &t->points[above < t->point_count ? above : t->point_count - 1];
    const double span = b->value - a->value, f = span > 0 ? fmin(fmax((value - a->value) / span, 0), 1) : 0;
    for (int c = 0; c < 3; ++c)
        rgba[c] = (1 - f) * a->rgb_linear[c] + f * b->rgb_linear[c];
    rgba[3] = (1 - f) * a->opacity + f * b->opacity;
}

/* Spans the points within the table's range, or the whole range. */
static void span_points(const iso_tf_table *t, bool whole, iso_color_ramp *ramp)
{
    ramp->lo = whole ? t->lo : fmax(t->lo, t->points[0].value);
    ramp->hi = whole ? t->hi : fmin(t->hi, t->points[t->point_count - 1].value);
    if (ramp->hi - ramp->lo > 1e-6 * (t->hi - t->lo))
        return;
    ramp->lo = t->lo;
    ramp->hi = t->hi;
}

static bool take_points(const iso_tf_table *t, bool whole, iso_color_ramp *ramp)
{
    double rgba[4];
    bool fits = t->point_count > 0 && t->unit_mm > 0;
    if (!fits)
        return false;
    span_points(t, whole, ramp);
    if (t->points[0].value != ramp->lo) {
        points_at(t, ramp->lo, false, rgba);
        fits = add_stop(ramp, 0, rgba);
    }
    for (size_t i = 0; i < t->point_count && fits; ++i) {
        const iso_tf_point *p = &t->points[i];
        if (p->value < ramp->lo || p->value > ramp->hi)
            continue;
        fits = add_stop(ramp, place(ramp, p->value),
                        (const double[]){p->rgb_linear[0], p->rgb_linear[1], p->rgb_linear[2], p->opacity});
    }
    if (fits && t->points[t->point_count - 1].value != ramp->hi) {
        points_at(t, ramp->hi, true, rgba);
        fits = add_stop(ramp, 1, rgba);
    }
    if (fits && ramp->count > 1)
        separate(ramp);
    return fits;
}

/* True if the table agrees with the points; a copy may have other entries. An entry at a step may be on either side. */
static bool is_the_table(const iso_tf_table *t, const iso_color_ramp *ramp)
{
    for (size_t i = 0; i < t->count; ++i) {
        const double x = place(ramp, value_of_entry(t, i));
        double want[4], below[4], above[4];
        entry_of(t, i, ramp->unit_mm, want);
        ramp_at(ramp, x - 1e-6, below);
        ramp_at(ramp, x + 1e-6, above);
        below[3] = fmin(below[3], ISO_TF_MAX_OPACITY);
        above[3] = fmin(above[3], ISO_TF_MAX_OPACITY);
        if (!(fmin(larger_difference(want, below), larger_difference(want, above)) <= same))
            return false;
    }
    return true;
}

/* ---- other tables ---- */

/* Finds the entries between which the table changes: outside, a ramp repeats its ends. */
static void trim(const iso_tf_table *t, size_t *first, size_t *last)
{
    const size_t bytes = 4 * sizeof *t->entries;
    *first = 0, *last = t->count - 1;
    while (*first + 1 < *last && memcmp(&t->entries[4 * (*first + 1)], t->entries, bytes) == 0)
        ++*first;
    while (*last > *first + 1 && memcmp(&t->entries[4 * (*last - 1)], &t->entries[4 * (t->count - 1)], bytes) == 0)
        --*last;
}

static bool chord_holds(const iso_tf_table *t, size_t from, size_t to, double unit_mm, double within)
{
    double a[4], b[4], want[4], have[4];
    entry_of(t, from, unit_mm, a);
    entry_of(t, to, unit_mm, b);
    for (size_t i = from + 1; i < to; ++i) {
        const double f = (double)(i - from) / (double)(to - from);
        entry_of(t, i, unit_mm, want);
        for (int c = 0; c < 4; ++c)
            have[c] = (1 - f) * a[c] + f * b[c];
        if (visible_difference(want, have) > within)
            return false;
    }
    return true;
}

static void add_entry(const iso_tf_table *t, size_t entry, iso_color_ramp *ramp)
{
    double rgba[4];
    entry_of(t, entry, ramp->unit_mm, rgba);
    add_stop(ramp, place(ramp, value_of_entry(t, entry)), rgba);
}

/* Places stops at entries, each as far after the previous one as the entries between allow. False: 32 do not
 * suffice. */
static bool chords(const iso_tf_table *t, size_t first, size_t last, double within, iso_color_ramp *ramp)
{
    ramp->count = 0;
    add_entry(t, first, ramp);
    for (size_t at = first; at < last;) {
        size_t next = at + 1;
        while (next < last && chord_holds(t, at, next + 1, ramp->unit_mm, within))
            ++next;
        if (ramp->count == ISO_RAMP_MAX_STOPS)
            return false;
        add_entry(t, next, ramp);
        at = next;
    }
    return true;
}

static void fit_stops(const iso_tf_table *t, bool whole, iso_color_ramp *ramp)
{
    size_t first = 0, last = t->count - 1;
    if (!whole)
        trim(t, &first, &last);
    ramp->lo = value_of_entry(t, first);
    ramp->hi = value_of_entry(t, last);
    for (double within = close_enough; !chords(t, first, last, within, ramp);)
        within *= 1.25;
}

/* ---- loss ---- */

/* Adds an entry's differences to the ramp's losses, for one of the bakings. Returns the visible difference. */
static double measure_entry(const iso_tf_table *t, size_t i, double steps, double max_extinction, iso_color_ramp *ramp)
{
    double want[4], have[4];
    entry_of(t, i, ramp->unit_mm, want);
    baked_at(ramp, steps, place(ramp, value_of_entry(t, i)), have);
    have[3] = fmin(have[3], ISO_TF_MAX_OPACITY);
    for (int c = 0; c < 3 && want[3] >= close_enough; ++c)
        ramp->color_loss = fmax(ramp->color_loss, fabs(want[c] - have[c]));
    ramp->opacity_loss = fmax(ramp->opacity_loss, fabs(want[3] - have[3]));
    const double extinction = fabs(extinction_of(have[3], ramp->unit_mm) - (double)t->entries[4 * i + 3]);
    ramp->extinction_loss = fmax(ramp->extinction_loss, max_extinction > 0 ? extinction / max_extinction : 0);
    return visible_difference(want, have);
}

static void measure(const iso_tf_table *t, double max_extinction, iso_color_ramp *ramp)
{
    double worst = -1;
    size_t off = 0;
    for (size_t i = 0; i < t->count; ++i) {
        double difference = 0;
        for (size_t b = 0; b < sizeof baked_steps / sizeof *baked_steps; ++b)
            difference = fmax(difference, measure_entry(t, i, baked_steps[b], max_extinction, ramp));
        off += difference > 1.0 / 255;
        if (difference > worst) {
            worst = difference;
            ramp->worst_value = value_of_entry(t, i);
        }
    }
    ramp->off = (double)off / (double)t->count;
}

static iso_color_ramp make_ramp(const iso_tf_table *t, bool whole)
{
    double max_extinction = 0;
    iso_color_ramp ramp = {0};
    for (size_t i = 0; i < t->count; ++i)
        max_extinction = fmax(max_extinction, (double)t->entries[4 * i + 3]);
    /* Without a length: one of which the most opaque entry passes a tenth of the light. */
    ramp.unit_mm = t->unit_mm > 0 ? t->unit_mm : max_extinction > 0 ? log(10) / max_extinction : 1;
    ramp.own_points = take_points(t, whole, &ramp) && is_the_table(t, &ramp);
    if (!ramp.own_points)
        fit_stops(t, whole, &ramp);
    measure(t, max_extinction, &ramp);
    return ramp;
}

/* Tries both spans. A short one has finer baked entries; those of the whole range may coincide with the table's. */
void iso_color_ramp_fit(const iso_tf_table *t, iso_color_ramp *ramp)
{
    const iso_color_ramp whole = make_ramp(t, true);
    *ramp = make_ramp(t, false);
    if (fmax(whole.color_loss, whole.opacity_loss) < 0.9 * fmax(ramp->color_loss, ramp->opacity_loss) &&
        whole.own_points == ramp->own_points)
        *ramp = whole;
}
