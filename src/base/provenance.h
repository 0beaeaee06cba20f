/* SPDX-License-Identifier: MIT */
/* provenance.h - names of inputs in outputs.
 *
 * Pictures, reports and exports are passed on. Folder names reveal their author and subject: people, patients,
 * machines. So outputs name a file by its last name alone, unless the user asks for whole paths; or they leave names
 * out. Terminal messages, such as errors, are not outputs and name files as given. */
#ifndef ISO_PROVENANCE_H
#define ISO_PROVENANCE_H

#include <stdio.h>

typedef enum iso_provenance {
    ISO_PROVENANCE_NAMES, /* the command, and files by their last names */
    ISO_PROVENANCE_PATHS, /* the command, and files as they were given */
    ISO_PROVENANCE_NONE,  /* neither */
} iso_provenance;

/* Sets what outputs keep, once per process, before anything is written. At the start it is ISO_PROVENANCE_NAMES. */
void iso_provenance_set(iso_provenance kept);
iso_provenance iso_provenance_kept(void);

/* Returns how an output names the file at path, which may be NULL: a part of path, or "". */
const char *iso_provenance_name(const char *path);

/* Returns the title of the volume at path in outputs: its last name, or "a volume". */
const char *iso_provenance_title(const char *path);

/* Returns the name of the scene at path in outputs: "brain" of "dir/brain.scene.json". If names are left out it is
 * "scene", or "scene-N" of several, whose numbers begin at 1 (0: it is the only one). To be freed; NULL: out of
 * memory. */
char *iso_provenance_scene(const char *path, size_t number);

/* Prints a word of a command line, quoted for a shell. The folders of a path are left out as by
 * iso_provenance_name(), also in "--option=path". A quotient such as 1/255 is not a path. */
void iso_provenance_put_word(FILE *f, const char *word);

/* Returns a command line of iso_words_put_quoted() and spaces as outputs show it; to be freed. NULL: out of memory. */
char *iso_provenance_line(const char *line);

/* Shortens words of another program or of an error for outputs, in place: absolute paths without spaces lose their
 * folders, unless whole paths are kept. Returns text. */
char *iso_provenance_shorten(char *text);

#endif
