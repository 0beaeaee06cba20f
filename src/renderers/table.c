/* SPDX-License-Identifier: MIT */
/* table.c - the table of renderers, and names. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render/cpu/caster.h"
#include "render/gl/raycaster.h"
#include "renderers/renderers.h"

static const iso_renderer_info *table[ISO_MAX_RENDERERS] = {
#define ISO_RENDERER_ROW(renderer) &renderer,
    ISO_RENDERER_LIST(ISO_RENDERER_ROW)
#undef ISO_RENDERER_ROW
};

size_t iso_renderer_count(void)
{
    size_t count = 0;
    while (count < ISO_MAX_RENDERERS && table[count])
        ++count;
    return count;
}

const iso_renderer_info *iso_renderer_at(size_t index)
{
    return table[index];
}

size_t iso_renderer_index(const iso_renderer_info *r)
{
    size_t i = 0;
    while (table[i] != r)
        ++i;
    return i;
}

const iso_renderer_info *iso_renderers_reference(void)
{
    return &iso_renderer_reference;
}
const iso_renderer_info *iso_renderers_usual(void)
{
    return &iso_renderer_gl;
}

static const iso_renderer_info *find(const char *name)
{
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (strcmp(table[i]->name, name) == 0)
            return table[i];
    return NULL;
}

iso_status iso_renderers_register(const iso_renderer_info *r, iso_error *err)
{
    const size_t count = iso_renderer_count();
    if (find(r->name))
        return iso_fail(err, ISO_E_USAGE, "renderer \"%s\": this name is taken; choose another", r->name);
    if (count == ISO_MAX_RENDERERS)
        return iso_fail(err, ISO_E_RANGE, "renderer \"%s\": the table is full, at most %zu renderers", r->name, count);
    table[count] = r;
    return ISO_OK;
}

/* Joins the names of those with all traits of `has` and none of `lacks`. */
static const char *join_names(unsigned has, unsigned lacks, const char *join, const char *last_join, char *text,
                              size_t size)
{
    size_t wanted = 0, done = 0, length = 0;
    bool takes[ISO_MAX_RENDERERS];
    text[0] = 0;
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        takes[i] = iso_renderer_has(table[i], has) && !(table[i]->traits & lacks);
        wanted += takes[i];
    }
    for (size_t i = 0; i < iso_renderer_count() && length < size; ++i)
        if (takes[i]) {
            const char *between = done == 0 ? "" : done + 1 == wanted ? last_join : join;
            length += (size_t)snprintf(text + length, size - length, "%s%s", between, table[i]->name);
            ++done;
        }
    return text;
}

const char *iso_renderers_with(unsigned traits, const char *join, const char *last_join, char *text, size_t size)
{
    return join_names(traits, 0, join, last_join, text, size);
}

const char *iso_renderers_by_default(unsigned traits, char *text, size_t size)
{
    return join_names(traits, ISO_IS_NAMED, ",", ",", text, size);
}

iso_status iso_renderer_from_name(const char *name, const iso_renderer_info **r, iso_error *err)
{
    char names[256];
    *r = find(name);
    if (*r)
        return ISO_OK;
    return iso_fail(err, ISO_E_USAGE, "unknown renderer \"%s\"; choose from %s", name,
                    iso_renderers_with(0, ", ", " or ", names, sizeof names));
}

iso_status iso_renderers_from_list(const char *list, bool wanted[ISO_MAX_RENDERERS], iso_error *err)
{
    for (size_t i = 0; i < ISO_MAX_RENDERERS; ++i)
        wanted[i] = i < iso_renderer_count() && (iso_renderer_has(table[i], ISO_IS_OF_PICTURES) ||
                                                 (!list && !iso_renderer_has(table[i], ISO_IS_NAMED)));
    wanted[iso_renderer_index(iso_renderers_reference())] = true;
    if (!list)
        return ISO_OK;
    FREED char *copy = strdup(list);
    NEED_MEMORY(copy, err, "out of memory");
    for (char *name, *rest = copy; (name = strsep(&rest, ","));) {
        const iso_renderer_info *r;
        NEED(iso_renderer_from_name(name, &r, err));
        wanted[iso_renderer_index(r)] = true;
    }
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (table[i]->beside)
            wanted[i] = wanted[iso_renderer_index(table[i]->beside)];
    return ISO_OK;
}

/* ---- the choice between the two ray casters if none was named ---- */

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
