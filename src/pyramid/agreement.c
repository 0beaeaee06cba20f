/* SPDX-License-Identifier: MIT */
#include "pyramid/agreement.h"

#include <math.h>
#include <stdio.h>

#include "pyramid/cascade.h"

static const double unit = 0x1p-36;
/* Level 0 included: a part of the volume makes as many levels as the whole does. */
enum { MEASURED_LEVELS = 5 };

void iso_agreement_add_row(iso_agreement *a, const float *state, size_t stride, size_t n)
{
    double sums[ISO_AGREEMENT_SUMS] = {0};
    for (size_t i = 0; i < n; ++i) {
        const float *s = state + i;
        double element[10];
        for (size_t c = 0; c < 10; ++c)
            element[c] = (double)s[c * stride];
        const double *x = element, *t = element + 4; /* N, S; T: xx, yy, zz, xy, xz, yz */
        const double diagonal = t[0] * t[0] + t[1] * t[1] + t[2] * t[2], rest = t[3] * t[3] + t[4] * t[4] + t[5] * t[5];
        sums[0] += sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
        sums[1] += sqrt(diagonal + 2 * rest);
        sums[2] += x[3];
    }
    for (int c = 0; c < ISO_AGREEMENT_SUMS; ++c)
        a->of[c] += (uint64_t)llrint(sums[c] / unit);
}

void iso_agreement_add(iso_agreement *a, const iso_agreement *more)
{
    for (int c = 0; c < ISO_AGREEMENT_SUMS; ++c)
        a->of[c] += more->of[c];
}

void iso_agreement_choose(const iso_agreement levels[], size_t measured, iso_direction_choice *choice)
{
    *choice = (iso_direction_choice){.is_made = true};
    for (size_t k = 1; k < sizeof choice->filter / sizeof *choice->filter; ++k) {
        const iso_agreement *a = &levels[k < measured ? k : measured];
        const double all = (double)a->of[2];
        choice->mean_agreement[k] = all > 0 ? (double)a->of[0] / all : 1;
        choice->axis_agreement[k] = all > 0 ? (double)a->of[1] / all : 1;
        choice->filter[k] = choice->axis_agreement[k] - choice->mean_agreement[k] >= ISO_AGREEMENT_GAIN
                                ? ISO_DIRECTION_TENSOR
                                : ISO_DIRECTION_MOMENTS;
    }
}

iso_pyramid_options iso_agreement_options(const iso_pyramid_options *opt)
{
    iso_pyramid_options own = *opt;
    own.scalar_filter = ISO_SCALAR_MEAN;
    own.level_count = own.level_count < MEASURED_LEVELS ? own.level_count : MEASURED_LEVELS;
    own.choice.is_made = false;
    own.keep_float = own.keep_magnitude = false;
    return own;
}

iso_status iso_agreement_choose_for(const iso_planes *planes, const iso_geometry *g, double scale,
                                    iso_pyramid_options *opt, const iso_progress *progress, iso_error *err)
{
    const iso_cascade_out nothing[32] = {{0}};
    const iso_pyramid_options own = iso_agreement_options(opt);
    iso_cascade *cascade = NULL;
    if (opt->direction_filter != ISO_DIRECTION_AUTO)
        return ISO_OK;
    iso_status status = iso_cascade_create(g, &own, scale, &cascade, err);
    const size_t nz = g->size[2], slab = status == ISO_OK ? iso_cascade_step(cascade) * 4 : 1;
    for (size_t z = 0; z < nz && status == ISO_OK; z += slab) {
        iso_progress_report(progress, "directions", (double)z / (double)nz);
        status = iso_progress_check(progress, err);
        TRY(status, iso_cascade_feed(cascade, planes, z, z + slab < nz ? z + slab : nz, nothing, err));
    }
    if (status == ISO_OK)
        iso_cascade_choose(cascade, &opt->choice);
    iso_cascade_destroy(cascade);
    return status;
}

const char *iso_direction_choice_text(const iso_direction_choice *choice, size_t level, char *text, size_t size)
{
    snprintf(text, size, "%s: gradients agree by %.3f in direction, by %.3f on an axis",
             iso_direction_filter_name(choice->filter[level]), choice->mean_agreement[level],
             choice->axis_agreement[level]);
    return text;
}
