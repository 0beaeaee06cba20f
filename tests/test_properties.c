/* SPDX-License-Identifier: MIT */
/* What holds for any geometry, transfer function, direction and pyramid (property.h). */
#include "folder.h"
#include "property.h"

#include <math.h>

#include "encode/code.h"
#include "pyramid/pyramid.h"
#include "tf/tf.h"
#include "volume/geometry.h"

static const char *because(const char *format, double a, double b)
{
    static char text[200];
    snprintf(text, sizeof text, format, a, b);
    return text;
}

/* ---- geometry ---- */

/* Nine numbers of a matrix, three of the corner, three sizes from 1. */
static iso_geometry geometry_of(const unsigned *n)
{
    const size_t size[3] = {1 + n[12], 1 + n[13], 1 + n[14]};
    iso_geometry g = iso_geometry_axis_aligned(size, (double[]){1, 1, 1});
    for (int i = 0; i < 9; ++i) /* 0 is the unit matrix; signs and lengths from 1e-3 to 1e3 follow */
        g.index_to_world.m[i / 3][i % 3] += ((int)(n[i] % 2) ? -1 : 1) * (double)n[i] * n[i] / 1000;
    g.origin_mm = iso_v3(n[9] * 0.37, -(double)n[10], n[11] * 100.0);
    return g;
}

static bool is_flat(const iso_geometry *g)
{
    double longest = 0;
    for (int c = 0; c < 3; ++c)
        longest = fmax(longest, iso_norm(iso_column(g->index_to_world, c)));
    return !(fabs(iso_mat3_det(g->index_to_world)) > 1e-6 * longest * longest * longest);
}

static const char *geometry_fails(const unsigned *n)
{
    const iso_geometry g = geometry_of(n);
    iso_error err = {""};
    const iso_status status = iso_geometry_check(&g, "g", &err);
    if (is_flat(&g))
        return status == ISO_OK || err.text[0] ? NULL : "it is refused without a word";
    if (status != ISO_OK)
        return err.text[0] ? "it is refused" : "it is refused without a word";
    const iso_vec3 index = iso_v3(0.25 * (double)n[12], -3.5, (double)n[14] + 0.125),
                   back = iso_geometry_to_index(&g, iso_geometry_to_world(&g, index));
    /* Rounding of 16 digits, times the condition of a matrix that is not flat: 1e6 by is_flat(), and the corner's
     * distance. */
    const double off = iso_norm(iso_sub(index, back));
    if (!(off <= 1e-6 * (1 + iso_norm(index))))
        return because("a place comes back %g from where it was", off, 0);
    const iso_geometry coarse = iso_geometry_coarser(&g);
    for (int a = 0; a < 3; ++a)
        if (coarse.size[a] != (g.size[a] + 1) / 2)
            return because("%g samples become %g", (double)g.size[a], (double)coarse.size[a]);
    const iso_vec3 a = iso_geometry_box_center_mm(&g), b = iso_geometry_box_center_mm(&coarse);
    const double moved = iso_norm(iso_sub(a, b)), radius = iso_geometry_box_radius_mm(&g);
    if (!(moved <= 1e-9 * (radius + iso_norm(a))))
        return because("the box's center moves by %g of %g", moved, radius);
    return NULL;
}

TEST(any_affine_geometry_maps_there_and_back)
{
    static const iso_property p = {
        "geometry", 15, {[0] = 1000, [9] = 100, [12] = 40}, .cases = 20000, .fails = geometry_fails};
    assert_property(&p);
}

/* ---- transfer functions ---- */

enum { POINTS = 6 };
static const char *tf_fails(const unsigned *n)
{
    iso_tf_point points[POINTS];
    const size_t count = 2 + n[0] % (POINTS - 1);
    bool rising = true;
    double most = 0;
    for (size_t i = 0; i < count; ++i) {
        points[i] = (iso_tf_point){.value = (double)n[1 + i] / 4, .opacity = (double)n[8 + i] / 1000};
        points[i].rgb_linear[0] = (double)n[16 + i] / 1000;
        rising = rising && (i == 0 || points[i].value > points[i - 1].value);
        most = fmax(most, points[i].rgb_linear[0]);
    }
    iso_tf *tf = NULL;
    iso_error err = {""};
    const iso_status status = iso_tf_from_points(points, count, 2, &tf, &err);
    if (status != ISO_OK)
        return rising ? "rising points are refused" : err.text[0] ? NULL : "it is refused without a word";
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){4, 4, 4}, (double[]){1, 1, 1});
    iso_tf_table table;
    const char *why = NULL;
    if (iso_tf_tabulate(tf, -1, 1, &g, &table, &err) == ISO_OK) {
        for (double v = -5; v < 300 && !why; v += 0.37) {
            double rgbs[4];
            iso_tf_lookup(&table, v, rgbs);
            if (!(rgbs[0] >= 0 && rgbs[0] <= most * (1 + 1e-6) && rgbs[3] >= 0 && isfinite(rgbs[3]))) /* float */
                why = because("at %g it shows %g", v, rgbs[0]);
        }
        iso_tf_table_destroy(&table);
    }
    iso_tf_free(tf);
    return why;
}

TEST(points_in_any_order_are_refused_or_stay_within_their_colors)
{
    static const iso_property p = {
        "transfer function", 22, {[0] = 10, [1] = 1000, [8] = 1000, [16] = 1000}, .cases = 400, .fails = tf_fails};
    assert_property(&p);
}

/* ---- pyramids ---- */

static const char *check_pyramid(const iso_pyramid *p, const iso_volume *v, iso_pyramid *loaded)
{
    FREED char *path = iso_path_join(folder, "p.iso");
    iso_error err = {""};
    const char *why = iso_pyramid_save(p, path, &err) != ISO_OK        ? "it cannot be saved"
                      : iso_pyramid_load(path, loaded, &err) != ISO_OK ? "it cannot be loaded"
                                                                       : NULL;
    for (size_t k = 0; k < p->level_count && !why; ++k) {
        const iso_level *a = &p->levels[k], *b = &loaded->levels[k];
        const size_t count = iso_geometry_voxel_count(&a->geometry);
        for (int x = 0; x < 3 && !why; ++x)
            if (k > 0 && a->geometry.size[x] != (p->levels[k - 1].geometry.size[x] + 1) / 2)
                why = "a level has not half the samples";
        if (!why && (count != iso_geometry_voxel_count(&b->geometry) || memcmp(a->codes, b->codes, 3 * count) != 0 ||
                     memcmp(a->scalar, b->scalar, count * sizeof(float)) != 0))
            why = "it is not loaded as it was saved";
        for (size_t i = 0; i < count && !why; ++i)
            if (!(a->scalar[i] >= p->levels[0].min - 1e-3 && a->scalar[i] <= p->levels[0].max + 1e-3)) /* float sums */
                why = because("level %g holds %g", (double)k, (double)a->scalar[i]);
    }
    (void)v;
    return why;
}

static const char *pyramid_fails(const unsigned *n)
{
    const size_t size[3] = {1 + n[0], 1 + n[1], 1 + n[2]};
    iso_geometry g = iso_geometry_axis_aligned(size, (double[]){1 + n[3], 1, 1 + n[4]});
    iso_volume v;
    iso_pyramid p = {0}, loaded = {0};
    iso_error err = {""};
    iso_random random = {.state = n[5]};
    if (iso_volume_create(&v, &g, n[6] ? ISO_F32 : ISO_U8, "test", &err) != ISO_OK)
        return "it cannot be created";
    for (size_t i = 0; i < iso_geometry_voxel_count(&g); ++i) {
        const unsigned value = (unsigned)(iso_random_next(&random) % 256);
        if (n[6])
            ((float *)v.data)[i] = (float)value / 16;
        else
            ((uint8_t *)v.data)[i] = (uint8_t)value;
    }
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.threads = 1 + (int)n[7];
    opt.level_count = 1;
    for (size_t m = size[0] > size[1] ? size[0] : size[1], k = m > size[2] ? m : size[2]; k > 1; k = (k + 1) / 2)
        ++opt.level_count;
    const char *why = iso_pyramid_build(&v, "test", &opt, &p, NULL, &err) == ISO_OK
                          ? check_pyramid(&p, &v, &loaded)
                          : because("it cannot be built of %g levels", (double)opt.level_count, 0);
    iso_pyramid_destroy(&loaded);
    iso_pyramid_destroy(&p);
    iso_volume_destroy(&v);
    return why;
}

TEST(pyramids_of_1_to_40_voxels_an_axis_are_whole)
{
    static const iso_property p = {
        "pyramid", 8, {[0] = 39, [3] = 3, [5] = 1000, [6] = 1, [7] = 2}, .cases = 60, .fails = pyramid_fails};
    assert_property(&p);
}

/* ---- the harness itself ---- */

/* Holds but where a number is 37 or more, and another above 5. */
static const char *planted_fails(const unsigned *n)
{
    return n[1] >= 37 && n[3] > 5 ? "planted" : NULL;
}

TEST(a_planted_fault_is_found_and_shrunk)
{
    static const iso_property p = {"planted", 5, {1000}, .cases = 100, .fails = planted_fails};
    const char *failed = iso_property_try(&p);
    assert_non_null(failed);
    if (!strstr(failed, "shrunk to 0 37 0 6 0:") || !strstr(failed, "ISO_PROPERTY_SEED="))
        fail_msg("%s", failed);
}

TEST_MAIN(make_folder, remove_folder)
