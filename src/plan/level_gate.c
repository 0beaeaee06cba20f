/* SPDX-License-Identifier: MIT */
#include "plan/level_gate.h"

#include "compare/metrics.h"
#include "compare/ssim.h"
#include "plan/optimize.h"
#include "render/cpu/caster.h"

enum { GATE_SEED = 0x67617465 }; /* not a seed of training */

bool iso_level_gate_is_nearer(const iso_level_seen *a, const iso_level_seen *b)
{
    const double most = 1 - ISO_LEVEL_GATE_GAIN;
    return b->ssim_dissimilarity <= most * a->ssim_dissimilarity && b->rmse <= a->rmse &&
           b->small_ssim_dissimilarity <= most * a->small_ssim_dissimilarity && b->small_rmse <= a->small_rmse;
}

/* Averages squares of 2^level pixels. */
static iso_status make_small(const iso_image *from, size_t level, iso_image *to, iso_error *err)
{
    const size_t n = (size_t)1 << level, width = (from->width + n - 1) >> level,
                 height = (from->height + n - 1) >> level;
    const iso_status status = iso_image_create(to, width, height, err);
    for (size_t i = 0; i < width * height && status == ISO_OK; ++i) {
        double sum[4] = {0}, count = 0;
        for (size_t y = i / width * n; y < i / width * n + n && y < from->height; ++y)
            for (size_t x = i % width * n; x < i % width * n + n && x < from->width; ++x, ++count)
                for (size_t c = 0; c < 4; ++c)
                    sum[c] += (double)from->rgba[4 * (y * from->width + x) + c];
        for (size_t c = 0; c < 4; ++c)
            to->rgba[4 * i + c] = (float)(sum[c] / count);
    }
    return status;
}

static iso_status measure(const iso_image *truth, const iso_image *image, double *ssim_dissimilarity, double *rmse,
                          iso_error *err)
{
    iso_metrics m = {0};
    double ssim = 1;
    iso_status status = iso_ssim_foreground(truth, image, &ssim, err);
    TRY(status, iso_metrics_measure_differences(truth, image, &m, err));
    *ssim_dissimilarity += (1 - ssim) / ISO_LEVEL_GATE_VIEWS;
    *rmse += m.rmse / ISO_LEVEL_GATE_VIEWS;
    return status;
}

/* A picture, and its average. */
typedef struct both {
    iso_image image, small;
} both;

static void destroy(both *b)
{
    iso_image_destroy(&b->image);
    iso_image_destroy(&b->small);
}

static iso_status draw(const iso_pyramid *p, const iso_level_with_tf *shown, iso_view *view, size_t level, int threads,
                       both *out, iso_error *err)
{
    iso_cpu_options opt = iso_cpu_defaults();
    const iso_tf_table own = view->tf;
    opt.threads = threads;
    *out = (both){0};
    if (shown->tf)
        view->tf = *shown->tf;
    iso_status status = iso_cpu_render(shown->level, p->options.code, view, &opt, &out->image, err);
    view->tf = own;
    TRY(status, make_small(&out->image, level, &out->small, err));
    return status;
}

static iso_status look(const iso_pyramid *p, size_t level, const iso_level_with_tf *shown, iso_view *view,
                       const both *truth, int threads, iso_level_seen *seen, iso_error *err)
{
    both drawn;
    iso_status status = draw(p, shown, view, level, threads, &drawn, err);
    TRY(status, measure(&truth->image, &drawn.image, &seen->ssim_dissimilarity, &seen->rmse, err));
    TRY(status, measure(&truth->small, &drawn.small, &seen->small_ssim_dissimilarity, &seen->small_rmse, err));
    destroy(&drawn);
    return status;
}

iso_status iso_level_gate_judge(const iso_pyramid *p, size_t level, const iso_scene *scene,
                                const iso_level_with_tf *today, const iso_level *optimized, int threads,
                                iso_level_gate *gate, iso_error *err)
{
    iso_view views[ISO_LEVEL_GATE_VIEWS];
    *gate = (iso_level_gate){0};
    iso_status status = iso_optimize_views(p, scene, GATE_SEED, ISO_LEVEL_GATE_VIEWS, views, err);
    for (int i = 0; i < ISO_LEVEL_GATE_VIEWS && status == ISO_OK; ++i) {
        both truth;
        status = draw(p, &(iso_level_with_tf){&p->levels[0], NULL}, &views[i], level, threads, &truth, err);
        TRY(status, look(p, level, today, &views[i], &truth, threads, &gate->today, err));
        TRY(status,
            look(p, level, &(iso_level_with_tf){optimized, NULL}, &views[i], &truth, threads, &gate->optimized, err));
        destroy(&truth);
    }
    for (int i = 0; i < ISO_LEVEL_GATE_VIEWS; ++i)
        iso_view_destroy(&views[i]);
    gate->accepts = status == ISO_OK && iso_level_gate_is_nearer(&gate->today, &gate->optimized);
    return status;
}
