/* SPDX-License-Identifier: MIT */
/* reduce.c - reduction of a table to the few nodes that other programs store. */
#include <math.h>
#include <stdlib.h>

#include "tf/curves.h"

typedef struct sampled {
    size_t count;
    double lo, hi;
    double (*rgba)[4]; /* display color and opacity */
    bool *kept;
} sampled;

static double place(const sampled *s, size_t i)
{
    return s->lo + (s->hi - s->lo) * (double)i / (double)(s->count - 1);
}

/* Returns the distance of place i from the line between places a and b, in channels first to last. */
static double away(const sampled *s, size_t a, size_t b, size_t i, int first, int last)
{
    const double t = (double)(i - a) / (double)(b - a);
    double most = 0;
    for (int c = first; c <= last; ++c)
        most = fmax(most, fabs((1 - t) * s->rgba[a][c] + t * s->rgba[b][c] - s->rgba[i][c]));
    return most;
}

/* Keeps the farthest place between a and b if it is farther than `most`, then splits both halves [douglas-1973]. */
static void split(const sampled *s, size_t a, size_t b, int first, int last, double most)
{
    size_t farthest = a;
    double distance = most;
    for (size_t i = a + 1; i < b; ++i) {
        const double d = away(s, a, b, i, first, last);
        if (d > distance)
            distance = d, farthest = i;
    }
    if (farthest == a)
        return;
    s->kept[farthest] = true;
    split(s, a, farthest, first, last, most);
    split(s, farthest, b, first, last, most);
}

static void choose(const sampled *s, int first, int last, double most)
{
    for (size_t i = 0; i < s->count; ++i)
        s->kept[i] = i == 0 || i + 1 == s->count;
    split(s, 0, s->count - 1, first, last, most);
}

static iso_status take(const sampled *s, bool color, iso_tf_curve *curve, iso_error *err)
{
    for (size_t i = 0; i < s->count; ++i)
        if (s->kept[i])
            NEED(color ? iso_tf_curve_add_color(curve, place(s, i), s->rgba[i], "a table", err)
                       : iso_tf_curve_add_opacity(curve, place(s, i), s->rgba[i][3], "a table", err));
    return ISO_OK;
}

iso_status iso_tf_reduce(const iso_tf_table *table, double unit_mm, size_t grid, double most, iso_tf_curves *curves,
                         iso_error *err)
{
    const size_t count = grid ? grid : table->count;
    FREED double(*rgba)[4] = malloc(count * sizeof *rgba);
    FREED bool *kept = malloc(count * sizeof *kept);
    const sampled s = {count, table->lo, table->hi, rgba, kept};
    *curves = (iso_tf_curves){.unit_mm = unit_mm};
    NEED_MEMORY(rgba && kept, err, "no memory for %zu entries", count);
    for (size_t i = 0; i < count; ++i) {
        double found[4];
        iso_tf_lookup(table, place(&s, i), found);
        for (int c = 0; c < 3; ++c)
            s.rgba[i][c] = fmin(fmax(iso_linear_to_srgb(found[c]), 0), 1);
        s.rgba[i][3] = -expm1(-found[3] * unit_mm);
    }
    choose(&s, 0, grid ? 3 : 2, most); /* on a grid both curves share the nodes */
    NEED(take(&s, true, &curves->color, err));
    if (!grid)
        choose(&s, 3, 3, most / 16); /* small opacities add up along long rays */
    return take(&s, false, &curves->opacity, err);
}
