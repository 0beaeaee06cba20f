/* SPDX-License-Identifier: MIT */
/* device.c - finds Blender, and the device of its Cycles. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/process.h"
#include "blender/blender_scene.h"

/* ---- devices ---- */

static const struct {
    const char *name, *summary;
} devices[] = {
    {"cpu", "the processor"},
    {"gpu", "the first available one of the following"},
    {"optix", "NVIDIA GPUs, with OptiX"},
    {"cuda", "NVIDIA GPUs, with CUDA"},
    {"hip", "AMD GPUs"},
    {"oneapi", "Intel GPUs"},
    {"metal", "Apple GPUs"},
};
const iso_names iso_cycles_device_names = ISO_NAMES_OF_ROWS_CALLED("device of Cycles", "devices of Cycles", devices);

static const char *chosen_device; /* name of a row, from iso_cycles_set_device() */

static iso_status find_device(const char *name, const char **row, iso_error *err)
{
    size_t i;
    NEED(iso_names_find(&iso_cycles_device_names, name, &i, err));
    *row = devices[i].name;
    return ISO_OK;
}

iso_status iso_cycles_set_device(const char *name, iso_error *err)
{
    chosen_device = NULL;
    return name ? find_device(name, &chosen_device, err) : ISO_OK;
}

iso_status iso_cycles_device(const char **name, iso_error *err)
{
    const char *asked = getenv("ISOSHADE_CYCLES_DEVICE");
    *name = chosen_device ? chosen_device : devices[0].name;
    return chosen_device || !asked || !*asked ? ISO_OK : find_device(asked, name, err);
}

/* ---- finding Blender ---- */

/* Oldest tested version. */
enum { OLDEST_MAJOR = 3, OLDEST_MINOR = 4 };

iso_status iso_blender_find(const char *program, char **path, iso_error *err)
{
    return program ? iso_process_find_named("Blender", program, path, err)
                   : iso_process_find("blender", "blender", path, err);
}

static void keep_version(void *user, const char *line)
{
    char *version = user;
    if (!version[0])
        sscanf(line, "Blender %31[0-9.]", version);
}

static iso_status check_age(const char *blender, const char *version, iso_error *err)
{
    int major = 0, minor = 0;
    if (sscanf(version, "%d.%d", &major, &minor) != 2)
        return iso_fail(err, ISO_E_PROGRAM, "%s: --version names no version of Blender", blender);
    if (major < OLDEST_MAJOR || (major == OLDEST_MAJOR && minor < OLDEST_MINOR))
        return iso_fail(err, ISO_E_MISSING, "%s: Blender %s is too old; needs %d.%d or newer", blender, version,
                        OLDEST_MAJOR, OLDEST_MINOR);
    return ISO_OK;
}

iso_status iso_blender_version(const char *program, char *version, size_t size, iso_error *err)
{
    char found[32] = "";
    FREED char *blender = NULL;
    NEED(iso_blender_find(program, &blender, err));
    const char *argv[] = {blender, "--version", NULL};
    const iso_process_options options = {.line = keep_version, .user = found, .timeout_seconds = 120};
    NEED(iso_process_run(argv, &options, err));
    NEED(check_age(blender, found, err));
    snprintf(version, size, "%s", found);
    return ISO_OK;
}

/* Asks Blender for its devices, which only it knows. Blender 5 shows volumes only with NanoVDB, which a build may
 * lack. */
static iso_status probe(const char *program, char *device, size_t size, iso_error *err)
{
    iso_blender_options options = iso_blender_defaults();
    iso_cycles_stats stats = {0};
    options.program = program;
    options.stats = &stats;
    FREED char *folder = iso_make_temp_dir();
    if (!folder)
        return iso_temp_dir_fail(err);
    const iso_status status = iso_blender_run(json_pack("{sb}", "probe", true), folder, &options, NULL, err);
    snprintf(device, size, "%s", stats.device);
    iso_remove_tree(folder);
    return status;
}

iso_status iso_cycles_ask(const char *program, iso_cycles_about *about, iso_error *err)
{
    const char *device;
    *about = (iso_cycles_about){.device = "CPU"};
    iso_status status = iso_cycles_device(&device, err);
    TRY(status, iso_blender_version(program, about->version, sizeof about->version, err));
    if (status == ISO_OK && (atoi(about->version) >= 5 || strcmp(device, devices[0].name) != 0))
        status = probe(program, about->device, sizeof about->device, err);
    return status;
}
