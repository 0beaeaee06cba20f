/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "report/sections.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/words.h"

static const struct {
    const char *name;
    unsigned verdicts;
} sections[] = {
#define ISO_SECTION_ROW(name, verdicts) {#name, verdicts},
    ISO_SECTION_LIST(ISO_SECTION_ROW)
#undef ISO_SECTION_ROW
};
enum { COUNT = sizeof sections / sizeof *sections };

static const unsigned bad_verdicts = ISO_IS(DIFFER) | ISO_IS(FAIL) | ISO_IS(REFUSED) | ISO_IS(UNKNOWN);

bool iso_sections_hold(const json_t *report)
{
    size_t i, k;
    json_t *row;
    for (i = 0; i < COUNT; ++i)
        json_array_foreach (json_object_get(report, sections[i].name), k, row)
            if (sections[i].verdicts && bad_verdicts >> iso_row_verdict(row) & 1)
                return false;
    return true;
}

static unsigned verdicts_of(const char *section)
{
    for (size_t i = 0; i < COUNT; ++i)
        if (strcmp(section, sections[i].name) == 0)
            return sections[i].verdicts;
    return 0;
}

/* Writes the verdicts of a section: "agree, differ, not compared". */
static void list_verdicts(unsigned verdicts, char *text, size_t size)
{
    text[0] = '\0';
    for (int v = 0; v < ISO_VERDICT_UNKNOWN; ++v)
        if (verdicts >> v & 1)
            iso_words_append(text, size, "%s%s", text[0] ? ", " : "", iso_verdict_word((iso_verdict)v));
}

static iso_status check_row(const char *path, const char *section, size_t number, const json_t *row, iso_error *err)
{
    const unsigned known = verdicts_of(section);
    char list[160];
    if (!known && !json_object_get(row, "verdict"))
        return ISO_OK;
    if (!known)
        return iso_fail(err, ISO_E_FORMAT, "%s: unknown section \"%.60s\" with verdicts; another version wrote it",
                        path, section);
    if (known >> iso_row_verdict(row) & 1)
        return ISO_OK;
    list_verdicts(known, list, sizeof list);
    return iso_fail(err, ISO_E_FORMAT, "%s: %s, row %zu: unknown verdict \"%.60s\", must be one of: %s", path, section,
                    number + 1, iso_row_text(row, "verdict"), list);
}

iso_status iso_report_check(const json_t *report, const char *path, iso_error *err)
{
    const char *key;
    json_t *rows, *row;
    size_t i;
    const char *schema = iso_row_text(report, "schema");
    if (strcmp(schema, ISO_REPORT_SCHEMA) != 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: its schema is \"%.60s\", must be %s: %s", path, schema,
                        ISO_REPORT_SCHEMA,
                        strncmp(schema, ISO_REPORT_SCHEMA, strlen(ISO_REPORT_SCHEMA) - 1) == 0
                            ? "another version of isoshade wrote it; validate again"
                            : "not a report.json of isoshade validate");
    json_object_foreach ((json_t *)report, key, rows)
        json_array_foreach (rows, i, row) {
            NEED(check_row(path, key, i, row, err));
        }
    const json_t *verdict = json_object_get(report, "verdict");
    if (verdict && !((ISO_IS(AGREE) | ISO_IS(DIFFER)) >> iso_verdict_from(verdict) & 1))
        return iso_fail(err, ISO_E_FORMAT, "%s: unknown verdict \"%.60s\", must be agree or differ", path,
                        iso_row_text(report, "verdict"));
    return ISO_OK;
}

iso_status iso_report_load(const char *path, json_t **report, iso_error *err)
{
    const bool is_dir = iso_path_is_dir(path);
    FREED char *file = is_dir ? iso_path_join(path, "report.json") : strdup(path);
    NEED_MEMORY(file, err, "%s: no memory", path);
    if (is_dir && !iso_path_exists(file))
        return iso_fail(err, ISO_E_IO, "%s: holds no report.json; needs a folder of isoshade validate -o", path);
    NEED(iso_json_load(file, report, err));
    return iso_report_check(*report, file, err);
}

iso_status iso_report_source_open(iso_report_source *source, const char *path, iso_error *err)
{
    *source = (iso_report_source){.path = path, .dir = iso_path_is_dir(path) ? strdup(path) : iso_path_dir(path)};
    return source->dir ? iso_report_load(path, &source->root, err) : iso_fail(err, ISO_E_MEMORY, "%s: no memory", path);
}

void iso_report_source_close(iso_report_source *source)
{
    free(source->dir);
    json_decref(source->root);
}

bool iso_report_source_has_pictures(const iso_report_source *source)
{
    FREED char *images = source->dir ? iso_path_join(source->dir, "images") : NULL;
    return images && iso_path_is_dir(images);
}

char *iso_report_source_picture(const iso_report_source *source, const char *name, const char *suffix)
{
    char *path = NULL;
    return asprintf(&path, "%s/images/%s.%s", source->dir, name, suffix) < 0 ? NULL : path;
}

bool iso_report_is_picture_name(const char *name)
{
    return name[0] && name[0] != '.' && !strchr(name, '/') && !iso_words_has_control(name);
}
