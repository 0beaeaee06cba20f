/* SPDX-License-Identifier: MIT */
/* no_gl.c - the interface of the ray caster without OpenGL: built instead of render/gl if libepoxy-dev is missing. No
 * context can be created, so no other function gets one. */
#include <math.h>

#include "render/gl/bricks_gl.h"
#include "render/gl/raycaster.h"

#pragma GCC diagnostic ignored "-Wunused-parameter" /* no function needs its arguments */

static iso_status refuse(iso_error *err)
{
    return iso_fail(err, ISO_E_MISSING,
                    "gl: built without OpenGL; install the Debian packages libepoxy-dev, libegl-dev and "
                    "libgl1-mesa-dri, and build again");
}

size_t iso_gl_device_count(void)
{
    return 0;
}

/* The CPU ray caster takes the place of software renderers. */
bool iso_gl_is_software(void)
{
    return true;
}

iso_status iso_gl_create(iso_gl **gl, const char *shader_dir, iso_error *err)
{
    *gl = NULL;
    return refuse(err);
}

iso_status iso_gl_create_on(iso_gl **gl, const char *device, const char *shader_dir, iso_error *err)
{
    return iso_gl_create(gl, shader_dir, err);
}

void iso_gl_destroy(iso_gl *gl)
{
}

iso_gl_info iso_gl_describe(const iso_gl *gl)
{
    static const iso_gl_info none;
    return none;
}

double iso_gl_device_seconds(const iso_gl *gl)
{
    return NAN;
}

void iso_gl_time_processor(iso_gl *gl, bool processor)
{
}

iso_gl_options iso_gl_defaults(void)
{
    return (iso_gl_options){0};
}

iso_status iso_gl_render(iso_gl *gl, const iso_level *level, iso_code code, const iso_view *view,
                         const iso_gl_options *opt, iso_image *image, iso_error *err)
{
    return refuse(err);
}

iso_gl_brick_options iso_gl_brick_defaults(void)
{
    return (iso_gl_brick_options){0};
}

iso_status iso_gl_render_bricks(iso_gl *gl, const iso_brick_field *field, const iso_view *view,
                                const iso_gl_brick_options *opt, iso_image *image, iso_gl_brick_stats *stats,
                                iso_error *err)
{
    return refuse(err);
}
