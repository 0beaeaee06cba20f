/* cmd_build.c - a volume to its pyramid. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/parallel.h"
#include "cli/cli.h"
#include "cli/input.h"
#include "pyramid/pyramid.h"

typedef struct build_options {
    char *output, *scalar_filter, *direction_filter, *code;
    int levels, gauss_radius, keep_float, keep_magnitude;
    double gauss_sigma;
} build_options;

/* NAME.iso in the current folder; to be freed. */
static char *default_output(const char *input)
{
    static const char *const endings[] = {".nii.gz", ".nrrd", ".nhdr", ".nii", ".hdr", ".img", ".raw"};
    const char *name = iso_path_base(input);
    size_t length = strlen(name);
    for (size_t i = 0; i < sizeof endings / sizeof *endings; ++i) {
        if (iso_path_ends_with(name, endings[i]) && length > strlen(endings[i])) {
            length -= strlen(endings[i]);
            break;
        }
    }
    char *path = NULL;
    return asprintf(&path, "%.*s.iso", (int)length, name) < 0 ? NULL : path;
}

static iso_status to_pyramid_options(const build_options *in, const iso_cli *cli, iso_pyramid_options *out, iso_error *err)
{
    *out = iso_pyramid_defaults();
    iso_status status = iso_cli_check_range("--levels", in->levels, 1, 32, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--gauss-radius", in->gauss_radius, 1, 16, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--gauss-sigma", in->gauss_sigma, 0.1, 100, err);
    if (status == ISO_OK && in->scalar_filter)
        status = iso_scalar_filter_from_name(in->scalar_filter, &out->scalar_filter, err);
    if (status == ISO_OK && in->direction_filter)
        status = iso_direction_filter_from_name(in->direction_filter, &out->direction_filter, err);
    if (status == ISO_OK && in->code)
        status = iso_code_from_name(in->code, &out->code, err);
    if (status != ISO_OK)
        return status;
    out->level_count = (size_t)in->levels;
    out->gauss_radius = (size_t)in->gauss_radius;
    out->gauss_sigma_voxels = in->gauss_sigma;
    out->keep_float = in->keep_float;
    out->keep_magnitude = in->keep_magnitude;
    out->threads = cli->threads;
    return ISO_OK;
}

static void report(const iso_cli *cli, const iso_pyramid *p, const char *output, double seconds)
{
    json_t *root = iso_cli_json(cli), *levels = json_array(), *options = json_object_get(root, "options");
    json_object_set_new(options, "scalar_filter", json_string(iso_scalar_filter_name(p->options.scalar_filter)));
    json_object_set_new(options, "direction_filter", json_string(iso_direction_filter_name(p->options.direction_filter)));
    json_object_set_new(options, "code", json_string(iso_code_describe(p->options.code)->name));
    json_object_set_new(root, "output", json_string(output));
    json_object_set_new(root, "seconds", json_real(seconds));
    for (size_t k = 0; k < p->level_count; ++k) {
        const iso_level *l = &p->levels[k];
        const size_t *n = l->geometry.size;
        if (!cli->json)
            printf("level %zu  %zu x %zu x %zu  %s  %.6g to %.6g\n", k, n[0], n[1], n[2], iso_type_name(l->stored_type),
                   l->min, l->max);
        json_array_append_new(levels, json_pack("{s:[I,I,I], s:s, s:f, s:f}", "size", (json_int_t)n[0], (json_int_t)n[1],
                                                (json_int_t)n[2], "type", iso_type_name(l->stored_type), "min", l->min,
                                                "max", l->max));
    }
    json_object_set_new(root, "levels", levels);
    if (cli->json) {
        iso_cli_print_json(root);
    } else {
        printf("%s\n", output);
        json_decref(root);
    }
}

static iso_status build(const iso_cli *cli, const iso_cli_input *input, const build_options *in, iso_error *err)
{
    const char *path = cli->arguments[0];
    iso_pyramid_options opt;
    iso_volume v = {0};
    iso_pyramid p = {0};
    iso_progress progress = iso_cli_progress(cli);
    const double start = iso_clock_seconds();
    char *output = in->output ? strdup(in->output) : default_output(path);
    iso_status status = output ? to_pyramid_options(in, cli, &opt, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK)
        status = iso_cli_load_volume(path, input, &v, err);
    if (status == ISO_OK)
        status = iso_pyramid_build(&v, path, &opt, &p, &progress, err);
    if (status == ISO_OK)
        status = iso_pyramid_save(&p, output, err);
    if (status == ISO_OK)
        report(cli, &p, output, iso_clock_seconds() - start);
    iso_pyramid_destroy(&p);
    iso_volume_destroy(&v);
    free(output);
    return status;
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    const iso_pyramid_options defaults = iso_pyramid_defaults();
    build_options in = {.levels = (int)defaults.level_count,
                        .gauss_radius = (int)defaults.gauss_radius,
                        .gauss_sigma = defaults.gauss_sigma_voxels};
    iso_cli_input input;
    iso_cli_input_defaults(&input);
    struct poptOption options[] = {
        {"output", 'o', POPT_ARG_STRING, &in.output, 0, "the pyramid's folder; else the input's name with .iso", "NAME.iso"},
        {"levels", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &in.levels, 0, "levels, with the finest", "N"},
        {"scalar-filter", 0, POPT_ARG_STRING, &in.scalar_filter, 0, "mean (default) or gauss", "NAME"},
        {"direction-filter", 0, POPT_ARG_STRING, &in.direction_filter, 0, "moments (default), eq1 or naive", "NAME"},
        {"code", 0, POPT_ARG_STRING, &in.code, 0, "the directions' code: snorm (default), region48, ...", "NAME"},
        {"gauss-radius", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &in.gauss_radius, 0,
         "of gauss and eq1, in voxels of the finer level", "N"},
        {"gauss-sigma", 0, POPT_ARG_DOUBLE | POPT_ARGFLAG_SHOW_DEFAULT, &in.gauss_sigma, 0, "of gauss and eq1", "VOXELS"},
        {"keep-float", 0, POPT_ARG_NONE, &in.keep_float, 0, "store the directions as floats, too", NULL},
        {"keep-magnitude", 0, POPT_ARG_NONE, &in.keep_magnitude, 0, "store the gradient magnitudes", NULL},
        ISO_CLI_INPUT_OPTIONS(&input),
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, 1, 1, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = build(&cli, &input, &in, err);
    iso_cli_end(&cli);
    free(in.output);
    free(in.scalar_filter);
    free(in.direction_filter);
    free(in.code);
    return status;
}

const iso_command iso_command_build = {
    .name = "build",
    .summary = "make the pyramid of a volume: scalars and encoded shading directions at several levels",
    .usage = "VOLUME [-o NAME.iso] [options]",
    .details = "The pyramid is a folder of plain NRRD files with pyramid.json beside them. Directions come from the\n"
               "gradients of the finest level, whatever the level.",
    .examples = "  isoshade make marschner-lobb --size 40x56x33 --spacing 1x1x2.5 -o v.nrrd\n"
                "  isoshade build v.nrrd -o v.iso --levels 4\n"
                "  isoshade build v.nrrd -o eq1.iso --direction-filter eq1 --gauss-radius 2 --gauss-sigma 1\n",
    .run = run,
};
