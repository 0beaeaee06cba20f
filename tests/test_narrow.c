/* SPDX-License-Identifier: MIT */
/* What is exported of a pyramid without level 0 is what is exported of a whole one, byte for byte, and does not depend
 * on threads. */
#define _GNU_SOURCE
#include "test.h"

#include "base/file.h"
#include "povray/df3.h"
#include "pyramid/narrow.h"
#include "scene/subject.h"
#include "scene/visible.h"
#include "tf/tf.h"
#include "vdb/vdb.h"
#include "volume/synthetic.h"

/* More voxels along x than a node of OpenVDB above the leaves has. */
enum { NX = 150, NY = 40, NZ = 30, LEVELS = 2 };

typedef struct fixture {
    char *dir;
    iso_volume volume;
    iso_pyramid whole, narrow;
} fixture;

static void begin(fixture *f, iso_type type)
{
    const size_t size[3] = {NX, NY, NZ};
    iso_field field = {.kind = ISO_FIELD_NOISE,
                       .geometry = iso_geometry_axis_aligned(size, (double[]){1, 0.7, 1.5}),
                       .seed = 5};
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = LEVELS;
    if (type == ISO_I16) /* rows are stored in reverse */
        field.geometry.index_to_world = iso_mat3_scale(field.geometry.index_to_world, -1);
    *f = (fixture){.dir = iso_make_temp_dir()};
    assert_ok(iso_field_sample(&field, type, &f->volume, &err));
    assert_ok(iso_pyramid_build(&f->volume, "noise", &opt, &f->whole, NULL, &err));
    assert_ok(iso_pyramid_build_narrow(&f->volume, "noise", &opt, &f->narrow, NULL, &err));
}

static void end(fixture *f)
{
    iso_pyramid_destroy(&f->whole);
    iso_pyramid_destroy(&f->narrow);
    iso_volume_destroy(&f->volume);
    iso_remove_tree(f->dir);
    free(f->dir);
}

static const iso_type types[] = {ISO_U8, ISO_I16, ISO_I32, ISO_F32};

TEST(all_but_level_0_is_equal)
{
    for (size_t t = 0; t < sizeof types / sizeof *types; ++t) {
        fixture f;
        begin(&f, types[t]);
        assert_null(f.narrow.levels[0].scalar);
        assert_null(f.narrow.levels[0].codes);
        float row[NX];
        for (size_t k = 0; k < LEVELS; ++k) {
            const iso_level *a = &f.whole.levels[k], *b = &f.narrow.levels[k];
            const size_t width = a->geometry.size[0], rows = a->geometry.size[1] * a->geometry.size[2];
            assert_true(a->min == b->min && a->max == b->max);
            if (k > 0)
                assert_memory_equal(a->codes, b->codes, 3 * width * rows);
            for (size_t i = 0; i < rows; ++i) {
                iso_level_scalars(b, &f.volume, i * width, width, row);
                assert_memory_equal(row, a->scalar + i * width, width * sizeof *row);
            }
        }
        end(&f);
    }
}

/* The range of a pyramid of one level, which is not built but measured. */
TEST(the_range_of_one_level_is_equal)
{
    for (size_t t = 0; t < sizeof types / sizeof *types; ++t) {
        fixture f;
        OWNED(iso_pyramid) one;
        begin(&f, types[t]);
        iso_pyramid_options opt = f.whole.options;
        opt.level_count = 1;
        assert_ok(iso_pyramid_build_narrow(&f.volume, "noise", &opt, &one, NULL, &err));
        assert_int_equal(one.level_count, 1);
        assert_true(one.levels[0].min == f.whole.levels[0].min && one.levels[0].max == f.whole.levels[0].max);
        assert_int_equal(one.levels[0].stored_type, f.whole.levels[0].stored_type);
        end(&f);
    }
}

static size_t wrong_rows(const iso_narrow_codes *c, const iso_level *whole, const size_t first[3], const size_t end[3])
{
    size_t wrong = 0;
    for (size_t z = first[2]; z < end[2]; ++z)
        for (size_t y = first[1]; y < end[1]; ++y)
            wrong += memcmp(iso_narrow_codes_at(c, first[0], y, z), whole->codes + 3 * (first[0] + NX * (y + NY * z)),
                            3 * (end[0] - first[0])) != 0;
    return wrong;
}

/* Of each estimator, at each border and away from it. */
TEST(codes_of_a_box_are_those_of_the_level)
{
    const size_t boxes[][2][3] = {{{0, 0, 0}, {NX, NY, NZ}},  {{0, 0, 0}, {1, 1, 1}},      {{8, 0, 5}, {16, 8, 6}},
                                  {{NX - 1, NY - 2, NZ - 1}, {NX, NY, NZ}}, {{17, 9, 8}, {20, 11, 12}}, {{0, 0, 7}, {NX, NY, 9}}};
    for (int method = 0; method < ISO_GRADIENT_COUNT; ++method) {
        fixture f;
        OWNED(iso_pyramid) whole;
        OWNED(iso_narrow_codes) codes;
        begin(&f, method % 2 ? ISO_U8 : ISO_F32);
        f.narrow.options.gradient.method = (iso_gradient_method)method;
        assert_ok(iso_pyramid_build(&f.volume, "noise", &f.narrow.options, &whole, NULL, &err));
        assert_ok(iso_narrow_codes_begin(&codes, &f.narrow, &f.volume, &err));
        for (size_t b = 0; b < sizeof boxes / sizeof *boxes; ++b) {
            const size_t *first = boxes[b][0], *last = boxes[b][1];
            assert_ok(iso_narrow_codes_make(&codes, first, last, &err));
            assert_int_equal(wrong_rows(&codes, &whole.levels[0], first, last), 0);
        }
        /* The last box has been made: a voxel that is another is seen. */
        codes.codes[3 * (NX * NY * (7 - codes.first[2]) + NX * 12 + 20)] ^= 1;
        assert_int_equal(wrong_rows(&codes, &whole.levels[0], boxes[5][0], boxes[5][1]), 1);
        end(&f);
    }
}

/* Of each estimator; boxes have at most `SIDE` voxels along each axis. */
TEST(codes_of_small_boxes_are_those_of_the_level)
{
    enum { SIDE = 9 };
    static const size_t boxes[][2][3] = {{{0, 0, 0}, {9, 9, 9}},     {{0, 0, 0}, {1, 1, 1}},
                                         {{17, 31, 8}, {9, 9, 9}},   {{141, 31, 21}, {9, 9, 9}},
                                         {{50, 20, 28}, {3, 1, 2}},  {{149, 39, 29}, {1, 1, 1}}};
    for (int method = 0; method < ISO_GRADIENT_COUNT; ++method) {
        fixture f;
        iso_pyramid whole;
        iso_box_codes *codes;
        double scale;
        uint8_t made[3 * SIDE * SIDE * SIDE];
        begin(&f, method % 2 ? ISO_U8 : ISO_F32);
        f.narrow.options.gradient.method = (iso_gradient_method)method;
        assert_ok(iso_pyramid_build(&f.volume, "noise", &f.narrow.options, &whole, NULL, &err));
        iso_level level = whole.levels[0];
        level.samples = &f.volume;
        level.estimator = (iso_gradient_method)method;
        assert_ok(iso_level_gradient_scale(&level, &scale, &err));
        assert_ok(iso_box_codes_create(&level, ISO_CODE_FIT, scale, SIDE, &codes, &err));
        for (size_t b = 0; b < sizeof boxes / sizeof *boxes; ++b) {
            const size_t *first = boxes[b][0], *n = boxes[b][1];
            iso_box_codes_make(codes, first, n, made);
            for (size_t row = 0; row < n[1] * n[2]; ++row)
                assert_memory_equal(made + 3 * n[0] * row,
                                    level.codes + 3 * (first[0] + NX * (first[1] + row % n[1] +
                                                                        NY * (first[2] + row / n[1]))),
                                    3 * n[0]);
        }
        iso_box_codes_destroy(codes);
        iso_pyramid_destroy(&whole);
        end(&f);
    }
}

/* What a scene shows of samples is what it shows of their floats: the transfer function that is suggested, the camera,
 * and what is warned of. */
TEST(samples_are_seen_as_their_floats)
{
    for (size_t t = 0; t < sizeof types / sizeof *types; ++t) {
        fixture f;
        begin(&f, types[t]);
        iso_level level = f.whole.levels[0];
        iso_pyramid of_samples = f.whole;
        level.scalar = NULL;
        level.samples = &f.volume;
        of_samples.level_count = 1;
        of_samples.levels = &level;
        const iso_subject_look look = {.size = "24"};
        OWNED(iso_view) a, b;
        assert_ok(iso_subject_make_view(&look, &f.whole, &a, &err));
        assert_ok(iso_subject_make_view(&look, &of_samples, &b, &err));
        assert_int_equal(a.tf.count, b.tf.count);
        assert_memory_equal(a.tf.entries, b.tf.entries, 4 * a.tf.count * sizeof *a.tf.entries);
        assert_true(a.camera.position.x == b.camera.position.x && a.camera.position.z == b.camera.position.z);
        const iso_visible one = iso_visible_measure(&f.whole.levels[0], &a, NULL, 1);
        const iso_visible other = iso_visible_measure(&level, &b, NULL, 2);
        assert_true(one.voxels > 0 && one.voxels < 1 && one.picture > 0);
        assert_true(one.voxels == other.voxels && one.faces == other.faces && one.picture == other.picture);
        memset(f.volume.data, 0, iso_geometry_voxel_count(&f.volume.geometry) * iso_type_bytes(types[t]) / 2);
        assert_true(iso_visible_measure(&level, &b, NULL, 2).voxels != one.voxels); /* other samples are seen */
        end(&f);
    }
}

/* Bytes of the file that is saved, but for the identifier that OpenVDB draws anew for each file. */
static char *save(const fixture *f, const iso_pyramid *p, const iso_vdb_shown *shown, int threads, size_t *bytes)
{
    enum { IDENTIFIER = 21, IDENTIFIER_BYTES = 36 };
    char *path = iso_path_join(f->dir, "v.vdb"), *data;
    iso_vdb_options o = iso_vdb_defaults();
    o.shown = shown;
    o.half_directions = shown != NULL;
    o.pad_voxels = 1;
    o.threads = threads;
    o.volume = p->levels[0].scalar ? NULL : &f->volume;
    assert_ok(iso_vdb_save(p, 0, 1, path, &o, NULL, &err));
    assert_ok(iso_file_read(path, &data, bytes, &err));
    assert_true(*bytes > IDENTIFIER + IDENTIFIER_BYTES);
    memset(data + IDENTIFIER, 0, IDENTIFIER_BYTES);
    free(path);
    return data;
}

static bool is_same_file(const fixture *f, const iso_pyramid *a, const iso_pyramid *b, const iso_vdb_shown *shown,
                         int threads)
{
    size_t one_bytes, other_bytes;
    FREED char *one = save(f, a, shown, 1, &one_bytes), *other = save(f, b, shown, threads, &other_bytes);
    const bool same = one_bytes == other_bytes && memcmp(one, other, one_bytes) == 0;
    return same;
}

TEST(openvdb_files_are_equal_whatever_the_threads)
{
    for (size_t t = 0; t < sizeof types / sizeof *types; ++t) {
        fixture f;
        begin(&f, types[t]);
        const double lo = f.whole.levels[0].min, hi = f.whole.levels[0].max;
        float entries[4 * 16] = {0};
        for (size_t i = 9; i < 12; ++i)
            entries[4 * i + 3] = 1;
        const iso_tf_table tf = {.count = 16, .lo = lo, .hi = hi, .entries = entries};
        const iso_vdb_shown shown = {&tf, 1, false, 0};
        assert_true(is_same_file(&f, &f.whole, &f.narrow, NULL, 3));
        assert_true(is_same_file(&f, &f.whole, &f.narrow, &shown, 3));
        memset((char *)f.volume.data + (size_t)(NX * NY * 9 + NX * 13 + 18) * iso_type_bytes(f.volume.type), 1,
               iso_type_bytes(f.volume.type));
        assert_false(is_same_file(&f, &f.whole, &f.narrow, NULL, 3)); /* one voxel is another */
        end(&f);
    }
}

static void read_codes(const void *user, size_t first, size_t count, float *out)
{
    const iso_narrow_codes *c = user;
    iso_code_decode_all(c->options.code, iso_narrow_codes_at(c, first % NX, first / NX % NY, first / (NX * NY)), out,
                        count);
}

static iso_status make_codes(void *user, size_t first, size_t end, iso_error *why)
{
    return iso_narrow_codes_make(user, (const size_t[]){0, 0, first}, (const size_t[]){NX, NY, end}, why);
}

/* Three files from one reading, whose codes are made a few planes after the other, are those of three readings. */
TEST(df3_files_of_several_channels_are_equal)
{
    fixture f;
    begin(&f, ISO_U8);
    const size_t size[3] = {NX, NY, NZ}, voxels = (size_t)NX * NY * NZ;
    OWNED(iso_narrow_codes) codes;
    assert_ok(iso_narrow_codes_begin(&codes, &f.narrow, &f.volume, &err));
    const iso_df3_source source = {.size = {NX, NY, NZ},
                                   .channels = 3,
                                   .read = read_codes,
                                   .user = &codes,
                                   .prepare = make_codes,
                                   .prepare_user = &codes,
                                   .planes = 7};
    FREED float *decoded = malloc(3 * voxels * sizeof *decoded);
    iso_code_decode_all(f.whole.options.code, f.whole.levels[0].codes, decoded, voxels);
    for (unsigned bits = 8; bits <= 32; bits *= 2) {
        const iso_df3_coding coding = {bits, -128.0 / 127, 1};
        char *paths[4], *data[4];
        size_t bytes[4];
        for (size_t i = 0; i < 4; ++i) {
            char name[16];
            snprintf(name, sizeof name, "%zu.df3", i);
            paths[i] = iso_path_join(f.dir, name);
        }
        assert_ok(iso_df3_write_from(&source, (const char *const *)paths, &coding, bits == 8 ? 1 : 3, &err));
        for (size_t c = 0; c < 3; ++c) {
            assert_ok(iso_df3_write(paths[3], size, decoded, 3, c, &coding, &err));
            assert_ok(iso_file_read(paths[c], &data[c], &bytes[c], &err));
            assert_ok(iso_file_read(paths[3], &data[3], &bytes[3], &err));
            assert_int_equal(bytes[c], bytes[3]);
            assert_int_equal(bytes[c], 6 + (NX + 2) * (NY + 2) * (NZ + 2) * bits / 8);
            assert_memory_equal(data[c], data[3], bytes[3]);
            assert_false(c > 0 && memcmp(data[c], data[c - 1], bytes[3]) == 0); /* channels are not mixed up */
            free(data[3]);
        }
        for (size_t i = 0; i < 4; ++i) {
            free(paths[i]);
            if (i < 3)
                free(data[i]);
        }
    }
    end(&f);
}

TEST_MAIN(NULL, NULL)
