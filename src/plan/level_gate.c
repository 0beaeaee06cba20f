/* SPDX-License-Identifier: MIT */
#include "plan/level_gate.h"

#include <math.h>

#include "compare/metrics.h"
#include "compare/srgb.h"
#include "compare/ssim.h"
#include "render/cpu/caster.h"
#include "scene/views.h"
#include "tf/adapt.h"
#include "tf/color_space.h"

enum { VIEWS = ISO_LEVEL_GATE_VIEWS, EDIT_VIEWS = VIEWS / 2, GATE_SEED = 0x67617465 }; /* not a seed of training */

bool iso_level_gate_is_better(const iso_level_seen *built, const iso_level_seen *other)
{
    bool good = other->ssim_dissimilarity <= (1 - ISO_LEVEL_GATE_GAIN) * built->ssim_dissimilarity &&
                other->rmse <= (1 + ISO_LEVEL_GATE_RMSE_LOSS) * built->rmse;
    for (int i = 0; i < VIEWS; ++i)
        good = good && other->of_view[i] - built->of_view[i] <= ISO_ADAPT_WORST_VIEW;
    return good;
}

bool iso_level_gate_is_nearer(const iso_level_seen *a, const iso_level_seen *b, size_t count)
{
    const double most = 1 - ISO_LEVEL_GATE_GAIN;
    double means[4] = {1, 1, 1, 1}; /* geometric */
    bool good = true;
    for (size_t i = 0; i < count; ++i) {
        const double ratios[4] = {b[i].ssim_dissimilarity / a[i].ssim_dissimilarity,
                                  b[i].small_ssim_dissimilarity / a[i].small_ssim_dissimilarity, b[i].rmse / a[i].rmse,
                                  b[i].small_rmse / a[i].small_rmse};
        for (int k = 0; k < 4; ++k) {
            good = good && ratios[k] <= 1 + ISO_LEVEL_GATE_GAIN;
            means[k] *= pow(ratios[k], 1 / (double)count);
        }
    }
    return good && means[0] <= most && means[1] <= most && means[2] <= 1 && means[3] <= 1;
}

bool iso_level_gate_stands(double built, double edited, double rounding)
{
    return edited <= (1 + ISO_LEVEL_GATE_GAIN) * built || sqrt(edited) <= sqrt(built) + sqrt(rounding);
}

/* ---- views ------------------------------------------------------------------------------------------------------ */

static iso_vec3 random_direction(iso_random *r)
{
    const double z = 2 * iso_random_unit(r) - 1, turn = 2 * acos(-1) * iso_random_unit(r), s = sqrt(1 - z * z);
    return iso_v3(s * cos(turn), s * sin(turn), z);
}

size_t iso_gate_picture_side(const iso_geometry *level0)
{
    const double side = 2 * iso_geometry_box_radius_mm(level0) / (1.1 * iso_geometry_min_spacing_mm(level0));
    return (size_t)fmin(fmax(side, 64), 448);
}

iso_status iso_gate_random_view(const iso_pyramid *p, const iso_scene *scene, bool own_light, iso_random *r,
                                iso_view *view, iso_error *err)
{
    iso_scene s = *scene; /* copies pointers, whose targets stay the scene's */
    s.width = s.height = iso_gate_picture_side(&p->levels[0].geometry);
    s.camera_fit = true;
    s.camera_direction = random_direction(r);
    s.camera_up = iso_view_up(s.camera_direction);
    s.margin = 1;
    s.zoom = 1;
    const iso_vec3 light = random_direction(r);
    if (!own_light && s.light_count > 0) {
        double intensity = 0;
        for (size_t i = 0; i < s.light_count; ++i)
            intensity += s.lights[i].intensity;
        s.lights[0] = (iso_light){light, false, intensity};
        s.light_count = 1;
    }
    return iso_scene_resolve(&s, &p->levels[0].geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), view, err);
}

/* ---- pictures --------------------------------------------------------------------------------------------------- */

iso_status iso_gate_minify(const iso_image *from, size_t level, iso_image *to, iso_error *err)
{
    const size_t n = (size_t)1 << level, width = (from->width + n - 1) >> level,
                 height = (from->height + n - 1) >> level;
    NEED(iso_image_create(to, width, height, err));
    for (size_t i = 0; i < width * height; ++i) {
        double sum[4] = {0}, count = 0;
        for (size_t y = i / width * n; y < i / width * n + n && y < from->height; ++y)
            for (size_t x = i % width * n; x < i % width * n + n && x < from->width; ++x, ++count)
                for (size_t c = 0; c < 4; ++c)
                    sum[c] += (double)from->rgba[4 * (y * from->width + x) + c];
        for (size_t c = 0; c < 4; ++c)
            to->rgba[4 * i + c] = (float)(sum[c] / count);
    }
    return ISO_OK;
}

static iso_status measure(const iso_image *truth, const iso_image *image, double *ssim_dissimilarity, double *rmse,
                          iso_error *err)
{
    iso_metrics m = {0};
    double ssim = 1;
    NEED(iso_ssim_foreground(truth, image, &ssim, err));
    NEED(iso_metrics_measure_differences(truth, image, &m, err));
    *ssim_dissimilarity = 1 - ssim;
    *rmse += m.rmse;
    return ISO_OK;
}

static iso_status draw(const iso_level_gate *gate, int i, const iso_level *level, iso_image *image, iso_error *err)
{
    iso_cpu_options opt = iso_cpu_defaults();
    opt.threads = gate->threads;
    return iso_cpu_render(level, gate->p->options.code, &gate->views[i], &opt, image, err);
}

static iso_status open_gate(iso_level_gate *gate, const iso_pyramid *p, const iso_scene *scene, int view_count,
                            int threads, iso_error *err)
{
    iso_random r = {.state = GATE_SEED};
    *gate = (iso_level_gate){.p = p, .threads = threads, .view_count = view_count};
    for (int i = 0; i < view_count; ++i) {
        NEED(iso_gate_random_view(p, scene, i % 2 == 0, &r, &gate->views[i], err));
        NEED(draw(gate, i, &p->levels[0], &gate->truth[i], err));
    }
    return ISO_OK;
}

iso_status iso_level_gate_open(iso_level_gate *gate, const iso_pyramid *p, const iso_scene *scene, int threads,
                               iso_error *err)
{
    return open_gate(gate, p, scene, VIEWS, threads, err);
}

iso_status iso_gate_edit_tf(const iso_pyramid *p, const iso_tf *tf, double shift, double factor, iso_tf *edited,
                            iso_error *err)
{
    NEED(iso_tf_copy(tf, edited, err));
    const double range = tf->fit_range ? 1 : iso_pyramid_hi(p) - iso_pyramid_lo(p);
    for (size_t i = 0; i < edited->point_count; ++i) {
        edited->points[i].value += shift * range;
        edited->points[i].opacity = fmin(factor * edited->points[i].opacity, 1);
    }
    return ISO_OK;
}

/* Compares level 0's pictures with themselves as a display of 8 bits shows them. */
static iso_status measure_rounding(iso_level_gate *gate, iso_error *err)
{
    for (int i = 0; i < gate->view_count; ++i) {
        const iso_image *truth = &gate->truth[i];
        OWNED(iso_image) shown = {0};
        double ssim;
        NEED(iso_image_create(&shown, truth->width, truth->height, err));
        for (size_t k = 0; k < 4 * truth->width * truth->height; ++k) {
            const double step = floor(255 * iso_srgb_encode((double)truth->rgba[k]) + 0.5);
            shown.rgba[k] = k % 4 == 3 ? truth->rgba[k] : (float)iso_srgb_to_linear(step / 255);
        }
        NEED(iso_ssim_foreground(truth, &shown, &ssim, err));
        gate->rounding += (1 - ssim) / gate->view_count;
    }
    return ISO_OK;
}

iso_status iso_level_gate_open_edits(iso_level_gate gates[ISO_LEVEL_GATE_EDITS], const iso_pyramid *p,
                                     const iso_scene *scene, int threads, iso_error *err)
{
    static const struct {
        double shift, factor;
    } edits[ISO_LEVEL_GATE_EDITS] = {{-0.05, 1}, {0.05, 1}, {0, 0.5}, {0, 2}};
    iso_status status = ISO_OK;
    for (int i = 0; i < ISO_LEVEL_GATE_EDITS && status == ISO_OK; ++i) {
        iso_scene s = *scene; /* copies pointers, whose targets stay the scene's */
        status = iso_gate_edit_tf(p, &scene->tf, edits[i].shift, edits[i].factor, &s.tf, err);
        TRY(status, open_gate(&gates[i], p, &s, EDIT_VIEWS, threads, err));
        TRY(status, measure_rounding(&gates[i], err));
        if (status == ISO_E_RANGE) {
            iso_level_gate_close(&gates[i]);
            gates[i].view_count = 0;
            status = ISO_OK;
        }
        iso_tf_destroy(&s.tf);
    }
    return status;
}

size_t iso_level_gate_bytes(const iso_geometry *level0, bool with_edits)
{
    const size_t side = iso_gate_picture_side(level0),
                 pictures = VIEWS + (with_edits ? ISO_LEVEL_GATE_EDITS * EDIT_VIEWS : 0);
    return pictures * side * side * 4 * sizeof(float);
}

void iso_level_gate_close(iso_level_gate *gate)
{
    for (int i = 0; i < gate->view_count; ++i) {
        iso_view_destroy(&gate->views[i]);
        iso_image_destroy(&gate->truth[i]);
    }
}

static iso_status compare(const iso_level_gate *gate, int i, size_t level, const iso_image *image, iso_level_seen *seen,
                          iso_error *err)
{
    OWNED(iso_image) small_truth = {0}, small = {0};
    double small_ssim_dissimilarity = 0;
    NEED(measure(&gate->truth[i], image, &seen->of_view[i], &seen->rmse, err));
    NEED(iso_gate_minify(&gate->truth[i], level, &small_truth, err));
    NEED(iso_gate_minify(image, level, &small, err));
    NEED(measure(&small_truth, &small, &small_ssim_dissimilarity, &seen->small_rmse, err));
    seen->ssim_dissimilarity += seen->of_view[i];
    seen->small_ssim_dissimilarity += small_ssim_dissimilarity;
    return ISO_OK;
}

iso_status iso_level_gate_look(iso_level_gate *gate, size_t level, const iso_shown_level *shown, iso_level_seen *seen,
                               iso_error *err)
{
    iso_status status = ISO_OK;
    *seen = (iso_level_seen){0};
    for (int i = 0; i < gate->view_count && status == ISO_OK; ++i) {
        iso_view *view = &gate->views[i];
        const iso_tf_table own = view->tf;
        iso_image image = {0};
        view->tf = *shown->tf; /* borrowed, as the scale */
        view->extinction_scale = (uint8_t *)(uintptr_t)shown->scale;
        status = draw(gate, i, shown->level, &image, err);
        view->tf = own;
        view->extinction_scale = NULL;
        TRY(status, compare(gate, i, level, &image, seen, err));
        iso_image_destroy(&image);
    }
    double *const means[] = {&seen->ssim_dissimilarity, &seen->rmse, &seen->small_ssim_dissimilarity,
                             &seen->small_rmse};
    for (size_t k = 0; k < sizeof means / sizeof *means; ++k)
        *means[k] /= gate->view_count;
    return status;
}
