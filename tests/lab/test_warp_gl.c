/* SPDX-License-Identifier: MIT */
/* The paper's transitions in GLSL: what the CPU has from the same definition, and continuous where that is. */
#include "tests/sampled.h"
#include "tests/gl.h"

#include "base/random.h"
#include "lab/warp_gl.h"
#include "render/reference_ray.h"
#include "volume/synthetic.h"

#define BRICK 8

static iso_random random_state;

static double random_unit(void)
{
    return iso_random_unit(&random_state);
}

/* Noise in 0..1 on whole bricks, as a level and a field of one channel. */
typedef struct noise {
    iso_level level;
    iso_warp_field field;
} noise;

static noise make_noise(size_t nx, size_t ny, size_t nz)
{
    const size_t size[3] = {BRICK * nx, BRICK * ny, BRICK * nz}, count = size[0] * size[1] * size[2];
    noise n = {
        .level = {.geometry = iso_geometry_axis_aligned(size, (double[]){1, 1, 1}), .stored_type = ISO_F32, .max = 1}};
    n.level.scalar = malloc(count * sizeof(float));
    assert_non_null(n.level.scalar);
    for (size_t i = 0; i < count; ++i)
        n.level.scalar[i] = (float)random_unit();
    assert_ok(iso_warp_field_create(&n.field, n.level.scalar, 1, size, BRICK, &err));
    return n;
}

static void destroy_noise(noise *n)
{
    iso_warp_field_destroy(&n->field);
    free(n->level.scalar);
}

enum { POINTS = 400 };

/* Points of faces, half of them near edges, each in every brick that holds it. Returns the largest difference between
 * the bricks that share a point; *apart: between GL and the CPU. */
static double worst_jump(const noise *n, double *apart)
{
    const iso_warp_field *f = &n->field;
    const size_t count[3] = {iso_warp_bricks(f, 0), iso_warp_bricks(f, 1), iso_warp_bricks(f, 2)};
    double(*places)[4] = malloc(8 * POINTS * sizeof *places);
    float(*values)[4] = malloc(8 * POINTS * sizeof *values);
    size_t first[POINTS + 1], used = 0;
    assert_true(places && values);
    for (size_t i = 0; i < POINTS; ++i) {
        const int across = (int)(3 * random_unit());
        double p[3];
        for (int a = 0; a < 3; ++a) {
            const double face = BRICK * (1 + floor((double)(count[a] - 1) * random_unit()));
            p[a] = a == across           ? face
                   : random_unit() < 0.5 ? (double)f->size[a] * random_unit()
                                         : face + random_unit() - 0.5;
            p[a] = (double)(float)p[a]; /* what the shader is given */
        }
        first[i] = used;
        for (size_t b = 0; b < count[0] * count[1] * count[2]; ++b) {
            const size_t brick[3] = {b % count[0], b / count[0] % count[1], b / (count[0] * count[1])};
            bool inside = true;
            for (int a = 0; a < 3; ++a)
                inside = inside && p[a] >= (double)(BRICK * brick[a]) && p[a] <= (double)(BRICK * (brick[a] + 1));
            if (inside)
                memcpy(places[used++], (double[]){p[0], p[1], p[2], (double)b}, sizeof *places);
        }
    }
    first[POINTS] = used;
    assert_ok(iso_gl_sample_warp(gl, &(iso_gl_warp){f, &n->level}, &places[0][0], used, &values[0][0], &err));
    double worst = 0;
    for (size_t i = 0; i < POINTS; ++i) {
        double min = INFINITY, max = -INFINITY;
        for (size_t k = first[i]; k < first[i + 1]; ++k) {
            const size_t b = (size_t)places[k][3];
            const size_t brick[3] = {b % count[0], b / count[0] % count[1], b / (count[0] * count[1])};
            const double value = (double)values[k][0],
                         difference = fabs(value - iso_warp_sample_in(f, brick, places[k]));
            min = fmin(min, value), max = isnan(value) ? NAN : fmax(max, value);
            *apart = difference <= *apart ? *apart : difference;
        }
        worst = max - min <= worst ? worst : max - min;
    }
    free(places);
    free(values);
    return worst;
}

/* Coordinates are floats: 1e-7 of a cache of 34 texels is 3e-6 texels, and noise changes by 1 a texel. */
#define FILTER 1e-5
#define SEEN 1e-3

TEST(glsl_is_the_cpu_s_definition_in_every_configuration)
{
    random_state = (iso_random){1};
    noise n = make_noise(2, 2, 2);
    uint8_t levels[8];
    n.field.levels = levels;
    double corrected = 0, apart = 0;
    int jumps = 0, own_jumps = 0;
    for (int k = 0; k < 256; ++k) {
        double near_faces = 0;
        for (int i = 0; i < 8; ++i)
            levels[i] = (uint8_t)(k >> i & 1);
        n.field.mode = ISO_WARP_CORRECTED;
        corrected = fmax(corrected, worst_jump(&n, &apart));
        /* As written the last 1e-6 before a face are left out: there floats are apart. */
        n.field.mode = ISO_WARP_WRITTEN;
        jumps += worst_jump(&n, &near_faces) > SEEN;
        n.field.mode = ISO_WARP_NONE;
        own_jumps += worst_jump(&n, &apart) > 0.02;
    }
    printf(
        "corrected: %.1e between bricks; %.1e from the CPU; of 256 configurations %d jump as written, %d without transitions\n",
        corrected, apart, jumps, own_jumps);
    assert_at_most(corrected, FILTER);
    assert_at_most(apart, FILTER);
    assert_int_equal(jumps, 172); /* those of tests/lab/test_warp.c */
    assert_int_equal(own_jumps, 254);
    destroy_noise(&n);
}

TEST(written_is_continuous_round_a_box_and_corrected_in_random_layouts)
{
    random_state = (iso_random){2};
    noise n = make_noise(4, 4, 3);
    uint8_t levels[48];
    double apart = 0;
    n.field.levels = levels;
    memset(levels, 1, sizeof levels);
    levels[1 + 4 * (1 + 4 * 1)] = levels[2 + 4 * (1 + 4 * 1)] = 0;
    n.field.mode = ISO_WARP_WRITTEN;
    for (int i = 0; i < 5; ++i)
        assert_at_most(worst_jump(&n, &apart), 10 * FILTER); /* Eq. 8 divides by 1 - 2v */
    int rejected = 0;
    double corrected = 0;
    for (int layout = 0; layout < 100; ++layout) {
        for (size_t i = 0; i < sizeof levels; ++i)
            levels[i] = random_unit() < 0.5;
        n.field.mode = ISO_WARP_CORRECTED;
        corrected = fmax(corrected, worst_jump(&n, &apart));
        n.field.mode = ISO_WARP_WRITTEN;
        rejected += worst_jump(&n, &apart) > SEEN;
    }
    printf("random layouts: corrected jumps by %.1e, as written %d of 100 jump\n", corrected, rejected);
    assert_at_most(corrected, FILTER);
    assert_more_than(rejected, 95);
    destroy_noise(&n);
}

static double difference(const iso_image *a, const iso_image *b, double *max)
{
    const size_t count = 4 * a->width * a->height;
    double sum = 0;
    *max = 0;
    for (size_t i = 0; i < count; ++i) {
        const double e = fabs((double)a->rgba[i] - (double)b->rgba[i]);
        *max = e <= *max ? *max : e;
        sum += e * e;
    }
    return sqrt(sum / (double)count);
}

/* The field as a medium of the reference. */
static double emit(const iso_emitter *e, const iso_emitter_place *at, double color[3])
{
    double v[ISO_WARP_CHANNELS], rgbs[4], n[3];
    iso_warp_sample(e->field, at->index, v);
    iso_tf_lookup(&at->view->tf, v[0], rgbs);
    iso_code_normal(v + 1, n);
    const double scale = rgbs[3] * iso_shade(at->view, iso_v3(n[0], n[1], n[2]), at->to_viewer);
    for (int c = 0; c < 3; ++c)
        color[c] = scale * rgbs[c];
    return rgbs[3];
}

TEST(images_agree_with_the_reference_in_every_mode)
{
    iso_field kind = {.kind = ISO_FIELD_MARSCHNER_LOBB, .seed = 3};
    kind.geometry = iso_geometry_axis_aligned((size_t[]){40, 44, 33}, (double[]){1, 0.9, 1.3});
    iso_pyramid_options build = iso_pyramid_defaults();
    OWNED(iso_scene) scene;
    OWNED(iso_view) view;
    OWNED(iso_warp_field) f;
    build.level_count = 1;
    OWNED(iso_pyramid) p = sampled_pyramid(&kind, ISO_F32, &build);
    const iso_level *level = &p.levels[0];
    assert_ok(iso_scene_load("refscenes/marschner-lobb.scene.json", &scene, &err));
    scene.width = 64, scene.height = 56;
    assert_ok(iso_scene_resolve(&scene, &level->geometry, level->min, level->max, &view, &err));
    assert_ok(iso_warp_field_of_level(&f, level, p.options.code, BRICK, &err));
    uint8_t levels[5 * 6 * 5];
    assert_int_equal(iso_warp_bricks(&f, 0) * iso_warp_bricks(&f, 1) * iso_warp_bricks(&f, 2), sizeof levels);
    random_state = (iso_random){5};
    for (size_t i = 0; i < sizeof levels; ++i)
        levels[i] = random_unit() < 0.5;
    f.levels = levels;
    iso_image written = {0};
    for (int mode = 0; mode < ISO_WARP_MODE_COUNT; ++mode) {
        iso_reference_options exact = iso_reference_defaults();
        iso_gl_brick_options opt = iso_gl_brick_defaults();
        iso_image a, b;
        double max, rmse;
        const iso_emitter medium = {emit, &f};
        exact.quadrature = ISO_QUADRATURE_MIDPOINT;
        exact.emitter = &medium;
        opt.cache_bits = 32;
        f.mode = (iso_warp_mode)mode;
        assert_ok(iso_gl_render_warp(gl, &(iso_gl_warp){&f, level}, &view, &opt, &a, NULL, &err));
        assert_ok(iso_reference_render(level, p.options.code, &view, &exact, &b, NULL, &err));
        rmse = difference(&a, &b, &max);
        printf("mode %d: RMSE %.1e, max %.1e\n", mode, rmse, max);
        /* As tests/test_bricks_gl.c: where the field jumps a sample may fall to the other side. */
        assert_at_most(rmse, mode == ISO_WARP_CORRECTED ? 1e-6 : 1e-3);
        if (mode == ISO_WARP_CORRECTED) {
            assert_at_most(max, 2e-5);
            assert_more_than(difference(&written, &b, &max), 1e-4); /* the one is not taken for the other */
        }
        iso_image_destroy(&written);
        written = a;
        iso_image_destroy(&b);
    }
    iso_image_destroy(&written);
}

TEST_MAIN(open_gl, close_gl)
