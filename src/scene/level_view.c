/* SPDX-License-Identifier: MIT */
#include "scene/level_view.h"

#include <stdlib.h>
#include <string.h>

#include "tf/level_look.h"

iso_status iso_view_take_level(iso_view *view, const iso_pyramid *p, size_t level, bool *found, iso_error *err)
{
    const iso_level *l = &p->levels[level];
    const size_t bytes = iso_geometry_voxel_count(&l->geometry);
    iso_tf_table own;
    iso_status status = iso_level_look(p, level, &view->tf, &own, found, err);
    if (status != ISO_OK || !*found)
        return status;
    if (l->scale && !view->extinction_scale)
        view->extinction_scale = malloc(bytes);
    if (l->scale && !view->extinction_scale) {
        iso_tf_table_destroy(&own);
        return iso_fail(err, ISO_E_MEMORY, "no memory for an extinction scale of %zu voxels", bytes);
    }
    if (l->scale)
        memcpy(view->extinction_scale, l->scale, bytes);
    iso_tf_table_destroy(&view->tf);
    view->tf = own;
    return ISO_OK;
}
