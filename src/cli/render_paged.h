/* SPDX-License-Identifier: MIT */
/* render_paged.h - `isoshade render NAME.iso --memory MB`: renders a level that may be larger than memory. */
#pragma once

#include "cli/render_options.h"

/* Renders the level. With --refine coarse levels come first, each as its own picture. Statuses as of other renders. */
iso_status iso_cli_render_paged(const iso_render_arguments *a, const iso_cli *cli, iso_error *err);
