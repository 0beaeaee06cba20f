/* test_atlas.c - every failure of the atlas is still one, and every fallback still mends it. */
#include "cli/atlas.h"
#include "test.h"

static void every_failure_and_every_fallback_stands(void **state)
{
    (void)state;
    for (size_t i = 0; i < iso_atlas_case_count; ++i) {
        const iso_atlas_case *c = &iso_atlas_cases[i];
        iso_atlas_result r;
        assert_ok(iso_atlas_run(c, &r, &err));
        printf("%-20s failure %-9.3g fallback %-9.3g\n", c->id, r.bad, r.good);
        assert_more_than(r.bad, c->bad_at_least);
        assert_at_most(r.good, c->good_at_most);
        assert_true(iso_atlas_stands(c, &r));
        /* A cured failure and a broken fallback would both be noticed. */
        iso_atlas_result cured = {.bad = r.good, .good = r.good}, broken = {.bad = r.bad, .good = r.bad};
        assert_false(iso_atlas_stands(c, &cured));
        assert_false(iso_atlas_stands(c, &broken));
        iso_atlas_clear(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_failure_and_every_fallback_stands)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
