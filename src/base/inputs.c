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

#include "base/temporary.h"

/* A regular file that was noted or announced; the name under which it was is NULL where it was not. */
typedef struct known {
    struct statx at;
    char *input, *output;
} known;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static bool is_watching;
static void *files; /* of tsearch() */

static int compare(uint64_t a, uint64_t b)
{
    return (a > b) - (a < b);
}

/* The time of birth, where the file system keeps it: an inode's number goes to another file when its own is removed. */
static int by_inode(const void *a, const void *b)
{
    const struct statx *x = &((const known *)a)->at, *y = &((const known *)b)->at;
    int order = compare(x->stx_ino, y->stx_ino);
    if (order == 0)
        order = compare(x->stx_dev_major, y->stx_dev_major);
    if (order == 0)
        order = compare(x->stx_dev_minor, y->stx_dev_minor);
    if (order == 0)
        order = compare((uint64_t)x->stx_btime.tv_sec, (uint64_t)y->stx_btime.tv_sec);
    return order ? order : compare(x->stx_btime.tv_nsec, y->stx_btime.tv_nsec);
}

static bool look_at(const char *path, known *file)
{
    *file = (known){0};
    return is_watching && statx(AT_FDCWD, path, 0, STATX_TYPE | STATX_INO | STATX_BTIME, &file->at) == 0 &&
           S_ISREG(file->at.stx_mode);
}

/* With the lock held. NULL: memory has ended. */
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
    return iso_fail(err, ISO_E_USAGE, "the output %s is the input %s, which would be lost", file->output, file->input);
}

/* is_input: path is one, else an output. */
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

iso_status iso_inputs_announce(const char *output, iso_error *err)
{
    return take(output, false, err);
}

iso_status iso_inputs_check(const char *output, iso_error *err)
{
    known file;
    if (!look_at(output, &file))
        return ISO_OK;
    pthread_mutex_lock(&lock);
    void *found = tfind(&file, &files, by_inode);
    file.input = found ? (*(known **)found)->input : NULL;
    file.output = (char *)output;
    pthread_mutex_unlock(&lock);
    return file.input ? refuse(&file, err) : ISO_OK;
}
