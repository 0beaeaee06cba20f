/* SPDX-License-Identifier: MIT */
#include "lab/look.h"

#include <math.h>

#include "scene/views.h"

iso_status iso_lab_view(const iso_lab_look *look, const iso_level *level0, const iso_tf *tf, iso_vec3 direction,
                          iso_view *view, iso_error *err)
{
    const iso_scene scene = {.path = "bench",
                             .width = look->image_size,
                             .height = look->image_size,
                             .camera_fit = true,
                             .orthographic = true,
                             .camera_direction = direction,
                             .camera_up = iso_view_up(direction),
                             .margin = 1,
                             .light_count = 1,
                             .lights = {{.direction = {0.3, 0.5, 0.8}, .in_camera_space = true, .intensity = 1}},
                             .shading = {.ambient = look->shaded ? 0.3 : 1,
                                         .diffuse = look->shaded ? 0.7 : 0,
                                         .power = 1},
                             .step_voxels = look->step_voxels,
                             .tf = *tf};
    return iso_scene_resolve(&scene, &level0->geometry, level0->min, level0->max, view, err);
}

double iso_lab_largest_alpha(const iso_image *image)
{
    double most = 0;
    for (size_t i = 0; image->rgba && i < image->width * image->height; ++i)
        most = fmax(most, (double)image->rgba[4 * i + 3]);
    return most;
}
