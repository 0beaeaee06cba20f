/* SPDX-License-Identifier: MIT */
#include "base/parallel.h"

#include <omp.h>
#include <sys/resource.h>
#include <time.h>

int iso_threads(int wanted)
{
    return wanted > 0 ? wanted : omp_get_max_threads();
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
