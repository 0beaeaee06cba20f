/* SPDX-License-Identifier: MIT */
/* Label maps: what is taken for one, majorities, and a slab of two labels whose picture is closed. */
#include "difference.h"
#include "rendered.h"
#include "test.h"

#include "volume/labels.h"
#include "volume/segments.h"

/* ---- a slab of two labels, looked at across ---- */

enum { NX = 16, NY = 4, NZ = 4, THREES = 4, SEVENS = 6 };

/* Air of label 0 to both sides; voxels of 1 mm. Labels from 3 to 7 pass through none that lies between. */
static iso_level make_slab(void)
{
    const size_t size[3] = {NX, NY, NZ};
    const double spacing[3] = {1, 1, 1};
    iso_level level = {.geometry = iso_geometry_axis_aligned(size, spacing),
                       .stored_type = ISO_U8,
                       .max = 7,
                       .labels = true,
                       .scalar = calloc(NX * NY * NZ, sizeof(float)),
                       .codes = calloc(NX * NY * NZ, 3)};
    for (size_t i = 0; i < NX * NY * NZ; ++i) {
        const size_t x = i % NX;
        level.scalar[i] = x < 3 ? 0 : x < 3 + THREES ? 3 : x < 3 + THREES + SEVENS ? 7 : 0;
    }
    return level;
}

/* A class table: an entry a label; those that there are not are white and dense, so that they would show. */
static float classes[8][4] = {{0, 0, 0, 0}, {1, 1, 1, 5}, {1, 1, 1, 5}, {1, 0.2f, 0, 0.11f},
                              {1, 1, 1, 5}, {1, 1, 1, 5}, {1, 1, 1, 5}, {0, 0.4f, 1, 0.07f}};

static iso_view make_view(void)
{
    iso_view view = {.width = 4, .height = 4, .shading = {.ambient = 1, .power = 1}, .step_voxels = 0.5};
    view.camera = (iso_camera){.orthographic = true,
                               .forward = {1, 0, 0},
                               .right = {0, -1, 0},
                               .up = {0, 0, 1},
                               .half_height = 0.5,
                               .position = {-50, 0, 0}};
    view.tf = (iso_tf_table){.count = 8, .lo = 0, .hi = 7, .entries = classes[0]};
    return view;
}

static const iso_renderer_info *find(const char *name)
{
    for (size_t i = 0; i < iso_renderer_count(); ++i)
        if (strcmp(iso_renderer_at(i)->name, name) == 0)
            return iso_renderer_at(i);
    fail();
    return NULL;
}

static iso_status draw_view(const iso_renderer_info *r, iso_level *level, bool exact, iso_view view,
                            iso_direction_source source, iso_image *image, iso_error *err)
{
    const iso_pyramid pyramid = {.options = iso_pyramid_defaults(), .level_count = 1, .levels = level};
    iso_render_options opt = iso_render_defaults(r);
    opt.exact_lookups = exact;
    opt.source = source;
    opt.threads = 1;
    if (strcmp(r->name, "povray") == 0) {
        opt.intervals = 128;
        opt.extrapolate = true;
    }
    const iso_render_request request = {.renderers = &renderers, .pyramid = &pyramid, .view = &view, .options = &opt};
    return iso_render_with(&request, image, NULL, err);
}

static iso_status draw_by(const iso_renderer_info *r, iso_level *level, bool exact, iso_image *image, iso_error *err)
{
    return draw_view(r, level, exact, make_view(), iso_render_defaults(r).source, image, err);
}

static iso_status draw(const char *name, iso_level *level, bool exact, iso_image *image, iso_error *err)
{
    return draw_by(find(name), level, exact, image, err);
}

static void closed_form(double rgba[4])
{
    const double a = exp(-(double)classes[3][3] * THREES), b = exp(-(double)classes[7][3] * SEVENS);
    for (int c = 0; c < 3; ++c)
        rgba[c] = (double)classes[3][c] * (1 - a) + a * (double)classes[7][c] * (1 - b);
    rgba[3] = 1 - a * b;
}

static double farthest(const iso_image *image)
{
    double wanted[4], most = 0;
    closed_form(wanted);
    for (size_t i = 0; i < 4 * image->width * image->height; ++i)
        most = fmax(most, fabs((double)image->rgba[i] - wanted[i % 4]));
    return most;
}

static void free_slab(iso_level *level)
{
    free(level->scalar);
    free(level->codes);
}

/* The reference: to its own tolerance. The ray caster: segments of half a voxel, each in one label, so that its sums
 * are exact but for floats, some 32 of them. Cycles: 16 steps a voxel, of which 16 are in each wherever they begin, in
 * floats too. POV-Ray: intervals of an eighth and a quarter of a voxel, extrapolated; 16 bits a channel, twice
 * 7.6e-6. */
TEST(a_slab_of_two_labels_has_its_closed_form)
{
    static const struct {
        const char *renderer;
        bool exact;
        double tolerance;
    } cases[] = {{"reference", false, 1e-6},
                 {"gl", false, 2e-6},
                 {"gl", true, 2e-6},
                 {"povray", false, 2e-5},
                 {"cycles", false, 2e-6}};
    ENDED_BY(free_slab) iso_level level = make_slab();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        OWNED(iso_image) image;
        assert_ok(draw(cases[i].renderer, &level, cases[i].exact, &image, &err));
        const double far = farthest(&image);
        if (!(far <= cases[i].tolerance))
            print_error("%s, exact %d: %g from the closed form\n", cases[i].renderer, cases[i].exact, far);
        assert_true(far <= cases[i].tolerance);
    }
}

/* Differences of labels are those of what is looked up, in all ways of lookup. */
TEST(differences_on_the_fly_are_those_of_labels)
{
    ENDED_BY(free_slab) iso_level level = make_slab();
    iso_view view = make_view();
    iso_image wanted, image;
    view.shading = (iso_shading){.ambient = 0.3, .diffuse = 0.7, .power = 1};
    view.light_count = 1;
    view.lights[0] = (iso_light){.direction = {-0.6, 0, 0.8}, .intensity = 1};
    assert_ok(draw_view(find("reference"), &level, false, view, ISO_FROM_ON_THE_FLY, &wanted, &err));
    for (int exact = 0; exact < 2; ++exact) {
        assert_ok(draw_view(find("gl"), &level, exact, view, ISO_FROM_ON_THE_FLY, &image, &err));
        assert_at_most(difference_of(&image, &wanted).max_abs, 2e-6);
        iso_image_destroy(&image);
    }
    iso_image_destroy(&wanted);
}

/* Planted: interpolated, the labels between 3 and 7 show. */
TEST(interpolated_labels_are_far_from_it)
{
    ENDED_BY(free_slab) iso_level level = make_slab();
    level.labels = false;
    static const char *const names[] = {"reference", "gl", "povray", "cycles"};
    for (int i = 0; i < 4; ++i) {
        OWNED(iso_image) image;
        assert_ok(draw(names[i], &level, false, &image, &err));
        assert_true(farthest(&image) > 0.1);
    }
}

/* None of ours does. */
TEST(a_renderer_that_would_interpolate_is_refused)
{
    ENDED_BY(free_slab) iso_level level = make_slab();
    iso_renderer_info without = *find("gl");
    iso_image image;
    iso_error err = {""};
    without.traits &= ~(unsigned)ISO_HAS_LABELS;
    assert_int_equal(draw_by(&without, &level, false, &image, &err), ISO_E_USAGE);
    assert_non_null(strstr(err.text, "label maps are rendered by reference, gl, cpu, cycles and povray, not by gl"));
}

/* ---- majorities ---- */

static float label_at(const iso_level *l, size_t x, size_t y, size_t z)
{
    const size_t *n = l->geometry.size;
    x = x < n[0] ? x : n[0] - 1;
    y = y < n[1] ? y : n[1] - 1;
    z = z < n[2] ? z : n[2] - 1;
    return l->scalar[(z * n[1] + y) * n[0] + x];
}

/* Counted: the most of eight, the largest of several. */
static float vote(const iso_level *fine, size_t x, size_t y, size_t z)
{
    int votes[8] = {0}, best = 0;
    for (size_t c = 0; c < 8; ++c)
        ++votes[(int)label_at(fine, 2 * x + (c & 1), 2 * y + (c >> 1 & 1), 2 * z + (c >> 2))];
    for (int label = 0; label < 8; ++label)
        best = votes[label] >= votes[best] ? label : best;
    return (float)best;
}

TEST(coarse_labels_are_majorities)
{
    const size_t size[3] = {13, 9, 11};
    const double spacing[3] = {1, 1, 1};
    const iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    static const iso_direction_filter filters[] = {ISO_DIRECTION_MOMENTS, ISO_DIRECTION_EQ1};
    uint32_t seed = 7;
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &g, ISO_U8, "labels", &err));
    for (size_t i = 0; i < 13 * 9 * 11; ++i) {
        seed = seed * 1664525u + 1013904223u;
        ((uint8_t *)v.data)[i] = (uint8_t)((seed >> 24) % 3 * 3);
    }
    for (size_t f = 0; f < 2; ++f) {
        OWNED(iso_pyramid) p;
        iso_pyramid_options opt = iso_pyramid_defaults();
        opt.level_count = 4;
        opt.scalar_filter = ISO_SCALAR_MAJORITY;
        opt.direction_filter = filters[f];
        assert_ok(iso_pyramid_build(&v, "labels", &opt, &p, NULL, &err));
        for (size_t k = 1; k < p.level_count; ++k) {
            const size_t *n = p.levels[k].geometry.size;
            assert_true(p.levels[k].labels);
            for (size_t z = 0; z < n[2]; ++z)
                for (size_t y = 0; y < n[1]; ++y)
                    for (size_t x = 0; x < n[0]; ++x)
                        assert_true(label_at(&p.levels[k], x, y, z) == vote(&p.levels[k - 1], x, y, z));
        }
    }
}

/* ---- what is a label map ---- */

enum { SIDE = 24 };

/* Cells round seven points, of which each has a label, within a ball. */
static int cell_of(int x, int y, int z)
{
    static const int points[7][3] = {{4, 5, 6},  {18, 4, 9},  {7, 19, 5},  {16, 17, 8},
                                     {5, 7, 19}, {19, 8, 18}, {11, 18, 18}};
    int best = 0, least = 1 << 30;
    for (int i = 0; i < 7; ++i) {
        const int dx = x - points[i][0], dy = y - points[i][1], dz = z - points[i][2], d = dx * dx + dy * dy + dz * dz;
        if (d < least) {
            least = d;
            best = i + 1;
        }
    }
    const int cx = x - 12, cy = y - 12, cz = z - 12;
    return cx * cx + cy * cy + cz * cz > 121 ? 0 : best;
}

typedef int (*value_of)(int x, int y, int z);
static int labels(int x, int y, int z)
{
    return cell_of(x, y, z);
}
static int mask(int x, int y, int z)
{
    return cell_of(x, y, z) ? 255 : 0;
}
static int nested(int x, int y, int z)
{
    (void)y, (void)z;
    return x / 8;
}
static int slope(int x, int y, int z)
{
    (void)y, (void)z;
    return x;
}
/* Flat regions with a noise of one bit, as few bits of a scanner have them. */
static int noisy(int x, int y, int z)
{
    return 4 * cell_of(x, y, z) + ((x * 73 + y * 179 + z * 283) * 2654435761u >> 31 & 1);
}

/* Nested the other way round: all changes go down. */
static int falling(int x, int y, int z)
{
    (void)y, (void)z;
    return 2 - x / 8;
}
/* Any of sixteen values in any voxel: hardly a change goes to the next one, but hardly a voxel is like its
 * neighbors. */
static int random_values(int x, int y, int z)
{
    return (int)(((unsigned)(x * 73 + y * 179 + z * 283) * 2654435761u) >> 28) * 3;
}
/* Cubes of 27 voxels: too few for a label of their own each. */
static int small_cubes(int x, int y, int z)
{
    return (x / 3 + 8 * (y / 3) + 64 * (z / 3)) * 181 % 512;
}
static int constant(int x, int y, int z)
{
    (void)x, (void)y, (void)z;
    return 7;
}

/* Floats are measured, whatever their values. */
TEST(floats_are_no_labels)
{
    const size_t size[3] = {SIDE, SIDE, SIDE};
    const double spacing[3] = {1, 1, 1};
    const iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    iso_label_facts facts;
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "test", &err));
    for (int i = 0; i < SIDE * SIDE * SIDE; ++i)
        ((float *)v.data)[i] = (float)labels(i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE);
    assert_ok(iso_labels_look_at(&v, true, &facts, &err));
    assert_false(facts.is_map);
}

static iso_label_facts look_at(value_of value, bool all)
{
    const size_t size[3] = {SIDE, SIDE, SIDE};
    const double spacing[3] = {1, 1, 1};
    const iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    iso_label_facts facts;
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &g, ISO_I16, "test", &err));
    for (int i = 0; i < SIDE * SIDE * SIDE; ++i)
        ((int16_t *)v.data)[i] = (int16_t)value(i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE);
    assert_ok(iso_labels_look_at(&v, all, &facts, &err));
    return facts;
}

TEST(labels_are_told_from_intensities)
{
    static const struct {
        value_of value;
        bool is_map;
        size_t count;
    } cases[] = {{labels, true, 8},          {mask, false, 2},     {nested, false, 3},
                 {slope, false, 24},         {noisy, false, 16},   {falling, false, 3},
                 {random_values, false, 16}, {constant, false, 1}, {small_cubes, false, 512}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const iso_label_facts f = look_at(cases[i].value, true);
        assert_int_equal(f.is_map, cases[i].is_map);
        assert_int_equal(f.count, cases[i].count);
        assert_false(f.has_too_many);
    }
}

/* An atlas of a brain has 600 to 2,000 regions. A file that has more values than labels may be is told. */
/* Fills a volume of 32-bit integers with ids in turn, numbers them, and checks that they have the numbers wanted. */
static void check_numbers(iso_type type, const double *ids, const int *wanted, size_t count)
{
    const size_t size[3] = {8, 7, 5};
    const iso_geometry g = iso_geometry_axis_aligned(size, (double[]){1, 1, 1});
    const size_t voxels = iso_geometry_voxel_count(&g);
    OWNED(iso_volume) v;
    iso_label_facts facts;
    assert_ok(iso_volume_create(&v, &g, type, "ids", &err));
    for (size_t i = 0; i < voxels; ++i) {
        const int64_t id = (int64_t)ids[i / 3 % count];
        ((uint32_t *)v.data)[i] = (uint32_t)id;
    }
    assert_ok(iso_labels_look_at(&v, true, &facts, &err));
    assert_true(facts.is_far && facts.is_sparse && !facts.has_too_many);
    assert_int_equal(facts.count, count);
    iso_labels_number(&v, &facts);
    assert_int_equal(v.type, ISO_I16);
    for (size_t i = 0; i < voxels; ++i)
        assert_int_equal(((int16_t *)v.data)[i], wanted[i / 3 % count]);
    for (size_t i = 0; i < count; ++i) {
        char digits[24];
        snprintf(digits, sizeof digits, "%.0f", ids[i]);
        const json_t *id = json_object_get(iso_segments_find(v.segments, wanted[i]), "id");
        assert_string_equal(iso_segments_name(v.segments, wanted[i]), ids[i] != 0 ? digits : "");
        assert_true(ids[i] == 0 || (double)json_integer_value(id) == ids[i]);
    }
}

TEST(values_far_apart_get_numbers_and_keep_their_ids)
{
    check_numbers(ISO_U32, (double[]){614454277, 0, 997, 4000000000, 70000}, (int[]){3, 0, 1, 4, 2}, 5);
    check_numbers(ISO_I32, (double[]){70000, -5, 3, -200000}, (int[]){2, -1, 1, -2}, 4); /* 0 is no other's */
}

TEST(an_atlas_of_many_labels_is_a_map)
{
    const size_t size[3] = {60, 60, 60};
    const iso_geometry g = iso_geometry_axis_aligned(size, (double[]){1, 1, 1});
    for (int side = 4; side <= 5; ++side) { /* cubes of 64 and of 125 voxels: 3375 and 1728 labels */
        const int n = 60 / side;
        iso_label_facts facts;
        OWNED(iso_volume) v;
        assert_ok(iso_volume_create(&v, &g, ISO_I16, "test", &err));
        for (int i = 0; i < 60 * 60 * 60; ++i) {
            const int x = i % 60 / side, y = i / 60 % 60 / side, z = i / 3600 / side;
            ((int16_t *)v.data)[i] = (int16_t)((x + n * (y + n * z)) * 181 % 3389); /* a prime: each another label */
        }
        assert_ok(iso_labels_look_at(&v, true, &facts, &err));
        assert_int_equal(facts.is_map, side == 5);
        assert_int_equal(facts.has_too_many, side == 4);
        if (side == 5)
            assert_int_equal(facts.count, 1728);
    }
}

TEST_MAIN(NULL, end_renderers)
