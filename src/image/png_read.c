/* SPDX-License-Identifier: MIT */
/* png_read.c - PNG of all bits and kinds as linear light of Rec. 709. libpng expands the samples to RGBA of 16 bits;
 * colors are decoded here, since libpng replaces the curve of sRGB by a power of 2.2. */
#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "image/picture_bytes.h"
#include "image/primaries.h"

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

/* libpng's objects and our memory, kept here because libpng leaves by longjmp. */
typedef struct png_job {
    png_structp png;
    png_infop info;
    uint16_t *samples; /* 4 per pixel */
    png_bytep *rows;
    size_t width, height;
    double gamma; /* exponent of linear light to samples; 0: sRGB's curve */
    bool has_alpha, has_primaries;
    iso_primaries primaries;
    bool is_other_space; /* the chunk cICP names another space than sRGB */
    char profile[80];    /* name of a color profile that is not sRGB's */
} png_job;

/* Takes the chunk cICP, also from a libpng that knows it (1.6.45): primaries 1, transfer 13 and full range are sRGB. */
static int take_unknown(png_structp png, png_unknown_chunkp chunk)
{
    static const png_byte srgb[4] = {1, 13, 0, 1};
    png_job *job = png_get_user_chunk_ptr(png);
    if (memcmp(chunk->name, "cICP", 4) == 0)
        job->is_other_space = chunk->size != 4 || memcmp(chunk->data, srgb, 4) != 0;
    return 1;
}

/* Reads the color space from the first of cICP, iCCP, sRGB, gAMA with cHRM (PNG 3, section 4.3). */
static void read_color_space(png_job *job)
{
    /* libpng's own tolerance: programs that mean sRGB write gAMA as 45455, 45450 or 45500. */
    const double srgb_gamma = 1 / 2.2, tolerance = 0.05;
    png_charp name = NULL;
    png_bytep profile = NULL;
    png_uint_32 length = 0;
    int method = 0;
    double gamma = 0;
    double(*c)[2] = job->primaries.xy;
    if (png_get_valid(job->png, job->info, PNG_INFO_sRGB))
        return;
    if (png_get_iCCP(job->png, job->info, &name, &method, &profile, &length) && !strstr(name, "sRGB")) {
        strncpy(job->profile, name, sizeof job->profile - 1);
        return;
    }
    if (name)
        return;
    if (png_get_gAMA(job->png, job->info, &gamma) && !(fabs(gamma / srgb_gamma - 1) <= tolerance))
        job->gamma = gamma;
    job->has_primaries = png_get_cHRM(job->png, job->info, &c[3][0], &c[3][1], &c[0][0], &c[0][1], &c[1][0], &c[1][1],
                                      &c[2][0], &c[2][1]) != 0;
}

/* Reads the file's header and pixels. False: the error has the reason. */
static bool decode(png_job *job, png_source *source)
{
    if (setjmp(png_jmpbuf(job->png)))
        return false;
    png_set_read_fn(job->png, source, read_bytes);
    png_set_crc_action(job->png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT); /* ancillary chunks define the colors */
    png_set_read_user_chunk_fn(job->png, job, take_unknown);
    png_set_keep_unknown_chunks(job->png, PNG_HANDLE_CHUNK_ALWAYS, (png_const_bytep) "cICP", 1);
    png_read_info(job->png, job->info);
    job->width = png_get_image_width(job->png, job->info);
    job->height = png_get_image_height(job->png, job->info);
    job->has_alpha = png_get_color_type(job->png, job->info) & PNG_COLOR_MASK_ALPHA ||
                     png_get_valid(job->png, job->info, PNG_INFO_tRNS);
    read_color_space(job);
    png_set_expand_16(job->png); /* palettes, tRNS and 1 to 8 bits: 255 becomes 65535 */
    png_set_gray_to_rgb(job->png);
    png_set_add_alpha(job->png, 0xffff, PNG_FILLER_AFTER);
    const uint16_t one = 1;
    if (*(const uint8_t *)&one == 1)
        png_set_swap(job->png);
    png_set_interlace_handling(job->png);
    png_read_update_info(job->png, job->info);
    if (png_get_rowbytes(job->png, job->info) != 8 * job->width)
        png_error(job->png, "its pixels are of an unknown form");
    job->samples = malloc(8 * job->width * job->height);
    job->rows = malloc(job->height * sizeof *job->rows);
    if (!job->samples || !job->rows)
        png_error(job->png, "no memory for its pixels");
    for (size_t y = 0; y < job->height; ++y)
        job->rows[y] = (png_bytep)(job->samples + 4 * job->width * y);
    png_read_image(job->png, job->rows);
    return true;
}

/* Converts an sRGB value to a linear one (IEC 61966-2-1). */
static double linear_of_srgb(double c)
{
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

static iso_status take_pixels(const char *path, const png_job *job, iso_image *image, iso_error *err)
{
    if (job->is_other_space)
        return iso_fail(err, ISO_E_FORMAT, "%s: its chunk cICP names another color space, must be sRGB; convert it", path);
    if (job->profile[0])
        return iso_fail(err, ISO_E_FORMAT, "%s: has the color profile \"%s\", must be sRGB; convert it", path, job->profile);
    iso_status status = iso_image_create(image, job->width, job->height, err);
    if (status != ISO_OK)
        return iso_fail_in(err, status, "%s", path);
    for (size_t i = 0; i < 4 * job->width * job->height; ++i) {
        const double value = job->samples[i] / 65535.0, alpha = job->samples[i | 3] / 65535.0;
        const double linear = job->gamma > 0 ? pow(value, 1 / job->gamma) : linear_of_srgb(value);
        image->rgba[i] = (float)(i % 4 == 3 ? alpha : alpha * linear);
    }
    if (job->has_primaries)
        status = iso_primaries_convert(path, &job->primaries, image, err);
    if (status != ISO_OK)
        iso_image_destroy(image);
    return status;
}

iso_status iso_png_decode(const char *path, const char *data, size_t size, bool *has_alpha, iso_image *image,
                          iso_error *err)
{
    iso_error why = {""};
    png_source source = {data, size, 0};
    png_job job = {.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &why, keep_text, pass_over)};
    *image = (iso_image){0};
    job.info = job.png ? png_create_info_struct(job.png) : NULL;
    const iso_status status = !job.info              ? iso_fail(err, ISO_E_MEMORY, "%s: no memory", path)
                              : decode(&job, &source) ? take_pixels(path, &job, image, err)
                                                      : iso_fail(err, ISO_E_FORMAT, "%s: %s", path, why.text);
    *has_alpha = job.has_alpha;
    png_destroy_read_struct(&job.png, &job.info, NULL);
    free(job.samples);
    free(job.rows);
    return status;
}

iso_status iso_image_load_png(const char *path, iso_image *image, iso_error *err)
{
    FREED char *data = NULL;
    size_t size;
    bool has_alpha;
    *image = (iso_image){0};
    NEED(iso_picture_read_kind(path, ISO_PICTURE_PNG, "PNG", &data, &size, err));
    return iso_png_decode(path, data, size, &has_alpha, image, err);
}
