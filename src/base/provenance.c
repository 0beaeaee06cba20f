/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/provenance.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/words.h"

static iso_provenance kept_now = ISO_PROVENANCE_NAMES;

void iso_provenance_set(iso_provenance kept)
{
    kept_now = kept;
}

iso_provenance iso_provenance_kept(void)
{
    return kept_now;
}

/* Returns a path's last name, trailing slashes ignored: the name of "a/b/" is "b/". */
static const char *last_name(const char *path)
{
    const char *name = path;
    for (const char *c = path; *c; ++c)
        if (*c == '/' && c[1] && c[1] != '/')
            name = c + 1;
    return name;
}

const char *iso_provenance_name(const char *path)
{
    if (!path || kept_now == ISO_PROVENANCE_NONE)
        return "";
    return kept_now == ISO_PROVENANCE_PATHS ? path : last_name(path);
}

const char *iso_provenance_path(const char *path)
{
    return path && path[0] != '/' && kept_now == ISO_PROVENANCE_NAMES ? path : iso_provenance_name(path);
}

const char *iso_provenance_title(const char *path)
{
    return path && kept_now != ISO_PROVENANCE_NONE ? last_name(path) : "a volume";
}

char *iso_provenance_scene(const char *path, size_t number)
{
    static const char ending[] = ".scene.json";
    char *name = NULL;
    if (kept_now == ISO_PROVENANCE_NONE)
        return number == 0 ? strdup("scene") : asprintf(&name, "scene-%zu", number) < 0 ? NULL : name;
    path = last_name(path);
    const size_t length = strlen(path), end = strlen(ending);
    return strndup(path, length > end && strcmp(path + length - end, ending) == 0 ? length - end : length);
}

/* Returns the absolute path within a part of a word, as in "/a/b", "name=/a/b" and "-o/a/b"; or the part's end. */
static const char *absolute_in(const char *part)
{
    const char *slash = part[0] == '-' && part[1] && part[2] == '/' ? part + 2 : part[0] == '/' ? part : NULL;
    for (const char *c = part; !slash && *c; ++c)
        if (strchr("=:", c[0]) && c[1] == '/')
            slash = c + 1;
    return slash ? slash : part + strlen(part);
}

/* True if each part of a list of paths is absolute; otherwise "/a/b, c/d" is one path with a comma in its name. */
static bool all_absolute(const char *list)
{
    for (; list; list = strchr(list, ',') ? strchr(list, ',') + 1 : NULL)
        if (*list != '/')
            return false;
    return true;
}

void iso_provenance_put_word(FILE *f, const char *word)
{
    char copy[4096], text[4096], *rest = copy, *to = text;
    if (kept_now == ISO_PROVENANCE_PATHS || !strchr(word, '/')) {
        iso_words_put_quoted(f, word);
        return;
    }
    if (snprintf(copy, sizeof copy, "%s", word) >= (int)sizeof copy) {
        iso_words_put_quoted(f, "...");
        return;
    }
    const bool is_one = *absolute_in(word) && !all_absolute(absolute_in(word));
    for (char *part; (part = is_one ? rest : strsep(&rest, ","));) {
        const char *absolute = absolute_in(part);
        to = stpncpy(to, part, (size_t)(absolute - part));
        to = stpcpy(to, iso_provenance_name(absolute));
        if (is_one || !rest)
            break;
        *to++ = ',';
    }
    iso_words_put_quoted(f, text);
}

/* Returns the end of a word: a space outside of quotes, or the line's end. */
static const char *end_of_word(const char *word)
{
    bool quoted = false;
    for (; *word && (quoted || *word != ' '); ++word)
        if (*word == '\'')
            quoted = !quoted;
        else if (*word == '\\' && !quoted && word[1])
            ++word;
    return word;
}

/* Removes a word's quotes, in place. */
static void unquote(char *word)
{
    char *to = word;
    bool quoted = false;
    for (const char *c = word; *c; ++c)
        if (*c == '\'')
            quoted = !quoted;
        else if (*c == '\\' && !quoted && c[1])
            *to++ = *++c;
        else
            *to++ = *c;
    *to = 0;
}

char *iso_provenance_line(const char *line)
{
    char *text = NULL, *word = malloc(strlen(line) + 1);
    size_t size = 0;
    FILE *f = word ? open_memstream(&text, &size) : NULL;
    while (f && kept_now != ISO_PROVENANCE_NONE && *line) {
        const char *end = end_of_word(line);
        const size_t n = (size_t)(end - line);
        memcpy(word, line, n);
        word[n] = 0;
        if (strchr(word, '/')) {
            unquote(word);
            iso_provenance_put_word(f, word);
        } else {
            fputs(word, f); /* as it is: && too */
        }
        for (line = end; *line == ' '; ++line)
            fputc(' ', f);
    }
    if (f)
        fclose(f);
    free(word);
    return text;
}

char *iso_provenance_shorten(char *text)
{
    static const char ends[] = " \t'\"`,;:()[]<>";
    char *to = text;
    for (const char *c = text; kept_now != ISO_PROVENANCE_PATHS && *c;) {
        const bool begins = *c == '/' && (c == text || strchr(ends, c[-1]) || c[-1] == '=');
        const size_t n = begins ? strcspn(c, ends) : 1;
        size_t folders = 0;
        for (size_t i = 1; begins && i + 1 < n; ++i)
            if (c[i] == '/')
                folders = i + 1;
        memmove(to, c + folders, n - folders);
        to += n - folders;
        c += n;
    }
    if (kept_now != ISO_PROVENANCE_PATHS)
        *to = 0;
    return text;
}
