/* SPDX-License-Identifier: MIT */
/* numbered_files.c - frames in files of their own, whose names have a number or are listed. */
#define _GNU_SOURCE
#include <ctype.h>
#include <dirent.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/json.h"
#include "base/status.h"
#include "volume/frames.h"

/* ---- lists of files ---- */

/* Files that make a series: listed by ParaView's .pvd or VTK's .series, or with numbers in their names. */
typedef struct listed_file {
    double time; /* or the number */
    char *path;  /* in the list's folder, if its name is relative */
} listed_file;

typedef struct file_list {
    listed_file *file; /* by time, then by path */
    size_t count, room;
    double step; /* of time, if it is even within 1 %; 0 otherwise */
} file_list;

enum { MOST_BYTES = 64 << 20 };

/* True if the path's name is that of a list. */
static bool file_list_is_one(const char *path)
{
    return (iso_path_ends_with(path, ".pvd") || iso_path_ends_with(path, ".series")) && iso_path_exists(path) &&
           !iso_path_is_dir(path);
}

static void file_list_destroy(file_list *list)
{
    for (size_t i = 0; i < list->count; ++i)
        free(list->file[i].path);
    free(list->file);
    *list = (file_list){0};
}

/* Appends a file and takes its path. False without memory, also for the path. */
static bool append(file_list *list, double time, char *path)
{
    if (path && list->count == list->room) {
        const size_t room = list->room ? 2 * list->room : 64;
        listed_file *more = realloc(list->file, room * sizeof *more);
        if (!more) {
            free(path);
            return false;
        }
        list->file = more;
        list->room = room;
    }
    if (path)
        list->file[list->count++] = (listed_file){time, path};
    return path;
}

static int by_time(const void *a, const void *b)
{
    const listed_file *x = a, *y = b;
    return x->time != y->time ? (x->time > y->time) - (x->time < y->time) : strcmp(x->path, y->path);
}

static iso_status add(file_list *list, const char *list_path, const char *name, double time, iso_error *err)
{
    if (!*name || !isfinite(time))
        return iso_fail(err, ISO_E_FORMAT, "%s: entry %zu has no %s", list_path, list->count + 1,
                        *name ? "finite time" : "file");
    FREED char *folder = iso_path_dir(list_path);
    char *path = *name == '/' || (folder && strcmp(folder, ".") == 0) ? strdup(name)
                 : folder                                             ? iso_path_join(folder, name)
                                                                      : NULL;
    NEED_MEMORY(append(list, time, path), err, "%s: out of memory", list_path);
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

static iso_status read_pvd(const char *path, const char *text, file_list *list, iso_error *err)
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

static iso_status read_series(const char *path, const char *text, size_t size, file_list *list, iso_error *err)
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

static iso_status put_in_order(const char *path, file_list *list, iso_error *err)
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

/* Reads a list. ISO_E_FORMAT: the list is damaged or empty, or has several parts of a
 * time step; ISO_E_IO; ISO_E_MEMORY. */
static iso_status file_list_read(const char *path, file_list *list, iso_error *err)
{
    FREED char *text = NULL;
    size_t size = 0;
    NEED(iso_inputs_note(path, err));
    NEED(iso_file_read(path, &text, &size, err));
    if (size > MOST_BYTES)
        return iso_fail(err, ISO_E_FORMAT, "%s: %zu bytes, too many for a list of files", path, size);
    NEED(iso_path_ends_with(path, ".pvd") ? read_pvd(path, text, list, err) : read_series(path, text, size, list, err));
    return put_in_order(path, list, err);
}

/* ---- the frames ---- */

/* Finds the place of a number such as %d or %04d in a file's name; NULL if there is none. */
static const char *find_place(const char *name, size_t *bytes)
{
    for (const char *at = strchr(name, '%'); at; at = strchr(at + 1, '%')) {
        *bytes = 1 + strspn(at + 1, "0123456789");
        if (at[(*bytes)++] == 'd')
            return at;
    }
    return NULL;
}

/* True if `name` is `before` bytes of the pattern, digits and `after`; *number is then the digits' value. */
static bool has_number(const char *name, const char *pattern, size_t before, const char *after, double *number)
{
    const size_t length = strlen(name), end = strlen(after);
    if (length <= before + end || strncmp(name, pattern, before) != 0 || strcmp(name + length - end, after) != 0)
        return false;
    const size_t digits = strspn(name + before, "0123456789");
    *number = (double)strtoull(name + before, NULL, 10); /* names decide between numbers above 2^53 */
    return digits == length - before - end;
}

static bool find_files(const char *path, const char *base, file_list *files)
{
    size_t bytes = 0;
    double number;
    const char *at = find_place(base, &bytes);
    FREED char *folder = iso_path_dir(path);
    DIR *dir = folder ? opendir(folder) : NULL;
    bool well = folder != NULL;
    for (const struct dirent *entry; dir && well && (entry = readdir(dir));)
        if (has_number(entry->d_name, base, (size_t)(at - base), at + bytes, &number))
            well = append(files, number,
                          strcmp(folder, ".") == 0 ? strdup(entry->d_name) : iso_path_join(folder, entry->d_name));
    if (dir)
        closedir(dir);
    if (files->count > 1)
        qsort(files->file, files->count, sizeof *files->file, by_time);
    return well;
}

static iso_status choose_file(const char *path, const iso_volume_hints *hints, const file_list *files,
                              iso_frame_file *found, iso_error *err)
{
    const iso_volume_hints none = {0};
    const iso_extra_axes axes = {.frame = {.count = files->count}, .frame_step = files->step};
    found->count = files->count;
    found->step = files->step;
    NEED(iso_frames_choose(path, hints ? hints : &none, &axes, &found->frame, err));
    for (size_t i = 0; i < files->count; ++i) /* all: an output of one must not replace another */
        NEED(iso_inputs_note(files->file[i].path, err));
    found->path = strdup(files->file[found->frame].path);
    NEED_MEMORY(found->path, err, "%s: out of memory", path);
    return ISO_OK;
}

iso_status iso_frames_of_files(const char *path, const iso_volume_hints *hints, iso_frame_file *found, iso_error *err)
{
    struct stat st;
    size_t bytes;
    const char *base = iso_path_base(path);
    OWNED(file_list) files = {0};
    *found = (iso_frame_file){0};
    if (file_list_is_one(path)) {
        NEED(file_list_read(path, &files, err));
        return choose_file(path, hints, &files, found, err);
    }
    if (!find_place(base, &bytes) || stat(path, &st) == 0)
        return ISO_OK;
    NEED_MEMORY(find_files(path, base, &files), err, "%s: out of memory", path);
    if (files.count == 0)
        return iso_fail(err, ISO_E_IO, "%s: no file has a number in this place", path);
    return choose_file(path, hints, &files, found, err);
}
