/* SPDX-License-Identifier: MIT */
#include "lab/volumes.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "scene/subject.h"

iso_status iso_lab_check_pictures(const iso_lab_pictures *p, iso_error *err)
{
    if (p->most_views > 0)
        NEED(iso_words_check_range("--views", p->views, 1, p->most_views, err));
    NEED(iso_words_check_range("--size", p->size, 16, 4096, err));
    return iso_words_check_range("--levels", p->levels, 2, p->most_levels, err);
}

iso_status iso_lab_crop_to_middle(iso_volume *v, size_t n, iso_error *err)
{
    const iso_geometry whole = v->geometry;
    iso_geometry part = whole;
    size_t first[3];
    for (int a = 0; a < 3; ++a) {
        part.size[a] = whole.size[a] < n ? whole.size[a] : n;
        part.box_index[a] = (double)part.size[a];
        first[a] = (whole.size[a] - part.size[a]) / 2;
    }
    part.origin_mm = iso_geometry_to_world(&whole, iso_v3((double)first[0], (double)first[1], (double)first[2]));
    const size_t voxel = iso_type_bytes(v->type), row = part.size[0] * voxel;
    char *data = malloc(iso_geometry_voxel_count(&part) * voxel), *to = data;
    NEED_MEMORY(data, err, "no memory for a crop of %zu voxels", iso_geometry_voxel_count(&part));
    for (size_t z = 0; z < part.size[2]; ++z)
        for (size_t y = 0; y < part.size[1]; ++y, to += row)
            memcpy(to,
                   (const char *)v->data +
                       voxel * (first[0] + whole.size[0] * (first[1] + y + whole.size[1] * (first[2] + z))),
                   row);
    free(v->data);
    v->data = data;
    v->geometry = part;
    return ISO_OK;
}

static iso_status visit_volume(const iso_lab_volumes *volumes, size_t i, iso_lab_visit visit, void *user,
                               iso_error *err)
{
    const char *path = volumes->cli->arguments[i];
    iso_pyramid_options build = iso_pyramid_defaults();
    OWNED(iso_pyramid) p = {0};
    build.level_count = (size_t)volumes->levels;
    build.threads = volumes->cli->threads;
    NEED(iso_subject_load_pyramid(path, volumes->input, &build, volumes->loading, &p, err));
    for (size_t t = 0; t < ISO_LEVEL_TF_COUNT; ++t) {
        const iso_lab_visited visited = {.volume = iso_path_base(path),
                                           .pyramid = &p,
                                           .tf = &iso_level_tfs[t],
                                           .number = i * ISO_LEVEL_TF_COUNT + t,
                                           .count = volumes->cli->argument_count * ISO_LEVEL_TF_COUNT};
        NEED(visit(user, &visited, err));
    }
    return ISO_OK;
}

iso_status iso_lab_visit_volumes(const iso_lab_volumes *volumes, iso_lab_visit visit, void *user, iso_error *err)
{
    for (size_t i = 0; i < volumes->cli->argument_count; ++i)
        NEED(visit_volume(volumes, i, visit, user, err));
    return ISO_OK;
}
