/* SPDX-License-Identifier: MIT */
/* inputs.h - what a command reads, so that nothing that it writes takes its place.
 *
 * Files are known by device and inode, whatever the name or link that leads to them. What reads a file that a person
 * named, or a file that such a file names, notes it; a command announces the outputs that it knows beforehand, also
 * those that get a name of their own beside -o. A file that is both is refused at once, whichever came first; what was
 * not announced is refused where it begins (iso_output_begin()), and a folder by each file in it. Of a folder that is
 * read as one thing, such as a Zarr store, whose chunks may be millions, all that stands in it is an input, and so is
 * what would: a new file in it could be taken for a chunk. Threads may note at once.
 *
 * Nothing is kept before iso_inputs_watch(): a program that uses the library may save what it has loaded. Temporaries
 * of this process are no inputs. */
#ifndef ISO_INPUTS_H
#define ISO_INPUTS_H

#include "base/status.h"

/* From now on. For programs; main() calls it. */
void iso_inputs_watch(void);

/* A regular file that is about to be read. ISO_E_USAGE: it is an output that was announced. What is no regular file is
 * for its reader to refuse. */
iso_status iso_inputs_note(const char *path, iso_error *err);

/* A folder that is about to be read as one thing. ISO_E_USAGE: an output that was announced stands in it. */
iso_status iso_inputs_note_folder(const char *path, iso_error *err);

/* An output that will be written. ISO_E_USAGE: it is an input; what is not there yet is none, but in such a folder. */
iso_status iso_inputs_announce(const char *output, iso_error *err);

/* The same for one that is written now. */
iso_status iso_inputs_check(const char *output, iso_error *err);

/* Calls visit for each file and folder that was noted, in the order of their names, until one fails. */
typedef iso_status iso_input_visitor(void *user, const char *path, iso_error *err);
iso_status iso_inputs_visit(iso_input_visitor *visit, void *user, iso_error *err);

#endif
