/* SPDX-License-Identifier: MIT */
/* exr.c - OpenEXR through OpenEXRCore, the library's C interface. */
#include <errno.h>
#include <openexr.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "image/image.h"

/* The pipelines' initializers of OpenEXR name their first fields alone: the others are 0, as C has it. */
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"

/* The library reports through a callback; the last message is the cause. It is kept by the thread, not as the context's
 * user data: while a file is written, the library holds the context's lock when it reports, and would wait for itself. */
static _Thread_local char last_message[512];

static void on_exr_error(exr_const_context_t context, exr_result_t code, const char *message)
{
    (void)context;
    (void)code;
    strncpy(last_message, message, sizeof last_message - 1);
}

static exr_context_initializer_t initializer(void)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = on_exr_error;
    memset(last_message, 0, sizeof last_message);
    errno = 0;
    return init;
}

/* Of a file that could not be read: was it the file, or what is in it? A file that is too short leaves errno alone. */
static iso_status read_failure(void)
{
    return errno == EIO || errno == EINTR || errno == EMFILE || errno == ENFILE || errno == EACCES || errno == ENOMEM
               ? iso_errno_status()
               : ISO_E_FORMAT;
}

/* Channels are stored by name, in alphabetical order. */
static const char *const channel_names[4] = {"A", "B", "G", "R"};
static int component_of(const char *channel)
{
    static const char names[] = "RGBA";
    const char *at = channel[0] && !channel[1] ? strchr(names, channel[0]) : NULL;
    return at ? (int)(at - names) : -1;
}

static exr_result_t write_header(exr_context_t file, const iso_image *image, const iso_image_note *notes)
{
    int part;
    exr_result_t result = exr_add_part(file, NULL, EXR_STORAGE_SCANLINE, &part);
    if (result == EXR_ERR_SUCCESS)
        result = exr_initialize_required_attr_simple(file, part, (int32_t)image->width, (int32_t)image->height,
                                                     EXR_COMPRESSION_ZIP);
    for (int c = 0; c < 4 && result == EXR_ERR_SUCCESS; ++c)
        result = exr_add_channel(file, part, channel_names[c], EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    for (; notes && notes->key && result == EXR_ERR_SUCCESS; ++notes)
        if (notes->value[0])
            result = exr_attr_set_string(file, part, notes->key, notes->value);
    return result == EXR_ERR_SUCCESS ? exr_write_header(file) : result;
}

static exr_result_t write_pixels(exr_context_t file, const iso_image *image)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t lines = 1;
    exr_result_t result = exr_get_scanlines_per_chunk(file, 0, &lines);
    for (size_t y = 0; y < image->height && result == EXR_ERR_SUCCESS; y += (size_t)lines) {
        exr_chunk_info_t chunk;
        result = exr_write_scanline_chunk_info(file, 0, (int)y, &chunk);
        if (result == EXR_ERR_SUCCESS)
            result = y == 0 ? exr_encoding_initialize(file, 0, &chunk, &pipe)
                            : exr_encoding_update(file, 0, &chunk, &pipe);
        for (int c = 0; c < pipe.channel_count && result == EXR_ERR_SUCCESS; ++c) {
            exr_coding_channel_info_t *channel = &pipe.channels[c];
            const float *from = image->rgba + 4 * y * image->width + (size_t)component_of(channel->channel_name);
            channel->user_pixel_stride = 4 * sizeof(float);
            channel->user_line_stride = (int32_t)(4 * sizeof(float) * image->width);
            channel->encode_from_ptr = (const uint8_t *)from;
        }
        if (result == EXR_ERR_SUCCESS && y == 0)
            result = exr_encoding_choose_default_routines(file, 0, &pipe);
        if (result == EXR_ERR_SUCCESS)
            result = exr_encoding_run(file, 0, &pipe);
    }
    exr_encoding_destroy(file, &pipe);
    return result;
}

iso_status iso_image_save_exr(const iso_image *image, const char *path, const iso_image_note *notes, iso_error *err)
{
    exr_context_initializer_t init = initializer();
    exr_context_t file = NULL;
    iso_output out;
    iso_status status = iso_output_begin(&out, path, err);
    if (status != ISO_OK)
        return status;
    exr_result_t result = exr_start_write(&file, out.temp_path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (result == EXR_ERR_SUCCESS)
        result = write_header(file, image, notes);
    if (result == EXR_ERR_SUCCESS)
        result = write_pixels(file, image);
    exr_result_t closed = file ? exr_finish(&file) : EXR_ERR_SUCCESS;
    if (result == EXR_ERR_SUCCESS && closed == EXR_ERR_SUCCESS)
        return iso_output_commit(&out, err);
    if (result == EXR_ERR_SUCCESS)
        result = closed;
    status = iso_fail(err, result == EXR_ERR_OUT_OF_MEMORY ? ISO_E_MEMORY : ISO_E_IO, "%s: cannot be written: %s", path,
                      last_message[0] ? last_message : exr_get_default_error_message(result));
    iso_output_abandon(&out);
    return status;
}

/* A file that is read chunk by chunk. */
typedef struct chunk_reader {
    exr_context_t file;
    exr_decode_pipeline_t pipe;
    bool started;
    iso_image *image;
    unsigned mask; /* the components that came */
} chunk_reader;

/* Points the decoder at the pixels of one chunk, whose first is at (x, y) of
 * the image. Channels that are not ours are skipped. */
static void aim(chunk_reader *r, size_t x, size_t y)
{
    exr_decode_pipeline_t *pipe = &r->pipe;
    iso_image *image = r->image;
    for (int c = 0; c < pipe->channel_count; ++c) {
        exr_coding_channel_info_t *channel = &pipe->channels[c];
        int component = component_of(channel->channel_name);
        channel->decode_to_ptr = NULL;
        if (component < 0 || channel->x_samples != 1 || channel->y_samples != 1)
            continue;
        r->mask |= 1u << component;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 4 * sizeof(float);
        channel->user_line_stride = (int32_t)(4 * sizeof(float) * image->width);
        channel->decode_to_ptr = (uint8_t *)(image->rgba + 4 * (y * image->width + x) + component);
    }
}

static exr_result_t decode_chunk(chunk_reader *r, const exr_chunk_info_t *chunk, size_t x, size_t y)
{
    exr_result_t result = r->started ? exr_decoding_update(r->file, 0, chunk, &r->pipe)
                                     : exr_decoding_initialize(r->file, 0, chunk, &r->pipe);
    if (result != EXR_ERR_SUCCESS)
        return result;
    aim(r, x, y);
    if (!r->started)
        result = exr_decoding_choose_default_routines(r->file, 0, &r->pipe);
    r->started = true;
    return result == EXR_ERR_SUCCESS ? exr_decoding_run(r->file, 0, &r->pipe) : result;
}

static exr_result_t read_scanlines(chunk_reader *r, int32_t first_line)
{
    int32_t lines = 1;
    exr_result_t result = exr_get_scanlines_per_chunk(r->file, 0, &lines);
    for (size_t y = 0; y < r->image->height && result == EXR_ERR_SUCCESS; y += (size_t)lines) {
        exr_chunk_info_t chunk;
        result = exr_read_scanline_chunk_info(r->file, 0, first_line + (int)y, &chunk);
        if (result == EXR_ERR_SUCCESS)
            result = decode_chunk(r, &chunk, 0, y);
    }
    return result;
}

static exr_result_t read_tiles(chunk_reader *r)
{
    int32_t tile_width = 0, tile_height = 0;
    exr_result_t result = exr_get_tile_sizes(r->file, 0, 0, 0, &tile_width, &tile_height);
    for (size_t y = 0; y < r->image->height && result == EXR_ERR_SUCCESS; y += (size_t)tile_height)
        for (size_t x = 0; x < r->image->width && result == EXR_ERR_SUCCESS; x += (size_t)tile_width) {
            exr_chunk_info_t chunk;
            result = exr_read_tile_chunk_info(r->file, 0, (int)(x / (size_t)tile_width), (int)(y / (size_t)tile_height),
                                              0, 0, &chunk);
            if (result == EXR_ERR_SUCCESS)
                result = decode_chunk(r, &chunk, x, y);
        }
    return result;
}

static exr_result_t read_pixels(exr_context_t file, exr_attr_box2i_t window, iso_image *image, unsigned *mask)
{
    chunk_reader r = {.file = file, .pipe = EXR_DECODE_PIPELINE_INITIALIZER, .image = image};
    exr_storage_t storage;
    exr_result_t result = exr_get_storage(file, 0, &storage);
    if (result == EXR_ERR_SUCCESS && storage == EXR_STORAGE_SCANLINE)
        result = read_scanlines(&r, window.min.y);
    else if (result == EXR_ERR_SUCCESS && storage == EXR_STORAGE_TILED)
        result = read_tiles(&r);
    else if (result == EXR_ERR_SUCCESS)
        result = EXR_ERR_FEATURE_NOT_IMPLEMENTED; /* deep images */
    exr_decoding_destroy(file, &r.pipe);
    *mask |= r.mask;
    return result;
}

/* An image of zeros as large as the window. */
static iso_status create_for_window(exr_attr_box2i_t window, const char *path, iso_image *image, iso_error *err)
{
    int64_t width = (int64_t)window.max.x - window.min.x + 1, height = (int64_t)window.max.y - window.min.y + 1;
    if (width < 1 || height < 1 || width > 65536 || height > 65536)
        return iso_fail(err, ISO_E_RANGE, "%s: image size %lld x %lld, each must be 1 to 65536", path, (long long)width,
                        (long long)height);
    iso_status status = iso_image_create(image, (size_t)width, (size_t)height, err);
    return status == ISO_OK ? ISO_OK : iso_fail_in(err, status, "%s", path);
}

static bool is_same_window(exr_attr_box2i_t a, exr_attr_box2i_t b)
{
    return a.min.x == b.min.x && a.min.y == b.min.y && a.max.x == b.max.x && a.max.y == b.max.y;
}

/* Replaces an image of the data window's pixels by one of the display window's, which is the picture: it is transparent
 * and black where there are no data, and data beyond it are not seen. */
static iso_status place_in_display(exr_attr_box2i_t data, exr_attr_box2i_t display, const char *path, iso_image *image,
                                   iso_error *err)
{
    iso_image picture;
    iso_status status = create_for_window(display, path, &picture, err);
    if (status != ISO_OK)
        return status;
    const int32_t x0 = data.min.x > display.min.x ? data.min.x : display.min.x,
                  x1 = data.max.x < display.max.x ? data.max.x : display.max.x;
    const int32_t y0 = data.min.y > display.min.y ? data.min.y : display.min.y,
                  y1 = data.max.y < display.max.y ? data.max.y : display.max.y;
    for (int64_t y = y0; y <= y1 && x0 <= x1; ++y)
        memcpy(picture.rgba + 4 * ((size_t)(y - display.min.y) * picture.width + (size_t)((int64_t)x0 - display.min.x)),
               image->rgba + 4 * ((size_t)(y - data.min.y) * image->width + (size_t)((int64_t)x0 - data.min.x)),
               4 * sizeof(float) * (size_t)((int64_t)x1 - x0 + 1));
    iso_image_destroy(image);
    *image = picture;
    return ISO_OK;
}

static iso_status load_opened(exr_context_t file, const char *path, iso_image *image, iso_error *err)
{
    exr_attr_box2i_t window, display;
    unsigned mask = 0;
    if (exr_get_data_window(file, 0, &window) != EXR_ERR_SUCCESS ||
        exr_get_display_window(file, 0, &display) != EXR_ERR_SUCCESS)
        return iso_fail(err, ISO_E_FORMAT, "%s: has no data window or no display window", path);
    iso_status status = create_for_window(window, path, image, err);
    if (status != ISO_OK)
        return status;
    exr_result_t result = read_pixels(file, window, image, &mask);
    if (result != EXR_ERR_SUCCESS)
        status = iso_fail(err, read_failure(), "%s: %s", path,
                          last_message[0] ? last_message : exr_get_default_error_message(result));
    else if ((mask & 7) != 7)
        status = iso_fail(err, ISO_E_FORMAT, "%s: has no channels named R, G and B", path);
    else if (!(mask & 8))
        for (size_t i = 0; i < image->width * image->height; ++i)
            image->rgba[4 * i + 3] = 1;
    if (status == ISO_OK && !is_same_window(window, display))
        status = place_in_display(window, display, path, image, err);
    image->origin[0] = display.min.x;
    image->origin[1] = display.min.y;
    if (status != ISO_OK)
        iso_image_destroy(image);
    return status;
}

static unsigned channels_of(exr_const_context_t file)
{
    const exr_attr_chlist_t *list = NULL;
    unsigned found = 0;
    if (exr_get_channels(file, 0, &list) != EXR_ERR_SUCCESS)
        return 0;
    for (int i = 0; i < list->num_channels; ++i) {
        const exr_attr_chlist_entry_t *c = &list->entries[i];
        const int component = component_of(c->name.str);
        if (component >= 0 && c->x_sampling == 1 && c->y_sampling == 1)
            found |= 1u << component;
    }
    return found;
}

/* The library would wait for a pipe. */
static iso_status start_read(exr_context_t *file, const char *path, iso_error *err)
{
    exr_context_initializer_t init = initializer();
    if (iso_path_exists(path) && !iso_path_is_file(path))
        return iso_fail(err, ISO_E_IO, "%s: is not a regular file", path);
    if (exr_start_read(file, path, &init) != EXR_ERR_SUCCESS)
        return iso_fail(err, read_failure(), "%s: not an OpenEXR image: %s", path, last_message);
    return ISO_OK;
}

iso_status iso_image_read_exr_header(const char *path, iso_exr_header *header, iso_error *err)
{
    exr_context_t file = NULL;
    exr_attr_box2i_t window, display;
    *header = (iso_exr_header){0};
    const iso_status status = start_read(&file, path, err);
    if (status != ISO_OK)
        return status;
    const bool good = exr_get_data_window(file, 0, &window) == EXR_ERR_SUCCESS &&
                      exr_get_display_window(file, 0, &display) == EXR_ERR_SUCCESS && window.max.x >= window.min.x &&
                      window.max.y >= window.min.y;
    if (good)
        *header = (iso_exr_header){.width = (size_t)((int64_t)window.max.x - window.min.x + 1),
                                   .height = (size_t)((int64_t)window.max.y - window.min.y + 1),
                                   .is_cropped = !is_same_window(window, display),
                                   .channels = channels_of(file)};
    exr_finish(&file);
    return good ? ISO_OK : iso_fail(err, ISO_E_FORMAT, "%s: has no data window or no display window", path);
}

iso_status iso_image_load_exr(const char *path, iso_image *image, iso_error *err)
{
    exr_context_t file = NULL;
    *image = (iso_image){0};
    if (!iso_path_exists(path))
        return iso_fail(err, ISO_E_IO, "%s: no such file", path);
    iso_status status = start_read(&file, path, err);
    if (status == ISO_OK)
        status = load_opened(file, path, image, err);
    exr_finish(&file);
    return status;
}
