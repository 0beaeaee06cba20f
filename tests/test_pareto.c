/* The front of cost and error, and the choice on it. */
#include <math.h>

#include "compare/pareto.h"
#include "tests/test.h"

static void the_front_holds_what_nothing_beats(void **state)
{
    (void)state;
    /*                      on       on      beaten   on       equal    beaten by equal cost */
    const double cost[] = {1.0, 2.0, 2.5, 4.0, 4.0, 2.0};
    const double error[] = {0.9, 0.5, 0.6, 0.1, 0.1, 0.7};
    const bool wanted[] = {true, true, false, true, true, false};
    bool front[6];
    iso_pareto_front(cost, error, 6, front);
    for (int i = 0; i < 6; ++i)
        assert_int_equal(front[i], wanted[i]);
}

static void what_is_not_a_number_is_never_on_the_front(void **state)
{
    (void)state;
    const double cost[] = {NAN, 1, INFINITY, 2}, error[] = {0, NAN, 0, 0.5};
    bool front[4];
    iso_pareto_front(cost, error, 4, front);
    assert_true(!front[0] && !front[1] && !front[2] && front[3]);
    assert_int_equal(iso_pareto_choose(cost, cost, error, 4, 1), 3);
    assert_int_equal(iso_pareto_choose(cost, cost, error, 4, NAN), 4);
}

static void the_cheapest_that_is_good_enough_is_chosen(void **state)
{
    (void)state;
    const double cost[] = {1, 2, 3, 2}, tie[] = {0, 7, 0, 5}, error[] = {0.9, 0.5, 0.1, 0.4};
    assert_int_equal(iso_pareto_choose(cost, tie, error, 4, 1), 0);
    assert_int_equal(iso_pareto_choose(cost, tie, error, 4, 0.5), 3); /* equal cost, smaller tie */
    assert_int_equal(iso_pareto_choose(cost, tie, error, 4, 0.1), 2); /* the limit itself is allowed */
    assert_int_equal(iso_pareto_choose(cost, tie, error, 4, 0.09), 4);
    assert_int_equal(iso_pareto_choose(cost, tie, error, 0, 1), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_front_holds_what_nothing_beats),
        cmocka_unit_test(what_is_not_a_number_is_never_on_the_front),
        cmocka_unit_test(the_cheapest_that_is_good_enough_is_chosen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
