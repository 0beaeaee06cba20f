/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* memmem */
#include "tf/format.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/words.h"

#define ISO_TF_FORMAT_DECLARE(name) extern const iso_tf_format iso_tf_format_##name;
ISO_TF_FORMAT_LIST(ISO_TF_FORMAT_DECLARE)
#undef ISO_TF_FORMAT_DECLARE

#define ISO_TF_FORMAT_POINTER(name) &iso_tf_format_##name,
static const iso_tf_format *const formats[] = {ISO_TF_FORMAT_LIST(ISO_TF_FORMAT_POINTER)};
#undef ISO_TF_FORMAT_POINTER
enum { FORMAT_COUNT = sizeof formats / sizeof *formats };

const iso_names iso_tf_format_names = ISO_NAMES_OF_POINTERS("transfer-function format", formats);

const iso_tf_format *iso_tf_format_at(size_t row)
{
    return row < FORMAT_COUNT ? formats[row] : NULL;
}

const iso_tf_format *iso_tf_format_of(const char *path)
{
    const iso_tf_format *found = NULL;
    for (size_t i = 0; i < FORMAT_COUNT; ++i)
        if (iso_path_ends_with(path, formats[i]->suffix) &&
            (!found || strlen(formats[i]->suffix) > strlen(found->suffix)))
            found = formats[i];
    return found;
}

char *iso_tf_format_written(char *text, size_t size)
{
    size_t length = 0, left = 0;
    for (size_t i = 0; i < FORMAT_COUNT; ++i)
        left += formats[i]->save != NULL;
    text[0] = '\0';
    for (size_t i = 0; i < FORMAT_COUNT && length < size; ++i)
        if (formats[i]->save) {
            --left;
            length += (size_t)snprintf(text + length, size - length, "%s%s", formats[i]->suffix,
                                       left > 1    ? ", "
                                       : left == 1 ? " or "
                                                   : "");
        }
    return text;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static bool is_named(const iso_tf_format *format, const char *path)
{
    return format->load &&
           (iso_path_ends_with(path, format->suffix) || (format->also && iso_path_ends_with(path, format->also)));
}

static bool looks_like(const iso_tf_format *format, const iso_tf_file *file)
{
    size_t marks = 0, found = 0;
    for (; marks < ISO_TF_MARKS && format->marks[marks]; ++marks)
        found += memmem(file->text, file->size, format->marks[marks], strlen(format->marks[marks])) != NULL;
    return format->load && found >= (format->has_all_marks ? marks : 1) && found > 0;
}

/* Returns the format that matches both name and content. NULL: the content is of *other, which the name does not allow.
 * If no format matches, returns ours: its reader reports the error. */
static const iso_tf_format *find_format(const iso_tf_file *file, const iso_tf_format **other)
{
    const iso_tf_format *named = iso_tf_format_of(file->path);
    *other = NULL;
    named = named && named->load ? named : NULL;
    for (size_t i = 0; i < FORMAT_COUNT; ++i) {
        if (!looks_like(formats[i], file))
            named = named || !is_named(formats[i], file->path) ? named : formats[i];
        else if (is_named(formats[i], file->path))
            return formats[i];
        else
            *other = formats[i];
    }
    if (*other)
        return named ? NULL : *other;
    return named ? named : &iso_tf_format_json;
}

/* Replaces the file's range by the requested one. */
static iso_status set_range(const iso_tf_request *q, iso_tf *tf, const char *path, iso_error *err)
{
    if (!q->has_range)
        return ISO_OK;
    const double lo = tf->fit_range ? 0 : tf->range[0], hi = tf->fit_range ? 1 : tf->range[1];
    const double to[2] = {q->fit ? 0 : q->range[0], q->fit ? 1 : q->range[1]};
    if (!(to[1] > to[0]))
        return iso_fail(err, ISO_E_USAGE, "%s: range [%g, %g]: the end must exceed the start", path, to[0], to[1]);
    for (size_t i = 0; i < tf->point_count; ++i)
        tf->points[i].value = to[0] + (tf->points[i].value - lo) / (hi - lo) * (to[1] - to[0]);
    tf->range[0] = to[0], tf->range[1] = to[1];
    tf->fit_range = q->fit;
    return ISO_OK;
}

/* Enough for the most points of a table at a hundred words each; larger files would be parsed for seconds, in vain. */
#define MOST_BYTES ((size_t)32 << 20)

iso_status iso_tf_load_as(const char *path, const iso_tf_request *request, iso_tf *tf, iso_error *err)
{
    FREED char *text = NULL;
    iso_tf_file file = {.path = path, .request = request};
    const iso_tf_format *other;
    *tf = (iso_tf){0};
    NEED(iso_inputs_note(path, err));
    NEED(iso_file_read(path, &text, &file.size, err));
    if (file.size > MOST_BYTES)
        return iso_fail(err, ISO_E_FORMAT, "%s: has %zu bytes, a transfer function has at most %zu", path, file.size,
                        MOST_BYTES);
    file.text = text;
    const iso_tf_format *format = find_format(&file, &other);
    iso_status status = format ? format->load(&file, tf, err)
                               : iso_fail(err, ISO_E_FORMAT, "%s: its content is %s; give it a name that ends with %s",
                                          path, other->summary, other->also ? other->also : other->suffix);
    if (status == ISO_OK && (status = set_range(request, tf, path, err)) != ISO_OK)
        iso_tf_destroy(tf);
    if (status == ISO_OK) {
        const size_t length = strlen(path), most = sizeof tf->of - 1; /* of a long path the end is kept */
        snprintf(tf->of, sizeof tf->of, "%s", path + (length > most ? length - most : 0));
    }
    return status;
}

iso_status iso_tf_load(const char *path, iso_tf *tf, iso_error *err)
{
    return iso_tf_load_as(path, &(iso_tf_request){0}, tf, err);
}

/* ---- shared by loaders ------------------------------------------------------------------------------------------- */

/* Writes "a, b and 3 more" into text. */
static void list_names(const char *const *names, size_t count, char *text, size_t size)
{
    size_t length = 0, listed = 0;
    for (; listed < count && length + strlen(names[listed]) + 32 < size; ++listed)
        length += (size_t)snprintf(text + length, size - length, "%s\"%s\"", listed ? ", " : "", names[listed]);
    if (listed < count)
        snprintf(text + length, size - length, " and %zu more", count - listed);
}

/* Sets *text to all names, one per line, and returns ISO_E_USAGE, since a request for names loads nothing. */
static iso_status give_names(const char *const *names, size_t count, char **text, iso_error *err)
{
    size_t size = 0;
    FILE *memory = open_memstream(text, &size);
    for (size_t i = 0; i < count && memory; ++i) {
        iso_words_put_line(memory, names[i]);
        fputc('\n', memory);
    }
    NEED_MEMORY(memory && fclose(memory) == 0, err, "out of memory");
    return iso_fail(err, ISO_E_USAGE, "names listed, nothing loaded");
}

iso_status iso_tf_choose(const iso_tf_file *file, const char *what, const char *const *names, size_t count,
                         size_t *chosen, iso_error *err)
{
    const char *wanted = file->request->name;
    char list[640] = "";
    *chosen = 0;
    if (file->request->names)
        return give_names(names, count, file->request->names, err);
    if (count == 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: has no %s", file->path, what);
    if (!wanted && count == 1)
        return ISO_OK;
    for (size_t i = 0; i < count && wanted; ++i)
        if (strcmp(names[i], wanted) == 0) {
            *chosen = i;
            return ISO_OK;
        }
    list_names(names, count, list, sizeof list);
    return wanted ? iso_fail(err, ISO_E_USAGE, "%s: has no %s \"%s\"; choose one by --name: %s", file->path, what,
                             wanted, list)
                  : iso_fail(err, ISO_E_USAGE, "%s: has %zu of them; choose a %s by --name: %s", file->path, count,
                             what, list);
}

static iso_status set_unit(const iso_tf_file *file, iso_tf_curves *c, iso_error *err)
{
    const double asked = file->request->unit_mm;
    if (c->unit_mm > 0 && asked > 0 && !c->unit_is_default)
        return iso_fail(err, ISO_E_USAGE,
                        "%s: states that its opacities are for %g mm; --unit-distance cannot change that", file->path,
                        c->unit_mm);
    if (!(c->unit_mm > 0) && !(asked > 0))
        return iso_fail(err, ISO_E_USAGE,
                        "%s: does not state the length of its opacities%s%s; give it by tf convert --unit-distance MM",
                        file->path, c->unit_is ? ", " : "", c->unit_is ? c->unit_is : "");
    if (asked > 0)
        c->unit_mm = asked, c->unit_is_voxel = false;
    if (!(c->unit_mm >= ISO_TF_LEAST_UNIT && c->unit_mm <= ISO_TF_MOST_UNIT))
        return iso_fail(err, ISO_E_RANGE, "%s: opacities are for %g mm, must be %g to %g", file->path, c->unit_mm,
                        ISO_TF_LEAST_UNIT, ISO_TF_MOST_UNIT);
    return ISO_OK;
}

static iso_status set_opacity(const iso_tf_file *file, iso_tf_curves *c, iso_error *err)
{
    const iso_tf_request *q = file->request;
    if (c->opacity.count && q->has_opacity)
        return iso_fail(err, ISO_E_USAGE, "%s: has opacities of its own; --opacity is for files without", file->path);
    if (c->opacity.count)
        return ISO_OK;
    if (!q->has_opacity)
        return iso_fail(err, ISO_E_USAGE, "%s: has no opacities; give them by tf convert --opacity A[,B]", file->path);
    NEED(iso_tf_curve_add_opacity(&c->opacity, c->color.nodes[0].x, q->opacity[0], file->path, err));
    return iso_tf_curve_add_opacity(&c->opacity, c->color.nodes[c->color.count - 1].x, q->opacity[1], file->path, err);
}

iso_status iso_tf_take_curves(const iso_tf_file *file, iso_tf_curves *curves, iso_tf *tf, iso_error *err)
{
    if (curves->color.count == 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: has no points of color", file->path);
    iso_tf_curve_sort(&curves->color);
    iso_tf_curve_sort(&curves->opacity);
    NEED(set_opacity(file, curves, err));
    NEED(set_unit(file, curves, err));
    NEED(iso_tf_resample(curves, file->path, tf, err));
    const iso_status status = file->request->measure ? iso_tf_measure_loss(curves, tf, err) : ISO_OK;
    if (status != ISO_OK)
        iso_tf_destroy(tf);
    return status;
}
