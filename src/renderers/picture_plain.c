/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "renderers/picture_plain.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/path.h"
#include "volume/half.h"
#include "volume/npy.h"

char *iso_picture_alpha(const char *path)
{
    char *alpha = NULL;
    if (!iso_path_ends_with(path, ".pfm") || asprintf(&alpha, "%.*s-alpha.pfm", (int)strlen(path) - 4, path) < 0)
        return NULL;
    return alpha;
}

/* Reads a file of at most `most` bytes, since an untrusted one may be endless. */
static iso_status read_file(const char *path, const char *name, size_t most, char **bytes, size_t *size, iso_error *err)
{
    struct stat s;
    if (stat(path, &s) == 0 && (size_t)s.st_size > most)
        return iso_fail(err, ISO_E_PROGRAM, "%s is damaged: %zu bytes, at most %zu belong to such a picture", name,
                        (size_t)s.st_size, most);
    return iso_file_read(path, bytes, size, err);
}

static void swap_bytes(unsigned char *sample, size_t bytes)
{
    for (size_t i = 0; i < bytes / 2; ++i) {
        const unsigned char byte = sample[i];
        sample[i] = sample[bytes - 1 - i];
        sample[bytes - 1 - i] = byte;
    }
}

/* Converts a float of 2, 4 or 8 bytes. */
static float take_sample(const char *from, size_t bytes, bool swapped)
{
    unsigned char sample[8];
    uint16_t half;
    float single;
    double twofold;
    memcpy(sample, from, bytes);
    if (swapped)
        swap_bytes(sample, bytes);
    memcpy(&half, sample, sizeof half);
    if (bytes == sizeof half)
        return iso_half_to_float(half);
    memcpy(&single, sample, sizeof single);
    if (bytes == sizeof single)
        return single;
    memcpy(&twofold, sample, sizeof twofold);
    return (float)twofold;
}

/* ---- NumPy ---- */

typedef struct layout {
    size_t bytes; /* of a sample */
    bool swapped, is_fortran;
} layout;

static iso_status check_header(const iso_npy *n, const char *name, const iso_view *view, layout *l, iso_error *err)
{
    size_t axes[ISO_NPY_MOST_AXES], count = 0;
    const char *type = iso_npy_value(n, "descr"), *shape = iso_npy_value(n, "shape");
    char order = 0, kind[3] = "";
    if (!iso_npy_shape(n, axes, &count, &l->is_fortran))
        return iso_fail(err, ISO_E_PROGRAM, "%s is damaged: its NumPy header has no order and shape", name);
    if (!iso_npy_type(n, &order, kind) || kind[0] != 'f' || !strchr("248", kind[1]))
        return iso_fail(err, ISO_E_PROGRAM, "%s has samples of type %.*s, needs floats of 16, 32 or 64 bits", name,
                        type ? (int)strcspn(type, ",}\n") : 7, type ? type : "missing");
    if (count != 3 || axes[0] != view->height || axes[1] != view->width || axes[2] != 4)
        return iso_fail(err, ISO_E_PROGRAM, "%s has the shape %.*s, needs (%zu, %zu, 4): rows, columns, RGBA", name,
                        (int)strcspn(shape, ")") + 1, shape, view->height, view->width);
    l->bytes = (size_t)(kind[1] - '0');
    l->swapped = iso_npy_is_swapped(order);
    return ISO_OK;
}

static void take_array(const char *samples, const layout *l, iso_image *image)
{
    const size_t w = image->width, h = image->height;
    for (size_t y = 0; y < h; ++y)
        for (size_t x = 0; x < w; ++x)
            for (size_t c = 0; c < 4; ++c)
                image->rgba[4 * (y * w + x) + c] =
                    take_sample(samples + l->bytes * (l->is_fortran ? y + h * (x + w * c) : 4 * (y * w + x) + c),
                                l->bytes, l->swapped);
}

iso_status iso_picture_load_npy(const char *path, const char *name, const iso_view *view, iso_image *image,
                                iso_error *err)
{
    const size_t count = 4 * view->width * view->height;
    FREED iso_npy *n = calloc(1, sizeof *n);
    layout l = {0};
    FREED char *bytes = NULL;
    size_t size = 0;
    NEED(n ? iso_npy_read_header(path, n, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    NEED(check_header(n, name, view, &l, err));
    NEED(read_file(path, name, n->samples_at + count * l.bytes, &bytes, &size, err));
    if (size < n->samples_at + count * l.bytes)
        return iso_fail(err, ISO_E_PROGRAM, "%s is damaged: %zu bytes of samples, needs %zu", name,
                        size - n->samples_at, count * l.bytes);
    NEED(iso_image_create(image, view->width, view->height, err));
    take_array(bytes + n->samples_at, &l, image);
    return ISO_OK;
}

/* ---- PFM ---- */

enum { MOST_PFM_HEADER = 128 };

/* Reads one file, of 3 channels ("PF") or one ("Pf"), into those channels of the image from `first` on. */
static iso_status take_pfm(const char *path, const char *name, size_t channels, size_t first, iso_image *image,
                           iso_error *err)
{
    const size_t w = image->width, h = image->height, needs = 4 * channels * w * h;
    char *bytes = NULL, head[MOST_PFM_HEADER + 1] = "", kind = 0;
    size_t size = 0, width = 0, height = 0;
    double scale = 0;
    int end = 0;
    iso_status status = read_file(path, name, MOST_PFM_HEADER + needs, &bytes, &size, err);
    if (status != ISO_OK)
        return status;
    memcpy(head, bytes, size < MOST_PFM_HEADER ? size : MOST_PFM_HEADER);
    if (sscanf(head, "P%c %zu %zu %lf%n", &kind, &width, &height, &scale, &end) != 4 || end == 0)
        status = iso_fail(err, ISO_E_PROGRAM, "%s is damaged: it has no PFM header", name);
    else if (kind != (channels == 1 ? 'f' : 'F'))
        status = iso_fail(err, ISO_E_PROGRAM, "%s begins with P%c, needs %s", name,
                          kind > ' ' && kind < 127 ? kind : '?',
                          channels == 1 ? "Pf: one channel" : "PF: three channels");
    else if (width != w || height != h)
        status = iso_fail(err, ISO_E_PROGRAM, "%s has %zu x %zu pixels, needs %zu x %zu", name, width, height, w, h);
    else if (fabs(scale) != 1)
        status = iso_fail(err, ISO_E_PROGRAM, "%s has the scale %g, must be 1 or -1", name, scale);
    else if (size != (size_t)end + 1 + needs)
        status = iso_fail(err, ISO_E_PROGRAM, "%s is damaged: %zu bytes of samples, needs %zu", name,
                          size > (size_t)end ? size - (size_t)end - 1 : 0, needs);
    const bool swapped = (scale < 0) != (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
    for (size_t i = 0; i < channels * w * h && status == ISO_OK; ++i) {
        const size_t pixel = i / channels, row = h - 1 - pixel / w;
        image->rgba[4 * (row * w + pixel % w) + first + i % channels] = take_sample(bytes + end + 1 + 4 * i, 4,
                                                                                    swapped);
    }
    free(bytes);
    return status;
}

iso_status iso_picture_load_pfm(const char *path, const char *name, const iso_view *view, iso_image *image,
                                iso_error *err)
{
    FREED char *alpha = iso_picture_alpha(path), *alpha_name = iso_picture_alpha(name);
    OWNED(iso_image) read = {0};
    NEED(alpha && alpha_name ? iso_image_create(&read, view->width, view->height, err)
                             : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    NEED(take_pfm(path, name, 3, 0, &read, err));
    NEED(take_pfm(alpha, alpha_name, 1, 3, &read, err));
    *image = read;
    read = (iso_image){0};
    return ISO_OK;
}
