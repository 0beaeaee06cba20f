/* SPDX-License-Identifier: MIT */
/* cli.h - the command line: one table of commands, one file per command.
 *
 * iso_command_run() parses the arguments by the command's table of options (options/option.h) and by that of all
 * commands, such as --help (to stdout, exit 0), --json and --threads. Results go to stdout, messages and progress to
 * stderr. A command returns a status, which becomes the exit code; main() prints its error as "isoshade COMMAND:
 * MESSAGE". */
#pragma once

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

#include "base/key.h"
#include "base/names.h"
#include "base/progress_line.h"
#include "base/status.h"
#include "base/version.h"
#include "base/words.h"
#include "options/option.h"

typedef struct iso_cli iso_cli;

typedef struct iso_command {
    const char *name;
    const char *summary;           /* one line, for the list of commands */
    size_t min_arguments;          /* number of positional arguments, at least */
    size_t max_arguments;          /* and at most */
    const char *usage;             /* the words after the name: "VOLUME -o PYRAMID.iso [options]" */
    const char *details;           /* a paragraph, or NULL */
    const iso_names *const *lists; /* names that its options choose from, for --help; ends with NULL, or NULL */
    const char *examples;          /* lines that run, each starting with "isoshade" */
    const char *common;            /* options that --help shows, separated by blanks; NULL: all */
    bool shares_ranks;             /* True if the ranks of one job share its work; the others run in a single process */
    bool is_inner;             /* True if another command runs it with words of a file: quiet, without common options */
    const iso_option *options; /* NULL: only those of all commands */
    size_t options_size;       /* bytes of the struct that `options` fills */
    const void *defaults;      /* such a struct; NULL: zeros */
    /* Runs with the parsed options: `options` points to the command's struct. */
    iso_status (*run)(const iso_cli *cli, void *options, iso_error *err);
    /* Gets the words of the command line instead, for another command or iso_command_parse_and_run(); or NULL. */
    iso_status (*run_words)(const struct iso_command *self, int argc, const char **argv, iso_error *err);
} iso_command;

/* The members for options of a command: its struct, its table, and defaults as members of the struct. */
#define ISO_COMMAND_OPTIONS(type, table, ...) \
    .options = table, .options_size = sizeof(type), .defaults = &(const type) \
    { \
        __VA_ARGS__ \
    }

/* Table in src/cli/commands.h. */
extern const iso_command *const iso_commands[]; /* ends with NULL */

/* Options of commands that take renderers. The device of the ray caster; the user's programs (renderers/external.h). */
/* clang-format off */
#define ISO_CLI_GL_DEVICE_OPTION(type, member) \
    {"gl-device", 0, "gl: number of isoshade list --gl, part of its name, or surfaceless (the first GPU)", "DEVICE", ISO_IN(type, member)}
#define ISO_CLI_RENDERERS_OPTION(type, member) \
    {"renderers", 0, "add render programs for --with (doc/guide/judging-a-renderer.md)", "FILE.json,...", ISO_IN(type, member)}
/* clang-format on */

/* A parsed command line. */
struct iso_cli {
    int json, quiet, threads;
    size_t argument_count;
    const char **arguments; /* positional arguments, owned by context */
    poptContext context;
    int argc;
    const char **argv;
    const iso_command *command;
    iso_progress_line *progress; /* NULL: none */
    json_t *given;               /* values of all options and arguments as texts, by name, with defaults */
};

/* Parses the words by the command's options and the common ones, and calls run(); --help is printed instead.
 * ISO_E_USAGE names the wrong option and its value, or the wrong number of positional arguments. */
iso_status iso_command_parse_and_run(const iso_command *command, int argc, const char **argv, iso_error *err);
/* Does the same, or calls run_words(). */
iso_status iso_command_run(const iso_command *command, int argc, const char **argv, iso_error *err);

/* Sets the program's name in messages, help, schemas and provenance ("isoshade"). */
void iso_cli_set_program(const char *name);

/* Calls `visit` for each option of the command, in the order of --help. is_common: True for options that all commands
 * have. */
typedef void (*iso_cli_option_visitor)(void *user, const struct poptOption *option, bool is_common);
void iso_cli_visit_options(const iso_command *command, iso_cli_option_visitor visit, void *user);

/* Returns a key of all options and arguments, for stored work (base/key.h); NULL: no memory. `without` lists options to
 * leave out, such as those that do not change results, and ends with NULL. --output, --resume and options that only
 * change messages are always left out. All other options count, so that a new one cannot be forgotten. */
iso_key *iso_cli_key(const iso_cli *cli, const char *const *without);

/* Returns the line of progress on stderr (base/progress_line.h); silent with --quiet. */
iso_progress iso_cli_progress(const iso_cli *cli);

/* A stage in the line of progress (base/progress_line.h), which borrows the name. */
typedef struct iso_cli_stage {
    const char *name; /* name by which the stage is reported */
    double cost;
} iso_cli_stage;
void iso_cli_expect(const iso_cli *cli, const iso_cli_stage *stages, size_t count);

/* Expects the stages of a command that first builds a pyramid if its input is a volume. The last stage takes longest.
 * Without stages expects one named `otherwise`, which need not be reported. */
enum { ISO_CLI_MAX_STAGES = 4 };
void iso_cli_expect_names(const iso_cli *cli, bool is_volume, const char *const stages[ISO_CLI_MAX_STAGES],
                          const char *otherwise);

/* Returns {"schema": "isoshade.COMMAND/1", "command": the command line, "options": {}}; add results, then print. */
json_t *iso_cli_json(const iso_cli *cli);
/* Prints the object on stdout, and releases it. */
void iso_cli_print_json(json_t *root);
/* Prints that object with the members of `results`, and releases these. */
void iso_cli_print_results(const iso_cli *cli, json_t *results);
/* Returns the command line, quoted for a shell, with names as outputs show them (base/provenance.h); to be freed. */
char *iso_cli_command_line(const iso_cli *cli);

/* Prints the plural of the names, then a line with name and summary per row, as --help does. */
void iso_cli_print_names(FILE *f, const iso_names *names);
