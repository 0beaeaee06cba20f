/* SPDX-License-Identifier: MIT */
/* fit.c - processor time of levels for a scene: least squares, the fit and the small pictures. */
#include <stdio.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "lab/lab.h"
#include "lab/level_scene.h"
#include "lab/volumes.h"
#include "plan/scene_levels.h"

typedef struct fit_bench {
    const iso_cli *cli;
    iso_volume_input input;
    int levels;
    json_t *cases;
} fit_bench;

/* A level of a volume under a transfer function. */
typedef struct fit_case {
    const char *volume, *tf;
    const iso_pyramid *pyramid;
    iso_scene scene;
    iso_tf_table table;
    size_t level;
    float *scalars[ISO_LEVEL_SCALAR_COUNT];
    double seconds[3]; /* processor time: least squares, fit, pictures */
    iso_fit_report fit;
    iso_level_candidate candidates[ISO_LEVEL_WAY_COUNT];
} fit_case;

static iso_status measure(fit_bench *b, fit_case *c, iso_error *err)
{
    const iso_level_scalar_input in = {&c->pyramid->levels[0], &c->table, c->level, b->cli->threads};
    double times[4] = {iso_cpu_seconds()};
    iso_status status = iso_level_scalars_make(&in, c->scalars[ISO_LEVEL_LEAST_SQUARES], NULL, NULL, err);
    times[1] = iso_cpu_seconds();
    TRY(status,
        iso_level_scalars_make(&in, c->scalars[ISO_LEVEL_LEAST_SQUARES], c->scalars[ISO_LEVEL_FITTED], &c->fit, err));
    times[2] = iso_cpu_seconds();
    TRY(status,
        iso_scene_level_judge(c->pyramid, c->level, &c->scene, c->scalars, b->cli->threads, c->candidates, err));
    times[3] = iso_cpu_seconds();
    c->seconds[0] = times[1] - times[0];
    c->seconds[1] = times[2] - times[1] - c->seconds[0];
    c->seconds[2] = times[3] - times[2];
    return status;
}

static void note(fit_bench *b, const fit_case *c)
{
    const double fine = (double)iso_geometry_voxel_count(&c->pyramid->levels[0].geometry);
    const double bytes = (double)iso_scene_levels_bytes(&c->pyramid->levels[0].geometry, ISO_U8, 1, ISO_EFFORT_NONE);
    const char *chosen = iso_level_scalar_name(iso_level_ways[iso_scene_level_choose(c->candidates)].scalar);
    const double left = c->fit.error_start > 0 ? c->fit.error_end / c->fit.error_start : 1;
    json_array_append_new(b->cases,
                          json_pack("{s:s, s:s, s:I, s:f, s:f, s:f, s:f, s:f, s:s}", "volume", c->volume, "tf", c->tf,
                                    "level", (json_int_t)c->level, "least_squares_ns_per_voxel",
                                    1e9 * c->seconds[0] / fine, "fit_ns_per_voxel", 1e9 * c->seconds[1] / fine,
                                    "pictures_seconds", c->seconds[2], "bytes_per_voxel", bytes / fine,
                                    "voxel_error_ratio", left, "chosen", chosen));
    if (!b->cli->json)
        printf("%-22s %-13s %zu %9.1f %9.1f %9.2f %9.1f %9.3f  %s\n", c->volume, c->tf, c->level,
               1e9 * c->seconds[0] / fine, 1e9 * c->seconds[1] / fine, c->seconds[2], bytes / fine, left, chosen);
    fflush(stdout);
}

static iso_status run_level(fit_bench *b, fit_case *c, iso_error *err)
{
    const iso_level *l = &c->pyramid->levels[c->level];
    const size_t bytes = iso_geometry_voxel_count(&l->geometry) * sizeof(float);
    c->scalars[0] = l->scalar;
    float **made[2] = {&c->scalars[ISO_LEVEL_LEAST_SQUARES], &c->scalars[ISO_LEVEL_FITTED]};
    for (int i = 0; i < 2; ++i)
        *made[i] = malloc(bytes);
    iso_status status = *made[0] && *made[1] ? measure(b, c, err)
                                             : iso_fail(err, ISO_E_MEMORY, "no memory for a level");
    if (status == ISO_OK)
        note(b, c);
    for (int i = 0; i < 2; ++i)
        free(*made[i]);
    return status;
}

static iso_status run_tf(void *user, const iso_lab_visited *v, iso_error *err)
{
    const iso_level *level0 = &v->pyramid->levels[0];
    fit_case c = {.volume = v->volume,
                  .tf = v->tf->name,
                  .pyramid = v->pyramid,
                  .scene = iso_level_bench_scene(iso_level_tf_of(v->tf))};
    iso_status status = iso_tf_tabulate(&c.scene.tf, level0->min, level0->max, &level0->geometry, &c.table, err);
    for (c.level = 1; c.level < v->pyramid->level_count && status == ISO_OK; ++c.level)
        status = run_level(user, &c, err);
    iso_tf_table_destroy(&c.table);
    return status;
}

static iso_status run_all(fit_bench *b, iso_error *err)
{
    iso_status status = ISO_OK;
    b->cases = json_array();
    if (!b->cli->json)
        printf("%-22s %-13s k %9s %9s %9s %9s %9s  chosen\n", "volume", "tf", "squares", "fit", "pictures", "bytes",
               "error");
    const iso_progress progress = iso_cli_progress(b->cli);
    status = iso_lab_visit_volumes(&(iso_lab_volumes){b->cli, &b->input, b->levels, &progress}, run_tf, b, err);
    if (status == ISO_OK && b->cli->json) {
        json_t *root = iso_cli_json(b->cli);
        json_object_set(root, "cases", b->cases);
        iso_cli_print_json(root);
    }
    json_decref(b->cases);
    return status;
}

static const iso_option options[] = {
    {"levels", 0, "use N levels, counting level 0", "N", ISO_IN(fit_bench, levels), .flags = ISO_SHOWN, .least = 2,
     .most = 8},
    ISO_OPTIONS_OF(fit_bench, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    fit_bench *b = values;
    b->cli = cli;
    return run_all(b, err);
}

const iso_command iso_lab_fit = {
    .name = "fit",
    .summary = "cost of levels for a scene (build --for): least squares, the fit, the pictures",
    .min_arguments = 1,
    .max_arguments = 64,
    .usage = "VOLUME... [options]",
    .details =
        "squares and fit: processor time in ns per voxel of level 0; pictures: seconds, with level 0's; bytes:\n"
        "memory per voxel of level 0 to build a volume of bytes for a scene; error: fraction of the squared opacity\n"
        "error that remains after the fit. Four transfer functions: surface, soft, two-material, shell.",
    .examples = "  isoshade make shells --size 40 --type uint8 -o shells.nrrd\n"
                "  isoshade-lab fit shells.nrrd --levels 3\n",
    ISO_COMMAND_OPTIONS(fit_bench, options, .levels = 4),
    .run = run,
};
