/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bench/files.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/bigfile.h"
#include "base/file.h"
#include "base/parallel.h"
#include "base/temporary.h"
#include "base/unfinished.h"

enum { MAX_FILES = 128, READ_PLANES = 4, WRITERS = 2 };

static iso_status open_path(void *user, iso_volume_source **source, iso_error *err)
{
    return iso_source_open(user, source, err);
}

static iso_status read_all(const char *path, iso_error *err)
{
    ENDED_BY(iso_source_close_owned) iso_volume_source *source = NULL;
    NEED(iso_source_open(path, &source, err));
    const iso_volume *v = iso_source_volume(source);
    const size_t *n = v->geometry.size;
    FREED char *planes = malloc(READ_PLANES * n[0] * n[1] * iso_type_bytes(v->type));
    if (!planes)
        return iso_fail(err, ISO_E_MEMORY, "%s: no memory for %d planes", path, READ_PLANES);
    for (size_t z = 0; z < n[2]; z += READ_PLANES)
        NEED(iso_source_read(source, z + READ_PLANES < n[2] ? READ_PLANES : n[2] - z, planes, err));
    return ISO_OK;
}

static iso_status write_bytes(const char *path, bool direct, size_t bytes, iso_error *err)
{
    FREED char *data = malloc(ISO_BIGFILE_BYTES);
    iso_bigfile *file = NULL;
    iso_status status = data ? iso_bigfile_open(path, direct, 0, &file, err)
                             : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (data)
        memset(data, 1, ISO_BIGFILE_BYTES);
    for (size_t done = 0; done < bytes && status == ISO_OK; done += ISO_BIGFILE_BYTES)
        status = iso_bigfile_write(file, data, bytes - done < ISO_BIGFILE_BYTES ? bytes - done : ISO_BIGFILE_BYTES,
                                   err);
    iso_status closed = iso_bigfile_close(file, status == ISO_OK ? err : NULL);
    return status == ISO_OK ? closed : status;
}

/* Flushes a file: a build's output is on the disk when the build ends. */
static iso_status flush_to_disk(const char *path, iso_error *err)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    const bool good = fd >= 0 && fsync(fd) == 0;
    if (fd >= 0)
        close(fd);
    return good ? ISO_OK : iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
}

/* Lists the sizes of the files in a folder; returns their number. */
static size_t list_sizes(const char *dir, size_t sizes[MAX_FILES])
{
    size_t count = 0;
    DIR *d = opendir(dir);
    for (struct dirent *e; d && count < MAX_FILES && (e = readdir(d));) {
        FREED char *path = iso_path_join(dir, e->d_name);
        struct stat st;
        if (path && stat(path, &st) == 0 && S_ISREG(st.st_mode))
            sizes[count++] = (size_t)st.st_size;
    }
    if (d)
        closedir(d);
    return count;
}

/* Copies with one reading and two writing threads, as the build does. */
static iso_status copy_bytes(const char *volume, const size_t *sizes, size_t count, const char *folder,
                             bench_files_times *t, iso_error *err)
{
    size_t read_bytes = 0;
    struct stat st;
    char *dir = iso_path_join(folder, "isoshade-bench.copy");
    iso_status results[MAX_FILES + 1] = {ISO_OK}, status = ISO_OK;
    iso_error errors[MAX_FILES + 1];
    if (stat(volume, &st) == 0)
        read_bytes = (size_t)st.st_size;
    if (!dir || mkdir(dir, 0777) != 0)
        status = iso_fail(err, ISO_E_IO, "%s: cannot be created", dir ? dir : folder);
    const double start = iso_clock_seconds();
#pragma omp parallel for schedule(dynamic, 1) num_threads(1 + WRITERS)
    for (size_t i = 0; i <= count; ++i) {
        char name[32];
        snprintf(name, sizeof name, "%zu", i);
        char *path = status == ISO_OK && i > 0 ? iso_path_join(dir, name) : NULL;
        if (status == ISO_OK)
            results[i] = i == 0 ? read_all(volume, &errors[0])
                         : path ? write_bytes(path, read_bytes >= (size_t)256 << 20, sizes[i - 1], &errors[i])
                                : iso_fail(&errors[i], ISO_E_MEMORY, "out of memory");
        free(path);
    }
    const double unflushed = iso_clock_seconds() - start;
    for (size_t i = 1; i <= count && status == ISO_OK && results[i] == ISO_OK; ++i) {
        char name[32];
        snprintf(name, sizeof name, "%zu", i);
        char *path = iso_path_join(dir, name);
        results[i] = path ? flush_to_disk(path, &errors[i]) : iso_fail(&errors[i], ISO_E_MEMORY, "out of memory");
        free(path);
    }
    const double seconds = iso_clock_seconds() - start;
    t->bytes = read_bytes;
    for (size_t i = 0; i <= count && status == ISO_OK; ++i) {
        t->bytes += i > 0 ? sizes[i - 1] : 0;
        if ((status = results[i]) != ISO_OK)
            *err = errors[i];
    }
    t->floor = fmin(t->floor, seconds);
    t->floor_unflushed = fmin(t->floor_unflushed, unflushed);
    if (dir)
        iso_remove_tree(dir);
    free(dir);
    return status;
}

/* Measures in a folder that is otherwise empty. */
static iso_status measure(const char *volume, const iso_pyramid_options *opt, const char *work, size_t memory_bytes,
                          size_t runs, bench_files_times *t, iso_error *err)
{
    FREED char *pyramid = iso_path_join(work, "isoshade-bench.iso");
    const iso_stream_input in = {open_path, (void *)volume, volume};
    const iso_stream_options how = {.memory_bytes = memory_bytes, .save_seconds = ISO_STREAM_SAVE_SECONDS};
    iso_status status = pyramid ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    *t = (bench_files_times){.floor = INFINITY, .floor_unflushed = INFINITY};
    t->stream.seconds_total = INFINITY;
    for (size_t i = 0; i < runs && status == ISO_OK; ++i) {
        iso_stream_report r;
        status = iso_pyramid_stream(&in, opt, &how, pyramid, &r, NULL, err);
        if (status == ISO_OK && r.seconds_total < t->stream.seconds_total)
            t->stream = r;
        size_t sizes[MAX_FILES];
        const size_t count = list_sizes(pyramid, sizes);
        iso_remove_tree(pyramid); /* frees the space before as much is written again */
        TRY(status, copy_bytes(volume, sizes, count, work, t, err));
    }
    return status;
}

/* Creates a fresh folder in `folder`, so that no user file is replaced or removed. Remove it and free *work. */
static iso_status make_work(const char *folder, char **work, iso_error *err)
{
    iso_temporary_sweep(folder);
    *work = iso_temporary_path(folder, "bench");
    if (!*work)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    iso_unfinished_add(*work, false);
    return mkdir(*work, 0777) == 0
               ? ISO_OK
               : iso_fail(err, iso_errno_status(), "%s: cannot create a folder in it: %s", folder, strerror(errno));
}

static void remove_work(char *work)
{
    if (work)
        iso_remove_tree(work);
    free(work);
}

iso_status iso_bench_files_of(const char *volume, const iso_pyramid_options *opt, const char *folder,
                              size_t memory_bytes, size_t runs, bench_files_times *t, iso_error *err)
{
    char *work;
    iso_status status = make_work(folder, &work, err);
    TRY(status, measure(volume, opt, work, memory_bytes, runs, t, err));
    remove_work(work);
    return status;
}

iso_status iso_bench_files(const iso_volume *v, const iso_pyramid_options *opt, const char *folder, size_t memory_bytes,
                           size_t runs, bench_files_times *t, iso_error *err)
{
    char *work, *volume = NULL;
    iso_status status = make_work(folder, &work, err);
    if (status == ISO_OK && !(volume = iso_path_join(work, "isoshade-bench.nrrd")))
        status = iso_fail(err, ISO_E_MEMORY, "out of memory");
    TRY(status, iso_volume_save(v, volume, false, err));
    TRY(status, measure(volume, opt, work, memory_bytes, runs, t, err));
    free(volume);
    remove_work(work);
    return status;
}
