/* SPDX-License-Identifier: MIT */
#include "volume/synthetic.h"

#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "base/random.h"

static const struct {
    const char *name, *summary;
} fields[] = {
#define ISO_FIELD_ROW(name, text, help) [name] = {text, help},
    ISO_FIELD_LIST(ISO_FIELD_ROW)
#undef ISO_FIELD_ROW
};
const iso_names iso_field_names = ISO_NAMES_OF_ROWS("kind", fields);

const char *iso_field_name(iso_field_kind kind)
{
    return fields[kind].name;
}

iso_status iso_field_from_name(const char *name, iso_field_kind *kind, iso_error *err)
{
    size_t row = 0;
    NEED(iso_names_find(&iso_field_names, name, &row, err));
    *kind = (iso_field_kind)row;
    return ISO_OK;
}

static double half_shortest_edge_mm(const iso_geometry *g)
{
    double spacing[3], shortest = INFINITY;
    iso_geometry_spacing_mm(g, spacing);
    for (int a = 0; a < 3; ++a)
        shortest = fmin(shortest, spacing[a] * g->box_index[a]);
    return 0.5 * shortest;
}

/* Returns the value in [0, 1] and the gradient by p, a normalized position. All fields below do the same. */
static double ramp(iso_vec3 p, double extent, iso_vec3 *d)
{
    /* Slopes differ by axis; scaled so that the whole box, `extent` half-edges
     * away from its center, stays in [0, 1]. */
    *d = iso_scale(iso_v3(1, 2, 3), 1 / (12 * extent));
    return 0.5 + iso_dot(*d, p);
}

static double slab(iso_vec3 p, double flank, iso_vec3 *d)
{
    double out = (fabs(p.z) - 0.5) / flank; /* -1/2 to 1/2 within the flank */
    *d = iso_v3(0, 0, out > -0.5 && out < 0.5 ? -copysign(1 / flank, p.z) : 0);
    return fmin(fmax(0.5 - out, 0), 1);
}

static double sphere(iso_vec3 p, iso_vec3 *d)
{
    double r = iso_norm(p);
    *d = r > 0 && r < 1 ? iso_scale(p, -1 / r) : iso_v3(0, 0, 0);
    return fmax(1 - r, 0);
}

static double gauss(double x, double width, double *slope)
{
    double v = exp(-x * x / (2 * width * width));
    *slope = -x / (width * width) * v;
    return v;
}

static double shells(iso_vec3 p, iso_vec3 *d)
{
    double r = iso_norm(p), s1, s2;
    double v = gauss(r - 0.45, 0.03, &s1) + gauss(r - 0.8, 0.03, &s2);
    *d = r > 0 ? iso_scale(p, (s1 + s2) / r) : iso_v3(0, 0, 0);
    return v;
}

static double plate(iso_vec3 p, iso_vec3 *d)
{
    const iso_vec3 normal = iso_normalize(iso_v3(1, 2, 4));
    double slope, v = gauss(iso_dot(p, normal), 0.04, &slope);
    *d = iso_scale(normal, slope);
    return v;
}

/* Returns the test signal of [marschner-1994] Eq. 7, with alpha = .25 and fM = 6. */
static double marschner_lobb(iso_vec3 p, iso_vec3 *d)
{
    const double pi = 3.14159265358979323846, alpha = 0.25, f = 6;
    double r = sqrt(p.x * p.x + p.y * p.y), inner = 2 * pi * f * cos(pi * r / 2);
    double scale = 1 / (2 * (1 + alpha));
    /* d/dr cos(inner) = sin(inner) 2 pi f (pi / 2) sin(pi r / 2); over r it is finite at r = 0 */
    double half = pi * r / 2, sinc = half > 1e-8 ? sin(half) / half : 1;
    double radial = alpha * scale * sin(inner) * 2 * pi * f * (pi / 2) * (pi / 2) * sinc;
    *d = iso_v3(radial * p.x, radial * p.y, -scale * pi / 2 * cos(pi * p.z / 2));
    return scale * (1 - sin(pi * p.z / 2) + alpha * (1 + cos(inner)));
}

static double uniform(uint64_t *seed)
{
    iso_random random = {*seed};
    const double value = iso_random_unit(&random);
    *seed = random.state;
    return value;
}

#define NOISE_WAVES 24

typedef struct noise_wave {
    iso_vec3 k;
    double phase;
} noise_wave;

static void noise_waves(uint64_t seed, noise_wave waves[NOISE_WAVES])
{
    const double pi = 3.14159265358979323846;
    for (int w = 0; w < NOISE_WAVES; ++w) {
        double z = 2 * uniform(&seed) - 1, turn = 2 * pi * uniform(&seed), flat = sqrt(1 - z * z);
        double wave_number = pi * (1 + 5 * uniform(&seed));
        waves[w].k = iso_scale(iso_v3(flat * cos(turn), flat * sin(turn), z), wave_number);
        waves[w].phase = 2 * pi * uniform(&seed);
    }
}

static double noise(iso_vec3 p, uint64_t seed, iso_vec3 *d)
{
    noise_wave waves[NOISE_WAVES];
    double sum = 0;
    *d = iso_v3(0, 0, 0);
    noise_waves(seed, waves);
    for (int w = 0; w < NOISE_WAVES; ++w) {
        double angle = iso_dot(waves[w].k, p) + waves[w].phase;
        sum += sin(angle);
        *d = iso_madd(*d, waves[w].k, cos(angle) / (2.0 * NOISE_WAVES));
    }
    return 0.5 + sum / (2.0 * NOISE_WAVES);
}

/* Computes a row of noise from p in steps of `step`. Each wave turns by a constant angle per voxel, so sines follow by
 * the addition theorem. Equals noise() within rounding that grows along the row by 1e-16 per voxel. */
static void noise_row(const noise_wave waves[NOISE_WAVES], iso_vec3 p, iso_vec3 step, size_t count, double *row)
{
    double s[NOISE_WAVES], c[NOISE_WAVES], turn_s[NOISE_WAVES], turn_c[NOISE_WAVES];
    for (int w = 0; w < NOISE_WAVES; ++w) {
        double angle = iso_dot(waves[w].k, p) + waves[w].phase, turn = iso_dot(waves[w].k, step);
        s[w] = sin(angle), c[w] = cos(angle);
        turn_s[w] = sin(turn), turn_c[w] = cos(turn);
    }
    for (size_t x = 0; x < count; ++x) {
        double sum = 0;
        for (int w = 0; w < NOISE_WAVES; ++w) {
            double next = s[w] * turn_c[w] + c[w] * turn_s[w];
            sum += s[w];
            c[w] = c[w] * turn_c[w] - s[w] * turn_s[w];
            s[w] = next;
        }
        row[x] = 0.5 + sum / (2.0 * NOISE_WAVES);
    }
}

/* The union of overlapping parts, 1 - product of (1 - s_i): in [0, 1], and as smooth as each. */
typedef struct overlap {
    double rest;        /* the product */
    iso_vec3 log_slope; /* sum of ds_i / (1 - s_i) */
} overlap;

static void add_part(overlap *o, double s, iso_vec3 slope)
{
    const double rest = fmax(1 - s, 1e-12); /* of a part that is 1: its slope vanishes with the rest */
    o->rest *= rest;
    o->log_slope = iso_madd(o->log_slope, slope, 1 / rest);
}

static double join_parts(const overlap *o, iso_vec3 *d)
{
    *d = iso_scale(o->log_slope, o->rest);
    return 1 - o->rest;
}

/* Returns a flank's height, from 1 inside (depth > 0) to 0 outside. */
static double flank_at(double depth, double width, double *slope)
{
    double v = 1 / (1 + exp(-depth / width));
    *slope = v * (1 - v) / width;
    return v;
}

static double tubes(iso_vec3 p, iso_vec3 *d)
{
    static const struct {
        iso_vec3 through, along;
        double width;
    } lines[] = {{{0, 0, 0}, {1, 0.3, 0.2}, 0.09},
                 {{0.1, -0.5, 0.3}, {0.2, 1, 0.5}, 0.06},
                 {{-0.5, 0.2, -0.3}, {0.3, -0.2, 1}, 0.045},
                 {{0.5, 0.5, 0}, {-0.4, 1, -0.7}, 0.035},
                 {{0, -0.1, 0.6}, {1, 1, -0.1}, 0.03}};
    overlap sum = {.rest = 1};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; ++i) {
        const iso_vec3 along = iso_normalize(lines[i].along), from = iso_sub(p, lines[i].through);
        const iso_vec3 off = iso_madd(from, along, -iso_dot(from, along));
        const double width = lines[i].width, v = exp(-iso_dot(off, off) / (2 * width * width));
        add_part(&sum, v, iso_scale(off, -v / (width * width)));
    }
    return join_parts(&sum, d);
}

static double balls(iso_vec3 p, iso_vec3 *d)
{
    static const struct {
        iso_vec3 center;
        double radius;
    } parts[] = {{{-0.42, -0.1, 0.05}, 0.4}, {{0.42, 0.08, -0.04}, 0.42}}; /* 0.045 apart */
    overlap sum = {.rest = 1};
    for (size_t i = 0; i < 2; ++i) {
        const iso_vec3 from = iso_sub(p, parts[i].center);
        const double r = iso_norm(from);
        double slope, v = flank_at(parts[i].radius - r, 0.012, &slope);
        add_part(&sum, v, r > 0 ? iso_scale(from, -slope / r) : iso_v3(0, 0, 0));
    }
    return join_parts(&sum, d);
}

enum { VESSEL_COUNT = 31 }; /* a trunk, and four times two branches at each end */

typedef struct vessel {
    iso_vec3 from, along; /* along: unit */
    double length, radius;
} vessel;

/* Grows branch i from the end of branch (i - 1) / 2; thickness shrinks by a quarter at each fork. */
static void grow_vessels(uint64_t seed, vessel tree[VESSEL_COUNT])
{
    tree[0] = (vessel){{0.05, -0.05, -0.9}, {0, 0, 1}, 0.6, 0.1};
    for (size_t i = 1; i < VESSEL_COUNT; ++i) {
        const vessel *parent = &tree[(i - 1) / 2];
        const double turn = 6.2831853071795865 * uniform(&seed), spread = 0.45 + 0.3 * uniform(&seed);
        const iso_vec3 other = fabs(parent->along.x) < 0.7 ? iso_v3(1, 0, 0) : iso_v3(0, 1, 0);
        const iso_vec3 u = iso_normalize(iso_cross(parent->along, other)), v = iso_cross(parent->along, u);
        /* the second of a pair leaves on the other side */
        const double side = i % 2 ? 1 : -1;
        iso_vec3 away = iso_add(iso_scale(u, side * cos(0.3 * turn)), iso_scale(v, side * sin(0.3 * turn)));
        tree[i] = (vessel){iso_madd(parent->from, parent->along, parent->length),
                           iso_normalize(iso_madd(parent->along, away, tan(spread))), 0.78 * parent->length,
                           0.75 * parent->radius};
    }
}

static double vessels(iso_vec3 p, const vessel tree[VESSEL_COUNT], iso_vec3 *d)
{
    const double flank = 0.01;
    overlap sum = {.rest = 1};
    for (size_t i = 0; i < VESSEL_COUNT; ++i) {
        const iso_vec3 from = iso_sub(p, tree[i].from);
        const double t = fmin(fmax(iso_dot(from, tree[i].along), 0), tree[i].length);
        const iso_vec3 off = iso_madd(from, tree[i].along, -t);
        const double r = iso_norm(off);
        double slope, v = flank_at(tree[i].radius - r, flank, &slope);
        add_part(&sum, v, r > 0 ? iso_scale(off, -slope / r) : iso_v3(0, 0, 0));
    }
    return join_parts(&sum, d);
}

/* The part that all samples of a field share. */
typedef struct field_frame {
    double half_edge; /* mm */
    iso_vec3 center;
    double extent;             /* of the box, in half edges */
    double flank;              /* one voxel along z, in half edges */
    vessel tree[VESSEL_COUNT]; /* of vessels alone */
} field_frame;

static field_frame frame_of(const iso_field *f)
{
    const iso_geometry *g = &f->geometry;
    double spacing[3], half_edge = half_shortest_edge_mm(g);
    iso_geometry_spacing_mm(g, spacing);
    field_frame frame = {.half_edge = half_edge,
                         .center = iso_geometry_box_center_mm(g),
                         .extent = iso_geometry_box_radius_mm(g) / half_edge,
                         .flank = spacing[2] / half_edge};
    if (f->kind == ISO_FIELD_VESSELS)
        grow_vessels(f->seed, frame.tree);
    return frame;
}

static double evaluate(const iso_field *f, const field_frame *frame, iso_vec3 p, iso_vec3 *d)
{
    switch (f->kind) {
    case ISO_FIELD_RAMP: return ramp(p, frame->extent, d);
    case ISO_FIELD_SLAB: return slab(p, frame->flank, d);
    case ISO_FIELD_SPHERE: return sphere(p, d);
    case ISO_FIELD_SHELLS: return shells(p, d);
    case ISO_FIELD_PLATE: return plate(p, d);
    case ISO_FIELD_MARSCHNER_LOBB: return marschner_lobb(p, d);
    case ISO_FIELD_NOISE: return noise(p, f->seed, d);
    case ISO_FIELD_TUBES: return tubes(p, d);
    case ISO_FIELD_VESSELS: return vessels(p, frame->tree, d);
    case ISO_FIELD_BALLS: return balls(p, d);
    case ISO_FIELD_CONSTANT:
    case ISO_FIELD_COUNT: break;
    }
    *d = iso_v3(0, 0, 0);
    return 0.5;
}

double iso_field_value(const iso_field *f, iso_vec3 world_mm, iso_vec3 *gradient)
{
    field_frame frame = frame_of(f);
    iso_vec3 d;
    double value = evaluate(f, &frame, iso_scale(iso_sub(world_mm, frame.center), 1 / frame.half_edge), &d);
    if (gradient)
        *gradient = iso_scale(d, 1 / frame.half_edge);
    return fmin(fmax(value, 0), 1);
}

void iso_field_type_range(iso_type type, double *lo, double *hi)
{
    *lo = 0;
    *hi = 1;
    switch (type) {
    case ISO_U8: *hi = UINT8_MAX; break;
    case ISO_U16: *hi = UINT16_MAX; break;
    case ISO_U32: *hi = UINT32_MAX; break;
    case ISO_I8: *lo = INT8_MIN, *hi = INT8_MAX; break;
    case ISO_I16: *lo = INT16_MIN, *hi = INT16_MAX; break;
    case ISO_I32: *lo = INT32_MIN, *hi = INT32_MAX; break;
    case ISO_F32:
    case ISO_F64: break;
    }
}

static void store_sample(void *data, iso_type type, size_t at, double value)
{
    double whole = nearbyint(value);
    switch (type) {
    case ISO_F32: ((float *)data)[at] = (float)value; break;
    case ISO_F64: ((double *)data)[at] = value; break;
    case ISO_U8: ((uint8_t *)data)[at] = (uint8_t)whole; break;
    case ISO_I8: ((int8_t *)data)[at] = (int8_t)whole; break;
    case ISO_U16: ((uint16_t *)data)[at] = (uint16_t)whole; break;
    case ISO_I16: ((int16_t *)data)[at] = (int16_t)whole; break;
    case ISO_U32: ((uint32_t *)data)[at] = (uint32_t)whole; break;
    case ISO_I32: ((int32_t *)data)[at] = (int32_t)whole; break;
    }
}

/* Returns a sum of twelve uniform numbers, of variance 1. Unlike logarithms, sums are the same on every machine. */
static double grain_of_voxel(uint64_t seed, size_t voxel)
{
    iso_random random = {seed};
    random.state = iso_random_next(&random) +
                   12 * (uint64_t)voxel * 0x9e3779b97f4a7c15u; /* each voxel its own twelve */
    double sum = -6;
    for (int i = 0; i < 12; ++i)
        sum += iso_random_unit(&random);
    return sum;
}

static void add_grain(const iso_field *f, size_t first_voxel, double *row)
{
    for (size_t x = 0; f->grain > 0 && x < f->geometry.size[0]; ++x)
        row[x] += f->grain * grain_of_voxel(f->seed, first_voxel + x);
}

static void sample_row(const iso_field *f, const field_frame *frame, const noise_wave *waves, size_t y, size_t z,
                       double *row)
{
    const iso_geometry *g = &f->geometry;
    iso_vec3 world = iso_geometry_to_world(g, iso_v3(0.5, (double)y + 0.5, (double)z + 0.5)), unused;
    iso_vec3 p = iso_scale(iso_sub(world, frame->center), 1 / frame->half_edge);
    iso_vec3 step = iso_scale(iso_column(g->index_to_world, 0), 1 / frame->half_edge);
    if (f->kind == ISO_FIELD_NOISE) {
        noise_row(waves, p, step, g->size[0], row);
        return;
    }
    for (size_t x = 0; x < g->size[0]; ++x)
        row[x] = evaluate(f, frame, iso_madd(p, step, (double)x), &unused);
}

iso_status iso_field_sample_planes(const iso_field *f, iso_type type, size_t z0, size_t z1, int threads, void *out,
                                   iso_error *err)
{
    const size_t *n = f->geometry.size;
    field_frame frame = frame_of(f);
    noise_wave waves[NOISE_WAVES];
    bool no_memory = false;
    noise_waves(f->seed, waves);
    double lo = f->range[0], hi = f->range[1];
    if (!f->has_range)
        iso_field_type_range(type, &lo, &hi);
#pragma omp parallel num_threads(iso_threads(threads)) reduction(|| : no_memory)
    {
        double *row = malloc(n[0] * sizeof *row);
        no_memory = row == NULL;
#pragma omp for schedule(static)
        for (size_t r = z0 * n[1]; r < z1 * n[1]; ++r) {
            if (!row)
                continue;
            sample_row(f, &frame, waves, r % n[1], r / n[1], row);
            add_grain(f, r * n[0], row);
            for (size_t x = 0; x < n[0]; ++x)
                store_sample(out, type, (r - z0 * n[1]) * n[0] + x, lo + fmin(fmax(row[x], 0), 1) * (hi - lo));
        }
        free(row);
    }
    return no_memory ? iso_fail(err, ISO_E_MEMORY, "no memory for a row of %zu samples", n[0]) : ISO_OK;
}

iso_status iso_field_sample(const iso_field *f, iso_type type, iso_volume *v, iso_error *err)
{
    iso_status status = iso_volume_create(v, &f->geometry, type, iso_field_name(f->kind), err);
    TRY(status, iso_field_sample_planes(f, type, 0, f->geometry.size[2], 0, v->data, err));
    if (status != ISO_OK)
        iso_volume_destroy(v);
    return status;
}
