/* SPDX-License-Identifier: MIT */
/* zlib_samples.c - samples that zlib packed, within a file: gzread() reads only gzip. */
#define _GNU_SOURCE
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/inputs.h"
#include "volume/stream_kernel.h"

enum { INPUT_BYTES = 1 << 16 };

typedef struct zlib_reader {
    z_stream z;
    FILE *file;
    bool ended;
    size_t given;
    unsigned char input[INPUT_BYTES];
} zlib_reader;

/* Inflates the next bytes, fewer only at the end; false if they are damaged. */
static bool inflate_some(zlib_reader *r, unsigned char *out, size_t bytes, size_t *done)
{
    for (*done = 0; *done < bytes && !r->ended;) {
        if (r->z.avail_in == 0) {
            r->z.next_in = r->input;
            r->z.avail_in = (uInt)fread(r->input, 1, sizeof r->input, r->file);
        }
        const size_t room = bytes - *done < (1u << 30) ? bytes - *done : 1u << 30;
        r->z.next_out = out + *done;
        r->z.avail_out = (uInt)room;
        const int code = inflate(&r->z, Z_NO_FLUSH);
        const size_t got = room - r->z.avail_out;
        *done += got;
        r->ended = code == Z_STREAM_END;
        if (code == Z_BUF_ERROR && got == 0)
            return true; /* the file has ended */
        if (code != Z_OK && code != Z_BUF_ERROR && !r->ended)
            return false;
    }
    return true;
}

static iso_status read_zlib(iso_volume_source *s, size_t plane_count, void *out, iso_error *err)
{
    zlib_reader *r = s->reader;
    const size_t total = iso_source_bytes(s), bytes = iso_source_plane_bytes(s) * plane_count;
    size_t done;
    unsigned char extra;
    const bool well = inflate_some(r, out, bytes, &done);
    NEED(iso_source_check_read(r->file, s->path, ISO_OK, err));
    if (!well)
        return iso_fail(err, ISO_E_FORMAT, "%s: compressed samples are damaged: %s", s->path,
                        r->z.msg ? r->z.msg : "not zlib's");
    r->given += done;
    if (done < bytes)
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated: the compressed samples end after %zu bytes of %zu", s->path,
                        r->given, total);
    if (r->given < total)
        return ISO_OK;
    if (inflate_some(r, &extra, 1, &done) && r->ended)
        return ISO_OK;
    iso_fail(err, ISO_E_FORMAT,
             done ? "%s: too long: compressed samples go on after the %zu bytes that the sizes need"
                  : "%s: compressed samples are damaged after %zu bytes: the end is missing",
             s->path, total);
    return iso_source_check_read(r->file, s->path, ISO_E_FORMAT, err);
}

static void close_zlib(iso_volume_source *s)
{
    zlib_reader *r = s->reader;
    inflateEnd(&r->z);
    if (r->file)
        fclose(r->file);
    free(r);
}

iso_status iso_source_take_zlib(iso_volume_source *source, const char *path, size_t offset, iso_error *err)
{
    zlib_reader *r = calloc(1, sizeof *r);
    if (!r || inflateInit2(&r->z, 15 + 32) != Z_OK) { /* zlib's header, or gzip's */
        free(r);
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    }
    source->reader = r;
    source->read_planes = read_zlib;
    source->close_reader = close_zlib;
    NEED(iso_source_check_regular(path, err));
    NEED(iso_inputs_note(path, err));
    r->file = fopen(path, "rb");
    struct stat st;
    if (!r->file || fseeko(r->file, (off_t)offset, SEEK_SET) != 0 || fstat(fileno(r->file), &st) != 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be read at byte %zu: %s", path, offset, strerror(errno));
    return iso_source_check_packed(source, path, (double)st.st_size - (double)offset, ISO_SOURCE_DEFLATE_MOST, err);
}
