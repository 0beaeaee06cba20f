/* SPDX-License-Identifier: MIT */
/* memory.h - ends the program if small allocations fail: see memory.c. */
#pragma once

/* Sets the names of the program and the command for the message. */
void iso_memory_set_command(const char *program_name, const char *name);

/* Removes unfinished files and ends the program with ISO_E_MEMORY. why: reason in the message; NULL: out of memory. */
void iso_memory_end(const char *why) __attribute__((noreturn));
