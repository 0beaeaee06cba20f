/* SPDX-License-Identifier: MIT */
/* Textures, and a program drawn over a whole image. */
#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "base/progress.h"
#include "render/gl/gl_context.h"

/* Fills a new texture with NaN in builds with sanitizers, so that reads of unwritten texels are visible. GL leaves the
 * content of a new texture undefined: Mesa clears it, other drivers leave old memory. */
static void poison(GLenum internal_format, const size_t size[3])
{
#ifdef ISO_POISON_TEXTURES
    const bool integers = internal_format == GL_R8UI || internal_format == GL_R16UI || internal_format == GL_R32UI;
    const size_t plane = size[0] * size[1];
    float *none = integers ? NULL : malloc(plane * 4 * sizeof *none);
    for (size_t i = 0; none && i < 4 * plane; ++i)
        none[i] = NAN;
    for (size_t z = 0; none && z < size[2]; ++z)
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, (GLint)z, (GLsizei)size[0], (GLsizei)size[1], 1, GL_RGBA, GL_FLOAT,
                        none);
    free(none);
#else
    (void)internal_format, (void)size;
#endif
}

iso_status iso_gl_clear_texture_3d(const size_t size[3], iso_error *err)
{
    uint8_t *zeros = calloc(size[0] * size[1], 1);
    NEED_MEMORY(zeros, err, "gl: no memory for a plane of %zu x %zu texels", size[0], size[1]);
    for (size_t z = 0; z < size[2]; ++z)
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, (GLint)z, (GLsizei)size[0], (GLsizei)size[1], 1, GL_RED,
                        GL_UNSIGNED_BYTE, zeros);
    free(zeros);
    return iso_gl_check("clearing a texture", err);
}

iso_status iso_gl_create_texture_3d(const iso_gl *gl, GLenum internal_format, const size_t size[3], const char *what,
                                    GLuint *texture, iso_error *err)
{
    *texture = 0;
    for (int a = 0; a < 3; ++a)
        if (size[a] > (size_t)gl->max_texture_3d_size)
            return iso_fail(err, ISO_E_RANGE, "gl: %s of %zu x %zu x %zu, %s takes at most %d along an axis", what,
                            size[0], size[1], size[2], gl->info.renderer, (int)gl->max_texture_3d_size);
    glGenTextures(1, texture);
    glBindTexture(GL_TEXTURE_3D, *texture);
    glTexStorage3D(GL_TEXTURE_3D, 1, internal_format, (GLsizei)size[0], (GLsizei)size[1], (GLsizei)size[2]);
    static const GLenum wraps[3] = {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R};
    for (int a = 0; a < 3; ++a)
        glTexParameteri(GL_TEXTURE_3D, wraps[a], GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    poison(internal_format, size);
    iso_status status = iso_gl_check(what, err);
    if (status != ISO_OK) {
        glDeleteTextures(1, texture);
        *texture = 0;
    }
    return status;
}

iso_status iso_gl_create_occupancy(const iso_gl *gl, const size_t count[3], const uint8_t *distance, GLuint *texture,
                                   iso_error *err)
{
    NEED(iso_gl_create_texture_3d(gl, GL_R8UI, count, "brick occupancy", texture, err));
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, (GLsizei)count[0], (GLsizei)count[1], (GLsizei)count[2], GL_RED_INTEGER,
                    GL_UNSIGNED_BYTE, distance);
    return iso_gl_check("uploading the brick occupancy", err);
}

iso_status iso_gl_create_texture_rgba32f(const iso_gl *gl, size_t width, size_t height, const float *rgba,
                                         GLuint *texture, iso_error *err)
{
    *texture = 0;
    if (width > (size_t)gl->max_texture_size || height > (size_t)gl->max_texture_size)
        return iso_fail(err, ISO_E_RANGE, "gl: image or table of %zu x %zu, %s takes at most %d along an axis", width,
                        height, gl->info.renderer, (int)gl->max_texture_size);
    glGenTextures(1, texture);
    glBindTexture(GL_TEXTURE_2D, *texture);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32F, (GLsizei)width, (GLsizei)height);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    if (rgba)
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, (GLsizei)width, (GLsizei)height, GL_RGBA, GL_FLOAT, rgba);
    iso_status status = iso_gl_check("image or table", err);
    if (status != ISO_OK) {
        glDeleteTextures(1, texture);
        *texture = 0;
    }
    return status;
}

/* Begins a query of the device time of the following commands; 0: the device has no timer. */
static GLuint begin_timer(const iso_gl *gl)
{
    GLuint query = 0;
    if (gl->info.timer_bits > 0) {
        glGenQueries(1, &query);
        glBeginQuery(GL_TIME_ELAPSED, query);
    }
    return query;
}

/* Returns the seconds; NaN without a timer. Call it after glFinish(), so that it need not wait. */
static double end_timer(GLuint query)
{
    GLuint64 nanoseconds = 0;
    if (query == 0)
        return NAN;
    glGetQueryObjectui64v(query, GL_QUERY_RESULT, &nanoseconds);
    glDeleteQueries(1, &query);
    return 1e-9 * (double)nanoseconds;
}

/* Draws the tiles from first until end. Of each row: from the first to the last one that shows. */
static void draw_tiles(const iso_screen_reach *screen, size_t columns, size_t first, size_t end)
{
    glEnable(GL_SCISSOR_TEST);
    for (size_t tile = first, next; tile < end; tile = next) {
        const size_t row = tile / columns;
        next = row * columns + columns < end ? row * columns + columns : end;
        size_t from = tile, to = next;
        while (screen && from < to && screen->mm[2 * from] > screen->mm[2 * from + 1])
            ++from;
        while (screen && from < to && screen->mm[2 * to - 2] > screen->mm[2 * to - 1])
            --to;
        if (from == to)
            continue;
        glScissor((GLint)(from % columns * ISO_SCREEN_TILE), (GLint)(row * ISO_SCREEN_TILE),
                  (GLsizei)((to - from) * ISO_SCREEN_TILE), ISO_SCREEN_TILE);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    glDisable(GL_SCISSOR_TEST);
}

/* Draws a picture in bands, if the call can be canceled: GL does not end a draw early. */
static iso_status draw_picture(const iso_gl *gl, size_t width, size_t height, const iso_gl_cover *cover, iso_error *err)
{
    const iso_progress *progress = cover->ray_samples > 0 ? iso_progress_current() : NULL;
    const bool in_bands = progress && progress->report;
    const size_t columns = (width + ISO_SCREEN_TILE - 1) / ISO_SCREEN_TILE,
                 tiles = columns * ((height + ISO_SCREEN_TILE - 1) / ISO_SCREEN_TILE);
    const double tile_samples = cover->ray_samples * ISO_SCREEN_TILE * ISO_SCREEN_TILE;
    const size_t band = in_bands ? (size_t)fmin(fmax(gl->band_samples / tile_samples, 1), (double)tiles) : tiles;
    if (!cover->screen && !in_bands) {
        glDrawArrays(GL_TRIANGLES, 0, 3);
        return ISO_OK;
    }
    if (cover->screen) {
        const GLfloat nothing[4] = {(GLfloat)cover->background[0], (GLfloat)cover->background[1],
                                    (GLfloat)cover->background[2], 0};
        glClearBufferfv(GL_COLOR, 0, nothing);
    }
    for (size_t first = 0, end; first < tiles; first = end) {
        end = first + band < tiles ? first + band : tiles;
        draw_tiles(cover->screen, columns, first, end);
        if (in_bands) {
            glFinish();
            iso_progress_report(progress, "draw", (double)end / (double)tiles);
            NEED(iso_progress_check(progress, err));
        }
    }
    return ISO_OK;
}

iso_status iso_gl_draw(iso_gl *gl, GLuint program, size_t width, size_t height, iso_gl_cover cover, float *rgba,
                       double *seconds, iso_error *err)
{
    GLuint target = 0, frame = 0;
    /* Bound to a unit that no program samples: the target must not replace a texture of the caller's. */
    GLint unit;
    glGetIntegerv(GL_ACTIVE_TEXTURE, &unit);
    glActiveTexture(GL_TEXTURE15);
    iso_status status = iso_gl_create_texture_rgba32f(gl, width, height, NULL, &target, err);
    glActiveTexture((GLenum)unit);
    if (status != ISO_OK)
        return status;
    glGenFramebuffers(1, &frame);
    glBindFramebuffer(GL_FRAMEBUFFER, frame);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target, 0);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        status = iso_fail(err, ISO_E_PROGRAM, "gl: no float target of %zu x %zu", width, height);
    if (status == ISO_OK) {
        glViewport(0, 0, (GLsizei)width, (GLsizei)height);
        glUseProgram(program);
        glBindVertexArray(gl->vertex_array);
        glFinish();
        double (*clock)(void) = gl->times_processor ? iso_cpu_seconds : iso_clock_seconds;
        const GLuint timer = begin_timer(gl);
        const double processor = iso_cpu_seconds(), start = clock();
        status = draw_picture(gl, width, height, &cover, err);
        if (timer != 0)
            glEndQuery(GL_TIME_ELAPSED);
        glFinish();
        if (seconds)
            *seconds = clock() - start;
        gl->processor_seconds = iso_cpu_seconds() - processor;
        gl->device_seconds = end_timer(timer);
        if (status == ISO_OK) {
            glReadPixels(0, 0, (GLsizei)width, (GLsizei)height, GL_RGBA, GL_FLOAT, rgba);
            status = iso_gl_check("drawing", err);
        }
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDeleteFramebuffers(1, &frame);
    glDeleteTextures(1, &target);
    return status;
}

iso_status iso_gl_draw_repeatedly(iso_gl *gl, GLuint program, const iso_gl_repeats *repeats, iso_image *image,
                                  double *least, iso_gl_stats *stats, iso_error *err)
{
    const size_t most = repeats->count ? repeats->count : 1;
    const bool timed = repeats->seconds > 0;
    iso_gl_cover cover = repeats->cover;
    float pixel[4];
    double sum = 0, best = INFINITY, least_device = NAN;
    if (timed || most > 1)
        cover.ray_samples = 0;
    iso_status status = timed ? iso_gl_draw(gl, program, 1, 1, (iso_gl_cover){0}, pixel, NULL, err) : ISO_OK;
    for (size_t i = 0; status == ISO_OK && i < most && (i == 0 || !timed || sum < repeats->seconds); ++i) {
        double once = 0;
        status = iso_gl_draw(gl, program, image->width, image->height, cover, image->rgba, &once, err);
        best = fmin(best, once);
        least_device = fmin(least_device, gl->device_seconds); /* of NaN and a number the number */
        sum += once;
        if (stats->draw_count < ISO_GL_MAX_DRAWS) {
            stats->draw_processor_seconds[stats->draw_count] = gl->processor_seconds;
            stats->draw_seconds[stats->draw_count++] = once;
        }
    }
    gl->device_seconds = least_device;
    if (least)
        *least = best;
    return status;
}

double iso_gl_texture_bytes(GLenum target, GLuint texture)
{
    static const GLenum sizes[] = {GL_TEXTURE_WIDTH, GL_TEXTURE_HEIGHT, GL_TEXTURE_DEPTH};
    static const GLenum channels[] = {GL_TEXTURE_RED_SIZE, GL_TEXTURE_GREEN_SIZE, GL_TEXTURE_BLUE_SIZE,
                                      GL_TEXTURE_ALPHA_SIZE};
    double texels = 1, bits = 0;
    GLint unit, value;
    if (!texture)
        return 0;
    glGetIntegerv(GL_ACTIVE_TEXTURE, &unit);
    glActiveTexture(GL_TEXTURE15); /* which no program samples */
    glBindTexture(target, texture);
    for (size_t i = 0; i < 3; ++i) {
        glGetTexLevelParameteriv(target, 0, sizes[i], &value);
        texels *= value;
    }
    for (size_t i = 0; i < 4; ++i) {
        glGetTexLevelParameteriv(target, 0, channels[i], &value);
        bits += value;
    }
    glBindTexture(target, 0);
    glActiveTexture((GLenum)unit);
    return texels * bits / 8;
}
