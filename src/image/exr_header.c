/* SPDX-License-Identifier: MIT */
#include "image/exr_header.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum { MOST_NAME = 255, START = 8, MULTIPART = 0x1000 };

/* A file's bytes and the place that is read. */
typedef struct reader {
    const char *path, *data;
    size_t size, at;
} reader;

/* Of one header: edges of the data window and of a tile; tile[0] is 0 without tiles. */
typedef struct extents {
    uint64_t window[2], tile[2];
} extents;

static uint32_t number_at(const char *bytes)
{
    unsigned char b[4];
    memcpy(b, bytes, sizeof b);
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static iso_status fail_short(const reader *r, iso_error *err)
{
    return iso_fail(err, ISO_E_FORMAT, "%s: damaged OpenEXR picture: its header goes beyond the file's %zu bytes", r->path,
                    r->size);
}

/* Reads a name that a 0 ends. NULL: it is too long, or the file ends. */
static const char *take_name(reader *r)
{
    const char *name = r->data + r->at;
    const size_t most = r->size - r->at < MOST_NAME + 1 ? r->size - r->at : MOST_NAME + 1;
    const char *end = memchr(name, 0, most);
    if (!end)
        return NULL;
    r->at += (size_t)(end - name) + 1;
    return name;
}

/* Types whose values the library reads by the type and not by the attribute's size. Others are read by the size. */
static const struct {
    const char *type;
    size_t bytes;
} fixed[] = {
    {"box2i", 16},     {"box2f", 16}, {"chromaticities", 32}, {"compression", 1}, {"deepImageState", 1}, {"double", 8},
    {"envmap", 1},     {"float", 4},  {"int", 4},             {"keycode", 28},    {"lineOrder", 1},      {"m33f", 36},
    {"m33d", 72},      {"m44f", 64},  {"m44d", 128},          {"rational", 8},    {"tiledesc", 9},       {"timecode", 8},
    {"v2i", 8},        {"v2f", 8},    {"v2d", 16},            {"v3i", 12},        {"v3f", 12},           {"v3d", 24},
};

/* True if the strings, each after its length, fill the bytes. */
static bool is_string_list(const char *value, size_t bytes)
{
    size_t at = 0;
    while (bytes - at >= 4 && number_at(value + at) <= bytes - at - 4)
        at += 4 + number_at(value + at);
    return at == bytes;
}

/* True if the channels, each a name and 16 bytes, and the 0 after them fill the bytes. */
static bool is_channel_list(const char *value, size_t bytes)
{
    enum { AFTER_NAME = 16 };
    size_t at = 0;
    while (at < bytes && value[at]) {
        const char *end = memchr(value + at, 0, bytes - at);
        if (!end || bytes - (size_t)(end - value) < 1 + AFTER_NAME)
            return false;
        at = (size_t)(end - value) + 1 + AFTER_NAME;
    }
    return at + 1 == bytes;
}

/* True if the library reads as many bytes as the attribute has. */
static bool has_own_size(const char *type, const char *value, size_t bytes)
{
    for (size_t i = 0; i < sizeof fixed / sizeof *fixed; ++i)
        if (strcmp(type, fixed[i].type) == 0)
            return bytes == fixed[i].bytes;
    if (strcmp(type, "preview") == 0)
        return bytes >= 8 && (bytes - 8) % 4 == 0 &&
               (uint64_t)number_at(value) * number_at(value + 4) == (bytes - 8) / 4;
    if (strcmp(type, "stringvector") == 0)
        return is_string_list(value, bytes);
    return strcmp(type, "chlist") != 0 || is_channel_list(value, bytes);
}

static void note_extents(const char *name, const char *value, size_t bytes, extents *e)
{
    if (strcmp(name, "dataWindow") == 0 && bytes == 16)
        for (int a = 0; a < 2; ++a)
            e->window[a] = (uint64_t)((int64_t)(int32_t)number_at(value + 8 + 4 * a) -
                                      (int64_t)(int32_t)number_at(value + 4 * a) + 1);
    if (strcmp(name, "tiles") == 0 && bytes == 9)
        for (int a = 0; a < 2; ++a)
            e->tile[a] = number_at(value + 4 * a);
}

static iso_status check_attribute(reader *r, extents *e, iso_error *err)
{
    const char *name = take_name(r), *type = name ? take_name(r) : NULL;
    if (!type || r->size - r->at < 4)
        return fail_short(r, err);
    const uint32_t bytes = number_at(r->data + r->at);
    const char *value = r->data + r->at + 4;
    r->at += 4;
    if (bytes > r->size - r->at || !has_own_size(type, value, bytes))
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: damaged OpenEXR picture: its attribute \"%.64s\" of type %.64s has %u bytes, which does not fit",
                        r->path, name, type, bytes);
    note_extents(name, value, bytes, e);
    r->at += bytes;
    return ISO_OK;
}

/* Returns the number of tiles, rounded up. */
static uint64_t count_tiles(uint64_t window, uint64_t tile)
{
    return (window - 1) / tile + 1;
}

static iso_status check_tiles(const reader *r, const extents *e, iso_error *err)
{
    const uint64_t most = r->size / 8, edge = UINT64_C(1) << 31;
    if (e->tile[0] == 0 || e->tile[1] == 0 || e->window[0] - 1 >= edge || e->window[1] - 1 >= edge)
        return ISO_OK; /* the library refuses such windows and tiles */
    const uint64_t columns = count_tiles(e->window[0], e->tile[0]), rows = count_tiles(e->window[1], e->tile[1]);
    return columns <= most && rows <= most && columns * rows <= most
               ? ISO_OK
               : iso_fail(err, ISO_E_FORMAT,
                          "%s: damaged OpenEXR picture: its header has %llu x %llu tiles, more than %zu bytes can list", r->path,
                          (unsigned long long)columns, (unsigned long long)rows, r->size);
}

static iso_status check_one(reader *r, iso_error *err)
{
    extents e = {0};
    while (r->at < r->size && r->data[r->at])
        NEED(check_attribute(r, &e, err));
    if (r->at >= r->size)
        return fail_short(r, err);
    ++r->at;
    return check_tiles(r, &e, err);
}

iso_status iso_exr_header_check(const char *path, const char *data, size_t size, iso_error *err)
{
    reader r = {path, data, size, START};
    if (size <= START)
        return fail_short(&r, err);
    const bool has_parts = number_at(data + 4) & MULTIPART;
    iso_status status = check_one(&r, err);
    while (status == ISO_OK && has_parts && r.at < size && data[r.at])
        status = check_one(&r, err);
    return status;
}
