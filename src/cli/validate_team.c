/* validate_team.c - independent parts of a validation side by side. */
#include "base/parallel.h"
#include "cli/validate.h"

/* What the workers share; begin() and end() alone touch it. */
typedef struct team {
    const iso_validation *v;
    iso_progress progress; /* for one thread at a time */
    size_t count, workers;
    iso_status status;     /* the first failure: nothing more is begun */
    iso_error error;
} team;

static void report_alone(void *user, const char *stage, double fraction)
{
    const iso_progress *outer = user;
    #pragma omp critical (iso_validate_progress)
    iso_progress_report(outer, stage, fraction);
}

static bool may_begin(const team *t)
{
    bool good;
    #pragma omp critical (iso_validate_team)
    good = t->status == ISO_OK;
    return good;
}

static void end_part(team *t, iso_status status, const iso_error *err)
{
    #pragma omp critical (iso_validate_team)
    if (status != ISO_OK && t->status == ISO_OK)
        t->status = status, t->error = *err;
}

/* A share of the parts, one after the other. A context of OpenGL belongs to a thread, so each has its own. */
static void work(team *t, iso_validation_part part, void *user)
{
    iso_validation mine = *t->v;
    const size_t cores = (size_t)iso_threads(t->v->threads);
    mine.renderers = (iso_renderers){.shader_dir = t->v->renderers.shader_dir};
    /* When one worker is left, its programs are not held to a single core. */
    mine.threads = (int)(4 * cores / t->workers < cores ? 4 * cores / t->workers : cores);
    #pragma omp for schedule(dynamic, 1)
    for (size_t i = 0; i < t->count; ++i) {
        iso_error err = {""};
        mine.order = t->v->order + i;
        mine.progress = &t->progress;
        if (may_begin(t))
            end_part(t, part(&mine, i, user, &err), &err);
    }
    iso_renderers_end(&mine.renderers);
}

static iso_status one_by_one(iso_validation *v, size_t count, iso_validation_part part, void *user, iso_error *err)
{
    const size_t first = v->order;
    const iso_progress *progress = v->progress;
    iso_status status = ISO_OK;
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        v->order = first + i;
        status = part(v, i, user, err);
        v->progress = progress;
    }
    v->order = first + count;
    return status;
}

iso_status iso_validate_each(iso_validation *v, size_t count, iso_validation_part part, void *user, iso_error *err)
{
    enum { most_workers = 16 }; /* each may hold a volume in a program of its own */
    /* POV-Ray sleeps half a second a run, Blender waits for files: twice as many workers as cores. */
    const size_t cores = (size_t)iso_threads(v->threads), wanted = cores > 1 ? 2 * cores : 1;
    const size_t most = wanted < most_workers ? wanted : most_workers;
    team t = {.v = v, .progress = {report_alone, (void *)v->progress}, .count = count,
              .workers = count < most ? count : most};
    if (t.workers < 2 || iso_is_in_parallel())
        return one_by_one(v, count, part, user, err);
    #pragma omp parallel num_threads((int)t.workers)
    work(&t, part, user);
    v->order += count;
    return t.status == ISO_OK ? ISO_OK : iso_fail(err, t.status, "%s", t.error.text);
}
