#define _GNU_SOURCE
#include "pyramid/pyramid_stream.h"

#include <float.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/bigfile.h"
#include "base/file.h"
#include "base/json.h"
#include "base/parallel.h"
#include "pyramid/cascade.h"
#include "pyramid/pyramid_layout.h"

#define PROGRESS_NAME "progress.json"
#define PROGRESS_SCHEMA "isoshade.progress/1"
#define CARRY_NAME "carry.raw"

/* Slabs that stay in a large cache are written while they are still there. */
#define FAST_BYTES ((size_t)160 << 20)

/* Input between two notes of progress; and from which on files bypass the page cache. */
#define PROGRESS_BYTES ((size_t)128 << 20)
#define DIRECT_BYTES ((size_t)256 << 20)

/* One level while it is written. Buffers hold `capacity` planes from out.first on;
 * there are two sets of them, one of which is written while the other is filled. */
typedef struct stream_level {
    iso_geometry geometry;
    iso_type type;
    size_t capacity;
    iso_cascade_out set[2];
    size_t first;      /* plane of the buffers' first plane */
    size_t written;    /* planes that the last slab completed */
    level_file files[FILE_COUNT];
    iso_bigfile *file[FILE_COUNT]; /* NULL: not stored */
    XXH3_state_t *hash[FILE_COUNT];
} stream_level;

/* A piece of a file, for the writing thread. */
typedef struct write_item {
    stream_level *level;
    int file;
    const void *data;
    size_t bytes;
} write_item;

typedef struct stream {
    const iso_stream_input *in;
    const iso_pyramid_options *opt;
    const iso_stream_options *how;
    iso_stream_report *report;
    iso_output output;
    iso_volume_source *source;
    iso_volume header;
    iso_cascade *cascade;
    size_t level_count;
    stream_level levels[32];
    /* The input's planes in memory. */
    char *planes[2];
    int active; /* the set that is filled */
    size_t planes_first, planes_count, planes_capacity, slab, progress_at;
    bool direct; /* files past the page cache */
    iso_bigfile *carry;
    size_t carry_planes; /* written */
    /* The thread that writes the other set. */
    write_item items[32 * FILE_COUNT];
    size_t item_count;
    bool writing;
    pthread_t writer;
    iso_status write_status;
    iso_error write_error;
} stream;

static size_t input_plane_bytes(const stream *s)
{
    return s->header.geometry.size[0] * s->header.geometry.size[1] * iso_type_bytes(s->header.type);
}

static size_t file_plane_bytes(const stream_level *l, int i)
{
    return l->geometry.size[0] * l->geometry.size[1] * l->files[i].components * iso_type_bytes(l->files[i].type);
}

/* Level 0's scalars go from the input to the file, unless they become float. */
static bool converts(const stream *s, size_t k)
{
    return k > 0 || s->levels[0].type != s->header.type;
}

/* ---- the range of the input ---- */

static iso_status measure_planes(const iso_volume *plane, const char *path, double *lo, double *hi, iso_error *err)
{
    iso_volume_stats stats = iso_volume_measure(plane);
    if (stats.nonfinite_count > 0)
        return iso_fail(err, ISO_E_RANGE, "%s: %zu voxels of a plane are NaN or infinite, none may be", path,
                        stats.nonfinite_count);
    *lo = fmin(*lo, stats.min);
    *hi = fmax(*hi, stats.max);
    return ISO_OK;
}

/* Of narrow integers by their type; of others by reading them all. */
static iso_status input_range(stream *s, double *range, iso_error *err)
{
    const size_t bytes = iso_type_bytes(s->header.type), nz = s->header.geometry.size[2];
    *range = bytes == 1 ? 255 : 65535;
    if (bytes <= 2)
        return ISO_OK;
    double lo = INFINITY, hi = -INFINITY;
    iso_volume plane = s->header;
    iso_volume_source *source = NULL;
    plane.geometry.size[2] = 1;
    plane.data = malloc(input_plane_bytes(s));
    iso_status status = plane.data ? s->in->open(s->in->user, &source, err)
                                   : iso_fail(err, ISO_E_MEMORY, "%s: no memory for a plane", s->in->path);
    for (size_t z = 0; z < nz && status == ISO_OK; ++z) {
        status = iso_source_read(source, 1, plane.data, err);
        if (status == ISO_OK)
            status = measure_planes(&plane, s->in->path, &lo, &hi, err);
        if (status != ISO_OK && status == ISO_E_RANGE)
            status = iso_fail_in(err, status, "plane %zu", z);
    }
    iso_source_close(source);
    free(plane.data);
    *range = hi - lo;
    if (status == ISO_OK && !(*range <= FLT_MAX && fabs(lo) <= FLT_MAX && fabs(hi) <= FLT_MAX))
        status = iso_fail(err, ISO_E_RANGE, "%s: values from %g to %g, differences up to %g can be taken", s->in->path, lo,
                          hi, (double)FLT_MAX);
    return status;
}

/* ---- buffers ---- */

static size_t level_plane_bytes(const stream *s, size_t k)
{
    const stream_level *l = &s->levels[k];
    const size_t n = l->geometry.size[0] * l->geometry.size[1];
    return n * (3 + (converts(s, k) ? sizeof(float) : 0) + (s->opt->keep_float ? 3 * sizeof(float) : 0) +
                (s->opt->keep_magnitude ? sizeof(float) : 0));
}

static size_t buffer_bytes(const stream *s, size_t slab)
{
    size_t bytes = 2 * (slab + 2 * iso_cascade_reach(s->cascade)) * input_plane_bytes(s) + iso_cascade_bytes(s->cascade);
    for (size_t k = 0; k < s->level_count; ++k) {
        bytes += 2 * iso_cascade_capacity(s->cascade, k, slab) * level_plane_bytes(s, k);
        for (int i = 0; i < FILE_COUNT; ++i)
            bytes += s->levels[k].files[i].stored ? ISO_BIGFILE_BYTES : 0;
    }
    return bytes;
}

static iso_status choose_slab(stream *s, iso_error *err)
{
    const size_t step = iso_cascade_step(s->cascade), limit = s->how->memory_bytes, nz = s->header.geometry.size[2];
    s->slab = step;
    if (limit > 0 && buffer_bytes(s, step) > limit)
        return iso_fail(err, ISO_E_MEMORY, "%s: slabs of %zu planes need %zu MB of memory, %zu MB are allowed", s->in->path,
                        step, buffer_bytes(s, step) >> 20, limit >> 20);
    const size_t enough = buffer_bytes(s, step) > FAST_BYTES ? buffer_bytes(s, step) : FAST_BYTES;
    const size_t most = limit > 0 && limit < enough ? limit : enough;
    const size_t longest = s->how->max_slab > 0 && s->how->max_slab < nz ? s->how->max_slab : nz;
    while (s->slab < longest && buffer_bytes(s, s->slab + step) <= most)
        s->slab += step;
    return ISO_OK;
}

static bool create_set(const stream *s, const stream_level *l, size_t k, iso_cascade_out *out)
{
    const size_t n = l->capacity * l->geometry.size[0] * l->geometry.size[1];
    out->codes = malloc(3 * n);
    out->scalar = converts(s, k) ? malloc(n * sizeof(float)) : NULL;
    out->directions = s->opt->keep_float ? malloc(3 * n * sizeof(float)) : NULL;
    out->magnitude = s->opt->keep_magnitude ? malloc(n * sizeof(float)) : NULL;
    return out->codes && (out->scalar || !converts(s, k)) && (out->directions || !s->opt->keep_float) &&
           (out->magnitude || !s->opt->keep_magnitude);
}

static bool create_buffers(stream *s)
{
    bool good = true;
    s->planes_capacity = s->slab + 2 * iso_cascade_reach(s->cascade);
    for (int set = 0; set < 2; ++set) {
        s->planes[set] = malloc(s->planes_capacity * input_plane_bytes(s));
        good = good && s->planes[set];
    }
    for (size_t k = 0; k < s->level_count; ++k) {
        stream_level *l = &s->levels[k];
        l->capacity = iso_cascade_capacity(s->cascade, k, s->slab);
        good = create_set(s, l, k, &l->set[0]) && create_set(s, l, k, &l->set[1]) && good;
    }
    return good;
}

/* ---- files ---- */

static iso_status write_file(stream_level *l, int i, const void *data, size_t bytes, iso_error *err)
{
    XXH3_64bits_update(l->hash[i], data, bytes);
    l->files[i].bytes += bytes;
    return iso_bigfile_write(l->file[i], data, bytes, err);
}

/* The first `bytes` of a file of an earlier build, into its checksum. */
static iso_status hash_file(const char *path, XXH3_state_t *hash, size_t bytes, iso_error *err)
{
    enum { CHUNK = 1 << 20 };
    char *chunk = malloc(CHUNK);
    FILE *file = fopen(path, "rb");
    bool good = chunk && file;
    for (size_t done = 0; done < bytes && good;) {
        size_t n = bytes - done < CHUNK ? bytes - done : CHUNK;
        good = fread(chunk, 1, n, file) == n;
        if (good)
            XXH3_64bits_update(hash, chunk, n);
        done += n;
    }
    free(chunk);
    if (file)
        fclose(file);
    return good ? ISO_OK : iso_fail(err, ISO_E_FORMAT, "%s: holds less than progress.json says", path);
}

static iso_status open_file(stream *s, size_t k, int i, size_t planes_done, iso_error *err)
{
    stream_level *l = &s->levels[k];
    char name[64];
    iso_layout_name(&l->files[i], k, name);
    char *path = iso_path_join(s->output.temp_path, name), *header = iso_layout_header(&l->geometry, &l->files[i]);
    l->hash[i] = XXH3_createState();
    iso_status status = path && header && l->hash[i] ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", name);
    if (status == ISO_OK) {
        XXH3_64bits_reset(l->hash[i]);
        l->files[i].bytes = planes_done ? strlen(header) + planes_done * file_plane_bytes(l, i) : 0;
        status = iso_bigfile_open(path, s->direct, l->files[i].bytes, &l->file[i], err);
    }
    if (status == ISO_OK)
        status = planes_done ? hash_file(path, l->hash[i], l->files[i].bytes, err)
                             : write_file(l, i, header, strlen(header), err);
    free(header);
    free(path);
    return status;
}

/* The files of all levels, at the plane where their level stands. */
static iso_status open_files(stream *s, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t k = 0; k < s->level_count && status == ISO_OK; ++k)
        for (int i = 0; i < FILE_COUNT && status == ISO_OK; ++i)
            if (s->levels[k].files[i].stored)
                status = open_file(s, k, i, s->levels[k].first, err);
    return status;
}

/* ---- progress.json ---- */

static json_t *describe_job(const stream *s, double scale)
{
    struct stat st = {0};
    stat(s->in->path, &st);
    return json_pack("{s:s, s:s, s:I, s:I, s:o, s:s, s:f, s:o}", "schema", PROGRESS_SCHEMA, "source", s->in->path,
                     "source_bytes", (json_int_t)st.st_size, "source_time", (json_int_t)st.st_mtime, "geometry",
                     iso_layout_geometry(&s->header.geometry), "type", iso_type_name(s->header.type), "scale", scale,
                     "options", iso_layout_options(s->opt));
}

static iso_status save_progress(const stream *s, json_t *job, size_t planes, iso_error *err)
{
    json_t *ranges = json_array();
    for (size_t k = 0; k < s->level_count; ++k) {
        double range[2] = {0, 0};
        iso_cascade_range(s->cascade, k, &range[0], &range[1]);
        json_array_append_new(ranges, iso_json_numbers(range, 2)); /* null where there is none yet */
    }
    json_object_set_new(job, "planes", json_integer((json_int_t)planes));
    json_object_set_new(job, "ranges", ranges);
    return iso_layout_save_json(s->output.temp_path, PROGRESS_NAME, job, err);
}

static iso_status take_up_carry(stream *s, size_t z, iso_error *err)
{
    size_t plane_floats;
    float *carry = iso_cascade_carry(s->cascade, &plane_floats);
    const size_t level = iso_cascade_carry_level(s->cascade), planes = z >> level;
    if (!carry || planes == 0)
        return ISO_OK;
    char *path = iso_path_join(s->output.temp_path, CARRY_NAME), *data = NULL;
    size_t size = 0;
    iso_status status = path ? iso_file_read(path, &data, &size, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK && size < planes * plane_floats * sizeof *carry)
        status = iso_fail(err, ISO_E_FORMAT, "%s: holds less than progress.json says", path);
    if (status == ISO_OK) {
        memcpy(carry, data, planes * plane_floats * sizeof *carry);
        s->carry_planes = planes;
    }
    free(data);
    free(path);
    return status;
}

/* Whether an earlier build's progress is of this very job, and how far it came. */
static bool read_progress(stream *s, const json_t *job, size_t *planes)
{
    char *path = iso_path_join(s->output.temp_path, PROGRESS_NAME);
    json_t *found = NULL;
    bool same = path && iso_json_load(path, &found, NULL) == ISO_OK;
    const char *key;
    json_t *value;
    if (same)
        json_object_foreach((json_t *)job, key, value)
            same = same && json_equal(value, json_object_get(found, key));
    json_t *ranges = same ? json_object_get(found, "ranges") : NULL;
    *planes = same ? (size_t)json_integer_value(json_object_get(found, "planes")) : 0;
    same = same && *planes > 0 && *planes <= s->header.geometry.size[2] && json_array_size(ranges) == s->level_count;
    for (size_t k = 0; same && k < s->level_count; ++k) {
        json_t *range = json_array_get(ranges, k);
        if (json_is_number(json_array_get(range, 0)))
            iso_cascade_set_range(s->cascade, k, json_number_value(json_array_get(range, 0)),
                                  json_number_value(json_array_get(range, 1)));
    }
    json_decref(found);
    free(path);
    return same;
}

/* ---- planes ---- */

/* Planes from `from` to `to` (not included) into the active set: those that the other has, and new ones. */
static iso_status read_planes(stream *s, size_t from, size_t to, iso_error *err)
{
    const size_t plane = input_plane_bytes(s), end = s->planes_first + s->planes_count;
    const double start = iso_clock_seconds();
    const size_t keep = end > from ? end - from : 0;
    char *planes = s->planes[s->active];
    if (keep > 0)
        memcpy(planes, s->planes[!s->active] + (s->planes_count - keep) * plane, keep * plane);
    s->planes_count = keep;
    s->planes_first = end - keep;
    iso_status status = ISO_OK;
    while (s->planes_first + s->planes_count < from && status == ISO_OK) { /* not wanted; only when a build is taken up */
        status = iso_source_read(s->source, 1, planes, err);
        ++s->planes_first;
    }
    if (status == ISO_OK) {
        const size_t count = to - (s->planes_first + s->planes_count);
        status = iso_source_read(s->source, count, planes + s->planes_count * plane, err);
        s->planes_count += count;
    }
    s->report->seconds_read += iso_clock_seconds() - start;
    return status;
}

static void *write_items(void *user)
{
    stream *s = user;
    s->write_status = ISO_OK;
    for (size_t i = 0; i < s->item_count && s->write_status == ISO_OK; ++i) {
        const write_item *w = &s->items[i];
        s->write_status = write_file(w->level, w->file, w->data, w->bytes, &s->write_error);
    }
    return NULL;
}

static iso_status wait_for_writer(stream *s, iso_error *err)
{
    if (!s->writing)
        return ISO_OK;
    const double start = iso_clock_seconds();
    pthread_join(s->writer, NULL);
    s->writing = false;
    s->report->seconds_write += iso_clock_seconds() - start;
    if (s->write_status != ISO_OK && err)
        *err = s->write_error;
    return s->write_status;
}

/* Hands the active set to the writing thread; without one, writes. */
static iso_status start_writer(stream *s, iso_error *err)
{
    s->writing = pthread_create(&s->writer, NULL, write_items, s) == 0;
    if (s->writing)
        return ISO_OK;
    write_items(s);
    if (s->write_status != ISO_OK && err)
        *err = s->write_error;
    return s->write_status;
}

static void list_pointers(const iso_cascade_out *out, char *data[FILE_COUNT])
{
    data[FILE_SCALAR] = (char *)out->scalar;
    data[FILE_CODES] = (char *)out->codes;
    data[FILE_DIRECTIONS] = (char *)out->directions;
    data[FILE_MAGNITUDE] = (char *)out->magnitude;
}

/* Lists the planes of level k that are complete, for the writer. */
static void list_level(stream *s, size_t k, size_t complete)
{
    stream_level *l = &s->levels[k];
    char *data[FILE_COUNT];
    list_pointers(&l->set[s->active], data);
    if (!converts(s, k))
        data[FILE_SCALAR] = s->planes[s->active] +
                            (l->first - s->planes_first) * l->geometry.size[0] * l->geometry.size[1] * iso_type_bytes(l->type);
    l->written = complete > l->first ? complete - l->first : 0;
    for (int i = 0; i < FILE_COUNT && l->written > 0; ++i)
        if (l->files[i].stored)
            s->items[s->item_count++] = (write_item){l, i, data[i], l->written * file_plane_bytes(l, i)};
    l->first += l->written;
}

/* What the last slab began and did not complete goes on in the other set. */
static void copy_begun_planes(stream *s)
{
    for (size_t k = 0; k < s->level_count; ++k) {
        stream_level *l = &s->levels[k];
        char *to[FILE_COUNT], *from[FILE_COUNT];
        list_pointers(&l->set[s->active], to);
        list_pointers(&l->set[!s->active], from);
        for (int i = 0; i < FILE_COUNT; ++i) {
            const size_t plane = file_plane_bytes(l, i);
            if (to[i])
                memcpy(to[i], from[i] + l->written * plane, (l->capacity - l->written) * plane);
        }
    }
}

static iso_status write_carry(stream *s, size_t z, iso_error *err)
{
    size_t plane_floats;
    const float *carry = iso_cascade_carry(s->cascade, &plane_floats);
    const size_t planes = z >> iso_cascade_carry_level(s->cascade);
    if (!carry || planes <= s->carry_planes)
        return ISO_OK;
    iso_status status = iso_bigfile_write(s->carry, carry + s->carry_planes * plane_floats,
                                          (planes - s->carry_planes) * plane_floats * sizeof *carry, err);
    s->carry_planes = planes;
    return status;
}

/* Before progress.json says that the planes are there. */
static iso_status sync_files(stream *s, iso_error *err)
{
    iso_status status = wait_for_writer(s, err);
    if (status == ISO_OK && s->carry)
        status = iso_bigfile_sync(s->carry, err);
    for (size_t k = 0; k < s->level_count; ++k)
        for (int i = 0; i < FILE_COUNT && status == ISO_OK; ++i)
            if (s->levels[k].file[i])
                status = iso_bigfile_sync(s->levels[k].file[i], err);
    return status;
}

static iso_status do_slab(stream *s, size_t z0, size_t z1, iso_error *err)
{
    const size_t nz = s->header.geometry.size[2], reach = iso_cascade_reach(s->cascade);
    iso_status status = read_planes(s, z0 > reach ? z0 - reach : 0, z1 + reach < nz ? z1 + reach : nz, err);
    if (status != ISO_OK)
        return status;
    const iso_planes planes = {s->planes[s->active], s->header.type,
                               {s->header.geometry.size[0], s->header.geometry.size[1], nz}, s->planes_first,
                               s->planes_count};
    const double start = iso_clock_seconds();
    iso_cascade_out out[32];
    copy_begun_planes(s);
    for (size_t k = 0; k < s->level_count; ++k) {
        out[k] = s->levels[k].set[s->active];
        out[k].first = s->levels[k].first;
    }
    status = iso_cascade_feed(s->cascade, &planes, z0, z1, out, err);
    s->report->seconds_build += iso_clock_seconds() - start;
    if (status == ISO_OK)
        status = wait_for_writer(s, err);
    if (status != ISO_OK)
        return status;
    s->item_count = 0;
    for (size_t k = 0; k < s->level_count; ++k)
        list_level(s, k, iso_cascade_complete(s->cascade, k, z1));
    status = write_carry(s, z1, err);
    if (status == ISO_OK)
        status = start_writer(s, err);
    s->active = !s->active;
    return status;
}

/* Not after every small slab: the last blocks of the files are written each time. */
static bool progress_is_due(stream *s, size_t z)
{
    const size_t bytes = (z - s->progress_at) * input_plane_bytes(s);
    if (bytes < PROGRESS_BYTES && s->how->stop_after == 0)
        return false;
    s->progress_at = z;
    return true;
}

static iso_status run_slabs(stream *s, json_t *job, size_t done, const iso_progress *progress, iso_error *err)
{
    const size_t nz = s->header.geometry.size[2];
    iso_status status = ISO_OK;
    for (size_t z = iso_cascade_warm_up(s->cascade, done); z < nz && status == ISO_OK;) {
        const size_t end = z + s->slab < nz ? z + s->slab : nz;
        iso_progress_report(progress, "build", (double)z / (double)nz);
        status = do_slab(s, z, end, err);
        z = end;
        if (status == ISO_OK && z > done && z < nz && progress_is_due(s, z))
            status = sync_files(s, err) == ISO_OK ? save_progress(s, job, z, err) : ISO_E_IO;
        if (s->how->stop_after > 0 && z >= s->how->stop_after && z < nz)
            return iso_fail(err, ISO_E_PROGRAM, "stopped after %zu planes", z);
    }
    if (status == ISO_OK)
        status = wait_for_writer(s, err);
    iso_progress_report(progress, "build", 1);
    return status;
}

/* ---- from beginning to end ---- */

static iso_status set_up(stream *s, double *scale, iso_error *err)
{
    double range = 0;
    iso_status status = s->in->open(s->in->user, &s->source, err);
    if (status != ISO_OK)
        return status;
    s->header = *iso_source_volume(s->source);
    status = input_range(s, &range, err);
    *scale = iso_cascade_scale(&s->header.geometry, range);
    if (status == ISO_OK)
        status = iso_cascade_create(&s->header.geometry, s->header.type, s->opt, *scale, &s->cascade, err);
    if (status != ISO_OK)
        return status;
    iso_geometry g = s->header.geometry;
    s->level_count = iso_cascade_level_count(&g, s->opt);
    for (size_t k = 0; k < s->level_count; ++k) {
        stream_level *l = &s->levels[k];
        l->geometry = g;
        l->type = k == 0 ? iso_layout_type(s->header.type) : ISO_F32;
        iso_layout_files(s->opt, l->type, l->files);
        g = iso_geometry_coarser(&g);
    }
    s->direct = s->how->direct || iso_geometry_voxel_count(&s->header.geometry) * iso_type_bytes(s->header.type) >= DIRECT_BYTES;
    status = choose_slab(s, err);
    if (status == ISO_OK && !create_buffers(s))
        status = iso_fail(err, ISO_E_MEMORY, "%s: no memory for slabs of %zu planes", s->in->path, s->slab);
    return status;
}

/* Where the build begins: 0, or where a killed one stood. */
static iso_status begin(stream *s, const json_t *job, bool resumed, size_t *done, iso_error *err)
{
    const bool same = resumed && read_progress(s, job, done);
    if (!same) {
        *done = 0;
        iso_output_clear(&s->output);
    }
    for (size_t k = 0; k < s->level_count; ++k)
        s->levels[k].first = iso_cascade_complete(s->cascade, k, *done);
    s->report->resumed_at_plane = *done;
    iso_status status = open_files(s, err);
    if (status == ISO_OK)
        status = take_up_carry(s, *done, err);
    size_t plane_floats;
    if (status == ISO_OK && iso_cascade_carry(s->cascade, &plane_floats)) {
        char *path = iso_path_join(s->output.temp_path, CARRY_NAME);
        status = path ? iso_bigfile_open(path, s->direct, s->carry_planes * plane_floats * sizeof(float), &s->carry, err)
                      : iso_fail(err, ISO_E_MEMORY, "out of memory");
        free(path);
    }
    return status;
}

static iso_status close_files(stream *s, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t k = 0; k < s->level_count; ++k)
        for (int i = 0; i < FILE_COUNT; ++i) {
            stream_level *l = &s->levels[k];
            if (l->hash[i])
                l->files[i].hash = XXH3_64bits_digest(l->hash[i]);
            iso_status closed = iso_bigfile_close(l->file[i], status == ISO_OK ? err : NULL);
            status = status == ISO_OK ? closed : status;
            l->file[i] = NULL;
        }
    iso_bigfile_abandon(s->carry);
    s->carry = NULL;
    return status;
}

static void remove_in(const char *dir, const char *name)
{
    char *path = iso_path_join(dir, name);
    if (path)
        unlink(path);
    free(path);
}

/* The description, last of all; then the folder gets its name. */
static iso_status finish(stream *s, iso_error *err)
{
    iso_status status = close_files(s, err);
    json_t *levels = json_array();
    s->report->level_count = s->level_count;
    s->report->slab_planes = s->slab;
    s->report->buffer_bytes = buffer_bytes(s, s->slab);
    for (size_t k = 0; k < s->level_count; ++k) {
        const stream_level *l = &s->levels[k];
        double lo, hi;
        iso_cascade_range(s->cascade, k, &lo, &hi);
        s->report->levels[k].geometry = l->geometry;
        s->report->levels[k].type = l->type;
        s->report->levels[k].min = lo;
        s->report->levels[k].max = hi;
        json_array_append_new(levels, iso_layout_level(&l->geometry, l->type, lo, hi, l->files, k));
    }
    remove_in(s->output.temp_path, PROGRESS_NAME);
    remove_in(s->output.temp_path, CARRY_NAME);
    if (status == ISO_OK)
        status = iso_layout_save(s->output.temp_path, s->in->path, s->opt, levels, err);
    else
        json_decref(levels);
    return status == ISO_OK ? iso_output_commit(&s->output, err) : status;
}

static void clean_up(stream *s, bool keep)
{
    wait_for_writer(s, NULL);
    close_files(s, NULL);
    for (size_t k = 0; k < 32; ++k) {
        stream_level *l = &s->levels[k];
        for (int set = 0; set < 2; ++set) {
            free(l->set[set].scalar);
            free(l->set[set].codes);
            free(l->set[set].directions);
            free(l->set[set].magnitude);
        }
        for (int i = 0; i < FILE_COUNT; ++i)
            XXH3_freeState(l->hash[i]);
    }
    free(s->planes[0]);
    free(s->planes[1]);
    iso_cascade_destroy(s->cascade);
    iso_source_close(s->source);
    if (keep)
        iso_output_keep(&s->output);
    else
        iso_output_abandon(&s->output);
}

iso_status iso_pyramid_stream(const iso_stream_input *in, const iso_pyramid_options *opt, const iso_stream_options *how,
                              const char *dir, iso_stream_report *report, const iso_progress *progress, iso_error *err)
{
    stream s = {.in = in, .opt = opt, .how = how, .report = report};
    *report = (iso_stream_report){0};
    const double start = iso_clock_seconds();
    double scale = 1;
    bool resumed = false;
    size_t done = 0;
    json_t *job = NULL;
    iso_status status = iso_pyramid_check_options(opt, err);
    if (status == ISO_OK)
        status = set_up(&s, &scale, err);
    if (status == ISO_OK)
        status = iso_output_resume_dir(&s.output, dir, ISO_PYRAMID_MARKER, how->resume, &resumed, err);
    if (status == ISO_OK) {
        job = describe_job(&s, scale);
        status = begin(&s, job, resumed, &done, err);
    }
    if (status == ISO_OK)
        status = run_slabs(&s, job, done, progress, err);
    if (status == ISO_OK)
        status = finish(&s, err);
    json_decref(job);
    clean_up(&s, status == ISO_E_PROGRAM);
    report->seconds_total = iso_clock_seconds() - start;
    return status;
}
