/* SPDX-License-Identifier: MIT */
/* parallel.h - threads by OpenMP. Loops begin with
 *     #pragma omp parallel for schedule(static) num_threads(iso_threads(opt->threads))
 * and give results that do not depend on the number. */
#pragma once

#include <stdbool.h>

/* Returns the number of threads: `wanted`, or as many as OpenMP offers (all cores, or OMP_NUM_THREADS) if it is 0.
 * Returns 1 in the thread of a forked child whose parent had several threads: they are not there. */
int iso_threads(int wanted);

/* Returns the number of the calling thread within its parallel region, from 0. */
int iso_thread_index(void);

/* True if the calling thread is one of several already: loops that it begins have one thread. */
bool iso_is_in_parallel(void);

/* Returns wall clock time in seconds, for benchmarks and reports. */
double iso_clock_seconds(void);

/* Returns the processor time of this process, summed over its threads, in seconds. */
double iso_cpu_seconds(void);

/* Returns the peak resident memory of this process in bytes. */
double iso_peak_rss_bytes(void);
