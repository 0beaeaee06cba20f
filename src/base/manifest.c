/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/manifest.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/file.h"
#include "base/inputs.h"

/* A pyramid that bypassed the page cache would be read from the disk again for its checksums, and twice when another
 * replaces it. That takes a good part of a build's time. So larger files are identified by their size, and by a
 * change after the list was written. */
enum { CHECKED_BYTES = 1 << 20 };

/* An entry of a folder. */
typedef struct entry {
    const char *path, *name; /* name: its path in the folder */
    struct stat st;
} entry;

static bool is_large(const entry *e)
{
    return S_ISREG(e->st.st_mode) && e->st.st_size > CHECKED_BYTES;
}

/* Makes its line of the list, to be freed; NULL if it is neither a file nor a folder. */
static iso_status line_of(const entry *e, bool is_hashed, char **line, iso_error *err)
{
    char sum[20] = "-";
    const bool is_folder = S_ISDIR(e->st.st_mode);
    const size_t bytes = is_folder ? 0 : (size_t)e->st.st_size;
    *line = NULL;
    if (!is_folder && !S_ISREG(e->st.st_mode))
        return ISO_OK;
    if (!is_folder && is_hashed) {
        FREED char *data = NULL;
        size_t size;
        NEED(iso_file_read(e->path, &data, &size, err));
        snprintf(sum, sizeof sum, "%016" PRIx64, (uint64_t)XXH3_64bits(data, size));
    }
    if (asprintf(line, "%c %zu %s %s\n", is_folder ? 'd' : 'f', bytes, sum, e->name) >= 0)
        return ISO_OK;
    *line = NULL;
    return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", e->path);
}

/* Calls visit for all that is in folder but the list itself, in the order of names, until it does not return ISO_OK. */
typedef iso_status visitor(void *user, const entry *e, iso_error *err);

static int is_no_dot(const struct dirent *e)
{
    return strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

static iso_status walk_below(const char *folder, const char *below, visitor *visit, void *user, iso_error *err);

static iso_status walk_entry(const char *folder, const char *name, visitor *visit, void *user, iso_error *err)
{
    entry e = {.path = iso_path_join(folder, name), .name = name};
    iso_status status = e.path ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", folder);
    if (status == ISO_OK && lstat(e.path, &e.st) != 0)
        status = iso_fail(err, iso_errno_status(), "%s: cannot be looked at: %s", e.path, strerror(errno));
    TRY(status, visit(user, &e, err));
    if (status == ISO_OK && S_ISDIR(e.st.st_mode))
        status = walk_below(folder, name, visit, user, err);
    free((char *)e.path);
    return status;
}

/* Visits the entries of a folder. below: a path in folder; "": folder itself. */
static iso_status walk_below(const char *folder, const char *below, visitor *visit, void *user, iso_error *err)
{
    FREED struct dirent **entries = NULL;
    FREED char *path = iso_path_join(folder, below);
    const int count = path ? scandir(path, &entries, is_no_dot, by_name) : 0;
    iso_status status = !path ? iso_fail(err, ISO_E_MEMORY, "%s: out of memory", folder)
                        : count < 0
                            ? iso_fail(err, iso_errno_status(), "%s: cannot be listed: %s", path, strerror(errno))
                            : ISO_OK;
    for (int i = 0; i < count; ++i) {
        FREED char *name = NULL;
        if (status == ISO_OK && (*below || strcmp(entries[i]->d_name, ISO_MANIFEST_NAME) != 0)) {
            name = *below ? iso_path_join(below, entries[i]->d_name) : strdup(entries[i]->d_name);
            status = name ? walk_entry(folder, name, visit, user, err)
                          : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", folder);
        }
        free(entries[i]);
    }
    return status;
}

typedef struct listing {
    FILE *lines;
    const char *const *own; /* or NULL */
} listing;

static iso_status list_entry(void *user, const entry *e, iso_error *err)
{
    const listing *l = user;
    FREED char *line = NULL;
    if (l->own && !iso_output_is_own(l->own, e->name))
        return ISO_OK;
    if (strchr(e->name, '\n'))
        return iso_fail(err, ISO_E_IO, "%s: a line feed in a name", e->name);
    NEED(line_of(e, !is_large(e), &line, err));
    if (!line)
        return iso_fail(err, ISO_E_IO, "%s: is neither a file nor a folder", e->name);
    fputs(line, l->lines);
    return ISO_OK;
}

iso_status iso_manifest_write(const char *folder, const char *const *own, iso_error *err)
{
    FREED char *text = NULL, *path = iso_path_join(folder, ISO_MANIFEST_NAME);
    size_t bytes = 0;
    FILE *memory = path ? open_memstream(&text, &bytes) : NULL;
    NEED_MEMORY(memory, err, "%s: no memory for the list of its files", folder);
    const iso_status walked = walk_below(folder, "", list_entry, &(listing){memory, own}, err);
    const bool is_whole = iso_memory_close(memory) == 0;
    NEED(walked);
    NEED_MEMORY(is_whole, err, "%s: no memory for the list of its files", folder);
    FILE *file = fopen(path, "we");
    bool good = file && fwrite(text, 1, bytes, file) == bytes;
    good = file && fclose(file) == 0 && good;
    return !good ? iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno)) : ISO_OK;
}

/* Adds a line by one write at the end of the file, so that no other process's line is lost. A line that does not fit
 * is left out whole. The list keeps its time, by which older large files are checked; so this file's line has the
 * checksum. */
bool iso_manifest_add(const char *folder, const char *name)
{
    FREED char *path = iso_path_join(folder, name), *list = iso_path_join(folder, ISO_MANIFEST_NAME), *line = NULL;
    entry e = {.path = path, .name = name};
    if (path && list && stat(path, &e.st) == 0)
        line_of(&e, true, &line, NULL);
    const int fd = line ? open(list, O_WRONLY | O_APPEND | O_CLOEXEC) : -1;
    bool good = line && fd < 0 && errno == ENOENT; /* no list, no line */
    if (fd >= 0) {
        struct stat before;
        const off_t end = lseek(fd, 0, SEEK_END);
        const bool has_time = fstat(fd, &before) == 0;
        good = write(fd, line, strlen(line)) == (ssize_t)strlen(line);
        if (!good && end >= 0 && ftruncate(fd, end) != 0)
            good = false; /* the folder is not replaced then, with a message */
        if (has_time)
            futimens(fd, (const struct timespec[]){{.tv_nsec = UTIME_OMIT}, before.st_mtim});
        close(fd);
    }
    return good;
}

iso_status iso_manifest_add_output(const char *folder, const char *path, iso_error *err)
{
    FREED char *whole_folder = realpath(folder, NULL), *whole_path = realpath(path, NULL);
    const size_t length = whole_folder ? strlen(whole_folder) : 0;
    const bool is_in = whole_folder && whole_path && strncmp(whole_path, whole_folder, length) == 0 &&
                       whole_path[length] == '/';
    const bool good = !is_in || iso_manifest_add(folder, whole_path + length + 1);
    return good ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be added to %s/" ISO_MANIFEST_NAME, path, folder);
}

/* ---- is all of it ours? ---- */

typedef struct listed {
    const char *shown, *text; /* text: the list, a line feed before its first line */
    struct timespec written;
} listed;

/* True if a text that begins with a line feed has this line, which ends with one. */
static bool has_line(const char *text, const char *line)
{
    for (const char *at = strstr(text, line); at; at = strstr(at + 1, line))
        if (at > text && at[-1] == '\n')
            return true;
    return false;
}

static bool has_name(const char *text, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = strstr(text, name); at; at = strstr(at + 1, name))
        if (at > text && at[-1] == ' ' && at[length] == '\n')
            return true;
    return false;
}

static bool is_after(struct timespec a, struct timespec b)
{
    return a.tv_sec != b.tv_sec ? a.tv_sec > b.tv_sec : a.tv_nsec > b.tv_nsec;
}

static iso_status has_entry(const listed *list, const entry *e, bool is_hashed, bool *found, iso_error *err)
{
    FREED char *line = NULL;
    NEED(line_of(e, is_hashed, &line, err));
    *found = line && has_line(list->text, line);
    return ISO_OK;
}

/* Sets *same to true if the entry is in the list and unchanged. */
static iso_status is_unchanged(const listed *list, const entry *e, bool *same, iso_error *err)
{
    *same = false;
    iso_status status = ISO_OK;
    if (is_large(e)) {
        status = has_entry(list, e, false, same, err);
        if (*same)
            *same = !is_after(e->st.st_mtim, list->written);
    }
    return status == ISO_OK && !*same && has_name(list->text, e->name) ? has_entry(list, e, true, same, err) : status;
}

static iso_status check_entry(void *user, const entry *e, iso_error *err)
{
    const listed *list = user;
    const char *name = e->name;
    bool same = false;
    iso_status status = iso_inputs_check(e->path, err);
    TRY(status, is_unchanged(list, e, &same, err));
    if (status != ISO_OK || same)
        return status;
    if (has_name(list->text, name))
        return iso_fail(
            err, ISO_E_IO,
            "%s: %s in it was changed since isoshade wrote it, so the folder is not replaced; move it away, or choose another output",
            list->shown, name);
    return iso_fail(
        err, ISO_E_IO,
        "%s: %s in it is not isoshade's, so the folder is not replaced; move it away, or choose another output",
        list->shown, name);
}

iso_status iso_manifest_check(const char *folder, const char *shown, iso_error *err)
{
    FREED char *path = iso_path_join(folder, ISO_MANIFEST_NAME), *data = NULL, *text = NULL;
    size_t bytes;
    struct stat st = {0};
    NEED_MEMORY(path, err, "%s: out of memory", shown);
    if (stat(path, &st) != 0 && errno == ENOENT)
        return iso_fail(err, ISO_E_IO,
                        "%s: has no list of isoshade's files (" ISO_MANIFEST_NAME
                        "), so it is not replaced; remove it, or choose another output",
                        shown);
    NEED(iso_file_read(path, &data, &bytes, err));
    if (asprintf(&text, "\n%s", data) < 0) {
        text = NULL;
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", shown);
    }
    return walk_below(folder, "", check_entry, &(listed){shown, text, st.st_mtim}, err);
}
