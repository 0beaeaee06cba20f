/* SPDX-License-Identifier: MIT */
#include "volume/value_unit.h"

#include <stdio.h>

const char *iso_value_unit_of(const iso_volume_notes *notes)
{
    const bool is_scaled = notes->applied_slope != 0 || (notes->scale_slope == 1 && notes->scale_intercept == 0);
    return is_scaled ? notes->value_unit : "";
}

void iso_value_unit_read(const char *path, const iso_volume_input *input, char unit[ISO_VALUE_UNIT_BYTES])
{
    ENDED_BY(iso_source_close_owned) iso_volume_source *source = NULL;
    unit[0] = 0;
    if (!path || iso_volume_input_open(path, input, &source, NULL) != ISO_OK)
        return;
    snprintf(unit, ISO_VALUE_UNIT_BYTES, "%s", iso_value_unit_of(&iso_source_volume(source)->notes));
}
