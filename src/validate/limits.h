/* SPDX-License-Identifier: MIT */
/* limits.h - renders with ever smaller steps until a renderer's limit is known well enough.
 *
 * The image is rendered at the steps h and 2h, a random renderer's with several seeds, and extrapolated to step 0
 * (compare/extrapolation.h). The step is halved again while one of these holds:
 *   - the error bar is wider than wanted;
 *   - the limit differs from the reference by more than its error bar;
 *   - halving does not reduce the error as second order should;
 *   - the error bar is wider than a faint image allows;
 *   - a pixel is beyond chance, and nothing excuses it;
 *   - a person would see the difference (FLIP, SSIM), if the scene asks for that.
 * If only the last halving left too much error at the finest step of a renderer without noise, the step is halved once
 * more: with samples of random phases a single halving may leave more by chance. If two limits in a row are many times
 * farther off than allowed, and the halving left nearly all of the error, the renderer fails at once: finer steps would
 * only make the bars narrower. A correct renderer passes in the end. The difference of a wrong one stays, while its bar
 * shrinks. */
#pragma once

#include "renderers/renderers.h"
#include "compare/extrapolation.h"

typedef struct iso_limit_options {
    double step_voxels;    /* the finer of the first two, in the level's smallest spacing */
    double finest_voxels;  /* where halving ends */
    double wanted_bar;     /* RMSE, factor included */
    double factor;         /* of safety: ISO_EXTRAPOLATION_FACTOR_... */
    double wanted_held_to; /* the most that iso_extrapolated_held_to() may be, for a faint image; 0: anything */
    double wanted_left;    /* part of the error that halving may leave: iso_extrapolated_error_left() */
    double hopeless; /* give up if two limits in a row are this many bars off and halving left nearly all; INFINITY:
                      * never */
    double wanted_ssim_dissimilarity, wanted_flip; /* of the limit; 0: not checked */
    size_t seeds;                                  /* of random renderers, at least 2 */
    size_t planes,
        intervals; /* of renderers with intervals, at step_voxels; at its double half of them; 0 intervals: chosen by the step */
    bool confirm; /* halve once more, beyond finest_voxels, where the last halving alone left too much */
    bool keep;    /* what iso_extrapolated_compare() needs */
    int first_seed, threads;
    double deadline; /* by iso_clock_seconds(): a halving that would end later is skipped (limit.unfinished); 0: none */
    const iso_render_options
        *truth; /* of the reference; with it, pixels are excused where the reference itself moves with
                                      * its eye by single precision. NULL: none is */
} iso_limit_options;
/* Returns the defaults: h = 1/4 and not below 1/64, 4 seeds, bars of 1/2550, a factor of 2; 0.354 left by halving;
 * nothing is hopeless. */
iso_limit_options iso_limit_defaults(void);

/* Renders and extrapolates until the limit is good enough, hopeless, or the step would be below finest_voxels. what: a
 * level and a view; its options are chosen here, and may be NULL. Pixels that are not finite make the error bar
 * infinite, so the limit fails its gates. Release *out with iso_extrapolated_destroy(). */
iso_status iso_limit_find(const iso_render_request *what, const iso_image *reference, const iso_renderer_info *which,
                          const iso_limit_options *opt, iso_extrapolated *out, iso_error *err);

/* Renders the image of a limit alone, from opt->step_voxels and its double, and creates *image. With the step, seeds,
 * planes and intervals of a limit of iso_limit_find(), it is the same image. */
iso_status iso_limit_render(const iso_render_request *what, const iso_renderer_info *which,
                            const iso_limit_options *opt, iso_image *image, iso_error *err);
