/* SPDX-License-Identifier: MIT */
#include "renderers/picture_file.h"

#include <math.h>

#include <string.h>

/* Passes an error on. If the error names the picture, blames the program, and shows `file` instead of its path. */
static iso_status refuse(iso_status status, const iso_error *why, const char *path, const char *file, iso_error *err)
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
    iso_error why = {""};
    const iso_status status = iso_image_read_exr_header(path, &header, &why);
    if (status != ISO_OK)
        return refuse(status, &why, path, file, err);
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

iso_status iso_picture_load(const char *path, const char *name, const iso_view *view, iso_image *image, iso_error *err)
{
    iso_error why = {""};
    iso_status status = check_header(path, name, view, err);
    if (status == ISO_OK && (status = iso_image_load_exr(path, image, &why)) != ISO_OK)
        return refuse(status, &why, path, name, err);
    if (status == ISO_OK && (status = check_values(image, name, err)) != ISO_OK)
        iso_image_destroy(image);
    return status;
}
