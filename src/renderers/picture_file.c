/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "renderers/picture_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "renderers/picture_plain.h"

iso_status iso_picture_find(const char *exr, const char *shown, char **path, iso_error *err)
{
    static const char *const endings[] = {".exr", ".npy", ".pfm"};
    const int stem = (int)strlen(exr) - 4;
    const char *found = NULL;
    for (size_t i = 0; i < sizeof endings / sizeof *endings; ++i) {
        if (asprintf(path, "%.*s%s", stem, exr, endings[i]) < 0)
            return iso_fail(err, ISO_E_MEMORY, "out of memory");
        const bool is_there = iso_path_exists(*path);
        free(*path);
        *path = NULL;
        if (is_there && found)
            return iso_fail(err, ISO_E_PROGRAM, "%.*s is there as %s and as %s; leave one", (int)strlen(shown) - 4,
                            shown, found, endings[i]);
        found = is_there ? endings[i] : found;
    }
    return asprintf(path, "%.*s%s", stem, exr, found ? found : ".exr") < 0
               ? iso_fail(err, ISO_E_MEMORY, "out of memory")
               : ISO_OK;
}

/* Passes an error on. If it begins with the path, the program is to blame, and it shows `file` instead. */
static iso_status blame(iso_status status, const iso_error *why, const char *path, const char *file, iso_error *err)
{
    const size_t length = strlen(path);
    if (status == ISO_E_MEMORY || status == ISO_E_IO || strncmp(why->text, path, length) != 0)
        return iso_fail(err, status, "%s", why->text);
    return iso_fail(err, ISO_E_PROGRAM, "%s%s", file, why->text + length);
}

static iso_status check_header(const char *path, const char *file, const iso_view *view, iso_error *err)
{
    static const char *const names[] = {"R", "G", "B", "A"};
    iso_exr_header header;
    NEED(iso_image_read_exr_header(path, &header, err));
    if (header.width != view->width || header.height != view->height || header.is_cropped)
        return iso_fail(err, ISO_E_PROGRAM, "%s has %zu x %zu pixels%s, needs %zu x %zu", file, header.width,
                        header.height, header.is_cropped ? " of a cropped window" : "", view->width, view->height);
    for (unsigned c = 0; c < 4; ++c)
        if (!(header.channels >> c & 1))
            return iso_fail(err, ISO_E_PROGRAM, "%s has no full-resolution channel %s", file, names[c]);
    return ISO_OK;
}

static iso_status check_values(const iso_image *image, const char *file, iso_error *err)
{
    size_t bad = 0, first = 0;
    for (size_t i = 4 * image->width * image->height; i-- > 0;)
        if (!isfinite(image->rgba[i])) {
            ++bad;
            first = i / 4;
        }
    return bad ? iso_fail(err, ISO_E_PROGRAM,
                          "%s has %zu values that are not finite, the first in column %zu of row %zu", file, bad,
                          first % image->width, first / image->width)
               : ISO_OK;
}

static iso_status load_exr(const char *path, const char *name, const iso_view *view, iso_image *image, iso_error *err)
{
    iso_status status = check_header(path, name, view, err);
    return status == ISO_OK ? iso_image_load_exr(path, image, err) : status;
}

iso_status iso_picture_load(const char *path, const char *name, const iso_view *view, iso_image *image, iso_error *err)
{
    iso_error why = {""};
    iso_status status = iso_path_ends_with(path, ".npy")   ? iso_picture_load_npy(path, name, view, image, &why)
                        : iso_path_ends_with(path, ".pfm") ? iso_picture_load_pfm(path, name, view, image, &why)
                                                           : load_exr(path, name, view, image, &why);
    if (status != ISO_OK)
        return blame(status, &why, path, name, err);
    if ((status = check_values(image, name, err)) != ISO_OK)
        iso_image_destroy(image);
    return status;
}
