/* SPDX-License-Identifier: MIT */
/* afni_open.c - AFNI datasets: a .HEAD of attributes as text, and a .BRIK next to it, or a .BRIK.gz. Sub-bricks are
 * frames. The file's world is that of DICOM, left, posterior, superior. */
#define _GNU_SOURCE
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/inputs.h"
#include "volume/reader.h"

enum { MOST_HEAD = 16 << 20, MOST_FRAMES = 100000 };

/* Finds an attribute's values, which stand in the lines after its count; NULL: it is missing. */
static const char *find_values(const char *head, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = head; (at = strstr(at, name)); at += length) {
        const char *before = at;
        while (before > head && before[-1] == ' ')
            --before;
        const char *count = at[length] == '\n' ? strstr(at, "count") : NULL;
        if (before > head && before[-1] == '=' && count && count < at + length + 8)
            return strchr(count, '\n');
    }
    return NULL;
}

/* Reads at most `most` numbers of an attribute; returns their count. */
static size_t numbers_of(const char *head, const char *name, double *out, size_t most)
{
    const char *at = find_values(head, name);
    size_t count = 0;
    char *end;
    while (at && count < most) {
        const double value = strtod(at, &end);
        if (end == at)
            break;
        out[count++] = value;
        at = end;
    }
    return count;
}

static bool is_afni(const char *path)
{
    return iso_path_ends_with(path, ".HEAD") && iso_reader_may_hold(path, "-attribute");
}

/* Reads the grid: by the matrix of the dataset, or by its origin and steps along DICOM's axes. */
static iso_status take_geometry(const char *head, iso_volume_source *source, iso_error *err)
{
    double sizes[3], matrix[12], orient[3], origin[3], delta[3], step[3][3] = {{0}}, first[3] = {0};
    size_t size[3];
    if (numbers_of(head, "DATASET_DIMENSIONS", sizes, 3) != 3)
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: no DATASET_DIMENSIONS", source->path);
    for (int a = 0; a < 3; ++a) {
        if (!(sizes[a] >= 1 && sizes[a] < 1e9))
            return iso_fail(err, ISO_E_RANGE, "%s: axis %d has size %g, must be 1 to 1e9", source->path, a + 1,
                            sizes[a]);
        size[a] = (size_t)sizes[a];
    }
    const bool has_matrix = numbers_of(head, "IJK_TO_DICOM_REAL", matrix, 12) == 12;
    if (!has_matrix && (numbers_of(head, "ORIENT_SPECIFIC", orient, 3) != 3 ||
                        numbers_of(head, "ORIGIN", origin, 3) != 3 || numbers_of(head, "DELTA", delta, 3) != 3))
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: damaged: neither IJK_TO_DICOM_REAL nor ORIENT_SPECIFIC, ORIGIN and DELTA", source->path);
    for (int a = 0; a < 3; ++a) {
        const int axis = has_matrix ? 0 : orient[a] >= 0 && orient[a] < 6 ? (int)orient[a] / 2 : a;
        if (!has_matrix)
            step[a][axis] = delta[a], first[axis] = origin[a];
        for (int r = 0; r < 3 && has_matrix; ++r)
            step[a][r] = matrix[4 * r + a], first[r] = matrix[4 * r + 3];
    }
    for (int r = 0; r < 2; ++r) { /* to right and anterior */
        first[r] = -first[r];
        for (int a = 0; a < 3; ++a)
            step[a][r] = -step[a][r];
    }
    source->header.notes.world_is_ras = true;
    return iso_reader_place(source, size, step, first, "mm", err);
}

static iso_status take_type(const char *head, size_t frames, iso_volume_source *source, iso_error *err)
{
    double *codes = calloc(frames, sizeof *codes);
    NEED_MEMORY(codes, err, "%s: out of memory", source->path);
    const size_t count = numbers_of(head, "BRICK_TYPES", codes, frames);
    const double code = codes[0];
    bool is_same = count == frames;
    for (size_t i = 0; i < count; ++i)
        is_same = is_same && codes[i] == code;
    free(codes);
    if (!is_same || (code != 0 && code != 1 && code != 3))
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: BRICK_TYPES begins with %g, must be 0, 1 or 3 (byte, short, float) for all", source->path,
                        code);
    source->header.type = code == 0 ? ISO_U8 : code == 1 ? ISO_I16 : ISO_F32;
    const char *order = find_values(head, "BYTEORDER_STRING");
    const bool is_big = order && strncmp(order + strspn(order, "\n '"), "MSB", 3) == 0;
    source->swap_bytes = code != 0 && is_big == (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
    return ISO_OK;
}

static iso_status choose_frame(const char *head, size_t frames, iso_volume_source *source, iso_error *err)
{
    double times[2] = {0, 0}, units[3] = {0};
    iso_extra_axes axes = {.frame = {.count = frames, .stride = 1}};
    if (numbers_of(head, "TAXIS_FLOATS", times, 2) == 2 && times[1] > 0) {
        const bool is_ms = numbers_of(head, "TAXIS_NUMS", units, 3) == 3 && units[2] == 77001;
        axes.frame_step = times[1];
        snprintf(axes.frame_unit, sizeof axes.frame_unit, "%s", is_ms ? "ms" : "s");
    }
    NEED(iso_source_choose(source, &axes, err));
    const size_t k = source->choice.frame;
    FREED double *factors = calloc(k + 1, sizeof *factors);
    NEED_MEMORY(factors, err, "%s: out of memory", source->path);
    if (numbers_of(head, "BRICK_FLOAT_FACS", factors, k + 1) == k + 1 && factors[k] != 0)
        source->header.notes.scale_slope = factors[k];
    return ISO_OK;
}

/* Opens the .BRIK next to the header, or the packed one. */
static iso_status take_samples(iso_volume_source *source, iso_error *err)
{
    struct stat st;
    FREED char *brick = NULL;
    if (asprintf(&brick, "%.*s.BRIK.gz", (int)(strlen(source->path) - 5), source->path) < 0)
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", source->path);
    if (stat(brick, &st) != 0 || !S_ISREG(st.st_mode)) {
        brick[strlen(brick) - 3] = 0;
        return iso_source_take_file(source, brick, 0, err);
    }
    NEED(iso_inputs_note(brick, err));
    source->gz = gzopen(brick, "rb");
    if (!source->gz)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", brick, strerror(errno));
    return iso_source_check_packed(source, brick, (double)st.st_size, ISO_SOURCE_DEFLATE_MOST, err);
}

static iso_status open_head(const char *head, iso_volume_source *source, iso_error *err)
{
    double rank[2];
    if (numbers_of(head, "DATASET_RANK", rank, 2) != 2 || !(rank[1] >= 1 && rank[1] <= MOST_FRAMES))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: no DATASET_RANK with 1 to %d sub-bricks", source->path,
                        MOST_FRAMES);
    NEED(take_geometry(head, source, err));
    NEED(take_type(head, (size_t)rank[1], source, err));
    NEED(choose_frame(head, (size_t)rank[1], source, err));
    return take_samples(source, err);
}

static iso_status open_afni(iso_volume_source *source, iso_error *err)
{
    struct stat st;
    FREED char *head = NULL;
    size_t size;
    if (stat(source->path, &st) == 0 && st.st_size > MOST_HEAD)
        return iso_fail(err, ISO_E_FORMAT, "%s: a header of %.0f bytes, must be at most %d", source->path,
                        (double)st.st_size, MOST_HEAD);
    NEED(iso_file_read(source->path, &head, &size, err));
    return open_head(head, source, err);
}

const iso_volume_format iso_volume_format_afni = {
    .name = "afni",
    .title = "AFNI",
    .summary = "a .HEAD with its .BRIK or .BRIK.gz, sub-bricks as frames, plane by plane",
    .suffixes = ".HEAD",
    .starts = "attributes, named .HEAD",
    .probe_path = is_afni,
    .open = open_afni,
};
