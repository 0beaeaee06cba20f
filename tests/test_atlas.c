/* SPDX-License-Identifier: MIT */
/* test_atlas.c - every failure of the atlas is still one, and every fallback still corrects it: a test a case. */
#include "base/file.h"
#include "base/json.h"
#include "atlas/atlas.h"
#include "tests/folder.h"
#include "tests/test.h"

/* Between what was measured and its limit: room for another compiler's rounding, and for little else. */
static const double margin = 1.05;
/* Between the two limits: what is seen with the naked eye. */
static const double contrast = 1.3;

static void a_failure_and_its_fallback_stand(void **state)
{
    const iso_atlas_case *c = *state;
    iso_atlas_result r;
    assert_ok(iso_atlas_run(c, &r, &err));
    const double bad = r.values[ISO_ATLAS_FAILURE], good = r.values[ISO_ATLAS_FALLBACK];
    printf("%-20s failure %-9.3g fallback %-9.3g\n", c->id, bad, good);
    assert_more_than(bad, c->failure_at_least * margin);
    assert_at_most(good * margin, c->fallback_at_most);
    assert_more_than(c->failure_at_least, c->fallback_at_most * contrast);
    assert_true(iso_atlas_is_valid(c, &r));
    /* Planted: a failure that has disappeared, a fallback that changes nothing, figures that are no numbers. */
    iso_atlas_result gone = r, broken = r, none = r;
    gone.values[ISO_ATLAS_FAILURE] = good;
    broken.values[ISO_ATLAS_FALLBACK] = bad;
    none.values[ISO_ATLAS_FALLBACK] = NAN;
    assert_false(iso_atlas_is_valid(c, &gone));
    assert_false(iso_atlas_is_valid(c, &broken));
    assert_false(iso_atlas_is_valid(c, &none));
    /* Something is seen in each rendered picture but where the failure is that all has gone. */
    for (int w = 0; w < ISO_ATLAS_WAYS && !c->draw; ++w) {
        double brightest = 0;
        for (size_t i = 0; i < 4 * r.images[w].width * r.images[w].height; i += 4)
            brightest = fmax(brightest, (double)r.images[w].rgba[i]);
        assert_more_than(brightest, w == ISO_ATLAS_FAILURE ? -1. : 0.08);
    }
    iso_atlas_clear(&r);
}

/* A case runs what the option strings say: one that no command knows is refused. */
TEST(an_unknown_option_is_refused)
{
    iso_atlas_case c = iso_atlas_cases[0];
    iso_atlas_result r;
    c.ways[ISO_ATLAS_FALLBACK].build = "--shading-from sobel";
    assert_status(iso_atlas_run(&c, &r, &err), ISO_E_USAGE);
    c.ways[ISO_ATLAS_FALLBACK].build = "--estimator prewitt";
    assert_status(iso_atlas_run(&c, &r, &err), ISO_E_USAGE);
}

/* What the atlas writes for its reader is a scene file, of the same transfer function and camera. */
TEST(the_scene_is_a_scene_file)
{
    FREED char *path = iso_path_join(folder, "case.scene.json");
    for (size_t i = 0; i < iso_atlas_case_count; ++i) {
        const iso_atlas_scene *s = &iso_atlas_cases[i].scene;
        if (!s->field)
            continue;
        json_auto_t *json = iso_atlas_scene_to_json(s, "comment");
        OWNED(iso_scene) scene;
        assert_non_null(json);
        assert_ok(iso_json_save(path, json, &err));
        assert_ok(iso_scene_load(path, &scene, &err));
        assert_int_equal(scene.width, ISO_ATLAS_PIXELS);
        assert_int_equal(scene.tf.point_count, s->band ? 5 : 4);
        assert_within(scene.tf.points[1].value, s->lo, 0);
        assert_true(scene.orthographic && scene.height_mm > 1);
    }
}

TEST(ids_are_of_their_own)
{
    for (size_t i = 0; i < iso_atlas_case_count; ++i)
        assert_ptr_equal(iso_atlas_find(iso_atlas_cases[i].id), &iso_atlas_cases[i]);
    assert_null(iso_atlas_find("none"));
}

int main(void)
{
    for (size_t i = 0; i < iso_atlas_case_count; ++i)
        iso_add_case(__LINE__, (struct CMUnitTest){.name = ISO_SANITIZED && i % 2 ? NULL : iso_atlas_cases[i].id,
                                                   .test_func = a_failure_and_its_fallback_stand,
                                                   .initial_state = (void *)&iso_atlas_cases[i]});
    return run_cases(make_folder, remove_folder);
}
