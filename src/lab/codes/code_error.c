/* SPDX-License-Identifier: MIT */
#include "lab/codes/code_error.h"

#include <math.h>
#include <stdlib.h>

#include "base/random.h"

static const double degree = 0.017453292519943295;

typedef struct probe {
    iso_vec3 a, b; /* not normalized */
    double t;
    double error_deg;
} probe;

double iso_angle_deg(iso_vec3 a, iso_vec3 b)
{
    return atan2(iso_norm(iso_cross(a, b)), iso_dot(a, b)) / degree;
}

void iso_scheme_encode(const iso_scheme *scheme, const float *restrict directions, uint8_t *restrict bytes,
                       size_t count)
{
    if (scheme->table)
        iso_paper_encode(scheme->table, directions, bytes, count);
    else if (scheme->encode)
        scheme->encode(directions, bytes, count);
    else
        iso_code_encode(scheme->code, directions, bytes, count);
}

iso_code_error_options iso_code_error_defaults(void)
{
    return (iso_code_error_options){.count = 100000, .min_length = 1, .climb = true, .seed = 20170613};
}

iso_vec3 iso_random_unit_vector(uint64_t *state)
{
    double z = 2 * iso_xorshift_unit(state) - 1, phi = 6.283185307179586 * iso_xorshift_unit(state),
           r = sqrt(1 - z * z);
    return iso_v3(r * cos(phi), r * sin(phi), z);
}

/* Returns the unit vector `apart` radians from a towards `somewhere`. */
static iso_vec3 turn_towards(iso_vec3 a, iso_vec3 somewhere, double apart)
{
    iso_vec3 across = iso_normalize(iso_madd(somewhere, a, -iso_dot(a, somewhere)));
    return iso_madd(iso_scale(a, cos(apart)), across, sin(apart));
}

static probe random_probe(const iso_code_error_options *opt, uint64_t *state)
{
    probe p = {.a = iso_random_unit_vector(state)};
    double spread = 1 - opt->min_length;
    p.b = p.a;
    if (opt->apart_deg > 0) {
        p.b = turn_towards(p.a, iso_random_unit_vector(state), opt->apart_deg * degree);
        p.t = iso_xorshift_unit(state);
        p.b = iso_scale(p.b, opt->min_length + spread * iso_xorshift_unit(state));
    }
    p.a = iso_scale(p.a, opt->min_length + spread * iso_xorshift_unit(state));
    return p;
}

/* Returns a random probe near p: it moves by about `reach`; angle and lengths are kept. */
static probe moved(const probe *p, const iso_code_error_options *opt, double reach, uint64_t *state)
{
    probe q = *p;
    double length_a = iso_norm(p->a), length_b = iso_norm(p->b);
    iso_vec3 a = iso_scale(p->a, 1 / length_a), b = iso_scale(p->b, 1 / length_b);
    a = iso_normalize(iso_madd(a, iso_random_unit_vector(state), reach * iso_xorshift_unit(state)));
    q.a = q.b = iso_scale(a, length_a);
    if (opt->apart_deg > 0) {
        b = iso_madd(b, iso_random_unit_vector(state), reach * iso_xorshift_unit(state));
        q.b = iso_scale(turn_towards(a, b, opt->apart_deg * degree), length_b);
        q.t = fmin(fmax(p->t + reach * (2 * iso_xorshift_unit(state) - 1), 0), 1);
    }
    return q;
}

/* Measures the error of each probe. floats: 6 per probe; bytes: 2 codes per probe. */
static void judge(const iso_scheme *scheme, probe *probes, size_t count, float *floats, uint8_t *bytes)
{
    const size_t size = iso_code_describe(scheme->code)->bytes;
    for (size_t i = 0; i < count; ++i) {
        const double values[6] = {probes[i].a.x, probes[i].a.y, probes[i].a.z,
                                  probes[i].b.x, probes[i].b.y, probes[i].b.z};
        for (int c = 0; c < 6; ++c)
            floats[6 * i + (size_t)c] = (float)values[c];
    }
    iso_scheme_encode(scheme, floats, bytes, 2 * count);
    for (size_t i = 0; i < count; ++i) {
        probe *p = &probes[i];
        double ea[3], eb[3], d[3];
        iso_code_lattice(scheme->code, bytes + size * 2 * i, ea);
        iso_code_lattice(scheme->code, bytes + size * (2 * i + 1), eb);
        for (int c = 0; c < 3; ++c)
            ea[c] += p->t * (eb[c] - ea[c]);
        iso_code_decode(scheme->code, ea, d);
        iso_vec3 exact = iso_madd(iso_scale(p->a, 1 - p->t), p->b, p->t);
        p->error_deg = iso_angle_deg(iso_v3(d[0], d[1], d[2]), exact);
    }
}

enum { BATCH = 512, CLIMBERS = 16, STEPS = 60 };

typedef struct workspace {
    probe probes[BATCH];
    probe worst[CLIMBERS];
    float floats[6 * BATCH];
    uint8_t bytes[12 * BATCH];
} workspace;

static void keep_if_worst(workspace *w, const probe *p)
{
    int least = 0;
    for (int i = 1; i < CLIMBERS; ++i)
        if (w->worst[i].error_deg < w->worst[least].error_deg)
            least = i;
    if (p->error_deg > w->worst[least].error_deg)
        w->worst[least] = *p;
}

/* Moves each of the worst probes to the worst of its neighbors, within a shrinking reach. */
static void climb(const iso_scheme *scheme, const iso_code_error_options *opt, workspace *w, uint64_t *state)
{
    enum { NEIGHBORS = BATCH / CLIMBERS };
    double reach = 0.02;
    for (int step = 0; step < STEPS && (size_t)step < opt->count / CLIMBERS / 2; ++step, reach *= 0.85) {
        for (int i = 0; i < BATCH; ++i)
            w->probes[i] = moved(&w->worst[i / NEIGHBORS], opt, reach, state);
        judge(scheme, w->probes, BATCH, w->floats, w->bytes);
        for (int i = 0; i < BATCH; ++i)
            if (w->probes[i].error_deg > w->worst[i / NEIGHBORS].error_deg)
                w->worst[i / NEIGHBORS] = w->probes[i];
    }
}

iso_status iso_code_error_measure(const iso_scheme *scheme, const iso_code_error_options *opt, iso_code_error *error,
                                  iso_error *err)
{
    if (opt->count < CLIMBERS || !(opt->apart_deg >= 0 && opt->apart_deg < 180) ||
        !(opt->min_length > 0 && opt->min_length <= 1))
        return iso_fail(
            err, ISO_E_RANGE,
            "code error: %zu probes, at least %d; %g degrees apart, 0 to 180; lengths from %g, above 0 and at most 1",
            opt->count, CLIMBERS, opt->apart_deg, opt->min_length);
    workspace *w = calloc(1, sizeof *w);
    NEED_MEMORY(w, err, "code error: no memory");
    uint64_t state = opt->seed;
    *error = (iso_code_error){0, 0};
    for (size_t done = 0; done < opt->count; done += BATCH) {
        size_t n = opt->count - done < BATCH ? opt->count - done : BATCH;
        for (size_t i = 0; i < n; ++i)
            w->probes[i] = random_probe(opt, &state);
        judge(scheme, w->probes, n, w->floats, w->bytes);
        for (size_t i = 0; i < n; ++i) {
            error->mean_deg += w->probes[i].error_deg / (double)opt->count;
            keep_if_worst(w, &w->probes[i]);
        }
    }
    if (opt->climb)
        climb(scheme, opt, w, &state);
    for (int i = 0; i < CLIMBERS; ++i)
        error->max_deg = fmax(error->max_deg, w->worst[i].error_deg);
    free(w);
    return ISO_OK;
}
