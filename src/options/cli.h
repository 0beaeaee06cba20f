/* SPDX-License-Identifier: MIT */
/* cli.h - the command line: one table of commands, one file a command.
 *
 * A command parses its arguments by popt through iso_cli_parse(), which owns
 * --help (stdout, exit 0, ends with the table's examples), --json, --quiet and
 * --threads. Results go to stdout, messages and progress to stderr. A command
 * returns a status, which is the exit code; the message that it left in err is
 * printed by main as "isoshade COMMAND: MESSAGE". */
#ifndef ISO_OPTIONS_CLI_H
#define ISO_OPTIONS_CLI_H

#include <jansson.h>
#include <popt.h>
#include <stdbool.h>
#include <stdio.h>

#include "base/key.h"
#include "base/names.h"
#include "base/progress_line.h"
#include "base/status.h"
#include "base/version.h"
#include "base/words.h"

typedef struct iso_command {
    const char *name;
    const char *summary;           /* one line, for the list of commands */
    size_t min_arguments;          /* positional ones; at most max_arguments */
    size_t max_arguments;          /* 0: none are taken */
    const char *usage;             /* what follows the name: "VOLUME -o PYRAMID.iso [options]" */
    const char *details;           /* a paragraph, or NULL */
    const iso_names *const *lists; /* what its options choose from, for --help; ends with NULL, or NULL */
    const char *examples;          /* lines that run, each starting with "isoshade" */
    const char *common; /* names of the options that --help shows, blanks between them; NULL: all. --help=all has the others */
    bool is_inner; /* run by another one with words of a file: quiet, and takes no option that all commands have */
    iso_status (*run)(const struct iso_command *self, int argc, const char **argv, iso_error *err);
} iso_command;

/* One line a command, in src/cli/commands.h. */
extern const iso_command *const iso_commands[]; /* ends with NULL */

/* Of the commands that take renderers: programs of the user's own (renderers/external.h). */
/* The device of the ray caster, for the variable of the environment that ISO_GL_DEVICE_VARIABLE names. */
#define ISO_CLI_GL_DEVICE_OPTION(variable) \
    { \
        "gl-device", 0, POPT_ARG_STRING, variable, 0, \
            "gl: a number of isoshade list --gl, a part of its name, or surfaceless (the first GPU)", "DEVICE" \
    }
#define ISO_CLI_RENDERERS_OPTION(variable) \
    { \
        "renderers", 0, POPT_ARG_STRING, variable, 0, \
            "programs that render, for --with ($ISOSHADE_RENDERERS): doc/extending.md", "FILE.json,..." \
    }

/* What every command has. */
typedef struct iso_cli {
    int json, quiet, threads;
    size_t argument_count;
    const char **arguments; /* positional, owned by the parse */
    poptContext context;
    int argc;
    const char **argv;
    const iso_command *command;
    iso_progress_line *progress; /* NULL: none */
    json_t *given;               /* values of all options and arguments, as texts by name, defaults included */
} iso_cli;

/* val of a number's poptOption whose variable is 0 where it is not given: 0 itself is refused. */
enum { ISO_CLI_NOT_ZERO = 1 };

typedef enum iso_cli_next { ISO_CLI_RUN, ISO_CLI_STOP } iso_cli_next;

/* Parses argv by `options` (popt; ended by POPT_TABLEEND) and the common ones.
 * On --help prints and sets *next to ISO_CLI_STOP. ISO_E_USAGE names the bad
 * option and value, and the number of positional arguments when the command
 * takes fewer or more. Release with iso_cli_end() in every case. */
iso_status iso_cli_parse(iso_cli *cli, const iso_command *command, int argc, const char **argv,
                         struct poptOption *options, iso_cli_next *next, iso_error *err);
void iso_cli_end(iso_cli *cli);

/* Sets the name of the program, as messages, help, schemas and provenance have it: "isoshade" at first. */
void iso_cli_set_program(const char *name);

/* Calls `visit` for each option of the command, in the order of its --help; the command itself does not run. common: one
 * that every command has. For one thread at a time. */
typedef void (*iso_cli_option_visitor)(void *user, const struct poptOption *option, bool is_common);
void iso_cli_visit_options(const iso_command *command, iso_cli_option_visitor visit, void *user);

/* A key of all options and arguments, for stored work (base/key.h), but for the options of `without`, whose values change
 * no result or are compared otherwise. It ends with NULL. Options of all commands that only change messages are left out, and
 * so are --output and --resume. Each other option is a part, so that a new one cannot be forgotten. NULL: no memory. */
iso_key *iso_cli_key(const iso_cli *cli, const char *const *without);

/* The line on stderr that says how far the command is (base/progress_line.h); silent with --quiet. */
iso_progress iso_cli_progress(const iso_cli *cli);

/* Adds steps to the line of progress (base/progress_line.h), which keeps their names. */
typedef struct iso_cli_stage {
    const char *name; /* as the stage is reported */
    double cost;
} iso_cli_stage;
void iso_cli_expect(const iso_cli *cli, const iso_cli_stage *stages, size_t count);

/* The same for a command that builds a pyramid where its input is a volume, then goes through stages, the last of which
 * takes longest. No stages: one of the name `otherwise`, which nobody reports. */
enum { ISO_CLI_MAX_STAGES = 4 };
void iso_cli_expect_names(const iso_cli *cli, bool is_volume, const char *const stages[ISO_CLI_MAX_STAGES],
                          const char *otherwise);

/* {"schema": "isoshade.COMMAND/1", "command": the command line, "options": {}}; add results, then print. */
json_t *iso_cli_json(const iso_cli *cli);
/* Prints the object on stdout, and releases it. */
void iso_cli_print_json(json_t *root);
/* The command line as one string, quoted for a shell, as outputs may name it (base/provenance.h); to be freed. */
char *iso_cli_command_line(const iso_cli *cli);

/* "WHATs:" and a line a row, name and summary, as --help has it. */
void iso_cli_print_names(FILE *f, const iso_names *names);

#endif
