/* SPDX-License-Identifier: MIT */
#include "scene/field.h"

static const struct {
    const char *name, *summary;
} sources[] = {
    [ISO_FROM_CODES] = {"codes", "codes are fetched, filtered, then decoded, as on a GPU"},
    [ISO_FROM_DECODED] = {"decoded", "decoded at the voxels, then filtered, as in exports"},
    [ISO_FROM_FLOAT] = {"float", "directions before encoding"},
    [ISO_FROM_FLIPPED] = {"flipped", "decoded at the voxels, turned to one side, then filtered"},
    [ISO_FROM_ON_THE_FLY] = {"on-the-fly", "central differences of the filtered scalar, one voxel apart"},
    [ISO_FROM_PALETTE] = {"palette", "a palette's entries at the voxels, filtered"},
    [ISO_FROM_PALETTE_NEAREST] = {"palette-nearest", "the palette's entry of the point's voxel"},
};
const iso_names iso_direction_source_names = ISO_NAMES_OF_ROWS("direction source", sources);

const char *iso_direction_source_name(iso_direction_source s)
{
    return (unsigned)s < ISO_SOURCE_COUNT ? sources[s].name : "unknown";
}

iso_status iso_direction_source_from_name(const char *name, iso_direction_source *s, iso_error *err)
{
    size_t row = 0;
    NEED(iso_names_find(&iso_direction_source_names, name, &row, err));
    *s = (iso_direction_source)row;
    return ISO_OK;
}
