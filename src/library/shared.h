/* SPDX-License-Identifier: MIT */
/* shared.h - functions that the files of the library's interface (isoshade.h) share.
 *
 * The interface's handles are the structs of the other modules, allocated. Its options are words and plain numbers;
 * these files turn them into the modules' options. No arithmetic on samples is done here. */
#ifndef ISO_LIBRARY_SHARED_H
#define ISO_LIBRARY_SHARED_H

#include "base/progress.h"
#include "isoshade.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* Converts a module's geometry to a public grid with the same values. */
iso_grid iso_grid_of_geometry(const iso_geometry *g);
iso_geometry iso_geometry_of_grid(const iso_grid *grid);

/* Returns the progress of a function's options. */
static inline iso_progress iso_progress_of(iso_progress_callback report, void *user)
{
    return (iso_progress){.report = report, .user = user};
}

/* Resolves the scene for the pyramid, with the TF and image size of the options (NULL, 0: the scene's). */
iso_status iso_scene_view(const iso_scene *scene, const iso_pyramid *p, const iso_tf *tf, size_t width, size_t height,
                          iso_view *view, iso_error *err);

#endif
