/* SPDX-License-Identifier: MIT */
/* Outputs that appear whole or not at all: see file.h. */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <fnmatch.h>
#include <ftw.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/manifest.h"
#include "base/progress.h"
#include "base/temporary.h"
#include "base/unfinished.h"

/* Returns path without slashes at its end. A link is followed: the file or folder that it names is replaced, the link
 * stays. */
static iso_status find_target(const char *path, char **target, iso_error *err)
{
    struct stat st;
    char *trimmed = strdup(path);
    *target = trimmed;
    NEED_MEMORY(trimmed, err, "%s: out of memory", path);
    for (size_t n = strlen(trimmed); n > 1 && trimmed[n - 1] == '/'; --n)
        trimmed[n - 1] = 0;
    if (lstat(trimmed, &st) != 0)
        return ISO_OK;
    if (S_ISLNK(st.st_mode)) {
        char *named = realpath(trimmed, NULL);
        if (!named)
            return iso_fail(err, iso_errno_status(), "%s: is a link whose target cannot be reached: %s", path,
                            strerror(errno));
        free(trimmed);
        *target = named;
        if (lstat(named, &st) != 0)
            return iso_fail(err, iso_errno_status(), "%s: cannot be reached: %s", path, strerror(errno));
    }
    if (!S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode))
        return iso_fail(err, ISO_E_IO, "%s: is a device, a pipe or a socket; an output has to be a file or a folder",
                        path);
    return ISO_OK;
}

static iso_status reserve(iso_output *out, const char *path, iso_error *err)
{
    *out = (iso_output){0};
    if (path[0] == 0)
        return iso_fail(err, ISO_E_USAGE, "the output path is empty");
    FREED char *dir = NULL;
    iso_status status = find_target(path, &out->final_path, err);
    TRY(status, iso_inputs_check(out->final_path, err));
    if (status == ISO_OK && !(dir = iso_path_dir(out->final_path)))
        status = iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    if (status == ISO_OK && !iso_path_is_dir(dir))
        status = iso_fail(err, ISO_E_IO, "%s: the folder %s does not exist", path, dir);
    if (status == ISO_OK && access(dir, W_OK) != 0)
        status = iso_fail(err, iso_errno_status(), "%s: the folder %s is not writable: %s", path, dir, strerror(errno));
    if (status == ISO_OK) {
        iso_temporary_sweep(dir);
        out->temp_path = iso_temporary_path(dir, iso_path_base(out->final_path));
        if (out->temp_path)
            iso_unfinished_add(out->temp_path, false);
        else
            status = iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    }
    if (status != ISO_OK) {
        free(out->final_path);
        *out = (iso_output){0};
    }
    return status;
}

iso_status iso_output_begin(iso_output *out, const char *path, iso_error *err)
{
    if (iso_path_is_dir(path)) {
        *out = (iso_output){0};
        return iso_fail(err, ISO_E_IO, "%s: is a directory, must be a file", path);
    }
    iso_status status = reserve(out, path, err);
    if (status != ISO_OK)
        return status;
    int fd = open(out->temp_path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (fd < 0) {
        status = iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
        iso_output_abandon(out);
        return status;
    }
    close(fd);
    return ISO_OK;
}

static bool has_marker(const char *folder, const char *marker)
{
    DIR *dir = opendir(folder);
    bool found = false;
    for (const struct dirent *e; dir && !found && (e = readdir(dir));)
        found = fnmatch(marker, e->d_name, FNM_PERIOD) == 0;
    if (dir)
        closedir(dir);
    return found;
}

/* Locks the finished folder while it is checked or replaced, so that no other process replaces it meanwhile. fd is
 * below 0 without an error if no folder has the name. */
static iso_status lock_final(const char *final_path, iso_folder_lock *lock, iso_error *err)
{
    *lock = iso_folder_lock_take(final_path, false);
    if (lock->fd >= 0 || lock->cause == ENOENT || lock->cause == ENOTDIR)
        return ISO_OK;
    if (lock->cause == EWOULDBLOCK)
        return iso_fail(err, ISO_E_IO, "%s: another process works in it; wait for its end, or choose another output",
                        final_path);
    errno = lock->cause;
    return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", final_path, strerror(errno));
}

static void unlock(const iso_folder_lock *lock)
{
    if (lock->fd >= 0)
        close(lock->fd);
}

static iso_status check_locked(const char *final_path, const char *marker, iso_error *err)
{
    if (has_marker(final_path, marker))
        return iso_manifest_check(final_path, final_path, err);
    if (rmdir(final_path) == 0) /* an empty folder may be removed */
        return ISO_OK;
    return iso_fail(err, ISO_E_IO, "%s: exists and holds no %s, so it is not replaced", final_path, marker);
}

/* Refuses all but nothing, an empty directory, and one of ours with nothing else in it. */
static iso_status check_replaceable(const char *final_path, const char *marker, iso_error *err)
{
    iso_folder_lock lock;
    iso_status status = lock_final(final_path, &lock, err);
    if (status == ISO_OK && lock.cause != ENOENT)
        status = check_locked(final_path, marker, err);
    unlock(&lock);
    return status;
}

iso_status iso_output_begin_dir(iso_output *out, const char *path, const char *marker, iso_error *err)
{
    NEED(reserve(out, path, err));
    iso_status status = check_replaceable(out->final_path, marker, err);
    if (status == ISO_OK) {
        out->is_folder = true;
        if (mkdir(out->temp_path, 0777) != 0)
            status = iso_fail(err, iso_errno_status(), "%s: cannot be created: %s", path, strerror(errno));
    }
    if (status != ISO_OK)
        iso_output_abandon(out);
    return status;
}

/* ---- folders of resumable work: their names are public, so their entries need not be ours ---- */

/* True if the command gives this name to its files there, or it is the list of files, or a temporary of one of them. */
bool iso_output_is_own(const char *const *own, const char *name)
{
    for (; *own; ++own)
        if (fnmatch(*own, name, FNM_PERIOD) == 0)
            return true;
    return fnmatch(".isoshade-*", name, 0) == 0;
}

/* Opens the partial folder for listing. Its descriptor is the output's lock. To be closed. */
static DIR *list_partial(const iso_output *out)
{
    const int fd = openat(out->lock - 1, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *dir = fd >= 0 ? fdopendir(fd) : NULL;
    if (!dir && fd >= 0)
        close(fd);
    return dir;
}

/* Checks a folder's entries. ISO_E_IO, with the first entry that does not belong to the command. */
static iso_status check_own(const iso_output *out, const char *path, iso_error *err)
{
    DIR *dir = list_partial(out);
    iso_status status = ISO_OK;
    struct stat st;
    if (!dir)
        return iso_fail(err, iso_errno_status(), "%s: %s cannot be listed: %s", path, iso_path_base(out->temp_path),
                        strerror(errno));
    for (const struct dirent *e; status == ISO_OK && (e = readdir(dir));)
        if (strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0 &&
            (!iso_output_is_own(out->own, e->d_name) || fstatat(dirfd(dir), e->d_name, &st, AT_SYMLINK_NOFOLLOW) != 0 ||
             !S_ISREG(st.st_mode)))
            status = iso_fail(err, ISO_E_IO, "%s: %s in %s is not isoshade's; move it away, or choose another output",
                              path, e->d_name, out->temp_path);
    closedir(dir);
    return status;
}

void iso_output_clear(const iso_output *out)
{
    DIR *dir = list_partial(out);
    for (const struct dirent *e; dir && (e = readdir(dir));)
        if (iso_output_is_own(out->own, e->d_name))
            unlinkat(dirfd(dir), e->d_name, 0);
    if (dir)
        closedir(dir);
}

/* Creates the folder, or opens an existing one, and locks it. No link is followed, and another user's folder is
 * refused: its owner may change it meanwhile. Without locks two processes could mix their work in it. */
static iso_status lock_partial(iso_output *out, const char *path, bool *is_new, iso_error *err)
{
    struct stat st;
    const iso_folder_lock lock = iso_folder_lock_take(out->temp_path, true);
    out->lock = lock.fd + 1;
    *is_new = lock.fd >= 0 && lock.made;
    errno = lock.cause;
    if (lock.cause == EWOULDBLOCK)
        return iso_fail(err, ISO_E_IO, "%s: another process is making it; wait for its end, or choose another output",
                        path);
    if (lock.fd < 0 && (lock.cause == ENOTDIR || lock.cause == ELOOP))
        return iso_fail(err, ISO_E_IO, "%s: %s cannot be opened as a folder: %s", path, out->temp_path,
                        strerror(errno));
    if (lock.fd < 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be created: %s", path, strerror(errno));
    if (lock.cause)
        return iso_fail(err, ISO_E_IO, "%s: the file system cannot lock a folder: %s; choose another output", path,
                        strerror(errno));
    if (fstat(lock.fd, &st) != 0 || st.st_uid != geteuid())
        return iso_fail(err, ISO_E_IO, "%s: %s is another user's; choose another output", path, out->temp_path);
    return lock.made ? ISO_OK : check_own(out, path, err);
}

/* Replaces the temporary's name, which is not known beforehand, by the partial name. */
static iso_status name_partial(iso_output *out, const char *path, iso_error *err)
{
    char *dir = iso_path_dir(out->final_path), *temp = NULL;
    if (!dir || asprintf(&temp, "%s/.%s.partial", dir, iso_path_base(out->final_path)) < 0)
        temp = NULL;
    free(dir);
    iso_unfinished_drop(out->temp_path);
    free(out->temp_path);
    out->temp_path = temp;
    return temp ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
}

iso_status iso_output_resume_dir(iso_output *out, const char *path, const char *const *own, bool resume, bool *resumed,
                                 iso_error *err)
{
    bool is_new = false;
    *resumed = false;
    NEED(reserve(out, path, err));
    out->is_folder = true;
    out->own = own;
    iso_status status = name_partial(out, path, err);
    TRY(status, lock_partial(out, path, &is_new, err));
    if (status == ISO_OK) /* after the lock: another process may have finished meanwhile */
        status = check_replaceable(out->final_path, own[0], err);
    if (status != ISO_OK) {
        if (is_new)
            rmdir(out->temp_path);
        iso_output_keep(out); /* the files of an earlier run stay */
        return status;
    }
    *resumed = resume && !is_new;
    if (!*resumed) { /* the files of an earlier run are not ours to remove */
        iso_unfinished_add(out->temp_path, true);
        iso_output_clear(out);
    }
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

/* Exchanges both folders in one step. File systems without that operation rename the old one first, to a name unlike
 * those of temporaries. */
static int exchange(const char *from, const char *to)
{
    if (renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_EXCHANGE) == 0)
        return 0;
    FREED char *aside = NULL;
    if (asprintf(&aside, "%s.before", to) < 0)
        return -1;
    int result = rename(to, aside);
    if (result == 0) {
        result = rename(from, to);
        const int cause = errno;
        /* Else another process has put its own there meanwhile, which replaces the old one, too. */
        if (rename(aside, result == 0 ? from : to) != 0 && iso_path_exists(to))
            iso_remove_tree(aside);
        errno = cause;
    }
    return result;
}

/* Flushes to the disk: a finished output has to survive a power failure a moment later. */
static int flush_to_disk(const char *path)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return -1;
    const int result = fsync(fd);
    const int cause = errno;
    close(fd);
    errno = cause;
    return result == 0 || cause == EINVAL ? 0 : -1; /* EINVAL: there is nothing to flush on this file system */
}

static int flush_entry(const char *path, const struct stat *st, int type, struct FTW *ftw)
{
    (void)st;
    (void)ftw;
    return type == FTW_SL || type == FTW_SLN ? 0 : flush_to_disk(path);
}

static void flush_folder_of(const char *path)
{
    FREED char *dir = iso_path_dir(path);
    if (dir)
        flush_to_disk(dir);
}

/* Forgets the temporary once it has its final name. The partial name is then free for other runs, so we no longer clean
 * it up. */
static void forget_temporary(iso_output *out)
{
    iso_unfinished_drop(out->temp_path);
    free(out->temp_path);
    out->temp_path = NULL;
}

/* Gives the replaced folder, which has the temporary's name, a name of our own until it is removed. Other runs know a
 * partial name, and may take it as soon as that folder is gone. */
static void move_replaced_aside(iso_output *out)
{
    FREED char *dir = iso_path_dir(out->final_path);
    char *aside = dir ? iso_temporary_path(dir, iso_path_base(out->final_path)) : NULL;
    const bool is_moved = aside && rename(out->temp_path, aside) == 0;
    forget_temporary(out); /* if it is not moved, the next run clears it */
    if (is_moved) {
        iso_unfinished_add(aside, false);
        out->temp_path = aside;
    } else
        free(aside);
}

/* Replaces a finished folder that has the name already. It is locked and checked again, since a person may have added
 * something in the meantime. *done stays false if another process has replaced or removed it. */
static iso_status replace(iso_output *out, bool *done, iso_error *err)
{
    iso_folder_lock lock;
    iso_status status = lock_final(out->final_path, &lock, err);
    if (status == ISO_OK && lock.fd >= 0)
        status = iso_manifest_check(out->final_path, out->final_path, err);
    if (status == ISO_OK && lock.fd >= 0) {
        *done = exchange(out->temp_path, out->final_path) == 0;
        if (!*done && errno != ENOENT && errno != EEXIST && errno != ENOTEMPTY)
            status = iso_fail(err, iso_errno_status(), "%s: cannot be put in place: %s", out->final_path,
                              strerror(errno));
        if (*done && out->own)
            move_replaced_aside(out);
    }
    unlock(&lock); /* the removal needs no lock: the folder's name is private */
    return status;
}

/* Renames the temporary into place. A directory replaces an empty one by a rename, a full one only by an exchange.
 * Other processes may put theirs there at any time. */
static iso_status put_in_place(iso_output *out, iso_error *err)
{
    enum { TRIES = 1000 };
    for (int i = 0; i < TRIES; ++i) {
        bool done = false;
        if (rename(out->temp_path, out->final_path) == 0) {
            forget_temporary(out);
            return ISO_OK;
        }
        if (errno != EEXIST && errno != ENOTEMPTY)
            break;
        const iso_status status = replace(out, &done, err);
        if (status != ISO_OK || done)
            return status;
    }
    return iso_fail(err, iso_errno_status(), "%s: cannot be put in place: %s", out->final_path, strerror(errno));
}

static iso_status commit_dir(iso_output *out, iso_error *err)
{
    NEED(iso_manifest_write(out->temp_path, out->own, err));
    if (nftw(out->temp_path, flush_entry, 16, FTW_DEPTH | FTW_PHYS) != 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", out->final_path, strerror(errno));
    return put_in_place(out, err);
}

static iso_status commit_file(const iso_output *out, bool is_final, iso_error *err)
{
    if (is_final && flush_to_disk(out->temp_path) != 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", out->final_path, strerror(errno));
    if (rename(out->temp_path, out->final_path) != 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be put in place: %s", out->final_path, strerror(errno));
    return ISO_OK;
}

static void release_lock(iso_output *out)
{
    if (out->lock > 0)
        close(out->lock - 1);
    out->lock = 0;
}

iso_status iso_output_commit(iso_output *out, iso_error *err)
{
    /* A file inside of a folder that is not finished itself is flushed with that folder. */
    const bool is_final = !iso_temporary_holds(out->final_path);
    iso_status status = iso_progress_check(iso_progress_current(), err);
    TRY(status, out->is_folder ? commit_dir(out, err) : commit_file(out, is_final, err));
    if (status == ISO_OK)
        release_lock(out); /* others may replace it while the old one is removed */
    if (status == ISO_OK && is_final)
        flush_folder_of(out->final_path);
    if (status == ISO_OK)
        out->own = NULL; /* the temporary is the folder that was replaced, which was looked at */
    iso_output_abandon(out);
    return status;
}

iso_status iso_output_commit_locked(iso_output *out, int *lock, iso_error *err)
{
    *lock = iso_folder_lock_take(out->temp_path, false).fd;
    const iso_status status = iso_output_commit(out, err);
    if (status != ISO_OK && *lock >= 0) {
        close(*lock);
        *lock = -1;
    }
    return status;
}

iso_status iso_output_commit_all(iso_output *outs, size_t count, iso_error *err)
{
    FREED char *folder = iso_path_dir(outs[count - 1].final_path), *real = folder ? realpath(folder, NULL) : NULL;
    iso_status status = ISO_OK;
    /* If somebody else works in the folder for long, the set goes without a lock: its work is not thrown away. */
    const iso_folder_lock lock = real ? iso_folder_lock_take(real, false) : (iso_folder_lock){.fd = -1};
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        status = iso_output_commit(&outs[i], err);
    unlock(&lock);
    return status;
}

void iso_output_keep(iso_output *out)
{
    if (!out || !out->final_path)
        return;
    release_lock(out);
    if (out->temp_path)
        iso_unfinished_drop(out->temp_path);
    free(out->temp_path);
    free(out->final_path);
    *out = (iso_output){0};
}

void iso_output_abandon(iso_output *out)
{
    if (out && out->temp_path && out->own) {
        iso_output_clear(out);
        rmdir(out->temp_path); /* fails if a person has put a file into it */
    } else if (out && out->temp_path)
        iso_remove_tree(out->temp_path);
    iso_output_keep(out);
}
