/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/validate_viewer.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/provenance.h"
#include "view/viewer.h"

iso_status iso_validate_save_viewer(const iso_validation *v, iso_error *err)
{
    FREED char *name = NULL, *path = NULL;
    iso_viewer_size size;
    iso_viewer page = {.pyramid = v->pyramid,
                       .scene = v->scene,
                       .title = iso_provenance_title(v->volume_path),
                       .input = v->input_options,
                       .folder = v->loaded ? v->volume_path : NULL,
                       .last = v->pyramid->level_count - 1,
                       .code_count = 1,
                       .codes = {v->pyramid->options.code},
                       .threads = v->threads};
    page.first = iso_viewer_finest_level(v->pyramid, ISO_VIEWER_MOST_VOXELS);
    if (asprintf(&name, "viewer-%s.html", v->scene_name) < 0 || !(path = iso_path_join(iso_report_dir(v->report), name)))
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    NEED(iso_viewer_save(&page, path, NULL, &size, err));
    iso_report_put(v->report, "viewers", v->scene_name, json_string(name));
    return ISO_OK;
}
