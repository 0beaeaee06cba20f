/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "options/look.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/words.h"
#include "tf/presets.h"

const iso_option iso_scene_rows[] = {
    {"scene", 0, "camera, lights, shading and transfer function (a first picture)", "SCENE.scene.json",
     ISO_IN(iso_cli_look, scene)},
    ISO_OPTIONS_END,
};

const iso_option iso_tf_rows[] = {
    {"tf", 0, "transfer function, a file or preset (the scene's; auto)", "FILE|PRESET", ISO_IN(iso_cli_look, tf)},
    ISO_OPTIONS_OF(iso_cli_look, transfer, iso_transfer_rows),
    ISO_OPTIONS_END,
};

const iso_option iso_zoom_rows[] = {
    {"zoom", 0, "factor to enlarge the middle of the picture (1)", "X", ISO_IN(iso_cli_look, zoom)},
    ISO_OPTIONS_END,
};

const iso_option iso_look_rows[] = {
    {.table = iso_scene_rows},
    {.table = iso_tf_rows},
    {"view", 0, "view direction, a name or degrees (the scene's; front or iso)", "NAME|AZ,EL",
     ISO_IN(iso_cli_look, view)},
    {.table = iso_zoom_rows},
    {"size", 0, "image size in pixels (the scene's, or 512x512)", "WxH", ISO_IN(iso_cli_look, size)},
    ISO_OPTIONS_END,
};

bool iso_cli_look_is_empty(const iso_cli_look *a)
{
    return !a->scene && !a->tf && !a->view && !a->size && !a->zoom;
}

/* Refuses options for transfer function files if --tf names no file: they would have no effect. */
static iso_status check_transfer(const iso_cli_look *a, iso_error *err)
{
    const iso_cli_transfer *t = &a->transfer;
    const char *given = t->name            ? "--name"
                        : t->unit_distance ? "--unit-distance"
                        : t->opacity       ? "--opacity"
                        : t->range         ? "--range"
                                           : NULL;
    size_t row;
    if (given && (!a->tf || iso_tf_preset_find(a->tf, &row)))
        return iso_fail(err, ISO_E_USAGE, "%s needs a file as --tf%s%s", given, a->tf ? ", not the preset " : "",
                        a->tf ? a->tf : "");
    return ISO_OK;
}

iso_status iso_cli_zoom_parse(const char *text, double *zoom, iso_error *err)
{
    char *end;
    *zoom = strtod(text, &end);
    if (end == text || *end)
        return iso_fail(err, ISO_E_USAGE, "--zoom is \"%s\", must be a number", text);
    return iso_words_check_range("--zoom", *zoom, 0.01, 1000, err);
}

iso_status iso_cli_look_take(const iso_cli_look *a, int threads, iso_subject_look *look, iso_error *err)
{
    *look = (iso_subject_look){.scene = a->scene, .tf = a->tf, .view = a->view, .size = a->size, .threads = threads};
    iso_status status = a->zoom ? iso_cli_zoom_parse(a->zoom, &look->zoom, err) : ISO_OK;
    TRY(status, check_transfer(a, err));
    return status == ISO_OK ? iso_cli_transfer_request(&a->transfer, &look->request, err) : status;
}

iso_status iso_cli_look_check(const iso_cli_look *a, int threads, iso_subject_look *look, iso_error *err)
{
    const iso_status status = iso_cli_look_take(a, threads, look, err);
    return status == ISO_OK ? iso_subject_check_look(look, err) : status;
}

char *iso_cli_look_line(const iso_cli_look *a)
{
    const struct {
        const char *option, *value;
    } words[] = {{"--scene", a->scene},
                 {"--tf", a->tf},
                 {"--name", a->transfer.name},
                 {"--unit-distance", a->transfer.unit_distance},
                 {"--opacity", a->transfer.opacity},
                 {"--range", a->transfer.range},
                 {"--view", a->view},
                 {"--size", a->size},
                 {"--zoom", a->zoom}};
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
        if (words[i].value) {
            fprintf(f, " %s ", words[i].option);
            iso_words_put_quoted(f, words[i].value);
        }
    fclose(f);
    return text;
}
