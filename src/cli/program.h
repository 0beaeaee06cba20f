/* SPDX-License-Identifier: MIT */
/* program.h - a program of commands: isoshade, and isoshade-lab. Finds the command, runs it, prints its error, and returns
 * its exit code (base/status.h). */
#ifndef ISO_CLI_PROGRAM_H
#define ISO_CLI_PROGRAM_H

#include "options/cli.h"

typedef struct iso_program {
    const char *name;  /* as messages, examples and schemas begin */
    const char *title; /* one line, for --help */
    const char *more;  /* lines of --help after the commands, or NULL */
    const iso_command *const *commands; /* ends with NULL */
    /* Runs the words that are no command, such as "completion", or NULL. ISO_PROGRAM_NO_WORD: not one of them. */
    int (*run_word)(int argc, const char **argv, iso_error *err);
    /* Finds the command by two words, such as "bench build", or NULL: one word is enough. */
    const iso_command *(*find_inner)(const iso_command *command, const char *word);
} iso_program;

enum { ISO_PROGRAM_NO_WORD = -1 };

/* Is called once, from main(). */
int iso_program_main(const iso_program *program, int argc, const char **argv);

#endif
