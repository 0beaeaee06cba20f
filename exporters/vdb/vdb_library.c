/* SPDX-License-Identifier: MIT */
/* vdb_library.c - loads OpenVDB on first use. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/helper.h"
#include "vdb/vdb_file.h"

static const char file_name[] = "isoshade_openvdb.so";
static const char missing[] =
    "built without OpenVDB; install the Debian packages libopenvdb-dev and libnanovdb-dev, and build again";
static pthread_once_t once = PTHREAD_ONCE_INIT;
static const iso_openvdb *loaded;
static char why[sizeof((iso_error *)0)->text]; /* reason why it cannot be loaded */

/* Defined if the archive is linked with -u iso_openvdb_functions, as the .pc file does. */
extern const iso_openvdb iso_openvdb_functions __attribute__((weak));

/* Loads it until the program ends, as OpenVDB's threads outlive the calls. */
static void load(void)
{
    loaded = &iso_openvdb_functions;
    if (loaded)
        return;
    FREED char *path = iso_helper_find(file_name);
    void *library = path ? dlopen(path, RTLD_NOW | RTLD_LOCAL) : NULL;
    loaded = library ? dlsym(library, ISO_OPENVDB_SYMBOL) : NULL;
    if (!loaded) {
        const char *reason = path ? dlerror() : NULL;
        strncpy(why, reason ? reason : missing, sizeof why - 1);
    }
}

const iso_openvdb *iso_vdb_library(const char *path, iso_error *err)
{
    pthread_once(&once, load);
    if (!loaded)
        iso_fail(err, ISO_E_MISSING, "%s: cannot load %s, which reads and writes OpenVDB: %s", path, file_name, why);
    return loaded;
}
