/* SPDX-License-Identifier: MIT */
/* key.h - all dependencies of a result, so that stored work is reused for the same inputs alone.
 *
 * A key has named parts, each with a hash of its value. Stored work keeps the parts. A later run makes a key of its
 * own, and iso_key_differs() names the first part that is not the same. The parts are
 *
 *     all that the caller adds      such as each option of a command (options/cli.h)
 *     "input ..."                   each file and folder that was read (inputs.h)
 *     "the program"                 the program's own file, and the programs and libraries that lie next to it
 *     "$NAME"                       each variable of the environment by which a driver or a renderer chooses
 *
 * Files are hashed whole, up to ISO_KEY_WHOLE_BYTES of all of them. Beyond that a file stands for itself by size,
 * inode, its times in nanoseconds and samples of its content. Its device is left out: a file system that is mounted
 * again may have another number. A part holds no path and no value, only hashes, since outputs may keep it
 * (provenance.h). */
#pragma once

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

#define ISO_KEY_WHOLE_BYTES ((size_t)64 << 20)

typedef struct iso_key iso_key;

/* Returns a key without parts. NULL: no memory. */
iso_key *iso_key_create(void);
void iso_key_destroy(iso_key *key); /* accepts NULL */

/* Adds a part, or gives an existing part the new value. */
void iso_key_add(iso_key *key, const char *part, const void *value, size_t bytes);
void iso_key_add_text(iso_key *key, const char *part, const char *text);
/* Adds all parts of another key. */
void iso_key_add_all(iso_key *key, const iso_key *other);

/* Adds the inputs, the program and the environment. Call it after all inputs were opened. ISO_E_IO: one cannot be
 * read. */
iso_status iso_key_add_surroundings(iso_key *key, iso_error *err);

/* Adds a file that a renderer depends on: a program as iso_process_find() takes it, a path, or "~/FILE" in the home
 * folder. A missing file is a part, too. Links are followed; a file that is replaced or rewritten has another hash. */
iso_status iso_key_add_dependency(iso_key *key, const char *name, iso_error *err);

/* Returns all parts, as a new object. NULL: memory ended, here or in an earlier call. */
json_t *iso_key_to_json(const iso_key *key);

enum { ISO_KEY_DIGEST_BYTES = 33 };
/* Writes the hash of all parts. False: memory ended, here or in an earlier call. */
bool iso_key_digest(const iso_key *key, char digest[ISO_KEY_DIGEST_BYTES]);

/* True if a part differs from the stored one, or only one of them has it. text: a clause that names it, such as "v.raw
 * changed since". */
bool iso_key_differs(const iso_key *key, const json_t *stored, char *text, size_t size);
