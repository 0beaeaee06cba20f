/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/reader.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

iso_status iso_reader_head(const char *path, char *head, size_t bytes, size_t *got, iso_error *err)
{
    FILE *f = fopen(path, "rb");
    *got = 0;
    if (!f)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    *got = fread(head, 1, bytes, f);
    head[*got] = 0;
    const iso_status status = iso_source_check_read(f, path, ISO_OK, err);
    fclose(f);
    return status;
}

bool iso_reader_may_hold(const char *path, const char *word)
{
    char head[4096 + 1];
    size_t got;
    return iso_reader_head(path, head, sizeof head - 1, &got, NULL) != ISO_OK || strstr(head, word);
}

iso_status iso_reader_place(iso_volume_source *source, const size_t size[3], double step[3][3], const double first[3],
                            const char *unit, iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    double mm;
    const iso_status status = iso_source_unit(source, unit, unit, &mm, err);
    if (status != ISO_OK)
        return status;
    *g = iso_geometry_axis_aligned(size, (double[]){1, 1, 1});
    for (int a = 0; a < 3; ++a)
        for (int r = 0; r < 3; ++r)
            g->index_to_world.m[r][a] = mm * step[a][r];
    g->origin_mm = iso_sub(iso_scale(iso_v3(first[0], first[1], first[2]), mm),
                           iso_mul(g->index_to_world, iso_v3(0.5, 0.5, 0.5)));
    return iso_source_check_geometry(source, err);
}

uint64_t iso_reader_number(const unsigned char *at, size_t bytes)
{
    uint64_t value = 0;
    for (size_t i = 0; i < bytes; ++i)
        value = value << 8 | at[i];
    return value;
}

double iso_reader_float(const unsigned char *at)
{
    const uint32_t bits = (uint32_t)iso_reader_number(at, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

const char *iso_reader_value(const char *text, const char *key)
{
    const size_t length = strlen(key);
    for (const char *line = text; line; line = strchr(line, '\n')) {
        line += *line == '\n';
        if (strncmp(line, key, length) == 0)
            return line + length + strspn(line + length, " \t");
    }
    return NULL;
}

size_t iso_reader_numbers(const char *text, double *out, size_t most)
{
    size_t count = 0;
    char *end;
    for (const char *at = text; at && count < most; at = end) {
        at += strspn(at, " \t,");
        const double value = strtod(at, &end);
        if (end == at)
            break;
        out[count++] = value;
    }
    return count;
}
