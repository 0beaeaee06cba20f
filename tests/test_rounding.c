/* SPDX-License-Identifier: MIT */
/* The rounding of texture units is distinguished from faults: a smooth TF on steep values, as of a CT next to its
 * padding. */
#include <math.h>
#include <string.h>
#include <sys/stat.h>

#include "base/random.h"
#include "tests/validated.h"

enum { pixels = 72 };
static const subject_size size = {pixels, 1, 1};

/* Padding, a body with grain and a bone, 1 x 1 x 4 mm. */
static void make_padded(iso_volume *volume)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){44, 44, 16}, (double[]){1, 1, 4});
    const iso_field field = {.kind = ISO_FIELD_CONSTANT, .geometry = g};
    iso_random random = {5};
    assert_ok(iso_field_sample(&field, ISO_F32, volume, &err));
    float *value = volume->data;
    for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i) {
        const double x = (double)(i % 44) - 21.5, y = (double)(i / 44 % 44) - 21.5, grain = iso_random_unit(&random);
        const double body = hypot(x + 2, y - 3) < 6 ? 900 : 40;
        value[i] = (float)(hypot(x, y) > 20 ? -1024 : rint(body + 60 * grain - 30));
    }
}

static iso_scene make_scene(void)
{
    static iso_tf_point points[] = {{0, {0.1, 0.3, 0.9}, 0.29},
                                    {0.38, {0.3, 0.5, 0.9}, 0.05},
                                    {0.5, {0.5, 0.5, 0.5}, 0},
                                    {0.62, {0.9, 0.6, 0.2}, 0.05},
                                    {1, {0.9, 0.2, 0.1}, 0.29}};
    iso_scene scene = scene_of_points(points, 5, pixels, 0.3);
    scene.orthographic = false;
    scene.fov_y_deg = 30;
    scene.camera_direction = iso_normalize(iso_v3(0.7, -1, -0.4));
    scene.camera_up = iso_v3(0, 0, 1);
    scene.margin = 0.75;
    scene.lights[0].direction = iso_normalize(scene.lights[0].direction);
    scene.agreement = (iso_scene_agreement){.tier = ISO_TIER_CONVERGENCE, .why = "the TF is smooth"};
    return scene;
}

/* The rows of gradients on the fly, drawn with the shaders of a folder, or with the built-in ones. */
static void open_rows(subject *s, const char *name, const char *shader_dir)
{
    OWNED(iso_volume) volume;
    make_padded(&volume);
    open_volume(s, &volume, make_scene(), name, size);
    iso_validation *v = &s->validation;
    v->image_prefix = v->build_options = v->render_options = v->input_options = "";
    v->variant = "on-the-fly";
    v->volume_path = v->scene_path = "test";
    v->source = ISO_FROM_ON_THE_FLY;
    v->renderers = (iso_renderers){.shader_dir = shader_dir};
    assert_ok(iso_validate_variant(v, 0, &err));
}

static void close_rows(subject *s)
{
    iso_renderers_end(&s->validation.renderers);
    close_subject(s);
}

static const json_t *row_of(const subject *s, iso_comparison comparison)
{
    size_t i;
    json_t *row;
    json_array_foreach(json_object_get(iso_report_json(s->validation.report), "agreement"), i,
                       row) if (iso_row_identify(row).comparison == comparison) return row;
    return NULL;
}

static double number(const json_t *row, const char *key)
{
    return json_number_value(json_object_get(row, key));
}

TEST(what_is_rounded_agrees_where_exact_lookups_do)
{
    subject s;
    open_rows(&s, "clean", NULL);
    const json_t *usual = row_of(&s, ISO_COMPARISON_LOCK_STEP), *exact = row_of(&s, ISO_COMPARISON_EXACT);
    const iso_tolerances smooth = iso_validate_lock_step(&iso_renderer_gl, &s.view, false);
    printf("rounded: RMSE %.3g, largest %.3g; exact: %.3g, %.3g\n", number(usual, "rmse"), number(usual, "max_abs"),
           number(exact, "rmse"), number(exact, "max_abs"));
    assert_more_than(number(usual, "max_abs"), smooth.max_abs); /* else nothing is tested here */
    assert_non_null(exact);
    assert_int_equal(iso_row_verdict(exact), ISO_VERDICT_AGREE);
    assert_int_equal(iso_row_verdict(usual), ISO_VERDICT_AGREE);
    assert_non_null(strstr(iso_row_text(usual, "why"), "in double"));
    close_rows(&s);
}

/* A copy of the shaders with one line changed. */
static void change_shaders(const char *dir, const char *old, const char *new)
{
    static const char *const names[] = {"raycast.glsl",   "fullscreen.glsl", "probe.glsl", "points.glsl",
                                        "first_hit.glsl", "held.glsl",       "roi.glsl",   "variants.h"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        char path[256], *text, *changed;
        size_t count;
        snprintf(path, sizeof path, "src/render/gl/shaders/%s", names[i]);
        assert_ok(iso_file_read(path, &text, &count, &err));
        char *at = i == 0 ? strstr(text, old) : NULL;
        assert_true(at || i > 0);
        changed = calloc(count + strlen(new) + 1, 1);
        assert_non_null(changed);
        if (at)
            sprintf(changed, "%.*s%s%s", (int)(at - text), text, new, at + strlen(old));
        snprintf(path, sizeof path, "%s/%s", dir, names[i]);
        assert_ok(iso_file_write(path, at ? changed : text, at ? strlen(changed) : count, &err));
        free(changed);
        free(text);
    }
}

/* Faults in what exact lookups do not use are not excused by their agreement; faults in what both use are no
 * rounding. */
VALUES_TEST(a_fault_is_no_rounding)
{
    static const char filter[] = "vec4 fetch(sampler3D texels, vec3 p) { return filtered(texels, p); }";
    static const struct fault {
        const char *name, *old, *new;
        iso_verdict exact;
    } faults[] = {
        {"weights of 8 bits", filter,
         "vec4 fetch(sampler3D texels, vec3 p) { vec3 n = vec3(256 * textureSize(texels, 0));\n"
         "return filtered(texels, floor(p * n + 0.5) / n); }",
         ISO_VERDICT_AGREE},
        {"a table that is off by a part of an entry", "float x = clamp(s * held.tf_scale + held.tf_offset, 0.0,",
         "float x = clamp(s * held.tf_scale + held.tf_offset + 0.005, 0.0,", ISO_VERDICT_AGREE},
        {"light that is .01 % too strong", "float sum = held.shading.x;", "float sum = 1.0001 * held.shading.x;",
         ISO_VERDICT_DIFFER},
        /* what rounding is allowed would allow this too, but exact lookups show it */
        {"light that is .002 % too strong", "float sum = held.shading.x;", "float sum = 1.00002 * held.shading.x;",
         ISO_VERDICT_DIFFER},
    };
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        subject s;
        char *dir = iso_path_join(folder, "shaders"), name[16];
        assert_true(mkdir(dir, 0700) == 0 || i > 0);
        change_shaders(dir, faults[i].old, faults[i].new);
        snprintf(name, sizeof name, "fault-%zu", i);
        open_rows(&s, name, dir);
        const json_t *usual = row_of(&s, ISO_COMPARISON_LOCK_STEP), *exact = row_of(&s, ISO_COMPARISON_EXACT);
        assert_non_null(exact);
        printf("%s: RMSE %.3g, largest %.3g; exact: %.3g, %.3g\n", faults[i].name, number(usual, "rmse"),
               number(usual, "max_abs"), number(exact, "rmse"), number(exact, "max_abs"));
        assert_int_equal(iso_row_verdict(exact), faults[i].exact);
        assert_int_equal(iso_row_verdict(usual), ISO_VERDICT_DIFFER);
        close_rows(&s);
        free(dir);
    }
}

TEST_MAIN(make_folder, end_renderers_and_folder)
