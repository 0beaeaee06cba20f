/* SPDX-License-Identifier: MIT */
/* choose.c - the choice between the two ray casters if none was named. */
#include "render/cpu/caster.h"
#include "render/gl/raycaster.h"
#include "renderers/renderers.h"

const iso_renderer_info *iso_renderers_instead(void)
{
    return &iso_renderer_cpu;
}

void iso_renderers_choose(const iso_pyramid *p, const iso_view *view, iso_render_options *opt)
{
    const iso_renderer_info *cpu = &iso_renderer_cpu;
    const bool has_all = !opt->isosurface && !opt->shade_table && !opt->exact_lookups &&
                         opt->quadrature == ISO_QUADRATURE_MIDPOINT && !iso_renderer_lacks(cpu, p, view, false) &&
                         iso_cpu_takes(&p->levels[0].geometry);
    if (opt->renderer == iso_renderers_usual() && has_all && iso_gl_is_software())
        opt->renderer = cpu;
}
