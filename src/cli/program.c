/* SPDX-License-Identifier: MIT */
/* program.c - main() of isoshade and of isoshade-lab. */
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
#include "cli/memory.h"
#include "cli/program.h"

static const iso_program *running;

static void print_overview(FILE *file)
{
    fprintf(file, "%s %s: %s\n\nusage: %s COMMAND [options]\n\ncommands:\n", running->name, ISO_VERSION, running->title,
            running->name);
    for (const iso_command *const *c = running->commands; *c; ++c)
        fprintf(file, "  %-12s %s\n", (*c)->name, (*c)->summary);
    fprintf(file, "\n%s help COMMAND shows its options, with examples.\n%s\nexit codes:\n", running->name,
            running->more ? running->more : "");
#define ISO_STATUS_LINE(name, code, text) fprintf(file, "  %d  %s\n", code, text);
    ISO_STATUS_LIST(ISO_STATUS_LINE)
#undef ISO_STATUS_LINE
}

/* Opens /dev/null for closed standard streams: otherwise a file would get such a number, and messages would go into it.
 * Returns false on failure. */
static bool have_standard_streams(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd)
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", fd == STDIN_FILENO ? O_RDONLY : O_WRONLY) != fd)
            return false;
    return true;
}

/* Refuses arguments that are not UTF-8 or have control characters: names go into JSON, pages and scenes of other
 * programs, where a line feed would begin a statement. */
static iso_status check_words(int argc, const char **argv, iso_error *err)
{
    for (int i = 1; i < argc; ++i) {
        json_t *string = json_string(argv[i]);
        json_decref(string);
        const char *fault = !string                          ? "is not UTF-8"
                            : iso_words_has_control(argv[i]) ? "has a control character, such as a line feed"
                                                             : NULL;
        if (fault)
            return iso_fail(err, ISO_E_USAGE, "argument %d %s; rename the file, or make a link to it", i, fault);
    }
    return ISO_OK;
}

/* Reports output that could not be written. */
static iso_status flush_output(iso_status status, iso_error *err)
{
    if ((fflush(stdout) != 0 || ferror(stdout)) && status == ISO_OK)
        return iso_fail(err, ISO_E_IO, "standard output: cannot be written; the output is incomplete");
    return status;
}

static int report(const char *command, iso_status status, iso_error *err)
{
    iso_temporary_rename_in(err->text);
    if (err->text[0] && status != ISO_OK)
        fprintf(stderr, "%s%s%s: %s\n", running->name, command[0] ? " " : "", command, err->text);
    return status;
}

static void print_warning(const char *text)
{
    fprintf(stderr, "%s: warning: %s\n", running->name, text);
}

/* Returns the command's name for messages; a benchmark's has two words. */
static const char *name_of(const iso_command *command, int argc, const char **argv)
{
    const iso_command *inner = running->find_inner && argc > 2 ? running->find_inner(command, argv[2]) : NULL;
    return inner ? inner->name : command->name;
}

/* Unsets the variables with which popt accepts no option after the first file. */
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
    signal(SIGXFSZ, SIG_IGN); /* a file above the size limit: a write error with a message, not a signal */
    iso_status status = check_words(argc, argv, &err);
    if (status != ISO_OK)
        return report("", status, &err);
    if (argc < 2) {
        print_overview(stderr);
        return ISO_E_USAGE;
    }
    if (argc > 2 && strcmp(argv[1], "help") == 0 && argv[2][0] != '-') { /* "help render": render --help */
        memmove(argv + 1, argv + 2, (size_t)(argc - 2) * sizeof *argv);
        argv[argc - 1] = "--help";
    }
    const int word = running->run_word ? running->run_word(argc, argv, &err) : ISO_PROGRAM_NO_WORD;
    if (word != ISO_PROGRAM_NO_WORD)
        return report(argv[1], flush_output((iso_status)word, &err), &err);
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "help") == 0) {
        print_overview(stdout);
        return report("", flush_output(ISO_OK, &err), &err);
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("%s %s\n", running->name, ISO_VERSION);
        return report("", flush_output(ISO_OK, &err), &err);
    }
    iso_guess guess = {0};
    char text[80];
    for (const iso_command *const *c = running->commands; *c; ++c) {
        iso_guess_try(&guess, argv[1], (*c)->name);
        if (strcmp((*c)->name, argv[1]) != 0)
            continue;
        const char *const name = name_of(*c, argc, argv);
        iso_memory_set_command(running->name, name);
        status = iso_command_run(*c, argc - 1, argv + 1, &err);
        return report(name, flush_output(status, &err), &err);
    }
    fprintf(stderr, "%s: unknown command \"%s\"%s; %s --help lists them\n", running->name, argv[1],
            iso_guess_text(&guess, "", text), running->name);
    return ISO_E_USAGE;
}

/* Replaces exit code 1 of libraries without memory or threads (popt, OpenMP), which would mean that pictures differ.
 * isoshade itself returns from main(), so an earlier exit is theirs. */
static bool has_returned;
static void end_without_memory(int code, void *unused)
{
    (void)unused;
    if (code == EXIT_FAILURE && !has_returned)
        iso_memory_end(NULL);
}

int iso_program_main(const iso_program *program, int argc, const char **argv)
{
    running = program;
    iso_cli_set_program(program->name);
    on_exit(end_without_memory, NULL);
    iso_unfinished_catch_signals();
    iso_inputs_watch();
    iso_warnings_print_by(print_warning);
    take_options_anywhere();
    const int code = run(argc, argv);
    has_returned = true;
    return code;
}
