/* SPDX-License-Identifier: MIT */
/* provenance.h - names of inputs in outputs.
 *
 * Pictures, reports and exports are passed on. Folder names reveal their author and subject: people, patients,
 * machines. So outputs name a file by its last name alone, unless the user asks for whole paths; or they leave names
 * out. Command lines keep relative paths, so that they run in the folder in which they were made. Terminal messages,
 * such as errors, are not outputs and name files as given. */
#pragma once

#include <stdio.h>

typedef enum iso_provenance {
    ISO_PROVENANCE_NAMES, /* the command with its relative paths; all other files by their last names */
    ISO_PROVENANCE_PATHS, /* the command, and files as they were given */
    ISO_PROVENANCE_NONE,  /* neither */
} iso_provenance;

/* Sets the choice of this process, once, before the first output. The default is ISO_PROVENANCE_NAMES. */
void iso_provenance_set(iso_provenance kept);
iso_provenance iso_provenance_kept(void);

/* Returns the name of a file for outputs: a part of path, or "". path may be NULL. */
const char *iso_provenance_name(const char *path);

/* Returns the path of a file for command lines: a relative one as it is, an absolute one by iso_provenance_name(). */
const char *iso_provenance_path(const char *path);

/* Returns the title of the volume at path in outputs: its last name, or "a volume". */
const char *iso_provenance_title(const char *path);

/* Returns the name of the scene at path in outputs: "brain" of "dir/brain.scene.json". With ISO_PROVENANCE_NONE
 * it is "scene", or "scene-N" for a number N above 0. The caller frees it; NULL: out of memory. */
char *iso_provenance_scene(const char *path, size_t number);

/* Prints a word of a command line, quoted for a shell, paths as by iso_provenance_path(), also in "--option=path" and
 * in lists. */
void iso_provenance_put_word(FILE *f, const char *word);

/* Returns a command line, quoted by iso_words_put_quoted(), for outputs. The caller frees it. NULL: out of memory. */
char *iso_provenance_line(const char *line);

/* Prepares a message of an error or of another program for outputs: removes the folders of absolute paths without
 * spaces, in place, unless whole paths are kept. Returns text. */
char *iso_provenance_shorten(char *text);
