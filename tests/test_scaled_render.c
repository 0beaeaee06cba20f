/* SPDX-License-Identifier: MIT */
/* Extinction scales in the renderers: one definition for all (fit/extinction_scale.h). Sizes and spacings are unequal,
 * the grid is rotated. */
#include "lab/vdb_read.h"
#include "rendered.h"
#include "test.h"
#include "cycles.h"
#include "folder.h"

#include "compare/metrics.h"
#include "fit/extinction_scale.h"
#include "render/gl/raycaster.h"
#include "renderers/gl.h"
#include "scene/roi.h"

/* The ray caster: samples in float, some 100 a ray. POV-Ray: 16 bits a channel, half a step is 7.6e-6 of the brightest
 * color. Cycles: the error of a step of an eighth of a voxel, of second order. */
#define GL_MAX_ABS 2e-5
#define GL_RMSE 1e-6
#define POVRAY_MAX_ABS 2e-5
#define POVRAY_RMSE 1e-5
#define CYCLES_RMSE 4e-4

static iso_pyramid noise_pyramid(iso_code code)
{
    const iso_field field = {.kind = ISO_FIELD_NOISE, .geometry = rotated_geometry(22, 27, 17), .seed = 3};
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 2;
    opt.code = code;
    opt.keep_float = true;
    iso_pyramid p = sampled_pyramid(&field, ISO_U8, &opt);
    return p;
}

/* Soft, in colors that differ, so that nothing is left out. */
static iso_view make_view(const iso_pyramid *p)
{
    static iso_tf_point points[] = {{0, {0.9, 0.3, 0.2}, 0},
                                    {0.3, {0.9, 0.3, 0.2}, 0},
                                    {0.55, {0.9, 0.8, 0.3}, 0.2},
                                    {0.7, {0.2, 0.5, 0.9}, 0.02},
                                    {1, {0.3, 0.9, 0.5}, 0.3}};
    const iso_scene scene = scene_of_points(points, 5);
    return view_of(&scene, p);
}

/* ---- scales, right and wrong ----------------------------------------------------------- */

typedef enum fault { RIGHT, SWAPPED_AXES, HALF_A_VOXEL_OFF, IGNORED, UPSIDE_DOWN, FAULT_COUNT } fault;

/* Waves of a factor of 3 to both sides, of another length along each axis. */
static double wave(double x, double y, double z)
{
    return ISO_EXTINCTION_SCALE_ONE + 45 * sin(0.9 * x + 0.3) * cos(0.6 * y) * cos(0.45 * z - 0.4);
}

static uint8_t *make_scale(const iso_pyramid *p, fault which)
{
    const size_t *n = p->levels[1].geometry.size;
    uint8_t *bytes = malloc(n[0] * n[1] * n[2]);
    for (size_t i = 0; i < n[0] * n[1] * n[2]; ++i) {
        const double x = (double)(i % n[0]), y = (double)(i / n[0] % n[1]), z = (double)(i / (n[0] * n[1]));
        const double byte = which == SWAPPED_AXES       ? wave(y, x, z)
                            : which == HALF_A_VOXEL_OFF ? wave(x + 0.5, y + 0.5, z + 0.5)
                                                        : wave(x, y, z);
        bytes[i] = which == IGNORED       ? ISO_EXTINCTION_SCALE_ONE
                   : which == UPSIDE_DOWN ? (uint8_t)lrint(2 * ISO_EXTINCTION_SCALE_ONE - byte)
                                          : (uint8_t)lrint(byte);
    }
    return bytes;
}

static iso_image render(const iso_pyramid *p, const iso_view *own, uint8_t *scale, const iso_render_options *opt)
{
    iso_view view = *own; /* lent */
    iso_image image;
    view.extinction_scale = scale;
    assert_ok(iso_render_with(&(iso_render_request){&renderers, p, 1, &view, opt, NULL}, &image, NULL, &err));
    return image;
}

static iso_metrics compare(const iso_image *a, const iso_image *b)
{
    iso_metrics m;
    assert_ok(iso_metrics_measure(a, b, &m, &err));
    return m;
}

/* The renderer meets the reference with the scale, and no faulty scale of the reference would have passed. */
static void check_renderer(const iso_pyramid *p, const iso_view *view, const iso_render_options *with,
                           const iso_render_options *reference, double max_abs, double rmse)
{
    FREED uint8_t *scale = make_scale(p, RIGHT);
    OWNED(iso_image) have = render(p, view, scale, with);
    for (int f = 0; f < FAULT_COUNT; ++f) {
        FREED uint8_t *other = make_scale(p, (fault)f);
        OWNED(iso_image) want = render(p, view, other, reference);
        const iso_metrics m = compare(&have, &want);
        print_message("%s, %s, fault %d: rmse %.3g, max %.3g\n", with->renderer->name,
                      iso_direction_source_name(with->source), f, m.rmse, m.max_abs);
        if (f == RIGHT) {
            assert_at_most(m.max_abs, max_abs);
            assert_at_most(m.rmse, rmse);
        } else {
            assert_more_than(m.rmse, 2.5 * rmse); /* with a margin */
        }
    }
}

/* ---- the ray caster -------------------------------------------------------------------- */

/* In the alpha of signed and unsigned codes and of floats, and in a texture of its own where directions have none. */
TEST(the_ray_caster_scales_by_any_directions)
{
    static const iso_code codes[] = {ISO_CODE_SNORM, ISO_CODE_CUBE};
    static const iso_direction_source sources[] = {ISO_FROM_CODES, ISO_FROM_DECODED, ISO_FROM_FLOAT, ISO_FROM_FLIPPED,
                                                   ISO_FROM_ON_THE_FLY};
    for (int c = 0; c < 2; ++c) {
        OWNED(iso_pyramid) p = noise_pyramid(codes[c]);
        OWNED(iso_view) view = make_view(&p);
        for (size_t s = 0; s < sizeof sources / sizeof *sources; ++s) {
            iso_render_options with = iso_render_defaults(&iso_renderer_gl),
                               reference = iso_render_defaults(&iso_renderer_reference);
            reference.quadrature = ISO_QUADRATURE_MIDPOINT;
            with.source = reference.source = sources[s];
            check_renderer(&p, &view, &with, &reference, GL_MAX_ABS, GL_RMSE);
        }
    }
}

TEST(the_ray_caster_scales_means_and_exact_lookups)
{
    OWNED(iso_pyramid) p = noise_pyramid(ISO_CODE_SNORM);
    OWNED(iso_view) view = make_view(&p);
    iso_render_options with = iso_render_defaults(&iso_renderer_gl),
                       reference = iso_render_defaults(&iso_renderer_reference);
    with.quadrature = reference.quadrature = ISO_QUADRATURE_PREINTEGRATED;
    check_renderer(&p, &view, &with, &reference, GL_MAX_ABS, GL_RMSE);
    with.quadrature = reference.quadrature = ISO_QUADRATURE_MIDPOINT;
    with.exact_lookups = true;
    check_renderer(&p, &view, &with, &reference, 1e-5, 5e-7); /* gl.c: what exact lookups leave */
}

/* Bricks that the transfer function does not show are not shown by a scale either. */
TEST(empty_bricks_stay_empty)
{
    OWNED(iso_pyramid) p = noise_pyramid(ISO_CODE_SNORM);
    OWNED(iso_view) view = make_view(&p);
    iso_image images[2];
    iso_gl *gl;
    view.extinction_scale = make_scale(&p, RIGHT);
    assert_ok(iso_renderers_need_gl(&renderers, &gl, &err));
    for (int i = 0; i < 2; ++i) {
        iso_gl_options opt = iso_gl_defaults();
        opt.skip = i ? ISO_GL_SKIP_ALWAYS : ISO_GL_SKIP_NEVER;
        opt.brick_voxels = 2;
        assert_ok(iso_gl_render(gl, &p.levels[1], p.options.code, &view, &opt, &images[i], &err));
    }
    assert_at_most(compare(&images[0], &images[1]).max_abs, 2e-6);
    iso_image_destroy(&images[0]);
    iso_image_destroy(&images[1]);
}

/* A region of interest has a finer level, which is not scaled; what lies around it is. */
TEST(the_level_around_a_region_of_interest_is_scaled)
{
    OWNED(iso_pyramid) p = noise_pyramid(ISO_CODE_SNORM);
    OWNED(iso_view) view = make_view(&p);
    iso_render_options with = iso_render_defaults(&iso_renderer_gl),
                       reference = iso_render_defaults(&iso_renderer_reference);
    iso_roi_options options = iso_roi_defaults();
    iso_roi *roi = calloc(1, sizeof *roi);
    assert_non_null(roi);
    options = (iso_roi_options){{4, 6, 3}, {14, 16, 10}, 0, options.band};
    assert_ok(iso_roi_create(&p, 1, &view.tf, &options, roi, &err));
    view.roi = roi;
    reference.quadrature = ISO_QUADRATURE_MIDPOINT;
    check_renderer(&p, &view, &with, &reference, GL_MAX_ABS, GL_RMSE);
}

/* ---- programs -------------------------------------------------------------------------- */

TEST(povray_scales_by_a_second_density)
{
    OWNED(iso_pyramid) p = noise_pyramid(ISO_CODE_SNORM);
    OWNED(iso_view) view = make_view(&p);
    iso_render_options with = iso_render_defaults(&iso_renderer_povray),
                       reference = iso_render_defaults(&iso_renderer_reference);
    reference.quadrature = ISO_QUADRATURE_POVRAY;
    with.intervals = reference.intervals = 60;
    check_renderer(&p, &view, &with, &reference, POVRAY_MAX_ABS, POVRAY_RMSE);
}

VALUES_TEST(cycles_scales_by_a_grid)
{
    need_cycles();
    OWNED(iso_pyramid) p = noise_pyramid(ISO_CODE_SNORM);
    OWNED(iso_view) view = make_view(&p);
    iso_render_options with = iso_render_defaults(&iso_renderer_cycles),
                       reference = iso_render_defaults(&iso_renderer_reference);
    with.step_voxels = 0.125;
    check_renderer(&p, &view, &with, &reference, 1, CYCLES_RMSE);
}

TEST(the_grid_holds_log2_of_the_scale)
{
    OWNED(iso_pyramid) p = noise_pyramid(ISO_CODE_SNORM);
    const size_t *n = p.levels[1].geometry.size, count = n[0] * n[1] * n[2];
    FREED uint8_t *scale = make_scale(&p, RIGHT);
    FREED float *read = malloc(count * sizeof *read);
    FREED char *path = iso_path_join(folder, "scaled.vdb");
    iso_vdb_options opt = iso_vdb_defaults();
    opt.extinction_scale = scale;
    assert_ok(iso_vdb_save(&p, 1, 1, path, &opt, NULL, &err));
    assert_ok(iso_vdb_load_grid(path, "log2_extinction_scale", 1, n, read, NULL, &err));
    for (size_t i = 0; i < count; ++i)
        assert_within((double)read[i], iso_extinction_scale_log2(scale[i]), 1e-6);
    assert_status(iso_vdb_save(&p, 0, 2, path, &opt, NULL, &err), ISO_E_RANGE);
}

static int end_all(void **state)
{
    end_renderers(state);
    return remove_folder(state);
}

TEST_MAIN(make_folder, end_all)
