/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/path.h"

#include <ctype.h>
#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "base/unfinished.h"

char *iso_path_join(const char *dir, const char *name)
{
    char *path = NULL;
    if (name[0] == '/')
        return strdup(name);
    return asprintf(&path, "%s/%s", dir, name) < 0 ? NULL : path;
}

char *iso_path_dir(const char *path)
{
    const char *slash = strrchr(path, '/');
    if (!slash)
        return strdup(".");
    return slash == path ? strdup("/") : strndup(path, (size_t)(slash - path));
}

const char *iso_path_base(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Repeats the call if the answer could not be read: that is not a "no". */
static bool look_at(const char *path, struct stat *st)
{
    return stat(path, st) == 0 || ((errno == EIO || errno == EINTR) && stat(path, st) == 0);
}

char *iso_path_plain_name(const char *dir)
{
    size_t end = strlen(dir), start;
    while (end > 0 && dir[end - 1] == '/')
        --end;
    for (start = end; start > 0 && dir[start - 1] != '/';)
        --start;
    char *name = end > start ? strndup(dir + start, end - start) : strdup("volume");
    for (char *c = name; c && *c; ++c)
        if (!isalnum((unsigned char)*c) && *c != '-' && *c != '_')
            *c = '_';
    return name;
}

bool iso_path_exists(const char *path)
{
    struct stat st;
    return look_at(path, &st);
}

bool iso_path_is_file(const char *path)
{
    struct stat st;
    return look_at(path, &st) && S_ISREG(st.st_mode);
}

bool iso_path_is_dir(const char *path)
{
    struct stat st;
    return look_at(path, &st) && S_ISDIR(st.st_mode);
}

bool iso_path_ends_with(const char *path, const char *suffix)
{
    size_t n = strlen(path), m = strlen(suffix);
    return n >= m && strcmp(path + n - m, suffix) == 0;
}

static int remove_entry(const char *path, const struct stat *st, int type, struct FTW *ftw)
{
    (void)st;
    (void)type;
    (void)ftw;
    return remove(path);
}

/* Repeats if a step fails, such as an allocation: no later run would find the remains. */
void iso_remove_tree(const char *path)
{
    for (int tries = 0; tries < 3; ++tries)
        if (nftw(path, remove_entry, 16, FTW_DEPTH | FTW_PHYS) == 0 || errno == ENOENT)
            break;
    remove(path); /* a file, or an empty folder, without memory */
    iso_unfinished_drop(path);
}
