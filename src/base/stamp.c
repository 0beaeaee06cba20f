/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/stamp.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/file.h"

static const char mark[] = "as isoshade wrote it: xxh64 ";

iso_status iso_stamp_append(const char *path, const char *comment, iso_error *err)
{
    FREED char *data = NULL;
    size_t size = 0;
    NEED(iso_file_read(path, &data, &size, err));
    const uint64_t sum = XXH64(data, size, 0);
    FILE *f = fopen(path, "ab");
    const bool written = f && fprintf(f, "\n%s%s%016" PRIx64 "\n", comment, mark, sum) > 0;
    if (f && fclose(f) == 0 && written)
        return ISO_OK;
    return iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
}

/* True if the file ends in a line with the checksum of all before it. */
static bool stamp_fits(const char *path)
{
    const size_t tail = strlen(mark) + 16 + 1; /* mark, checksum, end of line */
    FREED char *data = NULL;
    size_t size = 0;
    uint64_t sum = 0;
    bool fits = iso_file_read(path, &data, &size, NULL) == ISO_OK && size > tail &&
                memcmp(data + size - tail, mark, strlen(mark)) == 0 &&
                sscanf(data + size - 17, "%16" SCNx64, &sum) == 1;
    const char *line = fits ? memrchr(data, '\n', size - tail) : NULL;
    fits = line && sum == XXH64(data, (size_t)(line - data), 0);
    return fits;
}

/* Gives a second name to a file. False: the name is taken, or errno has the cause. Without hard links the first name
 * goes. */
static bool give_name(const char *path, const char *name)
{
    if (link(path, name) == 0)
        return true;
    return errno != EEXIST && errno != ENOENT && renameat2(AT_FDCWD, path, AT_FDCWD, name, RENAME_NOREPLACE) == 0;
}

/* Keeps a file as PATH1, or PATH2 and so on if that is taken: no backup replaces another, also if two processes make
 * them. ENOENT: another process has moved the file away, and keeps it. */
static iso_status keep_backup(const char *path, iso_error *err)
{
    enum { MOST_BACKUPS = 9999 };
    for (int i = 1; i <= MOST_BACKUPS; ++i) {
        char *backup = NULL;
        NEED_MEMORY(asprintf(&backup, "%s%d", path, i) >= 0, err, "out of memory");
        const bool is_kept = give_name(path, backup) || errno == ENOENT;
        const int cause = errno;
        iso_status status = ISO_OK;
        if (!is_kept && cause != EEXIST)
            status = iso_fail(err, iso_errno_status(), "%s: cannot be kept as %s: %s", path, backup, strerror(cause));
        free(backup);
        if (is_kept || status != ISO_OK)
            return status;
    }
    return iso_fail(err, ISO_E_IO, "%s: has %d backups already; remove some", path, MOST_BACKUPS);
}

iso_status iso_stamp_guard(const char *path, bool force, iso_error *err)
{
    return iso_stamp_guard_other(path, stamp_fits(path), force, err);
}

iso_status iso_stamp_guard_adjacent(const char *path, bool is_ours, iso_error *err)
{
    if (is_ours || !iso_path_exists(path))
        return ISO_OK;
    return iso_fail(err, ISO_E_IO, "%s: would be replaced, and is not from isoshade; -o names another", path);
}

iso_status iso_stamp_guard_other(const char *path, bool is_ours, bool force, iso_error *err)
{
    if (is_ours || !iso_path_exists(path))
        return ISO_OK;
    if (force)
        return keep_backup(path, err);
    return iso_fail(err, ISO_E_IO,
                    "%s: was saved or changed since isoshade wrote it, or is not from isoshade; --force overwrites it and keeps "
                    "it as %s1 (2, 3, ... if taken), -o names another",
                    path, iso_path_base(path));
}
