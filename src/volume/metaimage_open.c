/* SPDX-License-Identifier: MIT */
/* metaimage_open.c - MetaImage (.mha, .mhd): lines "Key = value"; the last one, ElementDataFile, names the file of the
 * samples. Its world is left, posterior, superior, as in ITK and Slicer, whatever AnatomicalOrientation is. */
#define _GNU_SOURCE
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "volume/reader.h"

enum { LINE_BYTES = 4096 };

typedef struct metaimage {
    int axes, channels;
    size_t size[8];
    double steps[3][3], spacing[4], first[3]; /* steps[a]: the direction of axis a */
    double slope, intercept;
    char unit[32], type[32], file[LINE_BYTES];
    bool has_spacing, is_image, is_text, big_endian, compressed;
    long header_bytes; /* before the samples of a file of their own; -1: they are its end */
    size_t end;        /* of this header */
} metaimage;

static bool is_true(const char *text)
{
    return *text == 'T' || *text == 't' || *text == '1';
}

/* Reads one line of the header. Ignores keys that do not describe the volume. */
static void take(metaimage *m, const char *key, const char *value)
{
    static const char *const places[] = {"Offset", "Position", "Origin"};
    static const char *const turns[] = {"TransformMatrix", "Rotation", "Orientation"};
    double list[16];
    for (int i = 0; i < 3; ++i) {
        if (strcmp(key, places[i]) == 0 && iso_reader_numbers(value, list, 3) == 3)
            memcpy(m->first, list, sizeof m->first);
        const size_t count = strcmp(key, turns[i]) == 0 ? iso_reader_numbers(value, list, 16) : 0;
        const int axes = count == 9 ? 3 : count == 16 ? 4 : 0; /* of four axes those of space come first */
        for (int a = 0; a < 3 && axes; ++a)
            memcpy(m->steps[a], list + a * axes, sizeof m->steps[a]);
    }
    if (strcmp(key, "ObjectType") == 0)
        m->is_image = strcmp(value, "Image") == 0;
    else if (strcmp(key, "NDims") == 0)
        m->axes = atoi(value);
    else if (strcmp(key, "DimSize") == 0) {
        double sizes[8];
        const size_t count = iso_reader_numbers(value, sizes, 8);
        for (size_t a = 0; a < count; ++a)
            m->size[a] = sizes[a] >= 1 && sizes[a] < 1e18 ? (size_t)sizes[a] : 0;
    } else if (strcmp(key, "ElementSpacing") == 0 || (strcmp(key, "ElementSize") == 0 && !m->has_spacing))
        m->has_spacing = iso_reader_numbers(value, m->spacing, 4) >= 3;
    else if (strcmp(key, "ElementType") == 0)
        snprintf(m->type, sizeof m->type, "%s", value);
    else if (strcmp(key, "ElementNumberOfChannels") == 0)
        m->channels = atoi(value);
    else if (strcmp(key, "ElementToIntensityFunctionSlope") == 0)
        m->slope = strtod(value, NULL);
    else if (strcmp(key, "ElementToIntensityFunctionOffset") == 0)
        m->intercept = strtod(value, NULL);
    else if (strcmp(key, "DistanceUnits") == 0 && strcmp(value, "?") != 0)
        snprintf(m->unit, sizeof m->unit, "%s", value);
    else if (strcmp(key, "BinaryData") == 0)
        m->is_text = !is_true(value);
    else if (strcmp(key, "BinaryDataByteOrderMSB") == 0 || strcmp(key, "ElementByteOrderMSB") == 0)
        m->big_endian = is_true(value);
    else if (strcmp(key, "CompressedData") == 0)
        m->compressed = is_true(value);
    else if (strcmp(key, "HeaderSize") == 0)
        m->header_bytes = atol(value);
    else if (strcmp(key, "ElementDataFile") == 0)
        snprintf(m->file, sizeof m->file, "%s", value);
}

static char *trim(char *text)
{
    text += strspn(text, " \t");
    for (size_t n = strlen(text); n > 0 && isspace((unsigned char)text[n - 1]);)
        text[--n] = 0;
    return text;
}

static iso_status read_header(const char *path, metaimage *m, iso_error *err)
{
    char line[LINE_BYTES];
    *m = (metaimage){.channels = 1, .slope = 1, .is_image = true, .steps = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    ENDED_BY(iso_close_file) FILE *f = fopen(path, "rb");
    if (!f)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    while (!m->file[0] && fgets(line, sizeof line, f)) {
        char *equals = strchr(line, '=');
        if (!equals)
            break;
        *equals = 0;
        take(m, trim(line), trim(equals + 1));
    }
    m->end = (size_t)ftello(f);
    const iso_status status = iso_source_check_read(f, path, ISO_OK, err);
    return m->file[0] || status != ISO_OK
               ? status
               : iso_fail(err, ISO_E_FORMAT, "%s: truncated: the MetaImage header ends before ElementDataFile", path);
}

static iso_status choose(const metaimage *m, iso_volume_source *source, iso_error *err)
{
    const iso_extra_axes axes = {
        .frame = {.count = m->axes == 4 ? m->size[3] : 1, .stride = 1},
        .frame_step = m->spacing[3],
        .channel = {.count = (size_t)m->channels, .inside = true, .stride = 1},
        /* Three or four bytes count as colors, as ITK writes them. */
        .is_color = source->header.type == ISO_U8 && (m->channels == 3 || m->channels == 4),
    };
    return iso_source_choose(source, &axes, err);
}

static iso_status check_header(metaimage *m, const char *path, iso_error *err)
{
    while (m->axes > 3 && m->axes <= 8 && m->size[m->axes - 1] == 1)
        --m->axes;
    if (!m->is_image)
        return iso_fail(err, ISO_E_FORMAT, "%s: a MetaImage file of another ObjectType than Image", path);
    if (m->axes != 3 && m->axes != 4)
        return iso_fail(err, ISO_E_FORMAT, "%s: %d axes, a volume has 3, with time 4", path, m->axes);
    if (m->channels < 1)
        return iso_fail(err, ISO_E_FORMAT, "%s: %d components per voxel, must be at least 1", path, m->channels);
    if (m->is_text)
        return iso_fail(err, ISO_E_FORMAT, "%s: its samples are text (BinaryData = False), which is not read", path);
    if (strcmp(m->file, "LIST") == 0 || strchr(m->file, '%'))
        return iso_fail(err, ISO_E_FORMAT, "%s: its samples are in several files (%s), which is not read", path,
                        m->file);
    return ISO_OK;
}

static iso_status take_geometry(const metaimage *m, iso_volume_source *source, iso_error *err)
{
    iso_volume *header = &source->header;
    iso_geometry *g = &header->geometry;
    double mm;
    NEED(iso_source_unit(source, m->unit, "mm", &mm, err));
    double spacing[3]; /* three or four numbers, or none */
    for (int a = 0; a < 3; ++a)
        spacing[a] = m->has_spacing ? m->spacing[a] : (double)NAN;
    NEED(iso_source_take_spacing(source, spacing, err));
    *g = iso_geometry_axis_aligned(m->size, (double[]){1, 1, 1});
    const double sign[3] = {-mm, -mm, mm};
    for (int a = 0; a < 3; ++a)
        for (int r = 0; r < 3; ++r)
            g->index_to_world.m[r][a] = sign[r] * m->steps[a][r] * spacing[a];
    g->origin_mm = iso_sub(iso_v3(sign[0] * m->first[0], sign[1] * m->first[1], sign[2] * m->first[2]),
                           iso_mul(g->index_to_world, iso_v3(0.5, 0.5, 0.5)));
    header->notes.world_is_ras = true;
    if (m->slope != 0 && isfinite(m->slope) && isfinite(m->intercept)) {
        header->notes.scale_slope = m->slope;
        header->notes.scale_intercept = m->intercept;
    }
    return iso_source_check_geometry(source, err);
}

/* Returns the path of the samples, relative to the header or the header itself; the caller frees it. */
static char *sample_path(const metaimage *m, const char *path, bool is_local)
{
    if (is_local || m->file[0] == '/')
        return strdup(is_local ? path : m->file);
    char *dir = iso_path_dir(path), *joined = dir ? iso_path_join(dir, m->file) : NULL;
    free(dir);
    return joined;
}

static iso_status open_samples(const metaimage *m, iso_volume_source *source, iso_error *err)
{
    const bool is_local = strcmp(m->file, "LOCAL") == 0 || strcmp(m->file, "local") == 0;
    FREED char *path = sample_path(m, source->path, is_local);
    size_t offset = is_local ? m->end : m->header_bytes > 0 ? (size_t)m->header_bytes : 0;
    struct stat st;
    NEED_MEMORY(path, err, "%s: out of memory", source->path);
    if (m->header_bytes == -1 && stat(path, &st) == 0 && (size_t)st.st_size >= iso_source_bytes(source))
        offset = (size_t)st.st_size - iso_source_bytes(source);
    source->swap_bytes = iso_type_bytes(source->header.type) > 1 &&
                         m->big_endian == (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
    return m->compressed ? iso_source_take_zlib(source, path, offset, err)
                         : iso_source_take_file(source, path, offset, err);
}

static iso_status open_metaimage(iso_volume_source *source, iso_error *err)
{
    metaimage m;
    NEED(read_header(source->path, &m, err));
    NEED(check_header(&m, source->path, err));
    NEED(iso_reader_need_type(source, m.type, err));
    NEED(take_geometry(&m, source, err));
    NEED(choose(&m, source, err));
    return open_samples(&m, source, err);
}

const iso_volume_format iso_volume_format_metaimage = {
    .name = "metaimage",
    .title = "MetaImage",
    .summary = ".mha, or .mhd with a file of samples, raw or zlib, read plane by plane",
    .suffixes = ".mha .mhd",
    .starts = "\"ObjectType\" or \"NDims\"",
    .marks = {ISO_MARK(0, "ObjectType"), ISO_MARK(0, "NDims")},
    .open = open_metaimage,
};
