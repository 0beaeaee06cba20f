/* SPDX-License-Identifier: MIT */
/* pyramids.c - pyramids and direction codes of the library's interface. */
#include <math.h>
#include <stdlib.h>

#include "library/shared.h"

iso_build_options iso_build_defaults(void)
{
    const iso_pyramid_options o = iso_pyramid_defaults();
    return (iso_build_options){.levels = o.level_count,
                               .code = iso_code_describe(o.code)->name,
                               .estimator = iso_gradient_name(o.gradient.method),
                               .scalar_filter = iso_scalar_filter_name(o.scalar_filter),
                               .direction_filter = iso_direction_filter_name(o.direction_filter)};
}

static iso_status take_build_options(const iso_build_options *given, iso_pyramid_options *o, iso_error *err)
{
    *o = iso_pyramid_defaults();
    o->level_count = given->levels;
    o->keep_float = given->keep_float;
    o->keep_magnitude = given->keep_magnitude;
    o->threads = given->threads;
    if (given->code)
        NEED(iso_code_from_name(given->code, &o->code, err));
    if (given->estimator)
        NEED(iso_gradient_from_name(given->estimator, &o->gradient.method, err));
    if (given->scalar_filter)
        NEED(iso_scalar_filter_from_name(given->scalar_filter, &o->scalar_filter, err));
    if (given->direction_filter)
        NEED(iso_direction_filter_from_name(given->direction_filter, &o->direction_filter, err));
    return ISO_OK;
}

iso_status iso_build(const iso_volume *volume, const iso_build_options *options, iso_pyramid **pyramid, iso_error *err)
{
    const iso_build_options given = options ? *options : iso_build_defaults();
    iso_pyramid_options o;
    *pyramid = NULL;
    NEED(take_build_options(&given, &o, err));
    iso_pyramid *p = calloc(1, sizeof *p);
    NEED_MEMORY(p, err, "out of memory");
    iso_call call;
    iso_call_begin(&call, given.progress, given.progress_user);
    iso_status status = iso_pyramid_build(volume, "memory", &o, p, &call.progress, err);
    status = iso_call_end(&call, status, err);
    if (status == ISO_OK)
        *pyramid = p;
    else
        free(p);
    return status;
}

iso_status iso_pyramid_open(const char *folder, iso_pyramid **pyramid, iso_error *err)
{
    *pyramid = calloc(1, sizeof **pyramid);
    NEED_MEMORY(*pyramid, err, "out of memory");
    iso_status status = iso_pyramid_load(folder, *pyramid, err);
    if (status != ISO_OK) {
        free(*pyramid);
        *pyramid = NULL;
    }
    return status;
}

size_t iso_pyramid_level_count(const iso_pyramid *pyramid)
{
    return pyramid->level_count;
}

iso_status iso_pyramid_level(const iso_pyramid *pyramid, size_t level, iso_level_view *view, iso_error *err)
{
    *view = (iso_level_view){0};
    NEED(iso_pyramid_check_level(pyramid, NULL, level, err));
    const iso_level *l = &pyramid->levels[level];
    *view = (iso_level_view){.grid = iso_grid_of_geometry(&l->geometry),
                             .min = l->min,
                             .max = l->max,
                             .values = l->scalar,
                             .code = iso_code_describe(pyramid->options.code)->name,
                             .codes = l->codes,
                             .directions = l->directions,
                             .magnitudes = l->magnitude};
    return ISO_OK;
}

/* Decodes vectors, and shortens those longer than 1. Here a length is the certainty of a direction; renderers only
 * divide by it. Codes are on a lattice, whose longest vectors exceed 1. NaN becomes the zero vector. */
static void decode_to_unit_ball(iso_code code, const uint8_t *bytes, float *directions, size_t count)
{
    iso_code_decode_all(code, bytes, directions, count);
    for (size_t i = 0; i < count; ++i) {
        float *d = directions + 3 * i;
        const double length = sqrt((double)d[0] * (double)d[0] + (double)d[1] * (double)d[1] +
                                   (double)d[2] * (double)d[2]);
        for (int a = 0; a < 3 && !(length <= 1); ++a)
            d[a] = isfinite(length) ? (float)((double)d[a] / length) : 0;
    }
}

iso_status iso_pyramid_directions(const iso_pyramid *pyramid, size_t level, float *directions, iso_error *err)
{
    NEED(iso_pyramid_check_level(pyramid, NULL, level, err));
    decode_to_unit_ball(pyramid->options.code, pyramid->levels[level].codes, directions,
                        iso_geometry_voxel_count(&pyramid->levels[level].geometry));
    return ISO_OK;
}

void iso_pyramid_free(iso_pyramid *pyramid)
{
    if (pyramid)
        iso_pyramid_destroy(pyramid);
    free(pyramid);
}

size_t iso_directions_bytes(const char *code)
{
    iso_code which;
    return iso_code_from_name(code, &which, NULL) == ISO_OK ? iso_code_describe(which)->bytes : 0;
}

/* True if d has length 1. A vector that was normalized in single precision is sometimes a little longer. */
static bool is_direction(const float *d)
{
    const double x = d[0], y = d[1], z = d[2];
    return x * x + y * y + z * z <= 1 + 1e-6; /* not true of NaN */
}

iso_status iso_directions_encode(const char *code, const float *directions, size_t count, uint8_t *bytes,
                                 iso_error *err)
{
    iso_code which;
    NEED(iso_code_from_name(code, &which, err));
    for (size_t i = 0; i < count; ++i) {
        const float *d = directions + 3 * i;
        if (!is_direction(d))
            return iso_fail(err, ISO_E_RANGE, "direction %zu is (%g, %g, %g), its length must be at most 1", i,
                            (double)d[0], (double)d[1], (double)d[2]);
    }
    iso_code_encode(which, directions, bytes, count);
    return ISO_OK;
}

iso_status iso_directions_decode(const char *code, const uint8_t *bytes, size_t count, float *directions,
                                 iso_error *err)
{
    iso_code which;
    NEED(iso_code_from_name(code, &which, err));
    decode_to_unit_ball(which, bytes, directions, count);
    return ISO_OK;
}
