/* SPDX-License-Identifier: MIT */
/* paraview.h - exports a level and a scene for ParaView and pvbatch.
 *
 * A folder: NAME.vti, the level as VTK image data, and NAME.py, a state that shows it. "pvbatch NAME.py" writes
 * NAME.png to the folder.
 *
 *     NAME.vti   float32, appended raw. The values belong to CELLS. ParaView draws point data from the first point to the
 *                last, which would cut half a voxel at each face. It draws cells to their outer faces, interpolates
 *                between their centers, and clamps to the edge beyond, as isoshade does.
 *                Origin, Spacing and Direction are the level's: world = origin + direction spacing index.
 *     NAME.py    the transfer function's table as opacities for unit_mm, which is ScalarOpacityUnitDistance;
 *                camera, background, size of the view. Colors are linear light and are not converted.
 *
 * The Python contains no text of the user: the file's name has only letters, digits, "-" and "_", and the rest are
 * numbers. Shading is ParaView's own (doc/guide/other-programs.md). */
#pragma once

#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* Exports the folder. ISO_E_USAGE: clip planes, a 2D transfer function, extinction scales, a region of interest, a
 * label map, or a sheared grid. ISO_E_IO, ISO_E_MEMORY. */
iso_status iso_paraview_export(const iso_pyramid *p, size_t level, const iso_view *view, const char *dir,
                               iso_error *err);
