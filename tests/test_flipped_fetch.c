/* SPDX-License-Identifier: MIT */
/* The flipped fetch: opposite directions on the two sides of a thin plate do not cancel. */
#include "sampled.h"

#include "render/reference.h"
#include "render/sampler.h"
#include "volume/synthetic.h"

typedef struct shortness {
    double least, mean; /* |n . the plate's normal| */
} shortness;

/* Within half a voxel of the plate's middle, away from the box. */
static shortness near_the_middle(const iso_level *level, iso_direction_source source)
{
    const iso_geometry *g = &level->geometry;
    const iso_vec3 normal = iso_normalize(iso_v3(1, 2, 4)); /* synthetic.c */
    iso_sampler s;
    shortness found = {2, 0};
    size_t count = 0;
    assert_ok(iso_sampler_create(&s, level, ISO_CODE_FIT, source, &err));
    for (size_t i = 0; i < 20000; ++i) {
        const double step = 0.5 / iso_geometry_min_spacing_mm(g);
        iso_vec3 index = {3 + (double)(i * 7919 % 10007) / 10007 * ((double)g->size[0] - 6),
                          3 + (double)(i * 104729 % 20011) / 20011 * ((double)g->size[1] - 6), 0};
        const iso_vec3 foot = iso_geometry_to_world(g, index),
                       lifted = iso_geometry_to_world(g, iso_v3(index.x, index.y, 1));
        index.z = -iso_dot(foot, normal) / (lifted.z - foot.z) / normal.z + ((double)(i % 101) / 100 - 0.5) * step;
        if (index.z < 2 || index.z > (double)g->size[2] - 2)
            continue;
        const double along = fabs(iso_dot(iso_sample_normal(&s, index), normal));
        found.least = fmin(found.least, along);
        found.mean += along;
        ++count;
    }
    iso_sampler_destroy(&s);
    assert_true(count > 1000);
    found.mean /= (double)count;
    return found;
}

static iso_pyramid make_plate(iso_direction_filter filter)
{
    const size_t size[3] = {40, 40, 40};
    const double spacing[3] = {1, 1, 1};
    iso_field f = {.kind = ISO_FIELD_PLATE, .geometry = iso_geometry_axis_aligned(size, spacing)};
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.direction_filter = filter;
    opt.level_count = 2;
    iso_pyramid p = sampled_pyramid(&f, ISO_F32, &opt);
    return p;
}

/* The plate is 1.6 voxels thick (a Gaussian of .8 deviation): the middle is between voxels of opposite directions. */
TEST(a_thin_plate_keeps_its_normal)
{
    OWNED(iso_pyramid) p = make_plate(ISO_DIRECTION_MOMENTS);
    const shortness flipped = near_the_middle(&p.levels[0], ISO_FROM_FLIPPED),
                    plain = near_the_middle(&p.levels[0], ISO_FROM_CODES);
    /* Central differences over two voxels of so thin a plate bend directions by 11 degrees, whose cosine is .98. */
    assert_more_than(flipped.least, 0.95);
    assert_at_most(plain.least, 0.2); /* the planted fault: the plain fetch has no direction in the middle */
    assert_more_than(flipped.mean, plain.mean + 0.02);
}

/* Level 1 with the tensor mean, whose axis survives where the mean of vectors vanishes. */
TEST(a_coarse_plate_keeps_its_normal)
{
    OWNED(iso_pyramid) p = make_plate(ISO_DIRECTION_TENSOR);
    const shortness flipped = near_the_middle(&p.levels[1], ISO_FROM_FLIPPED),
                    plain = near_the_middle(&p.levels[1], ISO_FROM_CODES);
    assert_more_than(flipped.least, 0.95);
    assert_at_most(plain.least, 0.2);
}

/* Where no directions oppose each other nothing changes. */
TEST(directions_of_one_side_are_left_alone)
{
    const size_t size[3] = {9, 8, 7};
    const double spacing[3] = {1, 1, 1};
    iso_field f = {.kind = ISO_FIELD_RAMP, .geometry = iso_geometry_axis_aligned(size, spacing)};
    iso_pyramid_options opt = iso_pyramid_defaults();
    OWNED(iso_sampler) plain, flipped;
    OWNED(iso_pyramid) p = sampled_pyramid(&f, ISO_F32, &opt);
    assert_ok(iso_sampler_create(&plain, &p.levels[0], opt.code, ISO_FROM_CODES, &err));
    assert_ok(iso_sampler_create(&flipped, &p.levels[0], opt.code, ISO_FROM_FLIPPED, &err));
    for (int i = 0; i < 500; ++i) {
        const iso_vec3 at = {i % 9 + 0.13, i % 8 + 0.71, i % 7 + 0.4};
        const iso_vec3 a = iso_sample_normal(&plain, at), b = iso_sample_normal(&flipped, at);
        assert_within(iso_norm(iso_sub(a, b)), 0, 1e-6); /* decoded in single precision */
    }
}

TEST_MAIN(NULL, NULL)
