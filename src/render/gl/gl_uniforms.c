/* SPDX-License-Identifier: MIT */
#include "render/gl/gl_uniforms.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void iso_gl_set_float(GLuint program, const char *name, double value)
{
    glUniform1f(glGetUniformLocation(program, name), (float)value);
}

void iso_gl_set_int(GLuint program, const char *name, int value)
{
    glUniform1i(glGetUniformLocation(program, name), value);
}

void iso_gl_set_vec3(GLuint program, const char *name, iso_vec3 v)
{
    glUniform3f(glGetUniformLocation(program, name), (float)v.x, (float)v.y, (float)v.z);
}

static void set_dvec3(GLuint program, const char *name, iso_vec3 v)
{
    glUniform3d(glGetUniformLocation(program, name), v.x, v.y, v.z);
}

void iso_gl_matrix_columns(iso_mat3 m, double columns[9])
{
    for (int i = 0; i < 9; ++i)
        columns[i] = m.m[i % 3][i / 3];
}

void iso_gl_set_camera(GLuint program, const iso_geometry *g, const iso_view *view, double step_mm)
{
    const iso_camera *c = &view->camera;
    double width = (double)view->width, height = (double)view->height, columns[9];
    iso_gl_matrix_columns(iso_mat3_inverse(g->index_to_world), columns);
    glUniformMatrix3dv(glGetUniformLocation(program, "to_index"), 1, GL_FALSE, columns);
    glUniform2d(glGetUniformLocation(program, "image_size"), width, height);
    glUniform2d(glGetUniformLocation(program, "half_image"), c->half_height * width / height, c->half_height);
    iso_gl_set_int(program, "orthographic", c->orthographic);
    set_dvec3(program, "forward", c->forward);
    set_dvec3(program, "right", c->right);
    set_dvec3(program, "up", c->up);
    set_dvec3(program, "position_index", iso_geometry_to_index(g, c->position));
    set_dvec3(program, "box_index", iso_v3(g->box_index[0], g->box_index[1], g->box_index[2]));
    glUniform1d(glGetUniformLocation(program, "step_mm"), step_mm);
    double planes[4 * ISO_MAX_CLIP_PLANES];
    for (size_t i = 0; i < view->clip_count; ++i)
        iso_clip_in_index(&view->clips[i], g, planes + 4 * i);
    if (view->clip_count > 0)
        glUniform4dv(glGetUniformLocation(program, "clip_planes"), (GLsizei)view->clip_count, planes);
    iso_gl_set_int(program, "clip_count", (int)view->clip_count);
}

void iso_gl_set_coordinates(GLuint program, iso_vec3 scale, iso_vec3 offset)
{
    set_dvec3(program, "index_scale", scale);
    set_dvec3(program, "index_offset", offset);
}

void iso_gl_set_tf(GLuint program, const iso_tf_table *tf, double zero, double per_texel)
{
    const double entries = (double)(tf->count - 1) / (tf->hi - tf->lo), scale = per_texel * entries,
                 offset = (zero - tf->lo) * entries;
    iso_gl_set_float(program, "tf_scale", scale);
    iso_gl_set_float(program, "tf_offset", offset);
    glUniform2d(glGetUniformLocation(program, "tf_exact"), scale, offset);
    iso_gl_set_int(program, "tf_count", (int)tf->count);
}

void iso_gl_set_light(GLuint program, const iso_view *view)
{
    for (size_t i = 0; i < view->light_count; ++i) {
        char name[48];
        snprintf(name, sizeof name, "light_direction[%zu]", i);
        iso_gl_set_vec3(program, name, view->lights[i].direction);
        snprintf(name, sizeof name, "light_intensity[%zu]", i);
        iso_gl_set_float(program, name, view->lights[i].intensity);
    }
    const iso_shading *s = &view->shading;
    glUniform4f(glGetUniformLocation(program, "shading"), (float)s->ambient, (float)s->diffuse, (float)s->specular,
                (float)s->power);
    iso_gl_set_vec3(program, "background", iso_v3(view->background[0], view->background[1], view->background[2]));
}

void iso_gl_set_surface(GLuint program, const iso_surface *surface, iso_vec3 samples_per_p, double first_sample,
                        double zero, double per_texel)
{
    iso_gl_set_float(program, "iso_texel", (surface->iso - zero) / (per_texel > 0 ? per_texel : 1));
    iso_gl_set_vec3(program, "samples_per_p", samples_per_p);
    iso_gl_set_float(program, "first_sample", first_sample);
}

iso_tf_table iso_gl_surface_tf(const iso_surface *surface, double min, double max, float entries[12])
{
    double reach = fmax(fmax(fabs(max - surface->iso), fabs(min - surface->iso)), 1e-300);
    memset(entries, 0, 12 * sizeof *entries);
    entries[11] = 1;
    return (iso_tf_table){.lo = surface->iso - reach, .hi = surface->iso + reach, .count = 3, .entries = entries};
}
