/* SPDX-License-Identifier: MIT */
/* limit_gates.c - the gates of an extrapolated limit, and their rows in the report. */
#include <math.h>

#include "base/json.h"
#include "validate/validate.h"

/* Error bars have to be below a tenth of an 8-bit step if the TF is smooth, and below that step if it is sharp. */
static const double smooth_bar = 1.0 / 2550, sharp_bar = 1.0 / 255;
/* Part of a step's error that may remain after halving. For smooth TFs it is half a power of the step more than second
 * order. For sharp ones, bends and steps between the samples have random phases: they are of first order, and single
 * halvings a little worse. */
static const double smooth_left = 0.354, sharp_left = 0.6;
/* A limit that stays this many times farther off than allowed is decided without its last halvings. */
static const double hopeless_bars = 5;

/* For lit scenes: below the difference that a person sees when the images alternate. */
static const double lit_flip = 0.01, lit_ssim_dissimilarity = 0.001;

iso_view iso_validate_small_view(const iso_view *view, size_t pixels)
{
    const size_t larger = view->width > view->height ? view->width : view->height;
    iso_view out = *view;
    if (pixels > 0 && larger > pixels) {
        out.width = (view->width * pixels + larger - 1) / larger;
        out.height = (view->height * pixels + larger - 1) / larger;
    }
    return out;
}

double iso_validate_error_bar(const iso_scene_agreement *asked)
{
    return asked->sharp ? sharp_bar : smooth_bar;
}

json_t *iso_validate_limit_to_json(const iso_extrapolated *l)
{
    json_t *o = json_pack("{s:f, s:o, s:o, s:o, s:o, s:I}", "step_voxels", l->step_voxels, "rmse_at_twice_the_step",
                          iso_json_number(l->coarse_rmse), "rmse_at_the_step", iso_json_number(l->fine_rmse), "order",
                          iso_json_number(l->order), "step_bar", iso_json_number(l->step_bar), "seeds",
                          (json_int_t)l->seeds);
    if (l->seeds < 2)
        return o;
    const iso_noise_test *n = &l->noise;
    json_object_update_new(o, json_pack("{s:o, s:o, s:I, s:o}", "pixel_tolerance_median",
                                        iso_json_number(n->tolerance_median), "pixel_tolerance_largest",
                                        iso_json_number(n->tolerance_largest), "pixels_excused", (json_int_t)n->excused,
                                        "largest_excused", iso_json_number(n->largest_excused)));
    json_object_update_new(o, json_pack("{s:o, s:I, s:I, s:o, s:o, s:o, s:o, s:o}", "noise_bar",
                                        iso_json_number(l->noise_bar), "pixels_tested", (json_int_t)n->tests,
                                        "pixels_beyond_chance", (json_int_t)n->rejected, "smallest_p",
                                        iso_json_number(n->smallest_p), "sidak_significance",
                                        iso_json_number(n->pixel_significance), "signed_bias", iso_json_number(n->bias),
                                        "standard_error_of_bias", iso_json_number(n->bias_error), "mean_local_error",
                                        iso_json_number(n->mean_abs)));
    return o;
}

static void add_gate(iso_report_agreement *row, iso_gate gate, double value, double limit)
{
    row->gates[row->gate_count++] = (iso_report_gate){gate, value, limit};
}

void iso_validate_limit_row(const iso_scene_agreement *asked, const iso_extrapolated *l, iso_report_agreement *row)
{
    row->error_bar = l->bar;
    row->tolerances = (iso_tolerances){.rmse = l->allowed};
    add_gate(row, ISO_GATE_ERROR_BAR, l->bar, iso_validate_error_bar(asked));
    add_gate(row, ISO_GATE_HALVING, iso_extrapolated_error_left(l), asked->sharp ? sharp_left : smooth_left);
    if (l->seeds > 1) {
        add_gate(row, ISO_GATE_PIXELS, (double)l->noise.rejected, 0);
        add_gate(row, ISO_GATE_BIAS, l->noise.biased, 0);
    }
    if (asked->tier == ISO_TIER_LIT) {
        row->tolerances.flip_mean = lit_flip;
        row->tolerances.ssim_dissimilarity = lit_ssim_dissimilarity;
    }
}

/* Returns a bound of all channels of a picture: the scene limits ambient and diffuse light to 1, and so is alpha. */
static double brightest(const iso_view *view)
{
    const double *b = view->background;
    double color = 0, light = 1;
    for (size_t i = 0; i < 4 * view->tf.count; ++i)
        color = fmax(color, i % 4 < 3 ? (double)view->tf.entries[i] : 0);
    for (size_t i = 0; i < view->light_count; ++i)
        light += view->shading.specular * view->lights[i].intensity;
    return fmax(1, fmax(color * light, fmax(b[0], fmax(b[1], b[2]))));
}

iso_tolerances iso_validate_lock_step(const iso_renderer_info *renderer, const iso_view *view, bool sharp)
{
    const iso_lock_step *lock = renderer->lock_step;
    const iso_sample_error *e = sharp ? &lock->sharp : &lock->smooth;
    const iso_render_output *output = &renderer->output;
    const double peak = output->peak ? output->peak(view) : 0;
    const double half = output->half ? iso_half_rounding(brightest(view)) : 0; /* of the image, too: it may be flat */
    return (iso_tolerances){.rmse = fmax(e->rmse, output->rounding_rmse * peak) + half,
                            .max_abs = fmax(e->max_abs, output->rounding * peak) + half};
}

iso_limit_options iso_validate_limit_options(const iso_scene_agreement *asked, const iso_renderer_info *renderer,
                                             size_t seeds, int threads)
{
    iso_limit_options o = iso_limit_defaults();
    o.seeds = renderer->seeds > seeds ? renderer->seeds : seeds;
    o.threads = threads;
    o.wanted_left = asked->sharp ? sharp_left : smooth_left;
    o.factor = asked->sharp ? ISO_EXTRAPOLATION_FACTOR_SHARP : ISO_EXTRAPOLATION_FACTOR_SMOOTH;
    o.wanted_bar = iso_validate_error_bar(asked);
    o.hopeless = hopeless_bars;
    if (asked->tier == ISO_TIER_LIT) { /* SSIM sees a shell's last bends before RMSE does */
        o.wanted_flip = lit_flip;
        o.wanted_ssim_dissimilarity = lit_ssim_dissimilarity;
    }
    if (asked->sharp) /* the first pair would seldom do */
        o.step_voxels = 1.0 / 8;
    if (renderer->first_step_voxels > 0)
        o.step_voxels = renderer->first_step_voxels;
    o.confirm = renderer->step_count == 0;
    if (renderer->step_count >= 2) /* the first pair, and the rest are halvings of it */
        o.finest_voxels = fmax(o.finest_voxels, ldexp(o.step_voxels, 2 - (int)renderer->step_count));
    return o;
}
