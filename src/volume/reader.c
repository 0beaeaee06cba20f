/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/reader.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

iso_status iso_reader_head(const char *path, char *head, size_t bytes, size_t *got, iso_error *err)
{
    ENDED_BY(iso_close_file) FILE *f = fopen(path, "rb");
    *got = 0;
    if (!f)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    *got = fread(head, 1, bytes, f);
    head[*got] = 0;
    return iso_source_check_read(f, path, ISO_OK, err);
}

bool iso_reader_may_hold(const char *path, const char *word)
{
    char head[4096 + 1];
    size_t got;
    return iso_reader_head(path, head, sizeof head - 1, &got, NULL) != ISO_OK || strstr(head, word);
}

bool iso_reader_is_named(const char *path, const char *ending)
{
    const size_t length = strlen(path), tail = strlen(ending);
    return length > tail && strcasecmp(path + length - tail, ending) == 0;
}

iso_status iso_reader_place(iso_volume_source *source, const size_t size[3], double step[3][3], const double first[3],
                            const char *unit, iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    double mm;
    NEED(iso_source_unit(source, unit, unit, &mm, err));
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

bool iso_reader_attribute(const char *tag, const char *name, char *out, size_t size)
{
    const char *end = tag ? strchr(tag, '>') : NULL;
    const size_t length = strlen(name);
    for (const char *at = tag; end && (at = strstr(at, name)) && at < end; at += length)
        if (isspace((unsigned char)at[-1]) && at[length] == '=' && (at[length + 1] == '"' || at[length + 1] == '\'')) {
            const char quote[2] = {at[length + 1], 0};
            snprintf(out, size, "%.*s", (int)strcspn(at + length + 2, quote), at + length + 2);
            return true;
        }
    *out = 0;
    return false;
}

bool iso_reader_take_type(iso_volume_source *source, const char *word, size_t length)
{
    static const struct {
        const char *words; /* each between two spaces */
        iso_type type;
        iso_form form;
    } types[] = {{" uint8 unsigned_char met_uchar ", ISO_U8, 0},
                 {" int8 char signed_char met_char ", ISO_I8, 0},
                 {" uint16 unsigned_short met_ushort ", ISO_U16, 0},
                 {" int16 short met_short ", ISO_I16, 0},
                 {" uint32 unsigned_int met_uint met_ulong ", ISO_U32, 0},
                 {" int32 int met_int met_long ", ISO_I32, 0},
                 {" float32 float met_float ", ISO_F32, 0},
                 {" float64 double met_double ", ISO_F64, 0},
                 {" float16 ", ISO_F32, ISO_FORM_HALF},
                 {" int64 vtktypeint64 met_long_long ", ISO_F64, ISO_FORM_I64},
                 {" uint64 vtktypeuint64 met_ulong_long ", ISO_F64, ISO_FORM_U64}};
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i)
        for (const char *at = types[i].words; *at && length > 0; ++at)
            if (at[0] == ' ' && strncasecmp(at + 1, word, length) == 0 && at[1 + length] == ' ') {
                source->header.type = types[i].type;
                if (types[i].form)
                    iso_source_set_form(source, types[i].form);
                return true;
            }
    return false;
}

iso_status iso_reader_need_type(iso_volume_source *source, const char *word, iso_error *err)
{
    return iso_reader_take_type(source, word, strlen(word))
               ? ISO_OK
               : iso_fail(err, ISO_E_FORMAT, "%s: type \"%s\", must be an integer, float or double", source->path,
                          word);
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
