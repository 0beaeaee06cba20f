/* SPDX-License-Identifier: MIT */
#include "render/gl/gl_palette.h"

#include <stdlib.h>

iso_status iso_gl_upload_indices(const iso_gl *gl, const iso_level *level, GLuint *texture, iso_error *err)
{
    const size_t *size = level->geometry.size, plane_count = size[0] * size[1];
    if (!level->palette || !level->palette_index)
        return iso_fail(err, ISO_E_RANGE, "gl: the level holds no palette, and directions from one are asked for");
    bool bytes = level->palette->count <= 256;
    NEED(iso_gl_create_texture_3d(gl, bytes ? GL_R8UI : GL_R16UI, size, "palette indices", texture, err));
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    uint8_t *plane = bytes ? malloc(plane_count) : NULL;
    if (bytes && !plane)
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for a plane of %zu indices", plane_count);
    for (size_t z = 0; z < size[2]; ++z) {
        const uint16_t *index = level->palette_index + z * plane_count;
        for (size_t i = 0; bytes && i < plane_count; ++i)
            plane[i] = (uint8_t)index[i];
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, (GLint)z, (GLsizei)size[0], (GLsizei)size[1], 1, GL_RED_INTEGER,
                        bytes ? GL_UNSIGNED_BYTE : GL_UNSIGNED_SHORT, bytes ? (const void *)plane : index);
    }
    free(plane);
    return iso_gl_check("uploading palette indices", err);
}

iso_status iso_gl_upload_palette(const iso_gl *gl, const iso_palette *palette, const iso_view *view, GLuint *texture,
                                 iso_error *err)
{
    iso_palette_light lights[ISO_MAX_LIGHTS];
    const iso_vec3 forward = view->camera.forward;
    const iso_shading *s = &view->shading;
    const iso_palette_shading shading = {
        s->ambient, s->diffuse, s->specular, s->power, lights, view->light_count, {-forward.x, -forward.y, -forward.z}};
    for (size_t i = 0; i < view->light_count; ++i) {
        iso_vec3 d = view->lights[i].direction;
        lights[i] = (iso_palette_light){{d.x, d.y, d.z}, view->lights[i].intensity};
    }
    FREED float *shade = malloc(palette->count * sizeof *shade), *row = malloc(4 * palette->count * sizeof *row);
    if (!shade || !row) {
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for %zu palette entries", palette->count);
    } else {
        iso_palette_shade(palette, &shading, shade);
        for (size_t i = 0; i < palette->count; ++i) {
            for (size_t c = 0; c < 3; ++c)
                row[4 * i + c] = palette->xyz[3 * i + c];
            row[4 * i + 3] = shade[i];
        }
        NEED(iso_gl_create_texture_rgba32f(gl, palette->count, 1, row, texture, err));
    }
    return ISO_OK;
}
