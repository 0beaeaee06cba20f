/* SPDX-License-Identifier: MIT */
/* cmd_atlas.c - writes the failure atlas as a folder: page, pictures, figures. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "atlas/atlas.h"
#include "options/cli.h"

/* Marks the cases of --case ID,ID in `wanted`; all without the option. */
static iso_status choose(const char *list, bool *wanted, iso_error *err)
{
    for (size_t i = 0; i < iso_atlas_case_count; ++i)
        wanted[i] = !list;
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL) {
        char id[64];
        snprintf(id, sizeof id, "%.*s", (int)strcspn(at, ","), at);
        const iso_atlas_case *c = iso_atlas_find(id);
        if (!c) {
            char names[1024] = "";
            for (size_t i = 0; i < iso_atlas_case_count; ++i)
                snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", i ? ", " : "",
                         iso_atlas_cases[i].id);
            return iso_fail(err, ISO_E_USAGE, "--case: unknown case \"%s\", must be one of: %s", id, names);
        }
        wanted[c - iso_atlas_cases] = true;
    }
    return ISO_OK;
}

static void print_case(const iso_atlas_case *c, const iso_atlas_result *r)
{
    printf("%-20s failure %-9.3g fallback %-9.3g %s%s\n", c->id, r->values[ISO_ATLAS_FAILURE],
           r->values[ISO_ATLAS_FALLBACK], iso_atlas_measure(c), iso_atlas_is_valid(c, r) ? "" : "  (out of date)");
}

static iso_status make_cases(const iso_cli *cli, const bool *wanted, iso_atlas_page *page, size_t *fallen,
                             iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    for (size_t i = 0; i < iso_atlas_case_count; ++i)
        if (wanted[i])
            iso_cli_expect(cli, &(iso_cli_stage){iso_atlas_cases[i].id, 1}, 1);
    for (size_t i = 0; i < iso_atlas_case_count; ++i) {
        const iso_atlas_case *c = &iso_atlas_cases[i];
        ENDED_BY(iso_atlas_clear) iso_atlas_result r = {0};
        if (!wanted[i])
            continue;
        iso_progress_report(&progress, c->id, 0);
        NEED(iso_atlas_run(c, &r, err));
        NEED(iso_atlas_page_add(page, c, &r, err));
        *fallen += !iso_atlas_is_valid(c, &r);
        iso_progress_line_hide(cli->progress);
        if (!cli->json)
            print_case(c, &r);
    }
    return ISO_OK;
}

static iso_status write_page(const char *dir, const json_t *root, const char *sections, iso_error *err)
{
    FREED char *text = NULL, *page = iso_path_join(dir, "index.html"), *data = iso_path_join(dir, "atlas.json");
    size_t size = 0;
    FILE *html = open_memstream(&text, &size);
    iso_status status = page && data && html ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (html) {
        iso_atlas_page_begin(html, json_object_get(root, "cases"));
        fputs(sections, html);
        iso_atlas_page_end(html);
        fclose(html);
    }
    TRY(status, iso_file_write(page, text, size, err));
    TRY(status, iso_json_save(data, root, err));
    return status;
}

/* Makes the atlas in the folder `output`. root receives the cases. */
static iso_status make_atlas(const iso_cli *cli, const bool *wanted, const char *output, json_t *root, iso_error *err)
{
    iso_output out;
    FREED char *sections = NULL;
    size_t size = 0, fallen = 0;
    iso_atlas_page page = {.name = output, .cases = json_array()};
    json_object_set_new(root, "cases", page.cases);
    NEED(iso_output_begin_dir(&out, output, "atlas.json", err));
    page.dir = out.temp_path;
    page.html = open_memstream(&sections, &size);
    iso_status status = page.html ? make_cases(cli, wanted, &page, &fallen, err)
                                  : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (page.html)
        fclose(page.html);
    TRY(status, write_page(out.temp_path, root, sections, err));
    TRY(status, iso_output_commit(&out, err));
    iso_output_abandon(&out);
    if (status == ISO_OK && cli->json)
        iso_cli_print_json(json_incref(root));
    if (status == ISO_OK && fallen > 0)
        status =
            iso_fail(err, ISO_E_DIFFERS,
                     "failures that disappeared, or that their fallback no longer corrects: %zu; see %s/index.html",
                     fallen, output);
    return status;
}

typedef struct atlas_options {
    char *output, *cases;
} atlas_options;

static const iso_option options[] = {
    {"output", 'o', "folder for the atlas", "DIR", ISO_IN(atlas_options, output)},
    {"case", 0, "only these cases, such as thin-plates,noise", "LIST", ISO_IN(atlas_options, cases)},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const atlas_options *o = values;
    FREED bool *wanted = calloc(iso_atlas_case_count, sizeof *wanted);
    json_auto_t *root = iso_cli_json(cli);
    NEED(!wanted      ? iso_fail(err, ISO_E_MEMORY, "out of memory")
         : !o->output ? iso_fail(err, ISO_E_USAGE, "-o is missing: folder for the atlas")
                      : choose(o->cases, wanted, err));
    return make_atlas(cli, wanted, o->output, root, err);
}

const iso_command iso_command_atlas = {
    .name = "atlas",
    .summary = "show how methods fail: the smallest scene for each failure, its figure and its fallback",
    .usage = "-o DIR [--case LIST] [options]",
    .details =
        "DIR/index.html shows each failure next to the correct picture and the fallback, with the commands that make both from\n"
        "the volume and scene in DIR; DIR/atlas.json holds the figures.\n"
        "Exit code 1: a failure has disappeared, or its fallback no longer corrects it: the documentation is out of date.",
    .examples = "  isoshade atlas -o atlas\n"
                "  isoshade atlas --case thin-vessels,noise -o atlas-two\n"
                "  isoshade render atlas-two/noise.nrrd --scene atlas-two/noise.scene.json -o noise.png\n",
    .options = options,
    .options_size = sizeof(atlas_options),
    .run = run,
};
