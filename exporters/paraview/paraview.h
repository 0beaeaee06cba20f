/* SPDX-License-Identifier: MIT */
/* paraview.h - a level and a scene as ParaView opens them, and as pvbatch renders them.
 *
 * A folder: NAME.vti, the level as VTK's image data, and NAME.py, a state that shows it ("pvbatch NAME.py" leaves NAME.png
 * beside it).
 *
 *     NAME.vti   float32, appended raw. The values belong to CELLS, not to points: ParaView draws points from the first one's
 *                center to the last one's, which leaves out half a voxel at each face, but cells to their outer faces, with
 *                the values between their centers interpolated and clamped to the edge beyond, as isoshade does.
 *                Origin, Spacing and Direction are those of the level: world = origin + direction spacing index.
 *     NAME.py    the table of the transfer function as opacities for unit_mm, which is ScalarOpacityUnitDistance;
 *                camera, background, size of the view. Colors are linear light and reach the picture as they are.
 *
 * Nothing that a person wrote reaches the Python: the file's name is made of letters, digits, "-" and "_", the rest are
 * numbers. Shading is ParaView's own (doc/guide/other-programs.md). */
#ifndef ISO_EXPORT_PARAVIEW_H
#define ISO_EXPORT_PARAVIEW_H

#include "pyramid/pyramid.h"
#include "scene/scene.h"

/* ISO_E_USAGE: a view with clip planes, a 2D transfer function, extinction scales or a region of interest, label maps, and
 * a grid that is sheared. ISO_E_IO, ISO_E_MEMORY. */
iso_status iso_paraview_export(const iso_pyramid *p, size_t level, const iso_view *view, const char *dir,
                               iso_error *err);

#endif
