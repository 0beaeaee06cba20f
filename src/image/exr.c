/* SPDX-License-Identifier: MIT */
/* exr.c - OpenEXR files. Each that is written is read again and compared before it gets its name. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "image/exr_codec.h"
#include "image/picture_bytes.h"

static iso_status write_bytes(const char *path, const char *data, size_t size, iso_error *err)
{
    FILE *file = fopen(path, "wb");
    bool good = file && fwrite(data, 1, size, file) == size;
    if (file && fclose(file) != 0)
        good = false;
    return good ? ISO_OK : iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
}

iso_status iso_exr_verify(const char *path, const iso_image *image, iso_error *err)
{
    OWNED(iso_image) read = {0};
    iso_status status = iso_image_load_exr(path, &read, err);
    if (status != ISO_OK)
        return iso_fail_in(err, ISO_E_IO, "the file just written cannot be read");
    if (read.width != image->width || read.height != image->height ||
        memcmp(read.rgba, image->rgba, 4 * sizeof(float) * image->width * image->height) != 0)
        status = iso_fail(err, ISO_E_IO, "%s: the pixels in the file are not those written to it", path);
    return status;
}

iso_status iso_image_save_exr(const iso_image *image, const char *path, const iso_image_note *notes, iso_error *err)
{
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    FREED char *data = NULL;
    size_t size = 0;
    NEED(iso_output_begin(&out, path, err));
    iso_status status = iso_exr_encode(path, image, notes, &data, &size, err);
    TRY(status, write_bytes(out.temp_path, data, size, err));
    TRY(status, iso_exr_verify(out.temp_path, image, err));
    if (status == ISO_OK)
        return iso_output_commit(&out, err);
    iso_output_rename_in(out.temp_path, path, err);
    return status;
}

iso_status iso_image_exr(const iso_image *image, unsigned char **bytes, size_t *size, iso_error *err)
{
    char *data = NULL;
    *bytes = NULL;
    *size = 0;
    NEED(image->rgba ? iso_exr_encode("EXR", image, NULL, &data, size, err)
                     : iso_fail(err, ISO_E_RANGE, "EXR: the image is empty"));
    *bytes = (unsigned char *)data;
    return ISO_OK;
}

iso_status iso_image_read_exr_header(const char *path, iso_exr_header *header, iso_error *err)
{
    FREED char *data = NULL;
    size_t size;
    *header = (iso_exr_header){0};
    NEED(iso_picture_read_kind(path, ISO_PICTURE_EXR, "OpenEXR", &data, &size, err));
    return iso_exr_decode_header(path, data, size, header, err);
}

iso_status iso_image_load_exr(const char *path, iso_image *image, iso_error *err)
{
    FREED char *data = NULL;
    size_t size;
    *image = (iso_image){0};
    NEED(iso_picture_read_kind(path, ISO_PICTURE_EXR, "OpenEXR", &data, &size, err));
    return iso_exr_decode(path, data, size, NULL, image, err);
}
