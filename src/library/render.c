/* SPDX-License-Identifier: MIT */
/* render.c - rendering of the library's interface. */
#include "library/shared.h"
#include "renderers/renderers.h"

iso_frame_options iso_frame_defaults(void)
{
    return (iso_frame_options){.renderer = iso_renderers_reference()->name,
                               .shading = iso_direction_source_name(ISO_FROM_CODES)};
}

static iso_status check_limits(const iso_frame_options *given, iso_error *err)
{
    if (!(given->step_voxels >= 0 && given->step_voxels <= 100))
        return iso_fail(err, ISO_E_RANGE, "step_voxels is %g, must be 0 to 100", given->step_voxels);
    if (given->samples < 0 || given->samples > 65536)
        return iso_fail(err, ISO_E_RANGE, "samples is %d, must be 0 to 65536", given->samples);
    return ISO_OK;
}

/* Refuses an option that the renderer would ignore: its user would rely on it. */
static iso_status check_for_renderer(const iso_renderer_info *r, const iso_frame_options *given,
                                     const iso_render_options *o, iso_error *err)
{
    const struct {
        const char *option;
        bool given;
        unsigned trait;
    } rules[] = {{"shading", o->source != ISO_FROM_CODES, ISO_READS_SOURCE},
                 {"samples", given->samples != 0, ISO_READS_SAMPLES},
                 {"seed", given->seed != 0, ISO_READS_SEED}};
    for (size_t i = 0; i < sizeof rules / sizeof *rules; ++i)
        if (rules[i].given && !iso_renderer_has(r, rules[i].trait))
            return iso_fail(err, ISO_E_USAGE, "%s does not have the option \"%s\"", r->name, rules[i].option);
    return ISO_OK;
}

static iso_status take_options(const iso_frame_options *given, iso_render_options *o, iso_error *err)
{
    const iso_renderer_info *renderer = iso_renderers_reference();
    NEED(check_limits(given, err));
    if (given->renderer)
        NEED(iso_renderer_from_name(given->renderer, &renderer, err));
    *o = iso_render_defaults(renderer);
    if (given->shading)
        NEED(iso_direction_source_from_name(given->shading, &o->source, err));
    o->step_voxels = given->step_voxels;
    if (o->step_voxels > 0 && o->quadrature == ISO_QUADRATURE_CONVERGED)
        o->quadrature = ISO_QUADRATURE_MIDPOINT;
    o->samples = given->samples;
    o->seed = given->seed;
    o->threads = given->threads;
    return check_for_renderer(renderer, given, o, err);
}

iso_status iso_render(const iso_pyramid *pyramid, const iso_scene *scene, const iso_frame_options *options,
                      iso_image *image, iso_error *err)
{
    const iso_frame_options given = options ? *options : iso_frame_defaults();
    iso_render_options o;
    iso_renderers renderers = {0};
    iso_view view = {0};
    iso_call call;
    *image = (iso_image){0};
    iso_call_begin(&call, given.progress, given.progress_user);
    iso_status status = take_options(&given, &o, err);
    TRY(status, iso_pyramid_check_level(pyramid, NULL, given.level, err));
    TRY(status, iso_library_view(&(iso_library_look){scene, given.tf, given.width, given.height, given.adapt,
                                                     given.extinction_scale, given.region, given.threads},
                                 pyramid, given.level, &view, err));
    TRY(status, iso_render_with(&(iso_render_request){&renderers, pyramid, given.level, &view, &o, &call.progress},
                                image, NULL, err));
    TRY(status, iso_progress_check(&call.progress, err));
    TRY(status, iso_render_check_finite(o.renderer, image, err));
    if (status != ISO_OK)
        iso_image_destroy(image);
    iso_renderers_end(&renderers);
    iso_view_destroy(&view);
    return iso_call_end(&call, status, err);
}
