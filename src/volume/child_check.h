/* SPDX-License-Identifier: MIT */
/* child_check.h - checks of the output of the programs that read volumes (child_stream.h). It is untrusted input: a
 * damaged file may make its library write anything. Private to src/volume. */
#pragma once

#include "volume/child_stream.h"

/* Ends each text where its field ends, for any content. */
void iso_child_end_texts(iso_child_header *header);
void iso_child_end_text(iso_child_answer *answer);

/* Returns the program's error, or ISO_OK. `path` and `library` are for the message if the answer's status is
 * unknown: ISO_E_FORMAT. Its text is ended. */
iso_status iso_child_check_answer(const iso_child_answer *answer, const char *path, const char *library,
                                  iso_error *err);

/* Checks all but the size, which iso_geometry_check() checks. ISO_E_FORMAT: an unknown type or world, a number that is
 * not finite, a box beyond the grid, or too many frames and channels to count. */
iso_status iso_child_check_header(const iso_child_header *header, const char *path, const char *library,
                                  iso_error *err);
