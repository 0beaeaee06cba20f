/* SPDX-License-Identifier: MIT */
/* child_check.h - what a program that reads volumes says (child_stream.h) is not trusted: a damaged file may make its
 * library write anything. Private to src/volume. */
#ifndef ISO_VOLUME_CHILD_CHECK_H
#define ISO_VOLUME_CHILD_CHECK_H

#include "volume/child_stream.h"

/* Ends each text where its field ends, whatever was written. */
void iso_child_end_texts(iso_child_header *header);
void iso_child_end_text(iso_child_answer *answer);

/* What the program says went wrong, or ISO_OK. `path` and `library` are for the message where it says nothing that is
 * known: ISO_E_FORMAT. Its text is ended. */
iso_status iso_child_check_answer(const iso_child_answer *answer, const char *path, const char *library,
                                  iso_error *err);

/* ISO_E_FORMAT for a type or a world that there is not, numbers that are none, a box beyond the grid, or more frames
 * and channels than can be counted. The size itself is left to iso_geometry_check(). */
iso_status iso_child_check_header(const iso_child_header *header, const char *path, const char *library,
                                  iso_error *err);

#endif
