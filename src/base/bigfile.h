/* SPDX-License-Identifier: MIT */
/* bigfile.h - long files, written from their beginning to their end.
 *
 * Where the file system can, writes go past the page cache (O_DIRECT), in
 * aligned blocks: a file larger than memory gains nothing from the cache, and
 * does not push out what others keep there. */
#ifndef ISO_BIGFILE_H
#define ISO_BIGFILE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

typedef struct iso_bigfile iso_bigfile;

/* Memory of each. */
#define ISO_BIGFILE_BYTES ((size_t)1 << 20)

/* Opens or creates; `keep` bytes of what is there stay and are gone on from
 * (ISO_E_FORMAT when there are fewer), the rest is cut off. */
iso_status iso_bigfile_open(const char *path, bool direct, size_t keep, iso_bigfile **file, iso_error *err);
/* Opens what another process has opened or created, and leaves it as it is; writing starts where iso_bigfile_go_on() says. */
iso_status iso_bigfile_join(const char *path, bool direct, iso_bigfile **file, iso_error *err);
iso_status iso_bigfile_write(iso_bigfile *file, const void *data, size_t bytes, iso_error *err);
/* What has been written is in the file, perhaps with a few bytes behind it that the end cuts off. */
iso_status iso_bigfile_sync(iso_bigfile *file, iso_error *err);

/* Several processes write one file in turns: each block of the disk is written by
 * one of them, as what does not fill its last block goes on to the next in turn. */
enum { ISO_BIGFILE_ALIGNMENT = 4096 };
typedef struct iso_bigfile_tail {
    size_t end;                               /* bytes of the file so far */
    unsigned char bytes[ISO_BIGFILE_ALIGNMENT]; /* the last end % ISO_BIGFILE_ALIGNMENT of them */
} iso_bigfile_tail;
/* Where the file stands. Only after open, go_on, or a flush. */
void iso_bigfile_get_tail(const iso_bigfile *file, iso_bigfile_tail *tail);
/* What the tail will be when `bytes` more have been written. */
void iso_bigfile_tail_after(iso_bigfile_tail *tail, const void *data, size_t bytes);
/* Writes from there on. */
void iso_bigfile_go_on(iso_bigfile *file, const iso_bigfile_tail *tail);
/* Writes all whole blocks of the disk. */
iso_status iso_bigfile_flush(iso_bigfile *file, iso_error *err);

/* Syncs, cuts, closes and frees in every case. Accepts NULL. */
iso_status iso_bigfile_close(iso_bigfile *file, iso_error *err);
void iso_bigfile_abandon(iso_bigfile *file); /* closes and frees only; accepts NULL */

#endif
