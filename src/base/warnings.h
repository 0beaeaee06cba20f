/* SPDX-License-Identifier: MIT */
/* warnings.h - facts that a user should read about an accepted input, such as a file that is left out.
 *
 * The library prints nothing: a program names the function that prints. Without one, warnings are dropped. */
#pragma once

typedef void iso_warning_print(const char *text);

/* Sets the function that prints warnings. Call it before threads start. */
void iso_warnings_print_by(iso_warning_print *print);
/* Prints a text the first time that it is given: an input may be opened several times. Threads may warn at once. */
void iso_warn(const char *text);
