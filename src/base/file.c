/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* True if the name still means the folder that was opened. */
static bool is_named(int fd, const char *folder)
{
    struct stat opened, named;
    return fstat(fd, &opened) == 0 && lstat(folder, &named) == 0 && opened.st_ino == named.st_ino &&
           opened.st_dev == named.st_dev;
}

/* Tries to lock a folder, which it creates first if `make`. cause is ESTALE if the name meant another folder once it
 * was locked. */
static iso_folder_lock try_lock(const char *folder, bool make)
{
    iso_folder_lock lock = {.fd = -1, .made = make && mkdir(folder, 0777) == 0};
    lock.cause = make && !lock.made && errno != EEXIST ? errno : 0;
    if (!lock.cause)
        lock.fd = open(folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (lock.fd < 0) {
        lock.cause = lock.cause ? lock.cause : errno == ENOENT && make ? ESTALE : errno;
        return lock;
    }
    lock.cause = flock(lock.fd, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
    if (lock.cause != EWOULDBLOCK && !is_named(lock.fd, folder))
        lock.cause = ESTALE;
    if (lock.cause == EWOULDBLOCK || lock.cause == ESTALE) {
        close(lock.fd);
        lock.fd = -1;
    }
    return lock;
}

iso_folder_lock iso_folder_lock_take(const char *folder, bool make)
{
    enum { PAUSES = 40, CHANGES = 1000 };
    const struct timespec pause = {.tv_nsec = 50 * 1000000};
    iso_folder_lock lock;
    for (int pauses = 0, changes = 0;;) {
        lock = try_lock(folder, make);
        if (lock.cause == EWOULDBLOCK && pauses++ < PAUSES)
            nanosleep(&pause, NULL);
        else if (lock.cause != ESTALE || changes++ == CHANGES)
            return lock;
    }
}

int iso_memory_close(FILE *memory)
{
    if (!memory)
        return 0;
    const bool failed = ferror(memory) != 0;
    return fclose(memory) != 0 || failed;
}

iso_status iso_file_open(const char *path, int *fd, size_t *bytes, iso_error *err)
{
    struct stat st;
    *fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* a pipe without a writer is reported, not waited for */
    if (*fd < 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    if (fstat(*fd, &st) == 0 && S_ISREG(st.st_mode)) {
        *bytes = (size_t)st.st_size;
        return ISO_OK;
    }
    close(*fd);
    *fd = -1;
    return iso_fail(err, ISO_E_IO, "%s: is not a regular file", path);
}

iso_status iso_file_read(const char *path, char **data, size_t *size, iso_error *err)
{
    int fd;
    size_t bytes;
    *data = NULL;
    *size = 0;
    iso_status status = iso_file_open(path, &fd, &bytes, err);
    if (status != ISO_OK)
        return status;
    FILE *file = fdopen(fd, "rb");
    *data = file ? malloc(bytes + 1) : NULL;
    if (!*data)
        status = iso_fail(err, ISO_E_MEMORY, "%s: no memory for %zu bytes", path, bytes);
    else if (fread(*data, 1, bytes, file) != bytes)
        status = iso_fail(err, iso_errno_status(), "%s: read error: %s", path, strerror(errno));
    else
        (*data)[bytes] = 0, *size = bytes;
    if (status != ISO_OK) {
        free(*data);
        *data = NULL;
    }
    if (file)
        fclose(file);
    else
        close(fd);
    return status;
}

iso_status iso_file_write(const char *path, const void *data, size_t size, iso_error *err)
{
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    NEED(iso_output_begin(&out, path, err));
    FILE *file = fopen(out.temp_path, "wb");
    bool good = file && fwrite(data, 1, size, file) == size;
    if (file && fclose(file) != 0)
        good = false;
    return good ? iso_output_commit(&out, err)
                : iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
}
