/* SPDX-License-Identifier: MIT */
/* cmd_list.c - the tables that the program is made of: formats, codes, estimators, targets. */
#include <stdio.h>

#include "blender/blender.h"
#include "encode/code.h"
#include "gradient/gradient.h"
#include "options/cli.h"
#include "palette/palette.h"
#include "pyramid/pyramid.h"
#include "renderers/external.h"
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
    &iso_field_names,         &iso_export_target_names,    &iso_blender_material_names, &iso_cycles_device_names, &iso_bake_grid_names,
    &iso_grid_program_names,  &iso_tf_preset_names,        &iso_viewpoint_names,
};
enum { LIST_COUNT = sizeof lists / sizeof *lists + 1 }; /* and the renderers, whose table may grow at run time */

static const iso_names *list_at(size_t i)
{
    static const iso_renderer_info *renderers[ISO_MAX_RENDERERS];
    static iso_names names = {"renderer",
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
    printf("## %ss\n\n| name | what it is |\n|---|---|\n", names->what);
    for (size_t i = 0; i < names->count; ++i)
        printf("| `%s` | %s |\n", iso_names_name(names, i), iso_names_summary(names, i));
}

static iso_status list(const iso_cli *cli, bool markdown)
{
    json_t *all = json_array();
    if (markdown && !cli->json)
        printf(
            "# Names\n\nWhat isoshade reads, writes and chooses from, by the names that its options take. Made by `isoshade list --markdown`\n"
            "from the program's tables; [extending.md](extending.md) shows how a row is added.\n\n");
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
    if (cli->json) {
        json_t *root = iso_cli_json(cli);
        json_object_set(root, "lists", all);
        iso_cli_print_json(root);
    }
    json_decref(all);
    return ISO_OK;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    int markdown = 0;
    char *renderers = NULL;
    struct poptOption options[] = {
        {"markdown", 0, POPT_ARG_NONE, &markdown, 0, "as a document: doc/names.md", NULL},
        ISO_CLI_RENDERERS_OPTION(&renderers),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = iso_renderers_load(renderers, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = list(&cli, markdown);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_command_list = {
    .name = "list",
    .summary = "list formats, direction codes, estimators and all else that has a name",
    .usage = "[--markdown] [--renderers FILE.json]",
    .examples = "  isoshade list\n"
                "  isoshade list --json\n",
    .run = run,
};
