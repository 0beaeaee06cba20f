/* SPDX-License-Identifier: MIT */
#include "render/gl/gl_directions.h"

#include <math.h>
#include <stdlib.h>

#include "fit/extinction_scale.h"

static bool needs_16_bits(const iso_gl *gl)
{
    return gl->info.filter_bits_unorm8 < gl->info.filter_bits_float - 1 &&
           gl->info.filter_bits_unorm16 > gl->info.filter_bits_unorm8;
}

iso_status iso_gl_upload_bytes(const iso_gl *gl, const iso_level *level, const uint8_t *bytes, const char *what,
                               GLuint *texture, iso_error *err)
{
    const size_t *size = level->geometry.size, plane_count = size[0] * size[1];
    const bool wide = needs_16_bits(gl);
    NEED(iso_gl_create_texture_3d(gl, wide ? GL_R16 : GL_R8, size, what, texture, err));
    FREED uint16_t *plane = wide ? malloc(plane_count * sizeof *plane) : NULL;
    if (wide && !plane)
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for a plane of %zu bytes", plane_count);
    for (size_t z = 0; z < size[2]; ++z) {
        for (size_t i = 0; wide && i < plane_count; ++i)
            plane[i] = (uint16_t)(bytes[z * plane_count + i] * 257);
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, (GLint)z, (GLsizei)size[0], (GLsizei)size[1], 1, GL_RED,
                        wide ? GL_UNSIGNED_SHORT : GL_UNSIGNED_BYTE,
                        wide ? (const void *)plane : bytes + z * plane_count);
    }
    return ISO_OK;
}

/* ---- codes ------------------------------------------------------------------------------------------------------ */

/* Storage of codes: bytes if they are filtered as finely as floats. Otherwise the same lattice in 16 bits, a multiple
 * of the byte, so that no code is rounded. */
typedef struct code_layout {
    bool is_signed, wide;
    size_t channels;
} code_layout;

/* The middle of the scale's bytes is 0 in signed textures, whose texels are -127 to 127. */
enum { SIGNED_MIDDLE = ISO_EXTINCTION_SCALE_LAST / 2 };

static void store(const code_layout *l, int number, size_t at, void *plane)
{
    if (l->wide)
        ((uint16_t *)plane)[at] = (uint16_t)(l->is_signed ? number * 258 : number * 257);
    else
        ((uint8_t *)plane)[at] = (uint8_t)number;
}

static void fill_plane(const code_layout *l, const uint8_t *codes, const uint8_t *scale, size_t count, void *plane)
{
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < 3; ++c) {
            const int byte = codes[3 * i + c], number = (int8_t)byte < -127 ? -127 : (int8_t)byte;
            store(l, l->is_signed ? number : byte, l->channels * i + c, plane);
        }
        if (scale)
            store(l, l->is_signed ? scale[i] - SIGNED_MIDDLE : scale[i], l->channels * i + 3, plane);
    }
}

static void set_factors(const code_layout *l, iso_gl_directions *d)
{
    const double octave = ISO_EXTINCTION_SCALE_PER_OCTAVE, one = ISO_EXTINCTION_SCALE_ONE;
    const double per_unit = l->wide ? 32767.0 / 258 : 127; /* signed numbers to texels */
    d->scale = l->is_signed ? per_unit / 127 : 2;
    d->offset = l->is_signed ? 0 : -1;
    d->octaves = (l->is_signed ? per_unit : 255) / octave;
    d->octaves_offset = ((l->is_signed ? SIGNED_MIDDLE : 0) - one) / octave;
}

iso_status iso_gl_upload_codes(const iso_gl *gl, const iso_level *level, iso_code code, const uint8_t *extinction_scale,
                               iso_gl_directions *d, iso_error *err)
{
    const size_t *size = level->geometry.size, plane_count = size[0] * size[1];
    const code_layout l = {iso_code_describe(code)->is_signed, needs_16_bits(gl), extinction_scale ? 4 : 3};
    const GLenum format = l.is_signed ? (l.wide ? GL_RGBA16_SNORM : GL_RGBA8_SNORM) : (l.wide ? GL_RGBA16 : GL_RGBA8);
    const GLenum type = l.is_signed ? (l.wide ? GL_SHORT : GL_BYTE) : (l.wide ? GL_UNSIGNED_SHORT : GL_UNSIGNED_BYTE);
    set_factors(&l, d);
    NEED(iso_gl_create_texture_3d(gl, format, size, "direction codes", &d->texture, err));
    void *plane = malloc(plane_count * l.channels * (l.wide ? 2 : 1));
    NEED_MEMORY(plane, err, "gl: no memory for a plane of codes");
    for (size_t z = 0; z < size[2]; ++z) {
        const size_t first = z * plane_count;
        fill_plane(&l, level->codes + 3 * first, extinction_scale ? extinction_scale + first : NULL, plane_count,
                   plane);
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, (GLint)z, (GLsizei)size[0], (GLsizei)size[1], 1,
                        extinction_scale ? GL_RGBA : GL_RGB, type, plane);
    }
    free(plane);
    return iso_gl_check("uploading direction codes", err);
}

/* Fills a plane with unsigned texels, so that the scalar's equal those of its own texture. Signed numbers -127 to 127
 * are stored from 0 on. */
static void fill_plane_with_scalar(const iso_level *level, bool is_signed, double multiple, size_t first, size_t count,
                                   uint16_t *plane)
{
    const code_layout l = {is_signed, true, 4};
    for (size_t i = 0; i < count; ++i) {
        const uint8_t *code = level->codes + 3 * (first + i);
        for (size_t c = 0; c < 3; ++c) {
            const int number = (int8_t)code[c] < -127 ? -127 : (int8_t)code[c];
            store(&l, is_signed ? number + 127 : code[c], 4 * i + c, plane);
        }
        plane[4 * i + 3] = (uint16_t)lrint(((double)level->scalar[first + i] - level->min) * multiple);
    }
}

iso_status iso_gl_upload_codes_with_scalar(const iso_gl *gl, const iso_level *level, iso_code code, double multiple,
                                           iso_gl_directions *d, iso_error *err)
{
    const size_t *size = level->geometry.size, count = size[0] * size[1];
    const bool is_signed = iso_code_describe(code)->is_signed;
    d->scale = is_signed ? 65535.0 / 258 / 127 : 2;
    d->offset = -1;
    NEED(iso_gl_create_texture_3d(gl, GL_RGBA16, size, "direction codes and a scalar volume", &d->texture, err));
    uint16_t *plane = malloc(4 * count * sizeof *plane);
    NEED_MEMORY(plane, err, "gl: no memory for a plane of codes");
    for (size_t z = 0; z < size[2]; ++z) {
        fill_plane_with_scalar(level, is_signed, multiple, z * count, count, plane);
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, (GLint)z, (GLsizei)size[0], (GLsizei)size[1], 1, GL_RGBA,
                        GL_UNSIGNED_SHORT, plane);
    }
    free(plane);
    return iso_gl_check("uploading direction codes and the scalar", err);
}

/* ---- floats ----------------------------------------------------------------------------------------------------- */

/* Interleaves directions with log2 of the scale as fourth component. */
static void interleave(const float *directions, const uint8_t *scale, size_t count, float *out)
{
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < 3; ++c)
            out[4 * i + c] = directions[3 * i + c];
        out[4 * i + 3] = (float)(scale[i] - ISO_EXTINCTION_SCALE_ONE) / ISO_EXTINCTION_SCALE_PER_OCTAVE;
    }
}

iso_status iso_gl_upload_vectors(const iso_gl *gl, const iso_level *level, iso_code code, iso_direction_source source,
                                 const uint8_t *extinction_scale, iso_gl_directions *d, iso_error *err)
{
    const size_t *size = level->geometry.size;
    size_t plane_count = size[0] * size[1];
    if (source == ISO_FROM_FLOAT && !level->directions)
        return iso_fail(err, ISO_E_RANGE, "gl: the level holds no float directions; build with --keep-float");
    NEED(iso_gl_create_texture_3d(gl, extinction_scale ? GL_RGBA32F : GL_RGB32F, size, "float directions", &d->texture,
                                  err));
    float *plane = malloc((extinction_scale ? 7 : 3) * plane_count * sizeof *plane);
    NEED_MEMORY(plane, err, "gl: no memory for a plane of %zu directions", plane_count);
    for (size_t z = 0; z < size[2]; ++z) {
        const size_t first = z * plane_count;
        const float *from = source == ISO_FROM_FLOAT ? level->directions + 3 * first : plane;
        if (source != ISO_FROM_FLOAT)
            iso_code_decode_all(code, level->codes + 3 * first, plane, plane_count);
        if (extinction_scale) {
            interleave(from, extinction_scale + first, plane_count, plane + 3 * plane_count);
            from = plane + 3 * plane_count;
        }
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, (GLint)z, (GLsizei)size[0], (GLsizei)size[1], 1,
                        extinction_scale ? GL_RGBA : GL_RGB, GL_FLOAT, from);
    }
    free(plane);
    d->scale = 1;
    d->octaves = 1;
    return iso_gl_check("uploading float directions", err);
}
