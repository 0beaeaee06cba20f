/* SPDX-License-Identifier: MIT */
/* path.h - parts of paths; questions about them; removal. */
#pragma once

#include <stdbool.h>

/* Returns "dir/name", to be freed. NULL only when memory ends. */
char *iso_path_join(const char *dir, const char *name);
/* Returns the folder of path, "." when it has none; to be freed. */
char *iso_path_dir(const char *path);
/* Returns the last part of path without its folder; points into path. */
const char *iso_path_base(const char *path);
/* Returns a folder's name as letters, digits, "-" and "_", which needs no quotes in a shell or in other programs' files;
 * "volume" for "/"; to be freed. NULL only when memory ends. */
char *iso_path_plain_name(const char *dir);
bool iso_path_exists(const char *path);
bool iso_path_is_dir(const char *path);
bool iso_path_is_file(const char *path); /* no folder, pipe or device */
bool iso_path_ends_with(const char *path, const char *suffix);

/* Removes a directory and all in it. Missing is fine. */
void iso_remove_tree(const char *path);
