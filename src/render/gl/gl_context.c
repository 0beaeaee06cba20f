/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "render/gl/gl_context.h"

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

/* ---- gl devices ---- */

/* The devices that EGL lists, and the choice of one.
 *
 * Without a choice: each device except software renderers, then the platform without a surface. A choice is a device's
 * number, a part of its OpenGL vendor or renderer name (ignoring case), or "surfaceless"; a choice has no fallback. */

/* Reports missing libraries as ISO_E_MISSING: without this check, epoxy would end the program. */
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

enum { MOST_DEVICES = 16 };

/* Devices tried so far, and the wanted one. */
typedef struct trial {
    const char *choice; /* NULL: the first that is not a software renderer */
    char tried[768];
} trial;

static void note(trial *t, const char *name, const char *why)
{
    const size_t used = strlen(t->tried);
    snprintf(t->tried + used, sizeof t->tried - used, "%s%s: %s", used ? "; " : "", name, why);
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

static bool is_number(const char *text)
{
    return text && *text && text[strspn(text, "0123456789")] == '\0';
}

/* True if the name of the current context matches the choice. */
static bool is_called(const char *choice)
{
    const char *const texts[] = {(const char *)glGetString(GL_VENDOR), (const char *)glGetString(GL_RENDERER)};
    for (size_t i = 0; i < 2; ++i)
        if (texts[i] && strcasestr(texts[i], choice))
            return true;
    return false;
}

/* Creates a current core 4.3 context on this display. False: the reason is noted. by_name: only a device of the chosen
 * name. */
static bool open_display(iso_gl *gl, EGLDisplay display, const char *name, bool by_name, trial *t)
{
    static const EGLint attributes[] = {
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL) || !eglBindAPI(EGL_OPENGL_API)) {
        note(t, name, display == EGL_NO_DISPLAY ? "no display" : egl_error_text());
        return false;
    }
    EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    const bool current = context != EGL_NO_CONTEXT && eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context);
    if (!current || (by_name && !is_called(t->choice))) {
        const char *renderer = current ? (const char *)glGetString(GL_RENDERER) : egl_error_text();
        note(t, name, renderer ? renderer : "unknown");
        if (current)
            eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (context != EGL_NO_CONTEXT)
            eglDestroyContext(display, context);
        return false;
    }
    gl->display = display;
    gl->context = context;
    snprintf(gl->info.device, sizeof gl->info.device, "%s", name);
    return true;
}

static bool has(const char *extension)
{
    return epoxy_has_egl_extension(EGL_NO_DISPLAY, extension);
}

/* Lists the devices. EGL_EXT_device_base is enumeration and query in one: Mesa names all three, NVIDIA's driver only
 * that one. */
static bool list(EGLDeviceEXT devices[MOST_DEVICES], EGLint *count)
{
    *count = 0;
    if (find_libraries(NULL) != ISO_OK)
        return false;
    const bool lists = has("EGL_EXT_device_base") || has("EGL_EXT_device_enumeration");
    return lists && has("EGL_EXT_platform_device") && eglQueryDevicesEXT(MOST_DEVICES, devices, count);
}

static bool is_software(EGLDeviceEXT device)
{
    const char *extensions = eglQueryDeviceStringEXT(device, EGL_EXTENSIONS);
    return extensions && strstr(extensions, "EGL_MESA_device_software");
}

/* Opens the first usable device. Devices that Mesa emulates are left to the surfaceless platform, unless chosen. */
static bool open_devices(iso_gl *gl, trial *t)
{
    EGLDeviceEXT devices[MOST_DEVICES];
    EGLint count = 0;
    const bool numbered = is_number(t->choice);
    const long wanted = numbered ? strtol(t->choice, NULL, 10) : -1;
    if (!list(devices, &count)) {
        note(t, "EGL devices", "cannot be listed");
        return false;
    }
    for (EGLint i = 0; i < count; ++i) {
        char name[32];
        if (t->choice ? numbered && i != wanted : is_software(devices[i]))
            continue;
        snprintf(name, sizeof name, "EGL device %d", (int)i);
        if (open_display(gl, eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL), name,
                         t->choice && !numbered, t))
            return true;
    }
    if (numbered && wanted >= count) {
        char why[48];
        snprintf(why, sizeof why, "there are %d, from 0 on", (int)count);
        note(t, "EGL devices", why);
    }
    return false;
}

static bool open_surfaceless(iso_gl *gl, bool by_name, trial *t)
{
    static const char name[] = "without a surface";
    if (!has("EGL_MESA_platform_surfaceless")) {
        note(t, name, "no such platform (Debian package libegl-mesa0)");
        return false;
    }
    return open_display(gl, eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL), name,
                        by_name, t);
}

/* Makes gl->display and gl->context, current on this thread, and fills gl->info.device. choice: NULL or "": none.
 * ISO_E_MISSING lists the devices tried, with reasons. */
static iso_status gl_open(iso_gl *gl, const char *choice, iso_error *err)
{
    trial t = {.choice = choice && *choice ? choice : NULL};
    const bool surfaceless = t.choice && strcmp(t.choice, "surfaceless") == 0;
    if (!surfaceless && open_devices(gl, &t))
        return ISO_OK;
    if (!is_number(t.choice) && open_surfaceless(gl, t.choice && !surfaceless, &t))
        return ISO_OK;
    if (!t.choice)
        return iso_fail(err, ISO_E_MISSING, "gl: no OpenGL 4.3 context by EGL (%s)", t.tried);
    return iso_fail(err, ISO_E_MISSING, "gl: no device \"%s\" with OpenGL 4.3 (%s); isoshade list --gl has them",
                    t.choice, t.tried);
}

size_t iso_gl_device_count(void)
{
    EGLDeviceEXT devices[MOST_DEVICES];
    EGLint count = 0;
    list(devices, &count);
    return (size_t)count;
}

bool iso_gl_is_software(void)
{
    EGLDeviceEXT devices[MOST_DEVICES];
    EGLint count = 0;
    const char *choice = getenv(ISO_GL_DEVICE_VARIABLE);
    if (choice && *choice)
        return false;
    list(devices, &count);
    for (EGLint i = 0; i < count; ++i)
        if (!is_software(devices[i]))
            return false;
    return true;
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
    NEED(find_libraries(err));
    iso_gl *gl = calloc(1, sizeof *gl);
    if (!gl || (shader_dir && !(gl->shader_dir = strdup(shader_dir)))) {
        free(gl);
        return iso_fail(err, ISO_E_MEMORY, "gl: no memory for a context");
    }
    /* llvmpipe filters 8-bit textures in 8 bits unless told otherwise before it starts. */
    setenv("GALLIVM_PERF", "no_aos_sampling", 0);
    iso_status status = gl_open(gl, device, err);
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
