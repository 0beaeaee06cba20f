/* SPDX-License-Identifier: MIT */
/* Arrays of a page: zlib, which browsers inflate with, gives back the bytes in the order that pack.h says, as they are
 * and as differences; what packs better was chosen. */
#include "test.h"

#include <zlib.h>

#include "view/pack.h"

enum { COUNT = 70001, COMPONENTS = 3, WIDTH = 2, BYTES = COUNT * COMPONENTS * WIDTH };

/* Steadily rising numbers, whose differences are one number each. */
static uint32_t rising(const void *of, size_t i, size_t c)
{
    (void)of;
    return (uint32_t)(i * (c + 7));
}

/* Two numbers without a pattern, whose differences are three. */
static uint32_t scattered(const void *of, size_t i, size_t c)
{
    (void)of;
    return (((uint32_t)(i + 77 * c) * 2654435761U) >> 31) * 40000;
}

static void assert_comes_back(uint32_t (*number)(const void *, size_t, size_t), bool delta)
{
    const iso_pack_array array = {COUNT, COMPONENTS, WIDTH, number, NULL};
    iso_packed packed;
    unsigned char *bytes = malloc(BYTES), *at = bytes;
    uLongf size = BYTES;
    assert_ok(iso_pack(&array, &packed, &err));
    assert_int_equal(packed.delta, delta);
    assert_int_equal(uncompress(bytes, &size, packed.bytes, packed.size), Z_OK);
    assert_int_equal(size, BYTES);
    for (size_t c = 0; c < COMPONENTS; ++c)
        for (size_t weight = 0; weight < WIDTH; ++weight)
            for (size_t i = 0; i < COUNT; ++i) {
                const uint32_t before = delta && i > 0 ? number(NULL, i - 1, c) : 0;
                assert_int_equal(*at++, (number(NULL, i, c) - before) >> (8 * weight) & 0xff);
            }
    free(bytes);
    free(packed.bytes);
}

TEST(differences_of_rising_numbers_come_back)
{
    assert_comes_back(rising, true);
}

TEST(scattered_numbers_come_back_as_they_are)
{
    assert_comes_back(scattered, false);
}

TEST(no_voxels_are_an_empty_stream)
{
    const iso_pack_array array = {0, 1, 1, rising, NULL};
    iso_packed packed;
    unsigned char byte;
    uLongf size = 1;
    assert_ok(iso_pack(&array, &packed, &err));
    assert_int_equal(uncompress(&byte, &size, packed.bytes, packed.size), Z_OK);
    assert_int_equal(size, 0);
    free(packed.bytes);
}

TEST_MAIN(NULL, NULL)
