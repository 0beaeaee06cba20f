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
iso_status iso_bigfile_write(iso_bigfile *file, const void *data, size_t bytes, iso_error *err);
/* What has been written is in the file, perhaps with a few bytes behind it that the end cuts off. */
iso_status iso_bigfile_sync(iso_bigfile *file, iso_error *err);
/* Syncs, cuts, closes and frees in every case. Accepts NULL. */
iso_status iso_bigfile_close(iso_bigfile *file, iso_error *err);
void iso_bigfile_abandon(iso_bigfile *file); /* closes and frees only; accepts NULL */

#endif
