/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "options/cli.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/json.h"
#include "base/process.h"
#include "base/provenance.h"
#include "options/overwrite.h"

static const char *program = "isoshade";

void iso_cli_set_program(const char *name)
{
    program = name;
}

void iso_cli_print_names(FILE *f, const iso_names *names)
{
    int widest = 0;
    for (size_t i = 0; i < names->count; ++i) {
        const int width = (int)strlen(iso_names_name(names, i));
        widest = width > widest ? width : widest;
    }
    fprintf(f, "%s:\n", names->plural);
    for (size_t i = 0; i < names->count; ++i)
        fprintf(f, "  %-*s  %s\n", widest, iso_names_name(names, i), iso_names_summary(names, i));
}

/* ---- --help: at most 20 options; --help=all has all of them ---- */

/* Subjects under which --help lists rare options. An option in no row belongs to the last one. */
static const struct {
    const char *subject, *names;
} subjects[] = {
    {"files without a header", " raw-size raw-type raw-spacing raw-big-endian raw-skip "},
    {"reading a volume", " spacing unit series frame frames channel no-data resample force-spacing stored labels "
                         "no-labels "},
    {"transfer function", " name unit-distance opacity range bits always "},
    {"levels", " level-views level-size extinction-scale tf-2d adapt gauss-radius gauss-sigma eq1-exponent keep-float "
               "keep-magnitude direction-filter scalar-filter estimator code filters codes estimators "},
    {"region of interest", " roi roi-level roi-band "},
    {"bricks", " plan plan-error cache-bytes brick brick-levels page-side memory refine plans faces "},
    {"other programs", " renderers blender cycles-device gl-device timeout no-sandbox "},
    {"names in outputs", " full-paths no-provenance "},
    {"more", NULL},
};
enum { SUBJECTS = sizeof subjects / sizeof *subjects };

/* True if `names`, with a blank around each, has the name. */
static bool has_name(const char *names, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = names; (at = strstr(at, name)); at += length)
        if (at > names && at[-1] == ' ' && at[length] == ' ')
            return true;
    return false;
}

static bool is_common_name(const iso_command *command, const char *name)
{
    static const char always[] = " json quiet help ";
    char padded[1024];
    snprintf(padded, sizeof padded, " %s ", command->common);
    return has_name(always, name) || has_name(padded, name);
}

static size_t subject_of(const char *name)
{
    size_t i = 0;
    while (subjects[i].names && !has_name(subjects[i].names, name))
        ++i;
    return i;
}

/* Hides the options that only --help=all shows, and writes their names to the lines of their subjects. */
static void hide_rare(const iso_command *command, struct poptOption *o, FILE *lines[SUBJECTS])
{
    for (; o->longName || o->shortName || o->arg; ++o)
        if ((o->argInfo & POPT_ARG_MASK) == POPT_ARG_INCLUDE_TABLE) {
            hide_rare(command, o->arg, lines);
        } else if (o->longName && !(o->argInfo & POPT_ARGFLAG_DOC_HIDDEN) && !is_common_name(command, o->longName)) {
            o->argInfo |= POPT_ARGFLAG_DOC_HIDDEN;
            fprintf(lines[subject_of(o->longName)], " --%s", o->longName);
        }
}

/* Prints the words of a subject in lines of 100 columns. */
static void print_subject(const char *subject, char *words)
{
    int column = printf("  %-22s", subject);
    for (char *word = strtok(words, " "); word; word = strtok(NULL, " ")) {
        if (column + (int)strlen(word) + 1 > 100)
            column = printf("\n  %-22s", "") - 1;
        column += printf(" %s", word);
    }
    putchar('\n');
}

static void print_names_short(const iso_names *names)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    for (size_t i = 0; f && i < names->count; ++i)
        fprintf(f, " %s", iso_names_name(names, i));
    if (f)
        fclose(f);
    print_subject(names->plural, text);
    free(text);
}

/* Prints all options or the common ones, and the names that they choose from. */
static void print_options(const iso_command *command, struct poptOption *table, poptContext context, bool all)
{
    char *lines[SUBJECTS] = {NULL}, *text = NULL;
    size_t sizes[SUBJECTS], size = 0;
    FILE *files[SUBJECTS], *memory = open_memstream(&text, &size);
    bool is_whole = true;
    for (size_t i = 0; i < SUBJECTS; ++i)
        files[i] = open_memstream(&lines[i], &sizes[i]);
    if (!all)
        hide_rare(command, table, files);
    /* Skip popt's own "Usage:" line. */
    poptPrintHelp(context, memory, 0);
    fclose(memory);
    char *options = strchr(text, '\n');
    fputs(options ? options + 1 : text, stdout);
    free(text);
    for (size_t i = 0; i < SUBJECTS; ++i) {
        fclose(files[i]);
        if (*lines[i] && is_whole)
            printf("\nmore options; %s %s --help=all explains them:\n", program, command->name);
        is_whole &= !*lines[i];
        if (*lines[i])
            print_subject(subjects[i].subject, lines[i]);
        free(lines[i]);
    }
    if (command->lists)
        putchar('\n');
    for (const iso_names *const *list = command->lists; list && *list; ++list) {
        if (all) {
            iso_cli_print_names(stdout, *list);
            putchar('\n');
        } else {
            print_names_short(*list);
        }
    }
}

static void print_help(const iso_command *command, struct poptOption *table, poptContext context, bool all)
{
    printf("%s %s - %s\n\nusage: %s %s %s\n", program, command->name, command->summary, program, command->name,
           command->usage);
    if (command->details)
        printf("\n%s\n", command->details);
    printf("\noptions:\n");
    fflush(stdout);
    print_options(command, table, context, all);
    if (command->examples)
        printf("\nexamples:\n%s", command->examples);
}

/* Returns the option before a bad value in another word, which popt does not name; "" if there is none. */
static const char *option_before(const char *bad, int argc, const char **argv, char text[64])
{
    for (int i = 2; i < argc; ++i)
        if (strcmp(argv[i], bad) == 0 && argv[i - 1][0] == '-' && bad[0] != '-') {
            snprintf(text, 64, "%s ", argv[i - 1]);
            return text;
        }
    return "";
}

static bool is_numeric(const struct poptOption *o)
{
    switch (o->argInfo & POPT_ARG_MASK) {
    case POPT_ARG_INT:
    case POPT_ARG_SHORT:
    case POPT_ARG_LONG:
    case POPT_ARG_LONGLONG:
    case POPT_ARG_FLOAT:
    case POPT_ARG_DOUBLE: return true;
    default: return false;
    }
}

/* Refuses an empty word, which popt reads as 0, and infinite numbers: -inf marks an option that is not given. */
static iso_status check_number(const struct poptOption *o, const char *text, iso_error *err)
{
    const char *option = o->longName;
    char *end;
    if (!*text)
        return iso_fail(err, ISO_E_USAGE, "--%s is empty, must be a number", option);
    if (o->val == ISO_CLI_NOT_ZERO && strtod(text, &end) == 0 && !*end)
        return iso_fail(err, ISO_E_USAGE, "--%s is %s, must be at least 1", option, text);
    return isinf(strtod(text, NULL)) ? iso_fail(err, ISO_E_USAGE, "--%s is %s, must be a finite number", option, text)
                                     : ISO_OK;
}

static iso_status check_numbers(const struct poptOption *o, int argc, const char **argv, iso_error *err)
{
    iso_status status = ISO_OK;
    for (; status == ISO_OK && (o->longName || o->shortName || o->arg); ++o) {
        if ((o->argInfo & POPT_ARG_MASK) == POPT_ARG_INCLUDE_TABLE)
            status = check_numbers(o->arg, argc, argv, err);
        if (!is_numeric(o) || !o->longName)
            continue;
        const size_t length = strlen(o->longName);
        for (int i = 1; status == ISO_OK && i < argc && strcmp(argv[i], "--") != 0; ++i) {
            const char *word = argv[i];
            if (strncmp(word, "--", 2) != 0 || strncmp(word + 2, o->longName, length) != 0)
                continue;
            const char *rest = word + 2 + length;
            if (*rest == '=' || (!*rest && i + 1 < argc))
                status = check_number(o, *rest ? rest + 1 : argv[i + 1], err);
        }
    }
    return status;
}

/* Set while options are visited. Commands keep their tables on the stack of run(), so iso_cli_parse() passes them
 * on. */
static struct {
    iso_cli_option_visitor visit;
    void *user;
} visiting;

static void visit_table(const struct poptOption *o, bool is_common)
{
    for (; o->longName || o->shortName || o->arg; ++o)
        if ((o->argInfo & POPT_ARG_MASK) == POPT_ARG_INCLUDE_TABLE)
            visit_table(o->arg, is_common);
        else if (o->longName)
            visiting.visit(visiting.user, o, is_common);
}

void iso_cli_visit_options(const iso_command *command, iso_cli_option_visitor visit, void *user)
{
    const char *const argv[] = {command->name, NULL};
    iso_error err = {""};
    visiting.visit = visit;
    visiting.user = user;
    command->run(command, 1, (const char **)argv, &err);
    visiting.visit = NULL;
}

/* Applies the options that are given. The others keep the process's settings, which the environment may have
 * changed. */
static iso_status take_common(double timeout, bool no_sandbox, bool full_paths, bool no_provenance, iso_error *err)
{
    if (no_sandbox)
        iso_sandbox_set(false);
    if (full_paths && no_provenance)
        return iso_fail(err, ISO_E_USAGE, "--full-paths and --no-provenance exclude each other");
    if (full_paths || no_provenance)
        iso_provenance_set(full_paths ? ISO_PROVENANCE_PATHS : ISO_PROVENANCE_NONE);
    if (timeout == -HUGE_VAL)
        return ISO_OK;
    const iso_status status = iso_words_check_range("--timeout", timeout, 0, 1e9, err);
    if (status == ISO_OK)
        iso_process_set_limit(timeout);
    return status;
}

/* ---- the values of all options, for keys ---- */

/* Returns the words of a list as one text, each in quotes. NULL: no memory. */
static json_t *words_json(char **words)
{
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    for (; words && *words; ++words) {
        iso_words_put_quoted(f, *words);
        fputc(' ', f);
    }
    json_t *json = fclose(f) == 0 ? json_string_nocheck(text) : NULL; /* a path need not be UTF-8 */
    free(text);
    return json;
}

static json_t *value_json(const struct poptOption *o)
{
    switch (o->argInfo & POPT_ARG_MASK) {
    case POPT_ARG_NONE:
    case POPT_ARG_VAL:
    case POPT_ARG_INT: return json_sprintf("%d", *(int *)o->arg);
    case POPT_ARG_SHORT: return json_sprintf("%d", *(short *)o->arg);
    case POPT_ARG_LONG: return json_sprintf("%ld", *(long *)o->arg);
    case POPT_ARG_LONGLONG: return json_sprintf("%lld", *(long long *)o->arg);
    case POPT_ARG_FLOAT: return json_sprintf("%.9g", (double)*(float *)o->arg);
    case POPT_ARG_DOUBLE: return json_sprintf("%.17g", *(double *)o->arg);
    case POPT_ARG_ARGV: return words_json(*(char ***)o->arg);
    default: return *(char **)o->arg ? json_string_nocheck(*(char **)o->arg) : json_null();
    }
}

/* Adds the texts of all options to `given`. False: no memory. */
static bool keep_values(const struct poptOption *o, json_t *given)
{
    bool good = true;
    for (; good && (o->longName || o->shortName || o->arg); ++o)
        if ((o->argInfo & POPT_ARG_MASK) == POPT_ARG_INCLUDE_TABLE)
            good = keep_values(o->arg, given);
        else if (o->longName && o->arg)
            good = json_object_set_new(given, o->longName, value_json(o)) == 0;
    return good;
}

static iso_status keep_given(iso_cli *cli, const struct poptOption *table, iso_error *err)
{
    cli->given = json_object();
    bool good = cli->given && keep_values(table, cli->given);
    for (size_t i = 0; i < cli->argument_count && good; ++i) {
        char name[32];
        snprintf(name, sizeof name, " %zu", i + 1);
        good = json_object_set_new(cli->given, name, json_string_nocheck(cli->arguments[i])) == 0;
    }
    return good ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
}

static bool is_among(const char *name, const char *const *names)
{
    while (*names && strcmp(*names, name) != 0)
        ++names;
    return *names;
}

iso_key *iso_cli_key(const iso_cli *cli, const char *const *without)
{
    static const char *const never[] = {"json",          "quiet",  "timeout", "help", "full-paths",
                                        "no-provenance", "output", "resume",  NULL};
    iso_key *key = iso_key_create();
    const char *name;
    json_t *value;
    if (!key)
        return NULL;
    iso_key_add_text(key, "the command", cli->command->name);
    json_object_foreach(cli->given, name, value) {
        char part[80];
        if (json_is_null(value) || is_among(name, never) || is_among(name, without))
            continue;
        snprintf(part, sizeof part, "%s%s", name[0] == ' ' ? "argument" : "--", name);
        iso_key_add_text(key, part, json_string_value(value));
    }
    return key;
}

/* Replaces --help=all by --help, because popt has no optional values. True if it was there. */
static bool take_help_all(int argc, const char **argv)
{
    bool found = false;
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; ++i)
        if (strcmp(argv[i], "--help=all") == 0) {
            argv[i] = "--help";
            found = true;
        }
    return found;
}

static void guess_option(const struct poptOption *o, const char *word, iso_guess *guess)
{
    for (; o->longName || o->shortName || o->arg; ++o)
        if ((o->argInfo & POPT_ARG_MASK) == POPT_ARG_INCLUDE_TABLE)
            guess_option(o->arg, word, guess);
        else if (o->longName)
            iso_guess_try(guess, word, o->longName);
}

static iso_status fail_option(const iso_command *command, poptContext context, const struct poptOption *table,
                              int result, int argc, const char **argv, iso_error *err)
{
    const char *bad = poptBadOption(context, POPT_BADOPTION_NOALIAS);
    char option[64], word[64], text[80];
    iso_guess guess = {0};
    snprintf(word, sizeof word, "%.*s", (int)strcspn(bad, "="), bad);
    if (result == POPT_ERROR_BADOPT && strncmp(word, "--", 2) == 0)
        guess_option(table, word + 2, &guess);
    return iso_fail(err, ISO_E_USAGE, "%s%s: %s%s; %s %s --help lists the options%s",
                    option_before(bad, argc, argv, option), bad, poptStrerror(result),
                    iso_guess_text(&guess, "--", text), program, command->name,
                    command->is_inner ? "; a file may name only options of this command" : "");
}

iso_status iso_cli_parse(iso_cli *cli, const iso_command *command, int argc, const char **argv,
                         struct poptOption *options, iso_cli_next *next, iso_error *err)
{
    *cli = (iso_cli){.argc = argc, .argv = argv, .command = command, .quiet = command->is_inner};
    *next = ISO_CLI_RUN;
    int help = 0, no_sandbox = 0, no_provenance = 0, full_paths = 0;
    double timeout = -HUGE_VAL; /* not given */
    struct poptOption common[] = {
        {"json", 0, POPT_ARG_NONE, &cli->json, 0, "print one JSON object on stdout", NULL},
        {"quiet", 'q', POPT_ARG_NONE, &cli->quiet, 0, "print no progress", NULL},
        {"threads", 0, POPT_ARG_INT, &cli->threads, 0, "number of threads; 0: all cores", "N"},
        {"timeout", 0, POPT_ARG_DOUBLE, &timeout, 0, "time limit of each external program; 0: none", "SECONDS"},
        {"no-sandbox", 0, POPT_ARG_NONE, &no_sandbox, 0, "let other programs write anywhere and use the network", NULL},
        {"full-paths", 0, POPT_ARG_NONE, &full_paths, 0, "write full paths into outputs", NULL},
        {"no-provenance", 0, POPT_ARG_NONE, &no_provenance, 0, "write no command and no input names into outputs",
         NULL},
        {"help", 'h', POPT_ARG_NONE, &help, 0, "show this text; --help=all: with all options", NULL},
        POPT_TABLEEND,
    };
    struct poptOption table[] = {
        {NULL, 0, POPT_ARG_INCLUDE_TABLE, options, 0, NULL, NULL},
        {NULL, 0, POPT_ARG_INCLUDE_TABLE, common, 0, NULL, NULL},
        POPT_TABLEEND,
    };
    if (command->is_inner)
        table[1] = (struct poptOption)POPT_TABLEEND;
    if (visiting.visit) {
        visit_table(options, false);
        visit_table(common, true);
        *next = ISO_CLI_STOP;
        return ISO_OK;
    }
    const bool all = take_help_all(argc, argv);
    iso_status status = check_numbers(table, argc, argv, err);
    if (status != ISO_OK)
        return status;
    cli->context = poptGetContext(program, argc, argv, table, 0);
    /* popt stores values through POPT_ARG_* pointers, and stops at options that have a val. */
    int result;
    do
        result = poptGetNextOpt(cli->context);
    while (result > 0);
    if (result < -1)
        return fail_option(command, cli->context, table, result, argc, argv, err);
    if (help) {
        print_help(command, table, cli->context, all || !command->common);
        *next = ISO_CLI_STOP;
        return ISO_OK;
    }
    status = take_common(timeout, no_sandbox, full_paths, no_provenance, err);
    if (status != ISO_OK)
        return status;
    if (!cli->quiet)
        cli->progress = iso_progress_line_create(command->name);
    cli->arguments = poptGetArgs(cli->context);
    while (cli->arguments && cli->arguments[cli->argument_count])
        ++cli->argument_count;
    if (cli->argument_count < command->min_arguments || cli->argument_count > command->max_arguments)
        return iso_fail(err, ISO_E_USAGE, "%zu arguments; usage: %s %s %s", cli->argument_count, program, command->name,
                        command->usage);
    status = iso_words_check_range("--threads", cli->threads, 0, 1024, err);
    TRY(status, keep_given(cli, table, err));
    /* tf checks its own outputs, whose names it makes. */
    return status == ISO_OK && strcmp(command->name, "tf") != 0
               ? iso_cli_refuse_overwriting(options, cli->arguments, err)
               : status;
}

void iso_cli_end(iso_cli *cli)
{
    iso_progress_line_destroy(cli->progress);
    if (cli->context)
        poptFreeContext(cli->context);
    json_decref(cli->given);
    *cli = (iso_cli){0};
}

iso_progress iso_cli_progress(const iso_cli *cli)
{
    return iso_progress_of_line(cli->progress);
}

void iso_cli_expect(const iso_cli *cli, const iso_cli_stage *stages, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        iso_progress_line_expect(cli->progress, stages[i].name, stages[i].cost);
}

void iso_cli_expect_names(const iso_cli *cli, bool is_volume, const char *const stages[ISO_CLI_MAX_STAGES],
                          const char *otherwise)
{
    if (is_volume)
        iso_cli_expect(cli, &(iso_cli_stage){"pyramid", 1}, 1);
    for (size_t i = 0; i < ISO_CLI_MAX_STAGES && stages[i]; ++i) {
        const bool is_last = i + 1 == ISO_CLI_MAX_STAGES || !stages[i + 1];
        iso_cli_expect(cli, &(iso_cli_stage){stages[i], is_last ? 5 : 1}, 1);
    }
    if (!stages[0])
        iso_cli_expect(cli, &(iso_cli_stage){otherwise, 1}, 1);
}

char *iso_cli_command_line(const iso_cli *cli)
{
    char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (!memory)
        return NULL;
    if (iso_provenance_kept() != ISO_PROVENANCE_NONE) {
        fprintf(memory, "%s %s", program, cli->command->name); /* a name may be two words */
        for (int i = 1; i < cli->argc; ++i) {
            fputc(' ', memory);
            iso_provenance_put_word(memory, cli->argv[i]);
        }
    }
    fclose(memory);
    return text;
}

json_t *iso_cli_json(const iso_cli *cli)
{
    char schema[64];
    snprintf(schema, sizeof schema, "%s.%s/1", program, cli->command->name);
    for (char *space = strchr(schema, ' '); space; space = strchr(space, ' '))
        *space = '.';
    char *line = iso_cli_command_line(cli);
    json_t *root = json_pack("{s:s, s:s, s:{}}", "schema", schema, "command", line ? line : "", "options");
    free(line);
    return root;
}

void iso_cli_print_json(json_t *root)
{
    char *text = iso_json_text(root, JSON_INDENT(2));
    if (text)
        puts(text);
    free(text);
    json_decref(root);
}
