/* SPDX-License-Identifier: MIT */
/* bigfile.h - long files, written from their beginning to their end.
 *
 * If the file system allows it, writes bypass the page cache (O_DIRECT), in aligned blocks. A file larger than
 * memory gains nothing from the cache, and would push out other programs' pages. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

typedef struct iso_bigfile iso_bigfile;

/* Size of each file's buffer. */
#define ISO_BIGFILE_BYTES ((size_t)1 << 20)

/* Opens or creates the file. The first `keep` bytes of an existing one stay, and writing goes on after them; the
 * rest is cut off. ISO_E_FORMAT if the file is shorter than that. */
iso_status iso_bigfile_open(const char *path, bool direct, size_t keep, iso_bigfile **file, iso_error *err);
/* Opens a file that another process has created, and changes nothing in it. Call iso_bigfile_go_on() before writing. */
iso_status iso_bigfile_join(const char *path, bool direct, iso_bigfile **file, iso_error *err);
iso_status iso_bigfile_write(iso_bigfile *file, const void *data, size_t bytes, iso_error *err);
/* Returns when all that was written is on the disk. The file may be longer by part of a block until it is closed. */
iso_status iso_bigfile_sync(iso_bigfile *file, iso_error *err);

/* Several processes write one file in turns. Only whole blocks are written: the bytes of a process that do not fill
 * its last block are its tail, which it hands to the next process. */
enum { ISO_BIGFILE_ALIGNMENT = 4096 };
typedef struct iso_bigfile_tail {
    size_t end;                                 /* bytes of the file so far */
    unsigned char bytes[ISO_BIGFILE_ALIGNMENT]; /* the last end % ISO_BIGFILE_ALIGNMENT of them */
} iso_bigfile_tail;
/* Returns the tail so far. Call it only after open, go_on or flush. */
void iso_bigfile_get_tail(const iso_bigfile *file, iso_bigfile_tail *tail);
/* Changes the tail to its state after writing `bytes` more bytes, at data. */
void iso_bigfile_tail_after(iso_bigfile_tail *tail, const void *data, size_t bytes);
/* Continues writing after this tail. */
void iso_bigfile_go_on(iso_bigfile *file, const iso_bigfile_tail *tail);
/* Writes all blocks that are full. */
iso_status iso_bigfile_flush(iso_bigfile *file, iso_error *err);

/* Syncs, cuts, closes and frees in every case. Accepts NULL. */
iso_status iso_bigfile_close(iso_bigfile *file, iso_error *err);
void iso_bigfile_abandon(iso_bigfile *file); /* closes and frees only; accepts NULL */
