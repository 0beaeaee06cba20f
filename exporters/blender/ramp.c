/* SPDX-License-Identifier: MIT */
/* ramp.c - a table of thousands of entries in 32 stops, and what that loses. */
#include <math.h>
#include <string.h>

#include "blender/blender.h"

#define BAKED 256 /* Cycles evaluates a ramp at i / 255 and interpolates */

static void table_entry(const iso_tf_table *t, size_t i, double max_extinction, double rgba[4])
{
    for (int c = 0; c < 4; ++c)
        rgba[c] = (double)t->entries[4 * i + (size_t)c];
    rgba[3] = max_extinction > 0 ? rgba[3] / max_extinction : 0;
}

static void ramp_at(const iso_color_ramp *ramp, double x, double rgba[4])
{
    size_t i = 0;
    while (i + 2 < ramp->count && ramp->position[i + 1] <= x)
        ++i;
    if (ramp->count == 1) {
        memcpy(rgba, ramp->rgba[0], 4 * sizeof *rgba);
        return;
    }
    double f = (x - ramp->position[i]) / (ramp->position[i + 1] - ramp->position[i]);
    f = f > 0 ? (f < 1 ? f : 1) : 0;
    for (int c = 0; c < 4; ++c)
        rgba[c] = (1 - f) * ramp->rgba[i][c] + f * ramp->rgba[i + 1][c];
}

static void baked_at(const iso_color_ramp *ramp, double x, double rgba[4])
{
    double at = x * (BAKED - 1), whole = floor(at), f = at - whole, next[4];
    ramp_at(ramp, whole / (BAKED - 1), rgba);
    ramp_at(ramp, fmin(whole + 1, BAKED - 1) / (BAKED - 1), next);
    for (int c = 0; c < 4; ++c)
        rgba[c] = (1 - f) * rgba[c] + f * next[c];
}

/* The entry that the ramp misses most, by how much. */
static size_t worst_entry(const iso_tf_table *t, const iso_color_ramp *ramp, double *worst)
{
    size_t where = 0;
    *worst = 0;
    for (size_t i = 0; i < t->count; ++i) {
        double want[4], have[4];
        table_entry(t, i, ramp->max_extinction, want);
        ramp_at(ramp, (double)i / (double)(t->count - 1), have);
        for (int c = 0; c < 4; ++c)
            if (fabs(want[c] - have[c]) > *worst) {
                *worst = fabs(want[c] - have[c]);
                where = i;
            }
    }
    return where;
}

static void add_stop(const iso_tf_table *t, size_t entry, iso_color_ramp *ramp)
{
    double x = (double)entry / (double)(t->count - 1);
    size_t i = ramp->count++;
    for (; i > 0 && ramp->position[i - 1] > x; --i) {
        ramp->position[i] = ramp->position[i - 1];
        memcpy(ramp->rgba[i], ramp->rgba[i - 1], sizeof ramp->rgba[i]);
    }
    ramp->position[i] = x;
    table_entry(t, entry, ramp->max_extinction, ramp->rgba[i]);
}

/* Stops are added where the ramp is worst until it is exact (to a float's rounding) or full. */
void iso_color_ramp_fit(const iso_tf_table *t, iso_color_ramp *ramp)
{
    *ramp = (iso_color_ramp){0};
    for (size_t i = 0; i < t->count; ++i)
        ramp->max_extinction = fmax(ramp->max_extinction, (double)t->entries[4 * i + 3]);
    add_stop(t, 0, ramp);
    add_stop(t, t->count - 1, ramp);
    double worst;
    for (size_t i; i = worst_entry(t, ramp, &worst), worst > 2e-7 && ramp->count < ISO_RAMP_MAX_STOPS;)
        add_stop(t, i, ramp);
    for (size_t i = 0; i < t->count; ++i) {
        double want[4], have[4];
        table_entry(t, i, ramp->max_extinction, want);
        baked_at(ramp, (double)i / (double)(t->count - 1), have);
        for (int c = 0; c < 3; ++c)
            ramp->color_loss = fmax(ramp->color_loss, fabs(want[c] - have[c]));
        ramp->alpha_loss = fmax(ramp->alpha_loss, fabs(want[3] - have[3]));
    }
}
