/* SPDX-License-Identifier: MIT */
/* Numbers in saved JSON are read back as the same doubles but for the rounding of computations, and are short. */
#include "test.h"

#include <float.h>

#include "base/file.h"
#include "base/json.h"
#include "folder.h"
#include "property.h"

static char *saved(json_t *root)
{
    char path[4096], *text = NULL;
    size_t size;
    iso_error err = {""};
    snprintf(path, sizeof path, "%s/a.json", folder);
    assert_int_equal(iso_json_save(path, root, &err), ISO_OK);
    assert_int_equal(iso_file_read(path, &text, &size, &err), ISO_OK);
    return text;
}

static double read_back(double value)
{
    json_auto_t *root = json_pack("{s:f}", "a", value), *again = NULL;
    FREED char *text = saved(root);
    iso_error err = {""};
    assert_int_equal(iso_json_parse("a.json", text, strlen(text), &again, &err), ISO_OK);
    assert_true(json_is_real(json_object_get(again, "a")));
    const double result = json_real_value(json_object_get(again, "a"));
    return result;
}

TEST(all_doubles_come_back)
{
    static const double values[] = {0,       -0.0,    1,       0.1,     0.3,       1.0 / 3,           -2.0 / 3, 1e22, 123456789,
                                    1e15 / 7, 1e-7 / 3, DBL_MAX, DBL_MIN, 4.9406564584124654e-324, 1e6 + 1e-3};
    for (size_t i = 0; i < sizeof values / sizeof *values; ++i) {
        const double again = read_back(values[i]); /* none is a float of more than nine digits */
        assert_true(fabs(again - values[i]) <= 4 * DBL_EPSILON * fabs(values[i]));
        assert_int_equal(signbit(again), signbit(values[i]));
    }
}

/* Editors of Windows write a byte order mark. In the middle of a text it is a fault. */
TEST(a_byte_order_mark_is_skipped)
{
    static const char marked[] = "\xef\xbb\xbf{\"a\": 1}", within[] = "{\xef\xbb\xbf\"a\": 1}";
    json_t *root;
    assert_ok(iso_json_parse("a.json", marked, sizeof marked - 1, &root, &err));
    assert_int_equal(json_integer_value(json_object_get(root, "a")), 1);
    json_decref(root);
    assert_status(iso_json_parse("a.json", within, sizeof within - 1, &root, &err), ISO_E_FORMAT);
    assert_status(iso_json_parse("a.json", marked, 3, &root, &err), ISO_E_FORMAT);
}

TEST(texts_stay_and_numbers_are_short)
{
    json_auto_t *root = json_pack("{s:s, s:f, s:i, s:[f, f]}", "1.10000000000000001", "\"0.10000000000000001\\", "b",
                                  0.1, "c", 12, "d", 6.500000000000001, (double)0.7f);
    FREED char *text = saved(root);
    assert_string_equal(text, "{\n  \"1.10000000000000001\": \"\\\"0.10000000000000001\\\\\",\n  \"b\": 0.1,\n  \"c\": 12,\n"
                              "  \"d\": [\n    6.5,\n    0.699999988\n  ]\n}\n");
}

TEST_MAIN(make_folder, remove_folder)
