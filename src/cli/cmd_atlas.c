/* cmd_atlas.c - the failure atlas as a folder: page, pictures, figures. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "cli/atlas.h"
#include "cli/cli.h"

ISO_EMBED(iso_atlas_page, "src/cli/atlas.html");

static iso_status save_picture(const char *dir, const char *id, const char *which, const iso_image *image, iso_error *err)
{
    char *path = NULL;
    if (asprintf(&path, "%s/%s-%s.png", dir, id, which) < 0)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    iso_status status = iso_image_save_png(image, path, 1, err);
    free(path);
    return status;
}

static iso_status save_pictures(const char *dir, const iso_atlas_case *c, const iso_atlas_result *r, iso_error *err)
{
    iso_status status = save_picture(dir, c->id, "right", &r->truth, err);
    if (status == ISO_OK)
        status = save_picture(dir, c->id, "failure", &r->failure, err);
    return status == ISO_OK ? save_picture(dir, c->id, "fallback", &r->mended, err) : status;
}

/* The texts are ours and hold no character that HTML would misread. */
static void print_case(FILE *page, const iso_atlas_case *c, const iso_atlas_result *r)
{
    fprintf(page, "<section id=\"%s\"><h2>%s</h2><p>%s</p><div class=\"row\">\n", c->id, c->title, c->cause);
    fprintf(page, "<figure><img src=\"%s-right.png\" alt=\"\"><figcaption>as it should be</figcaption></figure>\n", c->id);
    fprintf(page, "<figure><img src=\"%s-failure.png\" alt=\"\"><figcaption>%s<b>%.3g</b></figcaption></figure>\n", c->id, c->failure, r->bad);
    fprintf(page, "<figure><img src=\"%s-fallback.png\" alt=\"\"><figcaption>%s<b>%.3g</b></figcaption></figure>\n", c->id, c->mended, r->good);
    fprintf(page, "</div><p class=\"measure\">%s</p></section>\n", c->measure);
}

static json_t *to_json(const iso_atlas_case *c, const iso_atlas_result *r)
{
    return json_pack("{s:s, s:s, s:s, s:s, s:f, s:s, s:f, s:b}", "id", c->id, "cause", c->cause, "measure", c->measure, "failure",
                     c->failure, "failure_value", r->bad, "fallback", c->mended, "fallback_value", r->good, "stands",
                     iso_atlas_stands(c, r));
}

static iso_status make_cases(const iso_cli *cli, const char *dir, json_t *cases, FILE *page, bool *all_stand, iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    iso_status status = ISO_OK;
    *all_stand = true;
    for (size_t i = 0; i < iso_atlas_case_count && status == ISO_OK; ++i) {
        const iso_atlas_case *c = &iso_atlas_cases[i];
        iso_atlas_result r;
        iso_progress_report(&progress, "atlas", (double)i / (double)iso_atlas_case_count);
        status = iso_atlas_run(c, &r, err);
        if (status != ISO_OK)
            break;
        status = save_pictures(dir, c, &r, err);
        print_case(page, c, &r);
        json_array_append_new(cases, to_json(c, &r));
        *all_stand = *all_stand && iso_atlas_stands(c, &r);
        if (!cli->json)
            printf("%-20s failure %-9.3g fallback %-9.3g %s%s\n", c->id, r.bad, r.good, c->measure,
                   iso_atlas_stands(c, &r) ? "" : "  (does not stand)");
        iso_atlas_clear(&r);
    }
    iso_progress_report(&progress, "atlas", 1);
    return status;
}

static iso_status write_file(const char *dir, const char *name, const char *text, size_t size, iso_error *err)
{
    char *path = iso_path_join(dir, name);
    iso_status status = path ? iso_file_write(path, text, size, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    free(path);
    return status;
}

static iso_status make_atlas(const iso_cli *cli, const char *output, iso_error *err)
{
    iso_output out;
    json_t *root = iso_cli_json(cli), *cases = json_array();
    char *text = NULL, *path = NULL;
    size_t size = 0;
    bool all_stand = false;
    json_object_set_new(root, "cases", cases);
    iso_status status = output ? ISO_OK : iso_fail(err, ISO_E_USAGE, "-o is missing: the folder for the atlas");
    if (status == ISO_OK)
        status = iso_output_begin_dir(&out, output, "atlas.json", err);
    if (status != ISO_OK) {
        json_decref(root);
        return status;
    }
    FILE *page = open_memstream(&text, &size);
    fputs(iso_atlas_page, page);
    status = make_cases(cli, out.temp_path, cases, page, &all_stand, err);
    fputs("</main></body></html>\n", page);
    fclose(page);
    if (status == ISO_OK)
        status = write_file(out.temp_path, "index.html", text, size, err);
    if (status == ISO_OK && !(path = iso_path_join(out.temp_path, "atlas.json")))
        status = iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK)
        status = iso_json_save(path, root, err);
    status = status == ISO_OK ? iso_output_commit(&out, err) : (iso_output_abandon(&out), status);
    if (status == ISO_OK && cli->json)
        iso_cli_print_json(json_incref(root));
    if (status == ISO_OK && !all_stand)
        status = iso_fail(err, ISO_E_DIFFERS, "a failure is no longer one, or a fallback no longer mends it: see %s/index.html", output);
    free(path);
    free(text);
    json_decref(root);
    return status;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    char *output = NULL;
    struct poptOption options[] = {
        {"output", 'o', POPT_ARG_STRING, &output, 0, "the folder for the atlas", "DIR"},
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, 0, 0, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = make_atlas(&cli, output, err);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_command_atlas = {
    .name = "atlas",
    .summary = "the ways in which methods fail: the smallest scene for each, its figure, and the fallback",
    .usage = "-o DIR [options]",
    .details = "DIR/index.html shows each failure beside what is right and what mends it; DIR/atlas.json holds the figures.\n"
               "Exit code 1: a failure is cured, or a fallback no longer mends it, so that a text somewhere is out of date.",
    .examples = "  isoshade atlas -o atlas\n",
    .run = run,
};
