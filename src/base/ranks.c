/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/ranks.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/helper.h"
#include "base/ranks_interface.h"

struct iso_ranks {
    const iso_ranks_interface *interface;
    void *library;
    int index, count;
};

/* Reads a number from the environment of Open MPI, or of MPICH, Slurm and others with a PMI. `missing`: it is in
 * neither. */
static int from_environment(const char *open_mpi, const char *pmi, int missing)
{
    const char *text = getenv(open_mpi);
    if (!text)
        text = getenv(pmi);
    return text ? atoi(text) : missing;
}

int iso_ranks_is_other(void)
{
    return from_environment("OMPI_COMM_WORLD_RANK", "PMI_RANK", 0) > 0;
}

/* Loads isoshade_mpi.so, with its symbols visible to MPI's own libraries. */
static void *load_library(iso_error *err)
{
    char *path = iso_helper_find("isoshade_mpi.so");
    void *library = path ? dlopen(path, RTLD_NOW | RTLD_GLOBAL) : NULL;
    if (!library)
        iso_fail(err, ISO_E_MISSING, "started by mpirun, but MPI cannot be loaded: %s",
                 path ? dlerror() : "built without; install the Debian package libopenmpi-dev, and build again");
    free(path);
    return library;
}

iso_status iso_ranks_open(iso_ranks **ranks, iso_error *err)
{
    *ranks = NULL;
    const int wanted = from_environment("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", 1);
    if (wanted <= 1)
        return ISO_OK;
    iso_ranks *r = calloc(1, sizeof *r);
    if (!r)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    r->library = load_library(err);
    r->interface = r->library ? dlsym(r->library, ISO_RANKS_INTERFACE_SYMBOL) : NULL;
    iso_status status = r->interface ? ISO_OK : ISO_E_MISSING;
    if (status == ISO_OK) {
        r->interface->open(&r->index, &r->count);
        if (r->count != wanted)
            status = iso_fail(err, ISO_E_MISSING, "mpirun started %d ranks, MPI sees %d: they are of different makes",
                              wanted, r->count);
    }
    if (status == ISO_OK)
        *ranks = r;
    else
        iso_ranks_close(r);
    return status;
}

/* Closes the job. The library stays loaded: MPI leaves threads and handlers running. */
void iso_ranks_close(iso_ranks *r)
{
    if (r && r->count > 0)
        r->interface->close();
    free(r);
}

int iso_ranks_index(const iso_ranks *r)
{
    return r ? r->index : 0;
}

int iso_ranks_count(const iso_ranks *r)
{
    return r ? r->count : 1;
}

typedef struct outcome {
    iso_status status;
    iso_error error;
} outcome;

iso_status iso_ranks_agree(iso_ranks *r, iso_status status, iso_error *err)
{
    if (!r)
        return status;
    outcome own = {.status = status};
    if (err)
        own.error = *err;
    outcome *all = malloc((size_t)r->count * sizeof *all);
    if (!all)
        abort(); /* the others wait: mpirun ends them */
    r->interface->gather(&own, sizeof own, all);
    status = ISO_OK;
    for (int i = 0; i < r->count && status == ISO_OK; ++i) {
        status = all[i].status;
        if (status != ISO_OK && err)
            *err = all[i].error;
    }
    free(all);
    return status;
}

void iso_ranks_broadcast(iso_ranks *r, void *data, size_t bytes)
{
    if (r)
        r->interface->broadcast(data, bytes);
}

void iso_ranks_largest(iso_ranks *r, double *values, size_t count)
{
    if (r)
        r->interface->largest(values, count);
}

void iso_ranks_send(iso_ranks *r, int to, const void *data, size_t bytes)
{
    r->interface->send(to, data, bytes);
}

void iso_ranks_receive(iso_ranks *r, int from, void *data, size_t bytes)
{
    r->interface->receive(from, data, bytes);
}
