/* SPDX-License-Identifier: MIT */
#include "bake/bake_error.h"

#include "render/reference_ray.h"

/* Step in smallest spacings of the level, for both pictures, so that their samples coincide. */
static const double step_voxels = 0.125;

typedef struct baked_field {
    const iso_baked *baked;
    iso_baked_pair pair;
    iso_sampler directions; /* of the level */
    bool is_lit;
} baked_field;

static double emit(const iso_emitter *e, const iso_emitter_place *at, double color[3])
{
    const baked_field *f = e->field;
    const double extinction = iso_baked_sample(f->baked, f->pair, at->index, color);
    if (!(extinction > 0) || !f->is_lit) {
        for (int c = 0; c < 3; ++c)
            color[c] *= at->view->shading.ambient;
        return extinction;
    }
    const iso_vec3 normal = iso_sample_normal(&f->directions, iso_baked_in_level(f->baked, at->index));
    const double shade = iso_shade(at->view, normal, at->to_viewer);
    for (int c = 0; c < 3; ++c)
        color[c] *= shade;
    return extinction;
}

/* Sets the step; 0: converged. */
static void set_step(iso_reference_options *o, double voxels)
{
    o->quadrature = voxels > 0 ? ISO_QUADRATURE_MIDPOINT : ISO_QUADRATURE_CONVERGED;
    o->step_voxels = voxels;
}

iso_status iso_baked_render(const iso_baked *b, iso_baked_pair pair, const iso_view *view, double voxels,
                            iso_image *image, const iso_progress *progress, iso_error *err)
{
    /* The lattice as a level without values: the emitter provides all samples, and cells end at its points. */
    const iso_level lattice = {.geometry = b->geometry, .min = b->level->min, .max = b->level->max};
    baked_field field = {.baked = b, .pair = pair, .is_lit = view->light_count > 0};
    const iso_emitter emitter = {emit, &field};
    iso_reference_options o = iso_reference_defaults();
    iso_view clipless = *view; /* the grid is already clipped */
    clipless.clip_count = 0;
    clipless.extinction_scale = NULL;
    set_step(&o, voxels * (double)b->options.points); /* the lattice's voxels are smaller */
    o.emitter = &emitter;
    o.source = ISO_FROM_ON_THE_FLY;
    o.threads = b->options.threads;
    iso_status status = iso_sampler_create(&field.directions, b->level, b->code, ISO_FROM_CODES, err);
    TRY(status, iso_reference_render(&lattice, b->code, &clipless, &o, image, progress, err));
    iso_sampler_destroy(&field.directions);
    return status;
}

static iso_status compare(const iso_baked *b, iso_baked_pair pair, const iso_view *view, const iso_image *exact,
                          iso_bake_difference *out, const iso_progress *progress, iso_error *err)
{
    OWNED(iso_image) image = {0};
    NEED(iso_baked_render(b, pair, view, step_voxels, &image, progress, err));
    iso_metrics metrics = {0};
    NEED(iso_metrics_measure(&image, exact, &metrics, err));
    *out = (iso_bake_difference){metrics.rmse, metrics.max_abs};
    return ISO_OK;
}

static iso_status render_exact(const iso_baked *b, const iso_view *view, iso_image *image, const iso_progress *progress,
                               iso_error *err)
{
    iso_reference_options o = iso_reference_defaults();
    set_step(&o, step_voxels);
    o.threads = b->options.threads;
    return iso_reference_render(b->level, b->code, view, &o, image, progress, err);
}

/* Returns the view with at most `pixels` along its longer side; 0: unchanged. */
static iso_view measured_view(const iso_baked *b, size_t pixels)
{
    iso_view view = *b->view;
    const size_t longer = view.width > view.height ? view.width : view.height;
    if (pixels > 0 && pixels < longer) {
        view.width = (view.width * pixels + longer - 1) / longer;
        view.height = (view.height * pixels + longer - 1) / longer;
    }
    return view;
}

static void take_light_away(iso_view *view)
{
    view->shading = (iso_shading){.ambient = 1};
    view->light_count = 0;
}

iso_status iso_bake_measure_shaded(const iso_baked *b, size_t pixels, iso_bake_error *out, const iso_progress *progress,
                                   iso_error *err)
{
    OWNED(iso_image) exact = {0};
    iso_view view = measured_view(b, pixels);
    *out = (iso_bake_error){.width = view.width, .height = view.height};
    NEED(render_exact(b, &view, &exact, progress, err));
    take_light_away(&view); /* the colors already include it */
    return compare(b, ISO_BAKED_COLORS, &view, &exact, &out->lit, progress, err);
}

iso_status iso_bake_measure(const iso_baked *b, bool emission, size_t pixels, iso_bake_error *out,
                            const iso_progress *progress, iso_error *err)
{
    OWNED(iso_image) exact = {0};
    iso_view view = measured_view(b, pixels);
    *out = (iso_bake_error){.width = view.width, .height = view.height, .has_emission = emission};
    NEED(render_exact(b, &view, &exact, progress, err));
    NEED(compare(b, ISO_BAKED_COLORS, &view, &exact, &out->lit, progress, err));
    iso_image_destroy(&exact);
    take_light_away(&view);
    NEED(render_exact(b, &view, &exact, progress, err));
    NEED(compare(b, ISO_BAKED_COLORS, &view, &exact, &out->unlit, progress, err));
    return emission ? compare(b, ISO_BAKED_EMISSION, &view, &exact, &out->emission, progress, err) : ISO_OK;
}
