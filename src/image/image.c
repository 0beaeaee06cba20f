/* SPDX-License-Identifier: MIT */
#include "image/image.h"

#include <ctype.h>
#include <math.h>
#include <png.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "image/picture_bytes.h"

iso_status iso_image_create(iso_image *image, size_t width, size_t height, iso_error *err)
{
    *image = (iso_image){0};
    if (width == 0 || height == 0 || width > SIZE_MAX / 16 / height)
        return iso_fail(err, ISO_E_RANGE, "image size %zu x %zu is empty or cannot be addressed", width, height);
    image->rgba = calloc(width * height * 4, sizeof *image->rgba);
    NEED_MEMORY(image->rgba, err, "no memory for an image of %zu x %zu", width, height);
    image->width = width;
    image->height = height;
    return ISO_OK;
}

void iso_image_destroy(iso_image *image)
{
    if (!image)
        return;
    free(image->rgba);
    *image = (iso_image){0};
}

void iso_image_add_background(iso_image *image, const double background[3])
{
    for (size_t i = 0; i < image->width * image->height; ++i) {
        float *p = image->rgba + 4 * i;
        for (int c = 0; c < 3; ++c)
            p[c] += (float)((1 - (double)p[3]) * background[c]);
    }
}

/* Converts a linear value to an sRGB byte (IEC 61966-2-1); the caller turns NaN into magenta. */
static uint8_t srgb_byte(double linear)
{
    double c = fmin(fmax(linear, 0), 1);
    c = c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
    return (uint8_t)(c * 255 + 0.5);
}

static uint8_t *srgb_pixels(const iso_image *image, double exposure)
{
    static const uint8_t nonfinite[3] = {255, 0, 255}; /* shouts */
    size_t count = image->width * image->height;
    uint8_t *rgb = malloc(3 * count);
    for (size_t i = 0; rgb && i < count; ++i) {
        const float *p = image->rgba + 4 * i;
        bool finite = isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = finite ? srgb_byte(exposure * (double)p[c]) : nonfinite[c];
    }
    return rgb;
}

static iso_status check_exposure(double exposure, iso_error *err)
{
    return exposure >= 0 && isfinite(exposure)
               ? ISO_OK
               : iso_fail(err, ISO_E_RANGE, "exposure is %g, must be 0 or above", exposure);
}

iso_status iso_image_save_png(const iso_image *image, const char *path, double exposure, iso_error *err)
{
    NEED(check_exposure(exposure, err));
    FREED uint8_t *rgb = srgb_pixels(image, exposure);
    NEED_MEMORY(rgb, err, "%s: no memory for %zu x %zu pixels", path, image->width, image->height);
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    NEED(iso_output_begin(&out, path, err));
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)image->width,
                     .height = (png_uint_32)image->height,
                     .format = PNG_FORMAT_RGB};
    if (!png_image_write_to_file(&png, out.temp_path, 0, rgb, 0, NULL))
        return iso_fail(err, ISO_E_IO, "%s: cannot be written: %s", path, png.message);
    return iso_output_commit(&out, err);
}

iso_status iso_image_png(const iso_image *image, double exposure, unsigned char **bytes, size_t *size, iso_error *err)
{
    *bytes = NULL;
    *size = 0;
    NEED(check_exposure(exposure, err));
    uint8_t *rgb = image->rgba ? srgb_pixels(image, exposure) : NULL;
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)image->width,
                     .height = (png_uint_32)image->height,
                     .format = PNG_FORMAT_RGB};
    png_alloc_size_t most = rgb ? PNG_IMAGE_PNG_SIZE_MAX(png) : 0, used = most;
    unsigned char *data = rgb ? malloc(most) : NULL;
    iso_status status = !image->rgba ? iso_fail(err, ISO_E_RANGE, "PNG: the image is empty")
                        : !data      ? iso_fail(err, ISO_E_MEMORY, "PNG: out of memory")
                                     : ISO_OK;
    if (status == ISO_OK && !png_image_write_to_memory(&png, data, &used, 0, rgb, 0, NULL))
        status = iso_fail(err, ISO_E_PROGRAM, "PNG: %s", png.message);
    free(rgb);
    if (status != ISO_OK) {
        free(data);
        return status;
    }
    *bytes = data;
    *size = used;
    return ISO_OK;
}

static bool has_ending(const char *path, const char *ending)
{
    const size_t length = strlen(path), bytes = strlen(ending);
    return length >= bytes && strcasecmp(path + length - bytes, ending) == 0;
}

iso_status iso_image_check_name(const char *option, const char *path, iso_error *err)
{
    return has_ending(path, ".exr") || has_ending(path, ".png")
               ? ISO_OK
               : iso_fail(err, ISO_E_USAGE, "%s is \"%s\", must end with .exr or .png", option, path);
}

iso_status iso_image_save(const iso_image *image, const char *path, const iso_image_note *notes, iso_error *err)
{
    return has_ending(path, ".png") ? iso_image_save_png(image, path, 1, err)
                                    : iso_image_save_exr(image, path, notes, err);
}

/* Reads the next number of a PPM header; a comment runs from # to the end of the line. */
static bool ppm_number(const char **at, const char *end, size_t *number)
{
    while (*at < end && (isspace((unsigned char)**at) || **at == '#')) {
        if (**at == '#')
            while (*at < end && **at != '\n')
                ++*at;
        else
            ++*at;
    }
    if (*at >= end || !isdigit((unsigned char)**at))
        return false;
    for (*number = 0; *at < end && isdigit((unsigned char)**at); ++*at)
        *number = *number > 1000000 ? *number : *number * 10 + (size_t)(**at - '0');
    return true;
}

iso_status iso_ppm_decode(const char *path, const char *data, size_t size, iso_image *image, iso_error *err)
{
    const char *at = data + 2, *end = data + size;
    size_t width, height, maximum;
    if (size < 2 || memcmp(data, "P6", 2) != 0 || !ppm_number(&at, end, &width) || !ppm_number(&at, end, &height) ||
        !ppm_number(&at, end, &maximum) || at >= end)
        return iso_fail(err, ISO_E_FORMAT, "%s: not a binary PPM (P6)", path);
    ++at; /* one white space ends the header */
    if (maximum != 65535)
        return iso_fail(err, ISO_E_FORMAT, "%s: largest value is %zu, must be 65535 (16 bits)", path, maximum);
    if (width == 0 || height == 0 || width > 1000000 || height > 1000000 || (size_t)(end - at) < width * height * 6)
        return iso_fail(err, ISO_E_FORMAT, "%s: holds %zu bytes of pixels, %zu x %zu need %zu", path,
                        (size_t)(end - at), width, height, width * height * 6);
    NEED(iso_image_create(image, width, height, err));
    const uint8_t *sample = (const uint8_t *)at;
    for (size_t i = 0; i < width * height; ++i) {
        for (size_t c = 0; c < 3; ++c, sample += 2)
            image->rgba[4 * i + c] = (float)((sample[0] << 8 | sample[1]) / 65535.0);
        image->rgba[4 * i + 3] = 1;
    }
    return ISO_OK;
}

iso_status iso_image_load_ppm(const char *path, iso_image *image, iso_error *err)
{
    char *data;
    size_t size;
    *image = (iso_image){0};
    NEED(iso_picture_read_kind(path, ISO_PICTURE_PPM, "PPM of 16 bits", &data, &size, err));
    iso_status status = iso_ppm_decode(path, data, size, image, err);
    free(data);
    return status;
}

double iso_image_shown_share(const iso_image *image)
{
    const size_t count = image->width * image->height;
    size_t shown = 0;
    for (size_t i = 0; i < count; ++i)
        shown += (double)image->rgba[4 * i + 3] >= 1.0 / 255;
    return count ? (double)shown / (double)count : 0;
}

bool iso_image_clip(iso_image *image, float most)
{
    bool some = false;
    for (size_t i = 0; i < 4 * image->width * image->height; ++i)
        if (image->rgba[i] > most) {
            image->rgba[i] = most;
            some = true;
        }
    return some;
}

bool iso_image_is_finite(const iso_image *image)
{
    for (size_t i = 0; i < 4 * image->width * image->height; ++i)
        if (!isfinite(image->rgba[i]))
            return false;
    return true;
}
