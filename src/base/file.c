/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

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

bool iso_path_exists(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0;
}

bool iso_path_is_dir(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0 && S_ISDIR(st.st_mode);
}

bool iso_path_ends_with(const char *path, const char *suffix)
{
    size_t n = strlen(path), m = strlen(suffix);
    return n >= m && strcmp(path + n - m, suffix) == 0;
}

/* The temporary keeps the final name's ending, since many libraries choose the
 * format by it, and starts with a dot, so that no glob takes it for a result. */
static iso_status reserve(iso_output *out, const char *path, iso_error *err)
{
    *out = (iso_output){0};
    if (path[0] == 0)
        return iso_fail(err, ISO_E_USAGE, "the output path is empty");
    char *trimmed = strdup(path);
    if (!trimmed)
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    for (size_t n = strlen(trimmed); n > 1 && trimmed[n - 1] == '/'; --n)
        trimmed[n - 1] = 0;
    char *dir = iso_path_dir(trimmed);
    if (dir && asprintf(&out->temp_path, "%s/.%ld-%s", dir, (long)getpid(), iso_path_base(trimmed)) < 0)
        out->temp_path = NULL;
    out->final_path = trimmed;
    iso_status status = ISO_OK;
    if (!dir || !out->temp_path)
        status = iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    else if (!iso_path_is_dir(dir))
        status = iso_fail(err, ISO_E_IO, "%s: the folder %s does not exist", path, dir);
    else if (access(dir, W_OK) != 0)
        status = iso_fail(err, ISO_E_IO, "%s: the folder %s is not writable: %s", path, dir, strerror(errno));
    free(dir);
    if (status != ISO_OK) {
        free(out->final_path);
        free(out->temp_path);
        *out = (iso_output){0};
    }
    return status;
}

iso_status iso_output_begin(iso_output *out, const char *path, iso_error *err)
{
    if (iso_path_is_dir(path)) {
        *out = (iso_output){0};
        return iso_fail(err, ISO_E_IO, "%s: is a directory, wanted a file name", path);
    }
    iso_status status = reserve(out, path, err);
    if (status != ISO_OK)
        return status;
    int fd = open(out->temp_path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (fd < 0) {
        status = iso_fail(err, ISO_E_IO, "%s: cannot be written: %s", path, strerror(errno));
        iso_output_abandon(out);
        return status;
    }
    close(fd);
    return ISO_OK;
}

static int remove_below(const char *path, const struct stat *st, int type, struct FTW *ftw)
{
    (void)st;
    (void)type;
    return ftw->level > 0 ? remove(path) : 0;
}

void iso_output_clear(const iso_output *out)
{
    nftw(out->temp_path, remove_below, 16, FTW_DEPTH | FTW_PHYS);
}

/* What stands at the final path may be replaced: nothing, an empty directory, or one of ours. */
static iso_status check_replaceable(const iso_output *out, const char *path, const char *marker, iso_error *err)
{
    if (!iso_path_exists(out->final_path))
        return ISO_OK;
    char *mark = iso_path_join(out->final_path, marker);
    bool ours = mark && iso_path_exists(mark);
    bool empty = rmdir(out->final_path) == 0; /* an empty directory is no loss */
    free(mark);
    if (ours || empty)
        return ISO_OK;
    return iso_fail(err, ISO_E_IO, "%s: exists and holds no %s, so it is not replaced", path, marker);
}

iso_status iso_output_begin_dir(iso_output *out, const char *path, const char *marker, iso_error *err)
{
    iso_status status = reserve(out, path, err);
    if (status != ISO_OK)
        return status;
    status = check_replaceable(out, path, marker, err);
    if (status == ISO_OK) {
        iso_remove_tree(out->temp_path);
        if (mkdir(out->temp_path, 0777) != 0)
            status = iso_fail(err, ISO_E_IO, "%s: cannot be created: %s", path, strerror(errno));
    }
    if (status != ISO_OK)
        iso_output_abandon(out);
    return status;
}

iso_status iso_output_resume_dir(iso_output *out, const char *path, const char *marker, bool resume, bool *resumed,
                                 iso_error *err)
{
    *resumed = false;
    iso_status status = reserve(out, path, err);
    if (status != ISO_OK)
        return status;
    char *dir = iso_path_dir(out->final_path), *temp = NULL;
    if (!dir || asprintf(&temp, "%s/.%s.partial", dir, iso_path_base(out->final_path)) < 0)
        temp = NULL;
    free(dir);
    free(out->temp_path);
    out->temp_path = temp;
    status = temp ? check_replaceable(out, path, marker, err) : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    if (status != ISO_OK) {
        free(out->final_path); /* a temporary of an earlier run stays */
        free(out->temp_path);
        *out = (iso_output){0};
        return status;
    }
    *resumed = resume && iso_path_is_dir(temp);
    if (mkdir(temp, 0777) != 0 && errno != EEXIST) {
        status = iso_fail(err, ISO_E_IO, "%s: cannot be created: %s", path, strerror(errno));
        iso_output_abandon(out);
        return status;
    }
    int fd = open(temp, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0 || flock(fd, LOCK_EX | LOCK_NB) != 0) {
        status = iso_fail(err, ISO_E_IO, "%s: another process is making it: %s", path, strerror(errno));
        if (fd >= 0)
            close(fd);
        free(out->final_path);
        free(out->temp_path);
        *out = (iso_output){0};
        return status;
    }
    out->lock = fd + 1;
    if (!*resumed)
        iso_output_clear(out);
    return ISO_OK;
}

void iso_output_rename_in(const char *temp_path, const char *final_path, iso_error *err)
{
    char *at = err && *temp_path ? strstr(err->text, temp_path) : NULL;
    if (!at)
        return;
    iso_error found = *err;
    const size_t before = (size_t)(at - err->text);
    snprintf(err->text, sizeof err->text, "%.*s%s%s", (int)before, found.text, final_path,
             found.text + before + strlen(temp_path));
}

void iso_output_rename_all_in(iso_error *err)
{
    char mark[32]; /* as reserve() puts it before the name */
    snprintf(mark, sizeof mark, "/.%ld-", (long)getpid());
    const size_t length = strlen(mark);
    for (char *at = strstr(err->text, mark); at; at = strstr(at + 1, mark))
        memmove(at + 1, at + length, strlen(at + length) + 1);
}

/* A directory cannot be renamed over a full one: the old one steps aside first. */
static int rename_dir(const char *from, const char *to)
{
    char *aside = NULL;
    if (asprintf(&aside, "%s.old", from) < 0)
        return -1;
    bool stood = rename(to, aside) == 0;
    int result = rename(from, to);
    if (result != 0 && stood && rename(aside, to) != 0)
        result = -1; /* the old directory is left under its aside name */
    else if (stood)
        iso_remove_tree(aside);
    free(aside);
    return result;
}

iso_status iso_output_commit(iso_output *out, iso_error *err)
{
    int result = iso_path_is_dir(out->temp_path) ? rename_dir(out->temp_path, out->final_path)
                                                 : rename(out->temp_path, out->final_path);
    iso_status status = ISO_OK;
    if (result != 0)
        status = iso_fail(err, ISO_E_IO, "%s: cannot be put in place: %s", out->final_path, strerror(errno));
    iso_output_abandon(out);
    return status;
}

void iso_output_keep(iso_output *out)
{
    if (!out || !out->temp_path)
        return;
    if (out->lock > 0)
        close(out->lock - 1);
    free(out->temp_path);
    free(out->final_path);
    *out = (iso_output){0};
}

void iso_output_abandon(iso_output *out)
{
    if (out && out->temp_path)
        iso_remove_tree(out->temp_path);
    iso_output_keep(out);
}

static int remove_entry(const char *path, const struct stat *st, int type, struct FTW *ftw)
{
    (void)st;
    (void)type;
    (void)ftw;
    return remove(path);
}

void iso_remove_tree(const char *path)
{
    nftw(path, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
}

char *iso_make_temp_dir(void)
{
    const char *base = getenv("TMPDIR");
    char *path = NULL;
    if (asprintf(&path, "%s/isoshade-XXXXXX", base && *base ? base : "/tmp") < 0)
        return NULL;
    if (!mkdtemp(path)) {
        free(path);
        return NULL;
    }
    return path;
}

iso_status iso_file_read(const char *path, char **data, size_t *size, iso_error *err)
{
    *data = NULL;
    *size = 0;
    FILE *file = fopen(path, "rb");
    if (!file)
        return iso_fail(err, ISO_E_IO, "%s: cannot be opened: %s", path, strerror(errno));
    iso_status status = ISO_OK;
    struct stat st;
    if (fstat(fileno(file), &st) != 0 || !S_ISREG(st.st_mode)) {
        status = iso_fail(err, ISO_E_IO, "%s: is not a regular file", path);
    } else {
        size_t bytes = (size_t)st.st_size;
        *data = malloc(bytes + 1);
        if (!*data)
            status = iso_fail(err, ISO_E_MEMORY, "%s: no memory for %zu bytes", path, bytes);
        else if (fread(*data, 1, bytes, file) != bytes)
            status = iso_fail(err, ISO_E_IO, "%s: read error: %s", path, strerror(errno));
        else
            (*data)[bytes] = 0, *size = bytes;
    }
    if (status != ISO_OK) {
        free(*data);
        *data = NULL;
    }
    fclose(file);
    return status;
}

iso_status iso_file_write(const char *path, const void *data, size_t size, iso_error *err)
{
    iso_output out;
    iso_status status = iso_output_begin(&out, path, err);
    if (status != ISO_OK)
        return status;
    FILE *file = fopen(out.temp_path, "wb");
    bool good = file && fwrite(data, 1, size, file) == size;
    if (file && fclose(file) != 0)
        good = false;
    if (good)
        return iso_output_commit(&out, err);
    status = iso_fail(err, ISO_E_IO, "%s: cannot be written: %s", path, strerror(errno));
    iso_output_abandon(&out);
    return status;
}
