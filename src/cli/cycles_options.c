/* SPDX-License-Identifier: MIT */
#include "cli/cycles_options.h"

#include <stdio.h>

#include "blender/blender.h"
#include "renderers/renderers.h"
#include "report/rows.h"

iso_status iso_cli_take_cycles(const iso_cli_cycles *a, const char *with, iso_error *err)
{
    bool wanted[ISO_MAX_RENDERERS];
    const iso_renderer_info *cycles;
    NEED(iso_renderers_from_list(with, wanted, err));
    NEED(iso_renderer_from_name("cycles", &cycles, err));
    if ((a->blender || a->device) && !wanted[iso_renderer_index(cycles)])
        return iso_fail(err, ISO_E_USAGE, "%s needs cycles, which --with %s leaves out",
                        a->blender ? "--blender" : "--cycles-device", with);
    NEED(iso_cycles_set_device(a->device, err));
    return iso_renderers_take_blenders(a->blender, err);
}

void iso_cli_print_versions(const json_t *report)
{
    size_t i;
    json_t *row;
    json_array_foreach (json_object_get(report, "agreement"), i, row) {
        const json_t *found = json_object_get(row, "statistics");
        long long column = 0, line = 0;
        if (iso_row_identify(row).comparison != ISO_COMPARISON_VERSIONS || !found)
            continue;
        json_unpack((json_t *)found, "{s:[I,I]}", "pixel", &column, &line);
        printf("%s, level %lld: %s against %s: largest change %.2g in column %lld, row %lld (noise there %.2g): %s\n",
               iso_row_text(row, "scene"), iso_row_level(row), iso_row_text(row, "renderer"), iso_row_text(row, "a"),
               iso_row_number(found, "largest_change"), column, line, iso_row_number(found, "noise_there"),
               iso_row_text(row, "verdict"));
    }
}
