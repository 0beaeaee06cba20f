/* SPDX-License-Identifier: MIT */
/* paged.h - the ray caster on the CPU for levels that are larger than memory: bricks are pages, read when a ray needs
 * them.
 *
 *     level_K.nrrd  --read once, row by row-->  blocks that the transfer function shows (a byte for 64 voxels)
 *     level_K.nrrd, level_K_dir.nrrd  --bricks that rays wait for-->  pool of pages  -->  rays go on, or wait again
 *
 * All rays begin at once. In each pass every ray goes on until it is done or meets a brick that is not in the pool;
 * then the bricks that rays wait for are loaded and, if pages are free, those ahead. Bricks that no ray reaches,
 * because the transfer function or an opaque part hides them, are never loaded. The picture is that of caster.h, bit
 * for bit, for any memory and number of threads. */
#pragma once

#include "base/progress.h"
#include "pyramid/level_pages.h"
#include "render/cpu/caster.h"

typedef struct iso_paged_stats {
    size_t passes, bricks, bricks_of_level, pool_bricks; /* bricks: loaded, again too */
    double bytes_read, memory_bytes;                     /* memory: of all that a picture needs, the pool among it */
    double seconds;
} iso_paged_stats;

typedef struct iso_paged_options {
    double memory_bytes; /* of blocks, rays, pages and the image; the program itself is not counted */
    double step_voxels;  /* 0: the view's */
    iso_cpu_width width;
    int threads;
} iso_paged_options;

/* Renders a level that is shaded from codes. level: of the outline that the pages were opened with; with codes if the
 * view is lit. ISO_E_USAGE: a region of interest, a 2D transfer function or extinction scales. ISO_E_RANGE: too little
 * memory; the message gives the needed size. ISO_E_IO, ISO_E_MEMORY. */
iso_status iso_cpu_render_paged(const iso_level *level, iso_code code, const iso_level_pages *pages,
                                const iso_view *view, const iso_paged_options *opt, iso_image *image,
                                iso_paged_stats *stats, const iso_progress *progress, iso_error *err);
