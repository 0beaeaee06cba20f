/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L

#include "render/gl/gl_context.h"

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/parallel.h"

ISO_EMBED(iso_code_decode_glsl, "src/encode/code_decode.h");
ISO_EMBED(iso_warp_map_glsl, "src/brick/warp_map.h");
ISO_EMBED(iso_transition_glsl, "src/render/gl/shaders/transition.glsl");
ISO_EMBED(iso_points_glsl, "src/render/gl/shaders/points.glsl");
ISO_EMBED(iso_first_hit_glsl, "src/render/gl/shaders/first_hit.glsl");
ISO_EMBED(iso_roi_glsl, "src/render/gl/shaders/roi.glsl");
ISO_EMBED(iso_raycast_glsl, "src/render/gl/shaders/raycast.glsl");
ISO_EMBED(iso_probe_glsl, "src/render/gl/shaders/probe.glsl");
ISO_EMBED(iso_fullscreen_glsl, "src/render/gl/shaders/fullscreen.glsl");

static const struct {
    const char *name, *text;
} shader_files[] = {
    {"code_decode.h", iso_code_decode_glsl},
    {"first_hit.glsl", iso_first_hit_glsl},
    {"roi.glsl", iso_roi_glsl},
    {"fullscreen.glsl", iso_fullscreen_glsl},
    {"points.glsl", iso_points_glsl},
    {"probe.glsl", iso_probe_glsl},
    {"raycast.glsl", iso_raycast_glsl},
    {"transition.glsl", iso_transition_glsl},
    {"warp_map.h", iso_warp_map_glsl},
};

/* ---- context --------------------------------------------------------------- */

/* epoxy ends the program when a library is missing, so look first. */
static iso_status find_libraries(iso_error *err)
{
    static const char *const libraries[][2] = {{"libEGL.so.1", "libegl1"}, {"libGL.so.1", "libgl1"}};
    for (size_t i = 0; i < 2; ++i) {
        void *handle = dlopen(libraries[i][0], RTLD_LAZY | RTLD_LOCAL);
        if (!handle)
            return iso_fail(err, ISO_E_MISSING, "gl: %s is not there (Debian package %s)", libraries[i][0],
                            libraries[i][1]);
        dlclose(handle);
    }
    return ISO_OK;
}

/* Appends "name: why; " to what was tried. */
static void note_trial(char *tried, size_t size, const char *name, const char *why)
{
    size_t used = strlen(tried);
    snprintf(tried + used, size - used, "%s%s: %s", used ? "; " : "", name, why);
}

static const char *egl_error_text(void)
{
    switch (eglGetError()) {
    case EGL_NOT_INITIALIZED: return "not initialized";
    case EGL_BAD_ACCESS: return "access denied";
    case EGL_BAD_ALLOC: return "out of memory";
    case EGL_BAD_MATCH: return "no core profile 4.3";
    case EGL_BAD_CONFIG: return "no context without a config";
    default: return "refused";
    }
}

/* A current core 4.3 context on this display, or false with the reason noted. */
static bool open_display(iso_gl *gl, EGLDisplay display, const char *name, char *tried, size_t tried_size)
{
    static const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 3,
                                        EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                        EGL_NONE};
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL) || !eglBindAPI(EGL_OPENGL_API)) {
        note_trial(tried, tried_size, name, display == EGL_NO_DISPLAY ? "no display" : egl_error_text());
        return false;
    }
    EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (context == EGL_NO_CONTEXT || !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
        note_trial(tried, tried_size, name, egl_error_text());
        if (context != EGL_NO_CONTEXT)
            eglDestroyContext(display, context);
        return false;
    }
    gl->display = display;
    gl->context = context;
    return true;
}

/* A device that Mesa emulates is left to the surfaceless platform. */
static bool open_devices(iso_gl *gl, char *tried, size_t tried_size)
{
    EGLDeviceEXT devices[16];
    EGLint count = 0;
    if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") ||
        !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device") ||
        !eglQueryDevicesEXT(16, devices, &count)) {
        note_trial(tried, tried_size, "EGL devices", "cannot be listed");
        return false;
    }
    for (EGLint i = 0; i < count; ++i) {
        const char *extensions = eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS);
        if (extensions && strstr(extensions, "EGL_MESA_device_software"))
            continue;
        char name[32];
        snprintf(name, sizeof name, "EGL device %d", (int)i);
        if (open_display(gl, eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL), name, tried,
                         tried_size))
            return true;
    }
    return false;
}

static bool open_surfaceless(iso_gl *gl, char *tried, size_t tried_size)
{
    if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
        note_trial(tried, tried_size, "Mesa without a surface", "no such platform (Debian package libegl-mesa0)");
        return false;
    }
    return open_display(gl, eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL),
                        "Mesa without a surface", tried, tried_size);
}

/* ---- filter probe ---------------------------------------------------------- */

enum { PROBE_COUNT = 1021 }; /* prime: its fractions fall on no power of two */

/* Bits that linear filtering between a texel 0 and a texel 1 keeps: an error of
 * at most 2^-(b+1) is b bits, rounded to nearest. 23: all that a float has. */
static iso_status probe_filter(iso_gl *gl, GLenum format, int *bits, iso_error *err)
{
    static const size_t size[3] = {2, 1, 1};
    static const float texels[2] = {0, 1};
    float result[4 * PROBE_COUNT];
    GLuint program, texture;
    iso_status status = iso_gl_get_program(gl, "probe.glsl", "", &program, err);
    if (status == ISO_OK)
        status = iso_gl_create_texture_3d(gl, format, size, "filter probe", &texture, err);
    if (status != ISO_OK)
        return status;
    glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, 2, 1, 1, GL_RED, GL_FLOAT, texels);
    glUseProgram(program);
    glUniform1i(glGetUniformLocation(program, "texels"), 0);
    glUniform1f(glGetUniformLocation(program, "count"), PROBE_COUNT);
    status = iso_gl_draw(gl, program, PROBE_COUNT, 1, result, NULL, err);
    glDeleteTextures(1, &texture);
    double worst = ldexp(1, -24);
    for (int i = 0; i < PROBE_COUNT; ++i)
        worst = fmax(worst, fabs((double)result[4 * i] - (i + 0.5) / PROBE_COUNT));
    *bits = (int)lround(-log2(worst)) - 1;
    return status;
}

static iso_status describe(iso_gl *gl, iso_error *err)
{
    const struct {
        GLenum name;
        char *out;
    } texts[] = {{GL_VENDOR, gl->info.vendor}, {GL_RENDERER, gl->info.renderer}, {GL_VERSION, gl->info.version}};
    for (size_t i = 0; i < 3; ++i) {
        const char *text = (const char *)glGetString(texts[i].name);
        snprintf(texts[i].out, sizeof gl->info.vendor, "%s", text ? text : "unknown");
    }
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &gl->max_texture_size);
    glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &gl->max_texture_3d_size);
    iso_status status = probe_filter(gl, GL_R8, &gl->info.filter_bits_unorm8, err);
    int snorm = 0;
    if (status == ISO_OK)
        status = probe_filter(gl, GL_R8_SNORM, &snorm, err);
    if (snorm < gl->info.filter_bits_unorm8)
        gl->info.filter_bits_unorm8 = snorm;
    if (status == ISO_OK)
        status = probe_filter(gl, GL_R16, &gl->info.filter_bits_unorm16, err);
    if (status == ISO_OK)
        status = probe_filter(gl, GL_R32F, &gl->info.filter_bits_float, err);
    return status;
}

/* ---- life ------------------------------------------------------------------ */

iso_status iso_gl_create(iso_gl **out, const char *shader_dir, iso_error *err)
{
    char tried[512] = "";
    *out = NULL;
    iso_status status = find_libraries(err);
    if (status != ISO_OK)
        return status;
    iso_gl *gl = calloc(1, sizeof *gl);
    if (!gl || (shader_dir && !(gl->shader_dir = strdup(shader_dir)))) {
        free(gl);
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for a context");
    }
    /* llvmpipe filters 8-bit textures in 8 bits unless told otherwise before it starts. */
    setenv("GALLIVM_PERF", "no_aos_sampling", 0);
    if (!open_devices(gl, tried, sizeof tried) && !open_surfaceless(gl, tried, sizeof tried))
        status = iso_fail(err, ISO_E_MISSING, "gl: no OpenGL 4.3 context by EGL (%s)", tried);
    if (status == ISO_OK && epoxy_gl_version() < 43)
        status = iso_fail(err, ISO_E_MISSING, "gl: OpenGL %d.%d, at least 4.3 is needed", epoxy_gl_version() / 10,
                          epoxy_gl_version() % 10);
    if (status == ISO_OK) {
        glGenVertexArrays(1, &gl->vertex_array);
        status = describe(gl, err);
    }
    if (status != ISO_OK) {
        iso_gl_destroy(gl);
        return status;
    }
    *out = gl;
    return ISO_OK;
}

/* The display is not terminated: another iso_gl of the process may stand on it. */
void iso_gl_destroy(iso_gl *gl)
{
    if (!gl)
        return;
    if (gl->context) {
        if (eglMakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, gl->context)) {
            for (size_t i = 0; i < gl->program_count; ++i)
                glDeleteProgram(gl->programs[i].name);
            glDeleteVertexArrays(1, &gl->vertex_array);
            eglMakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        }
        eglDestroyContext(gl->display, gl->context);
        eglReleaseThread();
    }
    for (size_t i = 0; i < gl->program_count; ++i)
        free(gl->programs[i].key);
    free(gl->shader_dir);
    free(gl);
}

iso_gl_info iso_gl_describe(const iso_gl *gl) { return gl->info; }

void iso_gl_time_processor(iso_gl *gl, bool processor) { gl->times_processor = processor; }

iso_status iso_gl_bind(iso_gl *gl, iso_error *err)
{
    if (!eglBindAPI(EGL_OPENGL_API) || !eglMakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, gl->context))
        return iso_fail(err, ISO_E_PROGRAM, "gl: the context cannot be made current: %s", egl_error_text());
    return ISO_OK;
}

iso_status iso_gl_check(const char *what, iso_error *err)
{
    GLenum error = glGetError();
    if (error == GL_NO_ERROR)
        return ISO_OK;
    while (glGetError() != GL_NO_ERROR)
        continue;
    if (error == GL_OUT_OF_MEMORY)
        return iso_fail(err, ISO_E_MEMORY, "gl: %s: out of memory", what);
    return iso_fail(err, ISO_E_PROGRAM, "gl: %s: OpenGL error 0x%04x", what, error);
}

/* ---- programs -------------------------------------------------------------- */

/* The text of a shader file: from the shader folder when one is named, else the
 * embedded one. *owned is to be freed. */
static iso_status shader_text(const iso_gl *gl, const char *name, const char **text, char **owned, iso_error *err)
{
    *owned = NULL;
    *text = NULL;
    for (size_t i = 0; i < sizeof shader_files / sizeof *shader_files; ++i)
        if (strcmp(shader_files[i].name, name) == 0)
            *text = shader_files[i].text;
    if (!gl->shader_dir)
        return *text ? ISO_OK : iso_fail(err, ISO_E_MISSING, "gl: no shader is named '%s'", name);
    char *path = iso_path_join(gl->shader_dir, name);
    if (!path)
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for a path");
    iso_status status = ISO_OK;
    /* Headers that C shares belong to their modules, not to the shaders: they need not be in the folder. */
    if (iso_path_exists(path) || !iso_path_ends_with(name, ".h")) {
        size_t size;
        status = iso_file_read(path, owned, &size, err);
        *text = *owned;
    }
    free(path);
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
        if (!larger)
            return iso_fail(err, ISO_E_MEMORY, "gl: no memory for a shader of %zu bytes", room);
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

/* Lines #include "NAME" are replaced by that file. GLSL has no includes of its own. */
static iso_status expand(const iso_gl *gl, const char *name, int depth, expansion *e, iso_error *err)
{
    enum { deepest = 8 };
    const char *text;
    char *owned;
    iso_status status = shader_text(gl, name, &text, &owned, err);
    const int file = ++e->files;
    if (status == ISO_OK && depth > deepest)
        status = iso_fail(err, ISO_E_PROGRAM, "gl: shader %s is included from itself", name);
    if (status == ISO_OK)
        status = append_line_number(e, 1, file, err);
    int line = 1;
    for (const char *at = text; status == ISO_OK && *at; ++line) {
        const char *newline = strchr(at, '\n');
        size_t length = newline ? (size_t)(newline - at) + 1 : strlen(at);
        char included[64];
        if (sscanf(at, "#include \"%63[^\"\n]\"", included) == 1) {
            status = expand(gl, included, depth + 1, e, err);
            if (status == ISO_OK)
                status = append_line_number(e, line + 1, file, err);
        } else {
            status = append(e, at, length, err);
        }
        at += length;
    }
    free(owned);
    return status == ISO_OK ? append(e, "\n", 1, err) : status;
}

static iso_status build_program(iso_gl *gl, const char *fragment, const char *defines, GLuint *program, iso_error *err)
{
    static const char version[] = "#version 430 core\n";
    expansion vertex = {0}, body = {0};
    GLuint shaders[2] = {0, 0};
    iso_status status = expand(gl, "fullscreen.glsl", 0, &vertex, err);
    if (status == ISO_OK)
        status = expand(gl, "code_decode.h", 0, &body, err);
    if (status == ISO_OK)
        status = expand(gl, fragment, 0, &body, err);
    if (status == ISO_OK)
        status = compile(GL_VERTEX_SHADER, (const char *[]){version, vertex.text}, 2, "fullscreen.glsl", &shaders[0], err);
    if (status == ISO_OK)
        status = compile(GL_FRAGMENT_SHADER, (const char *[]){version, defines, body.text}, 3, fragment, &shaders[1], err);
    if (status == ISO_OK)
        status = link_program(shaders[0], shaders[1], fragment, program, err);
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
    if (!key)
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for a program's name");
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

/* ---- textures and drawing --------------------------------------------------- */

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
    iso_status status = iso_gl_create_texture_3d(gl, GL_R8UI, count, "brick occupancy", texture, err);
    if (status != ISO_OK)
        return status;
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, (GLsizei)count[0], (GLsizei)count[1], (GLsizei)count[2],
                    GL_RED_INTEGER, GL_UNSIGNED_BYTE, distance);
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

iso_status iso_gl_draw(iso_gl *gl, GLuint program, size_t width, size_t height, float *rgba, double *seconds,
                       iso_error *err)
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
        double start = clock();
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glFinish();
        if (seconds)
            *seconds = clock() - start;
        glReadPixels(0, 0, (GLsizei)width, (GLsizei)height, GL_RGBA, GL_FLOAT, rgba);
        status = iso_gl_check("drawing", err);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDeleteFramebuffers(1, &frame);
    glDeleteTextures(1, &target);
    return status;
}

iso_status iso_gl_draw_repeatedly(iso_gl *gl, GLuint program, size_t repeats, double repeat_seconds, iso_image *image,
                                  double *least, iso_gl_stats *stats, iso_error *err)
{
    float pixel[4];
    double sum = 0, best = INFINITY;
    iso_status status = repeat_seconds > 0 ? iso_gl_draw(gl, program, 1, 1, pixel, NULL, err) : ISO_OK;
    for (size_t i = 0; status == ISO_OK && i < (repeats ? repeats : 1) && (i == 0 || !(repeat_seconds > 0) || sum < repeat_seconds); ++i) {
        double once = 0;
        status = iso_gl_draw(gl, program, image->width, image->height, image->rgba, &once, err);
        best = fmin(best, once);
        sum += once;
        if (stats->draw_count < ISO_GL_MAX_DRAWS)
            stats->draw_seconds[stats->draw_count++] = once;
    }
    if (least)
        *least = best;
    return status;
}

double iso_gl_texture_bytes(GLenum target, GLuint texture)
{
    static const GLenum sizes[] = {GL_TEXTURE_WIDTH, GL_TEXTURE_HEIGHT, GL_TEXTURE_DEPTH};
    static const GLenum channels[] = {GL_TEXTURE_RED_SIZE, GL_TEXTURE_GREEN_SIZE, GL_TEXTURE_BLUE_SIZE, GL_TEXTURE_ALPHA_SIZE};
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
