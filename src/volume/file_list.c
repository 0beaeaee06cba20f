/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/file_list.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/json.h"

enum { MOST_BYTES = 64 << 20 };

bool iso_file_list_is_one(const char *path)
{
    return (iso_path_ends_with(path, ".pvd") || iso_path_ends_with(path, ".series")) && iso_path_exists(path) &&
           !iso_path_is_dir(path);
}

void iso_file_list_destroy(iso_file_list *list)
{
    for (size_t i = 0; i < list->count; ++i)
        free(list->file[i].path);
    free(list->file);
    *list = (iso_file_list){0};
}

static iso_status add(iso_file_list *list, const char *list_path, const char *name, double time, iso_error *err)
{
    if (!*name || !isfinite(time))
        return iso_fail(err, ISO_E_FORMAT, "%s: entry %zu has no %s", list_path, list->count + 1,
                        *name ? "finite time" : "file");
    if (list->count == list->room) {
        list->room = list->room ? 2 * list->room : 64;
        iso_listed_file *more = realloc(list->file, list->room * sizeof *more);
        if (!more)
            return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", list_path);
        list->file = more;
    }
    FREED char *folder = iso_path_dir(list_path);
    char *path = *name == '/' || (folder && strcmp(folder, ".") == 0) ? strdup(name)
                 : folder                                             ? iso_path_join(folder, name)
                                                                      : NULL;
    if (!path)
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", list_path);
    list->file[list->count++] = (iso_listed_file){time, path};
    return ISO_OK;
}

/* ---- .pvd: <DataSet timestep="0.5" group="" part="0" file="a.vti"/> ---- */

static void unescape(char *text)
{
    static const struct {
        const char *entity;
        char meant;
    } all[] = {{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
    char *to = text;
    for (const char *from = text; *from; ++to) {
        size_t skip = 1;
        char c = *from;
        for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
            if (strncmp(from, all[i].entity, strlen(all[i].entity)) == 0) {
                skip = strlen(all[i].entity);
                c = all[i].meant;
            }
        *to = c;
        from += skip;
    }
    *to = 0;
}

/* Returns the text of an attribute within [tag, end), to be freed; NULL if it has none. */
static char *attribute(const char *tag, const char *end, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = tag; (at = memmem(at, (size_t)(end - at), name, length)); at += length) {
        const char *value = at + length + 1;
        const char quote[2] = {at[length] == '=' ? at[length + 1] : 0, 0};
        if (!isspace((unsigned char)at[-1]) || (*quote != '"' && *quote != '\''))
            continue;
        char *text = strndup(value + 1, strcspn(value + 1, quote));
        if (text)
            unescape(text);
        return text;
    }
    return NULL;
}

static iso_status read_pvd(const char *path, const char *text, iso_file_list *list, iso_error *err)
{
    if (!strstr(text, "<VTKFile") || !strstr(text, "<Collection") || !strstr(text, "</Collection>"))
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated, or no collection of ParaView's (.pvd)", path);
    for (const char *at = text; (at = strstr(at, "<DataSet")); ++at) {
        const char *end = strpbrk(at + 1, "<>"); /* no tag continues after the beginning of another */
        const bool is_tag = end && *end == '>';
        FREED char *name = is_tag ? attribute(at, end, "file") : NULL,
                   *time = is_tag ? attribute(at, end, "timestep") : NULL;
        char *rest = NULL;
        const double value = time ? strtod(time, &rest) : (double)list->count;
        NEED(add(list, path, name ? name : "", time && rest == time ? NAN : value, err));
    }
    return ISO_OK;
}

/* ---- .series: {"file-series-version": "1.0", "files": [{"name": "a.vti", "time": 0.5}]} ---- */

static iso_status read_series(const char *path, const char *text, size_t size, iso_file_list *list, iso_error *err)
{
    json_auto_t *root = NULL;
    iso_status status = iso_json_parse(path, text, size, &root, err);
    if (status != ISO_OK)
        return status;
    iso_json_reader r = {path, ISO_OK, err};
    const json_t *files = iso_json_get_array(&r, root, "files", true);
    for (size_t i = 0; r.status == ISO_OK && i < json_array_size(files); ++i) {
        const json_t *entry = json_array_get(files, i);
        const char *name = "";
        double time = (double)i;
        iso_json_get_string(&r, entry, "name", true, &name);
        iso_json_get_number(&r, entry, "time", false, -1e300, 1e300, &time);
        TRY(r.status, add(list, path, name, time, err));
    }
    return r.status;
}

/* ---- both ---- */

static int by_time(const void *a, const void *b)
{
    const iso_listed_file *x = a, *y = b;
    return (x->time > y->time) - (x->time < y->time);
}

static iso_status put_in_order(const char *path, iso_file_list *list, iso_error *err)
{
    if (list->count == 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: lists no files", path);
    qsort(list->file, list->count, sizeof *list->file, by_time);
    const double step = list->count > 1
                            ? (list->file[list->count - 1].time - list->file[0].time) / (double)(list->count - 1)
                            : 0;
    list->step = step;
    for (size_t i = 1; i < list->count; ++i) {
        const double own = list->file[i].time - list->file[i - 1].time;
        if (own == 0)
            return iso_fail(err, ISO_E_FORMAT, "%s: two files of the time %g, %s and %s: parts are not joined", path,
                            list->file[i].time, list->file[i - 1].path, list->file[i].path);
        if (fabs(own - step) > 0.01 * step)
            list->step = 0;
    }
    return ISO_OK;
}

iso_status iso_file_list_read(const char *path, iso_file_list *list, iso_error *err)
{
    FREED char *text = NULL;
    size_t size = 0;
    *list = (iso_file_list){0};
    NEED(iso_inputs_note(path, err));
    NEED(iso_file_read(path, &text, &size, err));
    if (size > MOST_BYTES)
        return iso_fail(err, ISO_E_FORMAT, "%s: %zu bytes, too many for a list of files", path, size);
    NEED(iso_path_ends_with(path, ".pvd") ? read_pvd(path, text, list, err) : read_series(path, text, size, list, err));
    return put_in_order(path, list, err);
}
