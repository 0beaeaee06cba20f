/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "povray/df3.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/parallel.h"

static size_t clamped(size_t padded, size_t size)
{
    size_t i = padded > 0 ? padded - 1 : 0;
    return i < size ? i : size - 1;
}

static void put_big_endian(uint8_t *out, uint32_t value, unsigned bytes)
{
    for (unsigned b = 0; b < bytes; ++b)
        out[b] = (uint8_t)(value >> (8 * (bytes - 1 - b)));
}

/* Encodes values as integers of `bits` bits; NaN becomes 0. In doubles, which hold 32 bits exactly. */
static void encode_values(const float *restrict values, size_t count, const iso_df3_coding *c, double *restrict out)
{
    const double most = (double)(UINT32_MAX >> (32 - c->bits)), lo = c->lo, range = c->hi - c->lo;
    const double used = range > 0 ? most : 0, divisor = range > 0 ? range : 1;
    for (size_t i = 0; i < count; ++i) {
        const double v = ((double)values[i] - lo) / divisor;
        out[i] = (v > 0 ? (v < 1 ? v : 1) : 0) * used + 0.5;
    }
}

static void put_samples(const double *restrict samples, size_t count, unsigned bits, uint8_t *restrict out)
{
    if (bits == 8)
        for (size_t i = 0; i < count; ++i)
            out[i] = (uint8_t)(int)samples[i];
    else if (bits == 16)
        for (size_t i = 0; i < count; ++i) {
            out[2 * i] = (uint8_t)((int)samples[i] >> 8);
            out[2 * i + 1] = (uint8_t)(int)samples[i];
        }
    else
        for (size_t i = 0; i < count; ++i)
            put_big_endian(out + i * (bits / 8), (uint32_t)samples[i], bits / 8);
}

/* Output of samples, one file per channel. */
typedef struct plane_writer {
    const iso_df3_source *source;
    const iso_df3_coding *coding;
    const char *const *paths;
    size_t rim, size[3]; /* of the files */
    size_t row_bytes;
    int threads;
    int files[ISO_DF3_MAX_CHANNELS];
} plane_writer;

/* Buffers of one thread for encoding a plane. */
typedef struct plane_buffers {
    uint8_t *planes; /* one per channel */
    float *values;   /* a row */
    double *samples; /* a row as read, and a row of one channel */
} plane_buffers;

static void free_buffers(plane_buffers *buffers)
{
    free(buffers->planes);
    free(buffers->values);
    free(buffers->samples);
}

static iso_status make_buffers(const plane_writer *w, plane_buffers *buffers, iso_error *err)
{
    const size_t channels = w->source->channels, plane = w->row_bytes * w->size[1], width = w->source->size[0] + 1;
    *buffers = (plane_buffers){.planes = malloc(channels * plane),
                               .values = malloc(width * channels * sizeof *buffers->values),
                               .samples = malloc(width * 2 * channels * sizeof *buffers->samples)};
    if (buffers->planes && buffers->values && buffers->samples)
        return ISO_OK;
    return iso_fail(err, ISO_E_MEMORY, "%s: no memory for a plane of %zu bytes", w->paths[0], plane);
}

static size_t source_index(const plane_writer *w, size_t at, int axis)
{
    return w->rim ? clamped(at, w->source->size[axis]) : at;
}

/* Repeats the first sample of a row, doubling the copied part each time. */
static void repeat_first(uint8_t *row, size_t bytes, size_t count)
{
    for (size_t done = 1, more; done < count; done += more) {
        more = done < count - done ? done : count - done;
        memcpy(row + done * bytes, row, more * bytes);
    }
}

/* Encodes voxels of a row, from x on, into row y of the plane. same: all equal the first. */
static void encode_run(const plane_writer *w, const plane_buffers *buffers, size_t y, size_t first, size_t x,
                       size_t count, bool same)
{
    const iso_df3_source *s = w->source;
    const size_t bytes = w->coding->bits / 8, n = same ? 1 : count;
    s->read(s->user, first + x, n, buffers->values);
    encode_values(buffers->values, n * s->channels, w->coding, buffers->samples);
    for (size_t c = 0; c < s->channels; ++c) {
        uint8_t *to = buffers->planes + (c * w->size[1] + y) * w->row_bytes + (w->rim + x) * bytes;
        double *of_channel = buffers->samples;
        if (s->channels > 1) {
            of_channel += n * s->channels;
            for (size_t i = 0; i < n; ++i)
                of_channel[i] = buffers->samples[i * s->channels + c];
        }
        put_samples(of_channel, n, w->coding->bits, to);
        if (same)
            repeat_first(to, bytes, count);
    }
}

/* Encodes row y of the file's plane z, with its rim of edge values. */
static void encode_row(const plane_writer *w, const plane_buffers *buffers, size_t y, size_t z)
{
    const iso_df3_source *s = w->source;
    const size_t size = s->size[0], bytes = w->coding->bits / 8;
    const size_t first = size * (source_index(w, y, 1) + s->size[1] * source_index(w, z, 2));
    for (size_t x = 0, count; x < size; x += count) {
        bool same = false;
        count = s->run ? s->run(s->user, first + x, size - x, &same) : size;
        encode_run(w, buffers, y, first, x, count, same);
    }
    for (size_t c = 0; c < s->channels && w->rim; ++c) {
        uint8_t *row = buffers->planes + (c * w->size[1] + y) * w->row_bytes;
        memcpy(row, row + bytes, bytes);
        memcpy(row + (size + 1) * bytes, row + size * bytes, bytes);
    }
}

enum { HEADER_BYTES = 6 };

static iso_status write_at(const plane_writer *w, size_t channel, const uint8_t *bytes, size_t count, size_t at,
                           iso_error *err)
{
    for (size_t done = 0; done < count;) {
        const ssize_t n = pwrite(w->files[channel], bytes + done, count - done, (off_t)(at + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return iso_fail(err, n < 0 ? iso_errno_status() : ISO_E_IO, "%s: cannot be written: %s", w->paths[channel],
                            n < 0 ? strerror(errno) : "nothing was taken");
        done += (size_t)n;
    }
    return ISO_OK;
}

static iso_status write_plane(const plane_writer *w, const plane_buffers *buffers, size_t z, iso_error *err)
{
    const size_t bytes = w->row_bytes * w->size[1];
    for (size_t c = 0; c < w->source->channels; ++c)
        NEED(write_at(w, c, buffers->planes + c * bytes, bytes, HEADER_BYTES + z * bytes, err));
    return ISO_OK;
}

/* Writes planes [begin, end): each thread encodes a plane and writes it at its position, without waiting for others. */
static iso_status write_slab(const plane_writer *w, size_t begin, size_t end, iso_error *err)
{
    iso_status status = ISO_OK; /* of the first failed plane */
#pragma omp parallel num_threads(w->threads)
    {
        plane_buffers buffers;
        iso_error trouble;
        iso_status own = make_buffers(w, &buffers, &trouble);
#pragma omp for schedule(dynamic)
        for (size_t z = begin; z < end; ++z) {
            for (size_t y = 0; own == ISO_OK && y < w->size[1]; ++y)
                encode_row(w, &buffers, y, z);
            if (own == ISO_OK)
                own = write_plane(w, &buffers, z, &trouble);
        }
#pragma omp critical(iso_df3_status)
        if (own != ISO_OK && status == ISO_OK) {
            status = own;
            if (err)
                *err = trouble;
        }
        free_buffers(&buffers);
    }
    return status;
}

static iso_status write_planes(const plane_writer *w, iso_error *err)
{
    const iso_df3_source *s = w->source;
    const size_t depth = w->size[2], slab = s->prepare ? s->planes : depth;
    for (size_t z = 0; z < depth; z += slab) {
        const size_t end = z + slab < depth ? z + slab : depth;
        if (s->prepare)
            NEED(s->prepare(s->prepare_user, source_index(w, z, 2), source_index(w, end - 1, 2) + 1, err));
        NEED(write_slab(w, z, end, err));
    }
    return ISO_OK;
}

static iso_status open_files(plane_writer *w, iso_error *err)
{
    uint8_t header[HEADER_BYTES];
    for (unsigned a = 0; a < 3; ++a)
        put_big_endian(header + 2 * a, (uint32_t)w->size[a], 2);
    for (size_t c = 0; c < ISO_DF3_MAX_CHANNELS; ++c)
        w->files[c] = -1;
    for (size_t c = 0; c < w->source->channels; ++c) {
        w->files[c] = open(w->paths[c], O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
        if (w->files[c] < 0)
            return iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", w->paths[c], strerror(errno));
        NEED(write_at(w, c, header, sizeof header, 0, err));
    }
    return ISO_OK;
}

static iso_status close_files(plane_writer *w, iso_status status, iso_error *err)
{
    for (size_t c = 0; c < w->source->channels; ++c)
        if (w->files[c] >= 0 && close(w->files[c]) != 0 && status == ISO_OK)
            status = iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", w->paths[c], strerror(errno));
    return status;
}

static iso_status write_files(const iso_df3_source *s, size_t rim, const char *const *paths,
                              const iso_df3_coding *coding, int threads, iso_error *err)
{
    plane_writer w = {.source = s, .coding = coding, .paths = paths, .rim = rim, .threads = iso_threads(threads)};
    for (int a = 0; a < 3; ++a) {
        const size_t size = s->size[a];
        if (size + 2 * rim > UINT16_MAX)
            return iso_fail(err, ISO_E_RANGE, "%s: size %zu x %zu x %zu, a DF3 file holds at most %zu along an axis",
                            paths[0], s->size[0], s->size[1], s->size[2], (size_t)UINT16_MAX - 2 * rim);
        w.size[a] = size + 2 * rim;
    }
    w.row_bytes = w.size[0] * (coding->bits / 8);
    iso_status status = open_files(&w, err);
    TRY(status, write_planes(&w, err));
    return close_files(&w, status, err);
}

/* Values in memory. */
typedef struct array {
    const float *values;
    size_t stride;
} array;

static void read_array(const void *user, size_t first, size_t count, float *out)
{
    const array *a = user;
    for (size_t i = 0; i < count; ++i)
        out[i] = a->values[(first + i) * a->stride];
}

iso_status iso_df3_write_from(const iso_df3_source *s, const char *const *paths, const iso_df3_coding *coding,
                              int threads, iso_error *err)
{
    return write_files(s, 1, paths, coding, threads, err);
}

iso_status iso_df3_write(const char *path, const size_t size[3], const float *values, size_t stride, size_t channel,
                         const iso_df3_coding *coding, iso_error *err)
{
    const array a = {values + channel, stride};
    const iso_df3_source s = {.size = {size[0], size[1], size[2]}, .channels = 1, .read = read_array, .user = &a};
    return write_files(&s, 1, &path, coding, 0, err);
}

iso_status iso_df3_write_table(const char *path, const size_t size[2], const float *values, size_t stride,
                               size_t channel, const iso_df3_coding *coding, iso_error *err)
{
    const array a = {values + channel, stride};
    const iso_df3_source s = {.size = {size[0], size[1], 1}, .channels = 1, .read = read_array, .user = &a};
    return write_files(&s, 0, &path, coding, 1, err);
}
