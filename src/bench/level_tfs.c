/* SPDX-License-Identifier: MIT */
#include "bench/level_tfs.h"

/* Opacities are for one level-0 voxel. */
const iso_level_tf iso_level_tfs[ISO_LEVEL_TF_COUNT] = {
    {"surface",
     4,
     {{0, {0.9, 0.7, 0.4}, 0}, {0.3, {0.9, 0.7, 0.4}, 0}, {0.4, {1, 0.9, 0.8}, 0.8}, {1, {1, 0.9, 0.8}, 0.8}}},
    {"soft",
     4,
     {{0, {0.1, 0.2, 0.6}, 0}, {0.1, {0.1, 0.3, 0.7}, 0}, {0.5, {0.8, 0.6, 0.2}, 0.05}, {1, {1, 0.9, 0.6}, 0.2}}},
    {"two-material",
     7,
     {{0, {0.7, 0.2, 0.1}, 0},
      {0.15, {0.7, 0.2, 0.1}, 0},
      {0.22, {0.7, 0.2, 0.1}, 0.06},
      {0.38, {0.7, 0.2, 0.1}, 0.06},
      {0.45, {0.2, 0.5, 0.9}, 0},
      {0.55, {0.2, 0.6, 0.9}, 0.6},
      {1, {0.3, 0.7, 1}, 0.6}}},
    {"shell",
     5,
     {{0, {0.2, 0.8, 0.5}, 0},
      {0.4, {0.2, 0.8, 0.5}, 0},
      {0.45, {0.3, 0.9, 0.5}, 0.5},
      {0.5, {0.8, 0.8, 0.2}, 0},
      {1, {0.8, 0.8, 0.2}, 0}}},
};

iso_tf iso_level_tf_of(const iso_level_tf *tf)
{
    return (iso_tf){.point_count = tf->point_count,
                    .points = (iso_tf_point *)tf->points,
                    .fit_range = true,
                    .unit_distance = 1,
                    .unit_is_voxels = true,
                    .table_size = 256};
}
