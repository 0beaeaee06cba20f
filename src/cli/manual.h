/* SPDX-License-Identifier: MIT */
/* manual.h - what is printed from the table of commands and their options: isoshade(1), and completion for shells. */
#ifndef ISO_CLI_MANUAL_H
#define ISO_CLI_MANUAL_H

#include <stdio.h>

#include "base/status.h"

/* The manual page, in the macros of man(7). */
void iso_manual_print_page(FILE *f);
/* What completes the words of a command line; shell: "bash" or "zsh", else ISO_E_USAGE. */
iso_status iso_manual_print_completion(FILE *f, const char *shell, iso_error *err);

#endif
