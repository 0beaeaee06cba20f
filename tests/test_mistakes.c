/* SPDX-License-Identifier: MIT */
/* Mistakes of renderers are named: those of the pictures that the search draws itself, those that are planted into
 * renderers by other code (faults.h), and none of a right renderer. */
#include "test.h"
#include "validate/mistakes.h"

static iso_renderers renderers;

static void look(const size_t *numbers, size_t count, iso_mistakes *found)
{
    iso_image pictures[ISO_CALIBRATION_COUNT];
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i)
        assert_ok(iso_mistakes_draw(i, numbers, count, 0, &pictures[i], &err));
    assert_ok(iso_mistakes_of_pictures(pictures, 0, found, &err));
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i)
        iso_image_destroy(&pictures[i]);
}

static bool holds(const iso_mistakes *found, size_t number)
{
    for (size_t i = 0; i < found->count; ++i)
        if (found->numbers[i] == number)
            return true;
    return false;
}

TEST(mistakes_are_named)
{
    for (size_t m = 0; iso_mistake_name(m); m += ISO_SANITIZED ? 16 : 4) { /* check_mistakes.sh has others */
        iso_mistakes found;
        look(&m, 1, &found);
        if (found.count != 1 || !holds(&found, m))
            fail_msg("\"%s\" is taken for %zu: %s", iso_mistake_name(m), found.count,
                     found.count ? iso_mistake_name(found.numbers[0]) : "none");
        assert_within(found.explained, 1, 1e-9); /* the same arithmetic */
    }
}

static size_t number_of(const char *words)
{
    for (size_t m = 0; iso_mistake_name(m); ++m)
        if (strstr(iso_mistake_name(m), words))
            return m;
    fail_msg("no mistake is called \"%s\"", words);
    return 0;
}

VALUES_TEST(pairs_are_named)
{
    static const char *const pairs[][2] = {{"half a voxel off along x", "10 % more length"},
                                           {"multiplied by alpha twice", "lit on one side"},
                                           {"red and blue", "the bottom one"}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; ++i) {
        const size_t numbers[2] = {number_of(pairs[i][0]), number_of(pairs[i][1])};
        iso_mistakes found;
        look(numbers, 2, &found);
        if (found.count != 2 || !holds(&found, numbers[0]) || !holds(&found, numbers[1]))
            fail_msg("%s and %s are taken for %zu: %s, %s", pairs[i][0], pairs[i][1], found.count,
                     found.count ? iso_mistake_name(found.numbers[0]) : "none",
                     found.count > 1 ? iso_mistake_name(found.numbers[1]) : "none");
    }
}

/* Pictures without a mistake are explained by nothing, and by no mistake that would change them. */
TEST(a_right_renderer_has_none)
{
    const char *const names[] = {"reference", "cpu"};
    for (size_t i = 0; i < 2; ++i) {
        const iso_renderer_info *which;
        iso_mistakes found;
        iso_mistake_pictures shown;
        assert_ok(iso_renderer_from_name(names[i], &which, &err));
        assert_ok(iso_mistakes_find(&renderers, which, 0, &found, &shown, &err));
        assert_int_equal(found.count, 0);
        assert_null(shown.got.rgba);
    }
}

/* A picture that no mistake explains: a dark spot in each. */
VALUES_TEST(another_difference_is_not_named)
{
    iso_image pictures[ISO_CALIBRATION_COUNT];
    iso_mistakes found;
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i) {
        assert_ok(iso_mistakes_draw(i, NULL, 0, 0, &pictures[i], &err));
        for (size_t row = 12; row < 20; ++row)
            for (size_t column = 10; column < 22; ++column)
                memset(pictures[i].rgba + 4 * (row * pictures[i].width + column), 0, 4 * sizeof(float));
    }
    assert_ok(iso_mistakes_of_pictures(pictures, 0, &found, &err));
    assert_int_equal(found.count, 0);
    for (int i = 0; i < ISO_CALIBRATION_COUNT; ++i)
        iso_image_destroy(&pictures[i]);
}

TEST_MAIN(NULL, NULL)
