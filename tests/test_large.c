/* SPDX-License-Identifier: MIT */
/* Large buffers are whole. */
#include <stdlib.h>
#include <string.h>

#include "base/large.h"
#include "tests/test.h"

enum { MIB = 1 << 20 };

static void every_byte_can_be_written(void **state)
{
    (void)state;
    static const size_t sizes[] = {1, 4095, 2 * MIB, 4 * MIB - 1, 4 * MIB, 4 * MIB + 1, 7 * MIB + 3};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        unsigned char *p = iso_large_alloc(sizes[i]);
        assert_non_null(p);
        memset(p, (int)i + 1, sizes[i]);
        assert_int_equal(p[0], i + 1);
        assert_int_equal(p[sizes[i] - 1], i + 1);
        free(p);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_byte_can_be_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
