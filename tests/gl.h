/* SPDX-License-Identifier: MIT */
/* gl.h - one OpenGL context for all tests of a program: it takes a while to start. */
#pragma once

#include "render/gl/raycaster.h"

static iso_gl *gl;

static int open_gl(void **state)
{
    (void)state;
    iso_error err = {""};
    if (iso_gl_create(&gl, NULL, &err) == ISO_OK)
        return 0;
    print_error("%s\n", err.text);
    return -1;
}

static int close_gl(void **state)
{
    (void)state;
    iso_gl_destroy(gl);
    return 0;
}
