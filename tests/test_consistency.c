/* SPDX-License-Identifier: MIT */
/* The levels against level 0, as `isoshade validate` measures them: under the original TF and under the one adapted to
 * each level, and that rows say which. */
#include <math.h>
#include <string.h>

#include "base/words.h"
#include "report/levels.h"
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
        OWNED(iso_view) view;
        OWNED(iso_image) fine, coarse;
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
    }
    return sum;
}

TEST(every_method_has_a_row_under_either_tf_at_every_level)
{
    ENDED_BY(close_subject) subject s;
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
}

/* The same images once more: only the sum's order could differ. */
static const double rounding = 1e-12;

VALUES_TEST(a_row_is_of_its_own_level_and_tf)
{
    ENDED_BY(close_subject) subject s;
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
}

/* Planted: levels that exchange their TFs lose what adapting had gained at one of them. */
VALUES_TEST(exchanged_tfs_are_seen_in_the_rows)
{
    ENDED_BY(close_subject) subject right, wrong;
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
}

/* No table can be nearer to voxels that are all alike. */
TEST(a_refused_adaptation_is_reported_with_the_originals_figures)
{
    ENDED_BY(close_subject) subject s;
    open_subject(&s, ISO_FIELD_CONSTANT, "kept");
    measure_levels(&s);
    for (size_t level = 1; level < levels; ++level) {
        const json_t *a = row_of(&s, "naive", level), *b = row_of(&s, "naive+adapted", level);
        assert_non_null(strstr(json_string_value(json_object_get(b, "original_kept")), "the adapted TF"));
        assert_within(figure(b, "ssim_dissimilarity_mean"), figure(a, "ssim_dissimilarity_mean"), 0);
        assert_string_equal(json_string_value(json_object_get(a, "image")),
                            json_string_value(json_object_get(b, "image")));
    }
}

/* ---- extinction scales ---- */

static void open_scaled(subject *s, const char *name)
{
    open_subject(s, ISO_FIELD_SHELLS, name);
    s->validation.scales = ISO_SCALES_ADAPTED;
    assert_ok(iso_validate_scale(&s->validation, &err));
}

/* The verdict on a level, and what it says of the scale. */
static const json_t *verdict_of(const subject *s, size_t level, const char **verdict, iso_levels_summary *sentence)
{
    const json_t *rows = json_object_get(iso_report_json(s->validation.report), "levels"),
                 *row = json_array_get(rows, level - 1);
    *sentence = iso_levels_summarize(iso_report_json(s->validation.report));
    *verdict = json_string_value(json_object_get(row, "verdict"));
    assert_string_equal(json_string_value(json_object_get(row, "tf")), "scaled");
    assert_int_equal(json_integer_value(json_object_get(row, "level")), level);
    return json_object_get(row, "extinction_scale");
}

TEST(levels_are_judged_with_their_extinction_scales)
{
    ENDED_BY(close_subject) subject s;
    const char *verdict;
    iso_levels_summary all;
    open_scaled(&s, "scaled");
    measure_levels(&s);
    assert_int_equal(json_array_size(rows_of(&s)), (iso_method_count * 2 + 1) * (levels - 1));
    for (size_t level = 1; level < levels; ++level) {
        const json_t *scale = verdict_of(&s, level, &verdict, &all);
        assert_true(json_is_true(json_object_get(scale, "held")));
        assert_true(json_is_true(json_object_get(scale, "has_effect")));
        assert_true(json_integer_value(json_object_get(scale, "scaled_voxels")) > 0);
        assert_int_equal(json_integer_value(json_object_get(scale, "differing_voxels")), 0);
        if (level == 1) /* directions of level 2 are too far off, scaled or not */
            assert_string_equal(verdict, "agree");
        assert_at_most(dissimilarity(&s, "moments+scaled", level), 0.95 * dissimilarity(&s, "moments+adapted", level));
    }
}

/* Planted: level 1 is handed over with the bytes of level 2, each for the eight voxels that it is the mean of. */
TEST(the_scale_of_another_level_is_rejected)
{
    ENDED_BY(close_subject) subject s;
    const char *verdict;
    iso_levels_summary all;
    open_scaled(&s, "other");
    iso_level_tf *tfs = s.validation.level_tfs;
    const size_t *fine = s.pyramid.levels[1].geometry.size, *coarse = s.pyramid.levels[2].geometry.size;
    for (size_t i = 0; i < fine[0] * fine[1] * fine[2]; ++i) {
        const size_t x = i % fine[0] / 2, y = i / fine[0] % fine[1] / 2, z = i / (fine[0] * fine[1]) / 2;
        tfs[1].extinction_scale[i] = tfs[2].extinction_scale[x + coarse[0] * (y + coarse[1] * z)];
    }
    measure_levels(&s);
    const json_t *scale = verdict_of(&s, 1, &verdict, &all);
    assert_string_equal(verdict, "differ");
    assert_true(json_integer_value(json_object_get(scale, "differing_voxels")) > 0);
    assert_true(json_is_false(json_object_get(scale, "held")));
    assert_non_null(strstr(all.sentence, "Level 1: its extinction scale differs from one made of level 0"));
    assert_true(json_is_true(json_object_get(verdict_of(&s, 2, &verdict, &all), "held")));
}

/* The picture that would be without. */
static iso_status pass_over_scale(const void *user, const iso_render_request *request, iso_image *image, iso_error *e)
{
    iso_render_request plain = *request;
    iso_view view = *request->view; /* lent */
    iso_image without = {0};
    (void)user;
    if (!view.extinction_scale)
        return ISO_OK;
    view.extinction_scale = NULL;
    plain.view = &view;
    const iso_status status = iso_render_with(&plain, &without, NULL, e);
    if (status == ISO_OK)
        memcpy(image->rgba, without.rgba, 4 * image->width * image->height * sizeof *image->rgba);
    iso_image_destroy(&without);
    return status;
}

/* Planted: the renderer passes the bytes over. */
TEST(a_scale_that_is_not_used_is_rejected)
{
    ENDED_BY(close_subject) subject s;
    const char *verdict;
    iso_levels_summary all;
    open_scaled(&s, "unused");
    s.validation.renderers.after = (iso_image_hook){pass_over_scale, NULL};
    measure_levels(&s);
    renderers.after = (iso_image_hook){0};
    const json_t *scale = verdict_of(&s, 1, &verdict, &all);
    assert_string_equal(verdict, "differ");
    assert_int_equal(json_integer_value(json_object_get(scale, "differing_voxels")), 0);
    assert_true(json_is_false(json_object_get(scale, "has_effect")));
    assert_non_null(strstr(all.sentence, "Level 1: its extinction scale changes no picture"));
}

/* ---- a budget, and the progress ---- */

/* The budget is over when so many pictures are drawn. */
typedef struct budget_of_pictures {
    iso_validation *validation;
    size_t most, drawn;
    bool leaves_open; /* every other picture of stored directions is white, which may be chance */
} budget_of_pictures;

static iso_status count_picture(const void *user, const iso_render_request *request, iso_image *image, iso_error *e)
{
    budget_of_pictures *b = (budget_of_pictures *)user;
    (void)e;
    if (b->leaves_open && b->drawn % 2 == 0 && request->level > 0 && request->options->source == ISO_FROM_CODES)
        for (size_t i = 0; i < 4 * image->width * image->height; ++i)
            image->rgba[i] = 1;
    if (++b->drawn == b->most)
        b->validation->deadline = 1e-9; /* long ago, by a clock that runs */
    return ISO_OK;
}

/* more_views: levels that are open may have them, and are open. Returns the pictures that were drawn. */
static size_t measure_within(subject *s, const char *name, size_t most_pictures, bool more_views)
{
    open_subject(s, ISO_FIELD_SHELLS, name);
    budget_of_pictures b = {.validation = &s->validation, .most = most_pictures, .leaves_open = more_views};
    s->validation.budget_seconds = 1;
    s->validation.may_add_views = more_views;
    s->validation.renderers.after = (iso_image_hook){count_picture, &b};
    measure_levels(s);
    renderers.after = (iso_image_hook){0};
    return b.drawn;
}

/* "consistency, bounds of levels": the stages that the budget left out. */
static void expect_left_out(const subject *s, const char *wanted)
{
    char found[256] = "";
    json_t *row;
    size_t i;
    json_array_foreach(json_object_get(iso_report_json(s->validation.report), "agreement"), i, row)
    {
        assert_string_equal(iso_row_text(row, "not_compared"), "budget");
        iso_words_append(found, sizeof found, "%s%s", i > 0 ? ", " : "", iso_row_text(row, "variant"));
    }
    assert_string_equal(found, wanted);
}

static const json_t *levels_of(const subject *s)
{
    return json_object_get(iso_report_json(s->validation.report), "levels");
}

TEST(a_budget_ends_between_two_views)
{
    subject s;
    assert_int_equal(measure_within(&s, "one view", 1, false), 1);
    assert_int_equal(json_array_size(rows_of(&s)), 0);
    expect_left_out(&s, "consistency");
    close_subject(&s);
    assert_int_equal(measure_within(&s, "half a row", 3 * views + 1, false), 3 * views + 1);
    assert_int_equal(json_array_size(rows_of(&s)), 2); /* and not a third one of a view alone */
    assert_int_equal(json_array_size(levels_of(&s)), 0);
    expect_left_out(&s, "consistency");
    close_subject(&s);
}

/* With all that the verdict needs it is given; otherwise it names the missing part. */
VALUES_TEST(a_budget_leaves_out_bounds_and_more_views)
{
    subject s;
    const size_t all = measure_within(&s, "all", SIZE_MAX, false);
    assert_int_equal(json_array_size(levels_of(&s)), levels - 1);
    assert_non_null(json_object_get(json_array_get(levels_of(&s), 0), "bound"));
    expect_left_out(&s, "");
    close_subject(&s);
    assert_int_equal(measure_within(&s, "no bound", all, false), all);
    assert_int_equal(json_array_size(levels_of(&s)), levels - 1);
    for (size_t i = 0; i + 1 < levels; ++i)
        assert_null(json_object_get(json_array_get(levels_of(&s), i), "bound"));
    expect_left_out(&s, "bounds of levels");
    close_subject(&s);
    assert_more_than((double)measure_within(&s, "more", SIZE_MAX, true), (double)(all + 2 * ISO_FACE_VIEWS));
    close_subject(&s);
    assert_int_equal(measure_within(&s, "no more", all + 1, true), all + 1);
    assert_int_equal(json_array_size(levels_of(&s)), levels - 1);
    expect_left_out(&s, "more views of levels, bounds of levels");
    close_subject(&s);
}

/* What was reported: each stage by its first report, and how often the verdict said how far it is. */
TEST_MAIN(make_folder, end_renderers_and_folder)
