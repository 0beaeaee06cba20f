/* SPDX-License-Identifier: MIT */
/* shared.h - functions that the files of the library's interface (isoshade.h) share.
 *
 * The interface's handles are the structs of the other modules, allocated. Its options are words and plain numbers;
 * these files turn them into the modules' options. No arithmetic on samples is done here. */
#pragma once

#include "base/json.h"
#include "base/progress.h"
#include "isoshade.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* Converts a module's geometry to a public grid with the same values. */
iso_grid iso_grid_of_geometry(const iso_geometry *g);

/* Parses an object from memory. what: its name in messages. */
iso_status iso_json_of_text(const char *text, const char *what, json_t **root, iso_error *err);
/* Writes an object as a text, to be freed, and releases it. root NULL: out of memory. */
iso_status iso_text_of_json(json_t *root, char **text, iso_error *err);

/* Returns a new object in the form of a scene file, with the limits of its levels, without "suite". */
json_t *iso_json_of_scene(const iso_scene *scene);

/* Copies the scene, with the TF and image size of the options (NULL, 0: the scene's). The copy borrows all parts. */
iso_status iso_scene_borrow(const iso_scene *scene, const iso_tf *tf, size_t width, size_t height, iso_scene *copy,
                            iso_error *err);
/* Resolves the scene for the pyramid, with the TF and image size of the options (NULL, 0: the scene's). */
iso_status iso_scene_view(const iso_scene *scene, const iso_pyramid *p, const iso_tf *tf, size_t width, size_t height,
                          iso_view *view, iso_error *err);

/* How a level is to be looked at. */
typedef struct iso_library_look {
    const iso_scene *scene;
    const iso_tf *tf;     /* NULL: the scene's */
    size_t width, height; /* 0: the scene's */
    bool adapt, extinction_scale;
    const iso_region *region; /* or NULL */
    int threads;
} iso_library_look;
/* Resolves the scene for a level: as it was made to be shown (scene/level_view.h), or adapted if asked for; with an
 * extinction scale and a region of interest. */
iso_status iso_library_view(const iso_library_look *look, const iso_pyramid *p, size_t level, iso_view *view,
                            iso_error *err);
