/* SPDX-License-Identifier: MIT */
/* Pictures with derivatives: the caster's pictures; gradients against finite differences of a sum in double precision,
 * and against the closed form of a slab; the same from each instruction set. */
#include "rendered.h"
#include "test.h"

#include "base/random.h"
#include "render/cpu/adjoint.h"

/* Causes: floats of positions, of the table's entries and of the light from behind a sample, which is a difference of
 * sums. 9e-6 was seen. Of the derivative itself plus the root mean square of all of its kind. */
#define GRADIENT 3e-5

enum { NX = 7, NY = 6, NZ = 5, VOXELS = NX * NY * NZ, ENTRIES = 48, PIXELS = ISO_ADJOINT_PIXELS };

/* A field with its view and a weight for each float of a tile, and the same in doubles. */
typedef struct problem {
    iso_geometry geometry;
    iso_view view;
    iso_adjoint_tile tile;
    float voxels[4 * VOXELS], octaves[VOXELS], weights[4 * PIXELS], table[4 * ENTRIES];
    double at[5 * VOXELS + 4 * ENTRIES]; /* voxels, octaves, table */
} problem;
enum { OCTAVES = 4 * VOXELS, TABLE = 5 * VOXELS, PARAMETERS = TABLE + 4 * ENTRIES };

static float between(iso_random *r, double lo, double hi)
{
    return (float)(lo + (hi - lo) * iso_random_unit(r));
}

static void make_view(problem *p, bool orthographic)
{
    iso_view *v = &p->view;
    const iso_vec3 center = iso_geometry_box_center_mm(&p->geometry), forward = iso_normalize(iso_v3(2, -1, 0.7));
    const double radius = iso_geometry_box_radius_mm(&p->geometry);
    const iso_vec3 right = iso_normalize(iso_cross(forward, iso_v3(0, 0, 1)));
    *v = (iso_view){.width = 45, .height = 37, .step_voxels = 0.7};
    v->camera = (iso_camera){orthographic,
                             iso_madd(center, forward, -3 * radius),
                             forward,
                             right,
                             iso_cross(right, forward),
                             orthographic ? 0.9 * radius : 0.35};
    v->shading = (iso_shading){0.2, 0.5, 0.3, 9};
    v->light_count = 2;
    v->lights[0] = (iso_light){iso_normalize(iso_v3(-1, 0.4, 0.8)), false, 0.7};
    v->lights[1] = (iso_light){iso_normalize(iso_v3(0.3, 1, -0.2)), false, 0.3};
    v->clip_count = 1;
    v->clips[0] = (iso_clip_plane){iso_normalize(iso_v3(1, 1, -0.4)), -2};
    v->clips[0].offset_mm = iso_dot(v->clips[0].normal, center) - 0.6 * radius;
    v->background[1] = 0.4;
    v->tf = (iso_tf_table){.count = ENTRIES, .lo = 0.1, .hi = 0.85, .entries = p->table};
}

static problem *make_problem(bool orthographic)
{
    problem *p = calloc(1, sizeof *p);
    iso_random r = {.state = 11};
    p->geometry = rotated_geometry(NX, NY, NZ);
    p->tile = (iso_adjoint_tile){.x = 9, .y = 4};
    for (size_t i = 0; i < 4 * VOXELS; ++i)
        p->voxels[i] = i % 4 == 0 ? between(&r, 0, 1) : between(&r, -0.6, 0.6);
    for (size_t i = 0; i < VOXELS; ++i)
        p->octaves[i] = between(&r, -1, 0.8);
    for (size_t i = 0; i < 4 * ENTRIES; ++i)
        p->table[i] = i % 4 == 3 ? (float)fmax(0, 0.5 + 0.6 * sin(0.2 * (double)i / 4))
                                 : (float)(0.5 + 0.4 * cos(0.07 * (double)i + (double)(i % 4)));
    for (size_t i = 0; i < 4 * PIXELS; ++i) /* every third pixel along both axes counts */
        p->weights[i] = i / 4 % ISO_ADJOINT_TILE % 3 == 1 && i / 4 / ISO_ADJOINT_TILE % 3 == 2 ? between(&r, -1, 1) : 0;
    make_view(p, orthographic);
    for (size_t i = 0; i < PARAMETERS; ++i)
        p->at[i] = (double)(i < OCTAVES ? p->voxels[i] : i < TABLE ? p->octaves[i - OCTAVES] : p->table[i - TABLE]);
    return p;
}

static iso_adjoint_field field_of(const problem *p)
{
    return (iso_adjoint_field){&p->geometry, p->voxels, p->octaves};
}

/* ---- the same in doubles ---- */

/* Filters number `k` of `stride` per voxel. */
static double filter(const double *values, size_t stride, size_t k, iso_vec3 index)
{
    static const size_t size[3] = {NX, NY, NZ};
    const double x[3] = {index.x - 0.5, index.y - 0.5, index.z - 0.5};
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        size_t voxel = 0, step = 1;
        for (int a = 0; a < 3; ++a) {
            const double low = floor(x[a]), at = low + (corner >> a & 1), last = (double)size[a] - 1;
            weight *= corner >> a & 1 ? x[a] - low : 1 - (x[a] - low);
            voxel += step * (size_t)fmin(fmax(at, 0), last);
            step *= size[a];
        }
        sum += weight * values[stride * voxel + k];
    }
    return sum;
}

static double light_at(const problem *p, iso_vec3 index, iso_vec3 towards_viewer)
{
    const iso_shading *m = &p->view.shading;
    const double d[3] = {filter(p->at, 4, 1, index), filter(p->at, 4, 2, index), filter(p->at, 4, 3, index)};
    double sum = m->ambient, normal[3];
    iso_code_normal(d, normal);
    const iso_vec3 n = {normal[0], normal[1], normal[2]};
    for (size_t i = 0; i < p->view.light_count; ++i) {
        const iso_light *light = &p->view.lights[i];
        const iso_vec3 h = iso_normalize(iso_add(light->direction, towards_viewer));
        sum += light->intensity *
               (m->diffuse * fabs(iso_dot(n, light->direction)) + m->specular * pow(fabs(iso_dot(n, h)), m->power));
    }
    return sum;
}

/* Sums the weighted floats of one pixel. */
static double weighted_pixel(const problem *p, size_t column, size_t row, const float *weights)
{
    const iso_view *v = &p->view;
    const iso_ray ray = iso_camera_ray(&v->camera, v->width, v->height, column, row);
    const double step = v->step_voxels * iso_geometry_min_spacing_mm(&p->geometry);
    double t0, t1, rgb[3] = {0, 0, 0}, transmittance = 1;
    const bool hits = iso_view_ray(v, &ray, &p->geometry, &t0, &t1);
    for (double k = hits ? floor(t0 / step) : 0; hits && k * step < t1; ++k) {
        const double begin = fmax(t0, k * step), end = fmin(t1, (k + 1) * step);
        const iso_vec3 world = iso_madd(ray.origin, ray.direction, 0.5 * (begin + end)),
                       index = iso_geometry_to_index(&p->geometry, world);
        double x = (filter(p->at, 4, 0, index) - v->tf.lo) / (v->tf.hi - v->tf.lo) * (ENTRIES - 1), seen[4];
        x = fmin(fmax(x, 0), ENTRIES - 1);
        const size_t entry = (size_t)fmin(x, ENTRIES - 2);
        for (size_t c = 0; c < 4; ++c) {
            const double *e = p->at + TABLE + 4 * entry + c;
            seen[c] = e[0] + (x - (double)entry) * (e[4] - e[0]);
        }
        const double depth = seen[3] * exp2(filter(p->at + OCTAVES, 1, 0, index)) * (end - begin);
        const double weight = transmittance * -expm1(-depth), light = light_at(p, index, iso_scale(ray.direction, -1));
        for (int c = 0; c < 3; ++c)
            rgb[c] += weight * light * seen[c];
        transmittance -= weight;
    }
    double sum = (double)weights[3] * (1 - transmittance);
    for (int c = 0; c < 3; ++c)
        sum += (double)weights[c] * (rgb[c] + transmittance * v->background[c]);
    return sum;
}

static double weighted_sum(const problem *p)
{
    double sum = 0;
    for (size_t i = 0; i < PIXELS; ++i)
        if (p->weights[4 * i] != 0)
            sum += weighted_pixel(p, p->tile.x + i % ISO_ADJOINT_TILE, p->tile.y + i / ISO_ADJOINT_TILE,
                                  p->weights + 4 * i);
    return sum;
}

/* ---- gradients ---- */

typedef struct gradient {
    float voxels[4 * VOXELS], octaves[VOXELS];
    double table[4 * ENTRIES];
} gradient;

static double value_of(const gradient *g, size_t i)
{
    return i < OCTAVES ? (double)g->voxels[i] : i < TABLE ? (double)g->octaves[i - OCTAVES] : g->table[i - TABLE];
}

static gradient *differentiate(const problem *p)
{
    static float rgba[4 * PIXELS];
    gradient *g = calloc(1, sizeof *g);
    const iso_adjoint_field f = field_of(p);
    assert_ok(iso_adjoint_draw(&f, &p->view, &p->tile, rgba, &err));
    assert_ok(iso_adjoint_differentiate(&f, &p->view, &p->tile, rgba, p->weights,
                                        &(iso_adjoint_gradient){g->voxels, g->octaves, g->table}, &err));
    return g;
}

static double finite_difference(problem *p, size_t i)
{
    const double was = p->at[i], h = 1e-7;
    p->at[i] = was + h;
    const double above = weighted_sum(p);
    p->at[i] = was - h;
    const double below = weighted_sum(p);
    p->at[i] = was;
    return (above - below) / (2 * h);
}

/* Kinds of parameters: a scalar, a direction, octaves, color, extinction. */
enum { KINDS = 5 };
static int kind_of(size_t i)
{
    return i < OCTAVES ? i % 4 != 0 : i < TABLE ? 2 : 3 + ((i - TABLE) % 4 == 3);
}

/* Returns the largest difference of derivatives, as GRADIENT counts it. */
static double farthest(const gradient *g, const double *truth)
{
    double squares[KINDS] = {0}, most = 0;
    size_t counts[KINDS] = {0};
    for (size_t i = 0; i < PARAMETERS; ++i) {
        squares[kind_of(i)] += truth[i] * truth[i];
        ++counts[kind_of(i)];
    }
    for (size_t i = 0; i < PARAMETERS; ++i) {
        const double rms = sqrt(squares[kind_of(i)] / (double)counts[kind_of(i)]);
        const double d = fabs(value_of(g, i) - truth[i]) / (fabs(truth[i]) + rms);
        if (!(d <= most))
            most = d;
    }
    return most;
}

static const iso_cpu_width widths[] = {ISO_CPU_ONE, ISO_CPU_BASELINE, ISO_CPU_AVX2, ISO_CPU_AVX512};

VALUES_TEST(gradients_are_finite_differences)
{
    for (int orthographic = 0; orthographic < 2; ++orthographic) {
        problem *p = make_problem(orthographic);
        FREED double *truth = malloc(PARAMETERS * sizeof *truth);
        for (size_t i = 0; i < PARAMETERS; ++i)
            truth[i] = finite_difference(p, i);
        for (size_t w = 0; w < sizeof widths / sizeof *widths && widths[w] <= iso_cpu_widest(); ++w) {
            p->tile.width = widths[w];
            gradient *g = differentiate(p);
            const double d = farthest(g, truth);
            print_message("%s, %s: %.2g\n", iso_cpu_width_name(widths[w]),
                          orthographic ? "orthographic" : "perspective", d);
            assert_at_most(d, GRADIENT);
            free(g);
        }
        free(p);
    }
}

/* ---- pictures ---- */

TEST(pictures_are_the_casters)
{
    FREED problem *p = make_problem(false);
    static float rgba[4 * PIXELS], scalar[VOXELS], directions[3 * VOXELS];
    const iso_adjoint_field f = {&p->geometry, p->voxels, NULL};
    for (size_t i = 0; i < VOXELS; ++i) {
        scalar[i] = p->voxels[4 * i];
        memcpy(directions + 3 * i, p->voxels + 4 * i + 1, 3 * sizeof(float));
    }
    const iso_level level = {.geometry = p->geometry,
                             .stored_type = ISO_F32,
                             .scalar = scalar,
                             .directions = directions,
                             .min = 0,
                             .max = 1};
    iso_cpu_options opt = iso_cpu_defaults();
    OWNED(iso_image) image;
    opt.source = ISO_FROM_FLOAT;
    assert_ok(iso_cpu_render(&level, ISO_CODE_FIT, &p->view, &opt, &image, &err));
    assert_ok(iso_adjoint_draw(&f, &p->view, &p->tile, rgba, &err));
    for (size_t y = 0; y < ISO_ADJOINT_TILE; ++y)
        for (size_t x = 0; x < 4 * ISO_ADJOINT_TILE; ++x)
            assert_at_most(fabs((double)(rgba[4 * ISO_ADJOINT_TILE * y + x] -
                                         image.rgba[4 * ((p->tile.y + y) * image.width + p->tile.x) + x])),
                           5e-6); /* the caster's sums keep their rests, these do not */
}

TEST(a_seed_shifts_samples_and_gives_the_same_again)
{
    FREED problem *p = make_problem(true);
    static float rgba[3][4 * PIXELS];
    const iso_adjoint_field f = field_of(p);
    const uint32_t seeds[3] = {0, 5, 5};
    for (int i = 0; i < 3; ++i) {
        p->tile.seed = seeds[i];
        assert_ok(iso_adjoint_draw(&f, &p->view, &p->tile, rgba[i], &err));
    }
    assert_memory_equal(rgba[1], rgba[2], sizeof rgba[1]);
    assert_true(memcmp(rgba[0], rgba[1], sizeof rgba[0]) != 0);
}

/* ---- a slab ---- */

/* A slab of thickness L with sigma = 0.2 v 2^o, seen along an axis: alpha = 1 - exp(-sigma L). A pixel's derivatives by
 * all voxels, octaves and entries sum up to those by v, o and the table's height, whatever the samples' shifts are. */
TEST(a_slabs_derivatives_are_the_closed_form)
{
    FREED problem *p = make_problem(true);
    static float weights[4 * PIXELS];
    const double value = 0.6, octave = 0.5, length = NZ * 0.7, sigma = 0.2 * value * exp2(octave),
                 slope = length * exp(-sigma * length);
    p->geometry = iso_geometry_axis_aligned((size_t[]){NX, NY, NZ}, (double[]){1, 1, 0.7});
    p->view.camera = (iso_camera){true, {3.5, 3, -2}, {0, 0, 1}, {1, 0, 0}, {0, -1, 0}, 2};
    p->view.clip_count = 0;
    p->view.tf.lo = 0;
    p->view.tf.hi = 1;
    for (size_t i = 0; i < ENTRIES; ++i)
        p->table[4 * i + 3] = (float)(0.2 * (double)i / (ENTRIES - 1));
    for (size_t i = 0; i < VOXELS; ++i) {
        p->voxels[4 * i] = (float)value;
        p->octaves[i] = (float)octave;
    }
    for (uint32_t seed = 0; seed < 3; ++seed) {
        double scalar = 0, octaves = 0, table = 0;
        memset(weights, 0, sizeof weights);
        weights[4 * (5 * ISO_ADJOINT_TILE + 7) + 3] = 1; /* alpha of one pixel */
        memcpy(p->weights, weights, sizeof weights);
        p->tile.seed = seed;
        gradient *g = differentiate(p);
        for (size_t i = 0; i < VOXELS; ++i) {
            scalar += (double)g->voxels[4 * i];
            octaves += (double)g->octaves[i];
        }
        for (size_t i = 0; i < ENTRIES; ++i)
            table += g->table[4 * i + 3] * (double)p->table[4 * i + 3];
        assert_within(scalar, slope * sigma / value, 1e-5); /* floats: 2e-6 was seen */
        assert_within(octaves, slope * sigma * log(2), 1e-5);
        assert_within(table, slope * sigma, 1e-5);
        free(g);
    }
}

TEST_MAIN(NULL, NULL)
