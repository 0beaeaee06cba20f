/* SPDX-License-Identifier: MIT */
/* gipl_open.c - GIPL of Guy's Hospital: 256 bytes of header, most significant byte first, then the samples; all of
 * it may be packed by gzip. ITK reads it, too, but gives zeros for the missing end of a truncated file. */
#define _GNU_SOURCE
#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>

#include "volume/stream_kernel.h"

/* Byte offsets. */
enum { SIZE = 0, TYPE = 8, SPACING = 10, ORIGIN = 204, MAGIC = 252, HEADER_BYTES = 256 };

static uint64_t big_endian(const unsigned char *at, size_t bytes)
{
    uint64_t value = 0;
    for (size_t b = 0; b < bytes; ++b)
        value = value << 8 | at[b];
    return value;
}

static double real32(const unsigned char *at)
{
    const uint32_t bits = (uint32_t)big_endian(at, 4);
    float value;
    memcpy(&value, &bits, 4);
    return (double)value;
}

static double real64(const unsigned char *at)
{
    const uint64_t bits = big_endian(at, 8);
    double value;
    memcpy(&value, &bits, 8);
    return value;
}

static iso_status take_type(unsigned code, iso_volume_source *source, iso_error *err)
{
    switch (code) {
    case 7: source->header.type = ISO_I8; return ISO_OK;
    case 8: source->header.type = ISO_U8; return ISO_OK;
    case 15: source->header.type = ISO_I16; return ISO_OK;
    case 16: source->header.type = ISO_U16; return ISO_OK;
    case 31: source->header.type = ISO_U32; return ISO_OK;
    case 32: source->header.type = ISO_I32; return ISO_OK;
    case 64: source->header.type = ISO_F32; return ISO_OK;
    case 65: source->header.type = ISO_F64; return ISO_OK;
    default:
        return iso_fail(err, ISO_E_FORMAT, "%s: type %u, must be an integer of 8, 16 or 32 bits, float or double",
                        source->path, code);
    }
}

/* Reads sizes and spacing; the axes point left, posterior, superior, as in ITK and 3D Slicer. */
static iso_status take_geometry(const unsigned char *head, iso_volume_source *source, iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    size_t size[3];
    double mm, spacing[3];
    NEED(iso_source_unit(source, "mm", "mm", &mm, err));
    if (big_endian(head + SIZE + 6, 2) > 1)
        return iso_fail(err, ISO_E_FORMAT, "%s: %zu time steps, must be one volume", source->path,
                        (size_t)big_endian(head + SIZE + 6, 2));
    for (int a = 0; a < 3; ++a) {
        size[a] = (size_t)big_endian(head + SIZE + 2 * a, 2);
        spacing[a] = real32(head + SPACING + 4 * a);
    }
    *g = iso_geometry_axis_aligned(size, (double[]){1, 1, 1});
    NEED(iso_source_take_spacing(source, spacing, err));
    const double sign[3] = {-mm, -mm, mm};
    double first[3];
    for (int a = 0; a < 3; ++a) {
        const double at = real64(head + ORIGIN + 8 * a);
        g->index_to_world.m[a][a] = sign[a] * spacing[a];
        first[a] = sign[a] * (isfinite(at) ? at : 0);
    }
    g->origin_mm = iso_sub(iso_v3(first[0], first[1], first[2]), iso_mul(g->index_to_world, iso_v3(0.5, 0.5, 0.5)));
    source->header.notes.world_is_ras = true;
    return iso_source_check_geometry(source, err);
}

static iso_status check_packed(const iso_volume_source *source, iso_error *err)
{
    struct stat st;
    if (stat(source->path, &st) != 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be read: %s", source->path, strerror(errno));
    return iso_source_check_packed(source, source->path, (double)st.st_size, ISO_SOURCE_DEFLATE_MOST, err);
}

static iso_status open_gipl(iso_volume_source *source, iso_error *err)
{
    unsigned char head[HEADER_BYTES];
    source->gz = gzopen(source->path, "rb");
    if (!source->gz)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", source->path, strerror(errno));
    if (gzread(source->gz, head, HEADER_BYTES) != HEADER_BYTES)
        return iso_source_check_read_gz(source->gz, source->path,
                                        iso_fail(err, ISO_E_FORMAT, "%s: truncated: a GIPL header has %d bytes",
                                                 source->path, HEADER_BYTES),
                                        err);
    NEED(take_type((unsigned)big_endian(head + TYPE, 2), source, err));
    NEED(take_geometry(head, source, err));
    source->swap_bytes = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__;
    if (!gzdirect(source->gz))
        return check_packed(source, err);
    gzclose(source->gz);
    source->gz = NULL;
    return iso_source_take_file(source, source->path, HEADER_BYTES, err);
}

const iso_volume_format iso_volume_format_gipl = {
    .name = "gipl",
    .title = "GIPL",
    .summary = "of Guy's Hospital, plane by plane, packed by gzip, too",
    .suffixes = ".gipl .gipl.gz",
    .starts = "0xefffe9b0 at byte 252",
    .unpacks = true,
    .marks = {ISO_MARK(MAGIC, "\xef\xff\xe9\xb0"), ISO_MARK(MAGIC, "\x2a\xe3\x89\xb8")},
    .open = open_gipl,
};
