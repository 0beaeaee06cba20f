/* SPDX-License-Identifier: MIT */
/* encode_coherence.c - filtering errors of the best fit, by the weight of the length; and of directions whose length is
 * their reliability, by storage format. */
#include <math.h>
#include <stdio.h>

#include "base/json.h"
#include "base/random.h"
#include "lab/encode.h"
#include "lab/codes/code_error.h"
#include "encode/encode_kernel.h"
#include "lab/codes/encode_exact.h"

static const double apart_deg[] = {15, 60};
enum { APART_COUNT = sizeof apart_deg / sizeof apart_deg[0] };
static const double shortest = 0.1;

static void put(const char *name, int bytes, const iso_code_error e[], bool text, json_t *list)
{
    json_t *rows = json_array();
    for (int i = 0; i < APART_COUNT; ++i)
        json_array_append_new(rows, json_pack("{s:f, s:f, s:f}", "apart_deg", apart_deg[i], "filtered_mean_error_deg",
                                              e[i].mean_deg, "filtered_max_error_deg", e[i].max_deg));
    json_array_append_new(list, json_pack("{s:s, s:i, s:o}", "method", name, "bytes", bytes, "filtered", rows));
    if (!text)
        return;
    printf("  %-40s %d ", name, bytes);
    for (int i = 0; i < APART_COUNT; ++i)
        printf("  %8.3f %8.2f", e[i].mean_deg, e[i].max_deg);
    putchar('\n');
}

/* Encodes the direction by `fit` at full length, and the length in a separate byte. */
static iso_vec3 fitted(iso_vec3 d)
{
    float in[3] = {(float)d.x, (float)d.y, (float)d.z};
    uint8_t bytes[3];
    double e[3];
    iso_encode_fit(in, bytes, 1);
    iso_code_lattice(ISO_CODE_FIT, bytes, e);
    return iso_v3(e[0], e[1], e[2]);
}

/* Measures directions with a separate length. at_voxels: multiplies them at each voxel before filtering (one fetch per
 * voxel). Otherwise both are filtered separately, as one hardware fetch does. */
static iso_code_error separate_length(double apart, size_t count, bool at_voxels)
{
    uint64_t state = 20170613;
    iso_code_error error = {0, 0};
    for (size_t i = 0; i < count; ++i) {
        iso_vec3 a = iso_random_unit_vector(&state), across = iso_random_unit_vector(&state);
        across = iso_normalize(iso_madd(across, a, -iso_dot(across, a)));
        iso_vec3 b = iso_madd(iso_scale(a, cos(apart)), across, sin(apart));
        double t = iso_xorshift_unit(&state), la = shortest + (1 - shortest) * iso_xorshift_unit(&state),
               lb = shortest + (1 - shortest) * iso_xorshift_unit(&state);
        double wa = (1 - t) * (at_voxels ? rint(255 * la) : 1), wb = t * (at_voxels ? rint(255 * lb) : 1);
        iso_vec3 mixed = iso_madd(iso_scale(fitted(a), wa), fitted(b), wb);
        double off = iso_angle_deg(mixed, iso_madd(iso_scale(a, (1 - t) * la), b, t * lb));
        error.mean_deg += off / (double)count;
        error.max_deg = fmax(error.max_deg, off);
    }
    return error;
}

iso_status iso_lab_encode_coherence(bool text, size_t count, json_t *root, iso_error *err)
{
    static const struct {
        const char *name;
        iso_scheme scheme;
    } methods[] = {
        {"snorm of d L^2", {"snorm", ISO_CODE_SNORM, NULL, NULL}},
        {"fit aiming at |e| = L^2", {"fit", ISO_CODE_FIT, NULL, NULL}},
        {"half floats of d L^2", {"half", ISO_CODE_HALF, NULL, NULL}},
    };
    json_t *list = json_array();
    json_object_set_new(root, "coherence", list);
    if (text)
        printf("Coherence as length: lengths 0.1 to 1, error of the filtered direction, mean and largest seen\n"
               "  %-40s %s  %8.0f degrees apart %7.0f apart\n",
               "", "B", apart_deg[0], apart_deg[1]);
    iso_code_error_options opt = iso_code_error_defaults();
    opt.count = count;
    opt.min_length = shortest;
    opt.climb = false;
    iso_code_error e[APART_COUNT];
    for (size_t m = 0; m < sizeof methods / sizeof methods[0]; ++m) {
        for (int i = 0; i < APART_COUNT; ++i) {
            opt.apart_deg = apart_deg[i];
            NEED(iso_code_error_measure(&methods[m].scheme, &opt, &e[i], err));
        }
        put(methods[m].name, (int)iso_code_describe(methods[m].scheme.code)->bytes, e, text, list);
    }
    for (int at_voxels = 0; at_voxels < 2; ++at_voxels) {
        for (int i = 0; i < APART_COUNT; ++i)
            e[i] = separate_length(apart_deg[i] * 0.017453292519943295, count, at_voxels);
        put(at_voxels ? "fit of d, byte of L^2, mixed by 8 fetches" : "fit of d, byte of L^2, filtered apart", 4, e,
            text, list);
    }
    return ISO_OK;
}

/* ---- how stiff the length is ---- */

#define STIFFNESS_LIST(X) X(5) X(7) X(8) X(10) X(12) X(15) X(20) X(30) X(100)
/* clang-format off */
#define STIFFNESS_FUNCTION(percent)                                                                                      \
    static void fit_##percent(const float *restrict directions, uint8_t *restrict bytes, size_t count)                   \
    {                                                                                                                    \
        iso_encode_fit_with_mu(percent / 100.0, directions, bytes, count);                                               \
    }
/* clang-format on */
STIFFNESS_LIST(STIFFNESS_FUNCTION)

iso_status iso_lab_encode_stiffness(bool text, size_t count, json_t *root, iso_error *err)
{
#define STIFFNESS_ROW(percent) {percent / 100.0, {"fit", ISO_CODE_FIT, fit_##percent, NULL}},
    static const struct {
        double mu;
        iso_scheme scheme;
    } rows[] = {STIFFNESS_LIST(STIFFNESS_ROW)};
    json_t *list = json_array();
    json_object_set_new(root, "stiffness", list);
    if (text)
        printf("Best fit by mu, the weight of the length's error: mean error, degrees\n"
               "     mu  at voxels  15 apart  60 apart\n");
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        static const double apart[] = {0, 15, 60};
        iso_code_error_options opt = iso_code_error_defaults();
        iso_code_error e[3];
        opt.count = count;
        opt.climb = false;
        for (int a = 0; a < 3; ++a) {
            opt.apart_deg = apart[a];
            NEED(iso_code_error_measure(&rows[i].scheme, &opt, &e[a], err));
        }
        json_array_append_new(list, json_pack("{s:f, s:f, s:f, s:f}", "mu", rows[i].mu, "mean_error_deg", e[0].mean_deg,
                                              "filtered_15_mean_error_deg", e[1].mean_deg, "filtered_60_mean_error_deg",
                                              e[2].mean_deg));
        if (text)
            printf("  %5.2f  %9.4f  %8.4f  %8.4f\n", rows[i].mu, e[0].mean_deg, e[1].mean_deg, e[2].mean_deg);
    }
    return ISO_OK;
}
