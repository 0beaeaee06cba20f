/* SPDX-License-Identifier: MIT */
/* inputs.h - files that a command reads, so that no output replaces one of them.
 *
 * Files are identified by device and inode, under any name or link. A reader notes each file that the user named, and
 * each file that such a file names. A command announces the outputs that it can name beforehand, also those that get a
 * name of their own next to -o.
 * A file that is both is refused at once, in either order. An output that was not announced is refused when it begins
 * (iso_output_begin()), and a folder for each file in it.
 * Some folders are read as one input, such as a Zarr store, whose chunks may be millions. All its entries are inputs,
 * and so are new ones: a reader could take a new file for a chunk. Threads may note at once.
 *
 * Nothing is recorded before iso_inputs_watch(): a program that uses the library may save over a file that it has
 * loaded. Temporaries of this process are not inputs. */
#pragma once

#include "base/status.h"

/* Starts recording. For programs; main() calls it. */
void iso_inputs_watch(void);

/* Notes a regular file that is about to be read. ISO_E_USAGE: it is an announced output. Other kinds of files are
 * left to their reader to refuse. */
iso_status iso_inputs_note(const char *path, iso_error *err);

/* Notes a folder that is about to be read as one thing. ISO_E_USAGE: it holds an announced output. */
iso_status iso_inputs_note_folder(const char *path, iso_error *err);

/* Announces an output that will be written. ISO_E_USAGE: it is an input. A file that does not exist yet is an input
 * only in such a folder. */
iso_status iso_inputs_announce(const char *output, iso_error *err);

/* Checks an output that is written now by the same rules, without recording it. */
iso_status iso_inputs_check(const char *output, iso_error *err);

/* Calls visit for each file and folder that was noted, in the order of their names, until one fails. */
typedef iso_status iso_input_visitor(void *user, const char *path, iso_error *err);
iso_status iso_inputs_visit(iso_input_visitor *visit, void *user, iso_error *err);
