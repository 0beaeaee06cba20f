/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L

#include "render/gl/gl_devices.h"

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

/* ---- context --------------------------------------------------------------- */

iso_status iso_gl_find_libraries(iso_error *err)
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

/* ---- filter probe ---------------------------------------------------------- */

enum { PROBE_COUNT = 1021 }; /* prime: its fractions fall on no power of two */

/* Measures the bits that linear filtering keeps between a texel 0 and a texel 1: an error of at most 2^-(b+1) is b
 * bits, rounded to nearest. 23 is all that a float has. */
static iso_status probe_filter(iso_gl *gl, GLenum format, int *bits, iso_error *err)
{
    static const size_t size[3] = {2, 1, 1};
    static const float texels[2] = {0, 1};
    float result[4 * PROBE_COUNT];
    GLuint program, texture;
    NEED(iso_gl_get_program(gl, "probe.glsl", "", &program, err));
    NEED(iso_gl_create_texture_3d(gl, format, size, "filter probe", &texture, err));
    glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, 2, 1, 1, GL_RED, GL_FLOAT, texels);
    glUseProgram(program);
    glUniform1i(glGetUniformLocation(program, "texels"), 0);
    glUniform1f(glGetUniformLocation(program, "count"), PROBE_COUNT);
    iso_status status = iso_gl_draw(gl, program, PROBE_COUNT, 1, (iso_gl_cover){0}, result, NULL, err);
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
    gl->is_llvmpipe = strstr(gl->info.renderer, "llvmpipe") != NULL;
    gl->band_samples = gl->is_llvmpipe ? 4e6 * iso_threads(0) : 1e8; /* a slow GPU takes 1e9 per second */
    glGetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &gl->info.timer_bits);
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &gl->max_texture_size);
    glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &gl->max_texture_3d_size);
    iso_status status = probe_filter(gl, GL_R8, &gl->info.filter_bits_unorm8, err);
    int snorm = 0;
    TRY(status, probe_filter(gl, GL_R8_SNORM, &snorm, err));
    if (snorm < gl->info.filter_bits_unorm8)
        gl->info.filter_bits_unorm8 = snorm;
    TRY(status, probe_filter(gl, GL_R16, &gl->info.filter_bits_unorm16, err));
    TRY(status, probe_filter(gl, GL_R32F, &gl->info.filter_bits_float, err));
    return status;
}

/* ---- life ------------------------------------------------------------------ */

iso_status iso_gl_create(iso_gl **out, const char *shader_dir, iso_error *err)
{
    return iso_gl_create_on(out, getenv(ISO_GL_DEVICE_VARIABLE), shader_dir, err);
}

iso_status iso_gl_create_on(iso_gl **out, const char *device, const char *shader_dir, iso_error *err)
{
    *out = NULL;
    NEED(iso_gl_find_libraries(err));
    iso_gl *gl = calloc(1, sizeof *gl);
    if (!gl || (shader_dir && !(gl->shader_dir = strdup(shader_dir)))) {
        free(gl);
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for a context");
    }
    /* llvmpipe filters 8-bit textures in 8 bits unless told otherwise before it starts. */
    setenv("GALLIVM_PERF", "no_aos_sampling", 0);
    iso_status status = iso_gl_open(gl, device, err);
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

/* Destroys the context, not the display: another iso_gl of the process may use it. */
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

iso_gl_info iso_gl_describe(const iso_gl *gl)
{
    return gl->info;
}

bool iso_gl_filters_by_hand(const iso_gl *gl, bool fast_filter)
{
    return gl->info.filter_bits_float < ISO_GL_FINE_FILTER_BITS && !fast_filter;
}

double iso_gl_device_seconds(const iso_gl *gl)
{
    return gl->device_seconds;
}

void iso_gl_time_processor(iso_gl *gl, bool processor)
{
    gl->times_processor = processor;
}

iso_status iso_gl_bind(iso_gl *gl, iso_error *err)
{
    if (!eglBindAPI(EGL_OPENGL_API) || !eglMakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, gl->context))
        return iso_fail(err, ISO_E_PROGRAM, "gl: the context cannot be made current (EGL error 0x%04x)",
                        (unsigned)eglGetError());
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
