/* SPDX-License-Identifier: MIT */
/* test_image.c - images to files and back. */
#define _GNU_SOURCE
#include <png.h>
#include <unistd.h>

#include "base/file.h"
#include "compare/metrics.h"
#include "image/image.h"
#include "image/primaries.h"
#include "folder.h"
#include "test.h"

/* 37 x 53: neither a multiple of a chunk's lines, nor square. */
static iso_image pattern(void)
{
    iso_image image;
    assert_ok(iso_image_create(&image, 37, 53, &err));
    for (size_t i = 0; i < 37 * 53 * 4; ++i)
        image.rgba[i] = (float)sin((double)i) * 10;
    return image;
}

TEST(exr_keeps_every_bit_and_the_orientation)
{
    OWNED(iso_image) a = pattern(), b;
    FREED char *path = iso_path_join(folder, "a.exr");
    const iso_image_note notes[] = {{"command", "isoshade render"}, {NULL, NULL}};
    assert_ok(iso_image_save_exr(&a, path, notes, &err));
    assert_ok(iso_image_load_exr(path, &b, &err));
    assert_int_equal(b.width, 37);
    assert_int_equal(b.height, 53);
    assert_memory_equal(a.rgba, b.rgba, 37 * 53 * 4 * sizeof(float));
}

/* Writes the windows that an EXR of ours begins with; the file has one chunk, which is moved with its data window. */
static void set_windows(const char *path, const int32_t data[4], const int32_t display[4])
{
    static const char data_key[] = "dataWindow\0box2i", display_key[] = "displayWindow\0box2i";
    FREED char *bytes;
    size_t size;
    assert_ok(iso_file_read(path, &bytes, &size, &err));
    for (size_t i = 0; i + 32 < size; ++i) {
        uint64_t offset;
        memcpy(&offset, bytes + i, 8);
        if (memcmp(bytes + i, data_key, sizeof data_key) == 0)
            memcpy(bytes + i + sizeof data_key + 4, data, 16);
        else if (memcmp(bytes + i, display_key, sizeof display_key) == 0)
            memcpy(bytes + i + sizeof display_key + 4, display, 16);
        else if (offset == i + 8) /* the table of chunks, of one entry */
            memcpy(bytes + i + 8, &data[1], 4);
    }
    assert_ok(iso_file_write(path, bytes, size, &err));
}

/* What an EXR shows is its display window: data that lie elsewhere in it are another picture. */
TEST(the_data_window_places_the_pixels)
{
    enum { WIDTH = 7, HEIGHT = 6 };
    iso_image a, b;
    iso_metrics m;
    FREED char *path = iso_path_join(folder, "window.exr");
    assert_ok(iso_image_create(&a, WIDTH, HEIGHT, &err));
    for (size_t i = 0; i < WIDTH * HEIGHT * 4; ++i)
        a.rgba[i] = 0.25f + (float)i / 256;
    assert_ok(iso_image_save_exr(&a, path, NULL, &err));
    /* Moved by (2, 1) within the same picture: what leaves it is not seen, what is left empty is 0. */
    set_windows(path, (int32_t[]){2, 1, WIDTH + 1, HEIGHT}, (int32_t[]){0, 0, WIDTH - 1, HEIGHT - 1});
    assert_ok(iso_image_load_exr(path, &b, &err));
    assert_true(b.width == WIDTH && b.height == HEIGHT);
    for (size_t y = 0; y < HEIGHT; ++y)
        for (size_t x = 0; x < WIDTH; ++x)
            for (size_t c = 0; c < 4; ++c)
                assert_within(b.rgba[4 * (y * WIDTH + x) + c],
                              x < 2 || y < 1 ? 0 : a.rgba[4 * ((y - 1) * WIDTH + x - 2) + c], 0);
    assert_ok(iso_metrics_measure(&a, &b, &m, &err));
    assert_true(m.max_abs > 0.2); /* the same pixels elsewhere were "agree" */
    iso_image_destroy(&b);
    /* Data and picture both begin elsewhere: other places of a larger canvas, which are not compared. */
    set_windows(path, (int32_t[]){5, 7, WIDTH + 4, HEIGHT + 6}, (int32_t[]){5, 7, WIDTH + 4, HEIGHT + 6});
    assert_ok(iso_image_load_exr(path, &b, &err));
    assert_memory_equal(a.rgba, b.rgba, WIDTH * HEIGHT * 4 * sizeof(float));
    assert_status(iso_metrics_measure(&a, &b, &m, &err), ISO_E_RANGE);
    iso_image_destroy(&b);
    iso_image_destroy(&a);
}

TEST(a_truncated_exr_is_refused)
{
    iso_image a = pattern(), b;
    FREED char *path = iso_path_join(folder, "cut.exr");
    assert_ok(iso_image_save_exr(&a, path, NULL, &err));
    assert_int_equal(truncate(path, 2000), 0);
    assert_status(iso_image_load_exr(path, &b, &err), ISO_E_FORMAT);
    assert_ok(iso_file_write(path, "not an image", 12, &err));
    assert_status(iso_image_load_exr(path, &b, &err), ISO_E_FORMAT);
    iso_image_destroy(&a);
}

/* Bytes of the file's only chunk: its line and its size stand before it. */
static size_t chunk_bytes(const char *path)
{
    FREED char *data;
    size_t size, found = 0;
    assert_ok(iso_file_read(path, &data, &size, &err));
    for (size_t i = 0; found == 0 && i + 16 < size; ++i) {
        uint64_t offset;
        int32_t packed;
        memcpy(&offset, data + i, 8);
        memcpy(&packed, data + i + 12, 4);
        if (offset == i + 8 && (size_t)packed == size - i - 16)
            found = (size_t)packed;
    }
    return found;
}

/* A chunk that packs to its raw size is stored raw. Noise in which ever more bytes are 0 meets that size from above. */
TEST(chunks_that_pack_to_their_raw_size_are_kept)
{
    enum { WIDTH = 13, HEIGHT = 16, VALUES = 4 * WIDTH * HEIGHT };
    iso_image a, b;
    bool some_raw = false, some_packed = false;
    FREED char *path = iso_path_join(folder, "noise.exr");
    assert_ok(iso_image_create(&a, WIDTH, HEIGHT, &err));
    uint64_t random = 1;
    for (size_t i = 0; i < VALUES; ++i) { /* all bits, so NaN of all kinds, too */
        random = random * 6364136223846793005u + 1442695040888963407u;
        const uint32_t bits = (uint32_t)(random >> 32);
        memcpy(&a.rgba[i], &bits, 4);
    }
    for (size_t zeros = 0; zeros < 120; ++zeros) {
        a.rgba[4 * (zeros / 4) + zeros % 4] = 0;
        assert_ok(iso_image_save_exr(&a, path, NULL, &err));
        assert_ok(iso_image_load_exr(path, &b, &err));
        assert_memory_equal(a.rgba, b.rgba, sizeof(float) * VALUES);
        iso_image_destroy(&b);
        *(chunk_bytes(path) == sizeof(float) * VALUES ? &some_raw : &some_packed) = true;
    }
    assert_true(some_raw && some_packed);
    iso_image_destroy(&a);
}

/* Planted: one byte of a raw chunk, a pixel more, a file cut. */
TEST(a_file_with_other_pixels_is_noticed_after_writing)
{
    OWNED(iso_image) a, more;
    FREED char *bytes, *path = iso_path_join(folder, "raw.exr");
    size_t size;
    assert_ok(iso_image_create(&a, 1, 1, &err));
    a.rgba[0] = NAN;
    assert_ok(iso_image_save_exr(&a, path, NULL, &err));
    assert_ok(iso_exr_verify(path, &a, &err));
    assert_ok(iso_image_create(&more, 2, 1, &err));
    assert_status(iso_exr_verify(path, &more, &err), ISO_E_IO);
    assert_ok(iso_file_read(path, &bytes, &size, &err));
    bytes[size - 1] ^= 1;
    assert_ok(iso_file_write(path, bytes, size, &err));
    assert_status(iso_exr_verify(path, &a, &err), ISO_E_IO);
    assert_ok(iso_file_write(path, bytes, size - 1, &err));
    assert_status(iso_exr_verify(path, &a, &err), ISO_E_IO);
}

/* ITU-R BT.2087 has the matrix of Rec. 2020, to 4 digits; SMPTE TB 2018 that of ACES AP1 (D60), by Bradford, to 5. */
TEST(colors_of_other_primaries_become_those_of_rec_709)
{
    static const iso_primaries rec2020 = {{{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}}},
                               ap1 = {{{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, {0.32168, 0.33767}}},
                               srgb = {{{0.64, 0.33}, {0.3, 0.6}, {0.15, 0.06}, {0.31271, 0.32902}}},
                               line = {{{0.1, 0.1}, {0.2, 0.2}, {0.3, 0.3}, {0.3127, 0.3290}}};
    static const double of_2020[3][3] = {{1.6605, -0.5876, -0.0728}, {-0.1246, 1.1329, -0.0083}, {-0.0182, -0.1006, 1.1187}},
                        of_ap1[3][3] = {{1.70505, -0.62179, -0.08326}, {-0.13026, 1.14080, -0.01055}, {-0.02400, -0.12897, 1.15297}};
    double m[3][3], n[3][3];
    assert_true(iso_primaries_matrix(&rec2020, m) && iso_primaries_matrix(&ap1, n));
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            assert_within(m[i][j], of_2020[i][j], 0.5e-4 + 1e-9); /* its digits */
            assert_within(n[i][j], of_ap1[i][j], 2e-5);           /* its digits, and those of Bradford's matrix */
        }
        assert_within(n[i][0] + n[i][1] + n[i][2], 1, 1e-12); /* white stays white; rounding */
    }
    assert_true(iso_primaries_matrix(&srgb, m));
    assert_true(m[0][0] == 1 && m[0][1] == 0);
    assert_false(iso_primaries_matrix(&line, m));
}

TEST(an_unwritable_folder_is_named)
{
    OWNED(iso_image) a = pattern();
    iso_error e = {""};
    assert_int_equal(iso_image_save_exr(&a, "/nonexistent/folder/a.exr", NULL, &e), ISO_E_IO);
    assert_non_null(strstr(e.text, "/nonexistent/folder"));
    assert_int_equal(iso_image_save_png(&a, "/nonexistent/folder/a.png", 1, &e), ISO_E_IO);
}

TEST(ppm_of_16_bits_is_read_and_8_bits_refused)
{
    iso_image a;
    FREED char *path = iso_path_join(folder, "a.ppm");
    static const char good[] = "P6\n# POV-Ray\n2 1\n65535\n\377\377\000\000\000\001\200\000\000\000\000\000";
    assert_ok(iso_file_write(path, good, sizeof good - 1, &err));
    assert_ok(iso_image_load_ppm(path, &a, &err));
    assert_within(a.rgba[0], 1, 0);
    assert_within(a.rgba[2], 1 / 65535.0, 1e-9); /* float rounding */
    assert_within(a.rgba[4], 32768 / 65535.0, 1e-7);
    assert_within(a.rgba[7], 1, 0);
    iso_image_destroy(&a);
    assert_ok(iso_file_write(path, good, sizeof good - 2, &err));
    assert_status(iso_image_load_ppm(path, &a, &err), ISO_E_FORMAT);
    assert_ok(iso_file_write(path, "P6 1 1 255 abc", 14, &err));
    assert_status(iso_image_load_ppm(path, &a, &err), ISO_E_FORMAT);
}

/* Byte 188 is 0.502886 in linear light, 1 is 1 / (255 * 12.92). */
TEST(png_is_decoded_from_srgb_of_8_and_16_bits)
{
    iso_image a, b;
    FREED char *path = iso_path_join(folder, "a.png");
    assert_ok(iso_image_create(&a, 256, 1, &err));
    for (size_t i = 0; i < 256; ++i)
        for (size_t c = 0; c < 4; ++c) /* grays of all kinds, in red backwards */
            a.rgba[4 * i + c] = c == 3 ? 1 : (float)pow((double)(c == 0 ? 255 - i : i) / 255, 2.2);
    assert_ok(iso_image_save_png(&a, path, 1, &err));
    assert_ok(iso_image_load_png(path, &b, &err));
    assert_true(b.width == 256 && b.height == 1);
    iso_image_destroy(&a);
    assert_ok(iso_image_save_png(&b, path, 1, &err));
    assert_ok(iso_image_load_png(path, &a, &err));
    assert_memory_equal(a.rgba, b.rgba, 16 * 256); /* a byte and its color are one */
    iso_image_destroy(&a);
    iso_image_destroy(&b);

    const uint8_t bytes[] = {188, 1, 255, 255, 188, 0, 0, 51};
    png_image png = {.version = PNG_IMAGE_VERSION, .width = 2, .height = 1, .format = PNG_FORMAT_RGBA};
    assert_true(png_image_write_to_file(&png, path, 0, bytes, 0, NULL));
    assert_ok(iso_image_load_png(path, &a, &err));
    assert_within(a.rgba[0], 0.502886, 1e-6); /* the digits given */
    assert_within(a.rgba[1], 1 / (255 * 12.92), 1e-10);
    assert_within(a.rgba[2], 1, 0);
    assert_within(a.rgba[4], 0.2 * 0.502886, 1e-6); /* 51 / 255 */
    assert_within(a.rgba[7], 0.2, 1e-8);
    iso_image_destroy(&a);

    const uint16_t deep[] = {1, 2, 3, 4, 5, 6};
    png = (png_image){.version = PNG_IMAGE_VERSION, .width = 2, .height = 1, .format = PNG_FORMAT_LINEAR_RGB};
    assert_true(png_image_write_to_file(&png, path, 0, deep, 0, NULL));
    assert_ok(iso_image_load_png(path, &a, &err)); /* of 16 bits, which the file says are linear */
    for (size_t i = 0; i < 6; ++i)
        assert_within((double)a.rgba[4 * (i / 3) + i % 3], (double)deep[i] / 65535, 0.5 / 65535 / 12.92 + 1e-9);
    iso_image_destroy(&a);
    assert_ok(iso_file_write(path, "not a picture", 13, &err));
    assert_status(iso_image_load_png(path, &a, &err), ISO_E_FORMAT);
}

TEST(the_background_shows_through_what_is_left_of_alpha)
{
    OWNED(iso_image) a;
    const double background[3] = {1, 0.5, 0};
    assert_ok(iso_image_create(&a, 1, 1, &err));
    a.rgba[0] = 0.25f;
    a.rgba[3] = 0.75f;
    iso_image_add_background(&a, background);
    assert_within(a.rgba[0], 0.5, 0);
    assert_within(a.rgba[1], 0.125, 0);
    assert_within(a.rgba[2], 0, 0);
}

TEST_MAIN(make_folder, remove_folder)
