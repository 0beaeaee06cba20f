/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/bigfile.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Blocks start and end at multiples of a page, which every disk's sectors divide. */
enum { ALIGNMENT = ISO_BIGFILE_ALIGNMENT, BLOCK = ISO_BIGFILE_BYTES };

struct iso_bigfile {
    char *path;
    char *block;
    int fd;
    size_t used;   /* bytes in block */
    size_t offset; /* of block in the file, a multiple of ALIGNMENT */
};

static iso_status io_error(const iso_bigfile *f, iso_error *err)
{
    return iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", f->path, strerror(errno));
}

/* Keeps the first `keep` bytes. The block that holds the last of them is read back. */
static iso_status keep_bytes(iso_bigfile *f, size_t keep, iso_error *err)
{
    struct stat st;
    if (fstat(f->fd, &st) != 0)
        return io_error(f, err);
    if ((size_t)st.st_size < keep)
        return iso_fail(err, ISO_E_FORMAT, "%s: %zu bytes, of an earlier build there must be %zu", f->path,
                        (size_t)st.st_size, keep);
    f->offset = keep / ALIGNMENT * ALIGNMENT;
    f->used = keep - f->offset;
    int fd = open(f->path, O_RDONLY | O_CLOEXEC);
    bool good = fd >= 0 && pread(fd, f->block, f->used, (off_t)f->offset) == (ssize_t)f->used;
    if (fd >= 0)
        close(fd);
    return good && ftruncate(f->fd, (off_t)keep) == 0 ? ISO_OK : io_error(f, err);
}

static iso_status open_file(const char *path, int flags, bool direct, iso_bigfile **file, iso_error *err)
{
    *file = NULL;
    iso_bigfile *f = calloc(1, sizeof *f);
    if (f) {
        f->path = strdup(path);
        f->block = aligned_alloc(ALIGNMENT, BLOCK);
        f->fd = direct ? open(path, flags | O_DIRECT, 0666) : -1;
        if (f->fd < 0)
            f->fd = open(path, flags, 0666);
    }
    *file = f;
    NEED_MEMORY(f && f->path && f->block, err, "%s: out of memory", path);
    return f->fd < 0 ? io_error(f, err) : ISO_OK;
}

static iso_status open_or_abandon(const char *path, int flags, bool direct, size_t keep, iso_bigfile **file,
                                  iso_error *err)
{
    iso_status status = open_file(path, flags, direct, file, err);
    if (status == ISO_OK && (flags & O_CREAT))
        status = keep_bytes(*file, keep, err);
    if (status != ISO_OK) {
        iso_bigfile_abandon(*file);
        *file = NULL;
    }
    return status;
}

iso_status iso_bigfile_open(const char *path, bool direct, size_t keep, iso_bigfile **file, iso_error *err)
{
    return open_or_abandon(path, O_WRONLY | O_CREAT | O_CLOEXEC, direct, keep, file, err);
}

iso_status iso_bigfile_join(const char *path, bool direct, iso_bigfile **file, iso_error *err)
{
    return open_or_abandon(path, O_WRONLY | O_CLOEXEC, direct, 0, file, err);
}

static iso_status write_bytes(iso_bigfile *f, size_t bytes, iso_error *err)
{
    for (size_t done = 0; done < bytes;) {
        ssize_t n = pwrite(f->fd, f->block + done, bytes - done, (off_t)(f->offset + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0 && errno == EINVAL && (fcntl(f->fd, F_GETFL) & O_DIRECT)) { /* opened so, but not written so */
            fcntl(f->fd, F_SETFL, 0);
            continue;
        }
        if (n <= 0)
            return io_error(f, err);
        done += (size_t)n;
    }
    return ISO_OK;
}

static iso_status write_block(iso_bigfile *f, iso_error *err)
{
    const size_t bytes = (f->used + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    memset(f->block + f->used, 0, bytes - f->used);
    return write_bytes(f, bytes, err);
}

iso_status iso_bigfile_write(iso_bigfile *f, const void *data, size_t bytes, iso_error *err)
{
    const char *from = data;
    while (bytes > 0) {
        size_t n = BLOCK - f->used < bytes ? BLOCK - f->used : bytes;
        memcpy(f->block + f->used, from, n);
        f->used += n;
        from += n;
        bytes -= n;
        if (f->used < BLOCK)
            continue;
        NEED(write_block(f, err));
        f->offset += BLOCK;
        f->used = 0;
    }
    return ISO_OK;
}

iso_status iso_bigfile_flush(iso_bigfile *f, iso_error *err)
{
    const size_t whole = f->used / ALIGNMENT * ALIGNMENT;
    iso_status status = whole > 0 ? write_bytes(f, whole, err) : ISO_OK;
    memmove(f->block, f->block + whole, f->used - whole);
    f->offset += whole;
    f->used -= whole;
    return status;
}

void iso_bigfile_get_tail(const iso_bigfile *f, iso_bigfile_tail *tail)
{
    assert(f->used < ALIGNMENT);
    tail->end = f->offset + f->used;
    memcpy(tail->bytes, f->block, f->used);
}

void iso_bigfile_tail_after(iso_bigfile_tail *tail, const void *data, size_t bytes)
{
    const size_t used = tail->end % ALIGNMENT, left = (tail->end + bytes) % ALIGNMENT;
    if (used + bytes < ALIGNMENT)
        memcpy(tail->bytes + used, data, bytes);
    else
        memcpy(tail->bytes, (const char *)data + bytes - left, left);
    tail->end += bytes;
}

void iso_bigfile_go_on(iso_bigfile *f, const iso_bigfile_tail *tail)
{
    f->used = tail->end % ALIGNMENT;
    f->offset = tail->end - f->used;
    memcpy(f->block, tail->bytes, f->used);
}

iso_status iso_bigfile_sync(iso_bigfile *f, iso_error *err)
{
    return f->used > 0 ? write_block(f, err) : ISO_OK;
}

iso_status iso_bigfile_close(iso_bigfile *f, iso_error *err)
{
    if (!f)
        return ISO_OK;
    iso_status status = iso_bigfile_sync(f, err);
    if (status == ISO_OK && ftruncate(f->fd, (off_t)(f->offset + f->used)) != 0)
        status = io_error(f, err);
    if (close(f->fd) != 0 && status == ISO_OK)
        status = io_error(f, err);
    f->fd = -1;
    iso_bigfile_abandon(f);
    return status;
}

void iso_bigfile_abandon(iso_bigfile *f)
{
    if (!f)
        return;
    if (f->fd >= 0)
        close(f->fd);
    free(f->block);
    free(f->path);
    free(f);
}
