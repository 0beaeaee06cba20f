/* SPDX-License-Identifier: MIT */
/* mrc_open.c - MRC2014 and CCP4 maps of electron microscopy and crystallography [cheng-2015]: 1024 bytes of header,
 * an extended header, then the samples. Lengths are angstrom; the unit cell may be oblique. */
#define _GNU_SOURCE
#include <math.h>
#include <string.h>

#include "volume/stream_kernel.h"

/* Words of four bytes, numbered from 0 (the format counts from 1). */
enum {
    MODE = 3,
    START = 4,
    CELL_SAMPLES = 7,
    CELL = 10,
    ANGLES = 13,
    AXES = 16,
    SPACE_GROUP = 22,
    EXTENDED = 23,
    IMOD_STAMP = 38,
    IMOD_FLAGS = 39,
    ORIGIN = 49,
    MAP = 52,
    HEADER_BYTES = 1024,
    MAP_AT = 4 * MAP
};

typedef struct mrc {
    int32_t word[256];
    bool swapped;
} mrc;

static float real(const mrc *m, int word)
{
    float value;
    memcpy(&value, &m->word[word], 4);
    return value;
}

static iso_status read_header(FILE *f, const char *path, mrc *m, iso_error *err)
{
    const size_t n = fread(m->word, 1, HEADER_BYTES, f);
    if (n != HEADER_BYTES)
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated: %zu bytes, an MRC header has %d", path, n, HEADER_BYTES);
    /* The machine stamp is not always right; a mode or an axis that is large in one order is small in the other. */
    m->swapped = m->word[MODE] < 0 || m->word[MODE] > 0xffff || m->word[AXES] > 0xffff;
    for (int i = 0; m->swapped && i < 256; ++i)
        if (i < MAP || i > MAP + 1)
            m->word[i] = (int32_t)__builtin_bswap32((uint32_t)m->word[i]);
    for (int a = 0; a < 3; ++a)
        if (m->word[a] < 1)
            return iso_fail(err, ISO_E_RANGE, "%s: axis %d has size %d, must be at least 1", path, a + 1, m->word[a]);
    if (m->word[EXTENDED] < 0)
        return iso_fail(err, ISO_E_RANGE, "%s: an extended header of %d bytes", path, m->word[EXTENDED]);
    return m->word[SPACE_GROUP] < 401 ? ISO_OK
                                      : iso_fail(err, ISO_E_FORMAT, "%s: a stack of volumes, must be one", path);
}

/* True if bytes are unsigned: IMOD's are, until its version of 2012, which sets a bit if they are signed. MRC2014's are
 * signed. */
static bool bytes_are_unsigned(const mrc *m)
{
    return m->word[IMOD_STAMP] == 1146047817 && (m->word[IMOD_FLAGS] & 1) == 0;
}

static iso_status take_type(const mrc *m, iso_volume_source *source, iso_error *err)
{
    switch (m->word[MODE]) {
    case 0: source->header.type = bytes_are_unsigned(m) ? ISO_U8 : ISO_I8; return ISO_OK;
    case 1: source->header.type = ISO_I16; return ISO_OK;
    case 2: source->header.type = ISO_F32; return ISO_OK;
    case 6: source->header.type = ISO_U16; return ISO_OK;
    case 12: iso_source_set_form(source, ISO_FORM_HALF); return ISO_OK;
    default:
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: mode %d, must be 0, 1, 2, 6 or 12: an integer of 8 or 16 bits, float or half, not complex",
                        source->path, m->word[MODE]);
    }
}

/* Computes the edges of the unit cell: a along x, b in the plane of x and y. */
static void cell_edges(const mrc *m, const double length[3], double edge[3][3])
{
    double cosine[3];
    for (int i = 0; i < 3; ++i) {
        const double degrees = real(m, ANGLES + i);
        cosine[i] = degrees > 0 && degrees < 180 && degrees != 90 ? cos(degrees * M_PI / 180) : 0;
    }
    const double sine = sqrt(1 - cosine[2] * cosine[2]), y = (cosine[0] - cosine[1] * cosine[2]) / sine;
    const double rows[3][3] = {{1, 0, 0},
                               {cosine[2], sine, 0},
                               {cosine[1], y, sqrt(fmax(0, 1 - cosine[1] * cosine[1] - y * y))}};
    for (int i = 0; i < 3; ++i)
        for (int r = 0; r < 3; ++r)
            edge[i][r] = length[i] * rows[i][r];
}

/* Takes the geometry. The file's axes (columns, rows, sections) are the cell's in the order of AXES. */
static iso_status take_geometry(const mrc *m, iso_volume_source *source, iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    const size_t size[3] = {(size_t)m->word[0], (size_t)m->word[1], (size_t)m->word[2]};
    double mm, edge[3][3];
    int seen = 0;
    NEED(iso_source_unit(source, "angstrom", "angstrom", &mm, err));
    *g = iso_geometry_axis_aligned(size, (double[]){1, 1, 1});
    double cell[3];
    for (int a = 0; a < 3; ++a) /* 0: absent */
        cell[a] = real(m, CELL + a) != 0 && m->word[CELL_SAMPLES + a] > 0 ? real(m, CELL + a) : (double)NAN;
    NEED(iso_source_take_spacing(source, cell, err));
    if (!(real(m, CELL) > 0 && m->word[CELL_SAMPLES] > 0))
        return ISO_OK; /* around its center */
    cell_edges(m, cell, edge);
    const iso_vec3 origin = iso_v3(real(m, ORIGIN), real(m, ORIGIN + 1), real(m, ORIGIN + 2));
    iso_vec3 first = iso_scale(origin, mm);
    for (int a = 0; a < 3; ++a) {
        const int axis = m->word[AXES + a] >= 1 && m->word[AXES + a] <= 3 ? m->word[AXES + a] - 1 : a;
        const double samples = m->word[CELL_SAMPLES + axis] > 0 ? m->word[CELL_SAMPLES + axis] : 1;
        seen |= 1 << axis;
        for (int r = 0; r < 3; ++r)
            g->index_to_world.m[r][a] = mm * edge[axis][r] / samples;
        /* Where ORIGIN is not used, START is: in samples. */
        if (iso_norm(origin) == 0)
            first = iso_madd(first, iso_column(g->index_to_world, a), m->word[START + a]);
    }
    if (seen != 7)
        return iso_fail(err, ISO_E_FORMAT, "%s: axes %d, %d, %d, must be 1, 2 and 3 in some order", source->path,
                        m->word[AXES], m->word[AXES + 1], m->word[AXES + 2]);
    g->origin_mm = iso_sub(first, iso_mul(g->index_to_world, iso_v3(0.5, 0.5, 0.5)));
    return iso_source_check_geometry(source, err);
}

static iso_status read_mrc(FILE *f, iso_volume_source *source, iso_error *err)
{
    mrc m = {0};
    NEED(read_header(f, source->path, &m, err));
    NEED(take_type(&m, source, err));
    NEED(take_geometry(&m, source, err));
    source->swap_bytes = m.swapped && m.word[MODE] != 0;
    return iso_source_take_file(source, source->path, HEADER_BYTES + (size_t)m.word[EXTENDED], err);
}

const iso_volume_format iso_volume_format_mrc = {
    .name = "mrc",
    .title = "MRC and CCP4",
    .summary = "maps in angstrom, oblique cells too; modes 0, 1, 2, 6 and 12, plane by plane",
    .suffixes = ".mrc .map .ccp4 .rec",
    .starts = "\"MAP \" at byte 208",
    .marks = {ISO_MARK(MAP_AT, "MAP")},
    .read = read_mrc,
};
