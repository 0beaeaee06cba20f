/* SPDX-License-Identifier: MIT */
#include "povray/df3.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

static uint32_t encode_sample(double value, const iso_df3_coding *c)
{
    double most = (double)(UINT32_MAX >> (32 - c->bits));
    double v = c->hi > c->lo ? (value - c->lo) / (c->hi - c->lo) : 0;
    return (uint32_t)(fmin(fmax(v, 0), 1) * most + 0.5);
}

/* One row of the file, `rim` voxels of edge values at either end. */
static void encode_row(const float *restrict row, size_t count, size_t rim, size_t stride, const iso_df3_coding *c,
                       uint8_t *restrict out)
{
    unsigned bytes = c->bits / 8;
    for (size_t x = 0; x < count + 2 * rim; ++x) {
        size_t from = rim ? clamped(x, count) : x;
        put_big_endian(out + x * bytes, encode_sample((double)row[from * stride], c), bytes);
    }
}

/* What is written: samples of floats, with a rim of so many voxels. */
typedef struct density {
    const size_t *size;
    const float *values;
    size_t stride, rim;
    const iso_df3_coding *coding;
} density;

static iso_status write_samples(FILE *file, const char *path, const density *d, iso_error *err)
{
    const size_t *size = d->size, rim = d->rim;
    size_t rows_bytes = (size[0] + 2 * rim) * (d->coding->bits / 8);
    uint8_t *out = malloc(rows_bytes);
    if (!out)
        return iso_fail(err, ISO_E_MEMORY, "%s: no memory for a row of %zu bytes", path, rows_bytes);
    size_t ny = rim ? size[1] + 2 : size[1], nz = rim ? size[2] + 2 : size[2];
    uint8_t header[6];
    put_big_endian(header, (uint32_t)(size[0] + 2 * rim), 2);
    put_big_endian(header + 2, (uint32_t)ny, 2);
    put_big_endian(header + 4, (uint32_t)nz, 2);
    bool good = fwrite(header, 1, sizeof header, file) == sizeof header;
    for (size_t z = 0; z < nz && good; ++z) {
        for (size_t y = 0; y < ny && good; ++y) {
            size_t row = (rim ? clamped(z, size[2]) : z) * size[1] + (rim ? clamped(y, size[1]) : y);
            encode_row(d->values + row * size[0] * d->stride, size[0], rim, d->stride, d->coding, out);
            good = fwrite(out, 1, rows_bytes, file) == rows_bytes;
        }
    }
    free(out);
    return good ? ISO_OK : iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
}

static iso_status write_file(const char *path, const density *d, iso_error *err)
{
    const size_t *size = d->size, rim = d->rim;
    for (int a = 0; a < 3; ++a)
        if (size[a] + 2 * rim > UINT16_MAX)
            return iso_fail(err, ISO_E_RANGE, "%s: size %zu x %zu x %zu, a DF3 file holds at most %zu along an axis",
                            path, size[0], size[1], size[2], (size_t)UINT16_MAX - 2 * rim);
    FILE *file = fopen(path, "wb");
    if (!file)
        return iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
    iso_status status = write_samples(file, path, d, err);
    if (fclose(file) != 0 && status == ISO_OK)
        status = iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
    return status;
}

iso_status iso_df3_write(const char *path, const size_t size[3], const float *values, size_t stride, size_t channel,
                         const iso_df3_coding *coding, iso_error *err)
{
    return write_file(path, &(density){size, values + channel, stride, 1, coding}, err);
}

iso_status iso_df3_write_table(const char *path, const size_t size[2], const float *values, size_t stride,
                               size_t channel, const iso_df3_coding *coding, iso_error *err)
{
    const size_t whole[3] = {size[0], size[1], 1};
    return write_file(path, &(density){whole, values + channel, stride, 0, coding}, err);
}
