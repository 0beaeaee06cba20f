/* SPDX-License-Identifier: MIT */
/* power.h - the statistical power of validation: which planted faults its gates reject, in random scenes.
 *
 * A case is a random scene with the images that its gates compare with. A gate renders the scene, with a fault or without, and
 * answers by the very limits and verdicts of validate.h.
 *
 *   lock-step   the same samples as the reference, of renderers whose samples are known
 *   limit       of halved steps, of all but the reference
 *
 * Random scenes are a rotated, anisotropic noise, right- or left-handed, seen from anywhere, orthographic or in perspective, with one to three
 * lights, of four kinds in turn: smooth transfer functions; bright ones, dense and with highlights above 1; sharp ones
 * with a step of opacity; and lit ones, of the tier that is judged by FLIP and SSIM as well. */
#ifndef ISO_LAB_POWER_H
#define ISO_LAB_POWER_H

#include "options/cli.h"
#include "validate/faults.h"
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
    size_t pixels; /* along the sides of its images */
    size_t seeds;  /* of random renderers */
    int first_seed;
    int threads;
    iso_scene_agreement asked;
    iso_image converged,
        midpoint; /* the reference's of the clean scene: what limits have to meet; what shows a fault */
    iso_image
        same_samples[ISO_MAX_RENDERERS]; /* the reference's in lock-step with a renderer, of those that have one */
    iso_tolerances lock_step[ISO_MAX_RENDERERS];
    double brightest; /* value of a pixel of `converged` */
} iso_power_case;

/* The scene's images are rendered. seed, pixels, seeds, first_seed and threads of *c are given; its kind is that of
 * the seed. Release with iso_power_close(), which accepts what failed. */
iso_status iso_power_open(iso_renderers *r, iso_power_case *c, iso_error *err);
void iso_power_close(iso_power_case *c);

/* RMSE by which what is planted changes the reference's picture of the scene. */
iso_status iso_power_change(iso_renderers *r, const iso_power_case *c, const iso_planted *planted, double *rmse,
                            iso_error *err);

/* Does the gate reject the renderer, which is given the scene with the fault? planted NULL: the clean one. */
iso_status iso_power_ask(iso_renderers *r, const iso_power_case *c, iso_power_gate gate,
                         const iso_renderer_info *renderer, const iso_planted *planted, bool *rejected, iso_error *err);

/* The same for a deviation, whose renderer has the clean scene while the reference's deviates the other way: with a cache
 * in r the images of the renderer are made once for all amounts. */
iso_status iso_power_ask_deviation(iso_renderers *r, const iso_power_case *c, iso_power_gate gate,
                                   const iso_renderer_info *renderer, const iso_planted *deviation, bool *rejected,
                                   iso_error *err);

/* Is the noise of a random renderer what the test of its pixels takes it to be? `groups` groups of c->seeds seeds each, at the
 * first pair of steps: how many of them are flagged by chance, and how far the noise is from normal, by testing each
 * group's limits against the mean of all others without any tolerance. */
enum { ISO_POWER_BLOCKS = 3 };
typedef struct iso_power_noise {
    size_t groups, flagged;
    size_t tests, below; /* pixels and channels with noise, of all groups; those below a chance of ISO_POWER_NOISE_P */
    /* With iso_power_block_seeds[i] seeds, from which amount on a block in the middle that is too bright, of so many pixels
     * squared, has a pixel beyond chance, within 5 %. 0: there were not so many seeds. */
    double block[ISO_POWER_BLOCKS][ISO_POWER_BLOCKS];
} iso_power_noise;
extern const size_t iso_power_block_seeds[ISO_POWER_BLOCKS], iso_power_block_sides[ISO_POWER_BLOCKS];
#define ISO_POWER_NOISE_P 1e-3
iso_status iso_power_test_noise(iso_renderers *r, const iso_power_case *c, const iso_renderer_info *renderer,
                                size_t groups, iso_power_noise *out, iso_error *err);

/* The smallest amount of each deviation that is rejected, by each gate. */
typedef struct iso_sensitivity_options {
    bool wanted[ISO_MAX_RENDERERS];
    int scenes, pixels, seed, threads;
    int limit_pixels; /* limits are asked in pictures of this size as well, to see what that costs; 0: not */
    int halvings;     /* of the octave that a smallest amount is in */
    const char *output, *format; /* a folder for the chart and its data; or NULL */
} iso_sensitivity_options;
iso_status iso_power_sensitivity(iso_renderers *r, const iso_sensitivity_options *opt, const iso_cli *cli,
                                 iso_error *err);

/* Right scenes of which validate says that something differs. */
typedef struct iso_power_random_options {
    const char *with;
    int scenes, seed, threads;
} iso_power_random_options;
/* ISO_E_DIFFERS: there were such. */
iso_status iso_power_random(const iso_power_random_options *opt, const iso_cli *cli, iso_error *err);
/* True if a row of any section of a report says that something differs, failed or was refused; its name in text. */
bool iso_power_is_alarm(const json_t *report, char *text, size_t size);
/* The largest rate that so many alarms leave possible, at 95 % confidence: Clopper and Pearson's bound. */
double iso_power_rate_bound(size_t alarms, size_t asked);

#endif
