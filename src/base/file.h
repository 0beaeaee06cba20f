/* SPDX-License-Identifier: MIT */
/* file.h - outputs that appear whole or not at all.
 *
 * A file or a folder is made under a temporary name next to its final one (temporary.h), flushed to the disk, and
 * renamed when it is complete. An existing output stays until then. If an output is a link, its target is written
 * and the link stays. Devices, pipes and sockets are refused. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "base/path.h"
#include "base/status.h"
#include "base/temporary.h"

typedef struct iso_output {
    char *final_path; /* path as the user gave it */
    char *temp_path;  /* where to write */
    bool is_folder;
    int lock;         /* 1 + the descriptor that locks the temporary; 0: none */
    const char *const *own; /* names in a folder that can be resumed; NULL: all in the temporary is its own */
} iso_output;

/* Reserves a temporary file name next to path. Writers that take a path write to out->temp_path. ISO_E_IO if the
 * folder is missing or not writable. */
iso_status iso_output_begin(iso_output *out, const char *path, iso_error *err);

/* Does the same for a folder, which is created. An existing folder at path is replaced at commit only if it is one
 * of ours: it holds a file `marker`, a pattern of fnmatch(), and only files that isoshade wrote (manifest.h).
 * Otherwise ISO_E_IO, and no file of the user is lost. */
iso_status iso_output_begin_dir(iso_output *out, const char *path, const char *marker, iso_error *err);

/* Does the same for work that can be resumed after it was killed. The temporary folder has the fixed name
 * .NAME.partial. If one exists and `resume` is set, its files stay and *resumed becomes true; otherwise they are
 * removed.
 * own: names of the command's files there, patterns of fnmatch(), the marker first and NULL last; it outlives the
 * output.
 * ISO_E_IO while another process works in the folder. ISO_E_IO also if the folder is a link, belongs to another
 * user, or has an entry that matches no such name; that folder stays unchanged. */
iso_status iso_output_resume_dir(iso_output *out, const char *path, const char *const *own, bool resume, bool *resumed,
                                 iso_error *err);

/* True if a name fits one of the patterns, or is one that all our folders may have. */
bool iso_output_is_own(const char *const *own, const char *name);

/* Replaces the temporary name in an error message by the final one, which the user gave. */
void iso_output_rename_in(const char *temp_path, const char *final_path, iso_error *err);

/* Removes the command's own files from a directory of iso_output_resume_dir(). */
void iso_output_clear(const iso_output *out);

/* Renames into place. On failure the temporary is removed. */
iso_status iso_output_commit(iso_output *out, iso_error *err);

/* Renames files of one set into place, in their order. The last one's folder is locked meanwhile, so that sets of two
 * processes do not mix. All outputs have begun. */
iso_status iso_output_commit_all(iso_output *outs, size_t count, iso_error *err);

/* Renames a folder into place and keeps it locked, so that files can be added. *lock is a descriptor to be closed;
 * below 0: no lock. */
iso_status iso_output_commit_locked(iso_output *out, int *lock, iso_error *err);

/* Removes the temporary. Safe after commit, on an empty struct and on NULL. */
void iso_output_abandon(iso_output *out);

/* Abandons, but keeps the temporary, so that the work can be resumed. */
void iso_output_keep(iso_output *out);

/* Closes a stream of open_memstream(), which may be NULL. Not 0 if a write found no memory; the buffer is then not
 * NUL-terminated. */
int iso_memory_close(FILE *memory);

/* The lock of a folder; it ends when fd is closed. */
typedef struct iso_folder_lock {
    int fd;    /* of the folder; below 0: not locked */
    int cause; /* errno: EWOULDBLOCK, another process has the lock; ENOENT, the folder is missing. With an fd: 0, or
                * the error if this file system has no locks, so that no process is kept out */
    bool made; /* True if the folder is new */
} iso_folder_lock;

/* Opens a folder, which is made first if `make` is set, and locks it. Follows no link. If the last holder of the lock
 * renamed or removed the folder, the folder that has the name now is locked. Waits at most two seconds for a lock of
 * another process: programs that a killed run had started may hold its lock until they end. */
iso_folder_lock iso_folder_lock_take(const char *folder, bool make);

/* Opens a regular file for reading, and nothing else. *fd is -1 on failure. */
iso_status iso_file_open(const char *path, int *fd, size_t *bytes, iso_error *err);

/* Reads a whole file; a terminating 0 follows its *size bytes. To be freed. */
iso_status iso_file_read(const char *path, char **data, size_t *size, iso_error *err);

/* Writes a whole file at once, under a temporary name. */
iso_status iso_file_write(const char *path, const void *data, size_t size, iso_error *err);
