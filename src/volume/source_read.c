/* SPDX-License-Identifier: MIT */
/* source_read.c - reading planes. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "volume/stream_kernel.h"

/* zlib counts bytes in int. */
#define GZ_CHUNK_BYTES ((size_t)1 << 30)
#define DROP_BYTES ((size_t)4 << 20)

iso_type iso_source_stored_type(const iso_volume_source *source)
{
    return source->scaled || source->form ? source->stored : source->header.type;
}

void iso_source_set_form(iso_volume_source *s, iso_form form)
{
    s->form = form;
    s->stored = form == ISO_FORM_HALF ? ISO_U16 : ISO_F64;
    s->header.type = form == ISO_FORM_HALF ? ISO_F32 : ISO_F64;
    s->slope = 1;
}

size_t iso_source_plane_bytes(const iso_volume_source *source)
{
    const size_t *n = source->header.geometry.size;
    return n[0] * n[1] * source->choice.inside_count * iso_type_bytes(iso_source_stored_type(source));
}

size_t iso_source_planes(const iso_volume_source *source)
{
    return source->header.geometry.size[2] * source->choice.volume_count;
}

void iso_source_make_floats(iso_volume_source *s)
{
    if (s->scaled)
        return;
    s->scaled = true;
    s->slope = 1;
    s->intercept = 0;
    s->stored = s->form ? s->stored : s->header.type;
    s->header.type = ISO_F32;
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
        if (code == Z_ERRNO || code == Z_MEM_ERROR)
            return iso_fail(err, code == Z_ERRNO ? iso_errno_status() : ISO_E_MEMORY, "%s: read error: %s", s->path,
                            text);
        if (code != Z_OK && code != Z_BUF_ERROR)
            return iso_fail(err, ISO_E_FORMAT, "%s: compressed samples are damaged: %s", s->path, text);
        size_t planes = iso_source_planes(s);
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated: the compressed samples end after plane %.2f of %zu", s->path,
                        (double)s->planes_read + (double)done / (double)iso_source_bytes(s) * (double)planes, planes);
    }
    return ISO_OK;
}

/* Checks that compressed data ends with the last plane: more data means wrong sizes, and only the end shows a bad
 * checksum. */
static iso_status check_compressed_end(iso_volume_source *s, iso_error *err)
{
    unsigned char extra;
    int n = gzread(s->gz, &extra, 1), code;
    const char *text = gzerror(s->gz, &code);
    if (n > 0)
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: too long: compressed samples go on after the %zu bytes that the sizes need", s->path,
                        iso_source_bytes(s));
    if (n < 0 && code == Z_ERRNO)
        return iso_fail(err, iso_errno_status(), "%s: read error: %s", s->path, text);
    const bool end_is_missing = s->gz_end_is_missing || code == Z_BUF_ERROR;
    if (n < 0 || code != Z_OK || end_is_missing)
        return iso_fail(err, ISO_E_FORMAT, "%s: compressed samples are damaged: %s", s->path,
                        end_is_missing ? "the end is missing" : text);
    return ISO_OK;
}

/* Reads and drops the pages. A file that would fill much of the memory is read once: its pages leave the cache after
 * the read. The reader then reuses the same few pages, three times as fast on a virtual machine. */
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

/* Reads the next planes of the file, which must have as many. */
static iso_status read_stored(iso_volume_source *s, size_t plane_count, void *out, iso_error *err)
{
    const size_t sample = iso_type_bytes(iso_source_stored_type(s)), plane = iso_source_plane_bytes(s),
                 bytes = plane * plane_count;
    if (s->preloaded)
        memcpy(out, s->preloaded + s->planes_read * plane, bytes);
    else if (s->read_planes)
        NEED(s->read_planes(s, plane_count, out, err));
    else if (s->gz)
        NEED(read_compressed(s, out, bytes, err));
    else if (!read_plain(s, out, bytes))
        return iso_fail(err, ISO_E_IO, "%s: read error in planes %zu to %zu of %zu", s->path, s->planes_read,
                        s->planes_read + plane_count, iso_source_planes(s));
    if (s->swap_bytes)
        swap_samples(out, sample, bytes / sample);
    s->planes_read += plane_count;
    return s->gz && s->planes_read == iso_source_planes(s) ? check_compressed_end(s, err) : ISO_OK;
}

iso_status iso_source_skip_stored(iso_volume_source *s, size_t plane_count, iso_error *err)
{
    const size_t plane = iso_source_plane_bytes(s);
    if (s->file && fseeko(s->file, (off_t)(plane * plane_count), SEEK_CUR) != 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be read: %s", s->path, strerror(errno));
    if (!s->gz && !s->read_planes) {
        s->planes_read += plane_count;
        return ISO_OK;
    }
    FREED char *unwanted = plane_count ? malloc(plane) : NULL;
    NEED_MEMORY(unwanted || !plane_count, err, "%s: no memory for a plane", s->path);
    for (size_t i = 0; i < plane_count; ++i)
        NEED(read_stored(s, 1, unwanted, err));
    return ISO_OK;
}

void iso_source_apply_scale(iso_volume_source *s)
{
    const iso_volume_notes *notes = &s->header.notes;
    if (s->header.notes.applied_slope != 0 || (notes->scale_slope == 1 && notes->scale_intercept == 0))
        return;
    iso_source_make_floats(s);
    s->slope = notes->scale_slope;
    s->intercept = notes->scale_intercept;
    s->header.notes.applied_slope = s->slope;
    s->header.notes.applied_intercept = s->intercept;
    s->header.notes.scale_slope = 1;
    s->header.notes.scale_intercept = 0;
}

static iso_status check_count(const iso_volume_source *s, size_t plane_count, iso_error *err)
{
    const size_t planes = s->header.geometry.size[2];
    return plane_count <= planes - s->planes_done ? ISO_OK
                                                  : iso_fail(err, ISO_E_RANGE, "%s: no plane %zu, there are %zu",
                                                             s->path, s->planes_done + plane_count, planes);
}

/* Reads planes of the file one by one, and selects or converts their samples. */
static iso_status read_converted(iso_volume_source *s, size_t plane_count, char *out, iso_error *err)
{
    const size_t *n = s->header.geometry.size, plane = n[0] * n[1], bytes = iso_type_bytes(s->header.type);
    FREED void *cells = malloc(iso_source_plane_bytes(s));
    NEED_MEMORY(cells, err, "%s: no memory for a plane", s->path);
    for (size_t z = 0; z < plane_count; ++z) {
        NEED(read_stored(s, 1, cells, err));
        iso_source_look_at(s, cells, plane);
        iso_source_convert(s, cells, plane, out + z * plane * bytes);
        iso_source_mark_no_data(s, cells, plane, out + z * plane * bytes);
    }
    return ISO_OK;
}

iso_status iso_source_read(iso_volume_source *s, size_t plane_count, void *out, iso_error *err)
{
    const size_t *n = s->header.geometry.size;
    const bool is_plain = iso_source_is_plain(s);
    NEED(check_count(s, plane_count, err));
    NEED(is_plain ? read_stored(s, plane_count, out, err) : read_converted(s, plane_count, out, err));
    if (is_plain) {
        iso_source_look_at(s, out, n[0] * n[1] * plane_count);
        iso_source_mark_no_data(s, out, n[0] * n[1] * plane_count, out);
    }
    s->planes_done += plane_count;
    return s->look.seen == iso_geometry_voxel_count(&s->header.geometry) ? iso_source_check_look(s, err) : ISO_OK;
}

iso_status iso_source_skip(iso_volume_source *s, size_t plane_count, iso_error *err)
{
    NEED(check_count(s, plane_count, err));
    NEED(iso_source_skip_stored(s, plane_count, err));
    s->planes_done += plane_count;
    return ISO_OK;
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
    iso_unpacked_remove(&s->unpacked);
    json_decref(s->header.segments);
    free(s->preloaded);
    free(s->path);
    free(s->part);
    free(s);
}
