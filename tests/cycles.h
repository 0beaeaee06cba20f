/* SPDX-License-Identifier: MIT */
/* cycles.h - for tests of Cycles: a Blender that is built without volumes for it is no fault of ours. */
#pragma once

#include <stdbool.h>
#include <string.h>

#include "blender/blender.h"
#include "test.h"

/* False where the Blender found has no NanoVDB. One that is missing is a failure: the tests need one. */
static inline bool cycles_shows_volumes(void)
{
    iso_cycles_about about;
    iso_error err = {""};
    if (iso_cycles_ask(NULL, &about, &err) != ISO_E_MISSING ||
        !strstr(err.text, "built without NanoVDB"))
        return true;
    print_message("%s\n", err.text);
    return false;
}

/* Skips the test that calls it, with the reason. Call it before anything is allocated. Asks once: Blender starts. */
static inline void need_cycles(void)
{
    static enum { UNKNOWN, MISSING, THERE } state;
    if (state == UNKNOWN)
        state = cycles_shows_volumes() ? THERE : MISSING;
    if (state == MISSING)
        skip();
}
