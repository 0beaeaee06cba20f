/* SPDX-License-Identifier: MIT */
/* file.h - outputs that appear whole or not at all.
 *
 * A file or a directory is made under a temporary name beside its final one (temporary.h), flushed to the disk, and
 * renamed when it is complete. What stood there before stays until then. An output that is a link is written to what the
 * link names, and the link stays; devices, pipes and sockets are refused. */
#ifndef ISO_FILE_H
#define ISO_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "base/status.h"
#include "base/temporary.h"

typedef struct iso_output {
    char *final_path; /* what the user named */
    char *temp_path;  /* where to write */
    bool is_folder;
    int lock;         /* 1 + the descriptor that locks the temporary; 0: none */
    const char *const *own; /* names in a folder that can be resumed; NULL: all in the temporary is its own */
} iso_output;

/* Reserves a temporary file name beside path. Writers that take a path write
 * to out->temp_path. ISO_E_IO when the folder is not there or not writable. */
iso_status iso_output_begin(iso_output *out, const char *path, iso_error *err);

/* The same for a directory, which is created. An existing directory at path is
 * replaced at commit only if it holds a file `marker`, a pattern of fnmatch() (so it is one of ours), and
 * nothing but what isoshade wrote (manifest.h); else ISO_E_IO, and nothing of the user's is lost. */
iso_status iso_output_begin_dir(iso_output *out, const char *path, const char *marker, iso_error *err);

/* The same for work that can be resumed after it was killed: the temporary directory has the
 * fixed name .NAME.partial. If one exists and `resume` is set, its files stay and *resumed
 * becomes true; else they are removed. own: what the command calls its files there, patterns of fnmatch(), the marker
 * first and NULL last; it outlives the output. ISO_E_IO while another process works in the directory, and where it is
 * a link, another user's, or has an entry that is no file of such a name; that stays as it is. */
iso_status iso_output_resume_dir(iso_output *out, const char *path, const char *const *own, bool resume, bool *resumed,
                                 iso_error *err);

/* Does a name fit one of the patterns, or is it one that all folders of ours may have? */
bool iso_output_is_own(const char *const *own, const char *name);

/* Replaces the temporary name in an error message by the final one, which the user knows. */
void iso_output_rename_in(const char *temp_path, const char *final_path, iso_error *err);

/* The same for all temporaries of iso_output_begin() and iso_output_begin_dir(). main() calls it. */
void iso_output_rename_all_in(iso_error *err);

/* Removes the command's own files from a directory of iso_output_resume_dir(). */
void iso_output_clear(const iso_output *out);

/* Renames into place. On failure the temporary is removed. */
iso_status iso_output_commit(iso_output *out, iso_error *err);

/* Renames files of one set into place, in their order. The last one's folder is locked meanwhile, so that sets of two
 * processes do not mix. All outputs have begun. */
iso_status iso_output_commit_all(iso_output *outs, size_t count, iso_error *err);

/* Renames a folder into place and keeps it locked, so that files can be added. *lock is a descriptor to be closed; below 0:
 * no lock. */
iso_status iso_output_commit_locked(iso_output *out, int *lock, iso_error *err);

/* Removes the temporary. Safe after commit, on an empty struct and on NULL. */
void iso_output_abandon(iso_output *out);

/* As abandon, but keeps the temporary, so that the work can be resumed. */
void iso_output_keep(iso_output *out);

/* Closes what open_memstream() made, which may be NULL; not 0 where something that was written to it found no memory. What
 * it left then is no text. */
int iso_memory_close(FILE *memory);

/* Removes a directory and all in it. Missing is fine. */
void iso_remove_tree(const char *path);

/* The lock of a folder; it ends when fd is closed. */
typedef struct iso_folder_lock {
    int fd;    /* of the folder; below 0: not locked */
    int cause; /* errno: EWOULDBLOCK, another process has the lock; ENOENT, there is no folder. With an fd: 0, or the
                * reason why this file system has no locks, so that nobody is kept out */
    bool made; /* True if the folder is new */
} iso_folder_lock;

/* Opens a folder, which is made first if `make` is set, and locks it. No link is followed. The folder that is locked is the
 * one that has the name: whoever had the lock before may have renamed or removed the folder, and then its new bearer is
 * locked. A lock of another process is waited for, two seconds at most: programs that a killed run had started may hold
 * its lock until they end. */
iso_folder_lock iso_folder_lock_take(const char *folder, bool make);

/* "dir/name", to be freed. NULL only when memory ends. */
char *iso_path_join(const char *dir, const char *name);
/* The folder of path, "." when it has none; to be freed. */
char *iso_path_dir(const char *path);
/* The last part of path without its folder; points into path. */
const char *iso_path_base(const char *path);
bool iso_path_exists(const char *path);
bool iso_path_is_dir(const char *path);
bool iso_path_is_file(const char *path); /* no folder, pipe or device */
bool iso_path_ends_with(const char *path, const char *suffix);

/* Opens a regular file for reading, and nothing else. *fd is -1 on failure. */
iso_status iso_file_open(const char *path, int *fd, size_t *bytes, iso_error *err);

/* Reads a whole file; a terminating 0 is added behind *size bytes. To be freed. */
iso_status iso_file_read(const char *path, char **data, size_t *size, iso_error *err);

/* Writes a whole file at once, under a temporary name. */
iso_status iso_file_write(const char *path, const void *data, size_t size, iso_error *err);

#endif
