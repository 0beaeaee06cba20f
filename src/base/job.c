/* SPDX-License-Identifier: MIT */
#include "base/job.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_KINDS = 64, NAME_BYTES = 96 };

/* A lane keeps about so many cores busy: renderers use several threads, and start with one. */
static const double CORES_OF_A_LANE = 2;
/* What is known of a kind counts as so many parts of the usual pace, and of all kinds together as so many. */
static const double PRIOR_PARTS = 0.5, PRIOR_PARTS_OF_ALL = 1;
/* A part that takes longer than foreseen is taken to go on for this part of what it took. */
static const double OVERRUN_PART = 0.2;
/* Time left is shown when so much of the job is done, and so many seconds passed. */
static const double KNOWN_FRACTION = 0.02, KNOWN_SECONDS = 4;
/* The time that is shown leans towards the one that is played within this part of the time that passed. */
static const double LEAN_PART = 0.08, LEAN_LEAST_SECONDS = 1, LEAN_MOST_SECONDS = 20;
/* What is shown as the whole changes at most by this factor from one look to the next, and by this power of the time that
 * passed: by a quarter while the job gets a tenth older. */
static const double MOST_CHANGE = 1.1, MOST_POWER = 2.3;

typedef enum part_state { PART_WAITS, PART_RUNS, PART_OVER, PART_DROPPED } part_state;

typedef struct part {
    char name[NAME_BYTES];
    size_t kind;
    double cost;
    double own_seconds;            /* what it took, had it been alone */
    double fraction, told_seconds; /* the last that was told, and own_seconds then. NAN: not told */
    double began;
    bool shortened; /* nothing is learned from it */
    part_state state;
} part;

typedef struct lane {
    size_t first, count, current; /* parts; current == count: over */
    bool runs;
    double left_seconds; /* while the rest is played */
} lane;

typedef struct phase {
    char name[NAME_BYTES];
    size_t first, count, workers;
    bool over;
} phase;

typedef struct kind {
    char name[NAME_BYTES];
    double cost, own_seconds; /* of what is over, and of what took longer than foreseen */
    double all_cost;
    size_t count;
} kind;

struct iso_job {
    int cores;
    part *parts;
    lane *lanes;
    phase *phases;
    size_t part_count, lane_count, phase_count, part_room, lane_room, phase_room;
    kind kinds[MOST_KINDS];
    size_t kind_count;
    size_t phase; /* the one that runs; phase_count: none */
    bool began, over;
    double start, last, deadline; /* INFINITY: none */
    double fraction, left_seconds, left_at;
    struct told_whole {
        double passed, whole;
    } told[256]; /* what was shown, evenly over the time that passed */
    size_t told_count;
    double told_gap;
};

/* ---- the layout ---------------------------------------------------------------------------- */

iso_job *iso_job_create(int cores)
{
    iso_job *job = calloc(1, sizeof *job);
    if (!job)
        return NULL;
    job->cores = cores > 0 ? cores : 1;
    job->deadline = INFINITY;
    job->left_seconds = NAN;
    return job;
}

void iso_job_destroy(iso_job *job)
{
    if (!job)
        return;
    free(job->parts);
    free(job->lanes);
    free(job->phases);
    free(job);
}

/* Room for one more. Without memory the layout ends here: an estimate is no reason to stop a job. */
static bool grow(void **items, size_t size, size_t count, size_t *room)
{
    if (count < *room)
        return true;
    const size_t wanted = *room ? 2 * *room : 16;
    void *more = realloc(*items, wanted * size);
    if (!more)
        return false;
    *items = more;
    *room = wanted;
    return true;
}

void iso_job_add_phase(iso_job *job, const char *name, size_t workers)
{
    if (!grow((void **)&job->phases, sizeof *job->phases, job->phase_count, &job->phase_room))
        return;
    phase *p = &job->phases[job->phase_count++];
    *p = (phase){.first = job->lane_count, .workers = workers > 0 ? workers : 1};
    snprintf(p->name, sizeof p->name, "%s", name);
}

void iso_job_add_lane(iso_job *job)
{
    if (job->phase_count == 0)
        iso_job_add_phase(job, "", 1);
    if (job->phase_count == 0 || !grow((void **)&job->lanes, sizeof *job->lanes, job->lane_count, &job->lane_room))
        return;
    job->lanes[job->lane_count++] = (lane){.first = job->part_count};
    job->phases[job->phase_count - 1].count++;
}

static size_t find_kind(iso_job *job, const char *name)
{
    size_t i = 0;
    while (i < job->kind_count && strcmp(job->kinds[i].name, name) != 0)
        ++i;
    if (i == job->kind_count && i < MOST_KINDS) {
        snprintf(job->kinds[i].name, sizeof job->kinds[i].name, "%s", name);
        job->kind_count++;
    }
    return i < MOST_KINDS ? i : MOST_KINDS - 1;
}

void iso_job_add_part(iso_job *job, const char *name, const char *kind_name, double cost_seconds)
{
    if (job->phase_count == 0 || job->phases[job->phase_count - 1].count == 0)
        iso_job_add_lane(job);
    if (job->lane_count == 0 || !grow((void **)&job->parts, sizeof *job->parts, job->part_count, &job->part_room))
        return;
    part *p = &job->parts[job->part_count++];
    *p = (part){.cost = fmax(cost_seconds, 1e-6), .fraction = NAN};
    snprintf(p->name, sizeof p->name, "%s", name);
    p->kind = find_kind(job, kind_name);
    job->kinds[p->kind].all_cost += p->cost;
    job->kinds[p->kind].count++;
    job->lanes[job->lane_count - 1].count++;
}

static bool is_named(const part *p, const char *name, bool of_variants)
{
    const size_t all = strlen(p->name), end = strlen(name);
    return of_variants ? all > end && strcmp(p->name + all - end, name) == 0 : strcmp(p->name, name) == 0;
}

void iso_job_foresee(iso_job *job, const char *name, bool of_variants, double cost_seconds)
{
    for (size_t i = 0; i < job->part_count; ++i) {
        part *p = &job->parts[i];
        if (p->state == PART_OVER || p->state == PART_DROPPED || !is_named(p, name, of_variants))
            continue;
        job->kinds[p->kind].all_cost += fmax(cost_seconds, 1e-6) - p->cost;
        p->cost = fmax(cost_seconds, 1e-6);
    }
}

void iso_job_set_deadline(iso_job *job, double now, double seconds)
{
    job->deadline = now + seconds;
}

bool iso_job_has_parts(const iso_job *job)
{
    return job->part_count > 0;
}

bool iso_job_is_done(const iso_job *job)
{
    for (size_t i = 0; i < job->part_count; ++i)
        if (job->parts[i].state == PART_WAITS || (job->parts[i].state == PART_RUNS && !(job->parts[i].fraction >= 1)))
            return false;
    return true;
}

/* ---- paces --------------------------------------------------------------------------------- */

static double slowdown(const iso_job *job, size_t lanes_that_run)
{
    const double cores = job->cores, wanted = fmin(CORES_OF_A_LANE, cores) * (double)lanes_that_run;
    return fmax(1, wanted / cores);
}

/* Seconds that a unit of cost takes. */
static double pace_of_all(const iso_job *job)
{
    double cost = 0, own = 0, all_cost = 0, count = 0;
    for (size_t i = 0; i < job->kind_count; ++i) {
        const kind *k = &job->kinds[i];
        cost += k->cost, own += k->own_seconds, all_cost += k->all_cost, count += (double)k->count;
    }
    const double prior = PRIOR_PARTS_OF_ALL * all_cost / fmax(count, 1);
    return (prior + own) / (prior + cost);
}

static bool are_related(const kind *a, const kind *b)
{
    const char *end = strchr(a->name, '/');
    return end && strncmp(a->name, b->name, (size_t)(end - a->name) + 1) == 0;
}

static double pace_of(const iso_job *job, size_t i, double all)
{
    const kind *k = &job->kinds[i];
    const double prior = PRIOR_PARTS * k->all_cost / fmax((double)k->count, 1);
    double cost = 0, own = 0;
    for (size_t r = 0; r < job->kind_count; ++r)
        if (are_related(k, &job->kinds[r]))
            cost += job->kinds[r].cost, own += job->kinds[r].own_seconds;
    const double of_relatives = (prior * all + own) / (prior + cost);
    return (prior * of_relatives + k->own_seconds) / (prior + k->cost);
}

/* ---- the clock ----------------------------------------------------------------------------- */

static phase *running_phase(const iso_job *job)
{
    return job->phase < job->phase_count && !job->over ? &job->phases[job->phase] : NULL;
}

static part *running_part(const iso_job *job, const lane *l)
{
    return l->runs && l->current < l->count ? &job->parts[l->first + l->current] : NULL;
}

static void let_pass(iso_job *job, double now)
{
    const phase *p = running_phase(job);
    if (!job->began)
        job->began = true, job->start = job->last = now;
    const double seconds = fmax(now - job->last, 0);
    job->last = fmax(job->last, now);
    size_t running = 0;
    for (size_t i = 0; p && i < p->count; ++i)
        running += running_part(job, &job->lanes[p->first + i]) != NULL;
    for (size_t i = 0; p && i < p->count; ++i) {
        part *one = running_part(job, &job->lanes[p->first + i]);
        if (one)
            one->own_seconds += seconds / slowdown(job, running);
    }
}

/* ---- parts begin and end ------------------------------------------------------------------- */

static void end_part(iso_job *job, part *p)
{
    if (p->state == PART_RUNS) {
        p->state = PART_OVER;
        if (p->shortened)
            return;
        job->kinds[p->kind].cost += p->cost;
        job->kinds[p->kind].own_seconds += p->own_seconds;
    } else if (p->state == PART_WAITS) {
        p->state = PART_DROPPED; /* it was not needed, and says nothing of its kind */
    }
}

/* Parts before `current` are over. */
static void go_to(iso_job *job, lane *l, size_t current)
{
    for (; l->current < current; l->current++)
        end_part(job, &job->parts[l->first + l->current]);
}

static void end_phase(iso_job *job, phase *p)
{
    for (size_t i = 0; i < p->count; ++i) {
        go_to(job, &job->lanes[p->first + i], job->lanes[p->first + i].count);
        job->lanes[p->first + i].runs = false;
    }
    p->over = true;
}

void iso_job_begin_phase(iso_job *job, const char *name, double now)
{
    size_t wanted = job->phase;
    let_pass(job, now);
    while (wanted < job->phase_count && (job->phases[wanted].over || strcmp(job->phases[wanted].name, name) != 0))
        ++wanted;
    if (wanted == job->phase_count)
        return; /* nobody laid it out: it belongs to the one that runs */
    for (size_t i = 0; i < wanted; ++i)
        if (!job->phases[i].over)
            end_phase(job, &job->phases[i]);
    job->phase = wanted;
}

static void begin_part(part *p, double now)
{
    if (p->state != PART_WAITS)
        return;
    p->state = PART_RUNS;
    p->began = now;
}

void iso_job_report(iso_job *job, size_t number, const char *name, double fraction, double now)
{
    let_pass(job, now);
    phase *p = running_phase(job);
    if (!p || number >= p->count)
        return;
    lane *l = &job->lanes[p->first + number];
    size_t found = l->current;
    while (found < l->count && strcmp(job->parts[l->first + found].name, name) != 0)
        ++found;
    l->runs = true;
    if (found < l->count) {
        go_to(job, l, found);
        part *one = &job->parts[l->first + found];
        begin_part(one, now);
        if (isfinite(fraction) && fraction > 0)
            one->fraction = fmin(fraction, 1), one->told_seconds = one->own_seconds;
    }
}

void iso_job_is_shortened(iso_job *job, size_t number)
{
    const phase *p = running_phase(job);
    part *one = p && number < p->count ? running_part(job, &job->lanes[p->first + number]) : NULL;
    if (one)
        one->shortened = true;
}

void iso_job_end_lane(iso_job *job, size_t number, double now)
{
    let_pass(job, now);
    phase *p = running_phase(job);
    if (!p || number >= p->count)
        return;
    lane *l = &job->lanes[p->first + number];
    go_to(job, l, l->count);
    l->runs = false;
}

void iso_job_end(iso_job *job, double now)
{
    let_pass(job, now);
    for (size_t i = 0; i < job->phase_count; ++i)
        end_phase(job, &job->phases[i]);
    job->over = true;
}

/* ---- the rest, played forward --------------------------------------------------------------- */

/* From a fifth on a part's own pace is believed, before that more and more of it. */
static double belief_in(const part *p)
{
    return isnan(p->fraction) ? 0 : fmin(5 * p->fraction, 1);
}

/* Seconds of its own that a part needs yet. */
static double left_of_part(const part *p, double pace)
{
    const double foreseen = p->cost * pace;
    if (p->state == PART_WAITS)
        return foreseen;
    if (p->state != PART_RUNS)
        return 0;
    const double by_cost = fmax(foreseen - p->own_seconds, OVERRUN_PART * p->own_seconds);
    if (isnan(p->fraction))
        return by_cost;
    const double by_fraction = fmax(p->told_seconds / p->fraction - p->own_seconds,
                                    OVERRUN_PART * (p->own_seconds - p->told_seconds)),
                 belief = belief_in(p);
    return belief * by_fraction + (1 - belief) * by_cost;
}

/* What tells how far it is, or took longer than foreseen, says so before it ends. */
static void learn_from_running(const iso_job *job, iso_job *with)
{
    const double all = pace_of_all(job);
    for (size_t i = 0; i < job->part_count; ++i) {
        const part *p = &job->parts[i];
        kind *k = &with->kinds[p->kind];
        if (p->state != PART_RUNS || p->shortened)
            continue;
        if (!isnan(p->fraction))
            k->cost += belief_in(p) * p->fraction * p->cost, k->own_seconds += belief_in(p) * p->told_seconds;
        else if (p->own_seconds > p->cost * pace_of(job, p->kind, all))
            k->cost += p->cost, k->own_seconds += p->own_seconds;
    }
}

static void sum_up_lanes(iso_job *job)
{
    const double all = pace_of_all(job);
    for (size_t i = 0; i < job->lane_count; ++i) {
        lane *l = &job->lanes[i];
        l->left_seconds = 0;
        for (size_t k = 0; k < l->count; ++k) {
            const part *p = &job->parts[l->first + k];
            l->left_seconds += left_of_part(p, pace_of(job, p->kind, all));
        }
    }
}

/* As many lanes as there are workers, in their order; those that run already first. */
static double play(const iso_job *job, const phase *p)
{
    double seconds = 0;
    for (;;) {
        size_t running = 0;
        double least = INFINITY;
        for (size_t i = 0; i < p->count && running < p->workers; ++i)
            if (job->lanes[p->first + i].left_seconds > 0)
                ++running, least = fmin(least, job->lanes[p->first + i].left_seconds);
        if (running == 0)
            return seconds;
        seconds += least * slowdown(job, running);
        size_t taken = 0;
        for (size_t i = 0; i < p->count && taken < running; ++i) {
            lane *l = &job->lanes[p->first + i];
            if (l->left_seconds > 0)
                ++taken, l->left_seconds = l->left_seconds - least > 1e-9 ? l->left_seconds - least : 0;
        }
    }
}

static double play_rest(const iso_job *job)
{
    iso_job played = *job; /* the arrays are shared, and lanes' left_seconds are for this alone */
    double seconds = 0;
    learn_from_running(job, &played);
    sum_up_lanes(&played);
    for (size_t i = 0; i < job->phase_count; ++i)
        if (!job->phases[i].over)
            seconds += play(&played, &job->phases[i]);
    return seconds;
}

/* ---- what is shown -------------------------------------------------------------------------- */

static const char *latest_part(const iso_job *job)
{
    const phase *p = running_phase(job);
    const part *latest = NULL;
    for (size_t i = 0; p && i < p->count; ++i) {
        const part *one = running_part(job, &job->lanes[p->first + i]);
        if (one && one->state == PART_RUNS && (!latest || one->began >= latest->began))
            latest = one;
    }
    return latest ? latest->name : "";
}

/* Down with the clock, and towards what was played: the farther the longer the job runs. */
static void smooth(iso_job *job, double played, double now, bool known)
{
    const double passed = now - job->start, since = now - job->left_at;
    if (!known)
        return;
    if (isnan(job->left_seconds)) {
        job->left_seconds = played;
    } else {
        const double lean_seconds = fmin(fmax(LEAN_PART * passed, LEAN_LEAST_SECONDS), LEAN_MOST_SECONDS);
        const double down = fmax(job->left_seconds - since, 0),
                     change = fmin(MOST_CHANGE, exp(MOST_POWER * since / passed));
        const double wanted = passed + down + (played - down) * (1 - exp(-since / lean_seconds));
        const double whole = fmin(fmax(wanted, (passed + down) / change), (passed + down) * change);
        job->left_seconds = fmax(whole - passed, 0);
    }
    job->left_at = now;
}

/* When there is no more room every other one is forgotten, and half as many are kept from then on. */
static void note_told(iso_job *job, double passed)
{
    const size_t room = sizeof job->told / sizeof *job->told;
    if (isnan(job->left_seconds) || (job->told_count && passed < job->told[job->told_count - 1].passed + job->told_gap))
        return;
    if (job->told_count == room) {
        for (size_t i = 0; i < room / 2; ++i)
            job->told[i] = job->told[2 * i];
        job->told_count = room / 2;
        job->told_gap = 2 * fmax(job->told_gap, passed / (double)room);
    }
    job->told[job->told_count++] = (struct told_whole){passed, passed + job->left_seconds};
}

iso_job_state iso_job_look(iso_job *job, double now)
{
    let_pass(job, now);
    now = job->last;
    const double passed = now - job->start;
    iso_job_state state = {.part = latest_part(job), .passed_seconds = passed, .left_seconds = NAN};
    if (job->over) {
        state.fraction = 1;
        state.left_seconds = 0;
        return state;
    }
    if (job->part_count == 0)
        return state;
    const double played = fmin(play_rest(job), fmax(job->deadline - now, 0));
    smooth(job, played, now,
           !isnan(job->left_seconds) || (passed >= KNOWN_SECONDS && passed >= KNOWN_FRACTION * (passed + played)));
    /* Of what is shown as left, so that the two agree. */
    const double left = isnan(job->left_seconds) ? played : job->left_seconds;
    /* All but the last per mille: whether it is over is not for an estimate to say. */
    job->fraction = fmin(fmax(job->fraction, passed + left > 0 ? passed / (passed + left) : 0), 0.999);
    state.fraction = job->fraction;
    state.left_seconds = job->left_seconds;
    note_told(job, passed);
    return state;
}

iso_job_estimate iso_job_judge(const iso_job *job, double now)
{
    const double seconds = job->began ? now - job->start : 0;
    iso_job_estimate e = {.seconds = seconds, .first = job->told_count ? job->told[0].whole : NAN, .worst = NAN};
    for (size_t i = 0; i < job->told_count; ++i) {
        const double off = fabs(job->told[i].whole / seconds - 1);
        if (job->told[i].passed < seconds / 3)
            continue;
        e.worst = e.looks == 0 ? off : fmax(e.worst, off);
        ++e.looks;
    }
    return e;
}

size_t iso_job_part_count(const iso_job *job)
{
    return job->part_count;
}

iso_job_part iso_job_part_at(const iso_job *job, size_t i)
{
    const part *p = &job->parts[i];
    const char *of = "";
    for (size_t k = 0; k < job->phase_count; ++k) {
        const lane *first = job->phases[k].count ? &job->lanes[job->phases[k].first] : NULL;
        if (first && first->first <= i)
            of = job->phases[k].name;
    }
    return (iso_job_part){of, p->name, job->kinds[p->kind].name, p->cost, p->own_seconds};
}
