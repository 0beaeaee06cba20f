/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/helper.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <unistd.h>

#include "base/file.h"

/* Finds the file near the folder of `file`. NULL if no candidate exists. */
static char *find_near(const char *file, const char *name)
{
    static const char *const places[] = {".", ISO_LIBDIR, "isoshade", ".."};
    char *found = NULL;
    FREED char *dir = iso_path_dir(file);
    for (size_t i = 0; dir && i < sizeof places / sizeof *places && !found; ++i) {
        FREED char *folder = iso_path_join(dir, places[i]);
        found = folder ? iso_path_join(folder, name) : NULL;
        if (found && access(found, R_OK) != 0) {
            free(found);
            found = NULL;
        }
    }
    return found;
}

char *iso_helper_find(const char *name)
{
    char program[4096];
    const ssize_t n = readlink("/proc/self/exe", program, sizeof program - 1);
    program[n > 0 ? n : 0] = 0;
    char *found = find_near(program, name);
    Dl_info here; /* the shared library, in another program */
    if (!found && dladdr((void *)(size_t)iso_helper_find, &here) && here.dli_fname)
        found = find_near(here.dli_fname, name);
    return found;
}
