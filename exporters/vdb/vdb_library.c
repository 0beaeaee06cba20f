/* SPDX-License-Identifier: MIT */
/* vdb_library.c - OpenVDB is loaded when it is needed first. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/beside.h"
#include "vdb/vdb_file.h"

static const char file_name[] = "isoshade_openvdb.so";
static pthread_once_t once = PTHREAD_ONCE_INIT;
static const iso_openvdb *loaded;
static char why[sizeof((iso_error *)0)->text]; /* where it cannot be loaded */

/* In a program that the archive is linked into with -u iso_openvdb_functions, as the .pc file says: its own. */
extern const iso_openvdb iso_openvdb_functions __attribute__((weak));

/* It stays until the program ends: OpenVDB leaves threads behind. */
static void load(void)
{
    loaded = &iso_openvdb_functions;
    if (loaded)
        return;
    char *path = iso_beside_find(file_name);
    void *library = path ? dlopen(path, RTLD_NOW | RTLD_LOCAL) : NULL;
    loaded = library ? dlsym(library, ISO_OPENVDB_SYMBOL) : NULL;
    if (!loaded) {
        const char *reason = path ? dlerror() : NULL;
        strncpy(why, reason ? reason : "it does not lie beside the program", sizeof why - 1);
    }
    free(path);
}

const iso_openvdb *iso_vdb_library(const char *path, iso_error *err)
{
    pthread_once(&once, load);
    if (!loaded)
        iso_fail(err, ISO_E_MISSING, "%s: %s, which knows OpenVDB, cannot be loaded: %s", path, file_name, why);
    return loaded;
}
