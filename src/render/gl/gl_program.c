/* SPDX-License-Identifier: MIT */
/* Shader files, their includes, and programs made of them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "render/gl/gl_context.h"

ISO_EMBED(iso_code_decode_glsl, "src/encode/code_decode.h");
ISO_EMBED(iso_points_glsl, "src/render/gl/shaders/points.glsl");
ISO_EMBED(iso_first_hit_glsl, "src/render/gl/shaders/first_hit.glsl");
ISO_EMBED(iso_held_glsl, "src/render/gl/shaders/held.glsl");
ISO_EMBED(iso_roi_glsl, "src/render/gl/shaders/roi.glsl");
ISO_EMBED(iso_raycast_glsl, "src/render/gl/shaders/raycast.glsl");
ISO_EMBED(iso_variants_glsl, "src/render/gl/shaders/variants.h");
ISO_EMBED(iso_probe_glsl, "src/render/gl/shaders/probe.glsl");
ISO_EMBED(iso_fullscreen_glsl, "src/render/gl/shaders/fullscreen.glsl");

static const struct {
    const char *name, *text;
} shader_files[] = {
    {"code_decode.h", iso_code_decode_glsl},
    {"first_hit.glsl", iso_first_hit_glsl},
    {"held.glsl", iso_held_glsl},
    {"roi.glsl", iso_roi_glsl},
    {"fullscreen.glsl", iso_fullscreen_glsl},
    {"points.glsl", iso_points_glsl},
    {"probe.glsl", iso_probe_glsl},
    {"raycast.glsl", iso_raycast_glsl},
    {"transition.h", ""}, /* iso_gl.transition */
    {"variants.h", iso_variants_glsl},
};

/* Reads a shader file from the shader folder, if one is set; otherwise returns the embedded text. The caller frees
 * *owned. */
static iso_status shader_text(const iso_gl *gl, const char *name, const char **text, char **owned, iso_error *err)
{
    *owned = NULL;
    *text = NULL;
    for (size_t i = 0; i < sizeof shader_files / sizeof *shader_files; ++i)
        if (strcmp(shader_files[i].name, name) == 0)
            *text = shader_files[i].text;
    if (gl->transition && strcmp(name, "transition.h") == 0)
        *text = gl->transition;
    if (!gl->shader_dir)
        return *text ? ISO_OK : iso_fail(err, ISO_E_MISSING, "gl: no shader is named '%s'", name);
    FREED char *path = iso_path_join(gl->shader_dir, name);
    NEED_MEMORY(path, err, "gl: no memory for a path");
    iso_status status = ISO_OK;
    /* Headers that C shares belong to their modules, not to the shaders: they need not be in the folder. */
    if (iso_path_exists(path) || !iso_path_ends_with(name, ".h")) {
        size_t size;
        status = iso_file_read(path, owned, &size, err);
        *text = *owned;
    }
    return status;
}

static iso_status compile(GLenum stage, const char *const *texts, GLsizei count, const char *name, GLuint *shader,
                          iso_error *err)
{
    GLint ok = 0;
    *shader = glCreateShader(stage);
    glShaderSource(*shader, count, texts, NULL);
    glCompileShader(*shader);
    glGetShaderiv(*shader, GL_COMPILE_STATUS, &ok);
    if (ok)
        return ISO_OK;
    char log[768] = "";
    glGetShaderInfoLog(*shader, sizeof log, NULL, log);
    glDeleteShader(*shader);
    return iso_fail(err, ISO_E_PROGRAM, "gl: shader %s does not compile: %s", name, log);
}

static iso_status link_program(GLuint vertex, GLuint fragment, const char *name, GLuint *program, iso_error *err)
{
    GLint ok = 0;
    *program = glCreateProgram();
    glAttachShader(*program, vertex);
    glAttachShader(*program, fragment);
    glLinkProgram(*program);
    glGetProgramiv(*program, GL_LINK_STATUS, &ok);
    if (ok)
        return ISO_OK;
    char log[768] = "";
    glGetProgramInfoLog(*program, sizeof log, NULL, log);
    glDeleteProgram(*program);
    return iso_fail(err, ISO_E_PROGRAM, "gl: shader %s does not link: %s", name, log);
}

/* A shader with its includes, as one text. Files are numbered in the order in which they begin: compilers name that
 * number and the line. */
typedef struct expansion {
    char *text;
    size_t size, room;
    int files;
} expansion;

static iso_status append(expansion *e, const char *text, size_t length, iso_error *err)
{
    if (e->size + length + 1 > e->room) {
        size_t room = 2 * (e->size + length + 1);
        char *larger = realloc(e->text, room);
        NEED_MEMORY(larger, err, "gl: no memory for a shader of %zu bytes", room);
        e->text = larger;
        e->room = room;
    }
    memcpy(e->text + e->size, text, length);
    e->size += length;
    e->text[e->size] = 0;
    return ISO_OK;
}

static iso_status append_line_number(expansion *e, int line, int file, iso_error *err)
{
    char text[48];
    int length = snprintf(text, sizeof text, "#line %d %d\n", line, file);
    return append(e, text, (size_t)length, err);
}

/* Replaces each line #include "NAME" by that file: GLSL has no includes of its own. */
static iso_status expand(const iso_gl *gl, const char *name, int depth, expansion *e, iso_error *err)
{
    enum { deepest = 8 };
    const char *text;
    FREED char *owned = NULL;
    NEED(shader_text(gl, name, &text, &owned, err));
    const int file = ++e->files;
    if (depth > deepest)
        return iso_fail(err, ISO_E_PROGRAM, "gl: shader %s is included from itself", name);
    NEED(append_line_number(e, 1, file, err));
    int line = 1;
    for (const char *at = text; *at; ++line) {
        const char *newline = strchr(at, '\n');
        size_t length = newline ? (size_t)(newline - at) + 1 : strlen(at);
        char included[64];
        if (sscanf(at, "#include \"%63[^\"\n]\"", included) == 1) {
            NEED(expand(gl, included, depth + 1, e, err));
            NEED(append_line_number(e, line + 1, file, err));
        } else {
            NEED(append(e, at, length, err));
        }
        at += length;
    }
    return append(e, "\n", 1, err);
}

static iso_status build_program(iso_gl *gl, const char *fragment, const char *defines, GLuint *program, iso_error *err)
{
    static const char version[] = "#version 430 core\n";
    expansion vertex = {0}, body = {0};
    GLuint shaders[2] = {0, 0};
    iso_status status = expand(gl, "fullscreen.glsl", 0, &vertex, err);
    TRY(status, expand(gl, "code_decode.h", 0, &body, err));
    TRY(status, expand(gl, fragment, 0, &body, err));
    if (status == ISO_OK)
        status = compile(GL_VERTEX_SHADER, (const char *[]){version, vertex.text}, 2, "fullscreen.glsl", &shaders[0],
                         err);
    if (status == ISO_OK)
        status = compile(GL_FRAGMENT_SHADER, (const char *[]){version, defines, body.text}, 3, fragment, &shaders[1],
                         err);
    TRY(status, link_program(shaders[0], shaders[1], fragment, program, err));
    for (int i = 0; i < 2; ++i)
        if (shaders[i] && (i == 0 || status == ISO_OK))
            glDeleteShader(shaders[i]);
    free(vertex.text);
    free(body.text);
    return status;
}

iso_status iso_gl_get_program(iso_gl *gl, const char *fragment, const char *defines, GLuint *program, iso_error *err)
{
    size_t size = strlen(fragment) + strlen(defines) + 2;
    char *key = malloc(size);
    NEED_MEMORY(key, err, "gl: no memory for a program's name");
    snprintf(key, size, "%s\n%s", fragment, defines);
    for (size_t i = 0; i < gl->program_count; ++i)
        if (strcmp(gl->programs[i].key, key) == 0) {
            *program = gl->programs[i].name;
            free(key);
            return ISO_OK;
        }
    iso_status status = gl->program_count < ISO_GL_MAX_PROGRAMS
                            ? build_program(gl, fragment, defines, program, err)
                            : iso_fail(err, ISO_E_RANGE, "gl: more than %d programs in one context",
                                       ISO_GL_MAX_PROGRAMS);
    if (status == ISO_OK)
        gl->programs[gl->program_count++] = (struct iso_gl_program){key, *program};
    else
        free(key);
    return status;
}
