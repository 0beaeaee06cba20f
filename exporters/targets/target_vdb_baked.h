/* SPDX-License-Identifier: MIT */
/* target_vdb_baked.h - the target vdb with --bake or --for. */
#pragma once

#include "targets/targets.h"

iso_status iso_target_vdb_baked(const iso_export_job *job, iso_error *err);
