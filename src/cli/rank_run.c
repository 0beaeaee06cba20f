/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/rank_run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/ranks.h"

static const char *rank_folder;

typedef struct other_rank {
    const iso_command *self;
    int argc;
    const char **argv;
} other_rank;

static void run_other_rank(void *user, const char *folder)
{
    const other_rank *r = user;
    iso_error err = {""}; /* of rank 0 alone a message is seen */
    rank_folder = folder;
    iso_command_parse_and_run(r->self, r->argc, r->argv, &err);
}

iso_status iso_cli_run_as_rank(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    const int index = iso_ranks_find_place().index;
    iso_ranks_hide();
    if (index == 0)
        return iso_command_parse_and_run(self, argc, argv, err);
    const int signal = iso_ranks_run_apart(run_other_rank, &(other_rank){self, argc, argv});
    if (signal != 0)
        fprintf(stderr, "isoshade %s: warning: rank %d died of signal %d; the others draw its pictures\n", self->name,
                index, signal);
    return ISO_OK;
}

const char *iso_cli_rank_folder(void)
{
    return rank_folder;
}

char *iso_cli_work_folder(const char *output)
{
    char *folder = NULL;
    size_t end = strlen(output);
    while (end > 1 && output[end - 1] == '/')
        --end;
    return asprintf(&folder, "%.*s.work", (int)end, output) < 0 ? NULL : folder;
}

void iso_cli_end_rank(void)
{
    _exit(EXIT_SUCCESS);
}
