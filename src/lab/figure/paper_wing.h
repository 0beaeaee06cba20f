/* SPDX-License-Identifier: MIT */
/* paper_wing.h - an airplane's wing as a volume. Most directions point up or down, as in the palette paper. */
#pragma once

#include "volume/volume.h"

/* Makes 160 x 92 x 36 voxels; values fall from 1 inside to 0 outside over six voxels, with the surface at 1/2. */
iso_status iso_paper_make_wing(iso_volume *v, iso_error *err);
