/* SPDX-License-Identifier: MIT */
#include "cli/render.h"

#include <stdio.h>
#include <string.h>

#include "base/words.h"
#include "brick/bricks.h"

/* Returns the names of renderers with a trait: "reference or gl". */
static const char *or_list(unsigned trait, char names[256])
{
    return iso_renderers_with(trait, ", ", " or ", names, 256);
}

/* Refuses options that the renderer would ignore. */
static iso_status check_for_renderer(const iso_render_arguments *a, const iso_renderer_info *renderer, iso_error *err)
{
    const struct {
        const char *option;
        bool given;
        unsigned trait;
    } rules[] = {
        {"--quadrature", a->quadrature != NULL, ISO_READS_QUADRATURE},
        {"--shading-from", a->source != NULL, ISO_READS_SOURCE},
        {"--intervals", a->intervals != 0, ISO_READS_INTERVALS},
        {"--planes", a->planes != 0, ISO_READS_PLANES},
        {"--samples", a->samples != 0, ISO_READS_SAMPLES},
        {"--seed", a->seed != 0, ISO_READS_SEED},
        {"--shader-dir", a->shader_dir != NULL, ISO_READS_SHADERS},
        {"--shade-table", a->shade_table != 0, ISO_READS_SHADE_TABLE},
        {"--exact-lookups", a->exact_lookups != 0, ISO_READS_EXACT_LOOKUPS},
    };
    char names[256];
    for (size_t i = 0; i < sizeof rules / sizeof *rules; ++i)
        if (rules[i].given && !iso_renderer_has(renderer, rules[i].trait))
            return iso_fail(err, ISO_E_USAGE, "%s needs --with %s", rules[i].option, or_list(rules[i].trait, names));
    return ISO_OK;
}

static const struct {
    const char *name;
    iso_quadrature value;
} quadratures[] = {{"converged", ISO_QUADRATURE_CONVERGED},
                   {"midpoint", ISO_QUADRATURE_MIDPOINT},
                   {"preintegrated", ISO_QUADRATURE_PREINTEGRATED},
                   {"povray", ISO_QUADRATURE_POVRAY}};
enum { quadrature_count = sizeof quadratures / sizeof *quadratures };

const char *iso_render_list_quadratures(const iso_renderer_info *renderer, bool mark, char text[160])
{
    size_t wanted = 0, done = 0, length = 0;
    text[0] = 0;
    for (size_t i = 0; i < quadrature_count; ++i)
        wanted += renderer->quadratures >> quadratures[i].value & 1;
    for (size_t i = 0; i < quadrature_count && length < 160; ++i)
        if (renderer->quadratures >> quadratures[i].value & 1) {
            length += (size_t)snprintf(text + length, 160 - length, "%s%s%s",
                                       done == 0           ? ""
                                       : done + 1 < wanted ? ", "
                                                           : " or ",
                                       quadratures[i].name,
                                       mark && quadratures[i].value == renderer->defaults.quadrature ? " (default)"
                                                                                                     : "");
            ++done;
        }
    return text;
}

static iso_status take_quadrature(const char *word, const iso_renderer_info *renderer, iso_quadrature *quadrature,
                                  iso_error *err)
{
    char wanted[160];
    for (size_t i = 0; i < quadrature_count; ++i)
        if (strcmp(quadratures[i].name, word) == 0 && renderer->quadratures >> quadratures[i].value & 1) {
            *quadrature = quadratures[i].value;
            return ISO_OK;
        }
    return iso_fail(err, ISO_E_USAGE, "--quadrature is \"%s\", must be %s", word,
                    iso_render_list_quadratures(renderer, false, wanted));
}

bool iso_render_is_in_bricks(const iso_render_arguments *a)
{
    return a->cache_bytes != ISO_NO_CACHE || a->plan_error > 0;
}

/* Checks --cache-bytes and --plan-error: bricks fix the levels, and are decoded by the ray caster. */
static iso_status check_cache(const iso_render_arguments *a, const iso_renderer_info *renderer, iso_error *err)
{
    char names[256];
    if (!iso_render_is_in_bricks(a))
        return a->page_side ? iso_fail(err, ISO_E_USAGE, "--page-side needs --cache-bytes or --plan-error") : ISO_OK;
    if (a->cache_bytes != ISO_NO_CACHE && a->plan_error > 0)
        return iso_fail(err, ISO_E_USAGE, "--cache-bytes and --plan-error exclude each other");
    if (!iso_renderer_has(renderer, ISO_HAS_BRICKS) || a->level != 0 || a->source || a->palette || a->shade_table ||
        a->exact_lookups || a->isosurface || a->quadrature || a->adapted.wanted || a->adapted.extinction_scale ||
        a->roi.box)
        return iso_fail(
            err, ISO_E_USAGE,
            "--cache-bytes and --plan-error need --with %s, without --level, --shading-from, --palette, --shade-table, "
            "--exact-lookups, --isosurface, --quadrature, --adapt, --extinction-scale and --roi",
            or_list(ISO_HAS_BRICKS, names));
    if (a->page_side && renderer == &iso_renderer_cpu)
        return iso_fail(err, ISO_E_USAGE, "--page-side is a limit of textures, without effect for --with cpu");
    return ISO_OK;
}

/* Checks --limit, whose renders may differ only in their steps. */
static iso_status check_limit(const iso_render_arguments *a, const iso_renderer_info *renderer, iso_error *err)
{
    char names[256];
    if (!a->limit)
        return a->seeds ? iso_fail(err, ISO_E_USAGE, "--seeds needs --limit") : ISO_OK;
    if (!iso_renderer_has(renderer, ISO_HAS_LIMIT) || a->quadrature || a->source || a->isosurface || a->samples ||
        a->shade_table || a->exact_lookups || iso_render_is_in_bricks(a))
        return iso_fail(err, ISO_E_USAGE,
                        "--limit needs --with %s, without --quadrature, --shading-from, "
                        "--isosurface, --samples, --shade-table, --exact-lookups, --cache-bytes and --plan-error",
                        or_list(ISO_HAS_LIMIT, names));
    if (a->intervals % 2)
        return iso_fail(err, ISO_E_USAGE, "--intervals is %d, must be even with --limit, which halves them",
                        a->intervals);
    if (a->seeds && !iso_renderer_has(renderer, ISO_IS_RANDOM))
        return iso_fail(err, ISO_E_USAGE, "--seeds needs --with %s", or_list(ISO_IS_RANDOM, names));
    return ISO_OK;
}

iso_status iso_render_take_options(const iso_render_arguments *a, int threads, iso_render_options *opt, iso_error *err)
{
    const iso_renderer_info *renderer;
    NEED(iso_renderer_from_name(a->with ? a->with : iso_renderers_usual()->name, &renderer, err));
    *opt = iso_render_defaults(renderer);
    if (a->source)
        NEED(iso_direction_source_from_name(a->source, &opt->source, err));
    NEED(iso_words_check_range("--intervals", a->intervals, 0,
                               renderer->max_intervals ? (double)renderer->max_intervals : 1e6, err));
    NEED(check_for_renderer(a, renderer, err));
    NEED(check_cache(a, renderer, err));
    NEED(check_limit(a, renderer, err));
    if (a->quadrature)
        NEED(take_quadrature(a->quadrature, renderer, &opt->quadrature, err));
    if (a->isosurface) {
        double value[3];
        NEED(iso_words_parse_numbers(a->isosurface, "--isosurface", value, err));
        opt->isosurface = true;
        opt->iso = value[0];
    }
    if (a->step != ISO_STEP_OF_SCENE) /* otherwise the step of renderers.json, or the renderer's own */
        opt->step_voxels = a->step;
    opt->intervals = (size_t)a->intervals;
    opt->planes = (size_t)a->planes;
    opt->samples = a->samples;
    opt->seed = a->seed;
    opt->threads = threads;
    opt->shade_table = a->shade_table;
    opt->exact_lookups = a->exact_lookups;
    return ISO_OK;
}
