/* SPDX-License-Identifier: MIT */
/* target_vdb_baked.h - the target vdb with --bake or --for. */
#ifndef ISO_TARGET_VDB_BAKED_H
#define ISO_TARGET_VDB_BAKED_H

#include "targets/targets.h"

iso_status iso_target_vdb_baked(const iso_export_job *job, iso_error *err);

#endif
