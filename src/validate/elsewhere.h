/* SPDX-License-Identifier: MIT */
/* elsewhere.h - requests for a renderer on another machine (renderers/request.h): a folder for each scene and level and
 * for each calibration, and an index and a text that list the wanted pictures (renderers/pictures.h). */
#pragma once

#include "base/json.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

typedef struct iso_elsewhere {
    const char *dir;  /* an existing folder */
    const char *tier; /* "samples", "limit" or "8 bits" */
    size_t steps;     /* number of pictures, each at half the step of the one before, for the limit; 0: none */
    json_t *pictures; /* requested pictures, as in pictures.json; owned by the caller that began it */
    json_t *left_out; /* scenes for which a request has no words: each "scene", "why" */
} iso_elsewhere;

/* Writes the levels of a scene. view: the scene resolved for the pyramid. */
iso_status iso_elsewhere_write_scene(const iso_elsewhere *e, const iso_pyramid *p, const iso_scene *scene,
                                     const iso_view *view, const char *name, iso_error *err);
iso_status iso_elsewhere_write_calibrations(const iso_elsewhere *e, iso_error *err);
/* Writes pictures.json and README.txt. command: the line that made them; validate: the line that compares the
 * pictures. */
iso_status iso_elsewhere_finish(const iso_elsewhere *e, const char *command, const char *validate, iso_error *err);
