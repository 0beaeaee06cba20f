/* SPDX-License-Identifier: MIT */
/* provenance.h - what outputs say of where they came from.
 *
 * Pictures, reports and exports are passed on. Folders tell who made them and of whom: names of people, of patients, of
 * machines. So outputs name a file by its last name alone, unless the user asks for whole paths; or they say nothing. What
 * is printed on the terminal, such as an error, is not an output and names files as they were given. */
#ifndef ISO_PROVENANCE_H
#define ISO_PROVENANCE_H

#include <stdio.h>

typedef enum iso_provenance {
    ISO_PROVENANCE_NAMES, /* the command, and files by their last names */
    ISO_PROVENANCE_PATHS, /* the command, and files as they were given */
    ISO_PROVENANCE_NONE,  /* neither */
} iso_provenance;

/* Of this process: set once, before anything is written. At the start it is ISO_PROVENANCE_NAMES. */
void iso_provenance_set(iso_provenance kept);
iso_provenance iso_provenance_kept(void);

/* How an output names the file at path, which may be NULL: a part of path, or "". */
const char *iso_provenance_name(const char *path);

/* What an output calls the volume at path in a title: its last name, or "a volume". */
const char *iso_provenance_title(const char *path);

/* What an output calls the scene at path: "brain" of "dir/brain.scene.json"; where names are left out "scene", or "scene-N" of
 * several, whose numbers begin at 1 (0: it is the only one). To be freed; NULL: out of memory. */
char *iso_provenance_scene(const char *path, size_t number);

/* A word of a command line, quoted for a shell: the folders of a path are left out as iso_provenance_name() says, those
 * in "--option=path" too. A quotient such as 1/255 is no path. */
void iso_provenance_put_word(FILE *f, const char *word);

/* A command line that iso_words_put_quoted() and spaces made, as an output has it; to be freed. NULL: out of memory. */
char *iso_provenance_line(const char *line);

/* Words of another program or of an error, as an output has them: absolute paths in the text, which may not hold spaces,
 * lose their folders, in place; not where whole paths are kept. Returns text. */
char *iso_provenance_shorten(char *text);

#endif
