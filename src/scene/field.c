/* SPDX-License-Identifier: MIT */
#include "scene/field.h"

#include <string.h>

static const char *const source_names[ISO_SOURCE_COUNT] = {
    [ISO_FROM_CODES] = "codes",
    [ISO_FROM_DECODED] = "decoded",
    [ISO_FROM_FLOAT] = "float",
    [ISO_FROM_FLIPPED] = "flipped",
    [ISO_FROM_ON_THE_FLY] = "on-the-fly",
    [ISO_FROM_PALETTE] = "palette",
    [ISO_FROM_PALETTE_NEAREST] = "palette-nearest",
};

const char *iso_direction_source_name(iso_direction_source s)
{
    return (unsigned)s < ISO_SOURCE_COUNT ? source_names[s] : "unknown";
}

iso_status iso_direction_source_from_name(const char *name, iso_direction_source *s, iso_error *err)
{
    for (int i = 0; i < ISO_SOURCE_COUNT; ++i)
        if (strcmp(name, source_names[i]) == 0) {
            *s = (iso_direction_source)i;
            return ISO_OK;
        }
    return iso_fail(err, ISO_E_USAGE, "direction source '%s', must be codes, decoded, float, flipped, on-the-fly, palette or palette-nearest", name);
}
