/* SPDX-License-Identifier: MIT */
#include "chart/order.h"

#include <math.h>

/* Halving the step quarters its error. If more than this part remains, the error is the level's own. */
static const double FLOOR_PART = 0.85;

static bool is_sibling(const iso_chart_case *a, const iso_chart_case *b)
{
    return a->scene == b->scene && a->renderer == b->renderer && a->level == b->level && a->estimator == b->estimator &&
           a->filter == b->filter && a->source == b->source && a->code == b->code && a->palette == b->palette &&
           a->adapted == b->adapted && a->second == b->second && a->preintegrated == b->preintegrated &&
           a->plan_error == b->plan_error;
}

/* The two finest measured steps of the same setting that are coarser than its own. */
typedef struct coarser_steps {
    const iso_chart_case *fine, *coarse; /* or NULL */
} coarser_steps;

static coarser_steps find_coarser(const iso_chart_case *cases, size_t count, const iso_chart_case *c)
{
    coarser_steps s = {NULL, NULL};
    for (size_t i = 0; i < count; ++i) {
        const iso_chart_case *o = &cases[i];
        if (!o->done || !(o->step_voxels > c->step_voxels) || !is_sibling(o, c))
            continue;
        if (!s.fine || o->step_voxels < s.fine->step_voxels) {
            s.coarse = s.fine;
            s.fine = o;
        } else if (!s.coarse || o->step_voxels < s.coarse->step_voxels) {
            s.coarse = o;
        }
    }
    return s;
}

/* Returns a lower bound of the error at finer steps: extrapolates e = f + a h^2 through two steps. */
static double floor_of(const coarser_steps *s, const iso_chart_outlook *o)
{
    if (!s->coarse)
        return 0;
    const double fine = o->error(o->user, s->fine), coarse = o->error(o->user, s->coarse);
    const double h = s->fine->step_voxels / s->coarse->step_voxels;
    return fmax((fine - h * h * coarse) / (1 - h * h), 0);
}

/* True if the setting is as likely as not to lie on a front. */
static bool chart_matters(const iso_chart_case *cases, size_t count, const iso_chart_case *c,
                          const iso_chart_outlook *o)
{
    const coarser_steps s = find_coarser(cases, count, c);
    if (!s.coarse)
        return true;
    const double floor_error = floor_of(&s, o), seconds = o->frame_seconds(o->user, c);
    if (floor_error > FLOOR_PART * o->error(o->user, s.fine))
        return false;
    for (size_t i = 0; i < count; ++i)
        if (cases[i].done && cases[i].scene == c->scene && cases[i].took.seconds <= seconds &&
            o->error(o->user, &cases[i]) <= floor_error)
            return false;
    return true;
}

size_t iso_chart_next(iso_chart_case *cases, size_t count, const iso_chart_outlook *o)
{
    size_t other = count;
    for (size_t i = 0; i < count; ++i) {
        iso_chart_case *c = &cases[i];
        if (c->done || !o->is_open(o->user, c))
            continue;
        c->put_off = c->put_off || !chart_matters(cases, count, c, o);
        if (!c->put_off)
            return i;
        other = other == count ? i : other;
    }
    return other;
}
