/* SPDX-License-Identifier: MIT */
/* completion.c - prints functions for bash and zsh that complete commands, options and listed values. */
#define _GNU_SOURCE
#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "base/names.h"
#include "blender/blender.h"
#include "cli/commands.h"
#include "cli/manual.h"
#include "encode/code.h"
#include "gradient/gradient.h"
#include "palette/palette.h"
#include "pyramid/pyramid.h"
#include "scene/field.h"
#include "targets/targets.h"
#include "volume/synthetic.h"

/* ---- values from lists of a command ---- */

static const struct {
    const char *option;
    const iso_names *names;
} lists_of_options[] = {
    {"to", &iso_export_target_names},
    {"material", &iso_blender_material_names},
    {"code", &iso_code_names},
    {"estimator", &iso_gradient_names},
    {"scalar-filter", &iso_scalar_filter_names},
    {"direction-filter", &iso_direction_filter_names},
    {"shading-from", &iso_direction_source_names},
    {"method", &iso_palette_method_names},
};

static bool has_list(const iso_command *c, const iso_names *names)
{
    for (const iso_names *const *list = c->lists; list && *list; ++list)
        if (*list == names)
            return true;
    return false;
}

/* Returns the names with spaces between them; to be freed. */
static char *words_of_list(const iso_names *names)
{
    char *words = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&words, &size);
    for (size_t i = 0; f && i < names->count; ++i)
        fprintf(f, "%s%s", i ? " " : "", iso_names_name(names, i));
    if (f)
        fclose(f);
    return words;
}

/* Returns the values that an option chooses from; NULL if it has no list. */
static char *names_of_option(const iso_command *c, const char *option)
{
    for (size_t i = 0; i < sizeof lists_of_options / sizeof *lists_of_options; ++i)
        if (strcmp(lists_of_options[i].option, option) == 0 && has_list(c, lists_of_options[i].names))
            return words_of_list(lists_of_options[i].names);
    return NULL;
}

/* ---- values from help texts ---- */

static size_t word_length(const char *text)
{
    size_t n = 0;
    while (islower((unsigned char)text[n]) || isdigit((unsigned char)text[n]) || (n > 0 && text[n] == '-'))
        ++n;
    return n;
}

static const char *skip_default(const char *text)
{
    return strncmp(text, " (default)", 10) == 0 ? text + 10 : text;
}

/* Finds a list in a help text, such as "moments (default), eq1, naive or tensor" or "uint8, int16, ...", after an
 * optional "reference: ". Returns its words with spaces between them, to be freed. NULL if the text does not begin with
 * a list. */
static char *listed_values(const char *text)
{
    const char *colon = strstr(text, ": ");
    const size_t first = word_length(text);
    if (colon && strcspn(text, ",;(") > (size_t)(colon - text))
        text = colon + 2;
    else if (first == 0)
        return NULL;
    char *words = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&words, &size);
    bool is_list = false;
    for (int count = 0; f; ++count) {
        const size_t n = word_length(text);
        fprintf(f, "%s%.*s", count ? " " : "", (int)n, text);
        text = skip_default(text + n);
        if (n == 0 || strncmp(text, ", ...", 5) == 0) {
            is_list = n > 0 && count > 0;
            break;
        }
        if (strncmp(text, " or ", 4) == 0) {
            const size_t last = word_length(text + 4);
            fprintf(f, " %.*s", (int)last, text + 4);
            is_list = last > 0 && strchr(",;:", *skip_default(text + 4 + last)); /* also matches the end of the text */
            is_list = is_list || strncmp(text + 4 + last, " (", 2) == 0;
            break;
        }
        if (strncmp(text, ", ", 2) != 0)
            break;
        text += 2;
    }
    if (f)
        fclose(f);
    if (is_list)
        return words;
    free(words);
    return NULL;
}

static char *values_of(const iso_command *c, const struct poptOption *o)
{
    char *words = names_of_option(c, o->longName);
    return words || !o->descrip ? words : listed_values(o->descrip);
}

/* Finds the actions in a usage such as "adapt VOLUME ... | convert FILE ...", or make's kinds of volumes. Returns them
 * as above, or NULL. */
static char *listed_actions(const iso_command *c)
{
    const char *usage = c->usage;
    if (strcmp(c->name, "make") == 0)
        return words_of_list(&iso_field_names);
    char *words = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&words, &size);
    for (const char *part = usage; f && part; part = strstr(part, " | "), part = part ? part + 3 : NULL)
        fprintf(f, "%s%.*s", part == usage ? "" : " ", (int)word_length(part), part);
    if (f)
        fclose(f);
    if (words && isalpha((unsigned char)words[0]))
        return words;
    free(words);
    return NULL;
}

/* ---- bash ---- */

static void put_bash_option(void *user, const struct poptOption *o, bool is_common)
{
    (void)is_common;
    fprintf(user, " --%s", o->longName);
    if (o->shortName)
        fprintf(user, " -%c", o->shortName);
}

typedef struct value_writer {
    FILE *f;
    const iso_command *command;
} value_writer;

static void put_bash_values(void *user, const struct poptOption *o, bool is_common)
{
    const value_writer *w = user;
    (void)is_common;
    if (!o->argDescrip)
        return;
    FREED char *values = values_of(w->command, o);
    fprintf(w->f, "    '%s --%s'", w->command->name, o->longName);
    if (o->shortName)
        fprintf(w->f, " | '%s -%c'", w->command->name, o->shortName);
    fprintf(w->f, ") values='%s' takes=1 ;;\n", values ? values : "");
}

static void put_bash_command(FILE *f, const iso_command *c)
{
    FREED char *actions = listed_actions(c);
    fprintf(f, "    '%s') actions='%s' options='", c->name, actions ? actions : "");
    iso_cli_visit_options(c, put_bash_option, f);
    fputs("' ;;\n", f);
}

static void put_bash_names(FILE *f, const iso_command *const *list, size_t skip)
{
    for (const iso_command *const *c = list; *c; ++c)
        fprintf(f, " %s", (*c)->name + skip);
}

/* Calls `put` for each command and benchmark, without bench itself. */
static void each_command(FILE *f, void (*put)(FILE *f, const iso_command *c))
{
    for (const iso_command *const *c = iso_commands; *c; ++c)
        if (strcmp((*c)->name, "bench") != 0)
            put(f, *c);
    for (const iso_command *const *c = iso_benchmarks; *c; ++c)
        put(f, *c);
}

static void put_bash_command_values(FILE *f, const iso_command *c)
{
    value_writer w = {f, c};
    iso_cli_visit_options(c, put_bash_values, &w);
}

/* Prints the bash function. If it proposes nothing, "-o default" of complete proposes files. */
static void print_bash(FILE *f)
{
    fputs(
        "# bash completion of isoshade " ISO_VERSION ", made by `isoshade completion bash`\n"
        "_isoshade() {\n"
        "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]}\n"
        "    local first=2 actions= options= values= takes=\n"
        "    COMPREPLY=()\n"
        "    # --option=value comes as three words.\n"
        "    if [ \"$word\" = = ]; then word=; elif [ \"$before\" = = ]; then before=${COMP_WORDS[COMP_CWORD - 2]}; fi\n"
        "    if [ \"$COMP_CWORD\" = 1 ]; then\n"
        "        COMPREPLY=($(compgen -W '",
        f);
    put_bash_names(f, iso_commands, 0);
    fputs(" --help --version' -- \"$word\"))\n        return\n    fi\n"
          "    if [ \"$command\" = bench ]; then\n"
          "        if [ \"$COMP_CWORD\" = 2 ]; then\n"
          "            COMPREPLY=($(compgen -W '",
          f);
    put_bash_names(f, iso_benchmarks, strlen("bench "));
    fputs("' -- \"$word\"))\n            return\n        fi\n"
          "        command=\"bench ${COMP_WORDS[2]}\" first=3\n"
          "    fi\n"
          "    case \"$command\" in\n",
          f);
    each_command(f, put_bash_command);
    fputs("    esac\n    case \"$command $before\" in\n", f);
    each_command(f, put_bash_command_values);
    fputs("    esac\n"
          "    if [ -n \"$takes\" ]; then\n"
          "        [ -z \"$values\" ] || COMPREPLY=($(compgen -W \"$values\" -- \"$word\"))\n"
          "    elif [[ $word == -* ]]; then\n"
          "        COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
          "    elif [ \"$COMP_CWORD\" = $first ] && [ -n \"$actions\" ]; then\n"
          "        COMPREPLY=($(compgen -W \"$actions\" -- \"$word\"))\n"
          "    fi\n"
          "}\n"
          "complete -o default -F _isoshade isoshade\n",
          f);
}

/* ---- zsh ---- */

/* Escapes text for '...' in a specification of _arguments: quotes, and separators of fields. */
static void put_zsh_text(FILE *f, const char *text)
{
    for (; *text; ++text) {
        if (*text == '\'')
            fputs("'\\''", f);
        else if (strchr("[]:\\", *text))
            fprintf(f, "\\%c", *text);
        else
            fputc(*text, f);
    }
}

static void put_zsh_option(void *user, const struct poptOption *o, bool is_common)
{
    const value_writer *w = user;
    FILE *f = w->f;
    (void)is_common;
    fputs(" \\\n            '", f);
    if (o->shortName)
        fprintf(f, "(-%c --%s)'{-%c,--%s%s}'", o->shortName, o->longName, o->shortName, o->longName,
                o->argDescrip ? "=" : "");
    else
        fprintf(f, "--%s%s", o->longName, o->argDescrip ? "=" : "");
    fputc('[', f);
    put_zsh_text(f, o->descrip ? o->descrip : "");
    fputc(']', f);
    if (o->argDescrip) {
        FREED char *values = values_of(w->command, o);
        fputc(':', f);
        put_zsh_text(f, o->argDescrip);
        if (values)
            fprintf(f, ":(%s)", values);
        else
            fputs(strncmp(o->argDescrip, "DIR", 3) == 0 ? ":_files -/" : ":_files", f);
    }
    fputc('\'', f);
}

static void put_zsh_command(FILE *f, const iso_command *c)
{
    FREED char *actions = listed_actions(c);
    fprintf(f, "    '%s')\n        _arguments -s", c->name);
    value_writer w = {f, c};
    iso_cli_visit_options(c, put_zsh_option, &w);
    if (actions)
        fprintf(f, " \\\n            '1:action:(%s)'", actions);
    fputs(" \\\n            '*:file:_files' ;;\n", f);
}

static void put_zsh_names(FILE *f, const iso_command *const *list, size_t skip)
{
    for (const iso_command *const *c = list; *c; ++c) {
        fprintf(f, "        '%s:", (*c)->name + skip);
        put_zsh_text(f, (*c)->summary);
        fputs("'\n", f);
    }
}

static void print_zsh(FILE *f)
{
    fputs("#compdef isoshade\n# zsh completion of isoshade " ISO_VERSION ", made by `isoshade completion zsh`\n"
          "_isoshade() {\n    local -a commands benchmarks\n    commands=(\n",
          f);
    put_zsh_names(f, iso_commands, 0);
    fputs("    )\n    benchmarks=(\n", f);
    put_zsh_names(f, iso_benchmarks, strlen("bench "));
    fputs(
        "    )\n"
        "    if (( CURRENT == 2 )); then\n        _describe command commands\n        return\n    fi\n"
        "    shift words\n    (( CURRENT-- ))\n"
        "    local command=$words[1]\n"
        "    if [[ $command == bench ]]; then\n"
        "        if (( CURRENT == 2 )); then\n            _describe benchmark benchmarks\n            return\n        fi\n"
        "        shift words\n        (( CURRENT-- ))\n        command=\"bench $words[1]\"\n"
        "    fi\n"
        "    case $command in\n",
        f);
    each_command(f, put_zsh_command);
    fputs("    esac\n}\n_isoshade \"$@\"\n", f);
}

iso_status iso_manual_print_completion(FILE *f, const char *shell, iso_error *err)
{
    if (strcmp(shell, "bash") == 0)
        print_bash(f);
    else if (strcmp(shell, "zsh") == 0)
        print_zsh(f);
    else
        return iso_fail(err, ISO_E_USAGE, "no completion for \"%s\", must be bash or zsh", shell);
    return ISO_OK;
}
