/* SPDX-License-Identifier: MIT */
/* The ray caster against the reference with the same sampling. Sizes and spacings are unequal, the grid is rotated. */
#define _POSIX_C_SOURCE 200809L
#include "difference.h"
#include "sampled.h"
#include "gl.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/progress.h"
#include "render/gl/gl_context.h"
#include "render/reference.h"
#include "volume/synthetic.h"

/* Causes: texture coordinates and filter weights are floats (3e-8 of a volume of 56 voxels is 2e-6 voxels), and so is
 * the sum over some 100 samples. Mean errors cancel, hence the RMSE is a twentieth. */
#define MAX_ABS 2e-5
#define RMSE 1e-6

/* ---- a volume, a view ------------------------------------------------------- */

/* A curved, asymmetric field in [0, 1] with gradients in all directions. */
static double field(double x, double y, double z)
{
    double r = sqrt((x - 0.4) * (x - 0.4) + 1.3 * (y - 0.55) * (y - 0.55) + 0.8 * (z - 0.5) * (z - 0.5));
    return 0.5 + 0.25 * sin(14 * r) + 0.15 * sin(5 * x + 3 * y) + 0.1 * cos(7 * z - 2 * x);
}

static void fill(iso_volume *v)
{
    const size_t *n = v->geometry.size;
    for (size_t i = 0; i < iso_geometry_voxel_count(&v->geometry); ++i) {
        size_t x = i % n[0], y = i / n[0] % n[1], z = i / (n[0] * n[1]);
        double f = field(((double)x + 0.5) / (double)n[0], ((double)y + 0.5) / (double)n[1],
                         ((double)z + 0.5) / (double)n[2]);
        switch (v->type) {
        case ISO_U8: ((uint8_t *)v->data)[i] = (uint8_t)lrint(255 * f); break;
        case ISO_U16: ((uint16_t *)v->data)[i] = (uint16_t)lrint(60000 * f); break;
        case ISO_I16: ((int16_t *)v->data)[i] = (int16_t)lrint(4000 * f - 1024); break;
        default: ((float *)v->data)[i] = (float)(3 * f - 100); break;
        }
    }
}

static iso_pyramid make_pyramid(iso_type type, iso_code code)
{
    iso_geometry g = rotated_geometry(40, 56, 33);
    OWNED(iso_volume) v;
    iso_pyramid p;
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 3;
    opt.code = code;
    opt.keep_float = true;
    assert_ok(iso_volume_create(&v, &g, type, "test", &err));
    fill(&v);
    assert_ok(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err));
    return p;
}

/* A TF over the level-0 range with a half-transparent skin and an opaque core, in colors that differ. */
static void make_tf(iso_tf_table *t, const iso_level *level)
{
    enum { count = 64 };
    *t = (iso_tf_table){.count = count, .lo = level->min, .hi = level->max};
    t->entries = malloc(4 * count * sizeof *t->entries);
    assert_non_null(t->entries);
    for (int i = 0; i < count; ++i) {
        double x = (double)i / (count - 1);
        double skin = exp(-pow((x - 0.45) / 0.05, 2)), core = x > 0.7 ? (x - 0.7) / 0.3 : 0;
        t->entries[4 * i] = (float)(0.9 - 0.5 * x);
        t->entries[4 * i + 1] = (float)(0.3 + 0.6 * x);
        t->entries[4 * i + 2] = (float)(0.5 + 0.4 * sin(9 * x));
        t->entries[4 * i + 3] = (float)(0.08 * skin + 0.6 * core);
    }
}

typedef enum view_kind { PERSPECTIVE, ORTHOGRAPHIC, INSIDE } view_kind;

static iso_view make_view(view_kind kind, const iso_level *level0)
{
    const iso_geometry *g = &level0->geometry;
    double radius = iso_geometry_box_radius_mm(g);
    iso_vec3 center = iso_geometry_box_center_mm(g);
    iso_view v = {.width = 48,
                  .height = 40,
                  .step_voxels = 0.6,
                  .light_count = 2,
                  .shading = {.ambient = 0.3, .diffuse = 0.4, .specular = 0.3, .power = 20},
                  .background = {0.2, 0.1, 0.4}};
    iso_camera *c = &v.camera;
    c->forward = iso_normalize(iso_v3(1, 2, -0.7));
    c->right = iso_normalize(iso_cross(c->forward, iso_v3(0.1, 0, 1)));
    c->up = iso_cross(c->right, c->forward);
    c->orthographic = kind == ORTHOGRAPHIC;
    c->half_height = kind == ORTHOGRAPHIC ? 0.9 * radius : kind == INSIDE ? 0.8 : tan(0.26);
    c->position = iso_madd(center, c->forward, kind == INSIDE ? -0.2 * radius : -3.7 * radius);
    v.lights[0] = (iso_light){.direction = iso_normalize(iso_v3(-1, 0.5, 2)), .intensity = 0.9};
    /* In camera space, resolved: right, up, backwards. */
    v.lights[1] = (iso_light){.direction = iso_normalize(iso_sub(iso_add(c->right, c->up), c->forward)),
                              .in_camera_space = true,
                              .intensity = 0.5};
    make_tf(&v.tf, level0);
    return v;
}

/* ---- differences ------------------------------------------------------------ */

static iso_image render_gl(const iso_level *level, iso_code code, const iso_view *view, iso_direction_source source)
{
    iso_image image;
    iso_gl_options opt = iso_gl_defaults();
    opt.source = source;
    assert_ok(iso_gl_render(gl, level, code, view, &opt, &image, &err));
    return image;
}

static iso_image render_reference(const iso_level *level, iso_code code, const iso_view *view,
                                  iso_direction_source source)
{
    iso_image image;
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = ISO_QUADRATURE_MIDPOINT;
    opt.source = source;
    assert_ok(iso_reference_render(level, code, view, &opt, &image, NULL, &err));
    return image;
}

static void check_agreement(const iso_level *level, iso_code code, const iso_view *view, iso_direction_source source,
                            const char *what)
{
    OWNED(iso_image) a = render_gl(level, code, view, source), b = render_reference(level, code, view, source);
    difference d = difference_of(&a, &b);
    if (!(d.max_abs <= MAX_ABS && d.rmse <= RMSE))
        fail_msg("%s: max_abs %g, limit %g; rmse %g, limit %g", what, d.max_abs, MAX_ABS, d.rmse, RMSE);
    if (getenv("ISOSHADE_TEST_VERBOSE"))
        printf("%-40s max_abs %.2e rmse %.2e\n", what, d.max_abs, d.rmse);
}

/* ---- tests ------------------------------------------------------------------ */

TEST(filter_of_floats_is_probed_finer_than_8_bits_in_software)
{
    iso_gl_info info = iso_gl_describe(gl);
    printf("%s: filter bits %d (8-bit), %d (16-bit), %d (float)\n", info.renderer, info.filter_bits_unorm8,
           info.filter_bits_unorm16, info.filter_bits_float);
    assert_true(info.filter_bits_unorm8 >= 6 && info.filter_bits_unorm8 <= 24);
    if (strstr(info.renderer, "llvmpipe")) {
        assert_true(info.filter_bits_float >= 20);
        assert_true(info.filter_bits_unorm16 >= 20);
    }
}

TEST(every_source_and_code_agrees_with_the_reference_at_every_level)
{
    for (int code = 0; code < ISO_CODE_COUNT; ++code) {
        if (!iso_code_describe((iso_code)code)->is_textured)
            continue;
        OWNED(iso_pyramid) p = make_pyramid(ISO_F32, (iso_code)code);
        OWNED(iso_view) view = make_view(PERSPECTIVE, &p.levels[0]);
        for (size_t k = 0; k < p.level_count; ++k)
            for (int source = 0; source <= ISO_FROM_ON_THE_FLY; ++source) { /* palettes: test_palette_render.c */
                char what[96];
                snprintf(what, sizeof what, "%s, level %zu, %s", iso_code_describe((iso_code)code)->name, k,
                         iso_direction_source_name((iso_direction_source)source));
                check_agreement(&p.levels[k], (iso_code)code, &view, (iso_direction_source)source, what);
            }
    }
}

static iso_image render_exactly(const iso_level *level, const iso_view *view, iso_direction_source source)
{
    iso_image image;
    iso_gl_options opt = iso_gl_defaults();
    opt.source = source;
    opt.exact_lookups = true;
    assert_ok(iso_gl_render(gl, level, ISO_CODE_SNORM, view, &opt, &image, &err));
    return image;
}

/* A table whose entries jump between nothing and opaque multiplies what a texture coordinate rounds. Looked up exactly,
 * the same samples meet half the limits of smooth tables, so that what the filter's image is off (the planted fault) is
 * the coordinates' alone. */
TEST(exact_lookups_leave_out_what_texture_coordinates_round)
{
    static const iso_direction_source sources[] = {ISO_FROM_CODES, ISO_FROM_ON_THE_FLY};
    OWNED(iso_pyramid) p = make_pyramid(ISO_F32, ISO_CODE_SNORM);
    for (size_t k = 0; k < p.level_count; ++k)
        for (size_t i = 0; i < 2; ++i) {
            OWNED(iso_view) view = make_view(PERSPECTIVE, &p.levels[0]);
            for (size_t e = 0; e < view.tf.count; ++e)
                view.tf.entries[4 * e + 3] = e % 8 < 4 ? 0.0f : 6.0f;
            OWNED(iso_image) wanted = render_reference(&p.levels[k], ISO_CODE_SNORM, &view, sources[i]);
            OWNED(iso_image) exact = render_exactly(&p.levels[k], &view, sources[i]);
            OWNED(iso_image) filtered = render_gl(&p.levels[k], ISO_CODE_SNORM, &view, sources[i]);
            difference of_exact = difference_of(&exact, &wanted), of_filtered = difference_of(&filtered, &wanted);
            if (getenv("ISOSHADE_TEST_VERBOSE"))
                printf("level %zu, %s: exact %.2e %.2e, filtered %.2e %.2e\n", k, iso_direction_source_name(sources[i]),
                       of_exact.max_abs, of_exact.rmse, of_filtered.max_abs, of_filtered.rmse);
            assert_at_most(of_exact.max_abs, MAX_ABS / 2); /* 4.2e-6 and 1e-7 are seen: floats of sums and colors */
            assert_at_most(of_exact.rmse, RMSE / 2);
            if (k == 0) /* the most voxels, of which a coordinate rounds the same part */
                assert_more_than(of_filtered.rmse, 2 * of_exact.rmse);
        }
    OWNED(iso_view) view = make_view(PERSPECTIVE, &p.levels[0]);
    iso_gl_options opt = iso_gl_defaults();
    iso_image none;
    opt.exact_lookups = opt.preintegrated = true;
    assert_status(iso_gl_render(gl, &p.levels[0], ISO_CODE_SNORM, &view, &opt, &none, &err), ISO_E_USAGE);
}

/* Between the faces of a plate nearly every point turns some of its eight directions. */
TEST(the_flipped_fetch_of_a_plate_agrees_with_the_reference)
{
    iso_field f = {.kind = ISO_FIELD_PLATE, .geometry = rotated_geometry(40, 56, 33)};
    iso_pyramid_options opt = iso_pyramid_defaults();
    OWNED(iso_pyramid) p = sampled_pyramid(&f, ISO_F32, &opt);
    OWNED(iso_view) view = make_view(PERSPECTIVE, &p.levels[0]);
    for (size_t k = 0; k < 2; ++k)
        check_agreement(&p.levels[k], opt.code, &view, ISO_FROM_FLIPPED, k ? "plate, level 1" : "plate");
    OWNED(iso_image) flipped = render_gl(&p.levels[0], opt.code, &view, ISO_FROM_FLIPPED);
    OWNED(iso_image) plain = render_reference(&p.levels[0], opt.code, &view, ISO_FROM_CODES);
    assert_more_than(difference_of(&flipped, &plain).rmse, 100 * RMSE); /* the planted fault: the plain fetch */
}

TEST(every_stored_type_and_camera_agrees_with_the_reference)
{
    static const iso_type types[] = {ISO_U8, ISO_U16, ISO_I16, ISO_F32};
    static const char *const views[] = {"perspective", "orthographic", "inside"};
    for (size_t t = 0; t < 4; ++t) {
        OWNED(iso_pyramid) p = make_pyramid(types[t], ISO_CODE_SNORM);
        for (int kind = PERSPECTIVE; kind <= INSIDE; ++kind) {
            OWNED(iso_view) view = make_view((view_kind)kind, &p.levels[0]);
            char what[96];
            snprintf(what, sizeof what, "%s, %s", iso_type_name(types[t]), views[kind]);
            check_agreement(&p.levels[0], ISO_CODE_SNORM, &view, kind == INSIDE ? ISO_FROM_ON_THE_FLY : ISO_FROM_CODES,
                            what);
        }
    }
}

VALUES_TEST(every_reference_scene_agrees_at_every_level)
{
    static const struct {
        const char *scene;
        iso_field_kind kind;
        iso_type type;
    } cases[] = {{"refscenes/brain.scene.json", ISO_FIELD_SPHERE, ISO_I16},
                 {"refscenes/marschner-lobb.scene.json", ISO_FIELD_MARSCHNER_LOBB, ISO_U16},
                 {"refscenes/shells.scene.json", ISO_FIELD_SHELLS, ISO_F32},
                 {"refscenes/shells.scene.json", ISO_FIELD_NOISE, ISO_U8}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        iso_field f = {.kind = cases[i].kind, .geometry = rotated_geometry(40, 56, 33), .seed = 1};
        OWNED(iso_scene) scene;
        OWNED(iso_view) view;
        iso_pyramid_options opt = iso_pyramid_defaults();
        opt.level_count = 3;
        OWNED(iso_pyramid) p = sampled_pyramid(&f, cases[i].type, &opt);
        assert_ok(iso_scene_load(cases[i].scene, &scene, &err));
        assert_ok(iso_scene_resolve(&scene, &f.geometry, p.levels[0].min, p.levels[0].max, &view, &err));
        view.width = view.height = 64;
        for (size_t k = 0; k < p.level_count; ++k) {
            char what[96];
            snprintf(what, sizeof what, "%s, %s, level %zu", cases[i].scene, iso_field_name(cases[i].kind), k);
            check_agreement(&p.levels[k], opt.code, &view, ISO_FROM_CODES, what);
            check_agreement(&p.levels[k], opt.code, &view, ISO_FROM_ON_THE_FLY, what);
        }
    }
}

/* Axes of one voxel, no contrast, rays along the axes, cameras in the box's center, beyond it and beside it. */
TEST(degenerate_volumes_and_cameras_agree)
{
    static const size_t sizes[][3] = {{1, 9, 5}, {7, 1, 1}, {6, 5, 4}};
    for (size_t i = 0; i < 3; ++i) {
        iso_geometry g = iso_geometry_axis_aligned(sizes[i], (const double[3]){1, 2, 0.5});
        for (int kind = ISO_FIELD_RAMP; kind <= ISO_FIELD_CONSTANT; kind += ISO_FIELD_CONSTANT) {
            iso_field f = {.kind = (iso_field_kind)kind, .geometry = g};
            iso_pyramid_options opt = iso_pyramid_defaults();
            opt.level_count = 1;
            OWNED(iso_pyramid) p = sampled_pyramid(&f, ISO_F32, &opt);
            iso_level range = p.levels[0];
            range.min = -0.5, range.max = 1;
            for (int place = -2; place <= 2; ++place) {
                OWNED(iso_view) view = make_view(place ? ORTHOGRAPHIC : PERSPECTIVE, &range);
                view.camera.forward = iso_v3(0, 1, 0), view.camera.right = iso_v3(1, 0, 0);
                view.camera.up = iso_v3(0, 0, 1);
                view.camera.position = iso_v3(0, 4.0 * place, 0);
                char what[96];
                snprintf(what, sizeof what, "%zu x %zu x %zu, %s, camera at y = %d", sizes[i][0], sizes[i][1],
                         sizes[i][2], iso_field_name(f.kind), 4 * place);
                check_agreement(&p.levels[0], opt.code, &view, ISO_FROM_CODES, what);
                check_agreement(&p.levels[0], opt.code, &view, ISO_FROM_ON_THE_FLY, what);
            }
        }
    }
}

/* The same samples are summed, so that only the compiler's order of operations may differ. */
TEST(leaving_out_empty_bricks_changes_nothing)
{
    OWNED(iso_pyramid) p = make_pyramid(ISO_U16, ISO_CODE_SNORM);
    for (int kind = PERSPECTIVE; kind <= INSIDE; ++kind)
        for (size_t k = 0; k < p.level_count; ++k) {
            OWNED(iso_view) view = make_view((view_kind)kind, &p.levels[0]);
            for (size_t i = 0; i < view.tf.count; ++i)
                if (i < 50)
                    view.tf.entries[4 * i + 3] = 0;
            iso_gl_options opt = iso_gl_defaults();
            iso_image plain, skipping;
            opt.skip = ISO_GL_SKIP_NEVER;
            assert_ok(iso_gl_render(gl, &p.levels[k], ISO_CODE_SNORM, &view, &opt, &plain, &err));
            opt.skip = ISO_GL_SKIP_ALWAYS;
            for (opt.brick_voxels = 1; opt.brick_voxels <= 16; opt.brick_voxels += 5) {
                assert_ok(iso_gl_render(gl, &p.levels[k], ISO_CODE_SNORM, &view, &opt, &skipping, &err));
                assert_at_most(difference_of(&plain, &skipping).max_abs, 1e-6);
                iso_image_destroy(&skipping);
            }
            iso_image_destroy(&plain);
        }
}

/* Each of these faults is what a wrong export or shader would do. */
static void rejects(const iso_level *right, const iso_level *wrong, const iso_view *right_view,
                    const iso_view *wrong_view, const char *what)
{
    OWNED(iso_image) a = render_gl(wrong, ISO_CODE_SNORM, wrong_view, ISO_FROM_CODES);
    OWNED(iso_image) b = render_reference(right, ISO_CODE_SNORM, right_view, ISO_FROM_CODES);
    difference d = difference_of(&a, &b);
    if (!(d.max_abs > MAX_ABS && d.rmse > RMSE))
        fail_msg("%s passes: max_abs %g, rmse %g", what, d.max_abs, d.rmse);
}

TEST(known_faults_are_rejected)
{
    OWNED(iso_pyramid) p = make_pyramid(ISO_U16, ISO_CODE_SNORM);
    iso_level *level = &p.levels[0];
    OWNED(iso_view) view = make_view(PERSPECTIVE, level), wrong_view = view;
    iso_level wrong = *level;
    wrong.geometry.origin_mm = iso_geometry_to_world(&wrong.geometry, iso_v3(0.5, 0, 0));
    rejects(level, &wrong, &view, &view, "half a voxel of shift");

    wrong = *level;
    for (int row = 0; row < 3; ++row) {
        double *m = wrong.geometry.index_to_world.m[row], swapped = m[0];
        m[0] = m[1];
        m[1] = swapped;
    }
    rejects(level, &wrong, &view, &view, "a swapped axis");

    wrong_view.lights[0].direction = iso_v3(1, -0.5, 2);
    rejects(level, level, &view, &wrong_view, "a light from the wrong side");

    wrong_view = view;
    make_tf(&wrong_view.tf, level);
    for (size_t i = 0; i < 4 * wrong_view.tf.count; ++i)
        if (i % 4 != 3)
            wrong_view.tf.entries[i] = powf(wrong_view.tf.entries[i], 1 / 2.2f);
    rejects(level, level, &view, &wrong_view, "an sRGB TF");
}

TEST(images_do_not_differ_between_runs)
{
    OWNED(iso_pyramid) p = make_pyramid(ISO_U8, ISO_CODE_SNORM);
    OWNED(iso_view) view = make_view(PERSPECTIVE, &p.levels[0]);
    OWNED(iso_image) a = render_gl(&p.levels[1], ISO_CODE_SNORM, &view, ISO_FROM_CODES);
    OWNED(iso_image) b = render_gl(&p.levels[1], ISO_CODE_SNORM, &view, ISO_FROM_CODES);
    assert_memory_equal(a.rgba, b.rgba, 4 * a.width * a.height * sizeof *a.rgba);
}

TEST(volume_beyond_the_texture_limit_is_refused_with_both_sizes)
{
    float scalar = 0;
    iso_level level = {.geometry = iso_geometry_axis_aligned((const size_t[3]){100000, 1, 1},
                                                             (const double[3]){1, 1, 1}),
                       .stored_type = ISO_F32,
                       .scalar = &scalar,
                       .max = 1};
    OWNED(iso_view) view = make_view(PERSPECTIVE, &level);
    iso_gl_options opt = iso_gl_defaults();
    iso_image image;
    iso_error err = {""};
    assert_int_equal(iso_gl_render(gl, &level, ISO_CODE_SNORM, &view, &opt, &image, &err), ISO_E_RANGE);
    assert_non_null(strstr(err.text, "100000 x 1 x 1"));
    assert_non_null(strstr(err.text, "at most"));
}

TEST(missing_float_directions_are_refused)
{
    OWNED(iso_pyramid) p = make_pyramid(ISO_U8, ISO_CODE_SNORM);
    iso_level level = p.levels[0];
    level.directions = NULL;
    OWNED(iso_view) view = make_view(PERSPECTIVE, &level);
    iso_gl_options opt = {.source = ISO_FROM_FLOAT};
    iso_image image;
    assert_status(iso_gl_render(gl, &level, ISO_CODE_SNORM, &view, &opt, &image, &err), ISO_E_RANGE);
}

TEST(missing_shader_folder_is_named)
{
    iso_gl *other;
    iso_error err = {""};
    assert_int_equal(iso_gl_create(&other, "/nonexistent-shaders", &err), ISO_E_IO);
    assert_non_null(strstr(err.text, "/nonexistent-shaders"));
    assert_null(other);
}

TEST(shader_folder_of_the_sources_gives_the_same_image)
{
    OWNED(iso_pyramid) p = make_pyramid(ISO_U8, ISO_CODE_REGION48);
    OWNED(iso_view) view = make_view(ORTHOGRAPHIC, &p.levels[0]);
    OWNED(iso_image) a = render_gl(&p.levels[0], ISO_CODE_REGION48, &view, ISO_FROM_CODES), b;
    iso_gl_options opt = iso_gl_defaults();
    iso_gl *other;
    assert_ok(iso_gl_create(&other, "src/render/gl/shaders", &err));
    assert_ok(iso_gl_render(other, &p.levels[0], ISO_CODE_REGION48, &view, &opt, &b, &err));
    assert_memory_equal(a.rgba, b.rgba, 4 * a.width * a.height * sizeof *a.rgba);
    iso_gl_destroy(other);
}

/* ---- calls that can be canceled ---- */

/* Goes on for a number of reports, then cancels. */
typedef struct patience {
    size_t reports, most;
} patience;

static bool is_patient(void *user, const char *stage, double fraction)
{
    patience *p = user;
    assert_string_equal(stage, "draw");
    assert_true(fraction > 0 && fraction <= 1);
    return ++p->reports < p->most;
}

/* Renders within a call, in bands of so many tiles. Counts the pixels that GL draws. */
static iso_status render_in_bands(const iso_level *level, const iso_view *view, const iso_gl_options *opt, double tiles,
                                  patience *p, GLuint *pixels, iso_image *image)
{
    const double before = gl->band_samples, step_mm = view->step_voxels * iso_geometry_min_spacing_mm(&level->geometry),
                 ray_samples = 2 * iso_geometry_box_radius_mm(&level->geometry) / step_mm;
    iso_error failure = {""};
    iso_call call;
    GLuint query;
    gl->band_samples = (tiles + 0.5) * ISO_SCREEN_TILE * ISO_SCREEN_TILE * ray_samples;
    assert_ok(iso_gl_bind(gl, &err));
    glGenQueries(1, &query);
    glBeginQuery(GL_SAMPLES_PASSED, query);
    iso_call_begin(&call, is_patient, p);
    call.next_poll = INFINITY; /* nothing here depends on time */
    const iso_status status = iso_gl_render(gl, level, ISO_CODE_SNORM, view, opt, image, &failure);
    glEndQuery(GL_SAMPLES_PASSED);
    glGetQueryObjectuiv(query, GL_QUERY_RESULT, pixels);
    glDeleteQueries(1, &query);
    gl->band_samples = before;
    return iso_call_end(&call, status, &failure);
}

/* Neither side is a multiple of a tile's, and no band divides the 35 tiles but a single tile and all of them. */
TEST(a_picture_in_bands_is_the_one_drawn_at_once)
{
    static const struct {
        double tiles;
        size_t reports;
    } bands[] = {{0, 35}, {1, 35}, {4, 9}, {17, 3}, {35, 1}, {1e9, 1}};
    OWNED(iso_pyramid) p = make_pyramid(ISO_F32, ISO_CODE_SNORM);
    OWNED(iso_view) view = make_view(PERSPECTIVE, &p.levels[0]);
    view.width = 51, view.height = 37;
    for (size_t e = 0; e < view.tf.count; ++e)
        view.tf.entries[4 * e + 3] = e < 50 ? 0 : 0.3f; /* tiles without a visible brick are left out */
    GLuint drawn[2] = {0, 0};
    for (int skip = ISO_GL_SKIP_NEVER; skip <= ISO_GL_SKIP_ALWAYS; ++skip) {
        iso_gl_options opt = iso_gl_defaults();
        opt.skip = (iso_gl_skip)skip;
        OWNED(iso_image) whole = {0};
        assert_ok(iso_gl_render(gl, &p.levels[0], ISO_CODE_SNORM, &view, &opt, &whole, &err));
        for (size_t i = 0; i < sizeof bands / sizeof *bands; ++i) {
            patience endless = {0, SIZE_MAX};
            OWNED(iso_image) image = {0};
            assert_ok(render_in_bands(&p.levels[0], &view, &opt, bands[i].tiles, &endless, &drawn[skip - 1], &image));
            assert_memory_equal(image.rgba, whole.rgba, 4 * 51 * 37 * sizeof *image.rgba);
            assert_int_equal(endless.reports, bands[i].reports);
        }
    }
    assert_int_equal(drawn[0], 51 * 37);
    assert_in_range(drawn[1], 1, 51 * 37 - 1);
}

TEST(a_canceled_call_draws_no_further_band)
{
    OWNED(iso_pyramid) p = make_pyramid(ISO_F32, ISO_CODE_SNORM);
    OWNED(iso_view) view = make_view(PERSPECTIVE, &p.levels[0]);
    iso_gl_options opt = iso_gl_defaults();
    opt.skip = ISO_GL_SKIP_NEVER;
    for (GLuint reports = 1; reports < 3; ++reports) {
        patience little = {0, reports};
        GLuint pixels;
        iso_image image;
        assert_int_equal(render_in_bands(&p.levels[0], &view, &opt, 4, &little, &pixels, &image), ISO_E_CANCELED);
        assert_null(image.rgba);
        assert_int_equal(little.reports, reports);
        assert_int_equal(pixels, reports * 4 * ISO_SCREEN_TILE * ISO_SCREEN_TILE);
    }
    patience none = {0, 1};
    GLuint pixels;
    OWNED(iso_image) image = {0};
    opt.repeats = 2; /* which are for their time */
    assert_ok(render_in_bands(&p.levels[0], &view, &opt, 4, &none, &pixels, &image));
    assert_int_equal(none.reports, 0);
    assert_int_equal(pixels, 2 * view.width * view.height);
}

/* In a process of its own, as libEGL looks for its vendors once; a fresh program, not a mere fork, since libraries'
 * threads
 *    and their locks do not come along into a fork. */
#define WITHOUT_VENDORS "--without-vendors"
extern char **environ;
static int status_without_vendors = -1;
static void ask_without_vendors(void)
{
    char *const arguments[] = {"test_raycaster", WITHOUT_VENDORS, NULL};
    const char *before = getenv("__EGL_VENDOR_LIBRARY_FILENAMES");
    FREED char *vendors = before ? strdup(before) : NULL;
    pid_t child;
    setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent.json", 1);
    if (posix_spawn(&child, "/proc/self/exe", NULL, NULL, arguments, environ) == 0)
        waitpid(child, &status_without_vendors, 0);
    unsetenv("__EGL_VENDOR_LIBRARY_FILENAMES");
    if (vendors)
        setenv("__EGL_VENDOR_LIBRARY_FILENAMES", vendors, 1);
}

static _Noreturn void answer_without_vendors(void)
{
    iso_error err = {""};
    iso_status status = iso_gl_create(&gl, NULL, &err);
    _exit(status == ISO_E_MISSING && strstr(err.text, "no OpenGL 4.3 context by EGL") ? 0 : 1);
}

TEST(missing_egl_vendor_is_reported_with_what_was_tried)
{
    assert_int_equal(status_without_vendors, 0);
}

/* The answer without vendors is asked of a child, before this process has a context. */
static int ask_and_open_gl(void **state)
{
    ask_without_vendors();
    return open_gl(state);
}

int main(int count, char **arguments)
{
    if (count == 2 && strcmp(arguments[1], WITHOUT_VENDORS) == 0)
        answer_without_vendors();
    return run_cases(ask_and_open_gl, close_gl);
}
