/* SPDX-License-Identifier: MIT */
/* Extinction scales: how they are made, against formulas and against the definition written out in double precision. */
#include "rendered.h"
#include "test.h"

#include "fit/extinction_scale.h"
#include "fit/interpolation.h"
#include "render/sampler.h"
#include "tf/adapt.h"

/* ---- small volumes --------------------------------------------------------------------- */

typedef double value_at(size_t x, size_t y, size_t z);

static iso_pyramid pyramid_of(const size_t size[3], value_at *value, size_t levels)
{
    const iso_geometry g = iso_geometry_axis_aligned(size, (const double[]){1, 1, 1});
    iso_pyramid_options opt = iso_pyramid_defaults();
    OWNED(iso_volume) v;
    iso_pyramid p;
    opt.level_count = levels;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "test", &err));
    for (size_t z = 0, i = 0; z < size[2]; ++z)
        for (size_t y = 0; y < size[1]; ++y)
            for (size_t x = 0; x < size[0]; ++x, ++i)
                ((float *)v.data)[i] = (float)value(x, y, z);
    assert_ok(iso_pyramid_build(&v, "test", &opt, &p, NULL, &err));
    return p;
}

/* A white transfer function from 0 to 100 of these extinctions. */
static iso_tf_table table_of(const double *extinctions, size_t count)
{
    iso_tf_table t = {.count = count, .lo = 0, .hi = 100, .entries = calloc(4 * count, sizeof(float))};
    for (size_t i = 0; i < count; ++i) {
        t.entries[4 * i] = t.entries[4 * i + 1] = t.entries[4 * i + 2] = 1;
        t.entries[4 * i + 3] = (float)extinctions[i];
    }
    return t;
}

/* The mean extinction over values from `value` - width / 2 to `value` + width / 2: of lines between entries exactly. */
static double mean_extinction(const iso_tf_table *tf, double value, double width)
{
    const double entry = (tf->hi - tf->lo) / (double)(tf->count - 1), wide = fmax(width, entry / 64);
    double at = value - 0.5 * wide, end = at + wide, total = 0, a[4], b[4];
    while (at < end) {
        const double next = tf->lo + entry * (floor((at - tf->lo) / entry + 1e-9) + 1), to = fmin(next, end);
        iso_tf_lookup(tf, at, a);
        iso_tf_lookup(tf, to, b);
        total += 0.5 * (a[3] + b[3]) * (to - at);
        at = to;
    }
    return total / wide;
}

/* The length of the gradient in values a voxel: central differences, one-sided at the grid's faces. */
static double slope_at(const iso_level *l, size_t voxel)
{
    const size_t *n = l->geometry.size, step[3] = {1, n[0], n[0] * n[1]};
    const size_t at[3] = {voxel % n[0], voxel / n[0] % n[1], voxel / (n[0] * n[1])};
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        const size_t low = at[a] > 0, high = at[a] + 1 < n[a];
        if (low + high > 0)
            square += pow(((double)l->scalar[voxel + high * step[a]] - (double)l->scalar[voxel - low * step[a]]) /
                              (double)(low + high),
                          2);
    }
    return sqrt(square);
}

static iso_sampler sampler_of(iso_level *level, const iso_level *like, float *scalar)
{
    iso_sampler s;
    *level = *like;
    level->scalar = scalar;
    assert_ok(iso_sampler_create(&s, level, (iso_code){0}, ISO_FROM_ON_THE_FLY, &err));
    return s;
}

/* What the level shows at the fine voxels' centers: opacity over a fine voxel, of 1 mm. octaves: log2 q, or NULL. */
static double *shown_opacities(const iso_pyramid *p, size_t level, const iso_tf_table *tf, const double *octaves)
{
    const iso_geometry *fine = &p->levels[0].geometry;
    const iso_level *own = &p->levels[level];
    const size_t voxels = iso_geometry_voxel_count(&own->geometry), step = (size_t)1 << level;
    FREED float *scales = calloc(voxels, sizeof *scales), *slopes = malloc(voxels * sizeof *slopes);
    double *out = malloc(iso_geometry_voxel_count(fine) * sizeof *out);
    iso_level levels[3];
    for (size_t j = 0; j < voxels; ++j) {
        scales[j] = octaves ? (float)octaves[j] : 0;
        slopes[j] = (float)(slope_at(own, j) / (double)step);
    }
    OWNED(iso_sampler)
    value = sampler_of(&levels[0], own, own->scalar),
    scale = sampler_of(&levels[1], own, scales), slope = sampler_of(&levels[2], own, slopes);
    for (size_t i = 0; i < iso_geometry_voxel_count(fine); ++i) {
        const size_t x = i % fine->size[0], row = i / fine->size[0];
        const iso_vec3 at = {((double)x + 0.5) / (double)step, ((double)(row % fine->size[1]) + 0.5) / (double)step,
                             ((double)(row / fine->size[1]) + 0.5) / (double)step};
        const double sigma = mean_extinction(tf, iso_sample_scalar(&value, at), iso_sample_scalar(&slope, at));
        out[i] = -expm1(-sigma * exp2(iso_sample_scalar(&scale, at)));
    }
    return out;
}

static double *fine_opacities(const iso_pyramid *p, const iso_tf_table *tf)
{
    const iso_level *l = &p->levels[0];
    const size_t count = iso_geometry_voxel_count(&l->geometry);
    double *out = malloc(count * sizeof *out);
    for (size_t i = 0; i < count; ++i)
        out[i] = -expm1(-mean_extinction(tf, (double)l->scalar[i], slope_at(l, i)));
    return out;
}

static double *octaves_of(const uint8_t *bytes, size_t count)
{
    double *out = malloc(count * sizeof *out);
    for (size_t j = 0; j < count; ++j)
        out[j] = iso_extinction_scale_log2(bytes[j]);
    return out;
}

static double sum(const double *values, size_t count)
{
    double s = 0;
    for (size_t i = 0; i < count; ++i)
        s += values[i];
    return s;
}

static double rms(const double *a, const double *b, size_t count)
{
    double s = 0;
    for (size_t i = 0; i < count; ++i)
        s += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(s / (double)count);
}

/* ---- the byte -------------------------------------------------------------------------- */

TEST(bytes_are_powers_of_two)
{
    assert_true(iso_extinction_scale_of(ISO_EXTINCTION_SCALE_ONE) == 1);
    assert_within(iso_extinction_scale_of(0), 1.0 / 64, 1e-15);
    assert_within(iso_extinction_scale_of(ISO_EXTINCTION_SCALE_LAST), 8, 1e-14);
    assert_within(iso_extinction_scale_of(ISO_EXTINCTION_SCALE_ONE + ISO_EXTINCTION_SCALE_PER_OCTAVE), 2, 1e-15);
}

/* ---- closed forms ---------------------------------------------------------------------- */

static double checkered(size_t x, size_t y, size_t z)
{
    return (x + y + z) % 2 ? 100 : 0;
}

/* Half of the fine voxels have opacity 1/2, and the level shows 50 everywhere, with opacity 1/2 as well. Opacity 1/4
 * needs q = log(3/4) / log(1/2). Rounds approach it from 1 by a factor of six: 0.4 % remain after three, and half a
 * byte is 1.2 %. At the grid's faces differences are one-sided, and not 0: what they reach is left out. */
TEST(a_checkerboard_needs_one_number)
{
    OWNED(iso_pyramid) p = pyramid_of((const size_t[]){20, 16, 18}, checkered, 2);
    OWNED(iso_tf_table) tf = table_of((const double[]){0, log(2), log(2)}, 3);
    FREED uint8_t *bytes;
    assert_ok(iso_extinction_scale_level(&p, 1, &tf, &tf, 0, &bytes, &err));
    const double q = log(0.75) / log(0.5);
    for (size_t z = 3; z < 6; ++z)
        for (size_t y = 3; y < 5; ++y)
            for (size_t x = 3; x < 7; ++x)
                assert_within(iso_extinction_scale_of(bytes[x + 10 * (y + 8 * z)]), q, 0.016 * q);
}

static double half_filled(size_t x, size_t y, size_t z)
{
    (void)y, (void)z;
    return x < 7 ? 0 : 100; /* so the coarse voxel of x = 6 and 7 is half filled */
}

/* A surface inside a coarse voxel: the transfer function shows from 75 on, and the level has 50 in between. Its own
 * transfer function shows less of that than there is, or more: q makes it right. */
TEST(a_half_filled_voxel_becomes_as_opaque_as_its_half)
{
    OWNED(iso_pyramid) p = pyramid_of((const size_t[]){14, 8, 6}, half_filled, 2);
    OWNED(iso_tf_table)
    original = table_of((const double[]){0, 0, 0, 0.2, 0.2}, 5),
    own = table_of((const double[]){0, 0.1, 0.2, 0.2, 0.2}, 5);
    const iso_tf_table *tfs[] = {&original, &own}; /* the level's: too little of it shows, and too much */
    const size_t fine = iso_geometry_voxel_count(&p.levels[0].geometry),
                 coarse = iso_geometry_voxel_count(&p.levels[1].geometry);
    FREED double *want = fine_opacities(&p, &original);
    for (int t = 0; t < 2; ++t) {
        uint8_t *bytes;
        assert_ok(iso_extinction_scale_level(&p, 1, &original, tfs[t], 0, &bytes, &err));
        double *octaves = octaves_of(bytes, coarse), *before = shown_opacities(&p, 1, tfs[t], NULL),
               *after = shown_opacities(&p, 1, tfs[t], octaves);
        const double off = sum(before, fine) / sum(want, fine) - 1, now = sum(after, fine) / sum(want, fine) - 1;
        print_message("opacity of all fine voxels off by %.2f %%, with q by %.2f %%\n", 100 * off, 100 * now);
        assert_more_than(fabs(off), 0.02);
        assert_at_most(fabs(now), 0.15 * fabs(off));
        free(octaves), free(before), free(after), free(bytes);
    }
}

/* ---- the definition, written out ------------------------------------------------------- */

static iso_pyramid noise_pyramid(uint64_t seed, size_t levels)
{
    const iso_field field = {.kind = ISO_FIELD_NOISE,
                             .geometry = iso_geometry_axis_aligned((const size_t[]){21, 18, 13},
                                                                   (const double[]){1, 1, 1}),
                             .seed = seed};
    return build_field(&field, levels);
}

/* A ramp, a shell and a haze over the field's bytes. */
static iso_tf_table tf_of(int kind, const iso_level *level0)
{
    double extinctions[64];
    for (int i = 0; i < 64; ++i) {
        const double v = i / 63.0;
        extinctions[i] = kind == 0   ? 2 * fmin(fmax((v - 0.5) * 10, 0), 1)
                         : kind == 1 ? fmax(1 - 20 * fabs(v - 0.55), 0)
                                     : 0.1 * v;
    }
    iso_tf_table t = table_of(extinctions, 64);
    t.lo = level0->min, t.hi = level0->max;
    return t;
}

/* hat_j summed over all fine voxels with a value of each. */
static void scatter(const iso_interpolation *map, const double *values, double *sums)
{
    memset(sums, 0, map->coarse_count * sizeof *sums);
    for (size_t i = 0; i < map->fine_count; ++i) {
        const size_t n = map->axis[0].fine_size, row = i / n;
        const size_t at[3] = {i % n, row % map->axis[1].fine_size, row / map->axis[1].fine_size};
        for (int c = 0; c < 8; ++c) {
            size_t j = 0;
            double weight = 1;
            for (int a = 2; a >= 0; --a) {
                const iso_interpolation_axis *axis = &map->axis[a];
                const double high = (double)axis->weight[at[a]];
                weight *= c >> a & 1 ? high : 1 - high;
                j = j * axis->coarse_size + (c >> a & 1 ? axis->high[at[a]] : axis->low[at[a]]);
            }
            sums[j] += weight * values[i];
        }
    }
}

static double *three_rounds(const iso_pyramid *p, size_t level, const iso_tf_table *original, const iso_tf_table *own)
{
    OWNED(iso_interpolation) map;
    assert_ok(iso_interpolation_create(&map, p->levels[0].geometry.size, level, &err));
    const double little = 1e-3 * (double)((size_t)1 << (3 * level));
    double *octaves = calloc(map.coarse_count, sizeof *octaves), *want = fine_opacities(p, original);
    double *target = malloc(map.coarse_count * sizeof *target), *present = malloc(map.coarse_count * sizeof *present);
    scatter(&map, want, target);
    for (int round = 0; round < 3; ++round) {
        FREED double *have = shown_opacities(p, level, own, octaves);
        scatter(&map, have, present);
        for (size_t j = 0; j < map.coarse_count; ++j)
            octaves[j] = fmin(fmax(octaves[j] + log2((target[j] + little) / (present[j] + little)), -6), 3);
    }
    free(want), free(target), free(present);
    return octaves;
}

/* Floats against doubles, then rounded: at most a byte apart. And one byte is enough: half a step of log2 q changes
 * 1 - exp(-t) by at most ln 2 / 56 t exp(-t) <= 0.0046. No transfer function or level gets worse by its scale. */
TEST(bytes_are_the_definition_rounded)
{
    OWNED(iso_pyramid) p = noise_pyramid(5, 4);
    const size_t fine = iso_geometry_voxel_count(&p.levels[0].geometry);
    for (int kind = 0; kind < 3; ++kind)
        for (size_t level = 1; level < p.level_count; ++level) {
            const size_t coarse = iso_geometry_voxel_count(&p.levels[level].geometry);
            const iso_adapt_options opt = iso_adapt_defaults();
            OWNED(iso_tf_table) original = tf_of(kind, &p.levels[0]), own;
            uint8_t *bytes;
            assert_ok(iso_adapt_level(&p, level, &original, &opt, &own, NULL, &err));
            assert_ok(iso_extinction_scale_level(&p, level, &original, &own, 0, &bytes, &err));
            double *exact = three_rounds(&p, level, &original, &own), *rounded = octaves_of(bytes, coarse);
            double *want = fine_opacities(&p, &original), *plain = shown_opacities(&p, level, &own, NULL);
            double *by_doubles = shown_opacities(&p, level, &own, exact),
                   *by_bytes = shown_opacities(&p, level, &own, rounded);
            const double before = rms(plain, want, fine), after = rms(by_bytes, want, fine);
            print_message("kind %d level %zu: rms %.4f, scaled %.4f\n", kind, level, before, after);
            assert_at_most(after, before);
            if (after < before) /* else all bytes are 168 */
                for (size_t j = 0; j < coarse; ++j)
                    assert_within(rounded[j], exact[j], 0.55 / ISO_EXTINCTION_SCALE_PER_OCTAVE);
            for (size_t i = 0; after < before && i < fine; ++i)
                assert_within(by_bytes[i], by_doubles[i], 0.0051);
            free(exact), free(rounded), free(want), free(plain), free(by_doubles), free(by_bytes), free(bytes);
        }
}

/* ---- properties ------------------------------------------------------------------------ */

TEST(an_edit_on_a_kept_scaler_is_a_new_scale)
{
    OWNED(iso_pyramid) p = noise_pyramid(8, 3);
    for (size_t level = 1; level < 3; ++level) {
        const size_t coarse = iso_geometry_voxel_count(&p.levels[level].geometry);
        uint8_t *first = malloc(coarse), *fresh;
        iso_extinction_scaler *s;
        assert_ok(iso_extinction_scaler_create(&p.levels[0], &p.levels[level], level, 0, &s, &err));
        for (int kind = 0; kind < 3; ++kind) {
            OWNED(iso_tf_table) tf = tf_of(kind, &p.levels[0]);
            iso_extinction_scale_cost cost;
            assert_ok(iso_extinction_scaler_apply(s, &tf, &tf, first, &cost, &err));
            assert_at_most(cost.error, cost.error_one);
            assert_ok(iso_extinction_scale_level(&p, level, &tf, &tf, 0, &fresh, &err));
            assert_memory_equal(first, fresh, coarse);
            free(fresh);
        }
        iso_extinction_scaler_destroy(s);
        free(first);
    }
}

TEST(threads_do_not_matter)
{
    OWNED(iso_pyramid) p = noise_pyramid(6, 3);
    OWNED(iso_tf_table) tf = tf_of(0, &p.levels[0]);
    const size_t coarse = iso_geometry_voxel_count(&p.levels[1].geometry);
    uint8_t *one, *many;
    assert_ok(iso_extinction_scale_level(&p, 1, &tf, &tf, 1, &one, &err));
    for (int threads = 2; threads < 8; threads += 3) {
        assert_ok(iso_extinction_scale_level(&p, 1, &tf, &tf, threads, &many, &err));
        assert_memory_equal(one, many, coarse);
        free(many);
    }
    free(one);
}

static double plane(size_t x, size_t y, size_t z)
{
    return (double)(x + y + z);
}

/* Nothing is seen, or the level shows what the fine voxels do: then nothing is scaled. */
TEST(what_is_right_is_left_alone)
{
    OWNED(iso_pyramid) p = pyramid_of((const size_t[]){16, 16, 16}, plane, 2);
    OWNED(iso_tf_table) nothing = table_of((const double[]){0, 0}, 2), haze = table_of((const double[]){0.1, 0.1}, 2);
    const iso_tf_table *tfs[] = {&nothing, &haze};
    for (int t = 0; t < 2; ++t) {
        FREED uint8_t *bytes;
        assert_ok(iso_extinction_scale_level(&p, 1, tfs[t], tfs[t], 0, &bytes, &err));
        for (size_t j = 0; j < 8 * 8 * 8; ++j)
            assert_int_equal(bytes[j], ISO_EXTINCTION_SCALE_ONE);
    }
    uint8_t *none;
    assert_ok(iso_extinction_scale_level(&p, 0, &haze, &haze, 0, &none, &err));
    assert_null(none); /* level 0 needs none */
}

TEST(levels_that_do_not_fit_are_refused)
{
    OWNED(iso_pyramid) p = noise_pyramid(7, 3);
    iso_extinction_scaler *s;
    iso_level outline = p.levels[1];
    outline.scalar = NULL;
    assert_status(iso_extinction_scaler_create(&p.levels[0], &p.levels[1], 2, 0, &s, &err), ISO_E_RANGE);
    assert_null(s);
    assert_status(iso_extinction_scaler_create(&p.levels[0], &outline, 1, 0, &s, &err), ISO_E_RANGE);
    iso_extinction_scaler_destroy(NULL);
}

TEST_MAIN(NULL, end_renderers)
