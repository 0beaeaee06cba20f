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

#include "base/progress.h"
#include "base/status.h"

#define ISO_VERSION "0.1.0"

typedef struct iso_command {
    const char *name;
    const char *summary;  /* one line, for the list of commands */
    const char *usage;    /* what follows the name: "VOLUME -o PYRAMID.iso [options]" */
    const char *details;  /* a paragraph, or NULL */
    const char *examples; /* lines that run, each starting with "isoshade" */
    iso_status (*run)(const struct iso_command *self, int argc, const char **argv, iso_error *err);
} iso_command;

/* One line a command, in src/cli/commands.h. */
extern const iso_command *const iso_commands[]; /* ends with NULL */

/* What every command has. */
typedef struct iso_cli {
    int json, quiet, threads;
    size_t argument_count;
    const char **arguments; /* positional, owned by the parse */
    poptContext context;
    int argc;
    const char **argv;
    const iso_command *command;
} iso_cli;

typedef enum iso_cli_next { ISO_CLI_RUN, ISO_CLI_STOP } iso_cli_next;

/* Parses argv by `options` (popt; ended by POPT_TABLEEND) and the common ones.
 * On --help prints and sets *next to ISO_CLI_STOP. ISO_E_USAGE names the bad
 * option and value, and the number of positional arguments when it is not in
 * [min, max]. Release with iso_cli_end() in every case. */
iso_status iso_cli_parse(iso_cli *cli, const iso_command *command, int argc, const char **argv,
                         struct poptOption *options, size_t min_arguments, size_t max_arguments, iso_cli_next *next,
                         iso_error *err);
void iso_cli_end(iso_cli *cli);

/* The progress bar on stderr: drawn when that is a terminal, else a line a stage; silent with --quiet. */
iso_progress iso_cli_progress(const iso_cli *cli);

/* {"schema": "isoshade.COMMAND/1", "command": the command line, "options": {}}; add results, then print. */
json_t *iso_cli_json(const iso_cli *cli);
/* Prints the object on stdout, and releases it. */
void iso_cli_print_json(json_t *root);
/* The command line as one string, quoted for a shell; to be freed. */
char *iso_cli_command_line(const iso_cli *cli);
/* A word of a command line, quoted for a shell where it has to be. */
void iso_cli_put_word(FILE *f, const char *word);

/* "40x56x33", "1x1x2.5", or one number for all three. ISO_E_USAGE with the text. */
iso_status iso_cli_parse_sizes(const char *text, const char *option, size_t out[3], iso_error *err);
iso_status iso_cli_parse_numbers(const char *text, const char *option, double out[3], iso_error *err);
/* A number, or a quotient such as "1/255"; *end as strtod has it. */
double iso_cli_read_quotient(const char *text, char **end);
/* An image error, "1/255" or "0.004": above 0, at most 1. ISO_E_USAGE with the text. */
iso_status iso_cli_parse_error(const char *option, const char *text, double *error, iso_error *err);
/* ISO_E_USAGE "--option is VALUE, must be LO to HI". NaN fails. */
iso_status iso_cli_check_range(const char *option, double value, double lo, double hi, iso_error *err);

#endif
