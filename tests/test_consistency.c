/* SPDX-License-Identifier: MIT */
/* The levels against level 0, as `isoshade validate` measures them: under the original TF and under the one adapted to
 * each level, and that rows say which. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "validate/validate.h"
#include "scene/views.h"
#include "tests/validated.h"
#include "volume/synthetic.h"

enum { pixels = 40, views = 2, levels = 3 };
static const subject_size size = {pixels, levels, views};

/* A thin shell under one light, which coarse values widen: what adapting is for. */
static iso_scene make_scene(void)
{
    static iso_tf_point points[] = {{0, {0.9, 0.7, 0.4}, 0},
                                    {0.4, {0.9, 0.7, 0.4}, 0},
                                    {0.5, {1, 0.9, 0.6}, 0.5},
                                    {0.6, {0.3, 0.6, 0.9}, 0},
                                    {1, {0.3, 0.6, 0.9}, 0}};
    return scene_of_points(points, 5, pixels, 0.3);
}

static void open_subject(subject *s, iso_field_kind kind, const char *name)
{
    const iso_field field = {.kind = kind,
                             .seed = 3,
                             .geometry = iso_geometry_axis_aligned((size_t[]){30, 27, 22}, (double[]){1, 1.2, 0.9})};
    open_field(s, &field, make_scene(), name, size);
}

static const json_t *rows_of(const subject *s)
{
    return json_object_get(iso_report_json(s->validation.report), "consistency");
}

/* The one row of that name and level. */
static const json_t *row_of(const subject *s, const char *wanted, size_t level)
{
    const json_t *found = NULL;
    json_t *row;
    size_t i;
    json_array_foreach(rows_of(s), i, row)
    {
        char name[ISO_CONSISTENCY_NAME_BYTES];
        iso_report_consistency_name(row, name);
        if (strcmp(name, wanted) == 0 && (size_t)json_integer_value(json_object_get(row, "level")) == level) {
            assert_null(found);
            found = row;
        }
    }
    if (!found)
        fail_msg("no row of %s at level %zu", wanted, level);
    return found;
}

static double figure(const json_t *row, const char *key)
{
    const json_t *value = json_object_get(row, key);
    assert_true(json_is_number(value));
    return json_number_value(value);
}

static double dissimilarity(const subject *s, const char *name, size_t level)
{
    return figure(row_of(s, name, level), "ssim_dissimilarity_mean");
}

/* The same by hand: level 0 under the scene's TF, `level` under `table`, directions from the codes. */
static double measure_by_hand(subject *s, size_t level, const iso_tf_table *table)
{
    double sum = 0;
    for (int i = 0; i < views; ++i) {
        const iso_level *l = &s->pyramid.levels[0];
        iso_scene scene = s->scene;
        iso_view view;
        iso_image fine, coarse;
        iso_metrics m;
        const iso_render_options opt = iso_render_defaults(&iso_renderer_gl);
        scene.camera_direction = iso_view_along_diagonal(i);
        scene.camera_up = iso_view_up(scene.camera_direction);
        assert_ok(iso_scene_resolve(&scene, &l->geometry, l->min, l->max, &view, &err));
        assert_ok(
            iso_render_with(&(iso_render_request){&renderers, &s->pyramid, 0, &view, &opt, NULL}, &fine, NULL, &err));
        iso_view adapted = view; /* lent */
        adapted.tf = *table;
        assert_ok(iso_render_with(&(iso_render_request){&renderers, &s->pyramid, level, &adapted, &opt, NULL}, &coarse,
                                  NULL, &err));
        assert_ok(iso_metrics_measure(&fine, &coarse, &m, &err));
        sum += (1 - m.ssim) / views;
        iso_image_destroy(&fine);
        iso_image_destroy(&coarse);
        iso_view_destroy(&view);
    }
    return sum;
}

static void every_method_has_a_row_under_either_tf_at_every_level(void **state)
{
    (void)state;
    subject s;
    open_subject(&s, ISO_FIELD_SHELLS, "rows");
    measure_levels(&s);
    assert_int_equal(json_array_size(rows_of(&s)), iso_method_count * (levels - 1) * 2);
    for (size_t level = 1; level < levels; ++level)
        for (size_t m = 0; m < iso_method_count; ++m) {
            char adapted[64];
            snprintf(adapted, sizeof adapted, "%s+adapted", iso_methods[m].name);
            const json_t *a = row_of(&s, iso_methods[m].name, level), *b = row_of(&s, adapted, level);
            assert_true(json_is_null(json_object_get(a, "original_kept")));
            assert_true(json_is_null(json_object_get(b, "original_kept")));
            assert_string_equal(json_string_value(json_object_get(a, "tf")), "original");
            assert_string_equal(json_string_value(json_object_get(b, "tf")), "adapted");
            assert_string_not_equal(json_string_value(json_object_get(a, "image")),
                                    json_string_value(json_object_get(b, "image")));
            /* What adapting is for: the level comes nearer to level 0, whatever its directions. */
            assert_at_most(figure(b, "ssim_dissimilarity_mean"), 0.8 * figure(a, "ssim_dissimilarity_mean"));
            assert_at_most(figure(b, "flip_mean"), 0.8 * figure(a, "flip_mean"));
            assert_within(figure(a, "gradient_angle_mean_deg"), figure(b, "gradient_angle_mean_deg"), 0);
        }
    close_subject(&s);
}

/* The same images once more: only the sum's order could differ. */
static const double rounding = 1e-12;

static void a_row_is_of_its_own_level_and_tf(void **state)
{
    (void)state;
    subject s;
    open_subject(&s, ISO_FIELD_SHELLS, "own");
    measure_levels(&s);
    for (size_t level = 1; level < levels; ++level) {
        const iso_tf_table *own = &s.validation.level_tfs[level].table,
                           *others = &s.validation.level_tfs[levels - level].table;
        double adapted = dissimilarity(&s, "moments+adapted", level);
        assert_within(dissimilarity(&s, "moments", level), measure_by_hand(&s, level, &s.view.tf), rounding);
        assert_within(adapted, measure_by_hand(&s, level, own), rounding);
        /* Planted: the TF of another level, one entry off, and the original are each another figure. */
        iso_tf_table off = *own;
        off.lo += (own->hi - own->lo) / (double)(own->count - 1);
        off.hi += off.lo - own->lo;
        assert_more_than(fabs(measure_by_hand(&s, level, others) - adapted), 1e-3);
        assert_more_than(fabs(measure_by_hand(&s, level, &off) - adapted), 1e-4);
        assert_more_than(fabs(dissimilarity(&s, "moments", level) - adapted), 1e-2);
    }
    close_subject(&s);
}

/* Planted: levels that exchange their TFs lose what adapting had gained at one of them. */
static void exchanged_tfs_are_seen_in_the_rows(void **state)
{
    (void)state;
    subject right, wrong;
    open_subject(&right, ISO_FIELD_SHELLS, "right");
    open_subject(&wrong, ISO_FIELD_SHELLS, "wrong");
    iso_level_tf *tfs = wrong.validation.level_tfs, first = tfs[1];
    tfs[1] = tfs[2];
    tfs[2] = first;
    measure_levels(&right);
    measure_levels(&wrong);
    for (size_t m = 0; m < iso_method_count; ++m) {
        char name[64];
        snprintf(name, sizeof name, "%s+adapted", iso_methods[m].name);
        assert_more_than(dissimilarity(&wrong, name, 1), 1.1 * dissimilarity(&right, name, 1));
        assert_within(dissimilarity(&wrong, iso_methods[m].name, 1), dissimilarity(&right, iso_methods[m].name, 1), 0);
    }
    close_subject(&right);
    close_subject(&wrong);
}

/* No table can be nearer to voxels that are all alike. */
static void a_refused_adaptation_is_said_with_the_originals_figures(void **state)
{
    (void)state;
    subject s;
    open_subject(&s, ISO_FIELD_CONSTANT, "kept");
    measure_levels(&s);
    for (size_t level = 1; level < levels; ++level) {
        const json_t *a = row_of(&s, "naive", level), *b = row_of(&s, "naive+adapted", level);
        assert_non_null(strstr(json_string_value(json_object_get(b, "original_kept")), "the adapted TF"));
        assert_within(figure(b, "ssim_dissimilarity_mean"), figure(a, "ssim_dissimilarity_mean"), 0);
        assert_string_equal(json_string_value(json_object_get(a, "image")),
                            json_string_value(json_object_get(b, "image")));
    }
    close_subject(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_method_has_a_row_under_either_tf_at_every_level),
        cmocka_unit_test(a_row_is_of_its_own_level_and_tf),
        cmocka_unit_test(exchanged_tfs_are_seen_in_the_rows),
        cmocka_unit_test(a_refused_adaptation_is_said_with_the_originals_figures),
    };
    return cmocka_run_group_tests(tests, make_folder, end_renderers_and_folder);
}
