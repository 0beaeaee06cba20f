/* SPDX-License-Identifier: MIT */
/* brick_visible.h - which bricks of mixed resolution a view can show. */
#pragma once

#include "brick/bricks.h"
#include "scene/scene.h"

/* Marks visible bricks in visible[b]: the transfer function shows a part, the clip planes leave a part, and wanted[b]
 * is set. wanted: one byte per brick; NULL: all bricks. Returns the share of visible bricks. */
double iso_brick_visible(const iso_brick_field *f, const iso_view *view, const iso_tf_table *tf, const uint8_t *wanted,
                         int threads, uint8_t *restrict visible);
