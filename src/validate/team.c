/* SPDX-License-Identifier: MIT */
/* team.c - independent parts of a validation side by side. */
#include "base/parallel.h"
#include "renderers/picture_store.h"
#include "validate/validate.h"

/* Data shared by the workers; members that change are accessed in a critical section only. */
typedef struct team {
    size_t count, begin; /* begin: the part to begin with, so that ranks do not draw the same pictures */
    iso_status status;   /* the first failure: nothing more is begun */
    iso_error error;
} team;

static bool may_begin(const team *t)
{
    bool good;
#pragma omp critical(iso_validate_progress)
    good = t->status == ISO_OK;
    return good;
}

static void end_part(team *t, iso_status status, const iso_error *err)
{
#pragma omp critical(iso_validate_progress)
    {
        if (status != ISO_OK && t->status == ISO_OK)
            t->status = status, t->error = *err;
    }
}

static void run_part(team *t, iso_validation *mine, size_t first, size_t i, iso_validation_part part, void *user)
{
    iso_error err = {""};
    mine->order = first + i;
    if (may_begin(t))
        end_part(t, part(mine, i, user, &err), &err);
}

/* Runs a share of the parts, one after the other. A context of OpenGL belongs to a thread, so each has its own. */
static void work(team *t, const iso_validation *v, int threads, iso_validation_part part, void *user)
{
    iso_validation mine = *v;
    mine.renderers = (iso_renderers){.shader_dir = v->renderers.shader_dir, .store = v->renderers.store};
    mine.threads = threads;
#pragma omp for schedule(dynamic, 1)
    for (size_t i = 0; i < t->count; ++i)
        run_part(t, &mine, v->order, (i + t->begin) % t->count, part, user);
    iso_renderers_end(&mine.renderers);
}

size_t iso_validate_workers(const iso_validation *v, size_t count)
{
    enum { most_workers = 16 }; /* each may hold a volume in a program of its own */
    /* POV-Ray sleeps half a second a run, Blender waits for files: twice as many workers as cores. */
    const size_t cores = (size_t)iso_threads(v->threads), wanted = cores > 1 ? 2 * cores : 1;
    const size_t most = wanted < most_workers ? wanted : most_workers;
    return count < most ? count : most;
}

iso_status iso_validate_each(iso_validation *v, size_t count, iso_validation_part part, void *user, iso_error *err)
{
    const size_t cores = (size_t)iso_threads(v->threads), workers = iso_validate_workers(v, count);
    const size_t first = v->order;
    team t = {.count = count, .begin = iso_picture_store_share(v->renderers.store, count).first};
    if (workers > 1 && !iso_is_in_parallel()) {
        /* When one worker is left, its programs are not held to a single core. */
        const int threads = (int)(4 * cores / workers < cores ? 4 * cores / workers : cores);
#pragma omp parallel num_threads((int)workers)
        work(&t, v, threads, part, user);
    } else {
        for (size_t i = 0; i < count; ++i)
            run_part(&t, v, first, (i + t.begin) % count, part, user);
    }
    v->order = first + count;
    return t.status == ISO_OK ? ISO_OK : iso_fail(err, t.status, "%s", t.error.text);
}
