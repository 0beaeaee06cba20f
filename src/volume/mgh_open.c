/* SPDX-License-Identifier: MIT */
/* mgh_open.c - FreeSurfer's MGH, and MGZ, which is MGH packed by gzip: 284 bytes of header, all big-endian, then the
 * samples, frame after frame, then the repetition time in ms and other numbers of the scan.
 *
 * The world is right, anterior, superior. The header has directions, and the place of the voxel (nx/2, ny/2, nz/2). */
#define _GNU_SOURCE

#include "volume/reader.h"

/* Places of the header's numbers. */
enum { SIZE = 4, FRAMES = 16, TYPE = 20, IS_PLACED = 28, SPACING = 30, COSINES = 42, CENTER = 78, HEADER_BYTES = 284 };

static const struct {
    unsigned code;
    iso_type type;
} types[] = {{0, ISO_U8}, {1, ISO_I32}, {3, ISO_F32}, {4, ISO_I16}, {10, ISO_U16}};

static bool take_type(const unsigned char *head, iso_type *type)
{
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i)
        if (iso_reader_number(head + TYPE, 4) == types[i].code) {
            *type = types[i].type;
            return true;
        }
    return false;
}

/* True for version 1, a known type, and sizes that a volume may have. */
static bool starts_like_mgh(const unsigned char *head, size_t size)
{
    iso_type type;
    bool is_one = size >= HEADER_BYTES && iso_reader_number(head, 4) == 1 && take_type(head, &type) &&
                  iso_reader_number(head + IS_PLACED, 2) <= 1;
    for (int i = 0; i < 4 && is_one; ++i)
        is_one = iso_reader_number(head + SIZE + 4 * i, 4) - 1 < 1 << 24;
    return is_one;
}

static iso_status take_geometry(const unsigned char *head, iso_volume_source *source, iso_error *err)
{
    /* Without a place: coronal slices of 1 mm around the origin, as FreeSurfer has it. */
    double step[3][3] = {{-1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, first[3] = {0, 0, 0};
    const bool is_placed = iso_reader_number(head + IS_PLACED, 2) == 1;
    size_t size[3];
    for (int a = 0; a < 3; ++a) {
        size[a] = (size_t)iso_reader_number(head + SIZE + 4 * a, 4);
        for (int r = 0; r < 3 && is_placed; ++r)
            step[a][r] = iso_reader_float(head + SPACING + 4 * a) * iso_reader_float(head + COSINES + 12 * a + 4 * r);
    }
    for (int r = 0; r < 3; ++r) {
        first[r] = is_placed ? iso_reader_float(head + CENTER + 4 * r) : 0;
        for (int a = 0; a < 3; ++a)
            first[r] -= step[a][r] * (double)size[a] / 2;
    }
    source->header.notes.world_is_ras = true;
    return iso_reader_place(source, size, step, first, "mm", err);
}

/* Returns the repetition time, which stands after the samples; 0: it is missing. */
static double repetition_ms(const iso_volume_source *source, size_t frames)
{
    unsigned char bytes[4] = {0};
    const double at = HEADER_BYTES + (double)iso_geometry_voxel_count(&source->header.geometry) *
                                         (double)iso_type_bytes(source->header.type) * (double)frames;
    FILE *f = at < 1e18 ? fopen(source->path, "rb") : NULL;
    const bool is_there = f && fseeko(f, (off_t)at, SEEK_SET) == 0 && fread(bytes, 1, 4, f) == 4;
    if (f)
        fclose(f);
    const double ms = is_there ? iso_reader_float(bytes) : 0;
    return ms > 0 && ms < 1e9 ? ms : 0;
}

static iso_status open_mgh(iso_volume_source *source, iso_error *err)
{
    char head[HEADER_BYTES + 1];
    const unsigned char *bytes = (const unsigned char *)head;
    size_t got;
    NEED(iso_reader_head(source->path, head, HEADER_BYTES, &got, err));
    if (got < HEADER_BYTES || !take_type(bytes, &source->header.type))
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated: %zu bytes, an MGH header has %d", source->path, got,
                        HEADER_BYTES);
    NEED(take_geometry(bytes, source, err));
    iso_extra_axes axes = {.frame = {.count = (size_t)iso_reader_number(bytes + FRAMES, 4), .stride = 1},
                           .frame_unit = "ms"};
    axes.frame_step = axes.frame.count > 1 ? repetition_ms(source, axes.frame.count) : 0;
    NEED(iso_source_choose(source, &axes, err));
    source->swap_bytes = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ && iso_type_bytes(source->header.type) > 1;
    return iso_source_take_part(source, source->path, HEADER_BYTES, err);
}

const iso_volume_format iso_volume_format_mgh = {
    .name = "mgh",
    .title = "FreeSurfer MGH and MGZ",
    .summary = "with frames, plane by plane",
    .suffixes = ".mgh .mgz .mgh.gz",
    .starts = "version 1 and a known type, big-endian",
    .probe = starts_like_mgh,
    .open = open_mgh,
};
