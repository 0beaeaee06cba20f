/* SPDX-License-Identifier: MIT */
/* mif_open.c - MRtrix images: lines of text, then the samples at the byte that "file: . BYTE" names; or in the file
 * that a .mih names. The world is right, anterior, superior.
 *
 * "layout" has the order of the axes in the file, 0 the fastest, and a minus for each that runs backward. */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "volume/reader.h"

enum { HEAD_BYTES = 1 << 16, MOST_AXES = 5, NAME_BYTES = 256 };

typedef struct mif {
    double size[MOST_AXES], spacing[MOST_AXES], matrix[3][4];
    size_t axis_count, rank[MOST_AXES]; /* place of an axis among the strides: 0 is the fastest */
    bool is_backward[MOST_AXES];
} mif;

/* Reads "-0,-1,+2": -0 is an axis, too. */
static bool read_layout(const char *text, mif *m)
{
    size_t seen = 0;
    for (size_t a = 0; a < m->axis_count; ++a) {
        char *end;
        text += text[0] == ',';
        text += strspn(text, " ");
        m->is_backward[a] = *text == '-';
        const long rank = labs(strtol(text, &end, 10));
        if (end == text || rank >= (long)m->axis_count)
            return false;
        m->rank[a] = (size_t)rank;
        seen |= (size_t)1 << rank;
        text = end;
    }
    return seen == ((size_t)1 << m->axis_count) - 1;
}

static iso_status take_axes(const char *text, const char *path, mif *m, iso_error *err)
{
    const char *dim = iso_reader_value(text, "dim:"), *layout = iso_reader_value(text, "layout:"), *line = text;
    m->axis_count = iso_reader_numbers(dim, m->size, MOST_AXES);
    for (size_t a = 0; a < MOST_AXES; ++a)
        m->spacing[a] = (double)NAN;
    iso_reader_numbers(iso_reader_value(text, "vox:"), m->spacing, MOST_AXES);
    while (m->axis_count > 3 && m->size[m->axis_count - 1] == 1)
        --m->axis_count;
    if (m->axis_count < 3 || m->axis_count > 4 || !layout || !read_layout(layout, m))
        return iso_fail(err, ISO_E_FORMAT, "%s: its axes are \"%.*s\" of layout \"%.*s\", must be 3, or 4 with frames",
                        path, dim ? (int)strcspn(dim, "\n") : 0, dim ? dim : "",
                        layout ? (int)strcspn(layout, "\n") : 0, layout ? layout : "");
    for (size_t a = 0; a < m->axis_count; ++a)
        if (!(m->size[a] >= 1 && m->size[a] < 1e9))
            return iso_fail(err, ISO_E_RANGE, "%s: axis %zu has size %g, must be 1 to 1e9", path, a + 1, m->size[a]);
    for (int r = 0; r < 3; ++r) {
        for (int a = 0; a < 4; ++a)
            m->matrix[r][a] = r == a;
        line = line ? iso_reader_value(line, "transform:") : NULL;
        if (line)
            iso_reader_numbers(line, m->matrix[r], 4);
    }
    return ISO_OK;
}

/* Places the file's grid: its axes in the order of their strides, backward ones turned around. */
static iso_status take_geometry(const mif *m, iso_volume_source *source, iso_error *err)
{
    double step[3][3], first[3];
    size_t size[3], at = 0;
    const size_t frame_rank = m->axis_count > 3 ? m->rank[3] : 3;
    for (int r = 0; r < 3; ++r)
        first[r] = m->matrix[r][3];
    for (size_t rank = 0; rank < m->axis_count; ++rank)
        for (size_t a = 0; a < 3; ++a) {
            if (m->rank[a] != rank || rank == frame_rank)
                continue;
            size[at] = (size_t)m->size[a];
            for (int r = 0; r < 3; ++r) {
                step[at][r] = (m->is_backward[a] ? -1 : 1) * m->matrix[r][a] * m->spacing[a];
                first[r] -= m->is_backward[a] ? step[at][r] * (m->size[a] - 1) : 0;
            }
            ++at;
        }
    source->header.notes.world_is_ras = true;
    return iso_reader_place(source, size, step, first, "mm", err);
}

static iso_status choose_frame(const mif *m, iso_volume_source *source, iso_error *err)
{
    iso_extra_axes axes = {.frame = {.count = 1, .stride = 1}};
    if (m->axis_count > 3) {
        if (m->rank[3] != 0 && m->rank[3] != 3)
            return iso_fail(err, ISO_E_FORMAT,
                            "%s: its frames stand between the axes of space; mrconvert -strides 1,2,3,4 "
                            "puts them last",
                            source->path);
        if (m->is_backward[3])
            return iso_fail(err, ISO_E_FORMAT, "%s: its frames run backward; mrconvert -strides 1,2,3,4 turns them",
                            source->path);
        axes.frame = (iso_extra_axis){.count = (size_t)m->size[3], .inside = m->rank[3] == 0, .stride = 1};
        axes.frame_step = m->spacing[3] > 0 ? m->spacing[3] : 0;
        snprintf(axes.frame_unit, sizeof axes.frame_unit, "s");
    }
    return iso_source_choose(source, &axes, err);
}

static iso_status take_type(const char *text, iso_volume_source *source, iso_error *err)
{
    const char *name = iso_reader_value(text, "datatype:");
    const size_t length = name ? strcspn(name, " \r\n") : 0;
    const bool is_big = length > 2 && strncmp(name + length - 2, "BE", 2) == 0,
               is_ordered = is_big || (length > 2 && strncmp(name + length - 2, "LE", 2) == 0);
    if (iso_reader_take_type(source, name ? name : "", length - (is_ordered ? 2 : 0))) {
        source->swap_bytes = is_ordered && is_big == (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
        return ISO_OK;
    }
    return iso_fail(err, ISO_E_FORMAT, "%s: its type is \"%.*s\", must be an integer or float of 8 to 64 bits",
                    source->path, (int)length, name ? name : "");
}

/* Opens the samples: in this file, or in one next to it. */
static iso_status take_samples(const char *text, iso_volume_source *source, iso_error *err)
{
    const char *file = iso_reader_value(text, "file:");
    char name[NAME_BYTES] = "";
    size_t offset = 0;
    double scaling[2] = {0, 1};
    if (!file || sscanf(file, "%255s %18zu", name, &offset) < 1 || strchr(name, '/'))
        return iso_fail(err, ISO_E_FORMAT, "%s: its samples are in \"%s\", must be this file or one in its folder",
                        source->path, name);
    if (iso_reader_numbers(iso_reader_value(text, "scaling:"), scaling, 2) == 2 && scaling[1] != 0) {
        source->header.notes.scale_intercept = scaling[0];
        source->header.notes.scale_slope = scaling[1];
    }
    if (strcmp(name, ".") == 0)
        return iso_source_take_part(source, source->path, offset, err);
    const char *base = iso_path_base(source->path);
    FREED char *beside = NULL;
    if (asprintf(&beside, "%.*s%s", (int)(base - source->path), source->path, name) < 0)
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", source->path);
    return iso_source_take_part(source, beside, offset, err);
}

static iso_status open_text(const char *text, iso_volume_source *source, iso_error *err)
{
    mif m = {0};
    NEED(take_axes(text, source->path, &m, err));
    NEED(take_type(text, source, err));
    NEED(take_geometry(&m, source, err));
    NEED(choose_frame(&m, source, err));
    return take_samples(text, source, err);
}

static iso_status open_mif(iso_volume_source *source, iso_error *err)
{
    size_t got;
    FREED char *text = calloc(1, HEAD_BYTES + 1);
    NEED(text ? iso_reader_head(source->path, text, HEAD_BYTES, &got, err)
              : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", source->path));
    char *end = strstr(text, "\nEND"); /* a header of its own ends with its file */
    if (!end && (got == HEAD_BYTES || !iso_reader_value(text, "file:")))
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated: no line END in the first %d bytes", source->path,
                        HEAD_BYTES);
    if (end)
        end[1] = 0;
    return open_text(text, source, err);
}

const iso_volume_format iso_volume_format_mif = {
    .name = "mif",
    .title = "MRtrix",
    .summary = "one file (.mif) or a header with its samples (.mih), with frames, plane by plane",
    .suffixes = ".mif .mih .mif.gz",
    .starts = "\"mrtrix image\"",
    .marks = {ISO_MARK(0, "mrtrix image\n")},
    .open = open_mif,
};
