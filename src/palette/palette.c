/* SPDX-License-Identifier: MIT */
#include "palette/palette.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "palette/palette_fit.h"
#include "palette/palette_regular.h"

static const struct {
    const char *name, *summary;
} methods[] = {
#define METHOD_ROW(name, text, help) {text, help},
    ISO_PALETTE_METHOD_LIST(METHOD_ROW)
#undef METHOD_ROW
};
const iso_names iso_palette_method_names = ISO_NAMES_OF_ROWS("palette method", methods);

const char *iso_palette_method_name(iso_palette_method method)
{
    return methods[method].name;
}

iso_status iso_palette_method_from_name(const char *name, iso_palette_method *method, iso_error *err)
{
    size_t row = 0;
    const iso_status status = iso_names_find(&iso_palette_method_names, name, &row, err);
    if (status == ISO_OK)
        *method = (iso_palette_method)row;
    return status;
}

iso_palette_options iso_palette_defaults(void)
{
    return (iso_palette_options){
        .method = ISO_PALETTE_KMEANS,
        .directions = 254,
        .seed = 1,
        .swap_trials = 16,
        .anneal = {.start_prob = 0.2, .temp_fac = 0.92, .cycles = 100, .steps = 10000, .move_deg = {10, 15}},
    };
}

iso_status iso_palette_create(iso_palette *palette, size_t direction_count, iso_error *err)
{
    *palette = (iso_palette){0};
    if (direction_count > ISO_PALETTE_MAX)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu directions, at most %d", direction_count, ISO_PALETTE_MAX);
    palette->xyz = calloc(3 * (direction_count + 1), sizeof *palette->xyz);
    if (!palette->xyz)
        return iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu entries", direction_count + 1);
    palette->count = direction_count + 1;
    return ISO_OK;
}

void iso_palette_destroy(iso_palette *palette)
{
    if (!palette)
        return;
    free(palette->xyz);
    *palette = (iso_palette){0};
}

int iso_palette_bits(const iso_palette *palette)
{
    int bits = 1;
    while ((size_t)1 << bits < palette->count)
        ++bits;
    return bits;
}

iso_status iso_palette_check(const iso_palette_options *opt, iso_error *err)
{
    const iso_anneal_options *a = &opt->anneal;
    if (opt->directions < 1 || opt->directions > ISO_PALETTE_MAX)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu directions, must be 1 to %d", opt->directions, ISO_PALETTE_MAX);
    if (opt->method == ISO_PALETTE_FACES && opt->directions < 60)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu directions, regular faces need at least 60", opt->directions);
    if (opt->method == ISO_PALETTE_VERTICES && opt->directions < 32)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu directions, regular vertices need at least 32",
                        opt->directions);
    if (opt->method == ISO_PALETTE_GRID && opt->directions < 2)
        return iso_fail(err, ISO_E_RANGE, "palette: 1 direction, the grid needs at least 2");
    if (opt->method != ISO_PALETTE_ANNEAL)
        return ISO_OK;
    if (opt->directions < 8 || opt->directions % 2)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu directions, a tessellation needs an even number, at least 8",
                        opt->directions);
    if (!(a->start_prob > 0 && a->start_prob < 1))
        return iso_fail(err, ISO_E_RANGE, "palette: start probability %g, must be between 0 and 1", a->start_prob);
    if (!(a->temp_fac > 0 && a->temp_fac <= 1))
        return iso_fail(err, ISO_E_RANGE, "palette: temperature factor %g, must be above 0 and at most 1", a->temp_fac);
    if (!(a->move_deg[0] > 0 && a->move_deg[0] <= a->move_deg[1] && a->move_deg[1] <= 90))
        return iso_fail(err, ISO_E_RANGE, "palette: moves by %g to %g degrees, must be above 0, ascending, at most 90",
                        a->move_deg[0], a->move_deg[1]);
    return ISO_OK;
}

static iso_status fixed_table(const iso_palette_options *opt, iso_palette *palette, iso_error *err)
{
    size_t count = opt->directions;
    bool faces = opt->method == ISO_PALETTE_FACES;
    int level = 0;
    if (faces || opt->method == ISO_PALETTE_VERTICES) {
        size_t (*size)(int) = faces ? iso_subdivision_faces : iso_subdivision_vertices;
        while (size(level + 1) <= opt->directions)
            ++level;
        count = size(level);
    } else if (opt->method == ISO_PALETTE_GRID) {
        count = iso_palette_grid(opt->directions, NULL);
    }
    iso_status status = iso_palette_create(palette, count, err);
    if (status != ISO_OK)
        return status;
    float *xyz = palette->xyz + 3;
    if (opt->method == ISO_PALETTE_GRID)
        iso_palette_grid(opt->directions, xyz);
    else if (opt->method == ISO_PALETTE_SPIRAL)
        iso_palette_spiral(count, xyz);
    else if (opt->method == ISO_PALETTE_FIBONACCI)
        iso_palette_fibonacci(count, xyz);
    else
        status = iso_palette_subdivide(level, faces, xyz, err);
    if (status != ISO_OK)
        iso_palette_destroy(palette);
    return status;
}

iso_status iso_palette_fit(const iso_direction_set *set, const iso_palette_options *opt, iso_palette *palette,
                           const iso_progress *progress, iso_error *err)
{
    *palette = (iso_palette){0};
    iso_status status = iso_palette_check(opt, err);
    if (status != ISO_OK)
        return status;
    switch (opt->method) {
    case ISO_PALETTE_KMEANS:
    case ISO_PALETTE_KMEANSPP:
    case ISO_PALETTE_LLOYD:
    case ISO_PALETTE_LBG: return iso_palette_fit_kmeans(set, opt, palette, progress, err);
    case ISO_PALETTE_ANNEAL: return iso_palette_anneal(set, opt, palette, NULL, progress, err);
    default: return fixed_table(opt, palette, err);
    }
}

iso_status iso_palette_measure(const iso_direction_set *set, const iso_palette *palette, iso_palette_error *error,
                               iso_error *err)
{
    *error = (iso_palette_error){0};
    iso_palette_lookup *lookup;
    iso_status status = iso_palette_lookup_create(palette, &lookup, err);
    if (status != ISO_OK)
        return status;
    double total = 0, far2 = 0;
    for (size_t i = 0; i < set->count; ++i) {
        const float *u = set->xyz + 3 * i;
        uint16_t index;
        iso_palette_assign(lookup, u, &index, 1);
        const float *n = palette->xyz + 3 * (size_t)index;
        double x = (double)u[0] - (double)n[0], y = (double)u[1] - (double)n[1], z = (double)u[2] - (double)n[2];
        /* 1 - cos = |u - n|^2 / 2 (the paper's Eq. 1) keeps its digits; 1 - u.n loses them. */
        double chord2 = x * x + y * y + z * z;
        error->norm1 += set->weight[i] * (1 - (double)set->length[i] + 0.5 * (double)set->length[i] * chord2);
        total += set->weight[i];
        far2 = fmax(far2, chord2);
    }
    iso_palette_lookup_destroy(lookup);
    const double degrees = 180 / acos(-1);
    error->norm2 = sqrt(2 * error->norm1);
    error->norm2_printed = sqrt(0.5 * error->norm1);
    error->max_deg = 2 * asin(fmin(1, 0.5 * sqrt(far2))) * degrees;
    error->rms_deg = total > 0 ? 2 * asin(fmin(1, sqrt(0.5 * error->norm1 / total))) * degrees : 0;
    return ISO_OK;
}

void iso_palette_shade(const iso_palette *palette, const iso_palette_shading *s, float *restrict shade)
{
    for (size_t i = 0; i < palette->count; ++i) {
        const float *n = palette->xyz + 3 * i;
        double value = s->ambient;
        for (size_t k = 0; i > 0 && k < s->light_count; ++k) {
            double nl = 0, nh = 0, hh = 0;
            for (int c = 0; c < 3; ++c) {
                double h = s->lights[k].toward[c] + s->toward_viewer[c];
                nl += (double)n[c] * s->lights[k].toward[c];
                nh += (double)n[c] * h;
                hh += h * h;
            }
            double highlight = hh > 0 ? pow(fabs(nh) / sqrt(hh), s->power) : 0;
            value += s->lights[k].intensity * (s->diffuse * fabs(nl) + s->specular * highlight);
        }
        shade[i] = (float)value;
    }
}
