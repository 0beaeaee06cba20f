/* SPDX-License-Identifier: MIT */
#include "base/work.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

/* Of a program: starts and their processor time. Of a renderer: pictures, their pixels and samples. */
typedef struct row {
    char name[64];
    size_t count;
    double pixels, samples, seconds;
} row;

typedef struct table {
    row rows[ISO_WORK_MOST];
    size_t count;
} table;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static table programs, renderers;

static row *find(table *t, const char *name)
{
    for (size_t i = 0; i < t->count; ++i)
        if (strncmp(t->rows[i].name, name, sizeof t->rows[i].name - 1) == 0)
            return &t->rows[i];
    if (t->count == ISO_WORK_MOST)
        return &t->rows[ISO_WORK_MOST - 1];
    row *r = &t->rows[t->count++];
    *r = (row){.count = 0};
    snprintf(r->name, sizeof r->name, "%s", name);
    return r;
}

static double processor_seconds(int who)
{
    struct rusage u;
    return getrusage(who, &u) != 0 ? 0
                                   : (double)(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
                                         1e-6 * (double)(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

void iso_work_add_start(const char *program)
{
    pthread_mutex_lock(&lock);
    ++find(&programs, program)->count;
    pthread_mutex_unlock(&lock);
}

void iso_work_add_end(const char *program, double seconds)
{
    pthread_mutex_lock(&lock);
    find(&programs, program)->seconds += seconds;
    pthread_mutex_unlock(&lock);
}

void iso_work_add_picture(const char *renderer, double pixels, double samples)
{
    pthread_mutex_lock(&lock);
    row *r = find(&renderers, renderer);
    ++r->count;
    r->pixels += pixels;
    r->samples += samples;
    pthread_mutex_unlock(&lock);
}

iso_work_total iso_work_sum(void)
{
    iso_work_total t = {.processor_seconds = 0};
    pthread_mutex_lock(&lock);
    for (size_t i = 0; i < programs.count; ++i)
        t.starts += programs.rows[i].count;
    for (size_t i = 0; i < renderers.count; ++i) {
        t.pictures += renderers.rows[i].count;
        t.pixels += renderers.rows[i].pixels;
        t.samples += renderers.rows[i].samples;
    }
    t.processor_seconds = processor_seconds(RUSAGE_SELF) + processor_seconds(RUSAGE_CHILDREN);
    pthread_mutex_unlock(&lock);
    return t;
}

json_t *iso_work_to_json(void)
{
    const iso_work_total t = iso_work_sum();
    json_t *o = json_pack("{s:I, s:I, s:f, s:f, s:f, s:{}, s:{}}", "program_starts", (json_int_t)t.starts, "pictures",
                          (json_int_t)t.pictures, "pixels", t.pixels, "pixel_steps", t.samples, "processor_seconds",
                          t.processor_seconds, "programs", "renderers");
    pthread_mutex_lock(&lock);
    for (size_t i = 0; i < programs.count; ++i) {
        const row *r = &programs.rows[i];
        json_object_set_new(json_object_get(o, "programs"), r->name,
                            json_pack("{s:I, s:f}", "starts", (json_int_t)r->count, "processor_seconds", r->seconds));
    }
    for (size_t i = 0; i < renderers.count; ++i) {
        const row *r = &renderers.rows[i];
        json_object_set_new(json_object_get(o, "renderers"), r->name,
                            json_pack("{s:I, s:f, s:f}", "pictures", (json_int_t)r->count, "pixels", r->pixels,
                                      "pixel_steps", r->samples));
    }
    pthread_mutex_unlock(&lock);
    return o;
}
