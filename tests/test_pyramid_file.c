/* SPDX-License-Identifier: MIT */
/* Pyramids on disk: as they were, and refused where they are damaged. */
#include "folder.h"
#include "test.h"

#include <unistd.h>
#include <xxhash.h>

#include "base/file.h"
#include "pyramids.h"
#include "same_levels.h"

/* ---- files ---- */

TEST(a_saved_pyramid_is_loaded_as_it_was)
{
    const iso_type types[] = {ISO_U8, ISO_I16, ISO_U16, ISO_F32, ISO_F64};
    FREED char *dir = iso_path_join(folder, "trip.iso");
    for (size_t t = 0; t < sizeof types / sizeof *types; ++t) {
        iso_geometry g = plain(7, 5, 6);
        g.index_to_world.m[0][1] = 1.0 / 3;
        OWNED(iso_volume) v;
        assert_ok(iso_volume_create(&v, &g, types[t], "test", &err));
        for (size_t i = 0; i < 210 * iso_type_bytes(types[t]); ++i)
            ((uint8_t *)v.data)[i] = types[t] == ISO_F32 || types[t] == ISO_F64 ? 0x3f : (uint8_t)(i * 91);
        iso_pyramid_options opt = keeping((iso_direction_filter)(t % ISO_DIRECTION_COUNT));
        opt.keep_float = t % 2;
        opt.code = t % 2 ? ISO_CODE_REGION48 : ISO_CODE_SNORM;
        OWNED(iso_pyramid) p = build(&v, &opt), q;
        assert_ok(iso_pyramid_save(&p, dir, &err)); /* and replaces the one before */
        assert_true(iso_pyramid_is_one(dir));
        assert_ok(iso_pyramid_load(dir, &q, &err));
        assert_true(same_levels(&p, &q));
        assert_string_equal(p.source, q.source);
        q.options.threads = p.options.threads; /* not a property of the result */
        assert_int_equal(q.options.direction_filter, p.options.direction_filter);
        assert_int_equal(q.options.code, p.options.code);
        assert_true(q.options.keep_float == p.options.keep_float && q.options.keep_magnitude);
    }
}

/* Files of more than one of the pieces of 256 kB that are read at a time, none of which they fill at their end: 98153
 * voxels. */
TEST(files_of_several_pieces_are_loaded_as_they_were)
{
    FREED char *dir = iso_path_join(folder, "long.iso");
    OWNED(iso_volume) v = noise(53, 47, 43);
    iso_pyramid_options opt = keeping(ISO_DIRECTION_MOMENTS);
    opt.keep_float = true;
    OWNED(iso_pyramid) p = build(&v, &opt), q;
    assert_ok(iso_pyramid_save(&p, dir, &err));
    assert_ok(iso_pyramid_load(dir, &q, &err));
    assert_true(same_levels(&p, &q));
    q.levels[0].codes[(256 << 10) + 1] ^= 1; /* noticed, behind the first piece too */
    assert_false(same_levels(&p, &q));
}

/* Applies a change to one file of a fresh pyramid, and wants the load to fail. */
static void refuse(const char *name, size_t keep_bytes, long flip_at, iso_status wanted)
{
    OWNED(iso_volume) v = noise(6, 5, 4);
    iso_pyramid_options opt = iso_pyramid_defaults();
    OWNED(iso_pyramid) p = build(&v, &opt), q;
    FREED char *dir = iso_path_join(folder, "bad.iso"), *path, *data;
    size_t size;
    iso_remove_tree(dir); /* a folder that was changed is not replaced */
    assert_ok(iso_pyramid_save(&p, dir, &err));
    assert_ok(iso_pyramid_load(dir, &q, &err));
    iso_pyramid_destroy(&q);
    path = iso_path_join(dir, name);
    assert_ok(iso_file_read(path, &data, &size, &err));
    if (flip_at >= 0)
        data[flip_at] ^= 4;
    assert_ok(iso_file_write(path, data, keep_bytes ? keep_bytes : size, &err));
    if (keep_bytes == 0 && flip_at < 0)
        unlink(path);
    assert_status(iso_pyramid_load(dir, &q, &err), wanted);
}

TEST(truncated_tampered_and_missing_files_are_refused)
{
    refuse("level_0.nrrd", 400, -1, ISO_E_FORMAT);
    refuse("level_1_dir.nrrd", 300, -1, ISO_E_FORMAT);
    refuse("level_0.nrrd", 0, 500, ISO_E_FORMAT);
    refuse("level_0_dir.nrrd", 0, 20, ISO_E_FORMAT);
    refuse("level_1.nrrd", 0, -1, ISO_E_IO);
    refuse("pyramid.json", 100, -1, ISO_E_FORMAT);
    refuse("pyramid.json", 0, 30, ISO_E_FORMAT); /* the schema's name */
}

/* As a careful forger leaves it: of the text with zeros in the checksum's place, which is the last word of 16
 * digits. */
static void put_fitting_checksum(char *text, size_t size)
{
    char *place = NULL, digits[17];
    for (char *at = text; (at = strstr(at, "\"xxh3_64\": \"")); ++at)
        place = at + strlen("\"xxh3_64\": \"");
    memset(place, '0', 16);
    snprintf(digits, sizeof digits, "%016llx", (unsigned long long)XXH3_64bits(text, size));
    memcpy(place, digits, 16);
}

TEST(a_description_with_impossible_values_is_refused)
{
    const struct {
        const char *from, *to;
        iso_status status;
    } changes[] = {
        {"\"moments\"", "\"moment!\"", ISO_E_FORMAT}, {"\"float\"", "\"flint\"", ISO_E_USAGE},
        {"\"float\"", "\"int32\"", ISO_E_FORMAT},     {"\"level_1.nrrd\"", "\"../el_1.nrrd\"", ISO_E_FORMAT},
        {"\"fit\"", "\"fat\"", ISO_E_FORMAT},         {"\"box_index\"", "\"box_indey\"", ISO_E_FORMAT},
        {"\"size\": [", "\"size\": [6.5, 5, 4], \"six\": [", ISO_E_FORMAT},
        {"\"bytes\": ", "\"bytes\": 1", ISO_E_FORMAT},
        {"\"keep_float\"", "\"value_range\": [65419, 0], \"keep_float\"", ISO_E_FORMAT},
        {"\"keep_float\"", "\"value_range\": [7, 7], \"keep_float\"", ISO_E_FORMAT},
        {"\"options\"", "\"made_for\": {\"levels\": [{\"scalar\": \"\\u001b[2J\"}]}, \"options\"", ISO_E_FORMAT},
        {"\"options\"", "\"segments\": [1], \"options\"", ISO_E_FORMAT},
        {"\"options\"", "\"segments\": [{\"label\": 1.5, \"name\": \"a\"}], \"options\"", ISO_E_FORMAT},
        {"\"options\"", "\"segments\": [{\"label\": 4294967296, \"name\": \"a\"}], \"options\"", ISO_E_FORMAT},
        {"\"options\"", "\"segments\": [{\"label\": 1}], \"options\"", ISO_E_FORMAT},
        {"\"options\"", "\"segments\": [{\"label\": 1, \"name\": \"a\\nb\"}], \"options\"", ISO_E_FORMAT},
        {"\"options\"", "\"segments\": [{\"label\": 1, \"name\": \"a\", \"color\": [0, 0]}], \"options\"",
         ISO_E_FORMAT},
        {"\"options\"", "\"segments\": [{\"label\": 1, \"name\": \"a\", \"color\": [0, 2, 0]}], \"options\"",
         ISO_E_RANGE},
    };
    OWNED(iso_volume) v = noise(6, 5, 4);
    iso_pyramid_options opt = iso_pyramid_defaults();
    iso_pyramid p = build(&v, &opt), q;
    char *dir = iso_path_join(folder, "odd.iso"), *path = iso_path_join(dir, "pyramid.json"), *text;
    size_t size;
    for (size_t c = 0; c < sizeof changes / sizeof *changes; ++c) {
        iso_remove_tree(dir); /* a folder that was changed is not replaced */
        assert_ok(iso_pyramid_save(&p, dir, &err));
        assert_ok(iso_file_read(path, &text, &size, &err));
        char *at = strstr(text, changes[c].from), changed[16384];
        assert_non_null(at);
        int n = snprintf(changed, sizeof changed, "%.*s%s%s", (int)(at - text), text, changes[c].to,
                         at + strlen(changes[c].from));
        iso_error why = {""};
        assert_ok(iso_file_write(path, changed, (size_t)n, &err));
        assert_int_equal(iso_pyramid_load(dir, &q, &why), ISO_E_FORMAT); /* the checksum tells */
        assert_non_null(strstr(why.text, "was changed since"));
        why.text[0] = 0;
        put_fitting_checksum(changed, (size_t)n);
        assert_ok(iso_file_write(path, changed, (size_t)n, &err));
        iso_status status = iso_pyramid_load(dir, &q, &why);
        assert_null(strstr(why.text, "was changed since"));
        assert_true(status == changes[c].status || status == ISO_E_FORMAT);
        assert_true(why.text[0] != 0);
        free(text);
    }
    free(path);
    free(dir);
    iso_pyramid_destroy(&p);
}

TEST(a_folder_that_is_not_a_pyramid_is_left_alone)
{
    OWNED(iso_volume) v = noise(3, 3, 3);
    iso_pyramid_options opt = iso_pyramid_defaults();
    iso_pyramid p = build(&v, &opt), q;
    FREED char *inside = iso_path_join(folder, "precious.txt");
    assert_ok(iso_file_write(inside, "x", 1, &err));
    assert_status(iso_pyramid_save(&p, folder, &err), ISO_E_IO);
    assert_true(iso_path_exists(inside));
    assert_false(iso_pyramid_is_one(folder));
    assert_status(iso_pyramid_load(folder, &q, &err), ISO_E_IO);
    iso_pyramid_destroy(&p);
}

TEST_MAIN(make_folder, remove_folder)
