/* SPDX-License-Identifier: MIT */
/* external.h - renderers that are external programs, listed in a renderers.json. Such a program needs to know only the
 * request (request.h) and the pictures to write (doc/reference/files-request.md). doc/guide/judging-a-renderer.md has a
 * complete one.
 *
 * Each start has its own folder, which holds the request and is the working directory. There is no shell. The last
 * argument is the path of request.json. The time limit is the smaller one of the row and of --timeout. All child
 * processes end with the program (base/supervisor.h). It runs in a sandbox that allows a graphics device
 * (base/sandbox.h), unless the row turns that off.
 *
 * Errors name the cause: a missing program, an exit code other than 0, a signal, the time limit; a picture that is
 * missing, not a regular file, older than the request, of no form of picture_file.h, of another size, without one of the
 * four channels, or with values that are not finite. */
#pragma once

#include "renderers/renderers.h"

typedef struct iso_external {
    /* Ends with NULL; a first word without a slash is searched for by base/process.h. */
    const char *const *command;
    /* The same: prints the version as its first line, or exits with a code above 0 if it lacks something; or NULL. */
    const char *const *version;
    const char *package;    /* Debian package with the program, for messages; NULL: the program's name */
    const char *tier;       /* "samples", "limit" or "8 bits": for reports */
    double timeout_seconds; /* of a start; 0: --timeout alone */
    bool has_all_rights;    /* True if it runs without a sandbox */
} iso_external;

iso_status iso_external_version(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size,
                                iso_error *err);
iso_status iso_external_render(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *err);
iso_status iso_external_render_several(const iso_render_request *q, size_t count, iso_image *images, iso_error *err);
json_t *iso_external_describe(const iso_renderer_info *self);
#define ISO_EXTERNAL_CALLBACKS \
    .version = iso_external_version, .render = iso_external_render, .render_several = iso_external_render_several, \
    .describe = iso_external_describe
/* Traits of each of them. */
#define ISO_EXTERNAL_TRAITS (ISO_IS_PROGRAM | ISO_IS_NAMED)

/* Callbacks in place of a row's program. */
typedef struct iso_external_stand_in {
    const void *data;
    iso_status (*version)(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err);
    iso_status (*render)(const iso_render_request *request, iso_image *image, iso_render_stats *stats, iso_error *err);
    size_t steps; /* number of steps with pictures, each half of the one before; a limit needs 2 */
} iso_external_stand_in;

/* Registers a row of a renderers.json; path and folder are those of the file. *r is the renderer. Errors as below. */
iso_status iso_external_register(json_t *row, const char *path, const char *folder,
                                 const iso_external_stand_in *instead, const iso_renderer_info **r, iso_error *err);

/* Registers the renderers of several renderers.json, separated by commas; NULL: those in the environment variable
 * ISOSHADE_RENDERERS, or none. ISO_E_IO, ISO_E_FORMAT and ISO_E_RANGE name the file, the row and the key;
 * ISO_E_USAGE: a name is taken. */
#define ISO_RENDERERS_VARIABLE "ISOSHADE_RENDERERS"
iso_status iso_renderers_load(const char *paths, iso_error *err);
