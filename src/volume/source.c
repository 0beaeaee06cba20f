/* SPDX-License-Identifier: MIT */
/* source.c - opening by content, raw files, and reading planes. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "volume/stream_kernel.h"
#include "volume/unit.h"

/* zlib counts bytes in int. */
#define GZ_CHUNK_BYTES ((size_t)1 << 30)
#define DROP_BYTES ((size_t)4 << 20)

static iso_type stored_type(const iso_volume_source *source)
{
    return source->scaled ? source->stored : source->header.type;
}

size_t iso_source_bytes(const iso_volume_source *source)
{
    return iso_geometry_voxel_count(&source->header.geometry) * iso_type_bytes(stored_type(source));
}

iso_status iso_source_check_bytes(const iso_volume_source *source, double available, iso_error *err)
{
    const iso_geometry *g = &source->header.geometry;
    double need = (double)iso_source_bytes(source);
    if (available == need)
        return ISO_OK;
    return iso_fail(err, ISO_E_FORMAT, "%s: %s: holds %.0f bytes of samples, %zu x %zu x %zu of %s need %.0f",
                    source->path, available < need ? "truncated" : "too long", available, g->size[0], g->size[1],
                    g->size[2], iso_type_name(source->header.type), need);
}

iso_status iso_source_check_rest(const iso_volume_source *source, iso_error *err)
{
    struct stat st;
    const off_t at = ftello(source->file);
    if (at < 0 || fstat(fileno(source->file), &st) != 0)
        return iso_fail(err, ISO_E_IO, "%s: the samples cannot be read", source->path);
    return iso_source_check_bytes(source, (double)st.st_size - (double)at, err);
}

static iso_status open_at(iso_volume_source *source, const char *path, size_t offset, iso_error *err)
{
    source->file = fopen(path, "rb");
    if (!source->file)
        return iso_fail(err, ISO_E_IO, "%s: cannot be opened: %s", path, strerror(errno));
    if (fseeko(source->file, (off_t)offset, SEEK_SET) != 0)
        return iso_fail(err, ISO_E_IO, "%s: cannot be read at byte %zu", path, offset);
    return ISO_OK;
}

iso_status iso_source_take_part(iso_volume_source *source, const char *path, size_t offset, iso_error *err)
{
    struct stat st;
    const iso_status status = open_at(source, path, offset, err);
    if (status != ISO_OK)
        return status;
    if (fstat(fileno(source->file), &st) != 0)
        return iso_fail(err, ISO_E_IO, "%s: the samples cannot be read", path);
    const double there = (double)st.st_size - (double)offset;
    return there >= (double)iso_source_bytes(source) ? ISO_OK : iso_source_check_bytes(source, there, err);
}

iso_status iso_source_take_file(iso_volume_source *source, const char *path, size_t offset, iso_error *err)
{
    const iso_status status = open_at(source, path, offset, err);
    return status == ISO_OK ? iso_source_check_rest(source, err) : status;
}

iso_status iso_source_unit(iso_volume_source *source, const char *unit, const char *fallback, double *mm,
                           iso_error *err)
{
    iso_volume_notes *notes = &source->header.notes;
    const char *word = source->hints.unit ? source->hints.unit : unit && *unit ? unit : fallback, *name = "mm";
    if (!iso_unit_find(word, mm, &name))
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: its unit is \"%s\", not one that is known: " ISO_UNIT_NAMES "; --unit says it instead",
                        source->path, word);
    notes->unit_mm = *mm;
    if (source->hints.unit || (unit && *unit))
        snprintf(notes->unit, sizeof notes->unit, "%s", name);
    return ISO_OK;
}

iso_status iso_source_need_spacing(const iso_volume_source *source, const char *what, iso_error *err)
{
    if (source->hints.spacing_mm[0] > 0)
        return ISO_OK;
    return iso_fail(err, ISO_E_FORMAT, "%s: does not say the spacing %s; --spacing SXxSYxSZ does, in mm", source->path,
                    what);
}

/* Each axis as long as the hint says, around the center that the box has. */
static void apply_spacing(iso_volume_source *source)
{
    iso_geometry *g = &source->header.geometry;
    const iso_vec3 center = iso_geometry_box_center_mm(g);
    double spacing[3];
    iso_geometry_spacing_mm(g, spacing);
    if (!(source->hints.spacing_mm[0] > 0))
        return;
    for (int a = 0; a < 3; ++a)
        for (int r = 0; r < 3; ++r)
            g->index_to_world.m[r][a] *= source->hints.spacing_mm[a] / spacing[a];
    g->origin_mm = iso_add(g->origin_mm, iso_sub(center, iso_geometry_box_center_mm(g)));
}

static iso_status new_source(const char *path, const iso_volume_hints *hints, iso_volume_source **source,
                             iso_error *err)
{
    struct stat st;
    *source = NULL;
    if (stat(path, &st) != 0)
        return iso_fail(err, ISO_E_IO, "%s: cannot be opened: %s", path, strerror(errno));
    if (!S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode))
        return iso_fail(err, ISO_E_IO, "%s: is neither a regular file nor a folder", path);
    iso_volume_source *s = calloc(1, sizeof *s);
    if (s)
        s->path = strdup(path);
    if (!s || !s->path) {
        iso_source_close(s);
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    }
    s->header.notes.scale_slope = 1;
    s->header.notes.unit_mm = 1;
    if (hints)
        s->hints = *hints;
    *source = s;
    return ISO_OK;
}

/* The first bytes, unpacked where they are compressed. */
static iso_status read_head(const char *path, unsigned char head[ISO_VOLUME_HEAD_BYTES], size_t *size, iso_error *err)
{
    gzFile gz = gzopen(path, "rb");
    if (!gz)
        return iso_fail(err, ISO_E_IO, "%s: cannot be opened: %s", path, strerror(errno));
    int n = gzread(gz, head, ISO_VOLUME_HEAD_BYTES);
    *size = n > 0 ? (size_t)n : 0;
    gzclose(gz);
    return ISO_OK;
}

/* "NRRD (starts), ..." */
static void list_formats(char *text, size_t size)
{
    const iso_volume_format *f;
    size_t length = 0;
    text[0] = 0;
    for (size_t i = 0; (f = iso_volume_format_at(i)) && length < size; ++i)
        if (f->starts)
            length += (size_t)snprintf(text + length, size - length, "%s%s (%s)", length ? ", " : "", f->title,
                                       f->starts);
}

/* The file or folder that no format's first bytes name. */
static iso_status open_by_path(iso_volume_source *s, bool *found, iso_error *err)
{
    const iso_volume_format *f;
    *found = false;
    for (size_t i = 0; (f = iso_volume_format_at(i)) && !*found; ++i)
        if (f->probe_path && (*found = f->probe_path(s->path)))
            return f->open(s, err);
    return ISO_OK;
}

static iso_status open_by_content(iso_volume_source *s, iso_error *err)
{
    unsigned char head[ISO_VOLUME_HEAD_BYTES];
    size_t size = 0;
    bool found = false;
    if (iso_path_is_dir(s->path)) {
        const iso_status status = open_by_path(s, &found, err);
        return found ? status : iso_fail(err, ISO_E_FORMAT, "%s: a folder that holds no slices of a volume", s->path);
    }
    iso_status status = read_head(s->path, head, &size, err);
    if (status != ISO_OK)
        return status;
    if (size == 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: is empty", s->path);
    const iso_volume_format *f;
    for (size_t i = 0; (f = iso_volume_format_at(i)); ++i)
        if (f->probe && f->probe(head, size))
            return f->open(s, err);
    status = open_by_path(s, &found, err);
    if (found)
        return status;
    char shown[9] = "";
    for (size_t i = 0; i < 8 && i < size; ++i)
        shown[i] = head[i] >= 32 && head[i] < 127 ? (char)head[i] : '?';
    char known[512];
    list_formats(known, sizeof known);
    return iso_fail(err, ISO_E_FORMAT, "%s: starts with \"%s\", which is none of the formats that are read: %s",
                    s->path, shown, known);
}

iso_status iso_source_open(const char *path, iso_volume_source **source, iso_error *err)
{
    return iso_source_open_with(path, NULL, source, err);
}

iso_status iso_source_open_with(const char *path, const iso_volume_hints *hints, iso_volume_source **source,
                                iso_error *err)
{
    iso_status status = new_source(path, hints, source, err);
    if (status == ISO_OK)
        status = open_by_content(*source, err);
    if (status == ISO_OK)
        apply_spacing(*source);
    if (status != ISO_OK) {
        iso_source_close(*source);
        *source = NULL;
    }
    return status;
}

static iso_status open_raw(iso_volume_source *s, const iso_raw_layout *layout, iso_error *err)
{
    s->header.type = layout->type;
    s->header.geometry = iso_geometry_axis_aligned(layout->size, layout->spacing_mm);
    iso_status status = iso_geometry_check(&s->header.geometry, s->path, err);
    if (status != ISO_OK)
        return status;
    status = iso_source_take_file(s, s->path, layout->skip_bytes, err);
    s->swap_bytes = layout->big_endian == (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
    return status;
}

iso_status iso_source_open_raw(const char *path, const iso_raw_layout *layout, iso_volume_source **source,
                               iso_error *err)
{
    iso_status status = new_source(path, NULL, source, err);
    if (status == ISO_OK && iso_path_is_dir(path))
        status = iso_fail(err, ISO_E_IO, "%s: is not a regular file", path);
    if (status == ISO_OK)
        status = open_raw(*source, layout, err);
    if (status != ISO_OK) {
        iso_source_close(*source);
        *source = NULL;
    }
    return status;
}

const iso_volume_format iso_volume_format_raw = {
    .name = "raw",
    .title = "raw",
    .summary = "a file without a header, by --raw-size and --raw-type, plane by plane",
    .suffixes = ".raw",
};

const iso_volume *iso_source_volume(const iso_volume_source *source)
{
    return &source->header;
}

static void swap_samples(unsigned char *bytes, size_t sample_bytes, size_t count)
{
    if (sample_bytes == 2) {
        for (size_t i = 0; i < count; ++i) {
            uint16_t v;
            memcpy(&v, bytes + 2 * i, 2);
            v = __builtin_bswap16(v);
            memcpy(bytes + 2 * i, &v, 2);
        }
    } else if (sample_bytes == 4) {
        for (size_t i = 0; i < count; ++i) {
            uint32_t v;
            memcpy(&v, bytes + 4 * i, 4);
            v = __builtin_bswap32(v);
            memcpy(bytes + 4 * i, &v, 4);
        }
    } else if (sample_bytes == 8) {
        for (size_t i = 0; i < count; ++i) {
            uint64_t v;
            memcpy(&v, bytes + 8 * i, 8);
            v = __builtin_bswap64(v);
            memcpy(bytes + 8 * i, &v, 8);
        }
    }
}

static iso_status read_compressed(iso_volume_source *s, unsigned char *out, size_t bytes, iso_error *err)
{
    size_t done = 0;
    while (done < bytes) {
        size_t chunk = bytes - done < GZ_CHUNK_BYTES ? bytes - done : GZ_CHUNK_BYTES;
        int n = gzread(s->gz, out + done, (unsigned)chunk), code;
        const char *text = gzerror(s->gz, &code);
        /* All samples may be there though the file breaks off: zlib 1.3.2 forgets that with the next read. */
        s->gz_end_is_missing = s->gz_end_is_missing || code == Z_BUF_ERROR;
        if (n > 0)
            done += (size_t)n;
        if (n == (int)chunk)
            continue;
        if (code != Z_OK && code != Z_BUF_ERROR)
            return iso_fail(err, ISO_E_FORMAT, "%s: compressed samples are damaged: %s", s->path, text);
        size_t planes = s->header.geometry.size[2];
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated: the compressed samples end after plane %.2f of %zu", s->path,
                        (double)s->planes_done + (double)done / (double)iso_source_bytes(s) * (double)planes, planes);
    }
    return ISO_OK;
}

/* Compressed data must end with the last plane: more of it means wrong sizes,
 * and only the end shows a bad checksum. */
static iso_status check_compressed_end(iso_volume_source *s, iso_error *err)
{
    unsigned char extra;
    int n = gzread(s->gz, &extra, 1), code;
    const char *text = gzerror(s->gz, &code);
    if (n > 0)
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: too long: compressed samples go on after the %zu bytes that the sizes need", s->path,
                        iso_source_bytes(s));
    const bool end_is_missing = s->gz_end_is_missing || code == Z_BUF_ERROR;
    if (n < 0 || code != Z_OK || end_is_missing)
        return iso_fail(err, ISO_E_FORMAT, "%s: compressed samples are damaged: %s", s->path,
                        end_is_missing ? "the end is missing" : text);
    return ISO_OK;
}

/* A file that would fill much of the memory is read once: its pages leave the cache behind the reader, which then takes
 * the same few pages again instead of new ones, three times as fast on a virtual machine. */
static bool read_plain(iso_volume_source *s, char *out, size_t bytes)
{
    const size_t memory = (size_t)sysconf(_SC_PHYS_PAGES) * (size_t)sysconf(_SC_PAGESIZE);
    if (iso_source_bytes(s) < memory / 8)
        return fread(out, 1, bytes, s->file) == bytes;
    for (size_t done = 0; done < bytes; done += DROP_BYTES) {
        const size_t n = bytes - done < DROP_BYTES ? bytes - done : DROP_BYTES;
        const off_t at = ftello(s->file);
        if (fread(out + done, 1, n, s->file) != n)
            return false;
        posix_fadvise(fileno(s->file), at, (off_t)n, POSIX_FADV_DONTNEED);
    }
    return true;
}

static iso_status read_stored(iso_volume_source *s, size_t plane_count, void *out, iso_error *err)
{
    const size_t *n = s->header.geometry.size;
    size_t sample = iso_type_bytes(stored_type(s)), plane = n[0] * n[1] * sample;
    if (plane_count > n[2] - s->planes_done)
        return iso_fail(err, ISO_E_RANGE, "%s: plane %zu asked for, there are %zu", s->path,
                        s->planes_done + plane_count, n[2]);
    size_t bytes = plane * plane_count;
    iso_status status = ISO_OK;
    if (s->preloaded)
        memcpy(out, s->preloaded + s->planes_done * plane, bytes);
    else if (s->read_planes)
        status = s->read_planes(s, plane_count, out, err);
    else if (s->gz)
        status = read_compressed(s, out, bytes, err);
    else if (!read_plain(s, out, bytes))
        status = iso_fail(err, ISO_E_IO, "%s: read error in planes %zu to %zu of %zu", s->path, s->planes_done,
                          s->planes_done + plane_count, n[2]);
    if (status != ISO_OK)
        return status;
    if (s->swap_bytes)
        swap_samples(out, sample, bytes / sample);
    s->planes_done += plane_count;
    return s->gz && s->planes_done == n[2] ? check_compressed_end(s, err) : ISO_OK;
}

void iso_source_apply_scale(iso_volume_source *s)
{
    const iso_volume_notes *notes = &s->header.notes;
    if (s->scaled || (notes->scale_slope == 1 && notes->scale_intercept == 0))
        return;
    s->scaled = true;
    s->slope = notes->scale_slope;
    s->intercept = notes->scale_intercept;
    s->stored = s->header.type;
    s->header.type = ISO_F32;
    s->header.notes.applied_slope = s->slope;
    s->header.notes.applied_intercept = s->intercept;
    s->header.notes.scale_slope = 1;
    s->header.notes.scale_intercept = 0;
}

static void scale_row(const iso_volume *row, double slope, double intercept, float *restrict out)
{
    const size_t n = row->geometry.size[0];
/* clang-format off */
#define ISO_SCALE_CASE(name, text, ctype)                                    \
    case name:                                                               \
        for (size_t x = 0; x < n; ++x)                                       \
            out[x] = (float)(slope * (double)((const ctype *)row->data)[x] + intercept); \
        break;
    /* clang-format on */
    switch (row->type) {
        ISO_TYPE_LIST(ISO_SCALE_CASE)
    }
#undef ISO_SCALE_CASE
}

iso_status iso_source_read(iso_volume_source *s, size_t plane_count, void *out, iso_error *err)
{
    if (!s->scaled)
        return read_stored(s, plane_count, out, err);
    const size_t *n = s->header.geometry.size, plane = n[0] * n[1];
    iso_volume row = {.geometry = {.size = {plane, 1, 1}},
                      .type = s->stored,
                      .data = malloc(plane * iso_type_bytes(s->stored))};
    iso_status status = row.data ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: no memory for a plane", s->path);
    for (size_t z = 0; z < plane_count && status == ISO_OK; ++z) {
        status = read_stored(s, 1, row.data, err);
        if (status == ISO_OK)
            scale_row(&row, s->slope, s->intercept, (float *)out + z * plane);
    }
    free(row.data);
    return status;
}

iso_status iso_source_skip(iso_volume_source *s, size_t plane_count, iso_error *err)
{
    const size_t *n = s->header.geometry.size, plane = n[0] * n[1] * iso_type_bytes(stored_type(s));
    if (plane_count > n[2] - s->planes_done)
        return iso_fail(err, ISO_E_RANGE, "%s: plane %zu asked for, there are %zu", s->path,
                        s->planes_done + plane_count, n[2]);
    if (s->file && fseeko(s->file, (off_t)(plane * plane_count), SEEK_CUR) != 0)
        return iso_fail(err, ISO_E_IO, "%s: cannot be read: %s", s->path, strerror(errno));
    if (!s->gz && !s->read_planes) {
        s->planes_done += plane_count;
        return ISO_OK;
    }
    char *unwanted = malloc(plane);
    iso_status status = unwanted ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: no memory for a plane", s->path);
    for (size_t i = 0; i < plane_count && status == ISO_OK; ++i)
        status = read_stored(s, 1, unwanted, err);
    free(unwanted);
    return status;
}

void iso_source_close(iso_volume_source *s)
{
    if (!s)
        return;
    if (s->file)
        fclose(s->file);
    if (s->gz)
        gzclose(s->gz);
    if (s->close_reader)
        s->close_reader(s);
    free(s->preloaded);
    free(s->path);
    free(s);
}
