/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "options/cli.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/json.h"
#include "base/process.h"
#include "base/provenance.h"
#include "base/ranks.h"
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
    for (size_t i = 0; i < names->count; ++i) {
        const char *summary = iso_names_summary(names, i);
        fprintf(f, "  %-*s%s%s\n", summary ? widest : 0, iso_names_name(names, i), summary ? "  " : "",
                summary ? summary : "");
    }
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
    for (; o->longName; ++o)
        if (!(o->argInfo & POPT_ARGFLAG_DOC_HIDDEN) && !is_common_name(command, o->longName)) {
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

static bool is_numeric(const iso_option *o)
{
    return o->value && o->kind != ISO_OPTION_TEXT && o->kind != ISO_OPTION_TEXTS;
}

/* Refuses an empty word, which popt reads as 0, and infinite numbers: -inf marks an option that is not given. */
static iso_status check_number(const iso_option *o, const char *text, iso_error *err)
{
    const char *option = o->name;
    char *end;
    if (!*text)
        return iso_fail(err, ISO_E_USAGE, "--%s is empty, must be a number", option);
    if ((o->flags & ISO_NOT_ZERO) && strtod(text, &end) == 0 && !*end)
        return o->least > 1
                   ? iso_fail(err, ISO_E_USAGE, "--%s is %s, must be %g to %g", option, text, o->least, o->most)
                   : iso_fail(err, ISO_E_USAGE, "--%s is %s, must be at least 1", option, text);
    return isinf(strtod(text, NULL)) ? iso_fail(err, ISO_E_USAGE, "--%s is %s, must be a finite number", option, text)
                                     : ISO_OK;
}

static iso_status check_numbers(const iso_bound_options *bound, int argc, const char **argv, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t k = 0; status == ISO_OK && k < bound->count; ++k) {
        const iso_option *o = bound->rows[k];
        const size_t length = strlen(o->name);
        for (int i = 1; is_numeric(o) && status == ISO_OK && i < argc && strcmp(argv[i], "--") != 0; ++i) {
            const char *word = argv[i];
            if (strncmp(word, "--", 2) != 0 || strncmp(word + 2, o->name, length) != 0)
                continue;
            const char *rest = word + 2 + length;
            if (*rest == '=' || (!*rest && i + 1 < argc))
                status = check_number(o, *rest ? rest + 1 : argv[i + 1], err);
        }
    }
    return status;
}

/* ---- options of all commands ---- */

typedef struct common_options {
    int json, quiet, threads, no_sandbox, full_paths, no_provenance, help;
    double timeout;
} common_options;
static const common_options common_defaults = {.timeout = -HUGE_VAL}; /* not given */
static const iso_option common_rows[] = {
    {"json", 0, "print one JSON object on stdout", NULL, ISO_IN(common_options, json)},
    {"quiet", 'q', "print no progress", NULL, ISO_IN(common_options, quiet)},
    {"threads", 0, "number of threads; 0: all cores", "N", ISO_IN(common_options, threads), .most = 1024},
    {"timeout", 0, "time limit of each external program; 0: none", "SECONDS", ISO_IN(common_options, timeout),
     .most = 1e9},
    {"no-sandbox", 0, "let other programs write anywhere and use the network", NULL,
     ISO_IN(common_options, no_sandbox)},
    {"full-paths", 0, "write full paths into outputs", NULL, ISO_IN(common_options, full_paths)},
    {"no-provenance", 0, "write no command and no input names into outputs", NULL,
     ISO_IN(common_options, no_provenance)},
    {"help", 'h', "show this text; --help=all: with all options", NULL, ISO_IN(common_options, help)},
    ISO_OPTIONS_END,
};

/* The options of a command and those of all commands. */
typedef struct all_options {
    iso_bound_options own, common;
    struct poptOption *table; /* both */
} all_options;

static void unbind(all_options *all)
{
    free(all->table);
    iso_options_unbind(&all->own);
    iso_options_unbind(&all->common);
}

static iso_status bind(const iso_command *command, all_options *all, iso_error *err)
{
    *all = (all_options){.table = NULL};
    NEED(iso_options_bind(command->options, command->options_size, command->defaults, &all->own, err));
    NEED(iso_options_bind(command->is_inner ? NULL : common_rows, sizeof(common_options), &common_defaults,
                          &all->common, err));
    const size_t own = all->own.count, common = all->common.count;
    all->table = calloc(own + common + 1, sizeof *all->table);
    NEED_MEMORY(all->table, err, "out of memory");
    memcpy(all->table, all->own.popt, own * sizeof *all->table);
    memcpy(all->table + own, all->common.popt, common * sizeof *all->table);
    return ISO_OK;
}

void iso_cli_visit_options(const iso_command *command, iso_cli_option_visitor visit, void *user)
{
    all_options all;
    iso_error err = {""};
    if (bind(command, &all, &err) == ISO_OK)
        for (size_t i = 0; i < all.own.count + all.common.count; ++i)
            visit(user, &all.table[i], i >= all.own.count);
    unbind(&all);
}

/* Applies the options that are given. The others keep the process's settings, which the environment may have
 * changed. */
static iso_status take_common(const common_options *c, iso_error *err)
{
    if (c->no_sandbox)
        iso_sandbox_set(false);
    if (c->full_paths && c->no_provenance)
        return iso_fail(err, ISO_E_USAGE, "--full-paths and --no-provenance exclude each other");
    if (c->full_paths || c->no_provenance)
        iso_provenance_set(c->full_paths ? ISO_PROVENANCE_PATHS : ISO_PROVENANCE_NONE);
    if (c->timeout != common_defaults.timeout)
        iso_process_set_limit(c->timeout);
    return ISO_OK;
}

/* ---- the values of all options, for keys ---- */

/* Returns the words of a list as one text, each in quotes. NULL: no memory. */
static json_t *words_json(char *const *words)
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

static json_t *value_json(const iso_option *o, const void *at)
{
    switch (o->kind) {
    case ISO_OPTION_INT: return json_sprintf("%d", *(const int *)at);
    case ISO_OPTION_LONG: return json_sprintf("%ld", *(const long *)at);
    case ISO_OPTION_LONG_LONG: return json_sprintf("%lld", *(const long long *)at);
    case ISO_OPTION_DOUBLE: return json_sprintf("%.17g", *(const double *)at);
    case ISO_OPTION_TEXTS: return words_json(*(char *const *const *)at);
    default: return *(char *const *)at ? json_string_nocheck(*(char *const *)at) : json_null();
    }
}

/* Adds the texts of all options to `given`. False: no memory. */
static bool keep_values(const iso_bound_options *bound, json_t *given)
{
    bool good = true;
    for (size_t i = 0; good && i < bound->count; ++i)
        good = json_object_set_new(given, bound->rows[i]->name, value_json(bound->rows[i], bound->popt[i].arg)) == 0;
    return good;
}

static iso_status keep_given(iso_cli *cli, const all_options *all, iso_error *err)
{
    cli->given = json_object();
    bool good = cli->given && keep_values(&all->own, cli->given) && keep_values(&all->common, cli->given);
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
    json_object_foreach (cli->given, name, value) {
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
    for (; o->longName; ++o)
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

/* Parses the words. *runs: false after --help, which is printed. */
static iso_status parse(iso_cli *cli, all_options *all, bool *runs, iso_error *err)
{
    const iso_command *command = cli->command;
    const common_options *common = all->common.values;
    const bool help_all = take_help_all(cli->argc, cli->argv);
    NEED(check_numbers(&all->own, cli->argc, cli->argv, err));
    NEED(check_numbers(&all->common, cli->argc, cli->argv, err));
    cli->context = poptGetContext(program, cli->argc, cli->argv, all->table, 0);
    const int result = poptGetNextOpt(cli->context);
    if (result < -1)
        return fail_option(command, cli->context, all->table, result, cli->argc, cli->argv, err);
    *runs = !common->help;
    if (common->help) {
        print_help(command, all->table, cli->context, help_all || !command->common);
        return ISO_OK;
    }
    cli->json = common->json, cli->threads = common->threads;
    cli->quiet = common->quiet || command->is_inner;
    NEED(iso_options_take(&all->own, err));
    NEED(iso_options_take(&all->common, err));
    NEED(take_common(common, err));
    if (!cli->quiet)
        cli->progress = iso_progress_line_create(command->name);
    cli->arguments = poptGetArgs(cli->context);
    while (cli->arguments && cli->arguments[cli->argument_count])
        ++cli->argument_count;
    if (cli->argument_count < command->min_arguments || cli->argument_count > command->max_arguments)
        return iso_fail(err, ISO_E_USAGE, "%zu arguments; usage: %s %s %s", cli->argument_count, program, command->name,
                        command->usage);
    iso_status status = keep_given(cli, all, err);
    /* tf checks its own outputs, whose names it makes. */
    return status == ISO_OK && strcmp(command->name, "tf") != 0
               ? iso_cli_refuse_overwriting(all->own.popt, cli->arguments, err)
               : status;
}

/* Refuses a command that each rank of a job would run whole. Rank 0 reports it: mpirun ends all when one fails. */
static iso_status refuse_ranks(const iso_command *command, bool *runs, iso_error *err)
{
    const char *variable = command->shares_ranks || command->is_inner ? NULL : iso_ranks_variable();
    *runs = !variable;
    if (!variable || iso_ranks_find_place().index > 0)
        return ISO_OK;
    return iso_fail(err, ISO_E_USAGE,
                    "several ranks were started, which cannot share its work; start one process, or unset %s for "
                    "independent ones",
                    variable);
}

iso_status iso_command_parse_and_run(const iso_command *command, int argc, const char **argv, iso_error *err)
{
    iso_cli cli = {.argc = argc, .argv = argv, .command = command};
    all_options all;
    bool runs = false;
    iso_status status = bind(command, &all, err);
    TRY(status, parse(&cli, &all, &runs, err));
    if (status == ISO_OK && runs)
        status = refuse_ranks(command, &runs, err);
    if (status == ISO_OK && runs)
        status = command->run(&cli, all.own.values, err);
    iso_progress_line_destroy(cli.progress);
    if (cli.context)
        poptFreeContext(cli.context);
    json_decref(cli.given);
    unbind(&all);
    return status;
}

iso_status iso_command_run(const iso_command *command, int argc, const char **argv, iso_error *err)
{
    return (command->run_words ? command->run_words : iso_command_parse_and_run)(command, argc, argv, err);
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

void iso_cli_print_results(const iso_cli *cli, json_t *results)
{
    json_t *root = iso_cli_json(cli);
    json_object_update_new(root, results);
    iso_cli_print_json(root);
}
