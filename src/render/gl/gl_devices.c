/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE

#include "render/gl/gl_devices.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
    if (iso_gl_find_libraries(NULL) != ISO_OK)
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

iso_status iso_gl_open(iso_gl *gl, const char *choice, iso_error *err)
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
