/* SPDX-License-Identifier: MIT */
/* choices.c - the words that options of the library's interface take, from the tables of their modules. */
#include "library/shared.h"
#include "renderers/renderers.h"
#include "scene/viewpoint.h"
#include "targets/targets.h"
#include "tf/presets.h"

static const char *name_of_row(const iso_names *names, size_t row)
{
    return row < names->count ? iso_names_name(names, row) : NULL;
}

static const char *voxel_type(size_t row)
{
    return row <= ISO_F64 ? iso_type_name((iso_type)row) : NULL;
}

/* Palettes, which stand last, are not of the interface. */
static const char *shading(size_t row)
{
    return row <= ISO_FROM_ON_THE_FLY ? name_of_row(&iso_direction_source_names, row) : NULL;
}

static const char *renderer(size_t row)
{
    return row < iso_renderer_count() ? iso_renderer_at(row)->name : NULL;
}

const char *iso_choice_name(iso_choice what, size_t number)
{
    switch (what) {
    case ISO_CHOICE_VOXEL_TYPE: return voxel_type(number);
    case ISO_CHOICE_CODE: return name_of_row(&iso_code_names, number);
    case ISO_CHOICE_ESTIMATOR: return name_of_row(&iso_gradient_names, number);
    case ISO_CHOICE_SCALAR_FILTER: return name_of_row(&iso_scalar_filter_names, number);
    case ISO_CHOICE_DIRECTION_FILTER: return name_of_row(&iso_direction_filter_names, number);
    case ISO_CHOICE_SHADING: return shading(number);
    case ISO_CHOICE_RENDERER: return renderer(number);
    case ISO_CHOICE_EXPORT: return name_of_row(&iso_export_target_names, number);
    case ISO_CHOICE_TF: return name_of_row(&iso_tf_preset_names, number);
    case ISO_CHOICE_VIEW: return name_of_row(&iso_viewpoint_names, number);
    }
    return NULL;
}
