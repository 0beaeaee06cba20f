/* SPDX-License-Identifier: MIT */
/* cmd_list.c - lists the program's tables: formats, codes, estimators, targets and others. */
#include <stdio.h>

#include "base/sandbox.h"
#include "blender/blender.h"
#include "encode/code.h"
#include "figure/job.h"
#include "gradient/gradient.h"
#include "options/cli.h"
#include "palette/palette.h"
#include "pyramid/pyramid.h"
#include "renderers/external.h"
#include "render/gl/raycaster.h"
#include "scene/field.h"
#include "targets/targets.h"
#include "scene/viewpoint.h"
#include "tf/format.h"
#include "tf/presets.h"
#include "volume/format.h"
#include "volume/synthetic.h"

static const iso_names *const lists[] = {
    &iso_volume_format_names, &iso_tf_format_names,        &iso_gradient_names,         &iso_code_names,
    &iso_scalar_filter_names, &iso_direction_filter_names, &iso_direction_source_names, &iso_palette_method_names,
    &iso_field_names,         &iso_export_target_names,    &iso_blender_material_names, &iso_cycles_device_names,
    &iso_bake_grid_names,     &iso_grid_program_names,     &iso_tf_preset_names,        &iso_viewpoint_names,
    &iso_figure_kind_names,   &iso_colormap_names,
};
enum { LIST_COUNT = sizeof lists / sizeof *lists + 1 }; /* and the renderers, whose table may grow at run time */

static const iso_names *list_at(size_t i)
{
    static const iso_renderer_info *renderers[ISO_MAX_RENDERERS];
    static iso_names names = {"renderer",
                              "renderers",
                              renderers,
                              0,
                              sizeof renderers[0],
                              offsetof(iso_renderer_info, name),
                              offsetof(iso_renderer_info, title),
                              true};
    if (i + 1 < LIST_COUNT)
        return lists[i];
    names.count = iso_renderer_count();
    for (size_t r = 0; r < names.count; ++r)
        renderers[r] = iso_renderer_at(r);
    return &names;
}

static json_t *to_json(const iso_names *names)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < names->count; ++i)
        json_array_append_new(rows, json_pack("{s:s, s:s}", "name", iso_names_name(names, i), "summary",
                                              iso_names_summary(names, i)));
    return json_pack("{s:s, s:o}", "what", names->what, "rows", rows);
}

static void print_markdown(const iso_names *names)
{
    printf("## %s\n\n", names->plural);
    for (size_t i = 0; i < names->count; ++i)
        printf("- `%s`: %s\n", iso_names_name(names, i), iso_names_summary(names, i));
}

static iso_status list(const iso_cli *cli, bool markdown)
{
    json_auto_t *all = json_array();
    if (markdown && !cli->json)
        printf("# Names\n\nThe values of options. `make reference` writes this page from the program's tables;\n"
               "[extending.md](../extending.md) shows how to add a row.\n\n");
    for (size_t i = 0; i < LIST_COUNT; ++i) {
        if (cli->json) {
            json_array_append_new(all, to_json(list_at(i)));
            continue;
        }
        if (i > 0)
            putchar('\n');
        if (markdown)
            print_markdown(list_at(i));
        else
            iso_cli_print_names(stdout, list_at(i));
    }
    char sandbox[200];
    iso_sandbox_describe(sandbox, sizeof sandbox);
    if (!cli->json && !markdown) /* depends on the machine, unlike the tables */
        printf("\nsandbox:\n  %s\n", sandbox);
    if (cli->json)
        iso_cli_print_results(cli, json_pack("{s:O, s:s}", "lists", all, "sandbox", sandbox));
    return ISO_OK;
}

/* ---- devices of OpenGL, which depend on the machine ---- */

static json_t *device_json(const char *choice, const iso_gl_info *info, const char *why)
{
    if (!info)
        return json_pack("{ss ss}", "choice", choice, "why", why);
    return json_pack("{ss ss ss ss ss si si si si}", "choice", choice, "device", info->device, "vendor", info->vendor,
                     "renderer", info->renderer, "version", info->version, "filter_bits_unorm8",
                     info->filter_bits_unorm8, "filter_bits_unorm16", info->filter_bits_unorm16, "filter_bits_float",
                     info->filter_bits_float, "timer_bits", info->timer_bits);
}

/* Adds a row for a device; if it cannot be opened, with the reason. */
static void list_device(const char *choice, json_t *rows)
{
    iso_gl *gl = NULL;
    iso_error why = {{0}};
    static const iso_gl_info none;
    const bool there = iso_gl_create_on(&gl, choice, NULL, &why) == ISO_OK;
    const iso_gl_info info = there ? iso_gl_describe(gl) : none;
    if (rows)
        json_array_append_new(rows, device_json(choice, there ? &info : NULL, why.text));
    else if (!there)
        printf("%-12s %s\n", choice, why.text);
    else
        printf("%-12s %s: %s, OpenGL %s\n"
               "             linear filter of %d bits (8-bit textures), %d (16-bit), %d (float); timer of %d bits\n",
               choice, info.vendor, info.renderer, info.version, info.filter_bits_unorm8, info.filter_bits_unorm16,
               info.filter_bits_float, info.timer_bits);
    iso_gl_destroy(gl);
}

static iso_status list_gl(const iso_cli *cli)
{
    json_t *rows = cli->json ? json_array() : NULL;
    const size_t count = iso_gl_device_count();
    for (size_t i = 0; i < count; ++i) {
        char choice[24];
        snprintf(choice, sizeof choice, "%zu", i);
        list_device(choice, rows);
    }
    list_device("surfaceless", rows);
    if (rows)
        iso_cli_print_results(cli, json_pack("{s:o}", "gl_devices", rows));
    return ISO_OK;
}

typedef struct list_options {
    int markdown, gl;
    char *renderers;
} list_options;

static const iso_option options[] = {
    {"markdown", 0, "print as Markdown: doc/reference/names.md", NULL, ISO_IN(list_options, markdown)},
    {"gl", 0, "list devices for --gl-device, with the bits of their linear filter", NULL, ISO_IN(list_options, gl)},
    ISO_CLI_RENDERERS_OPTION(list_options, renderers),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const list_options *o = values;
    NEED(iso_renderers_load(o->renderers, err));
    return o->gl ? list_gl(cli) : list(cli, o->markdown);
}

const iso_command iso_command_list = {
    .name = "list",
    .summary = "list formats, direction codes, estimators and all other names",
    .usage = "[--markdown] [--renderers FILE.json] | --gl",
    .examples = "  isoshade list\n"
                "  isoshade list --json\n"
                "  isoshade list --gl\n",
    .options = options,
    .options_size = sizeof(list_options),
    .run = run,
};
