/* SPDX-License-Identifier: MIT */
/* render_paged.h - `isoshade render NAME.iso --memory MB`: a level that may be larger than memory. */
#ifndef ISO_CLI_RENDER_PAGED_H
#define ISO_CLI_RENDER_PAGED_H

#include "cli/render_options.h"

/* Coarse levels first with --refine, each as a picture of its own; statuses as the other renders have. */
iso_status iso_cli_render_paged(const iso_render_arguments *a, const iso_cli *cli, iso_error *err);

#endif
