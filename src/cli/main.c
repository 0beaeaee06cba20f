/* SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <string.h>

#include "base/file.h"
#include "options/cli.h"
#include "cli/commands.h"
#include "cli/manual.h"

#define ISO_COMMAND_EXTERN(name) extern const iso_command iso_command_##name;
ISO_COMMAND_LIST(ISO_COMMAND_EXTERN)
#undef ISO_COMMAND_EXTERN

#define ISO_COMMAND_ENTRY(name) &iso_command_##name,
const iso_command *const iso_commands[] = {ISO_COMMAND_LIST(ISO_COMMAND_ENTRY) NULL};
#undef ISO_COMMAND_ENTRY

static void print_overview(FILE *file)
{
    fprintf(file,
            "isoshade %s: shading of volumes that is the same at every level of detail and in every renderer\n\n"
            "usage: isoshade COMMAND [options]\n\ncommands:\n",
            ISO_VERSION);
    for (const iso_command *const *c = iso_commands; *c; ++c)
        fprintf(file, "  %-10s %s\n", (*c)->name, (*c)->summary);
    fprintf(
        file,
        "\nisoshade COMMAND --help shows its options, with examples.\nisoshade help --man prints the manual page; isoshade completion bash or zsh what completes words in these shells."
        "\n\nexit codes:\n");
#define ISO_STATUS_LINE(name, code, text) fprintf(file, "  %d  %s\n", code, text);
    ISO_STATUS_LIST(ISO_STATUS_LINE)
#undef ISO_STATUS_LINE
}

static int print_completion(const char *shell)
{
    iso_error err = {""};
    iso_status status = iso_manual_print_completion(stdout, shell, &err);
    if (status != ISO_OK)
        fprintf(stderr, "isoshade completion: %s\n", err.text);
    return status;
}

int main(int argc, const char **argv)
{
    if (argc < 2) {
        print_overview(stderr);
        return ISO_E_USAGE;
    }
    if (argc == 3 && strcmp(argv[1], "help") == 0 && strcmp(argv[2], "--man") == 0) {
        iso_manual_print_page(stdout);
        return ISO_OK;
    }
    if (strcmp(argv[1], "completion") == 0)
        return print_completion(argc == 3 ? argv[2] : "");
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "help") == 0) {
        print_overview(stdout);
        return ISO_OK;
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("isoshade %s\n", ISO_VERSION);
        return ISO_OK;
    }
    for (const iso_command *const *c = iso_commands; *c; ++c) {
        if (strcmp((*c)->name, argv[1]) != 0)
            continue;
        iso_error err = {""};
        iso_status status = (*c)->run(*c, argc - 1, argv + 1, &err);
        if (fflush(stdout) != 0 && status == ISO_OK)
            status = iso_fail(&err, ISO_E_IO, "standard output: cannot be written");
        iso_output_rename_all_in(&err);
        if (err.text[0] && status != ISO_OK)
            fprintf(stderr, "isoshade %s: %s\n", argv[1], err.text);
        return status;
    }
    fprintf(stderr, "isoshade: unknown command \"%s\"; isoshade --help lists them\n", argv[1]);
    return ISO_E_USAGE;
}
