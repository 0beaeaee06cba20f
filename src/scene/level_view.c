/* SPDX-License-Identifier: MIT */
#include "scene/level_view.h"

#include <stdlib.h>
#include <string.h>

#include "tf/level_look.h"

iso_status iso_view_take_scale(iso_view *view, const iso_level *level, iso_error *err)
{
    const size_t bytes = iso_geometry_voxel_count(&level->geometry);
    if (!level->scale)
        return ISO_OK;
    if (!view->extinction_scale && !(view->extinction_scale = malloc(bytes)))
        return iso_fail(err, ISO_E_MEMORY, "no memory for an extinction scale of %zu voxels", bytes);
    memcpy(view->extinction_scale, level->scale, bytes);
    return ISO_OK;
}

iso_status iso_view_take_level(iso_view *view, const iso_pyramid *p, size_t level, bool *found, iso_error *err)
{
    const iso_level *l = &p->levels[level];
    iso_tf_table own = {0};
    iso_status status = iso_level_look(p, level, &view->tf, &own, found, err);
    if (status == ISO_OK && (*found || l->geometry.has_no_data))
        status = iso_view_take_scale(view, l, err);
    if (status == ISO_OK && *found) {
        iso_tf_table_destroy(&view->tf);
        view->tf = own;
        return ISO_OK;
    }
    iso_tf_table_destroy(&own);
    return status;
}
