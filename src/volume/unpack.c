/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/unpack.h"

#include <archive.h>
#include <archive_entry.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

#include "base/file.h"
#include "base/words.h"
#include "volume/stream_kernel.h"

enum { MOST_MAGIC = 6, BLOCK_BYTES = 1 << 18, MOST_MEMBERS = 10000 };

static const struct {
    const char *ending;
    int filter;
    size_t bytes;
    unsigned char magic[MOST_MAGIC];
} packers[] = {
    {".gz", ARCHIVE_FILTER_GZIP, 3, {0x1f, 0x8b, 8}},
    {".bz2", ARCHIVE_FILTER_BZIP2, 3, "BZh"},
    {".xz", ARCHIVE_FILTER_XZ, 6, {0xfd, '7', 'z', 'X', 'Z', 0}},
    {".zst", ARCHIVE_FILTER_ZSTD, 4, {0x28, 0xb5, 0x2f, 0xfd}},
    {".lz4", ARCHIVE_FILTER_LZ4, 4, {0x04, 0x22, 0x4d, 0x18}},
    {".Z", ARCHIVE_FILTER_COMPRESS, 2, {0x1f, 0x9d}},
};
enum { PACKERS = sizeof packers / sizeof *packers };

/* Returns the row of a packed file, or PACKERS. */
static size_t find_packer(const unsigned char *head, size_t size)
{
    size_t i = 0;
    while (i < PACKERS && (size < packers[i].bytes || memcmp(head, packers[i].magic, packers[i].bytes) != 0))
        ++i;
    return i;
}

bool iso_looks_packed(const unsigned char *head, size_t size)
{
    return find_packer(head, size) < PACKERS;
}

/* Returns the name without its packer's ending, to be freed. */
static char *plain_name(const char *path)
{
    const char *base = iso_path_base(path);
    size_t length = strlen(base);
    for (size_t i = 0; i < PACKERS; ++i)
        if (iso_path_ends_with(base, packers[i].ending) && length > strlen(packers[i].ending)) {
            length -= strlen(packers[i].ending);
            break;
        }
    return strndup(base, length);
}

/* Returns the largest size to unpack to. */
static double most_bytes(const char *folder, double packed)
{
    struct statvfs disk;
    const double room = statvfs(folder, &disk) == 0 ? (double)disk.f_bavail * (double)disk.f_frsize / 2
                                                    : (double)INFINITY;
    return fmin(room, ISO_SOURCE_DEFLATE_MOST * packed);
}

static iso_status fail_damaged(struct archive *a, const char *path, iso_error *err)
{
    const char *why = archive_error_string(a);
    return iso_fail(err, archive_errno(a) == ENOMEM ? ISO_E_MEMORY : ISO_E_FORMAT, "%s: cannot be unpacked: %s", path,
                    why ? why : "it is damaged");
}

static iso_status copy(struct archive *a, const char *path, FILE *out, double most, iso_error *err)
{
    const void *block;
    size_t bytes;
    la_int64_t at;
    double sum = 0;
    int code;
    while ((code = archive_read_data_block(a, &block, &bytes, &at)) == ARCHIVE_OK) {
        sum += (double)bytes;
        if (sum > most)
            return iso_fail(err, ISO_E_RANGE,
                            "%s: unpacks to more than %.0f bytes, the limit; unpack it yourself, or set TMPDIR to a "
                            "folder with more space",
                            path, most);
        if (bytes > 0 && fwrite(block, 1, bytes, out) != bytes) /* an empty block is NULL */
            return iso_fail(err, iso_errno_status(), "%s: cannot be unpacked into the temporary folder: %s", path,
                            strerror(errno));
    }
    return code == ARCHIVE_EOF ? ISO_OK : fail_damaged(a, path, err);
}

static iso_status read_packer(const char *path, size_t *packer, iso_error *err)
{
    unsigned char head[MOST_MAGIC];
    ENDED_BY(iso_close_file) FILE *f = fopen(path, "rb");
    if (!f)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    *packer = find_packer(head, fread(head, 1, sizeof head, f));
    return *packer < PACKERS ? ISO_OK : iso_fail(err, ISO_E_FORMAT, "%s: is not packed", path);
}

/* Opens the packed file with that filter: libarchive's own choice could unpack samples that look packed. */
static bool begin(struct archive *a, const char *path, int filter)
{
    struct archive_entry *entry;
    return archive_read_support_format_raw(a) == ARCHIVE_OK && archive_read_append_filter(a, filter) == ARCHIVE_OK &&
           archive_read_open_filename(a, path, BLOCK_BYTES) == ARCHIVE_OK &&
           archive_read_next_header(a, &entry) == ARCHIVE_OK;
}

static iso_status unpack_to(const char *path, const iso_unpacked *file, iso_error *err)
{
    struct archive *a = archive_read_new();
    struct stat st;
    size_t packer;
    FILE *out = fopen(file->path, "wb");
    iso_status status = read_packer(path, &packer, err);
    if (status == ISO_OK && (!a || !out || stat(path, &st) != 0))
        status = iso_fail(err, a ? iso_errno_status() : ISO_E_MEMORY, "%s: cannot be unpacked: %s", path,
                          strerror(errno));
    if (status == ISO_OK && !begin(a, path, packers[packer].filter))
        status = fail_damaged(a, path, err);
    TRY(status, copy(a, path, out, most_bytes(file->folder, (double)st.st_size), err));
    if (out && fclose(out) != 0 && status == ISO_OK)
        status = iso_fail(err, iso_errno_status(), "%s: cannot be unpacked into the temporary folder: %s", path,
                          strerror(errno));
    if (a)
        archive_read_free(a);
    return status;
}

iso_status iso_unpack(const char *path, iso_unpacked *file, iso_error *err)
{
    *file = (iso_unpacked){.folder = iso_make_temp_dir()};
    if (!file->folder)
        return iso_temp_dir_fail(err);
    FREED char *name = plain_name(path);
    file->path = name ? iso_path_join(file->folder, name) : NULL;
    const iso_status status = file->path ? unpack_to(path, file, err)
                                         : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    if (status != ISO_OK)
        iso_unpacked_remove(file);
    return status;
}

/* True if the member has that name, with the ending or without it; NULL: if it ends with it. */
static bool is_wanted(const char *member, const char *name, const char *ending)
{
    const size_t length = name ? strlen(name) : 0;
    if (!name)
        return iso_path_ends_with(member, ending);
    return strncmp(member, name, length) == 0 && (member[length] == 0 || strcmp(member + length, ending) == 0);
}

/* Counts the members that are wanted, and lists those that could be. ISO_E_FORMAT: the archive is damaged. */
static iso_status list_members(const char *path, const char *name, const char *ending, size_t *count, char *list,
                               size_t size, iso_error *err)
{
    struct archive *a = archive_read_new();
    struct archive_entry *entry;
    int code = a && archive_read_support_format_zip(a) == ARCHIVE_OK ? archive_read_open_filename(a, path, BLOCK_BYTES)
                                                                     : ARCHIVE_FATAL;
    *count = 0;
    for (size_t members = 0; code == ARCHIVE_OK && members < MOST_MEMBERS; ++members) {
        code = archive_read_next_header(a, &entry);
        const char *member = code == ARCHIVE_OK ? archive_entry_pathname(entry) : NULL;
        *count += member && is_wanted(member, name, ending);
        if (member && iso_path_ends_with(member, ending))
            iso_words_append(list, size, "%s%.*s", *list ? ", " : "", (int)(strlen(member) - strlen(ending)), member);
    }
    const iso_status status = code == ARCHIVE_EOF || code == ARCHIVE_OK ? ISO_OK : fail_damaged(a, path, err);
    archive_read_free(a);
    return status;
}

/* Unpacks the first member that is wanted. */
static iso_status unpack_member(const char *path, const char *name, const char *ending, const iso_unpacked *file,
                                iso_error *err)
{
    struct archive *a = archive_read_new();
    struct archive_entry *entry;
    struct stat st;
    FILE *out = fopen(file->path, "wb");
    if (!a || !out || stat(path, &st) != 0) {
        archive_read_free(a);
        if (out)
            fclose(out);
        return iso_fail(err, iso_errno_status(), "%s: cannot be unpacked: %s", path, strerror(errno));
    }
    int code = archive_read_support_format_zip(a);
    code = code == ARCHIVE_OK ? archive_read_open_filename(a, path, BLOCK_BYTES) : code;
    bool found = false;
    while (code == ARCHIVE_OK && !found && (code = archive_read_next_header(a, &entry)) == ARCHIVE_OK)
        found = archive_entry_pathname(entry) && is_wanted(archive_entry_pathname(entry), name, ending);
    iso_status status = found ? copy(a, path, out, most_bytes(file->folder, (double)st.st_size), err)
                              : fail_damaged(a, path, err);
    if (fclose(out) != 0 && status == ISO_OK)
        status = iso_fail(err, iso_errno_status(), "%s: cannot be unpacked into the temporary folder: %s", path,
                          strerror(errno));
    archive_read_free(a);
    return status;
}

iso_status iso_unpack_member(const char *path, const char *name, const char *ending, iso_unpacked *file, iso_error *err)
{
    size_t count;
    char list[320] = "";
    iso_status status = list_members(path, name, ending, &count, list, sizeof list, err);
    if (status == ISO_OK && count != 1)
        status = iso_fail(err, ISO_E_USAGE, "%s: %s, FILE:NAME must be one of: %s", path,
                          name ? "has no such array" : "holds several arrays", list);
    if (status != ISO_OK)
        return status;
    *file = (iso_unpacked){.folder = iso_make_temp_dir()};
    if (!file->folder)
        return iso_temp_dir_fail(err);
    file->path = iso_path_join(file->folder, "member");
    status = file->path ? unpack_member(path, name, ending, file, err)
                        : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    if (status != ISO_OK)
        iso_unpacked_remove(file);
    return status;
}

void iso_unpacked_remove(iso_unpacked *file)
{
    if (file->folder)
        iso_remove_tree(file->folder);
    free(file->folder);
    free(file->path);
    *file = (iso_unpacked){NULL};
}
