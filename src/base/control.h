/* SPDX-License-Identifier: MIT */
/* control.h - control characters in texts of files and of other programs. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* Returns the length in bytes of a control character at the text's beginning, 0 if there is none: below a space,
 * delete, or U+0080 to U+009F in UTF-8, of which U+009B begins terminal commands. */
size_t iso_words_control(const char *text);
/* True if a text holds one. No name or word of a file needs it, and a line feed would begin a statement in texts for
 * other programs. */
bool iso_words_has_control(const char *text);
/* Copies a text with spaces in place of control characters, as much as fits into size bytes. */
void iso_words_copy_line(const char *text, char *line, size_t size);
/* Prints all of it in the same way, without a line end. */
void iso_words_put_line(FILE *f, const char *text);
/* Makes another program's output printable, in place: bytes outside printable ASCII become '?', tabs a space. */
void iso_words_make_printable(char *text);
