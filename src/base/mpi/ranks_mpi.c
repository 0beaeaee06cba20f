/* SPDX-License-Identifier: MIT */
/* ranks_mpi.c - the calls to MPI, a library of its own (base/ranks.h): linked with MPI, which the program is not. MPI's
 * own handler ends the job on an error. */
#define _POSIX_C_SOURCE 200809L
#include <mpi.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/ranks_interface.h"

/* The messages in flight to each rank. */
typedef struct sending {
    MPI_Request request;
    void *copy;
} sending;

static sending *under_way;

static void mpi_open(int *index, int *count)
{
    int provided;
    MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, index);
    MPI_Comm_size(MPI_COMM_WORLD, count);
    under_way = calloc((size_t)*count, sizeof *under_way);
    if (!under_way)
        MPI_Abort(MPI_COMM_WORLD, 6);
}

/* Sleeps while it waits: MPI's own waiting takes a whole core, on which the neighboring ranks may be computing. */
static void wait_asleep(MPI_Request *request)
{
    const struct timespec pause = {.tv_nsec = 200000};
    for (int done = 0; MPI_Test(request, &done, MPI_STATUS_IGNORE), !done;)
        nanosleep(&pause, NULL);
}

static void finish_sending(sending *s)
{
    if (s->copy)
        wait_asleep(&s->request);
    free(s->copy);
    s->copy = NULL;
}

static void mpi_close(void)
{
    int count;
    MPI_Comm_size(MPI_COMM_WORLD, &count);
    for (int i = 0; i < count; ++i)
        finish_sending(&under_way[i]);
    free(under_way);
    MPI_Finalize();
}

static void mpi_gather(const void *data, size_t bytes, void *all)
{
    MPI_Request request;
    MPI_Iallgather(data, (int)bytes, MPI_BYTE, all, (int)bytes, MPI_BYTE, MPI_COMM_WORLD, &request);
    wait_asleep(&request);
}

static void mpi_broadcast(void *data, size_t bytes)
{
    MPI_Request request;
    MPI_Ibcast(data, (int)bytes, MPI_BYTE, 0, MPI_COMM_WORLD, &request);
    wait_asleep(&request);
}

static void mpi_largest(double *values, size_t count)
{
    MPI_Request request;
    MPI_Iallreduce(MPI_IN_PLACE, values, (int)count, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD, &request);
    wait_asleep(&request);
}

/* Counts are of 64 bytes, as they are of int and messages may be large; senders and receivers pad. */
enum { UNIT = 64 };

static int units(size_t bytes)
{
    return (int)((bytes + UNIT - 1) / UNIT);
}

static MPI_Datatype unit_type(void)
{
    static MPI_Datatype type = MPI_DATATYPE_NULL;
    if (type == MPI_DATATYPE_NULL) {
        MPI_Type_contiguous(UNIT, MPI_BYTE, &type);
        MPI_Type_commit(&type);
    }
    return type;
}

static void mpi_send(int to, const void *data, size_t bytes)
{
    sending *s = &under_way[to];
    finish_sending(s);
    s->copy = calloc((size_t)units(bytes), UNIT);
    if (!s->copy)
        MPI_Abort(MPI_COMM_WORLD, 6);
    memcpy(s->copy, data, bytes);
    MPI_Isend(s->copy, units(bytes), unit_type(), to, 0, MPI_COMM_WORLD, &s->request);
}

static void mpi_receive(int from, void *data, size_t bytes)
{
    char *padded = calloc((size_t)units(bytes), UNIT);
    if (!padded)
        MPI_Abort(MPI_COMM_WORLD, 6);
    MPI_Request request;
    MPI_Irecv(padded, units(bytes), unit_type(), from, 0, MPI_COMM_WORLD, &request);
    wait_asleep(&request);
    memcpy(data, padded, bytes);
    free(padded);
}

const iso_ranks_interface iso_ranks_interface_mpi = {
    .open = mpi_open,
    .close = mpi_close,
    .gather = mpi_gather,
    .broadcast = mpi_broadcast,
    .largest = mpi_largest,
    .send = mpi_send,
    .receive = mpi_receive,
};
