/* SPDX-License-Identifier: MIT */
/* pyramid_samples.c - reads a level's file in pieces. Each piece is hashed, compared and converted while it is in the
 * processor's cache; nothing but the samples is kept. */
#define _GNU_SOURCE
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/large.h"
#include "pyramid/pyramid_layout.h"

#define PIECE_BYTES ((size_t)256 << 10)

typedef struct reading {
    const char *path, *header;
    const level_file *file;
    int fd;
    XXH3_state_t *hash;
    char *piece;
    bool has_header; /* the one that is wanted */
} reading;

static iso_status read_bytes(const reading *r, char *to, size_t bytes, iso_error *err)
{
    for (size_t done = 0; done < bytes;) {
        errno = 0;
        const ssize_t n = read(r->fd, to + done, bytes - done);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return iso_fail(err, iso_errno_status(), "%s: read error: %s", r->path, strerror(errno ? errno : EIO));
        done += (size_t)n;
    }
    XXH3_64bits_update(r->hash, to, bytes);
    return ISO_OK;
}

static iso_status read_header(reading *r, iso_error *err)
{
    const size_t bytes = strlen(r->header);
    FREED char *found = malloc(bytes + 1);
    iso_status status = found ? read_bytes(r, found, bytes, err)
                              : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", r->path);
    r->has_header = status == ISO_OK && memcmp(found, r->header, bytes) == 0;
    return status;
}

/* Reads codes in place, values through a piece. */
static iso_status read_samples(const reading *r, size_t count, void *samples, iso_error *err)
{
    const size_t width = iso_type_bytes(r->file->type), most = PIECE_BYTES / width;
    const bool keeps = r->file->is_bytes || r->file->is_kept;
    for (size_t at = 0; at < count; at += most) {
        const size_t n = count - at < most ? count - at : most;
        char *to = keeps ? (char *)samples + width * at : r->piece;
        NEED(read_bytes(r, to, n * width, err));
        if (!keeps)
            iso_layout_to_floats(to, r->file->type, n, (float *)samples + at);
    }
    return ISO_OK;
}

static iso_status check(const reading *r, const char *digest, iso_error *err)
{
    char found[32];
    snprintf(found, sizeof found, "%016llx", (unsigned long long)XXH3_64bits_digest(r->hash));
    if (strcmp(found, digest) != 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: checksum %s, pyramid.json says %s", r->path, found, digest);
    if (!r->has_header)
        return iso_fail(err, ISO_E_FORMAT, "%s: its NRRD header is not the one that pyramid.json describes", r->path);
    return ISO_OK;
}

static iso_status read_all(reading *r, const char *digest, size_t count, void *samples, iso_error *err)
{
    NEED(read_header(r, err));
    NEED(read_samples(r, count, samples, err));
    return check(r, digest, err);
}

static iso_status check_size(const reading *r, size_t count, size_t bytes, iso_error *err)
{
    const size_t wanted = strlen(r->header) + count * iso_type_bytes(r->file->type);
    return bytes == wanted
               ? ISO_OK
               : iso_fail(err, ISO_E_FORMAT, "%s: %zu bytes, must be %zu by pyramid.json", r->path, bytes, wanted);
}

iso_status iso_layout_read(const char *path, const char *header, const level_file *f, const char *digest, size_t count,
                           void **data, iso_error *err)
{
    size_t bytes;
    reading r = {.path = path, .header = header, .file = f, .fd = -1};
    *data = NULL;
    iso_status status = iso_inputs_note(path, err);
    TRY(status, iso_file_open(path, &r.fd, &bytes, err));
    TRY(status, check_size(&r, count, bytes, err));
    if (status == ISO_OK) {
        r.hash = XXH3_createState();
        r.piece = malloc(PIECE_BYTES);
        /* Floats not by large.h: a virtual machine that tells its host of each free huge page has to get it back
         * for every file. */
        *data = f->is_kept ? iso_large_samples(count * iso_type_bytes(f->type))
                           : malloc(f->is_bytes ? count : count * sizeof(float));
        if (r.hash && r.piece && *data) {
            XXH3_64bits_reset(r.hash);
            status = read_all(&r, digest, count, *data, err);
        } else {
            status = iso_fail(err, ISO_E_MEMORY, "%s: no memory for %zu samples", path, count);
        }
    }
    if (status != ISO_OK) {
        iso_large_free(*data);
        *data = NULL;
    }
    free(r.piece);
    XXH3_freeState(r.hash);
    if (r.fd >= 0)
        close(r.fd);
    return status;
}
