/* SPDX-License-Identifier: MIT */
#include "image/png16.h"

#include <png.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* The header chunk stands first: 8 bytes of signature, length, "IHDR", width, height, then the bits. */
bool iso_png_has_16_bits(const char *data, size_t size)
{
    return size > 25 && memcmp(data + 12, "IHDR", 4) == 0 && data[24] == 16;
}

typedef struct png_source {
    const char *data;
    size_t size, at;
} png_source;

static void read_bytes(png_structp png, png_bytep to, png_size_t count)
{
    png_source *s = png_get_io_ptr(png);
    if (count > s->size - s->at)
        png_error(png, "it ends too early");
    memcpy(to, s->data + s->at, count);
    s->at += count;
}

static void keep_text(png_structp png, png_const_charp text)
{
    iso_error *err = png_get_error_ptr(png);
    iso_fail(err, ISO_E_FORMAT, "%s", text);
    png_longjmp(png, 1);
}

static void pass_over(png_structp png, png_const_charp text)
{
    (void)png, (void)text;
}

/* What libpng allocates while it may jump away. */
typedef struct png_job {
    png_structp png;
    png_infop info;
    uint16_t *samples; /* 4 a pixel */
    png_bytep *rows;
    size_t width, height;
    bool linear;
} png_job;

/* false: the error says why. */
static bool decode(png_job *job, png_source *source)
{
    if (setjmp(png_jmpbuf(job->png)))
        return false;
    png_set_read_fn(job->png, source, read_bytes);
    png_read_info(job->png, job->info);
    job->width = png_get_image_width(job->png, job->info);
    job->height = png_get_image_height(job->png, job->info);
    double gamma = 0;
    job->linear = !png_get_valid(job->png, job->info, PNG_INFO_sRGB) && png_get_gAMA(job->png, job->info, &gamma) &&
                  gamma > 0.99;
    png_set_gray_to_rgb(job->png);
    png_set_add_alpha(job->png, 0xffff, PNG_FILLER_AFTER);
    const uint16_t one = 1;
    if (*(const uint8_t *)&one == 1)
        png_set_swap(job->png);
    png_set_interlace_handling(job->png);
    png_read_update_info(job->png, job->info);
    job->samples = malloc(8 * job->width * job->height);
    job->rows = malloc(job->height * sizeof *job->rows);
    if (!job->samples || !job->rows)
        png_error(job->png, "no memory for its pixels");
    for (size_t y = 0; y < job->height; ++y)
        job->rows[y] = (png_bytep)(job->samples + 4 * job->width * y);
    png_read_image(job->png, job->rows);
    return true;
}

iso_status iso_png16_take(const char *path, const char *data, size_t size, iso_image *image, iso_error *err)
{
    iso_error why = {""};
    png_source source = {data, size, 0};
    png_job job = {.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &why, keep_text, pass_over)};
    job.info = job.png ? png_create_info_struct(job.png) : NULL;
    iso_status status = !job.info              ? iso_fail(err, ISO_E_MEMORY, "%s: no memory", path)
                        : decode(&job, &source) ? iso_image_create(image, job.width, job.height, err)
                                                : iso_fail(err, ISO_E_FORMAT, "%s: %s", path, why.text);
    for (size_t i = 0; status == ISO_OK && i < 4 * job.width * job.height; ++i) {
        const double alpha = job.samples[i | 3] / 65535.0, value = job.samples[i] / 65535.0;
        image->rgba[i] = (float)(i % 4 == 3 ? alpha : alpha * (job.linear ? value : iso_png_linear(value)));
    }
    png_destroy_read_struct(&job.png, &job.info, NULL);
    free(job.samples);
    free(job.rows);
    return status;
}
