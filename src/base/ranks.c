/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/ranks.h"

#include <dlfcn.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/helper.h"
#include "base/path.h"
#include "base/ranks_interface.h"
#include "base/temporary.h"

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

static iso_ranks_place read_place(void)
{
    static const char *const jobs[] = {"PMIX_NAMESPACE", "OMPI_MCA_ess_base_jobid", "SLURM_JOB_ID", "SLURM_STEP_ID"};
    const int slurm_index = from_environment("SLURM_PROCID", "SLURM_PROCID", 0),
              slurm_count = from_environment("SLURM_STEP_NUM_TASKS", "SLURM_NTASKS", 1);
    iso_ranks_place p = {.index = from_environment("OMPI_COMM_WORLD_RANK", "PMI_RANK", slurm_index),
                         .count = from_environment("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", slurm_count)};
    size_t length = 0;
    for (size_t i = 0; i < sizeof jobs / sizeof *jobs; ++i) {
        const char *text = getenv(jobs[i]);
        if (text && length < sizeof p.job)
            length += (size_t)snprintf(p.job + length, sizeof p.job - length, "%s ", text);
    }
    if (p.count < 1 || p.index < 0 || p.index >= p.count)
        p.index = 0, p.count = 1;
    return p;
}

iso_ranks_place iso_ranks_find_place(void)
{
    static iso_ranks_place place;
    if (place.count == 0)
        place = read_place();
    return place;
}

/* Without SLURM_NTASKS, which the batch script that calls srun has, too. */
static const char *const counts[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"};
enum { COUNTS = sizeof counts / sizeof *counts };

const char *iso_ranks_variable(void)
{
    static const char *found;
    for (size_t i = 0; i < COUNTS && !found; ++i) {
        const char *text = getenv(counts[i]);
        found = text && atoi(text) > 1 ? counts[i] : NULL;
    }
    return found;
}

void iso_ranks_hide(void)
{
    iso_ranks_find_place();
    iso_ranks_variable();
    for (size_t i = 0; i < COUNTS; ++i)
        unsetenv(counts[i]);
}

static void work_as_child(pid_t parent, void (*work)(void *user, const char *folder), void *user, const char *folder)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() == parent && freopen("/dev/null", "w", stdout) && freopen("/dev/null", "w", stderr))
        work(user, folder);
    _exit(EXIT_SUCCESS);
}

int iso_ranks_run_apart(void (*work)(void *user, const char *folder), void *user)
{
    FREED char *folder = iso_make_temp_dir();
    int state = 0;
    fflush(NULL);
    const pid_t parent = getpid(), child = folder ? fork() : -1;
    if (child == 0)
        work_as_child(parent, work, user, folder);
    while (child > 0 && waitpid(child, &state, 0) < 0 && errno == EINTR)
        ;
    if (folder)
        iso_remove_tree(folder);
    return child > 0 && WIFSIGNALED(state) ? WTERMSIG(state) : 0;
}

/* Loads isoshade_mpi.so, with its symbols visible to MPI's own libraries. */
static void *load_library(iso_error *err)
{
    FREED char *path = iso_helper_find("isoshade_mpi.so");
    void *library = path ? dlopen(path, RTLD_NOW | RTLD_GLOBAL) : NULL;
    if (!library)
        iso_fail(err, ISO_E_MISSING, "started by mpirun, but MPI cannot be loaded: %s",
                 path ? dlerror() : "built without; install the Debian package libopenmpi-dev, and build again");
    return library;
}

iso_status iso_ranks_open(iso_ranks **ranks, iso_error *err)
{
    *ranks = NULL;
    const int wanted = from_environment("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", 1);
    if (wanted <= 1)
        return ISO_OK;
    iso_ranks *r = calloc(1, sizeof *r);
    NEED_MEMORY(r, err, "out of memory");
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
    FREED outcome *all = malloc((size_t)r->count * sizeof *all);
    if (!all)
        abort(); /* the others wait: mpirun ends them */
    r->interface->gather(&own, sizeof own, all);
    status = ISO_OK;
    for (int i = 0; i < r->count && status == ISO_OK; ++i) {
        status = all[i].status;
        if (status != ISO_OK && err)
            *err = all[i].error;
    }
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
