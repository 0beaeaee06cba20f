/* SPDX-License-Identifier: MIT */
#include "options/option.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/words.h"

static size_t count_rows(const iso_option *o)
{
    size_t count = 0;
    for (; o && (o->name || o->table); ++o)
        count += o->table ? count_rows(o->table) : 1;
    return count;
}

static unsigned popt_kind(const iso_option *o)
{
    static const unsigned kinds[] = {
        [ISO_OPTION_TEXT] = POPT_ARG_STRING,   [ISO_OPTION_TEXTS] = POPT_ARG_ARGV,
        [ISO_OPTION_INT] = POPT_ARG_INT,       [ISO_OPTION_LONG] = POPT_ARG_LONG,
        [ISO_OPTION_DOUBLE] = POPT_ARG_DOUBLE, [ISO_OPTION_LONG_LONG] = POPT_ARG_LONGLONG,
    };
    return o->value ? kinds[o->kind] : POPT_ARG_NONE;
}

/* Appends the rows. False: no memory. */
static bool bind_rows(const iso_option *o, char *values, iso_bound_options *bound)
{
    bool good = true;
    for (; good && o && (o->name || o->table); ++o) {
        if (o->table) {
            good = bind_rows(o->table, values + o->at, bound);
            continue;
        }
        struct poptOption *to = &bound->popt[bound->count];
        *to = (struct poptOption){
            .longName = o->name,
            .shortName = o->letter,
            .argInfo = popt_kind(o) | (o->flags & ISO_SHOWN ? POPT_ARGFLAG_SHOW_DEFAULT : 0) |
                       (o->flags & ISO_HIDDEN ? POPT_ARGFLAG_DOC_HIDDEN : 0),
            .arg = values + o->at,
            .descrip = o->describe ? o->describe(o) : o->help,
            .argDescrip = o->value,
        };
        bound->rows[bound->count++] = o;
        good = to->descrip;
    }
    return good;
}

iso_status iso_options_bind(const iso_option *rows, size_t size, const void *defaults, iso_bound_options *bound,
                            iso_error *err)
{
    const size_t count = count_rows(rows);
    *bound = (iso_bound_options){.values = calloc(1, size + 1),
                                 .defaults = defaults,
                                 .popt = calloc(count + 1, sizeof *bound->popt),
                                 .rows = calloc(count + 1, sizeof *bound->rows),
                                 .texts = calloc(count + 1, sizeof *bound->texts)};
    if (bound->values && defaults)
        memcpy(bound->values, defaults, size);
    if (bound->values && bound->popt && bound->rows && bound->texts && bind_rows(rows, bound->values, bound))
        return ISO_OK;
    iso_options_unbind(bound);
    return iso_fail(err, ISO_E_MEMORY, "out of memory");
}

/* Returns the default of option i; NULL: zero. */
static const void *default_of(const iso_bound_options *bound, size_t i)
{
    const ptrdiff_t at = (const char *)bound->popt[i].arg - (const char *)bound->values;
    return bound->defaults ? (const char *)bound->defaults + at : NULL;
}

static double number_at(iso_option_kind kind, const void *at)
{
    switch (kind) {
    case ISO_OPTION_INT: return *(const int *)at;
    case ISO_OPTION_LONG: return (double)*(const long *)at;
    case ISO_OPTION_LONG_LONG: return (double)*(const long long *)at;
    default: return *(const double *)at;
    }
}

static iso_status check_limits(const iso_bound_options *bound, size_t i, iso_error *err)
{
    const iso_option *o = bound->rows[i];
    const void *usual = default_of(bound, i);
    const double value = number_at(o->kind, bound->popt[i].arg);
    char option[64];
    if (!(o->least < o->most) || value == (usual ? number_at(o->kind, usual) : 0))
        return ISO_OK;
    snprintf(option, sizeof option, "--%s", o->name);
    return iso_words_check_range(option, value, o->least, o->most, err);
}

/* Checks a text against "svg|pdf". */
static iso_status check_one_of(const iso_option *o, const char *text, iso_error *err)
{
    const size_t length = strlen(text);
    char list[128] = "";
    size_t used = 0;
    for (const char *word = o->value; *word;) {
        const size_t n = strcspn(word, "|");
        if (n == length && strncmp(word, text, n) == 0)
            return ISO_OK;
        const char *next = word + n + (word[n] == '|');
        const char *join = !used ? "" : *next ? ", " : " or ";
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%.*s", join, (int)n, word);
        word = next;
    }
    return iso_fail(err, ISO_E_USAGE, "--%s is \"%s\", must be %s", o->name, text, list);
}

iso_status iso_options_take(iso_bound_options *bound, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t i = 0; i < bound->count && !bound->is_taken; ++i) {
        const iso_option_kind kind = bound->rows[i]->kind;
        void *const *const usual = default_of(bound, i);
        if (kind == ISO_OPTION_TEXT || kind == ISO_OPTION_TEXTS) {
            void *const text = *(void **)bound->popt[i].arg;
            bound->texts[i] = usual && text == *usual ? NULL : text;
            if (status == ISO_OK && (bound->rows[i]->flags & ISO_ONE_OF) && bound->texts[i])
                status = check_one_of(bound->rows[i], text, err);
        } else if (status == ISO_OK) {
            status = check_limits(bound, i, err);
        }
    }
    bound->is_taken = true;
    return status;
}

void iso_options_unbind(iso_bound_options *bound)
{
    iso_error ignored = {""};
    if (bound->texts)
        iso_options_take(bound, &ignored);
    for (size_t i = 0; i < bound->count; ++i) {
        if (bound->rows[i]->describe)
            free((char *)bound->popt[i].descrip);
        if (bound->rows[i]->kind == ISO_OPTION_TEXTS)
            for (char **text = bound->texts[i]; text && *text; ++text)
                free(*text);
        free(bound->texts[i]);
    }
    free(bound->values);
    free(bound->popt);
    free(bound->rows);
    free(bound->texts);
    *bound = (iso_bound_options){0};
}
