/* SPDX-License-Identifier: MIT */
/* memory.h - what the program does where memory has ended: see memory.c. */
#ifndef ISO_CLI_MEMORY_H
#define ISO_CLI_MEMORY_H

/* Sets the program and the command that the message names. */
void iso_memory_is_for(const char *program_name, const char *name);

/* Removes what is unfinished and ends the program with ISO_E_MEMORY. why: for the line of error; NULL: there is one. */
void iso_memory_end(const char *why) __attribute__((noreturn));

#endif
