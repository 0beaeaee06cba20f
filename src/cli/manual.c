/* SPDX-License-Identifier: MIT */
/* manual.c - prints the manual page isoshade(1). */
#include "cli/manual.h"

#include <ctype.h>
#include <string.h>

#include "cli/commands.h"
#include "options/cli.h"

/* ---- text for troff ---- */

/* Escapes text: hyphens of options as minus signs, and periods and quotes that would begin a request. */
static void put_escaped(FILE *f, const char *text, size_t length)
{
    for (size_t i = 0; i < length && text[i]; ++i) {
        const bool starts_line = i == 0 || text[i - 1] == '\n';
        if (starts_line && (text[i] == '.' || text[i] == '\''))
            fputs("\\&", f);
        switch (text[i]) {
        case '\\': fputs("\\e", f); break;
        case '-': fputs("\\-", f); break;
        case '`': fputs("\\`", f); break;
        case '\'': fputs("\\(aq", f); break;
        case '^': fputs("\\(ha", f); break;
        case '~': fputs("\\(ti", f); break;
        default: fputc(text[i], f); break;
        }
    }
}

static void put_text(FILE *f, const char *text)
{
    put_escaped(f, text, strlen(text));
}

/* Returns the length of the first word if the line is an item such as "  ramp: linear in x" or "adapt    writes ...";
 * otherwise 0. */
static size_t item_length(const char *line, size_t length)
{
    const size_t indent = strspn(line, " ");
    size_t end = indent;
    while (end < length && (isalnum((unsigned char)line[end]) || line[end] == '-'))
        ++end;
    const bool is_indented = indent == 2 && end > indent && line[end] == ':';
    const bool is_column = indent == 0 && end > 0 && end + 1 < length && line[end] == ' ' &&
                           strspn(line + end, " ") > 1;
    return is_indented || is_column ? end - indent : 0;
}

/* Prints a text: lines are filled, lists become tagged paragraphs, and empty lines separate paragraphs. */
static void put_details(FILE *f, const char *details)
{
    bool in_list = false;
    for (const char *line = details; *line;) {
        const size_t length = strcspn(line, "\n"), indent = strspn(line, " "), item = item_length(line, length);
        if (length == 0) {
            fputs(".PP\n", f);
        } else if (item > 0) {
            const char *rest = line + indent + item;
            rest += strspn(rest, ": ");
            fputs(".TP\n", f);
            put_escaped(f, line + indent, item);
            fputc('\n', f);
            put_escaped(f, rest, length - (size_t)(rest - line));
            fputc('\n', f);
        } else {
            if (in_list && indent == 0)
                fputs(".PP\n", f);
            put_escaped(f, line + indent, length - indent);
            fputc('\n', f);
        }
        in_list = item > 0 || (in_list && indent > 0);
        line += length + (line[length] == '\n');
    }
}

/* ---- sections ---- */

static void put_option(void *user, const struct poptOption *o, bool is_common)
{
    FILE *f = user;
    if (is_common)
        return;
    fputs(".TP\n", f);
    if (o->shortName)
        fprintf(f, "\\fB\\-%c\\fR, ", o->shortName);
    fputs("\\fB\\-\\-", f);
    put_text(f, o->longName);
    fputs("\\fR", f);
    if (o->argDescrip) {
        fputs("=\\fI", f);
        put_text(f, o->argDescrip);
        fputs("\\fR", f);
    }
    fputc('\n', f);
    put_text(f, o->descrip ? o->descrip : "");
    fputc('\n', f);
}

static void put_common_option(void *user, const struct poptOption *o, bool is_common)
{
    if (is_common)
        put_option(user, o, false);
}

static void put_benchmarks(FILE *f)
{
    for (const iso_command *const *b = iso_benchmarks; *b; ++b) {
        fputs(".TP\n.B ", f);
        put_text(f, (*b)->name + strlen("bench "));
        fputc('\n', f);
        put_text(f, (*b)->summary);
        fputc('\n', f);
    }
    fputs(".PP\nisoshade bench NAME \\-\\-help shows the options of a benchmark.\n", f);
}

/* Prints names that options choose from. */
static void put_list(FILE *f, const iso_names *names)
{
    fprintf(f, ".PP\n%c", toupper((unsigned char)names->plural[0]));
    put_text(f, names->plural + 1);
    fputs(":\n", f);
    for (size_t i = 0; i < names->count; ++i) {
        const char *summary = iso_names_summary(names, i);
        fputs(".TP\n.B ", f);
        put_text(f, iso_names_name(names, i));
        fputc('\n', f);
        put_text(f, summary);
        fputc('\n', f);
    }
}

static void put_command(FILE *f, const iso_command *c)
{
    fputs(".SS ", f);
    put_text(f, c->name);
    fputs("\n.B isoshade ", f);
    put_text(f, c->name);
    fputc(' ', f);
    put_text(f, c->usage);
    fprintf(f, "\n.PP\n%c", toupper((unsigned char)c->summary[0]));
    put_text(f, c->summary + 1);
    fputs(".\n", f);
    if (c->details) {
        fputs(".PP\n", f);
        put_details(f, c->details);
    }
    if (strcmp(c->name, "bench") == 0)
        put_benchmarks(f);
    iso_cli_visit_options(c, put_option, f);
    for (const iso_names *const *list = c->lists; list && *list; ++list)
        put_list(f, *list);
}

static void put_examples(FILE *f, const iso_command *c)
{
    if (!c->examples)
        return;
    for (const char *line = c->examples; *line;) {
        const size_t length = strcspn(line, "\n"), indent = strspn(line, " ");
        put_escaped(f, line + indent, length - indent);
        fputc('\n', f);
        line += length + (line[length] == '\n');
    }
}

static void put_environment(FILE *f)
{
    fputs(".SH ENVIRONMENT\n.TP\n.BR ISOSHADE_BLENDER ,\\  ISOSHADE_POVRAY ,\\  ISOSHADE_GNUPLOT\n"
          ".TQ\n.BR ISOSHADE_PYTHON3 ,\\  ISOSHADE_CHROMIUM\n"
          "Program to run instead of the one in the PATH.\n"
          ".TP\n.B ISOSHADE_RENDERERS\nRender programs, as for \\-\\-renderers.\n"
          ".TP\n.B ISOSHADE_GL_DEVICE\nDevice of the OpenGL ray caster, as for \\-\\-gl\\-device.\n"
          ".TP\n.B ISOSHADE_CYCLES_DEVICE\nDevice of Cycles, as for \\-\\-cycles\\-device.\n"
          ".TP\n.B ISOSHADE_SANDBOX\noff: other programs run with all rights of the user, as with \\-\\-no\\-sandbox.\n"
          ".TP\n.B ISOSHADE_LIBRARY\nFile of the library that the Python package loads.\n"
          ".TP\n.B TMPDIR\nFolder for temporary files.\n",
          f);
}

void iso_manual_print_page(FILE *f)
{
    fprintf(f, ".TH ISOSHADE 1 \"\" \"isoshade %s\" \"User Commands\"\n", ISO_VERSION);
    fputs(
        ".SH NAME\nisoshade \\- shading of volumes that is the same at every level of detail and in every renderer\n"
        ".SH SYNOPSIS\n.B isoshade\n.I COMMAND\n.RI [ options ]\n.br\n.B isoshade\n.I COMMAND\n.B \\-\\-help\n"
        ".SH DESCRIPTION\nPreprocesses scalar volumes into pyramids, exports them to OpenVDB, Blender and POV\\-Ray, renders them,\n"
        "and reports whether renderers agree. Results go to standard output, messages and progress to standard error.\n"
        ".SH OPTIONS OF EVERY COMMAND\n",
        f);
    iso_cli_visit_options(iso_commands[0], put_common_option, f);
    fputs(".SH COMMANDS\n", f);
    for (const iso_command *const *c = iso_commands; *c; ++c)
        put_command(f, *c);
    fputs(".SH EXIT STATUS\n", f);
#define ISO_STATUS_ITEM(name, code, text) fprintf(f, ".TP\n.B %d\n%s\n", code, text);
    ISO_STATUS_LIST(ISO_STATUS_ITEM)
#undef ISO_STATUS_ITEM
    put_environment(f);
    fputs(".SH EXAMPLES\n.nf\n", f);
    for (const iso_command *const *c = iso_commands; *c; ++c)
        put_examples(f, *c);
    fputs(".fi\n.SH SEE ALSO\n.BR blender (1),\n.BR povray (1),\n.BR gnuplot (1)\n", f);
}
