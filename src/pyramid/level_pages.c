/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "pyramid/level_pages.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inputs.h"
#include "pyramid/pyramid_layout.h"

typedef struct paged_file {
    int fd; /* -1: not open */
    char *path;
    size_t header_bytes, voxel_bytes;
    iso_type type;
} paged_file;

struct iso_level_pages {
    size_t size[3];
    paged_file scalar, codes;
    size_t bytes_read;
};

static iso_status check_file(const paged_file *f, const char *header, size_t voxels, iso_error *err)
{
    struct stat st;
    const size_t bytes = f->header_bytes + voxels * f->voxel_bytes;
    FREED char *found = malloc(f->header_bytes + 1);
    NEED_MEMORY(found, err, "%s: out of memory", f->path);
    if (fstat(f->fd, &st) != 0 || (size_t)st.st_size != bytes)
        return iso_fail(err, ISO_E_FORMAT, "%s: not the %zu bytes that pyramid.json describes", f->path, bytes);
    if (pread(f->fd, found, f->header_bytes, 0) != (ssize_t)f->header_bytes ||
        memcmp(found, header, f->header_bytes) != 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: its NRRD header is not the one that pyramid.json describes", f->path);
    return ISO_OK;
}

static iso_status open_file(const char *dir, const iso_level *level, size_t k, const level_file *layout, paged_file *f,
                            iso_error *err)
{
    char name[64];
    iso_layout_name(layout, k, name);
    FREED char *header = iso_layout_header(&level->geometry, layout);
    f->path = iso_path_join(dir, name);
    NEED(header && f->path ? iso_inputs_note(f->path, err) : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", name));
    if ((f->fd = open(f->path, O_RDONLY | O_CLOEXEC)) < 0)
        return iso_fail(err, ISO_E_IO, "%s: cannot be opened: %s", f->path, strerror(errno));
    f->header_bytes = strlen(header);
    f->type = layout->type;
    f->voxel_bytes = layout->components * iso_type_bytes(layout->type);
    return check_file(f, header, iso_geometry_voxel_count(&level->geometry), err);
}

iso_status iso_level_pages_open(const char *dir, const iso_pyramid *outline, size_t level, bool with_codes,
                                iso_level_pages **pages, iso_error *err)
{
    level_file files[FILE_COUNT];
    *pages = NULL;
    NEED(iso_pyramid_check_level(outline, dir, level, err));
    const iso_level *l = &outline->levels[level];
    iso_level_pages *p = *pages = calloc(1, sizeof *p);
    NEED_MEMORY(p, err, "%s: out of memory", dir);
    p->scalar.fd = p->codes.fd = -1;
    memcpy(p->size, l->geometry.size, sizeof p->size);
    iso_layout_files(&outline->options, l->stored_type, files);
    iso_status status = open_file(dir, l, level, &files[FILE_SCALAR], &p->scalar, err);
    if (status == ISO_OK && with_codes)
        status = open_file(dir, l, level, &files[FILE_CODES], &p->codes, err);
    if (status != ISO_OK) {
        iso_level_pages_close(p);
        *pages = NULL;
    }
    return status;
}

static void close_file(paged_file *f)
{
    if (f->fd >= 0)
        close(f->fd);
    free(f->path);
}

void iso_level_pages_close(iso_level_pages *p)
{
    if (!p)
        return;
    close_file(&p->scalar);
    close_file(&p->codes);
    free(p);
}

static iso_status read_at(const paged_file *f, size_t at, size_t bytes, char *out, iso_error *err)
{
    while (bytes > 0) {
        const ssize_t n = pread(f->fd, out, bytes, (off_t)at);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return iso_fail(err, ISO_E_IO, "%s: cannot be read at byte %zu: %s", f->path, at,
                            n < 0 ? strerror(errno) : "it has become shorter");
        out += n;
        at += (size_t)n;
        bytes -= (size_t)n;
    }
    return ISO_OK;
}

/* Reads each row's bytes as stored, to the end of the `pitch` bytes that the row has in out. */
static iso_status read_rows(iso_level_pages *p, const paged_file *f, const size_t first[3], const size_t count[3],
                            size_t pitch, char *out, iso_error *err)
{
    const size_t row_bytes = count[0] * f->voxel_bytes;
    for (size_t z = 0; z < count[2]; ++z)
        for (size_t y = 0; y < count[1]; ++y, out += pitch) {
            const size_t voxel = first[0] + p->size[0] * (first[1] + y + p->size[1] * (first[2] + z));
            NEED(read_at(f, f->header_bytes + voxel * f->voxel_bytes, row_bytes, out + pitch - row_bytes, err));
        }
    __atomic_add_fetch(&p->bytes_read, row_bytes * count[1] * count[2], __ATOMIC_RELAXED);
    return ISO_OK;
}

iso_status iso_level_pages_codes(const iso_level_pages *p, const size_t first[3], const size_t count[3], uint8_t *out,
                                 iso_error *err)
{
    return read_rows((iso_level_pages *)p, &p->codes, first, count, 3 * count[0], (char *)out, err);
}

/* Widens in place a row of n samples of 8 or 16 bits, which stand at the end of the row's buffer. */
static void widen(iso_type type, size_t n, float *row)
{
    enum { PIECE = 512 };
    uint16_t piece[PIECE];
    const size_t width = iso_type_bytes(type);
    const char *from = (const char *)(row + n) - n * width;
    for (size_t i = 0; i < n; i += PIECE) {
        const size_t m = n - i < PIECE ? n - i : PIECE;
        memcpy(piece, from + i * width, m * width);
        iso_layout_to_floats(piece, type, m, row + i);
    }
}

iso_status iso_level_pages_scalars(const iso_level_pages *p, const size_t first[3], const size_t count[3], float *out,
                                   iso_error *err)
{
    const size_t pitch = count[0] * sizeof *out;
    const iso_status status = read_rows((iso_level_pages *)p, &p->scalar, first, count, pitch, (char *)out, err);
    if (status != ISO_OK || p->scalar.type == ISO_F32)
        return status;
    for (size_t row = 0; row < count[1] * count[2]; ++row)
        widen(p->scalar.type, count[0], out + row * count[0]);
    return ISO_OK;
}

double iso_level_pages_bytes_read(const iso_level_pages *p)
{
    return (double)p->bytes_read;
}
