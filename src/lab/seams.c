/* SPDX-License-Identifier: MIT */
/* seams.c - jumps between neighboring bricks of mixed resolution on their faces, by scheme. */
#include "base/random.h"
#include "lab/lab.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "brick/bricks.h"
#include "lab/warp.h"
#include "image/image.h"

enum { BRICK = 8, SIDE = 3, VOXELS = BRICK * SIDE };

typedef enum scheme { OWN_NODES, BAKED, OWN_CENTERS, PAPER_WRITTEN, PAPER_CORRECTED, SCHEME_COUNT } scheme;
static const char *const scheme_names[SCHEME_COUNT] = {"nodes-own", "nodes-baked", "centers-own", "paper-written",
                                                       "paper-corrected"};

/* White noise, as bricks with nodes at the samples and as bricks with centers there. */
typedef struct seams {
    float *noise;
    iso_node_levels nodes;
    iso_warp_field warp;
    uint8_t levels[SIDE * SIDE * SIDE];
} seams;

static iso_status create(seams *s, iso_random *state, iso_error *err)
{
    const size_t all = VOXELS + 1, size[3] = {all, all, all}, cells[3] = {VOXELS, VOXELS, VOXELS};
    *s = (seams){.noise = malloc(all * all * all * sizeof(float))};
    NEED_MEMORY(s->noise, err, "no memory for a volume of %d^3", VOXELS + 1);
    for (size_t i = 0; i < all * all * all; ++i)
        s->noise[i] = (float)iso_random_unit(state);
    iso_level level = {.geometry = iso_geometry_axis_aligned(size, (const double[3]){1, 1, 1}),
                       .scalar = s->noise,
                       .max = 1};
    iso_status status = iso_node_levels_create(&s->nodes, &level, BRICK, 2, false, 1, err);
    return status == ISO_OK ? iso_warp_field_create(&s->warp, s->noise, 1, cells, BRICK, err) : status;
}

static void destroy(seams *s)
{
    iso_node_levels_destroy(&s->nodes);
    iso_warp_field_destroy(&s->warp);
    free(s->noise);
}

/* Returns a brick's function at p; bricks are [8 b, 8 (b + 1)]. */
static double sample_in(seams *s, scheme which, const size_t brick[3], const double p[3])
{
    if (which == OWN_NODES || which == BAKED) {
        const iso_brick_field f = {&s->nodes, s->levels, which == BAKED ? ISO_FACES_BAKED : ISO_FACES_OWN};
        double value[ISO_NODE_CHANNELS];
        iso_brick_sample_in(&f, brick, p, value);
        return value[0];
    }
    s->warp.levels = s->levels;
    s->warp.mode = which == PAPER_WRITTEN     ? ISO_WARP_WRITTEN
                   : which == PAPER_CORRECTED ? ISO_WARP_CORRECTED
                                              : ISO_WARP_NONE;
    return iso_warp_sample_in(&s->warp, brick, p);
}

/* Returns the difference at p across the face between a brick and the next along an axis. */
static double jump(seams *s, scheme which, const size_t brick[3], int axis, const double p[3])
{
    size_t next[3] = {brick[0], brick[1], brick[2]};
    ++next[axis];
    return fabs(sample_in(s, which, brick, p) - sample_in(s, which, next, p));
}

typedef struct result {
    double largest, part; /* part: samples with a jump of more than a thousandth of the range */
} result;

static void measure(seams *s, int layouts, iso_random *state, result results[SCHEME_COUNT])
{
    enum { points = 400 };
    memset(results, 0, SCHEME_COUNT * sizeof *results);
    for (int k = 0; k < layouts; ++k) {
        for (size_t i = 0; i < sizeof s->levels; ++i)
            s->levels[i] = iso_random_unit(state) < 0.5;
        for (int i = 0; i < points; ++i) {
            int axis = (int)(3 * iso_random_unit(state));
            size_t brick[3];
            double p[3];
            for (int a = 0; a < 3; ++a) {
                brick[a] = (size_t)((SIDE - (a == axis)) * iso_random_unit(state));
                p[a] = BRICK * ((double)brick[a] + (a == axis ? 1 : iso_random_unit(state)));
            }
            for (int which = 0; which < SCHEME_COUNT; ++which) {
                double d = jump(s, (scheme)which, brick, axis, p);
                results[which].largest = fmax(results[which].largest, d);
                results[which].part += d > 1e-3 ? 1.0 / (points * (double)layouts) : 0;
            }
        }
    }
}

/* Draws the counterexample: two neighboring fine bricks, and a coarse one that touches the first only by an edge and
 * the second by a face. The plane cuts that edge and is 2.4 voxels wide; stripes of equal values break at jumps. */
static iso_status draw(seams *s, const char *path, iso_error *err)
{
    static const scheme panels[] = {OWN_CENTERS, PAPER_WRITTEN, PAPER_CORRECTED, BAKED};
    enum { panel = 280, gap = 8, count = 4 };
    const double width = 2.4;
    OWNED(iso_image) image = {0};
    NEED(iso_image_create(&image, count * panel + (count - 1) * gap, panel, err));
    memset(s->levels, 0, sizeof s->levels);
    s->levels[1 + SIDE * (1 + SIDE * 1)] = 1;
    s->levels[1 + SIDE * (1 + SIDE * 0)] = s->levels[1 + SIDE * (1 + SIDE * 2)] = 1;
    for (size_t i = 0; i < image.width * image.height; ++i) {
        size_t column = i % image.width, row = i / image.width, k = column / (panel + gap), x = column % (panel + gap);
        float *pixel = image.rgba + 4 * i;
        pixel[0] = pixel[1] = pixel[2] = pixel[3] = 1;
        if (x >= panel)
            continue;
        const double p[3] = {BRICK + width * (((double)x + 0.5) / panel - 0.5),
                             BRICK + width * (0.5 - ((double)row + 0.5) / panel), 1.5 * BRICK + 0.3};
        const size_t brick[3] = {p[0] > BRICK, p[1] > BRICK, 1};
        double value = sample_in(s, panels[k], brick, p);
        float stripe = (float)(0.5 + 0.5 * cos(2 * 3.14159265358979 * 12 * value)), shade = (float)(0.1 + 0.6 * value);
        for (int c = 0; c < 3; ++c)
            pixel[c] = shade * (0.35f + 0.65f * stripe);
        if (brick[0] && brick[1])
            pixel[2] = fminf(1, pixel[2] + 0.25f); /* the coarse brick */
        if (x == panel / 2 || row == panel / 2)
            pixel[0] = fminf(1, pixel[0] + 0.5f); /* the faces */
    }
    return iso_image_save_png(&image, path, 1, err);
}

static void report(const iso_cli *cli, const result results[SCHEME_COUNT], int layouts)
{
    json_t *root = iso_cli_json(cli), *cases = json_array();
    json_object_set_new(root, "layouts", json_integer(layouts));
    if (!cli->json)
        printf("%-14s %14s %22s\n", "scheme", "largest jump", "part of face samples");
    for (int i = 0; i < SCHEME_COUNT; ++i) {
        json_array_append_new(cases, json_pack("{s:s, s:f, s:f}", "scheme", scheme_names[i], "largest_jump",
                                               results[i].largest, "part_of_face_samples", results[i].part));
        if (!cli->json)
            printf("%-14s %14.3g %20.2f %%\n", scheme_names[i], results[i].largest, 100 * results[i].part);
    }
    json_object_set_new(root, "schemes", cases);
    if (cli->json)
        iso_cli_print_json(root);
    else
        json_decref(root);
}

static iso_status bench(const iso_cli *cli, int layouts, const char *picture, iso_error *err)
{
    ENDED_BY(destroy) seams s = {0};
    result results[SCHEME_COUNT];
    iso_random state = {1};
    NEED(create(&s, &state, err));
    measure(&s, layouts, &state, results);
    if (picture)
        NEED(draw(&s, picture, err));
    report(cli, results, layouts);
    return ISO_OK;
}

typedef struct seams_options {
    int layouts;
    char *picture;
} seams_options;

static const iso_option options[] = {
    {"layouts", 0, "use N random layouts", "N", ISO_IN(seams_options, layouts), .flags = ISO_SHOWN, .least = 1,
     .most = 100000},
    {"output", 'o', "write a picture of the counterexample", "FILE.png", ISO_IN(seams_options, picture)},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const seams_options *o = values;
    return bench(cli, o->layouts, o->picture, err);
}

const iso_command iso_lab_seams = {
    .name = "seams",
    .summary = "bricks of mixed resolution: jumps on their faces, by scheme",
    .usage = "[options]",
    .details =
        "White noise in 3 x 3 x 3 bricks of 8, random layouts of two levels. Jumps are parts of the range. The picture\n"
        "is a plane across an edge where fine and coarse bricks meet: centers-own, paper-written, paper-corrected,\n"
        "nodes-baked.",
    .examples = "  isoshade-lab seams --layouts 5 -o seams.png\n",
    ISO_COMMAND_OPTIONS(seams_options, options, .layouts = 100),
    .run = run,
};
