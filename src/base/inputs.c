/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/inputs.h"

#include <fcntl.h>
#include <pthread.h>
#include <search.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/temporary.h"

/* A regular file that was noted or announced; the name of the use that did not occur is NULL. */
typedef struct known {
    struct statx at;
    char *input, *output;
} known;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static bool is_watching;
static void *files; /* of tsearch() */

/* A folder that was noted. */
typedef struct folder {
    struct statx at;
    char *name;
    struct folder *next;
} folder;

static folder *folders;

static int compare(uint64_t a, uint64_t b)
{
    return (a > b) - (a < b);
}

/* Compares by inode, device and, if the file system keeps it, time of birth: a removed file's inode number is
 * reused. */
static int compare_files(const struct statx *x, const struct statx *y)
{
    int order = compare(x->stx_ino, y->stx_ino);
    if (order == 0)
        order = compare(x->stx_dev_major, y->stx_dev_major);
    if (order == 0)
        order = compare(x->stx_dev_minor, y->stx_dev_minor);
    if (order == 0)
        order = compare((uint64_t)x->stx_btime.tv_sec, (uint64_t)y->stx_btime.tv_sec);
    return order ? order : compare(x->stx_btime.tv_nsec, y->stx_btime.tv_nsec);
}

static int by_inode(const void *a, const void *b)
{
    return compare_files(&((const known *)a)->at, &((const known *)b)->at);
}

static bool look_at(const char *path, known *file)
{
    *file = (known){0};
    return is_watching && statx(AT_FDCWD, path, 0, STATX_TYPE | STATX_INO | STATX_BTIME, &file->at) == 0 &&
           S_ISREG(file->at.stx_mode);
}

/* Finds the file, or adds it. The caller holds the lock. NULL: out of memory. */
static known *find_or_add(const known *file)
{
    void *found = tfind(file, &files, by_inode);
    if (found)
        return *(known **)found;
    known *own = malloc(sizeof *own);
    if (own) {
        *own = *file;
        if (!tsearch(own, &files, by_inode)) {
            free(own);
            own = NULL;
        }
    }
    return own;
}

static iso_status refuse(const known *file, iso_error *err)
{
    return iso_fail(err, ISO_E_USAGE, "the output %s would overwrite the input %s; choose another name", file->output,
                    file->input);
}

static const folder *noted_folder(const char *path)
{
    struct statx at;
    const folder *f = statx(AT_FDCWD, path, 0, STATX_INO | STATX_BTIME, &at) == 0 ? folders : NULL;
    while (f && compare_files(&at, &f->at) != 0)
        f = f->next;
    return f;
}

/* Returns the noted folder that holds a path, however deep; NULL: none. The caller holds the lock. */
static const folder *folder_of(const char *path)
{
    FREED char *parent = folders ? iso_path_dir(path) : NULL, *whole = parent ? realpath(parent, NULL) : NULL;
    const folder *found = whole ? noted_folder(whole) : NULL;
    for (char *end; whole && !found && (end = strrchr(whole, '/')) > whole;) {
        *end = 0;
        found = noted_folder(whole);
    }
    return found;
}

static iso_status check_folders(const char *output, iso_error *err)
{
    const folder *of = folder_of(output);
    return of ? iso_fail(err, ISO_E_USAGE, "the output %s would overwrite the input %s in part; choose another folder",
                         output, of->name)
              : ISO_OK;
}

/* Records path as an input or as an output. ISO_E_USAGE if it is both. */
static iso_status take(const char *path, bool is_input, iso_error *err)
{
    known file;
    if (!look_at(path, &file))
        return ISO_OK;
    pthread_mutex_lock(&lock);
    known *own = find_or_add(&file);
    char **name = !own ? NULL : is_input ? &own->input : &own->output;
    if (name && !*name)
        *name = strdup(path);
    iso_status status = !name || !*name            ? iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path)
                        : own->input && own->output ? refuse(own, err)
                                                    : ISO_OK;
    pthread_mutex_unlock(&lock);
    return status;
}

void iso_inputs_watch(void)
{
    is_watching = true;
}

iso_status iso_inputs_note(const char *path, iso_error *err)
{
    return iso_temporary_holds(path) ? ISO_OK : take(path, true, err);
}

/* A search among the announced outputs. */
typedef struct announced {
    iso_status status;
    iso_error *err;
} announced;

static void check_announced(const void *node, VISIT visit, void *closure)
{
    const known *file = *(known *const *)node;
    announced *found = closure;
    if ((visit == postorder || visit == leaf) && file->output && found->status == ISO_OK)
        found->status = check_folders(file->output, found->err);
}

static iso_status add_folder(const char *path, const struct statx *at, iso_error *err)
{
    folder *own = malloc(sizeof *own);
    char *name = strdup(path);
    if (!own || !name) {
        free(own);
        free(name);
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    }
    *own = (folder){.at = *at, .name = name, .next = folders};
    folders = own;
    return ISO_OK;
}

iso_status iso_inputs_note_folder(const char *path, iso_error *err)
{
    struct statx at;
    if (!is_watching || iso_temporary_holds(path) || statx(AT_FDCWD, path, 0, STATX_INO | STATX_BTIME, &at) != 0)
        return ISO_OK;
    announced found = {.err = err};
    pthread_mutex_lock(&lock);
    if (!noted_folder(path))
        found.status = add_folder(path, &at, err);
    twalk_r(files, check_announced, &found);
    pthread_mutex_unlock(&lock);
    return found.status;
}

iso_status iso_inputs_announce(const char *output, iso_error *err)
{
    pthread_mutex_lock(&lock);
    const iso_status status = check_folders(output, err);
    pthread_mutex_unlock(&lock);
    return status == ISO_OK ? take(output, false, err) : status;
}

iso_status iso_inputs_check(const char *output, iso_error *err)
{
    known file;
    pthread_mutex_lock(&lock);
    const iso_status status = check_folders(output, err);
    pthread_mutex_unlock(&lock);
    if (status != ISO_OK || !look_at(output, &file))
        return status;
    pthread_mutex_lock(&lock);
    void *found = tfind(&file, &files, by_inode);
    file.input = found ? (*(known **)found)->input : NULL;
    file.output = (char *)output;
    pthread_mutex_unlock(&lock);
    return file.input ? refuse(&file, err) : ISO_OK;
}

/* ---- all of them ---- */

/* Names stay as long as the process, so they are borrowed. */
typedef struct names {
    const char **all;
    size_t count, room;
    bool has_failed;
} names;

static void add_name(names *n, const char *name)
{
    if (n->count == n->room) {
        const size_t room = n->room ? 2 * n->room : 64;
        const char **more = realloc(n->all, room * sizeof *more);
        n->has_failed = n->has_failed || !more;
        if (!more)
            return;
        n->all = more;
        n->room = room;
    }
    n->all[n->count++] = name;
}

static void add_input(const void *node, VISIT visit, void *closure)
{
    const known *file = *(known *const *)node;
    if ((visit == postorder || visit == leaf) && file->input)
        add_name(closure, file->input);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

iso_status iso_inputs_visit(iso_input_visitor *visit, void *user, iso_error *err)
{
    names n = {.count = 0};
    pthread_mutex_lock(&lock);
    twalk_r(files, add_input, &n);
    for (const folder *f = folders; f; f = f->next)
        add_name(&n, f->name);
    pthread_mutex_unlock(&lock);
    iso_status status = n.has_failed ? iso_fail(err, ISO_E_MEMORY, "no memory for the names of the inputs") : ISO_OK;
    if (n.count > 0)
        qsort(n.all, n.count, sizeof *n.all, by_name);
    for (size_t i = 0; i < n.count && status == ISO_OK; ++i)
        status = visit(user, n.all[i], err);
    free(n.all);
    return status;
}
