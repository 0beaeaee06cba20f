/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/json.h"
#include "base/unfinished.h"
#include "base/warnings.h"
#include "base/words.h"
#include "options/cli.h"
#include "cli/commands.h"
#include "cli/manual.h"
#include "cli/memory.h"

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

/* A file that is opened where stdin, stdout or stderr are closed would take its number, and messages would go into it. */
static bool have_standard_streams(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd)
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", fd == STDIN_FILENO ? O_RDONLY : O_WRONLY) != fd)
            return false;
    return true;
}

/* Names go into JSON, pages, and scenes of other programs, which are UTF-8 throughout, and where a line feed would begin a
 * statement. */
static iso_status check_words(int argc, const char **argv, iso_error *err)
{
    for (int i = 1; i < argc; ++i) {
        json_t *string = json_string(argv[i]);
        json_decref(string);
        const char *fault = !string                          ? "is not UTF-8"
                            : iso_words_has_control(argv[i]) ? "holds a control character, such as a line feed"
                                                             : NULL;
        if (fault)
            return iso_fail(err, ISO_E_USAGE, "argument %d %s; give the file another name, or make a link to it", i,
                            fault);
    }
    return ISO_OK;
}

/* What was printed has to have arrived. */
static iso_status flush_output(iso_status status, iso_error *err)
{
    if ((fflush(stdout) != 0 || ferror(stdout)) && status == ISO_OK)
        return iso_fail(err, ISO_E_IO, "standard output: cannot be written");
    return status;
}

static int say(const char *command, iso_status status, iso_error *err)
{
    iso_output_rename_all_in(err);
    if (err->text[0] && status != ISO_OK)
        fprintf(stderr, "isoshade%s%s: %s\n", command[0] ? " " : "", command, err->text);
    return status;
}

static void print_warning(const char *text)
{
    fprintf(stderr, "isoshade: warning: %s\n", text);
}

/* What its messages begin with: a benchmark is called by two words. */
static const char *name_of(const iso_command *command, int argc, const char **argv)
{
    const iso_command *benchmark = command == &iso_command_bench && argc > 2 ? iso_benchmark_find(argv[2]) : NULL;
    return benchmark ? benchmark->name : command->name;
}

/* popt would take no option behind the first file then, and each command's options may stand there. */
static void take_options_anywhere(void)
{
    unsetenv("POSIXLY_CORRECT");
    unsetenv("POSIX_ME_HARDER");
}

static int run(int argc, const char **argv)
{
    iso_error err = {""};
    if (!have_standard_streams())
        return ISO_E_IO;
    signal(SIGXFSZ, SIG_IGN); /* a file above the limit of its size is an error of writing, which is told */
    iso_status status = check_words(argc, argv, &err);
    if (status != ISO_OK)
        return say("", status, &err);
    if (argc < 2) {
        print_overview(stderr);
        return ISO_E_USAGE;
    }
    if (argc == 3 && strcmp(argv[1], "help") == 0 && strcmp(argv[2], "--man") == 0) {
        iso_manual_print_page(stdout);
        return say("help", flush_output(ISO_OK, &err), &err);
    }
    if (strcmp(argv[1], "completion") == 0) {
        status = iso_manual_print_completion(stdout, argc == 3 ? argv[2] : "", &err);
        return say("completion", flush_output(status, &err), &err);
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "help") == 0) {
        print_overview(stdout);
        return say("", flush_output(ISO_OK, &err), &err);
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("isoshade %s\n", ISO_VERSION);
        return say("", flush_output(ISO_OK, &err), &err);
    }
    for (const iso_command *const *c = iso_commands; *c; ++c) {
        if (strcmp((*c)->name, argv[1]) != 0)
            continue;
        const char *const name = name_of(*c, argc, argv);
        iso_memory_is_for(name);
        status = (*c)->run(*c, argc - 1, argv + 1, &err);
        return say(name, flush_output(status, &err), &err);
    }
    fprintf(stderr, "isoshade: unknown command \"%s\"; isoshade --help lists them\n", argv[1]);
    return ISO_E_USAGE;
}

/* Libraries that find no memory or no thread (popt, OpenMP) say so and end the process with 1, which would mean that
 * pictures differ. isoshade itself only ends by returning from main(), so what comes here before that is theirs. */
static bool has_returned;
static void end_without_memory(int code, void *unused)
{
    (void)unused;
    if (code == EXIT_FAILURE && !has_returned)
        iso_memory_end(NULL);
}

int main(int argc, const char **argv)
{
    on_exit(end_without_memory, NULL);
    iso_unfinished_catch_signals();
    iso_inputs_watch();
    iso_warnings_print_by(print_warning);
    take_options_anywhere();
    const int code = run(argc, argv);
    has_returned = true;
    return code;
}
