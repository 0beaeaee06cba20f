/* SPDX-License-Identifier: MIT */
/* memory.h - what the program does where memory has ended: see memory.c. */
#ifndef ISO_CLI_MEMORY_H
#define ISO_CLI_MEMORY_H

#include <stdbool.h>

/* The command that the message names. */
void iso_memory_is_for(const char *name);

/* Removes what is unfinished and ends the program with ISO_E_MEMORY; say: with a line. */
void iso_memory_end(bool say) __attribute__((noreturn));

#endif
