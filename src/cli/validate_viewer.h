/* SPDX-License-Identifier: MIT */
/* validate_viewer.h - writes a viewer page next to a report (validate --viewer). */
#pragma once

#include "validate/validate.h"

/* Writes DIR/viewer-SCENE.html, and "viewers" in the report, to link rows to their level in the page. Levels with more
 * voxels than a page may hold are left out. */
iso_status iso_validate_save_viewer(const iso_validation *v, iso_error *err);
