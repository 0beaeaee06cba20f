/* SPDX-License-Identifier: MIT */
/* ranks.h - the processes of one MPI job, for work that outgrows one machine.
 *
 * All calls to MPI go through this header. They are made in isoshade_mpi.so, which lies next to the program and is
 * loaded only if mpirun started the program. Without it iso_ranks_open() gives NULL, and every function here takes
 * NULL for a job of one rank. All calls have to come from the thread that opened. When a rank dies, mpirun ends the
 * others. */
#pragma once

#include <stddef.h>

#include "base/status.h"

typedef struct iso_ranks iso_ranks;

/* Opens the job. *ranks is NULL if mpirun did not start the program. ISO_E_MISSING if it did and isoshade_mpi.so cannot
 * be loaded. */
iso_status iso_ranks_open(iso_ranks **ranks, iso_error *err);
void iso_ranks_close(iso_ranks *ranks); /* waits for the others; accepts NULL */

int iso_ranks_index(const iso_ranks *ranks); /* from 0 */
int iso_ranks_count(const iso_ranks *ranks);
/* True for a rank other than 0. Reads the environment that mpirun sets, so it can be called before iso_ranks_open(). */
int iso_ranks_is_other(void);

/* Place of this process among those that mpirun or srun started, without MPI: for work that shares a folder and
 * survives the death of a rank. */
typedef struct iso_ranks_place {
    int index, count; /* 0 and 1 if nothing started several */
    char job[128];    /* the same for all ranks of a job, another one for the next; may be empty */
} iso_ranks_place;
iso_ranks_place iso_ranks_find_place(void);
/* Returns the name of the variable by which mpirun or srun made this process one of several, or NULL. */
const char *iso_ranks_variable(void);
/* Hides the place from programs that this process starts: each is started once. Call it before threads are started. */
void iso_ranks_hide(void);
/* Runs the work in a child process with a private folder, which is removed afterwards. This process survives its failure
 * or death. Call it before threads are started. Returns the signal that ended the child, or 0. */
int iso_ranks_run_apart(void (*work)(void *user, const char *folder), void *user);

/* Waits for all ranks. All return the status and the message of the first rank that failed. */
iso_status iso_ranks_agree(iso_ranks *ranks, iso_status status, iso_error *err);
/* Copies the data of rank 0 to all ranks. */
void iso_ranks_broadcast(iso_ranks *ranks, void *data, size_t bytes);
/* Replaces each value by the largest of all ranks' values. */
void iso_ranks_largest(iso_ranks *ranks, double *values, size_t count);
/* Copies the data and returns; one message at a time to each rank. */
void iso_ranks_send(iso_ranks *ranks, int to, const void *data, size_t bytes);
/* Waits for a message of at most `bytes` bytes. */
void iso_ranks_receive(iso_ranks *ranks, int from, void *data, size_t bytes);
