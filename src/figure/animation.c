/* SPDX-License-Identifier: MIT */
#include "figure/animation.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "compare/srgb.h"

struct iso_animation {
    FILE *file;
    size_t frames, added, width, height;
    uint32_t sequence; /* counts fcTL and fdAT */
    unsigned milliseconds;
};

static void put_u32(unsigned char *at, size_t value)
{
    for (int i = 0; i < 4; ++i)
        at[i] = (unsigned char)(value >> (24 - 8 * i));
}

/* Writes a chunk, returns true on success; the checksum covers the type and the data. */
static int put_chunk(FILE *f, const char type[4], const unsigned char *data, size_t size)
{
    unsigned char head[8], tail[4];
    put_u32(head, size);
    memcpy(head + 4, type, 4);
    uLong sum = crc32(crc32(0, NULL, 0), head + 4, 4);
    if (size > 0)
        sum = crc32(sum, data, (uInt)size);
    put_u32(tail, sum);
    return fwrite(head, 1, 8, f) == 8 && fwrite(data, 1, size, f) == size && fwrite(tail, 1, 4, f) == 4;
}

iso_status iso_animation_create(iso_animation **out, const char *path, size_t frames, double seconds, iso_error *err)
{
    iso_animation *a = *out = calloc(1, sizeof *a);
    if (!a)
        return iso_fail(err, ISO_E_MEMORY, "animation: out of memory");
    a->frames = frames;
    a->milliseconds = (unsigned)lrint(1000 * seconds);
    a->file = fopen(path, "wb");
    return a->file ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be written", path);
}

static int put_head(iso_animation *a)
{
    static const unsigned char signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    static const unsigned char perceptual[1] = {0};
    unsigned char size[13] = {0}, control[8] = {0}; /* the second number of acTL: 0 repeats endlessly */
    put_u32(size, a->width);
    put_u32(size + 4, a->height);
    size[8] = 8;
    size[9] = 2; /* RGB */
    put_u32(control, a->frames);
    return fwrite(signature, 1, 8, a->file) == 8 && put_chunk(a->file, "IHDR", size, 13) &&
           put_chunk(a->file, "sRGB", perceptual, 1) && put_chunk(a->file, "acTL", control, 8);
}

static int put_frame_control(iso_animation *a)
{
    unsigned char c[26] = {0};
    put_u32(c, a->sequence++);
    put_u32(c + 4, a->width);
    put_u32(c + 8, a->height);
    c[20] = (unsigned char)(a->milliseconds >> 8), c[21] = (unsigned char)a->milliseconds;
    c[22] = 1000 >> 8, c[23] = 1000 & 0xff;
    return put_chunk(a->file, "fcTL", c, sizeof c);
}

/* Returns the rows in PNG's form: a byte of the filter, "sub", then differences from the pixel on the left. */
static unsigned char *filter_rows(const iso_image *image)
{
    const size_t row = 1 + 3 * image->width;
    unsigned char *rows = malloc(row * image->height);
    for (size_t y = 0; y < image->height && rows; ++y) {
        unsigned char before[3] = {0};
        rows[y * row] = 1;
        for (size_t i = 0; i < 3 * image->width; ++i) {
            const float linear = image->rgba[4 * (y * image->width + i / 3) + i % 3];
            const unsigned char byte = (unsigned char)(iso_srgb_encode((double)linear) * 255 + 0.5);
            rows[y * row + 1 + i] = (unsigned char)(byte - before[i % 3]);
            before[i % 3] = byte;
        }
    }
    return rows;
}

/* Writes a frame. The first one is the PNG's own picture; the others have their number before the data. */
static int put_frame(iso_animation *a, const unsigned char *rows, size_t size)
{
    uLongf packed = compressBound(size);
    FREED unsigned char *data = malloc(4 + packed);
    const int first = a->added == 0;
    int whole = data && compress2(data + 4, &packed, rows, size, 6) == Z_OK && put_frame_control(a);
    if (whole && !first)
        put_u32(data, a->sequence++);
    whole = whole &&
            (first ? put_chunk(a->file, "IDAT", data + 4, packed) : put_chunk(a->file, "fdAT", data, 4 + packed));
    return whole;
}

iso_status iso_animation_add(iso_animation *a, const iso_image *image, iso_error *err)
{
    const size_t size = (1 + 3 * image->width) * image->height;
    if (a->added == 0)
        a->width = image->width, a->height = image->height;
    if (image->width != a->width || image->height != a->height)
        return iso_fail(err, ISO_E_RANGE, "animation: frames differ in size");
    unsigned char *rows = filter_rows(image);
    const int whole = rows && (a->added > 0 || put_head(a)) && put_frame(a, rows, size);
    free(rows);
    ++a->added;
    return whole ? ISO_OK : iso_fail(err, rows ? ISO_E_IO : ISO_E_MEMORY, "animation: cannot be written");
}

iso_status iso_animation_finish(iso_animation *a, iso_error *err)
{
    if (a->added != a->frames)
        return iso_fail(err, ISO_E_RANGE, "animation: %zu frames were added, not %zu", a->added, a->frames);
    const int whole = put_chunk(a->file, "IEND", (const unsigned char *)"", 0);
    const int closed = fclose(a->file) == 0;
    a->file = NULL;
    return whole && closed ? ISO_OK : iso_fail(err, ISO_E_IO, "animation: cannot be written");
}

void iso_animation_destroy(iso_animation *a)
{
    if (a && a->file)
        fclose(a->file);
    free(a);
}
