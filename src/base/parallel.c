/* SPDX-License-Identifier: MIT */
#include "base/parallel.h"

#include <omp.h>
#include <pthread.h>
#include <sys/resource.h>
#include <time.h>

/* OpenMP keeps threads for each thread that begins a parallel loop. A forked child has only the thread that forked,
 * which would wait for the others forever. */
static _Thread_local bool has_team, lost_team;
static pthread_once_t watches_forks = PTHREAD_ONCE_INIT;

static void note_fork(void)
{
    lost_team = has_team;
}

static void watch_forks(void)
{
    pthread_atfork(NULL, NULL, note_fork);
}

int iso_threads(int wanted)
{
    const int count = wanted > 0 ? wanted : omp_get_max_threads();
    if (lost_team)
        return 1;
    if (count > 1 && !has_team) {
        pthread_once(&watches_forks, watch_forks);
        has_team = true;
    }
    return count;
}

int iso_thread_index(void)
{
    return omp_get_thread_num();
}

bool iso_is_in_parallel(void)
{
    return omp_in_parallel();
}

double iso_clock_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double iso_cpu_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double iso_peak_rss_bytes(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return 1024.0 * (double)usage.ru_maxrss;
}
