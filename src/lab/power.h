/* SPDX-License-Identifier: MIT */
/* power.h - statistical power of validation: which planted faults its gates reject, in random scenes.
 *
 * A case is a random scene with the images that its gates compare with. A gate renders the scene, with or without a
 * fault, and decides by the limits and verdicts of validate.h.
 *
 *   lock-step   the same samples as the reference, for renderers with known samples
 *   limit       of halved steps, for all renderers but the reference
 *
 * Random scenes are rotated, anisotropic noise, right- or left-handed, seen from any side, orthographic or in
 * perspective, with one to three lights. Four kinds follow in turn: smooth transfer functions; bright ones, dense and
 * with highlights above 1; sharp ones with a step of opacity; and lit ones, also judged by FLIP and SSIM. */
#pragma once

#include "options/cli.h"
#include "lab/faults.h"
#include "validate/validate.h"

typedef enum iso_power_kind {
    ISO_POWER_SMOOTH,
    ISO_POWER_BRIGHT,
    ISO_POWER_SHARP,
    ISO_POWER_LIT,
    ISO_POWER_KIND_COUNT
} iso_power_kind;
const char *iso_power_kind_name(iso_power_kind kind);

typedef enum iso_power_gate { ISO_POWER_LOCK_STEP, ISO_POWER_LIMIT, ISO_POWER_GATE_COUNT } iso_power_gate;
const char *iso_power_gate_name(iso_power_gate gate);
bool iso_power_has_gate(iso_power_gate gate, const iso_renderer_info *renderer);

typedef struct iso_power_case {
    uint64_t seed;
    iso_power_kind kind;
    size_t pixels; /* per side of its images */
    size_t seeds;  /* of random renderers */
    int first_seed;
    int threads;
    iso_scene_agreement asked;
    iso_image converged, midpoint; /* by the reference, of the clean scene: for limits; for the effect of a fault */
    iso_image same_samples[ISO_MAX_RENDERERS]; /* by the reference, in lock-step with a renderer that has this gate */
    iso_tolerances lock_step[ISO_MAX_RENDERERS];
    double brightest; /* largest pixel value of `converged` */
} iso_power_case;

/* Renders the scene's images. Set seed, pixels, seeds, first_seed and threads of *c before; the seed determines the
 * kind. Release with iso_power_close(), also after a failure. */
iso_status iso_power_open(iso_renderers *r, iso_power_case *c, iso_error *err);
void iso_power_close(iso_power_case *c);

/* Computes the RMSE by which the planted fault changes the reference's picture of the scene. */
iso_status iso_power_change(iso_renderers *r, const iso_power_case *c, const iso_planted *planted, double *rmse,
                            iso_error *err);

/* Runs a gate: *rejected is true if it rejects the renderer with the planted fault (NULL: the clean scene). */
iso_status iso_power_run_gate(iso_renderers *r, const iso_power_case *c, iso_power_gate gate,
                              const iso_renderer_info *renderer, const iso_planted *planted, bool *rejected,
                              iso_error *err);

/* Does the same for a deviation. The renderer gets the clean scene and the reference deviates the other way, so that
 * with a cache in r the renderer's images are rendered once for all amounts. */
iso_status iso_power_run_deviation_gate(iso_renderers *r, const iso_power_case *c, iso_power_gate gate,
                                        const iso_renderer_info *renderer, const iso_planted *deviation, bool *rejected,
                                        iso_error *err);

/* Tests that a random renderer's noise fits the assumptions of the pixel test, by `groups` groups of c->seeds seeds
 * each, at the first pair of steps. Counts the groups flagged by chance. Tests for normality compare each group's
 * limits with the mean of all others, without tolerance. */
enum { ISO_POWER_BLOCKS = 3 };
typedef struct iso_power_noise {
    size_t groups, flagged;
    size_t tests, below; /* pixels and channels with noise, of all groups; those below a chance of ISO_POWER_NOISE_P */
    /* Smallest excess, within 5 %, at which a block in the middle has a pixel beyond chance, with
     * iso_power_block_seeds[i] seeds and iso_power_block_sides[j]^2 pixels. 0: not enough seeds. */
    double block[ISO_POWER_BLOCKS][ISO_POWER_BLOCKS];
} iso_power_noise;
extern const size_t iso_power_block_seeds[ISO_POWER_BLOCKS], iso_power_block_sides[ISO_POWER_BLOCKS];
#define ISO_POWER_NOISE_P 1e-3
iso_status iso_power_test_noise(iso_renderers *r, const iso_power_case *c, const iso_renderer_info *renderer,
                                size_t groups, iso_power_noise *out, iso_error *err);

/* Finds the smallest amount of each deviation that each gate rejects. */
typedef struct iso_sensitivity_options {
    bool wanted[ISO_MAX_RENDERERS];
    int scenes, pixels, seed, threads;
    int limit_pixels;            /* also tests limits in pictures of this size, to compare both; 0: off */
    int halvings;                /* bisections of the octave with the smallest amount */
    const char *output, *format; /* folder for the chart and its data; or NULL */
} iso_sensitivity_options;
iso_status iso_power_sensitivity(iso_renderers *r, const iso_sensitivity_options *opt, const iso_cli *cli,
                                 iso_error *err);

/* Counts correct scenes in which validate reports a difference. */
typedef struct iso_power_random_options {
    const char *with;
    int scenes, seed, threads;
} iso_power_random_options;
/* Runs them. ISO_E_DIFFERS: at least one false alarm. */
iso_status iso_power_random(const iso_power_random_options *opt, const iso_cli *cli, iso_error *err);
/* True if a row of any section of a report differs, failed or was refused; text: the row's name. */
bool iso_power_is_alarm(const json_t *report, char *text, size_t size);
/* True if all such rows are levels whose pictures alone are behind the simple way's: what is stored, the bound, the
 * extinction scale and the scene's limits hold. */
bool iso_power_is_finding(const json_t *report);
/* Returns the largest rate consistent with these alarms at 95 % confidence (Clopper and Pearson). */
double iso_power_rate_bound(size_t alarms, size_t tested);
