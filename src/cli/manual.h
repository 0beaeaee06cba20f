/* SPDX-License-Identifier: MIT */
/* manual.h - prints the manual page isoshade(1) and shell completions from the tables of commands and options. */
#pragma once

#include <stdio.h>

#include "base/status.h"

/* Prints the manual page, with the macros of man(7). */
void iso_manual_print_page(FILE *f);
/* Prints the completion function of a shell, "bash" or "zsh"; otherwise ISO_E_USAGE. */
iso_status iso_manual_print_completion(FILE *f, const char *shell, iso_error *err);
