/* SPDX-License-Identifier: MIT */
/* ranks.h - the processes of one MPI job, for work that outgrows one machine.
 *
 * The only door to MPI. A program that mpirun did not start is alone: iso_ranks_open() gives NULL, which every function
 * here takes for one rank, and neither loads nor initialises anything. MPI itself stands in a library of its own beside
 * the program, which is loaded when it is needed. Calls come from the thread that opened. When a rank dies, mpirun ends
 * the others. */
#ifndef ISO_RANKS_H
#define ISO_RANKS_H

#include <stddef.h>

#include "base/status.h"

typedef struct iso_ranks iso_ranks;

/* *ranks is NULL when the program is alone. ISO_E_MISSING when mpirun started it and the door cannot be opened. */
iso_status iso_ranks_open(iso_ranks **ranks, iso_error *err);
void iso_ranks_close(iso_ranks *ranks); /* waits for the others; accepts NULL */

int iso_ranks_index(const iso_ranks *ranks); /* from 0 */
int iso_ranks_count(const iso_ranks *ranks);
/* From what mpirun leaves in the environment, so before and without opening: not rank 0. */
int iso_ranks_is_other(void);

/* Waits for all. All get the status and the message of the first rank that failed. */
iso_status iso_ranks_agree(iso_ranks *ranks, iso_status status, iso_error *err);
/* What rank 0 has, to all. */
void iso_ranks_broadcast(iso_ranks *ranks, void *data, size_t bytes);
/* Each value becomes the largest of all ranks' values. */
void iso_ranks_largest(iso_ranks *ranks, double *values, size_t count);
/* Copies the data and returns; one message at a time to each rank. */
void iso_ranks_send(iso_ranks *ranks, int to, const void *data, size_t bytes);
/* Waits for as many bytes as were sent, at most `bytes`. */
void iso_ranks_receive(iso_ranks *ranks, int from, void *data, size_t bytes);

#endif
