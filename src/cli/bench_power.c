/* bench_power.c - does validation catch what is wrong, and leave alone what is right?
 *
 * Planted faults against the calibration, each by name; then random scenes, clean and with each fault, against
 * the gates of the agreement. Everything follows from --seed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/random.h"
#include "cli/bench.h"
#include "cli/calibrate.h"
#include "cli/validate.h"
#include "volume/synthetic.h"

typedef struct power_options {
    char *with;
    int repetitions, size, scenes, seed;
    bool wanted[ISO_RENDERER_COUNT];
} power_options;

typedef struct power_result {
    double ratio[ISO_FAULT_COUNT][ISO_RENDERER_COUNT]; /* value over limit of the check made for it; NaN: not asked */
    size_t caught_in_scenes[ISO_FAULT_COUNT], scenes;
    size_t flagged[ISO_RENDERER_COUNT], clean[ISO_RENDERER_COUNT]; /* comparisons of clean scenes */
} power_result;

/* A random scene: a rotated, anisotropic noise under a soft TF, a camera from anywhere, one to three lights. */
typedef struct power_scene {
    iso_pyramid pyramid;
    iso_view view;
    iso_scene_agreement asked;
} power_scene;

static double between(iso_random *r, double lo, double hi) { return lo + (hi - lo) * iso_random_unit(r); }

static iso_vec3 direction(iso_random *r)
{
    double z = between(r, -1, 1), turn = between(r, 0, 6.2831853), flat = sqrt(1 - z * z);
    return iso_v3(flat * cos(turn), flat * sin(turn), z);
}

static iso_geometry random_grid(iso_random *r)
{
    size_t size[3];
    double spacing[3];
    for (int a = 0; a < 3; ++a) {
        size[a] = 13 + iso_random_below(r, 12);
        spacing[a] = between(r, 0.8, 1.8);
    }
    iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    iso_vec3 x = direction(r), z = iso_normalize(iso_cross(x, direction(r))), y = iso_cross(z, x);
    const iso_mat3 turn = {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            g.index_to_world.m[i][k] = turn.m[i][k] * spacing[k];
    g.origin_mm = iso_mul(turn, g.origin_mm);
    return g;
}

static void random_camera(iso_random *r, const iso_geometry *g, iso_camera *c)
{
    double radius = 0.8 * iso_geometry_box_radius_mm(g);
    *c = (iso_camera){.orthographic = iso_random_below(r, 2), .forward = direction(r)};
    c->right = iso_normalize(iso_cross(c->forward, fabs(c->forward.z) < 0.9 ? iso_v3(0, 0, 1) : iso_v3(0, 1, 0)));
    c->up = iso_cross(c->right, c->forward);
    c->half_height = c->orthographic ? radius : 0.25;
    c->position = iso_madd(iso_geometry_box_center_mm(g), c->forward, -(c->orthographic ? 3 * radius : 4.2 * radius));
}

static iso_status random_tf(iso_random *r, const iso_level *level, iso_tf_table *tf, iso_error *err)
{
    enum { entries = 64, points = 5 };
    double p[points][4];
    *tf = (iso_tf_table){.count = entries, .lo = level->min, .hi = level->max, .entries = malloc(entries * 4 * sizeof(float))};
    if (!tf->entries)
        return iso_fail(err, ISO_E_MEMORY, "bench power: no memory");
    for (int i = 0; i < points; ++i)
        for (int c = 0; c < 4; ++c)
            p[i][c] = c < 3 ? between(r, 0.1, 1) : i > 0 ? between(r, 0.02, 0.3) : 0;
    for (size_t i = 0; i < entries; ++i) {
        double x = (double)i / (entries - 1) * (points - 1);
        size_t k = x < points - 1 ? (size_t)x : points - 2;
        for (int c = 0; c < 4; ++c)
            tf->entries[4 * i + (size_t)c] = (float)(p[k][c] + (x - (double)k) * (p[k + 1][c] - p[k][c]));
    }
    return ISO_OK;
}

static iso_status make_scene(uint64_t seed, size_t pixels, power_scene *s, iso_error *err)
{
    iso_random r = {.state = seed * 7919};
    iso_field field = {.kind = ISO_FIELD_NOISE, .geometry = random_grid(&r), .seed = seed};
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_volume volume;
    *s = (power_scene){.asked = {.tier = ISO_TIER_CONVERGENCE, .why = "random"}};
    build.level_count = 2; /* the second is for a planted fault */
    iso_status status = iso_field_sample(&field, ISO_U16, &volume, err);
    if (status != ISO_OK)
        return status;
    status = iso_pyramid_build(&volume, "power", &build, &s->pyramid, NULL, err);
    iso_volume_destroy(&volume);
    if (status != ISO_OK)
        return status;
    iso_view *v = &s->view;
    *v = (iso_view){.width = pixels, .height = pixels, .step_voxels = 0.5, .light_count = 1 + iso_random_below(&r, 3)};
    v->shading = (iso_shading){.ambient = 0.2, .diffuse = 0.8, .specular = between(&r, 0.3, 1), .power = between(&r, 2, 20)};
    for (size_t i = 0; i < v->light_count; ++i)
        v->lights[i] = (iso_light){.direction = direction(&r), .intensity = 1.0 / (double)v->light_count};
    for (int c = 0; c < 3; ++c)
        v->background[c] = between(&r, 0, 0.4);
    random_camera(&r, &field.geometry, &v->camera);
    return random_tf(&r, &s->pyramid.levels[0], &v->tf, err);
}

static void clear_scene(power_scene *s)
{
    iso_view_destroy(&s->view);
    iso_pyramid_destroy(&s->pyramid);
}

static iso_status render_reference(iso_renderers *r, const power_scene *s, iso_quadrature q, iso_image *image, iso_error *err)
{
    iso_render_options opt = iso_render_defaults(ISO_WITH_REFERENCE);
    opt.quadrature = q;
    return iso_render_with(r, &s->pyramid, 0, &s->view, &opt, image, NULL, NULL, err);
}

/* The gates that validation has for a limit; *flagged when one is not held. */
static iso_status test_limit(iso_renderers *r, const power_scene *s, const iso_image *reference, iso_renderer which,
                             int first_seed, bool *flagged, iso_error *err)
{
    iso_limit limit;
    iso_limit_options opt = iso_limit_defaults();
    iso_report_agreement row = {.a = "reference", .b = iso_renderer_name(which)};
    opt.seeds = 3;
    opt.first_seed = first_seed;
    if (which == ISO_WITH_GL)
        opt.step_voxels = 1.0 / 16;
    iso_status status = iso_limit_find(r, &s->pyramid, 0, &s->view, reference, which, &opt, &limit, NULL, err);
    if (status == ISO_OK)
        status = iso_metrics_measure(reference, &limit.image, &row.metrics, err);
    if (status == ISO_OK)
        iso_validate_limit_row(&s->asked, &limit, &row);
    *flagged = status == ISO_OK && strcmp(iso_report_verdict(&row), "agree") != 0;
    iso_limit_destroy(&limit);
    return status;
}

/* The lock-step gate of the ray caster, which is given a spoilt scene. */
static iso_status test_lock_step(iso_renderers *r, uint64_t seed, size_t pixels, const iso_image *same, iso_fault fault,
                                 bool *flagged, iso_error *err)
{
    power_scene s;
    iso_image image = {0};
    iso_report_agreement row = {.limits = iso_validate_gl_lock_step(false)};
    iso_render_options opt = iso_render_defaults(ISO_WITH_GL);
    iso_status status = make_scene(seed, pixels, &s, err);
    iso_fault_plant(fault, &s.pyramid, 0, &s.view);
    if (status == ISO_OK)
        status = iso_render_with(r, &s.pyramid, fault == ISO_FAULT_LEVEL ? 1 : 0, &s.view, &opt, &image, NULL, NULL, err);
    if (status == ISO_OK)
        iso_fault_spoil(fault, &image);
    if (status == ISO_OK)
        status = iso_metrics_measure(same, &image, &row.metrics, err);
    *flagged = status == ISO_OK && strcmp(iso_report_verdict(&row), "agree") != 0;
    iso_image_destroy(&image);
    clear_scene(&s);
    return status;
}

static int check_number(const char *name)
{
    static const char *const names[ISO_CALIBRATION_COUNT] = {"placement", "slab", "transfer function", "light"};
    int i = 0;
    while (i + 1 < ISO_CALIBRATION_COUNT && strcmp(names[i], name) != 0)
        ++i;
    return i;
}

static iso_status plant_in_calibrations(iso_renderers *r, const power_options *o, power_result *out,
                                        const iso_progress *progress, iso_error *err)
{
    iso_status status = ISO_OK;
    for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT && status == ISO_OK; ++f)
        for (int w = 0; w < ISO_RENDERER_COUNT && status == ISO_OK; ++w) {
            iso_calibration c;
            out->ratio[f][w] = NAN;
            if (!o->wanted[w])
                continue;
            iso_progress_report(progress, "planted faults", (double)(f - 1) / (ISO_FAULT_COUNT - 1));
            status = iso_calibrate_check(r, (iso_renderer)w, (iso_fault)f, check_number(iso_fault_check((iso_fault)f)), &c, err);
            out->ratio[f][w] = c.value / c.limit;
        }
    return status;
}

static iso_status run_scene(iso_renderers *r, const power_options *o, int i, power_result *out, iso_error *err)
{
    const uint64_t seed = (uint64_t)o->seed * 1000 + (uint64_t)i;
    const size_t pixels = (size_t)o->size;
    power_scene s;
    iso_image converged = {0}, same = {0};
    iso_status status = make_scene(seed, pixels, &s, err);
    if (status == ISO_OK)
        status = render_reference(r, &s, ISO_QUADRATURE_CONVERGED, &converged, err);
    if (status == ISO_OK)
        status = render_reference(r, &s, ISO_QUADRATURE_MIDPOINT, &same, err);
    for (int w = ISO_WITH_REFERENCE + 1; w < ISO_RENDERER_COUNT && status == ISO_OK; ++w) {
        bool flagged = false;
        if (!o->wanted[w])
            continue;
        status = test_limit(r, &s, &converged, (iso_renderer)w, 1000 * i, &flagged, err);
        out->clean[w] += 1;
        out->flagged[w] += flagged;
    }
    for (int f = ISO_FAULT_NONE; f < ISO_FAULT_COUNT && o->wanted[ISO_WITH_GL] && status == ISO_OK; ++f) {
        bool flagged = false;
        status = test_lock_step(r, seed, pixels, &same, (iso_fault)f, &flagged, err);
        if (f == ISO_FAULT_NONE)
            out->clean[ISO_WITH_GL] += 1, out->flagged[ISO_WITH_GL] += flagged;
        else
            out->caught_in_scenes[f] += flagged;
    }
    out->scenes += 1;
    iso_image_destroy(&converged);
    iso_image_destroy(&same);
    clear_scene(&s);
    return status;
}

static bool is_caught(const power_result *r, int fault)
{
    for (int w = 0; w < ISO_RENDERER_COUNT; ++w)
        if (r->ratio[fault][w] <= 1)
            return false;
    return true;
}

static json_t *to_json(const power_result *r)
{
    json_t *faults = json_array(), *clean = json_array();
    for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT; ++f) {
        json_t *ratios = json_object();
        for (int w = 0; w < ISO_RENDERER_COUNT; ++w)
            if (isfinite(r->ratio[f][w]))
                json_object_set_new(ratios, iso_renderer_name((iso_renderer)w), json_real(r->ratio[f][w]));
        json_array_append_new(faults, json_pack("{s:s, s:s, s:b, s:o, s:I, s:I}", "fault", iso_fault_name((iso_fault)f),
                                                "check", iso_fault_check((iso_fault)f), "caught", is_caught(r, f),
                                                "times_the_limit", ratios, "caught_in_scenes",
                                                (json_int_t)r->caught_in_scenes[f], "scenes", (json_int_t)r->scenes));
    }
    for (int w = 0; w < ISO_RENDERER_COUNT; ++w)
        if (r->clean[w])
            json_array_append_new(clean, json_pack("{s:s, s:I, s:I}", "renderer", iso_renderer_name((iso_renderer)w),
                                                   "comparisons", (json_int_t)r->clean[w], "flagged", (json_int_t)r->flagged[w]));
    return json_pack("{s:o, s:o}", "faults", faults, "clean", clean);
}

static void print_table(const power_options *o, const power_result *r)
{
    printf("%-58s %-18s", "planted fault", "check");
    for (int w = 0; w < ISO_RENDERER_COUNT; ++w)
        if (o->wanted[w])
            printf(" %10s", iso_renderer_name((iso_renderer)w));
    printf("  scenes\n");
    for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT; ++f) {
        printf("%-58s %-18s", iso_fault_name((iso_fault)f), iso_fault_check((iso_fault)f));
        for (int w = 0; w < ISO_RENDERER_COUNT; ++w)
            if (o->wanted[w])
                printf(" %9.3gx", r->ratio[f][w]);
        printf("  %zu of %zu%s\n", r->caught_in_scenes[f], r->scenes, is_caught(r, f) ? "" : "  NOT CAUGHT");
    }
    for (int w = 0; w < ISO_RENDERER_COUNT; ++w)
        if (r->clean[w])
            printf("clean scenes, %s: %zu of %zu comparisons flagged\n", iso_renderer_name((iso_renderer)w), r->flagged[w],
                   r->clean[w]);
}

static iso_status verdict(const power_result *r, iso_error *err)
{
    for (int f = ISO_FAULT_NONE + 1; f < ISO_FAULT_COUNT; ++f)
        if (!is_caught(r, f))
            return iso_fail(err, ISO_E_DIFFERS, "bench power: \"%s\" is not caught", iso_fault_name((iso_fault)f));
    for (int w = 0; w < ISO_RENDERER_COUNT; ++w)
        if (r->flagged[w])
            return iso_fail(err, ISO_E_DIFFERS, "bench power: %zu of %zu clean comparisons of %s were flagged", r->flagged[w],
                            r->clean[w], iso_renderer_name((iso_renderer)w));
    return ISO_OK;
}

static iso_status bench(const iso_cli *cli, power_options *o, iso_error *err)
{
    iso_progress progress = iso_cli_progress(cli);
    iso_renderers renderers = {0};
    power_result result = {0};
    iso_status status = iso_cli_check_range("--repetitions", o->repetitions, 0, 10000, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--size", o->size, 8, 1024, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--seed", o->seed, 0, 1e6, err);
    if (status == ISO_OK)
        status = iso_renderers_from_list(o->with, o->wanted, err);
    if (status == ISO_OK)
        status = plant_in_calibrations(&renderers, o, &result, &progress, err);
    for (int i = 0; i < o->repetitions && status == ISO_OK; ++i) {
        iso_progress_report(&progress, "random scenes", (double)i / o->repetitions);
        status = run_scene(&renderers, o, i, &result, err);
    }
    iso_renderers_end(&renderers);
    if (status != ISO_OK)
        return status;
    if (cli->json) {
        json_t *root = iso_cli_json(cli);
        json_object_update_new(root, to_json(&result));
        iso_cli_print_json(root);
    } else {
        print_table(o, &result);
    }
    return verdict(&result, err);
}

static iso_status run(const iso_command *self, int argc, const char **argv, iso_error *err)
{
    power_options o = {.repetitions = 20, .size = 32, .seed = 1};
    struct poptOption options[] = {
        {"repetitions", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &o.repetitions, 0, "random scenes", "N"},
        {"with", 0, POPT_ARG_STRING, &o.with, 0, "renderers besides the reference (gl,cycles,povray)", "LIST"},
        {"size", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &o.size, 0, "pixels along the sides of the scenes' images", "N"},
        {"seed", 0, POPT_ARG_INT | POPT_ARGFLAG_SHOW_DEFAULT, &o.seed, 0, "of the scenes", "N"},
        POPT_TABLEEND,
    };
    iso_cli cli;
    iso_cli_next next;
    iso_status status = iso_cli_parse(&cli, self, argc, argv, options, 0, 0, &next, err);
    if (status == ISO_OK && next == ISO_CLI_RUN)
        status = bench(&cli, &o, err);
    iso_cli_end(&cli);
    return status;
}

const iso_command iso_bench_power = {
    .name = "bench power",
    .summary = "planted faults that validation catches, and clean scenes that it leaves alone",
    .usage = "[options]",
    .details = "Each fault is planted into the calibration of each renderer: by how many times its limit the check made for it is\n"
               "exceeded. Then random scenes: how many clean ones the gates of the limits and of the ray caster's lock-step flag, and\n"
               "in how many the lock-step sees each fault. Exit code 1: a fault was not caught, or a clean scene was flagged.",
    .examples = "  isoshade bench power --with gl --repetitions 2 --size 16\n",
    .run = run,
};
