/* SPDX-License-Identifier: MIT */
/* cmd_certificate.c - makes a site of certificates from reports. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "options/cli.h"
#include "report/certificate.h"
#include "report/rows.h"

static void print_site(const json_t *site, const char *output)
{
    json_t *one;
    size_t i;
    printf("%s\n", iso_row_text(site, "sentence"));
    json_array_foreach (json_object_get(site, "renderers"), i, one)
        printf("%-16s %s/%s\n", iso_row_text(one, "renderer"), output, iso_row_text(one, "badge"));
    printf("site: %s/index.html\n", output);
}

static iso_status make_site(const iso_cli *cli, const char *output, const iso_report_source *reports, iso_error *err)
{
    json_auto_t *made = NULL, *site = iso_cli_json(cli);
    NEED(iso_certificates_of(reports, cli->argument_count, &made, err));
    json_object_set_new(site, "title", json_string("Certificates of volume renderers"));
    json_object_update(site, made);
    NEED(iso_certificates_write(output, site, reports, err));
    if (cli->json)
        iso_cli_print_json(json_incref(site));
    else
        print_site(site, output);
    return ISO_OK;
}

typedef struct certificate_options {
    char *output;
} certificate_options;

static const iso_option options[] = {
    {"output", 'o', "folder for the site", "DIR", ISO_IN(certificate_options, output)},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const certificate_options *o = values;
    FREED iso_report_source *reports = calloc(cli->argument_count, sizeof *reports);
    if (!o->output)
        return iso_fail(err, ISO_E_USAGE, "-o is missing: folder for the site");
    iso_status status = reports ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    for (size_t i = 0; i < cli->argument_count && status == ISO_OK; ++i)
        status = iso_report_source_open(&reports[i], cli->arguments[i], err);
    TRY(status, make_site(cli, o->output, reports, err));
    for (size_t i = 0; reports && i < cli->argument_count; ++i)
        iso_report_source_close(&reports[i]);
    return status;
}

const iso_command iso_command_certificate = {
    .name = "certificate",
    .summary = "make a site of certificates from reports, with a badge per renderer",
    .min_arguments = 1,
    .max_arguments = SIZE_MAX,
    .usage = "REPORT... -o DIR",
    .details =
        "REPORT is a folder that `isoshade validate` wrote, or only its report.json, without pictures. DIR/index.html\n"
        "has a card for each renderer and scene: picture, difference, verdict, limits, versions and command. It needs\n"
        "no network. DIR/certificates.json has all as data, DIR/badges/RENDERER.svg is a badge to link to. If several\n"
        "reports have the same renderer, volume and scene, the newest counts.\n"
        "Exit code 0: the site is complete, even if renderers differ; 3 or 4: a report cannot be read.",
    .examples = "  isoshade make shells --size 40x44x37 -o shells.nrrd\n"
                "  isoshade validate shells.nrrd --scene refscenes/shells.scene.json --quick --levels 2 --with gl,cpu "
                "--size 64 -o shells-report\n"
                "  isoshade certificate shells-report -o site\n",
    .options = options,
    .options_size = sizeof(certificate_options),
    .run = run,
};
