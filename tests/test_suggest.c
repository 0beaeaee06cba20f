/* SPDX-License-Identifier: MIT */
/* Each volume is made from a formula, so it is known what part of it is the object: that has to be shown, and the box's
 * faces have not to be a wall. */
#include "test.h"

#include "base/random.h"
#include "scene/subject.h"
#include "scene/viewpoint.h"
#include "tf/presets.h"
#include "tf/suggest.h"

static const size_t size[3] = {40, 48, 36};

typedef struct sample_at {
    double x, y, z, r, noise; /* -1 to 1 along each axis; the distance from the center; a normal deviate */
} sample_at;
typedef double formula(const sample_at *p);

static double ball(const sample_at *p)
{
    return (p->r < 0.6 ? 180 : 20) + 6 * p->noise;
}

static double dark_ball(const sample_at *p)
{
    return 255 - ball(p);
}

/* Air, soft tissue with a shell of bone in it, and a padding round the field of view. */
static double head(const sample_at *p, double padding)
{
    if (p->x * p->x + p->y * p->y > 0.96)
        return padding;
    const bool bone = p->r > 0.5 && p->r < 0.65;
    return round((p->r > 0.8 ? -1000 : bone ? 900 : 40) + 12 * p->noise);
}

static double padded_head(const sample_at *p)
{
    return head(p, -2000);
}

static double far_padded_head(const sample_at *p)
{
    return head(p, -32768);
}

/* Two lobes, as a p orbital has them. */
static double orbital(const sample_at *p)
{
    return 1e-3 * p->z * exp(-40 * p->r * p->r);
}

/* Nearly all of it lies far below its largest values. */
static double stars(const sample_at *p)
{
    const double dx = p->x - 0.3, e = p->x + 0.4;
    return 1 / (1e-4 + pow(dx * dx + p->y * p->y + p->z * p->z, 1.5)) +
           1 / (1e-3 + pow(e * e + p->y * p->y + p->z * p->z, 1.5));
}

/* Dim and bright spots on a dark current, counts, and a few hot pixels. */
static double spots(const sample_at *p)
{
    double v = 100 + 4 * p->noise;
    for (int i = 0; i < 6; ++i) {
        const double x = p->x - 0.6 * cos(1.0 * i), y = p->y - 0.6 * sin(1.0 * i), z = p->z - 0.2 * (i - 2.5);
        v += (i % 2 ? 90 : 400) * exp(-(x * x + y * y + z * z) / 0.02);
    }
    return round(p->noise > 4 ? 65535 : v);
}

static double waves(const sample_at *p)
{
    return sin(5 * p->x) + sin(6 * p->y + 1) + sin(4 * p->z - 1);
}

static double three_labels(const sample_at *p)
{
    return p->r > 0.7 ? 0 : p->x > 0.2 ? 7 : p->z > 0 ? 5 : 1;
}

static double mask(const sample_at *p)
{
    return p->r < 0.6 ? 255 : 0;
}

/* Sides of the box are cut: the object reaches two faces. */
static double trunk(const sample_at *p)
{
    return (p->x * p->x + p->y * p->y < 0.3 ? 120 : 10) + 3 * p->noise;
}

static const struct {
    const char *name;
    formula *value;
    iso_suggest_kind kind;
    bool hounsfield;
    double solid_lo, solid_hi; /* bounds of the part of the voxels that is nearly opaque; from the formula's volumes */
    double faces_hi;           /* the same of the voxels at the faces */
} cases[] = {
    {"ball", ball, ISO_SUGGEST_OBJECT, false, 0.09, 0.14, 0},
    {"dark ball", dark_ball, ISO_SUGGEST_DARK, false, 0.09, 0.14, 0},
    {"head, padding -2000", padded_head, ISO_SUGGEST_OBJECT, true, 0.05, 0.12, 0},
    {"head, padding -32768", far_padded_head, ISO_SUGGEST_OBJECT, true, 0.05, 0.12, 0},
    {"orbital", orbital, ISO_SUGGEST_SIGNED, false, 0.002, 0.1, 0},
    {"stars", stars, ISO_SUGGEST_OBJECT, false, 0.0005, 0.2, 0.02},
    {"spots", spots, ISO_SUGGEST_OBJECT, false, 0.005, 0.08, 0.01},
    {"waves", waves, ISO_SUGGEST_SHELL, false, 0.005, 0.15, 0.15},
    {"labels", three_labels, ISO_SUGGEST_LABELS, false, 0.15, 0.2, 0},
    {"mask", mask, ISO_SUGGEST_LABELS, false, 0.09, 0.14, 0},
    {"trunk", trunk, ISO_SUGGEST_OBJECT, false, 0.2, 0.26, 0.1},
};

static iso_level make_level(formula *value)
{
    iso_level l = {.geometry = iso_geometry_axis_aligned(size, (double[]){1, 0.8, 1.2}),
                   .min = INFINITY,
                   .max = -INFINITY};
    iso_random random = {9};
    l.scalar = malloc(iso_geometry_voxel_count(&l.geometry) * sizeof *l.scalar);
    assert_non_null(l.scalar);
    for (size_t z = 0, i = 0; z < size[2]; ++z)
        for (size_t y = 0; y < size[1]; ++y)
            for (size_t x = 0; x < size[0]; ++x, ++i) {
                sample_at p = {2 * (x + 0.5) / (double)size[0] - 1, 2 * (y + 0.5) / (double)size[1] - 1,
                               2 * (z + 0.5) / (double)size[2] - 1, 0, 0};
                p.r = sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
                for (int k = 0; k < 12; ++k)
                    p.noise += iso_random_unit(&random);
                p.noise -= 6;
                l.scalar[i] = (float)value(&p);
                l.min = fmin(l.min, (double)l.scalar[i]);
                l.max = fmax(l.max, (double)l.scalar[i]);
            }
    return l;
}

/* Parts of all voxels and of those at the faces of which two hide more than 30 %. */
static void measure(const iso_level *l, const iso_tf *tf, double *solid, double *faces)
{
    OWNED(iso_tf_table) table;
    size_t n[2] = {0, 0}, opaque[2] = {0, 0};
    const double two_voxels = 2 * iso_geometry_mean_spacing_mm(&l->geometry);
    assert_ok(iso_tf_tabulate(tf, l->min, l->max, &l->geometry, &table, &err));
    for (size_t z = 0, i = 0; z < size[2]; ++z)
        for (size_t y = 0; y < size[1]; ++y)
            for (size_t x = 0; x < size[0]; ++x, ++i) {
                double rgbs[4];
                iso_tf_lookup(&table, l->scalar[i], rgbs);
                const bool face = x == 0 || y == 0 || z == 0 || x + 1 == size[0] || y + 1 == size[1] ||
                                  z + 1 == size[2];
                for (int f = 0; f <= face; ++f) {
                    ++n[f];
                    opaque[f] += -expm1(-rgbs[3] * two_voxels) > 0.3;
                }
            }
    *solid = (double)opaque[0] / (double)n[0];
    *faces = (double)opaque[1] / (double)n[1];
}

TEST(the_object_is_shown_and_the_faces_are_no_wall)
{
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        iso_level l = make_level(cases[i].value);
        FREED iso_survey *survey;
        OWNED(iso_suggestion) s;
        double solid, faces;
        assert_ok(iso_survey_make(&l, 1, &survey, &err));
        assert_ok(iso_suggest(survey, &l.geometry, &s, &err));
        measure(&l, &s.tf, &solid, &faces);
        if (s.kind != cases[i].kind || survey->is_hounsfield != cases[i].hounsfield || !(solid >= cases[i].solid_lo) ||
            !(solid <= cases[i].solid_hi) || !(faces <= cases[i].faces_hi))
            fail_msg("%s: %s, solid %.4f, faces %.4f", cases[i].name, iso_suggest_kind_text(s.kind), solid, faces);
        assert_true(s.tf.point_count >= 2 && s.tf.point_count <= ISO_SUGGEST_POINTS);
        for (size_t k = 1; k < s.tf.point_count; ++k)
            assert_true(s.tf.points[k].value >= s.tf.points[k - 1].value);
        free(l.scalar);
    }
}

/* The check itself: a transfer function that begins in the background makes a wall, one beyond all values shows
 * nothing. */
TEST(a_wall_and_nothing_are_told)
{
    iso_level l = make_level(ball);
    iso_tf_point points[2] = {{.value = 0, .opacity = 0.75}, {.value = 1, .opacity = 0.75}};
    const iso_tf tf = {.point_count = 2, .points = points, .range = {0, 255}, .unit_distance = 2, .table_size = 64};
    iso_tf_point beyond[2] = {{.value = 300, .opacity = 0}, {.value = 301, .opacity = 0.75}};
    const iso_tf nothing = {
        .point_count = 2, .points = beyond, .range = {0, 400}, .unit_distance = 2, .table_size = 64};
    double solid, faces;
    measure(&l, &tf, &solid, &faces);
    assert_true(faces > 0.9);
    measure(&l, &nothing, &solid, &faces);
    assert_true(solid == 0);
    free(l.scalar);
}

TEST(threads_change_nothing)
{
    iso_level l = make_level(spots);
    FREED iso_survey *one, *three;
    assert_ok(iso_survey_make(&l, 1, &one, &err));
    assert_ok(iso_survey_make(&l, 3, &three, &err));
    assert_memory_equal(one->joint, three->joint, sizeof one->joint);
    assert_memory_equal(one->slope, three->slope, sizeof one->slope);
    assert_true(one->background_hi == three->background_hi && one->face_count == three->face_count);
    free(l.scalar);
}

/* Counts each voxel by the formulas of survey.h, in doubles. */
static void count_plainly(const iso_level *l, iso_survey *s)
{
    const size_t *n = l->geometry.size;
    double h[3];
    iso_geometry_spacing_mm(&l->geometry, h);
    const double mean = cbrt(h[0] * h[1] * h[2]), largest = 0.5 * (s->hi - s->lo);
    memset(s->joint, 0, sizeof s->joint);
    memset(s->count, 0, sizeof s->count);
    memset(s->face, 0, sizeof s->face);
    for (size_t i = 0; i < n[0] * n[1] * n[2]; ++i) {
        const size_t at[3] = {i % n[0], i / n[0] % n[1], i / (n[0] * n[1])}, step[3] = {1, n[0], n[0] * n[1]};
        double squares = 0;
        bool is_beside = false, is_face = false;
        if (s->has_padding && (double)l->scalar[i] == s->padding)
            continue;
        for (int a = 0; a < 3; ++a) {
            const float before = l->scalar[at[a] > 0 ? i - step[a] : i],
                        after = l->scalar[at[a] + 1 < n[a] ? i + step[a] : i];
            const double slope = ((double)after - (double)before) * (0.5 * mean / h[a]);
            squares += slope * slope;
            is_face = is_face || at[a] == 0 || at[a] + 1 == n[a];
            is_beside = is_beside || (s->has_padding && ((double)before == s->padding || (double)after == s->padding));
        }
        const int bin = iso_survey_bin(s, (double)l->scalar[i]);
        const double slope = sqrt(squares) < largest ? ISO_SURVEY_SLOPES * sqrt(sqrt(squares) / largest)
                                                     : ISO_SURVEY_SLOPES - 1;
        ++s->count[bin];
        s->face[bin] += is_face;
        s->joint[bin][(int)slope] += !is_beside;
    }
}

/* Most bins are found in floats, and voxels of one value together: every count is that of doubles. */
TEST(counts_are_those_of_doubles)
{
    static formula *const formulas[] = {ball, padded_head, orbital, three_labels, waves, stars};
    for (size_t i = 0; i < sizeof formulas / sizeof *formulas; ++i) {
        iso_level l = make_level(formulas[i]);
        iso_survey *survey;
        assert_ok(iso_survey_make(&l, 2, &survey, &err));
        iso_survey *plain = malloc(sizeof *plain);
        *plain = *survey;
        count_plainly(&l, plain);
        assert_memory_equal(plain->count, survey->count, sizeof plain->count);
        assert_memory_equal(plain->face, survey->face, sizeof plain->face);
        assert_memory_equal(plain->joint, survey->joint, sizeof plain->joint);
        /* A value that moves is seen. */
        const size_t middle = size[0] / 2 + size[0] * (size[1] / 2 + size[1] * (size[2] / 2));
        l.scalar[middle] += (float)(survey->hi - survey->lo) / 8;
        count_plainly(&l, plain);
        assert_memory_not_equal(plain->joint, survey->joint, sizeof plain->joint);
        free(plain);
        free(survey);
        free(l.scalar);
    }
}

static double constant(const sample_at *p)
{
    return 5 + 0 * p->x;
}

static double ramp(const sample_at *p)
{
    return p->x;
}

static double only_noise(const sample_at *p)
{
    return p->noise;
}

static double huge(const sample_at *p)
{
    return 1e30 * ball(p);
}

TEST(any_volume_gets_a_transfer_function)
{
    formula *const odd[] = {constant, ramp, only_noise, huge};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; ++i) {
        iso_level l = make_level(odd[i]);
        for (size_t row = 0; row < iso_tf_preset_names.count; ++row) {
            OWNED(iso_tf) tf;
            OWNED(iso_tf_table) table;
            assert_ok(iso_tf_of_level(iso_names_name(&iso_tf_preset_names, row), NULL, NULL, &l, 1, &tf, &err));
            assert_ok(iso_tf_tabulate(&tf, l.min, l.max, &l.geometry, &table, &err));
            for (size_t e = 0; e < 4 * table.count; ++e)
                assert_true(isfinite(table.entries[e]));
        }
        free(l.scalar);
    }
}

/* From the front a patient's left side is on the right of the picture. */
TEST(views_have_their_sides)
{
    static const struct {
        const char *name;
        iso_vec3 at, right; /* where the camera stands, and what is to the right of it */
    } views[] = {
        {"front", {0, 1, 0}, {-1, 0, 0}}, {"back", {0, -1, 0}, {1, 0, 0}},  {"left", {-1, 0, 0}, {0, -1, 0}},
        {"right", {1, 0, 0}, {0, 1, 0}},  {"top", {0, 0, 1}, {1, 0, 0}},    {"bottom", {0, 0, -1}, {-1, 0, 0}},
        {"0,0", {0, 1, 0}, {-1, 0, 0}},   {"90,0", {-1, 0, 0}, {0, -1, 0}}, {"0,90", {0, 0, 1}, {1, 0, 0}},
    };
    const iso_geometry g = iso_geometry_axis_aligned(size, (double[]){1, 0.8, 1.2});
    for (size_t i = 0; i < sizeof views / sizeof *views; ++i) {
        iso_viewpoint v;
        assert_ok(iso_viewpoint_parse(views[i].name, &v, &err));
        const iso_vec3 right = iso_normalize(iso_cross(v.direction, v.up));
        assert_true(iso_norm(iso_add(v.direction, views[i].at)) < 1e-12);
        assert_true(iso_norm(iso_sub(right, views[i].right)) < 1e-12);
        /* the box's corners lie inside the picture, and one of them at its twentieth */
        const iso_scene scene = iso_scene_first(&g, &v, 300, 200);
        iso_scene shown = scene;
        iso_tf_point points[2] = {{.value = 0}, {.value = 1}};
        shown.tf = (iso_tf){.point_count = 2, .points = points, .range = {0, 1}, .unit_distance = 1, .table_size = 2};
        OWNED(iso_view) view;
        assert_ok(iso_scene_resolve(&shown, &g, 0, 1, &view, &err));
        double farthest = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const iso_vec3 p = iso_sub(iso_geometry_to_world(&g, iso_v3((corner & 1) * g.box_index[0],
                                                                        (corner >> 1 & 1) * g.box_index[1],
                                                                        (corner >> 2 & 1) * g.box_index[2])),
                                       view.camera.position);
            const double depth = iso_dot(p, view.camera.forward), high = view.camera.half_height * depth;
            farthest = fmax(farthest, fmax(fabs(iso_dot(p, view.camera.up)) / high,
                                           fabs(iso_dot(p, view.camera.right)) / (1.5 * high)));
        }
        assert_true(fabs(farthest - 0.95) < 1e-9);
    }
}

/* Two edges three times as long as the third; of a patient, too. An oblique axis counts by its largest part. */
TEST(a_thin_slab_is_seen_along_its_shortest_axis)
{
    static const struct {
        size_t size[3];
        const char *view, *of_patient;
    } slabs[] = {{{60, 50, 10}, "top", "top"},     {{60, 9, 30}, "front", "front"}, {{8, 25, 30}, "left", "left"},
                 {{60, 50, 20}, "iso", "front"}, {{60, 10, 20}, "iso", "front"}};
    for (size_t i = 0; i < sizeof slabs / sizeof *slabs; ++i) {
        iso_geometry g = iso_geometry_axis_aligned(slabs[i].size, (double[]){1, 1, 1});
        assert_string_equal(iso_viewpoint_usual(&g), slabs[i].view);
        g.is_patient = true;
        assert_string_equal(iso_viewpoint_usual(&g), slabs[i].of_patient);
    }
    /* spacing counts, and the direction in the world */
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){60, 50, 10}, (double[]){1, 1, 5});
    assert_string_equal(iso_viewpoint_usual(&g), "iso");
    g = iso_geometry_axis_aligned((size_t[]){60, 50, 10}, (double[]){1, 1, 1});
    g.index_to_world = (iso_mat3){{{1, 0, 0.3}, {0, 0.3, -0.95}, {0, 0.95, 0.3}}};
    assert_string_equal(iso_viewpoint_usual(&g), "front");
}

/* An organ in nothing, as skull stripping leaves it: gray with a white core, and a thin rim of partial volume. */
static double stripped(const sample_at *p)
{
    return p->r > 0.7 ? 0 : (p->r > 0.68 ? 35 : p->r > 0.45 ? 90 : 125) + 6 * p->noise;
}

/* The same in a head: a thick layer that is darker. */
static double in_a_head(const sample_at *p)
{
    return p->r > 0.7 && p->r < 0.95 ? 40 + 6 * p->noise : stripped(p);
}

TEST(an_organ_that_was_cut_out_is_solid)
{
    for (int k = 0; k < 3; ++k) { /* a patient's; none of a patient; in its surroundings */
        iso_level l = make_level(k == 2 ? in_a_head : stripped);
        iso_survey *survey;
        iso_suggestion found;
        l.geometry.is_patient = k != 1;
        assert_ok(iso_survey_make(&l, 1, &survey, &err));
        assert_ok(iso_suggest(survey, &l.geometry, &found, &err));
        assert_int_equal(found.kind, ISO_SUGGEST_OBJECT);
        assert_true(found.material_count >= 2);
        if (k == 0)
            assert_true(found.materials[0].opacity > 0.5 && found.materials[0].begins > 40);
        else
            assert_true(found.materials[0].opacity < 0.5);
        iso_suggestion_destroy(&found);
        free(survey);
        free(l.scalar);
    }
}

/* Air on two faces, a body cut off by the four others, and a bone in it. */
static double cut_chest(const sample_at *p)
{
    const bool bone = p->r < 0.3;
    return round(fabs(p->x) > 0.8 ? -1000 + 2 * p->noise : (bone ? 900 : 40) + 60 * p->noise);
}

TEST(air_is_the_background_of_a_body_that_is_cut_off)
{
    iso_level l = make_level(cut_chest);
    FREED iso_survey *survey;
    OWNED(iso_suggestion) found;
    assert_ok(iso_survey_make(&l, 1, &survey, &err));
    assert_true(survey->is_hounsfield);
    assert_true(survey->has_background);
    assert_true(survey->background_hi < -700 && survey->background < -850);
    assert_ok(iso_suggest(survey, &l.geometry, &found, &err));
    assert_int_equal(found.kind, ISO_SUGGEST_OBJECT);
    free(l.scalar);
}

static double small_ball(const sample_at *p)
{
    const double x = p->x - 0.5, y = p->y + 0.4, z = p->z - 0.3;
    return x * x + y * y + z * z < 0.04 ? 100 : 0;
}

/* A small object in a large volume fills the picture; one that fills the volume leaves the camera with the box. */
TEST(the_camera_frames_what_is_visible)
{
    formula *const objects[] = {small_ball, ball, constant};
    for (size_t i = 0; i < sizeof objects / sizeof *objects; ++i) {
        iso_level l = make_level(objects[i]);
        iso_viewpoint v;
        assert_ok(iso_viewpoint_parse("iso", &v, &err));
        iso_scene whole = iso_scene_first(&l.geometry, &v, 64, 64), s = whole;
        iso_tf_point points[] = {{.value = 90}, {.value = 95, .opacity = 0.9}, {.value = 200, .opacity = 0.9}};
        const iso_tf tf = {
            .points = points, .point_count = 3, .range = {90, 200}, .unit_distance = 1, .table_size = 256};
        OWNED(iso_tf_table) table;
        assert_ok(iso_tf_tabulate(&tf, 0, 1, &l.geometry, &table, &err));
        assert_ok(iso_scene_frame_visible(&s, &l, &table, 1, NULL, &err));
        assert_int_equal(s.camera_fit, i != 0);
        if (i == 0) {
            const iso_geometry *g = &l.geometry;
            const iso_vec3 index = iso_v3(0.75 * g->box_index[0], 0.3 * g->box_index[1], 0.65 * g->box_index[2]),
                           off = iso_sub(iso_geometry_to_world(g, index), s.camera_look_at);
            assert_true(iso_norm(off) < 1.5 * iso_geometry_mean_spacing_mm(g)); /* voxels that the ball holds in part */
            const double distance = iso_norm(iso_sub(s.camera_look_at, s.camera_position));
            assert_true(distance < 0.5 * iso_geometry_box_radius_mm(g) / sin(12.5 * acos(-1) / 180));
            iso_scene threads = whole, again = whole;
            iso_scene_part kept = {0};
            assert_ok(iso_scene_frame_visible(&threads, &l, &table, 3, &kept, &err));
            assert_memory_equal(&threads.camera_position, &s.camera_position, sizeof s.camera_position);
            kept.hi[0] = kept.lo[0]; /* the kept part, now empty, is not searched for again */
            assert_ok(iso_scene_frame_visible(&again, &l, &table, 3, &kept, &err));
            assert_true(again.camera_fit);
        }
        free(l.scalar);
    }
}

TEST(bad_views_name_what_is_wanted)
{
    const char *const bad[] = {"frnt", "1", "1,2,3", "10,91", ",", "", "nan,0"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        iso_viewpoint v;
        iso_error err = {""};
        assert_int_equal(iso_viewpoint_parse(bad[i], &v, &err), ISO_E_USAGE);
        assert_non_null(strstr(err.text, "iso, front, back, left, right, top, bottom, or AZ,EL"));
    }
}

TEST_MAIN(NULL, NULL)
