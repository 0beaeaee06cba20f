/* SPDX-License-Identifier: MIT */
/* The front of cost and error, and the choice on it. */
#include "base/random.h"
#include "chart/pareto.h"
#include "tests/test.h"

TEST(the_front_holds_what_nothing_beats)
{
    /*                      on       on      beaten   on       equal    beaten by equal cost */
    const double cost[] = {1.0, 2.0, 2.5, 4.0, 4.0, 2.0};
    const double error[] = {0.9, 0.5, 0.6, 0.1, 0.1, 0.7};
    const bool wanted[] = {true, true, false, true, true, false};
    bool front[6];
    iso_pareto_front(cost, error, 6, front);
    for (int i = 0; i < 6; ++i)
        assert_int_equal(front[i], wanted[i]);
}

TEST(what_is_not_a_number_is_never_on_the_front)
{
    const double cost[] = {NAN, 1, INFINITY, 2}, error[] = {0, NAN, 0, 0.5};
    bool front[4];
    iso_pareto_front(cost, error, 4, front);
    assert_true(!front[0] && !front[1] && !front[2] && front[3]);
    assert_int_equal(iso_pareto_choose(cost, cost, error, 4, 1), 3);
    assert_int_equal(iso_pareto_choose(cost, cost, error, 4, NAN), 4);
}

TEST(the_cheapest_that_is_good_enough_is_chosen)
{
    const double cost[] = {1, 2, 3, 2}, tie[] = {0, 7, 0, 5}, error[] = {0.9, 0.5, 0.1, 0.4};
    assert_int_equal(iso_pareto_choose(cost, tie, error, 4, 1), 0);
    assert_int_equal(iso_pareto_choose(cost, tie, error, 4, 0.5), 3); /* equal cost, smaller tie */
    assert_int_equal(iso_pareto_choose(cost, tie, error, 4, 0.1), 2); /* the limit itself is allowed */
    assert_int_equal(iso_pareto_choose(cost, tie, error, 4, 0.09), 4);
    assert_int_equal(iso_pareto_choose(cost, tie, error, 0, 1), 0);
}

/* ---- random points, against the definition -------------------------------------------- */

enum { MOST = 200 };

/* Few values, so that costs and errors tie often; some are not finite. */
static double random_figure(iso_random *r)
{
    const double u = iso_random_unit(r);
    return u < 0.03 ? NAN : u < 0.05 ? INFINITY : floor(25 * iso_random_unit(r)) / 8;
}

/* The front by another way than pareto.c's: a point is beaten when the least error among strictly cheaper points is at
 * most its own, or when one of equal cost has less. */
static bool is_worth_having(const double *cost, const double *error, size_t count, size_t i)
{
    double cheaper = INFINITY, equal = INFINITY;
    for (size_t j = 0; j < count; ++j) {
        if (!isfinite(error[j]) || !isfinite(cost[j]))
            continue;
        if (cost[j] < cost[i])
            cheaper = fmin(cheaper, error[j]);
        else if (cost[j] == cost[i])
            equal = fmin(equal, error[j]);
    }
    return isfinite(cost[i]) && isfinite(error[i]) && error[i] < cheaper && error[i] <= equal;
}

static size_t count_wrong(const double *cost, const double *error, const bool *front, size_t count)
{
    size_t wrong = 0;
    for (size_t i = 0; i < count; ++i)
        wrong += front[i] != is_worth_having(cost, error, count, i);
    return wrong;
}

/* Planted faults: a front that takes no notice of ties in cost, one that lets the infinite in, one that drops a
 * point. */
static void plant(int fault, const double *cost, const double *error, size_t count, bool *front)
{
    for (size_t i = 0; i < count; ++i) {
        bool beaten = false;
        for (size_t j = 0; j < count; ++j)
            beaten = beaten || (cost[j] < cost[i] && error[j] < error[i]);
        if (fault == 0 && isfinite(cost[i]) && isfinite(error[i]))
            front[i] = !beaten;
        if (fault == 1 && isinf(cost[i]))
            front[i] = true;
        if (fault == 2 && front[i]) {
            front[i] = false;
            return;
        }
    }
}

TEST(random_fronts_follow_the_definition)
{
    iso_random r = {20};
    double cost[MOST], error[MOST], tie[MOST];
    bool front[MOST];
    size_t found[3] = {0};
    for (int round = 0; round < 200; ++round) {
        const size_t count = 1 + (size_t)(iso_random_unit(&r) * (MOST - 1));
        for (size_t i = 0; i < count; ++i) {
            cost[i] = random_figure(&r);
            error[i] = random_figure(&r);
            tie[i] = iso_random_unit(&r);
        }
        iso_pareto_front(cost, error, count, front);
        assert_int_equal(count_wrong(cost, error, front, count), 0);

        const double limit = 3 * iso_random_unit(&r);
        const size_t chosen = iso_pareto_choose(cost, tie, error, count, limit);
        for (size_t i = 0; i < count; ++i)
            if (error[i] <= limit && isfinite(cost[i])) {
                assert_true(chosen < count && error[chosen] <= limit && cost[chosen] <= cost[i]);
                assert_true(cost[chosen] < cost[i] || tie[chosen] <= tie[i]);
            }
        for (int fault = 0; fault < 3; ++fault) {
            iso_pareto_front(cost, error, count, front);
            plant(fault, cost, error, count, front);
            found[fault] += count_wrong(cost, error, front, count) > 0;
        }
    }
    for (int fault = 0; fault < 3; ++fault)
        assert_true(found[fault] > 100); /* of 200 sets; small ones may have neither a tie nor an infinity */
}

/* The cheapest by error, ties broken by time, is on the front: what `--want` names lies on it. */
TEST(what_is_chosen_lies_on_the_front)
{
    iso_random r = {21};
    double cost[50], error[50];
    bool front[50];
    for (int round = 0; round < 200; ++round) {
        for (size_t i = 0; i < 50; ++i) {
            cost[i] = random_figure(&r);
            error[i] = random_figure(&r);
        }
        iso_pareto_front(cost, error, 50, front);
        const size_t chosen = iso_pareto_choose(cost, error, error, 50, 3 * iso_random_unit(&r));
        assert_true(chosen == 50 || front[chosen]);
    }
}

TEST_MAIN(NULL, NULL)
