/* SPDX-License-Identifier: MIT */
/* build.c - the in-memory build against memcpy. */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/bigfile.h"
#include "base/file.h"
#include "base/parallel.h"
#include "base/temporary.h"
#include "base/unfinished.h"
#include "bench/bench.h"
#include "pyramid/cascade.h"
#include "pyramid/pyramid_stream.h"
#include "volume/synthetic.h"

/* ---- a streaming build, compared with the time that the disk needs for the same bytes ---- */

/* Times of the fastest build and of the fastest copy. */
typedef struct bench_files_times {
    iso_stream_report stream;
    /* Seconds to read the volume's file and write files as long as the pyramid's, in parallel, nothing computed: until
     * they are on the disk (as the pyramid is), and until the system has accepted them. */
    double floor, floor_unflushed;
    size_t bytes; /* read and written */
} bench_files_times;

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
    NEED_MEMORY(planes, err, "%s: no memory for %d planes", path, READ_PLANES);
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
    NEED_MEMORY(*work, err, "out of memory");
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

/* Does the same for a volume in a file. */
static iso_status bench_files_of(const char *volume, const iso_pyramid_options *opt, const char *folder,
                                 size_t memory_bytes, size_t runs, bench_files_times *t, iso_error *err)
{
    char *work;
    iso_status status = make_work(folder, &work, err);
    TRY(status, measure(volume, opt, work, memory_bytes, runs, t, err));
    remove_work(work);
    return status;
}

/* Builds `runs` times in a new folder within `folder`, each build next to one copy of the same bytes. memory_bytes:
 * limit of the buffers; 0: the build's default. */
static iso_status bench_files(const iso_volume *v, const iso_pyramid_options *opt, const char *folder,
                              size_t memory_bytes, size_t runs, bench_files_times *t, iso_error *err)
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

typedef struct build_bench {
    size_t size[3], levels, runs;
    iso_type type;
    iso_pyramid_options opt;
    int threads;
    const char *files;  /* folder for a build to files as well, or NULL */
    const char *volume; /* input of that build; NULL: the volume in memory */
    double memory_mb;
} build_bench;

/* Fastest times in seconds; memory has been touched before. */
typedef struct build_times {
    double gradient, encode, pyramid,
        total;    /* of the build: with one level and nothing stored, with codes, with all levels */
    double means; /* of the build with mean scalars */
    double processor, processor_means; /* of both: over all cores, less affected by other work */
    double memcpy_build;               /* of half of the build's traffic, as memcpy both reads and writes */
    double central, memcpy_central;    /* central differences to float triples */
    size_t bytes_read, bytes_written, central_bytes;
    size_t level_count;
    bench_files_times files; /* of the build from a file to files, if requested */
} build_times;

/* Fills the volume with a small repeated block, which is fast at any size. Speed does not depend on the values. */
static iso_status fill(const build_bench *b, iso_volume *v, iso_error *err)
{
    const size_t edge = 32, block_size[3] = {edge, edge, edge};
    const double spacing[3] = {1, 1, 1};
    iso_field field = {.kind = ISO_FIELD_NOISE, .geometry = iso_geometry_axis_aligned(block_size, spacing), .seed = 1};
    iso_geometry g = iso_geometry_axis_aligned(b->size, spacing);
    iso_volume block;
    NEED(iso_field_sample(&field, b->type, &block, err));
    iso_status status = iso_volume_create(v, &g, b->type, "bench build", err);
    const size_t width = iso_type_bytes(b->type), *n = b->size;
    if (status == ISO_OK) {
#pragma omp parallel for schedule(static) num_threads(iso_threads(b->threads))
        for (size_t row = 0; row < n[1] * n[2]; ++row)
            for (size_t x = 0; x < n[0]; x += edge)
                memcpy((char *)v->data + (row * n[0] + x) * width,
                       (char *)block.data + ((row / n[1] % edge) * edge + row % n[1] % edge) * edge * width,
                       (n[0] - x < edge ? n[0] - x : edge) * width);
    }
    iso_volume_destroy(&block);
    return status;
}

static double copy_seconds(char *to, const char *from, size_t bytes, int threads)
{
    const size_t piece = (size_t)1 << 22, count = (bytes + piece - 1) / piece;
    const double start = iso_clock_seconds();
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < count; ++i)
        memcpy(to + i * piece, from + i * piece, i + 1 < count ? piece : bytes - i * piece);
    return iso_clock_seconds() - start;
}

/* Measures a memcpy of `bytes` between buffers touched before. */
static iso_status time_memcpy(size_t bytes, size_t runs, int threads, double *seconds, iso_error *err)
{
    FREED char *from = malloc(bytes), *to = malloc(bytes);
    *seconds = INFINITY;
    if (from && to) {
        memset(from, 1, bytes);
        memset(to, 2, bytes);
        for (size_t i = 0; i < runs; ++i)
            *seconds = fmin(*seconds, copy_seconds(to, from, bytes, threads));
    } else {
        return iso_fail(err, ISO_E_MEMORY, "no memory to copy %zu bytes", bytes);
    }
    return ISO_OK;
}

typedef struct build_buffers {
    iso_cascade_out out[32];
    size_t bytes;
} build_buffers;

static void free_buffers(build_buffers *b)
{
    for (size_t k = 0; k < 32; ++k) {
        free(b->out[k].scalar);
        free(b->out[k].codes);
    }
}

static iso_status make_buffers(const iso_volume *v, size_t level_count, build_buffers *b, iso_error *err)
{
    iso_geometry g = v->geometry;
    *b = (build_buffers){0};
    for (size_t k = 0; k < level_count; ++k) {
        const size_t count = iso_geometry_voxel_count(&g);
        b->out[k].codes = malloc(3 * count);
        if (k > 0)
            b->out[k].scalar = malloc(count * sizeof(float));
        if (!b->out[k].codes || (k > 0 && !b->out[k].scalar)) {
            free_buffers(b);
            return iso_fail(err, ISO_E_MEMORY, "no memory for level %zu", k);
        }
        memset(b->out[k].codes, 1, 3 * count);
        if (k > 0)
            memset(b->out[k].scalar, 1, count * sizeof(float));
        b->bytes += 3 * count + (k > 0 ? 4 * count : 0);
        g = iso_geometry_coarser(&g);
    }
    return ISO_OK;
}

/* Runs one build and lowers *seconds and *processor to its times if it was faster. */
static iso_status run_cascade(const iso_volume *v, const iso_pyramid_options *opt, const iso_cascade_out *out,
                              double *seconds, double *processor, iso_error *err)
{
    const size_t *n = v->geometry.size;
    const iso_planes planes = {v->data, v->type, {n[0], n[1], n[2]}, 0, n[2], false};
    iso_cascade *c;
    const double start = iso_clock_seconds(), processor_start = iso_cpu_seconds();
    iso_status status = iso_cascade_create(&v->geometry, opt, iso_cascade_scale(&v->geometry, 65535), &c, err);
    TRY(status, iso_cascade_feed(c, &planes, 0, n[2], out, err));
    iso_cascade_destroy(c);
    *seconds = fmin(*seconds, iso_clock_seconds() - start);
    *processor = fmin(*processor, iso_cpu_seconds() - processor_start);
    return status;
}

static iso_status time_cascade(const iso_volume *v, const iso_pyramid_options *opt, const iso_cascade_out *out,
                               size_t runs, double *seconds, iso_error *err)
{
    double processor = INFINITY;
    *seconds = INFINITY;
    for (size_t i = 0; i < runs; ++i)
        NEED(run_cascade(v, opt, out, seconds, &processor, err));
    return ISO_OK;
}

/* Measures both builds in turn (default and mean scalars), so that other load affects both. */
static iso_status time_with_means(const iso_volume *v, const iso_pyramid_options *opt, const iso_cascade_out *out,
                                  size_t runs, build_times *t, iso_error *err)
{
    iso_pyramid_options means = *opt;
    iso_status status = ISO_OK;
    means.scalar_filter = ISO_SCALAR_MEAN;
    t->total = t->means = t->processor = t->processor_means = INFINITY;
    for (size_t i = 0; i < runs && status == ISO_OK; ++i) {
        status = run_cascade(v, opt, out, &t->total, &t->processor, err);
        if (status == ISO_OK && opt->scalar_filter != ISO_SCALAR_MEAN)
            status = run_cascade(v, &means, out, &t->means, &t->processor_means, err);
    }
    if (opt->scalar_filter == ISO_SCALAR_MEAN) {
        t->means = t->total;
        t->processor_means = t->processor;
    }
    return status;
}

static iso_status time_build(const build_bench *b, const iso_volume *v, build_times *t, iso_error *err)
{
    iso_pyramid_options opt = b->opt;
    build_buffers buffers;
    double one = INFINITY, coded = INFINITY;
    t->level_count = iso_cascade_level_count(&v->geometry, &opt);
    NEED(make_buffers(v, t->level_count, &buffers, err));
    const iso_cascade_out nothing = {0};
    t->bytes_read = iso_geometry_voxel_count(&v->geometry) * iso_type_bytes(v->type);
    t->bytes_written = buffers.bytes;
    iso_status status = time_with_means(v, &opt, buffers.out, b->runs, t, err);
    opt.scalar_filter = ISO_SCALAR_MEAN;
    opt.level_count = 1;
    TRY(status, time_cascade(v, &opt, &nothing, b->runs, &one, err));
    TRY(status, time_cascade(v, &opt, buffers.out, b->runs, &coded, err));
    t->gradient = one;
    t->encode = coded - one;
    t->pyramid = t->total - coded;
    free_buffers(&buffers);
    TRY(status,
        time_memcpy((t->bytes_read + t->bytes_written) / 2, b->runs, iso_threads(b->threads), &t->memcpy_build, err));
    return status;
}

static iso_status time_central(const build_bench *b, const iso_volume *v, build_times *t, iso_error *err)
{
    const size_t count = iso_geometry_voxel_count(&v->geometry);
    float *out = malloc(3 * count * sizeof *out);
    NEED_MEMORY(out, err, "no memory for %zu gradients", count);
    memset(out, 1, 3 * count * sizeof *out);
    iso_gradient_options opt = b->opt.gradient;
    opt.threads = b->threads;
    iso_status status = ISO_OK;
    t->central = INFINITY;
    for (size_t i = 0; i < b->runs && status == ISO_OK; ++i) {
        const double start = iso_clock_seconds();
        status = iso_gradient_compute(v, &opt, out, err);
        t->central = fmin(t->central, iso_clock_seconds() - start);
    }
    free(out);
    t->central_bytes = count * (iso_type_bytes(v->type) + 3 * sizeof(float));
    TRY(status, time_memcpy(t->central_bytes / 2, b->runs, iso_threads(b->threads), &t->memcpy_central, err));
    return status;
}

static double files_voxels(const build_times *t)
{
    return (double)iso_geometry_voxel_count(&t->files.stream.levels[0].geometry);
}

/* Returns voxels per second from file to files, divided by those in memory. */
static double rate_ratio(const build_times *t, double voxels)
{
    return t->total / voxels * files_voxels(t) / t->files.stream.seconds_total;
}

static void report_files(const build_bench *b, const build_times *t, double voxels)
{
    const iso_stream_report *r = &t->files.stream;
    (void)b;
    printf("to files   %8.4f s  %6.2f ns per voxel  %5.2f of the rate in memory; slabs of %zu planes\n",
           r->seconds_total, 1e9 * r->seconds_total / files_voxels(t), rate_ratio(t, voxels), r->slab_planes);
    printf("  of it    waiting for planes %.4f, building %.4f, waiting for writers %.4f s\n", r->seconds_read,
           r->seconds_build, r->seconds_write);
    printf(
        "  disk     %8.4f s to read and write the same %.0f MB and compute nothing; the build takes %.2f times that\n"
        "           %8.4f s of it until the system has accepted them, the rest until they are on the disk\n",
        t->files.floor, 1e-6 * (double)t->files.bytes, r->seconds_total / t->files.floor, t->files.floor_unflushed);
}

static json_t *files_to_json(const build_times *t, double voxels)
{
    const iso_stream_report *r = &t->files.stream;
    return json_pack("{s:f, s:f, s:f, s:f, s:f, s:f, s:I, s:I, s:f, s:f, s:I, s:f, s:f}", "seconds_read",
                     r->seconds_read, "seconds_build", r->seconds_build, "seconds_write", r->seconds_write,
                     "seconds_total", r->seconds_total, "seconds_reading", r->seconds_reading, "seconds_writing",
                     r->seconds_writing, "slab_planes", (json_int_t)r->slab_planes, "buffer_bytes",
                     (json_int_t)r->buffer_bytes, "disk_seconds_same_bytes", t->files.floor, "disk_seconds_unflushed",
                     t->files.floor_unflushed, "bytes", (json_int_t)t->files.bytes, "ratio_to_disk",
                     r->seconds_total / t->files.floor, "rate_ratio_to_memory", rate_ratio(t, voxels));
}

static void report(const iso_cli *cli, const build_bench *b, const build_times *t)
{
    const double voxels = (double)b->size[0] * (double)b->size[1] * (double)b->size[2];
    if (!cli->json) {
        printf("%zu x %zu x %zu %s, %zu levels, %s and %s, code %s, %d threads\n", b->size[0], b->size[1], b->size[2],
               iso_type_name(b->type), t->level_count, iso_scalar_filter_name(b->opt.scalar_filter),
               iso_direction_filter_name(b->opt.direction_filter), iso_code_describe(b->opt.code)->name,
               iso_threads(b->threads));
        printf("build      %8.4f s  %6.2f ns per voxel  %5.2f x memcpy (%.4f s for the same traffic, %.0f MB)\n",
               t->total, 1e9 * t->total / voxels, t->total / t->memcpy_build, t->memcpy_build,
               1e-6 * (double)(t->bytes_read + t->bytes_written));
        printf("  of it    gradient %.4f, codes of level 0 %.4f, coarse levels %.4f s\n", t->gradient, t->encode,
               t->pyramid);
        if (b->opt.scalar_filter != ISO_SCALAR_MEAN)
            printf(
                "  means    %8.4f s  with mean scalars, built in turn; %s takes %.2f times that, %.2f in processor time\n",
                t->means, iso_scalar_filter_name(b->opt.scalar_filter), t->total / t->means,
                t->processor / t->processor_means);
        printf("gradients  %8.4f s  %6.2f ns per voxel  %5.2f x memcpy (%.4f s, %.0f MB)\n", t->central,
               1e9 * t->central / voxels, t->central / t->memcpy_central, t->memcpy_central,
               1e-6 * (double)t->central_bytes);
        if (b->files)
            report_files(b, t, voxels);
        return;
    }
    json_t *root = iso_cli_json(cli), *options = json_object_get(root, "options");
    json_object_set_new(options, "scalar_filter", json_string(iso_scalar_filter_name(b->opt.scalar_filter)));
    json_object_set_new(options, "direction_filter", json_string(iso_direction_filter_name(b->opt.direction_filter)));
    json_object_set_new(options, "estimator", json_string(iso_gradient_name(b->opt.gradient.method)));
    json_object_set_new(options, "code", json_string(iso_code_describe(b->opt.code)->name));
    json_object_set_new(options, "runs", json_integer((json_int_t)b->runs));
    json_object_set_new(root, "size",
                        json_pack("[I,I,I]", (json_int_t)b->size[0], (json_int_t)b->size[1], (json_int_t)b->size[2]));
    json_object_set_new(root, "voxel_type", json_string(iso_type_name(b->type)));
    json_object_set_new(root, "levels", json_integer((json_int_t)t->level_count));
    json_object_set_new(root, "threads", json_integer(iso_threads(b->threads)));
    json_object_set_new(root, "seconds",
                        json_pack("{s:f, s:f, s:f, s:f, s:f, s:f}", "read", t->files.stream.seconds_read, "gradient",
                                  t->gradient, "pyramid", t->pyramid, "encode", t->encode, "write",
                                  t->files.stream.seconds_write, "total", t->total));
    if (b->files)
        json_object_set_new(root, "to_files", files_to_json(t, voxels));
    json_object_set_new(root, "bytes_read", json_integer((json_int_t)t->bytes_read));
    json_object_set_new(root, "bytes_written", json_integer((json_int_t)t->bytes_written));
    json_object_set_new(root, "memcpy_seconds_same_bytes", json_real(t->memcpy_build));
    json_object_set_new(root, "ratio_to_memcpy", json_real(t->total / t->memcpy_build));
    json_object_set_new(root, "seconds_means", json_real(t->means));
    json_object_set_new(root, "ratio_to_means", json_real(t->total / t->means));
    json_object_set_new(root, "processor_seconds", json_real(t->processor));
    json_object_set_new(root, "processor_ratio_to_means", json_real(t->processor / t->processor_means));
    json_object_set_new(root, "gradients_to_float",
                        json_pack("{s:f, s:f, s:f}", "seconds", t->central, "memcpy_seconds_same_bytes",
                                  t->memcpy_central, "ratio_to_memcpy", t->central / t->memcpy_central));
    json_object_set_new(root, "peak_rss_bytes", json_real(iso_peak_rss_bytes()));
    iso_cli_print_json(root);
}

static iso_status bench(const iso_cli *cli, build_bench *b, iso_error *err)
{
    OWNED(iso_volume) v = {0};
    build_times t = {0};
    b->threads = b->opt.threads = cli->threads;
    NEED(fill(b, &v, err));
    iso_status status = time_build(b, &v, &t, err);
    TRY(status, time_central(b, &v, &t, err));
    const size_t memory = (size_t)(b->memory_mb * 1048576);
    if (status == ISO_OK && b->volume)
        status = bench_files_of(b->volume, &b->opt, b->files, memory, b->runs, &t.files, err);
    else if (status == ISO_OK && b->files)
        status = bench_files(&v, &b->opt, b->files, memory, b->runs, &t.files, err);
    if (status == ISO_OK)
        report(cli, b, &t);
    return status;
}

typedef struct build_options {
    build_bench bench;
    char *size, *type, *scalar, *direction, *code, *files, *volume;
    int levels, radius, runs;
} build_options;

static const iso_option options[] = {
    {"size", 0, "use a volume of this many voxels (256)", "N or NXxNYxNZ", ISO_IN(build_options, size)},
    {"type", 0, "set the voxels' type (uint16)", "TYPE", ISO_IN(build_options, type)},
    {"levels", 0, "build N levels, counting the finest", "N", ISO_IN(build_options, levels), .flags = ISO_SHOWN,
     .least = 1, .most = 32},
    {"scalar-filter", 0, "as in build", "NAME", ISO_IN(build_options, scalar)},
    {"direction-filter", 0, "as in build", "NAME", ISO_IN(build_options, direction)},
    {"gauss-radius", 0, "as in build", "N", ISO_IN(build_options, radius), .flags = ISO_SHOWN, .least = 1, .most = 16},
    {"code", 0, "as in build", "NAME", ISO_IN(build_options, code)},
    {"files", 0, "also build from a file to files in this folder", "FOLDER", ISO_IN(build_options, files)},
    {"volume", 0, "with --files: read this file of any size (default: the volume in memory)", "FILE",
     ISO_IN(build_options, volume)},
    {"memory", 0, "with --files: limit the buffers", "MB", ISO_IN(build_options, bench.memory_mb), .flags = ISO_SHOWN,
     .least = 1, .most = 1e9},
    {"runs", 0, "run N times; the fastest counts", "N", ISO_IN(build_options, runs), .flags = ISO_SHOWN, .least = 1,
     .most = 1000},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    build_options *o = values;
    build_bench *b = &o->bench;
    iso_status status = o->size ? iso_words_parse_sizes(o->size, "--size", b->size, err) : ISO_OK;
    b->opt = iso_pyramid_defaults();
    if (status == ISO_OK && o->type)
        status = iso_type_from_name(o->type, &b->type, err);
    if (status == ISO_OK && o->scalar)
        status = iso_scalar_filter_from_name(o->scalar, &b->opt.scalar_filter, err);
    if (status == ISO_OK && o->direction)
        status = iso_direction_filter_from_name(o->direction, &b->opt.direction_filter, err);
    if (status == ISO_OK && o->code)
        status = iso_code_from_name(o->code, &b->opt.code, err);
    if (status == ISO_OK && o->volume && !o->files)
        status = iso_fail(err, ISO_E_USAGE, "--volume needs --files FOLDER");
    b->opt.level_count = (size_t)o->levels;
    b->opt.gauss_radius = (size_t)o->radius;
    b->runs = (size_t)o->runs;
    b->files = o->files;
    b->volume = o->volume;
    return status == ISO_OK ? bench(cli, b, err) : status;
}

const iso_command iso_bench_build = {
    .name = "bench build",
    .summary = "gradients, pyramid and codes in memory, compared with memcpy",
    .usage = "[options]",
    .details =
        "The build reads the samples, and writes the codes of all levels and the scalars of the coarse ones. memcpy\n"
        "copies half of these bytes with as many threads: it reads and writes each of them. The seconds of gradient,\n"
        "encode and pyramid are differences between builds that do less. With --files, read and write are the\n"
        "seconds that the build waits for files; in memory they are 0. Each build to files runs next to a plain\n"
        "copy: the same bytes read and written with nothing computed. Both end when the bytes are on the disk.",
    .examples = "  isoshade bench build --size 96 --runs 2\n",
    ISO_COMMAND_OPTIONS(build_options, options, .bench = {.size = {256, 256, 256}, .type = ISO_U16, .memory_mb = 900},
                        .levels = 4, .radius = 2, .runs = 5),
    .run = run,
};
