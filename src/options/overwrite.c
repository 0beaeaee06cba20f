/* SPDX-License-Identifier: MIT */
#include "options/overwrite.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/inputs.h"

static bool is_output(const struct poptOption *o)
{
    const char *const names[] = {"output",    "png",        "junit",    "image", "full-image", "difference",
                                 "histogram", "summary-md", "flip-map", "csv",   "page"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (strcmp(o->longName, names[i]) == 0)
            return true;
    return false;
}

/* True for tables that --csv extends. */
static bool is_continued(const struct poptOption *o)
{
    return strcmp(o->longName, "have") == 0;
}

iso_status iso_cli_refuse_same_file(const char *output, const char *input, iso_error *err)
{
    struct stat a, b;
    if (!output || !input || stat(output, &a) != 0 || stat(input, &b) != 0 || !S_ISREG(a.st_mode) ||
        a.st_dev != b.st_dev || a.st_ino != b.st_ino)
        return ISO_OK;
    return iso_fail(err, ISO_E_USAGE, "the output %s would overwrite the input %s; choose another name", output, input);
}

/* Calls `visit` for each text that an option of the table was given, until one fails. */
typedef struct visitor {
    iso_status (*visit)(struct visitor *self, const struct poptOption *option, const char *text);
    const struct poptOption *all;
    const char *const *arguments;
    const char *output; /* compared with the other texts */
    iso_error *err;
} visitor;

static iso_status visit_texts(const struct poptOption *o, visitor *v)
{
    for (; o->longName; ++o) {
        const unsigned kind = o->argInfo & POPT_ARG_MASK;
        if (kind == POPT_ARG_STRING && *(char **)o->arg)
            NEED(v->visit(v, o, *(char **)o->arg));
        else if (kind == POPT_ARG_ARGV && *(char ***)o->arg)
            for (char **text = *(char ***)o->arg; *text; ++text)
                NEED(v->visit(v, o, *text));
    }
    return ISO_OK;
}

/* True if two paths name the same file or folder, existing or not. */
static bool is_one_place(const char *a, const char *b)
{
    struct stat x, y;
    if (stat(a, &x) == 0 && stat(b, &y) == 0)
        return x.st_dev == y.st_dev && x.st_ino == y.st_ino;
    FREED char *dir_a = iso_path_dir(a), *dir_b = iso_path_dir(b);
    const bool is_one = dir_a && dir_b && strcmp(iso_path_base(a), iso_path_base(b)) == 0 && stat(dir_a, &x) == 0 &&
                        stat(dir_b, &y) == 0 && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
    return is_one;
}

static iso_status compare_text(visitor *v, const struct poptOption *o, const char *text)
{
    if (is_continued(o) || text == v->output)
        return ISO_OK;
    if (!is_output(o))
        return iso_cli_refuse_same_file(v->output, text, v->err);
    return is_one_place(v->output, text)
               ? iso_fail(v->err, ISO_E_USAGE, "the outputs %s and %s (--%s) are the same file; choose another name",
                          v->output, text, o->longName)
               : ISO_OK;
}

static iso_status compare_output(visitor *v, const struct poptOption *o, const char *text)
{
    if (!is_output(o))
        return ISO_OK;
    visitor inner = *v;
    inner.visit = compare_text;
    inner.output = text;
    iso_status status = iso_inputs_announce(text, v->err);
    for (const char *const *input = v->arguments; status == ISO_OK && input && *input; ++input)
        status = iso_cli_refuse_same_file(text, *input, v->err);
    return status == ISO_OK ? visit_texts(v->all, &inner) : status;
}

iso_status iso_cli_refuse_overwriting(const struct poptOption *options, const char *const *arguments, iso_error *err)
{
    visitor v = {.visit = compare_output, .all = options, .arguments = arguments, .err = err};
    return visit_texts(options, &v);
}
