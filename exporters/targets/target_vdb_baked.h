/* SPDX-License-Identifier: MIT */
/* target_vdb_baked.h - what the target vdb writes where --bake or --for is given. */
#ifndef ISO_TARGET_VDB_BAKED_H
#define ISO_TARGET_VDB_BAKED_H

#include "targets/targets.h"

iso_status iso_target_vdb_baked(const iso_export_job *job, iso_error *err);

#endif
