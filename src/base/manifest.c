/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/manifest.h"

#include <fcntl.h>
#include <fts.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/file.h"

enum { CHECKED_BYTES = 1 << 20 };

/* A line of the list; to be freed. NULL: it is no file and no folder, or cannot be read, or memory ended. */
static char *line_of(const char *path, mode_t mode, size_t bytes, const char *name)
{
    char *line = NULL, sum[20] = "-";
    const bool is_folder = S_ISDIR(mode);
    if (!is_folder && !S_ISREG(mode))
        return NULL;
    if (!is_folder && bytes <= CHECKED_BYTES) {
        char *data;
        size_t size;
        if (iso_file_read(path, &data, &size, NULL) != ISO_OK)
            return NULL;
        snprintf(sum, sizeof sum, "%016" PRIx64, (uint64_t)XXH3_64bits(data, size));
        free(data);
    }
    return asprintf(&line, "%c %zu %s %s\n", is_folder ? 'd' : 'f', is_folder ? 0 : bytes, sum, name) < 0 ? NULL : line;
}

static char *line_of_entry(const FTSENT *entry, const char *name)
{
    if (entry->fts_info != FTS_D && entry->fts_info != FTS_F)
        return NULL;
    return line_of(entry->fts_accpath, entry->fts_statp->st_mode, (size_t)entry->fts_statp->st_size, name);
}

/* Calls entry for all that is in folder but the list itself, in the order of names, until it does not return ISO_OK. */
typedef iso_status visit(void *user, const FTSENT *entry, const char *name, iso_error *err);

static int by_name(const FTSENT **a, const FTSENT **b)
{
    return strcmp((*a)->fts_name, (*b)->fts_name);
}

static iso_status walk(const char *folder, visit *entry, void *user, iso_error *err)
{
    char *const roots[] = {(char *)folder, NULL};
    FTS *tree = fts_open(roots, FTS_PHYSICAL | FTS_NOCHDIR, by_name);
    if (!tree)
        return iso_fail(err, ISO_E_IO, "%s: cannot be listed", folder);
    iso_status status = ISO_OK;
    for (FTSENT *e; status == ISO_OK && (e = fts_read(tree));) {
        if (e->fts_level == 0 || e->fts_info == FTS_DP)
            continue;
        const char *name = e->fts_path + strlen(folder) + 1;
        if (e->fts_level > 1 || strcmp(e->fts_name, ISO_MANIFEST_NAME) != 0)
            status = entry(user, e, name, err);
    }
    fts_close(tree);
    return status;
}

static iso_status list_entry(void *user, const FTSENT *entry, const char *name, iso_error *err)
{
    if (strchr(name, '\n'))
        return iso_fail(err, ISO_E_IO, "%s: a line feed in a name", name);
    char *line = line_of_entry(entry, name);
    const bool good = line && fputs(line, user) >= 0;
    free(line);
    return good ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be listed", name);
}

iso_status iso_manifest_write(const char *folder, iso_error *err)
{
    char *text = NULL, *path = iso_path_join(folder, ISO_MANIFEST_NAME);
    size_t bytes = 0;
    FILE *memory = path ? open_memstream(&text, &bytes) : NULL;
    iso_status status = memory ? walk(folder, list_entry, memory, err) : ISO_E_MEMORY;
    if (memory && fclose(memory) != 0)
        status = ISO_E_MEMORY;
    FILE *file = status == ISO_OK ? fopen(path, "we") : NULL;
    if (status == ISO_OK) {
        bool good = file && fwrite(text, 1, bytes, file) == bytes;
        good = file && fclose(file) == 0 && good;
        status = good ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be written", path);
    } else if (status == ISO_E_MEMORY) {
        iso_fail(err, status, "%s: no memory for the list of its files", folder);
    }
    free(text);
    free(path);
    return status;
}

/* One write at the end of the file, so that no other process's line is lost. */
void iso_manifest_add(const char *folder, const char *name)
{
    struct stat st;
    char *path = iso_path_join(folder, name), *list = iso_path_join(folder, ISO_MANIFEST_NAME), *line = NULL;
    if (path && list && stat(path, &st) == 0)
        line = line_of(path, st.st_mode, (size_t)st.st_size, name);
    const int fd = line ? open(list, O_WRONLY | O_APPEND | O_CLOEXEC) : -1;
    /* Without its line the folder is not replaced, and says why: no harm. */
    const ssize_t written = fd >= 0 ? write(fd, line, strlen(line)) : 0;
    (void)written;
    if (fd >= 0)
        close(fd);
    free(line);
    free(list);
    free(path);
}

/* ---- is all of it ours? ---- */

typedef struct listed {
    const char *shown, *text; /* text: the list, a line feed before its first line */
} listed;

static bool has_line(const char *text, const char *line)
{
    char *whole = NULL;
    const bool found = asprintf(&whole, "\n%s", line) >= 0 && strstr(text, whole);
    free(whole);
    return found;
}

static bool has_name(const char *text, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = strstr(text, name); at; at = strstr(at + 1, name))
        if (at > text && at[-1] == ' ' && at[length] == '\n')
            return true;
    return false;
}

static iso_status check_entry(void *user, const FTSENT *entry, const char *name, iso_error *err)
{
    const listed *list = user;
    char *line = line_of_entry(entry, name);
    const bool same = line && has_line(list->text, line);
    free(line);
    if (same)
        return ISO_OK;
    if (has_name(list->text, name))
        return iso_fail(err, ISO_E_IO,
                        "%s: %s in it was changed since isoshade wrote it, so the folder is not replaced; move it away, or choose another output",
                        list->shown, name);
    return iso_fail(err, ISO_E_IO,
                    "%s: %s in it is not isoshade's, so the folder is not replaced; move it away, or choose another output",
                    list->shown, name);
}

iso_status iso_manifest_check(const char *folder, const char *shown, iso_error *err)
{
    char *path = iso_path_join(folder, ISO_MANIFEST_NAME), *data = NULL, *text = NULL;
    size_t bytes;
    iso_status status = path ? iso_file_read(path, &data, &bytes, NULL) : ISO_E_MEMORY;
    if (status != ISO_OK)
        status = iso_fail(err, ISO_E_IO,
                          "%s: has no list of isoshade's files (" ISO_MANIFEST_NAME
                          "), so it is not replaced; remove it, or choose another output",
                          shown);
    else if (asprintf(&text, "\n%s", data) < 0)
        status = iso_fail(err, ISO_E_MEMORY, "%s: out of memory", shown);
    if (status == ISO_OK)
        status = walk(folder, check_entry, &(listed){shown, text}, err);
    free(text);
    free(data);
    free(path);
    return status;
}
