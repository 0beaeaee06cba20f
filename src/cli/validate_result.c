/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/validate.h"

#include <stdio.h>
#include <string.h>


iso_status iso_cli_validate_verdict(const iso_validation *v, const iso_report_summary *summary,
                                    const iso_levels_summary *levels, iso_error *err)
{
    if (v->foreign[0])
        return iso_fail(err, ISO_E_DIFFERS, "%s: %s", v->volume_path, v->foreign);
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (v->refused[i].status != ISO_OK) /* of one that was left out it is ISO_OK */
            return iso_fail(err, v->refused[i].status, "%s %s", iso_renderer_at(i)->name, v->refused[i].why);
    if (summary->refused > 0) /* it answered at the start */
        return iso_validate_refused_later(v, err);
    if (!summary->good)
        return iso_fail(err, ISO_E_DIFFERS, "%s", summary->sentence);
    return summary->holds ? ISO_OK : iso_fail(err, ISO_E_DIFFERS, "%s", levels->sentence);
}

static bool is_stage(const json_t *row)
{
    return strcmp(iso_row_text(row, "comparison"), "stage") == 0;
}

static void print_uncompared(const json_t *row)
{
    char name[ISO_ROW_NAME_BYTES];
    iso_row_name_of(row, name);
    if (is_stage(row))
        printf("not compared: %s: %s\n", name, iso_row_text(row, "why"));
    else
        printf("not compared: %s, level %lld, %s: %s\n", iso_row_text(row, "scene"), iso_row_level(row), name,
               iso_row_text(row, "why"));
}

/* Prints requested comparisons that were skipped, with the reason, whole stages first; the page has all. */
static void print_not_compared(const iso_report *r)
{
    enum { most = 6 };
    size_t i, count = 0;
    json_t *row;
    for (int stages = 1; stages >= 0; --stages)
        json_array_foreach (json_object_get(iso_report_json(r), "agreement"), i, row)
            if (is_stage(row) == stages && iso_row_verdict(row) == ISO_VERDICT_NOT_COMPARED && ++count <= most)
                print_uncompared(row);
    if (count > most)
        printf("not compared: %zu more, listed in the report\n", count - most);
}

/* Prints the renderers that are not installed, and that nobody named. */
static void print_left_out(const iso_report *r)
{
    const char *name;
    json_t *why;
    json_object_foreach (json_object_get(iso_report_json(r), "left_out"), name, why)
        printf("left out: %s: %s\n", name, json_string_value(why));
}

/* Prints calibration checks that a renderer cannot do, with the consequence. */
static void print_not_calibrated(const iso_report *r)
{
    size_t i;
    json_t *row;
    json_array_foreach (json_object_get(iso_report_json(r), "calibration"), i, row)
        if (iso_row_verdict(row) == ISO_VERDICT_NOT_COMPARED)
            printf("not calibrated: %s: %s: %s\n", iso_row_text(row, "renderer"), iso_row_text(row, "check"),
                   iso_row_text(row, "detail"));
}

/* Prints the assumed limits of scenes that set none. */
static void print_assumed(const iso_report *r)
{
    const char *scene;
    json_t *asked;
    json_object_foreach (json_object_get(iso_report_json(r), "asked"), scene, asked)
        if (json_is_true(json_object_get(asked, "assumed")))
            printf("assumed: %s: %s\n", scene, iso_row_text(asked, "why"));
}

void iso_cli_validate_print(const char *output, const iso_cli *cli, const iso_validation *v,
                            const iso_report_summary *s, const iso_levels_summary *levels)
{
    if (cli->json) {
        iso_cli_print_json(json_incref((json_t *)iso_report_json(v->report)));
    } else {
        puts(s->sentence);
        if (levels->sentence[0])
            puts(levels->sentence);
        iso_cli_print_versions(iso_report_json(v->report));
        print_left_out(v->report);
        print_not_calibrated(v->report);
        print_not_compared(v->report);
        print_assumed(v->report);
        printf("report: %s/index.html\n", output);
    }
}
