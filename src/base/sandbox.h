/* SPDX-License-Identifier: MIT */
/* sandbox.h - limits a started program: it may read its user's files and write to its own folder, without network.
 *
 * It uses only Linux features that every process may use, without helpers or namespaces. So it works in containers and
 * for root. (bubblewrap 0.8 needs namespaces of users, which containers often forbid, and 15 ms a program: this would
 * have to stay next to it.)
 *
 *   Landlock             writes, new files, removals and renames outside of allowed folders fail with EACCES or EXDEV;
 *                        no signals to processes outside (from Linux 6.12 on)
 *   seccomp              sockets fail with EACCES (except pairs of streams), io_uring with ENOSYS; without a graphics
 *                        device, changes of modes, owners, times and extended attributes also fail with EACCES
 *   PR_SET_NO_NEW_PRIVS  no program that it starts gets further rights
 *   the environment      TMPDIR is its own folder
 *
 * If the kernel lacks a part, the others still hold, and iso_sandbox_describe() names the missing ones.
 * Reading is not restricted. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

typedef enum iso_sandbox_kind {
    ISO_SANDBOX_CLOSED, /* no sockets, and no changes that Landlock does not cover, such as a file's mode */
    ISO_SANDBOX_DEVICE, /* for programs that may draw on a GPU: allows local sockets (AF_UNIX), graphics devices, and
                         * the folders in which drivers cache compiled programs (~/.cache, ~/.nv, /var/tmp) */
    ISO_SANDBOX_NONE    /* no limits: for isoshade itself, which starts its programs in sandboxes */
} iso_sandbox_kind;

typedef struct iso_sandbox_wish {
    iso_sandbox_kind kind;
    const char *output;        /* another existing folder or file that it may write to; or NULL */
    bool private_home;         /* True if HOME is its own folder, so that the user's settings have no effect */
    const char *first_in_path; /* folder that comes first in its PATH; or NULL */
    const char *without;       /* prefix of environment variables to remove, such as "PYTHON"; or NULL */
} iso_sandbox_wish;

/* Prepared before the fork, entered after it. {0} is none. */
typedef struct iso_sandbox {
    bool closes;        /* False: no limits */
    bool has_sockets;   /* True if local sockets are allowed */
    int rules;          /* descriptor of Landlock's rules; below 0: none */
    char **environment; /* of the program; NULL: ours */
    size_t copies;      /* number of its first entries, which are owned */
} iso_sandbox;

/* Prepares a sandbox. folder: the program's own, which exists; NULL: it may write nowhere, and TMPDIR stays. Without
 * a sandbox only the environment is changed. ISO_E_MEMORY; ISO_E_IO if the folder or the output does not exist. */
iso_status iso_sandbox_prepare(const iso_sandbox_wish *wish, const char *folder, iso_sandbox *box, iso_error *err);
void iso_sandbox_release(iso_sandbox *box);

/* Enters the sandbox. Called by the forked process; makes only system calls. False: the kernel refused a part. */
bool iso_sandbox_enter(const iso_sandbox *box);

/* Turns sandboxes on or off, also for programs of isoshade that are started; off: every kind acts as
 * ISO_SANDBOX_NONE. They are on by default, unless the environment variable ISOSHADE_SANDBOX is "off". */
void iso_sandbox_set(bool on);
bool iso_sandbox_is_on(void);

/* Describes it: "writes in their own folders only (Landlock 7), no network (seccomp)", and the missing parts. */
void iso_sandbox_describe(char *text, size_t size);
