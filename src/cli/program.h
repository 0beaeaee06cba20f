/* SPDX-License-Identifier: MIT */
/* program.h - main() of programs with commands, isoshade and isoshade-lab: finds and runs a command, prints its error
 * and returns its exit code (base/status.h). */
#pragma once

#include "options/cli.h"

typedef struct iso_program {
    const char *name;  /* first word of messages, examples and schemas */
    const char *title; /* one line, for --help */
    const char *more;  /* lines of --help after the commands, or NULL */
    const iso_command *const *commands; /* ends with NULL */
    /* Runs a word that is not a command, such as "completion", or returns ISO_PROGRAM_NO_WORD. May be NULL. */
    int (*run_word)(int argc, const char **argv, iso_error *err);
    /* Finds a command of two words, such as "bench build". NULL: all have one word. */
    const iso_command *(*find_inner)(const iso_command *command, const char *word);
} iso_program;

enum { ISO_PROGRAM_NO_WORD = -1 };

/* Runs the program; called once, from main(). */
int iso_program_main(const iso_program *program, int argc, const char **argv);
