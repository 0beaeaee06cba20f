/* SPDX-License-Identifier: MIT */
/* numbered_files.c - frames in files of their own, whose names have a number or are listed. */
#define _GNU_SOURCE
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/inputs.h"
#include "volume/file_list.h"
#include "volume/frames.h"

typedef struct numbered {
    unsigned long long number;
    char *name;
} numbered;

typedef struct numbered_files {
    numbered *file;
    size_t count, room;
} numbered_files;

/* Finds the place of a number such as %d or %04d in a file's name; NULL if there is none. */
static const char *find_place(const char *name, size_t *bytes)
{
    for (const char *at = strchr(name, '%'); at; at = strchr(at + 1, '%')) {
        *bytes = 1 + strspn(at + 1, "0123456789");
        if (at[(*bytes)++] == 'd')
            return at;
    }
    return NULL;
}

/* True if `name` is `before` bytes of the pattern, digits and `after`; *number is then the digits' value. */
static bool has_number(const char *name, const char *pattern, size_t before, const char *after,
                       unsigned long long *number)
{
    const size_t length = strlen(name), end = strlen(after);
    if (length <= before + end || strncmp(name, pattern, before) != 0 || strcmp(name + length - end, after) != 0)
        return false;
    const size_t digits = strspn(name + before, "0123456789");
    *number = strtoull(name + before, NULL, 10);
    return digits == length - before - end;
}

static int by_number(const void *a, const void *b)
{
    const numbered *x = a, *y = b;
    return x->number != y->number ? (x->number > y->number) - (x->number < y->number) : strcmp(x->name, y->name);
}

static void free_files(numbered_files *files)
{
    for (size_t i = 0; i < files->count; ++i)
        free(files->file[i].name);
    free(files->file);
}

static bool add_file(numbered_files *files, const char *folder, const char *name, unsigned long long number)
{
    if (files->count == files->room) {
        files->room = files->room ? 2 * files->room : 64;
        numbered *more = realloc(files->file, files->room * sizeof *more);
        if (!more)
            return false;
        files->file = more;
    }
    char *path = strcmp(folder, ".") == 0 ? strdup(name) : iso_path_join(folder, name);
    files->file[files->count] = (numbered){number, path};
    files->count += path != NULL;
    return path != NULL;
}

static bool find_files(const char *path, const char *base, numbered_files *files)
{
    size_t bytes = 0;
    unsigned long long number;
    const char *at = find_place(base, &bytes);
    FREED char *folder = iso_path_dir(path);
    DIR *dir = folder ? opendir(folder) : NULL;
    bool well = folder != NULL;
    for (const struct dirent *entry; dir && well && (entry = readdir(dir));)
        if (has_number(entry->d_name, base, (size_t)(at - base), at + bytes, &number))
            well = add_file(files, folder, entry->d_name, number);
    if (dir)
        closedir(dir);
    if (files->count > 1)
        qsort(files->file, files->count, sizeof *files->file, by_number);
    return well;
}

static iso_status choose_file(const char *path, const iso_volume_hints *hints,
                              const char *name_of(const void *, size_t), const void *files, iso_frame_file *found,
                              iso_error *err)
{
    const iso_volume_hints none = {0};
    const iso_extra_axes axes = {.frame = {.count = found->count}, .frame_step = found->step};
    NEED(iso_frames_choose(path, hints ? hints : &none, &axes, &found->frame, err));
    for (size_t i = 0; i < found->count; ++i) /* all: an output of one must not replace another */
        NEED(iso_inputs_note(name_of(files, i), err));
    found->path = strdup(name_of(files, found->frame));
    return found->path ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
}

static const char *numbered_at(const void *files, size_t i)
{
    return ((const numbered_files *)files)->file[i].name;
}

static const char *listed_at(const void *list, size_t i)
{
    return ((const iso_file_list *)list)->file[i].path;
}

static iso_status of_list(const char *path, const iso_volume_hints *hints, iso_frame_file *found, iso_error *err)
{
    OWNED(iso_file_list) list = {0};
    NEED(iso_file_list_read(path, &list, err));
    found->count = list.count;
    found->step = list.step;
    return choose_file(path, hints, listed_at, &list, found, err);
}

iso_status iso_frames_of_files(const char *path, const iso_volume_hints *hints, iso_frame_file *found, iso_error *err)
{
    struct stat st;
    size_t bytes;
    const char *base = iso_path_base(path);
    *found = (iso_frame_file){0};
    if (iso_file_list_is_one(path))
        return of_list(path, hints, found, err);
    if (!find_place(base, &bytes) || stat(path, &st) == 0)
        return ISO_OK;
    ENDED_BY(free_files) numbered_files files = {0};
    if (!find_files(path, base, &files))
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    if (files.count == 0)
        return iso_fail(err, ISO_E_IO, "%s: no file has a number in this place", path);
    found->count = files.count;
    return choose_file(path, hints, numbered_at, &files, found, err);
}
