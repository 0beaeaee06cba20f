/* SPDX-License-Identifier: MIT */
/* rank_run.h - commands whose pictures are shared by the ranks of one job, in the folder OUTPUT.work. */
#pragma once

#include "options/cli.h"

/* run_words() of such a command. A rank other than 0 runs it in a child, for the pictures only: if that dies, the job
 * goes on, and others draw its pictures. Its exit code is 0, and only rank 0 prints. */
iso_status iso_cli_run_as_rank(const iso_command *self, int argc, const char **argv, iso_error *err);

/* Private folder of a rank other than 0, for outputs that are dropped; NULL for rank 0. */
const char *iso_cli_rank_folder(void);
/* Returns OUTPUT.work, to be freed. NULL: no memory. */
char *iso_cli_work_folder(const char *output);
/* Ends a rank whose pictures nobody needs any more. */
void iso_cli_end_rank(void);
