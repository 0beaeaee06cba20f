/* SPDX-License-Identifier: MIT */
/* main.c - isoshade: its commands, `help --man` and `completion`. */
#include <stdio.h>
#include <string.h>

#include "cli/commands.h"
#include "cli/manual.h"
#include "cli/program.h"

#define ISO_COMMAND_EXTERN(name) extern const iso_command iso_command_##name;
ISO_COMMAND_LIST(ISO_COMMAND_EXTERN)
#undef ISO_COMMAND_EXTERN

#define ISO_COMMAND_ENTRY(name) &iso_command_##name,
const iso_command *const iso_commands[] = {ISO_COMMAND_LIST(ISO_COMMAND_ENTRY) NULL};
#undef ISO_COMMAND_ENTRY

static int run_word(int argc, const char **argv, iso_error *err)
{
    if (argc == 3 && strcmp(argv[1], "help") == 0 && strcmp(argv[2], "--man") == 0) {
        iso_manual_print_page(stdout);
        return ISO_OK;
    }
    if (strcmp(argv[1], "completion") == 0)
        return (int)iso_manual_print_completion(stdout, argc == 3 ? argv[2] : "", err);
    return ISO_PROGRAM_NO_WORD;
}

static const iso_command *find_benchmark(const iso_command *command, const char *word)
{
    return command == &iso_command_bench ? iso_benchmark_find(word) : NULL;
}

int main(int argc, const char **argv)
{
    const iso_program isoshade = {
        .name = "isoshade",
        .title = "shading of volumes that is the same at every level of detail and in every renderer",
        .more = "isoshade help --man prints the manual page; isoshade completion bash or zsh prints the completions for these "
                "shells.\n",
        .commands = iso_commands,
        .run_word = run_word,
        .find_inner = find_benchmark,
    };
    return iso_program_main(&isoshade, argc, argv);
}
