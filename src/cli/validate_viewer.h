/* SPDX-License-Identifier: MIT */
/* validate_viewer.h - the viewer's page beside a report (validate --viewer). */
#ifndef ISO_CLI_VALIDATE_VIEWER_H
#define ISO_CLI_VALIDATE_VIEWER_H

#include "validate/validate.h"

/* DIR/viewer-SCENE.html, and "viewers" in the report, by which rows link to it at their level. Levels of more voxels than
 * a page holds are left out. */
iso_status iso_validate_save_viewer(const iso_validation *v, iso_error *err);

#endif
