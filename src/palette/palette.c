/* SPDX-License-Identifier: MIT */
#include "palette/palette.h"

#include <math.h>
#include <stdlib.h>

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
    NEED(iso_names_find(&iso_palette_method_names, name, &row, err));
    *method = (iso_palette_method)row;
    return ISO_OK;
}

iso_palette_options iso_palette_defaults(void)
{
    return (iso_palette_options){
        .method = ISO_PALETTE_KMEANS,
        .directions = 254,
        .seed = 1,
        .swap_trials = 16,
    };
}

iso_status iso_palette_create(iso_palette *palette, size_t direction_count, iso_error *err)
{
    *palette = (iso_palette){0};
    if (direction_count > ISO_PALETTE_MAX)
        return iso_fail(err, ISO_E_RANGE, "palette: %zu directions, at most %d", direction_count, ISO_PALETTE_MAX);
    palette->xyz = calloc(3 * (direction_count + 1), sizeof *palette->xyz);
    NEED_MEMORY(palette->xyz, err, "palette: no memory for %zu entries", direction_count + 1);
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

void iso_palette_put(iso_palette *palette, size_t entry, iso_vec3 direction)
{
    const iso_vec3 n = iso_normalize(direction);
    palette->xyz[3 * entry] = (float)n.x;
    palette->xyz[3 * entry + 1] = (float)n.y;
    palette->xyz[3 * entry + 2] = (float)n.z;
}

iso_status iso_palette_measure(const iso_direction_set *set, const iso_palette *palette, iso_palette_error *error,
                               iso_error *err)
{
    *error = (iso_palette_error){0};
    iso_palette_lookup *lookup;
    NEED(iso_palette_lookup_create(palette, &lookup, err));
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
