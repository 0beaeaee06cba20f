/* SPDX-License-Identifier: MIT */
/* external.h - renderers that are programs which know nothing of isoshade but a request (request.h) and the pictures that
 * it asks for. They stand in a renderers.json (doc/reference/files-request.md); doc/extending.md has a complete one.
 *
 * A start: a folder of its own, in which the request is, and which is the working directory; no shell; the path of request.json as the last argument; the time limit of the row or of --timeout, whichever is less. When
 * it has ended, nothing that it began is left running (base/keeper.h). In a sandbox for programs that may draw on a graphics
 * device (base/sandbox.h), unless the row says otherwise. Refused by name: no such program, an exit code
 * other than 0, a signal, the time limit; a picture that is not there, is no file, is older than the request, is no
 * OpenEXR, has another size or not all four channels, or has values that are no numbers. */
#ifndef ISO_RENDERERS_EXTERNAL_H
#define ISO_RENDERERS_EXTERNAL_H

#include "renderers/renderers.h"

typedef struct iso_external {
    const char *const
        *command; /* ends with NULL; its first word is found as base/process.h does, where it has no slash */
    const char *const
        *version;        /* the same: prints its version as the first line, or exits with another code than 0 where
                                 * something that it needs is missing; or NULL */
    const char *package; /* the Debian package that has the program, for messages; NULL: of its name */
    const char *tier;       /* "samples", "limit" or "8 bits": for reports */
    double timeout_seconds; /* of a start; 0: --timeout alone */
    bool has_all_rights;    /* it is started without a sandbox */
} iso_external;

iso_status iso_external_version(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size,
                                iso_error *err);
iso_status iso_external_render(const iso_render_request *q, iso_image *image, iso_render_stats *stats, iso_error *err);
iso_status iso_external_render_several(const iso_render_request *q, size_t count, iso_image *images, iso_error *err);
json_t *iso_external_describe(const iso_renderer_info *self);
#define ISO_EXTERNAL_CALLBACKS \
    .version = iso_external_version, .render = iso_external_render, .render_several = iso_external_render_several, \
    .describe = iso_external_describe
/* What each of them is: given an export, started, taking part where it is named. */
#define ISO_EXTERNAL_TRAITS (ISO_IS_PROGRAM | ISO_IS_NAMED)

/* What stands in a row instead of a program. */
typedef struct iso_external_stand_in {
    const void *data;
    iso_status (*version)(const iso_renderer_info *self, iso_renderers *r, char *text, size_t size, iso_error *err);
    iso_status (*render)(const iso_render_request *request, iso_image *image, iso_render_stats *stats, iso_error *err);
    size_t steps; /* at how many steps, each half of the one before, there are pictures; below 2 there is no limit */
} iso_external_stand_in;

/* Registers a row as renderers.json has it, of a file and its folder; *r is the renderer. Statuses as below. */
iso_status iso_external_register(json_t *row, const char *path, const char *folder, const iso_external_stand_in *instead,
                                 const iso_renderer_info **r, iso_error *err);

/* Registers the renderers of a list of files like renderers.json, with commas between their names; paths NULL: of those that
 * the environment variable ISOSHADE_RENDERERS names, or none. ISO_E_IO, ISO_E_FORMAT and ISO_E_RANGE name the file, the row and the key; ISO_E_USAGE: a name that is
 * taken. */
#define ISO_RENDERERS_VARIABLE "ISOSHADE_RENDERERS"
iso_status iso_renderers_load(const char *paths, iso_error *err);

#endif
