/* SPDX-License-Identifier: MIT */
/* tables.c - transfer functions, palettes, pictures, and words of command lines. */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "base/words.h"
#include "image/image.h"
#include "palette/palette.h"
#include "scene/viewpoint.h"
#include "tests/fuzz/readers.h"
#include "tf/format.h"
#include "volume/unit.h"

/* ---- transfer functions ---- */

static const size_t some_size[3] = {9, 7, 8};
static const double some_spacing[3] = {0.5, 1, 2};

static void check_table(const iso_tf *tf)
{
    const iso_geometry g = iso_geometry_axis_aligned(some_size, some_spacing);
    iso_tf_table table = {0};
    iso_error err = {""};
    const iso_status status = iso_tf_tabulate(tf, -3, 260, &g, &table, &err);
    fuzz_check_status(status, &err);
    if (status == ISO_OK && !(table.lo < table.hi && table.count >= 2 && table.count <= ISO_TF_MOST_ENTRIES))
        fuzz_fail("a table of %zu entries over %g to %g", table.count, table.lo, table.hi);
    for (size_t i = 0; status == ISO_OK && i < 4 * table.count; ++i)
        if (!(isfinite(table.entries[i]) && table.entries[i] >= 0))
            fuzz_fail("entry %zu of the table holds %g", i / 4, (double)table.entries[i]);
    iso_tf_table_destroy(&table);
}

/* What is written is read again as it was. */
static void check_round_trip(const iso_tf *tf)
{
    iso_tf again = {0};
    iso_error err = {""};
    json_t *once = iso_tf_to_json(tf);
    const iso_status status = iso_tf_from_json(once, "again", &again, &err);
    if (status != ISO_OK)
        fuzz_fail("what is written of a TF is refused: %s", err.text);
    json_t *twice = iso_tf_to_json(&again);
    fuzz_check_same("a TF", once, twice);
    json_decref(once);
    json_decref(twice);
    iso_tf_destroy(&again);
}

static iso_status load_tf(const char *path, const iso_tf_request *request, bool again)
{
    iso_tf tf = {0};
    iso_error err = {""};
    const iso_status status = iso_tf_load_as(path, request, &tf, &err);
    fuzz_check_status(status, &err);
    if (status == ISO_OK) {
        fuzz_note_read();
        check_table(&tf);
        if (again)
            check_round_trip(&tf);
    }
    iso_tf_destroy(&tf);
    return status;
}

/* Without a name, then by the first name that the file has, and by what it leaves open. What a conversion loses is
 * measured for one file in sixteen and one in four is written and read again: both take several times as long as to
 * read. */
void fuzz_tf(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target;
    const unsigned long sum = crc32(0, data, (uInt)size);
    const bool measure = sum % 16 == 0, again = sum % 4 == 0;
    char *names = NULL;
    iso_status status = load_tf(path, &(iso_tf_request){.names = &names}, again);
    if (names)
        names[strcspn(names, "\n")] = 0;
    const iso_tf_request requests[] = {
        {.name = names && names[0] ? names : NULL, .measure = measure},
        {.name = names,
         .unit_mm = 2,
         .has_opacity = true,
         .opacity = {0, 0.5},
         .has_range = true,
         .range = {0, 10},
         .measure = measure},
        {.name = names, .unit_mm = 1, .measure = measure},
        {.name = names, .has_range = true, .fit = true, .measure = measure}};
    for (size_t i = 0; i < sizeof requests / sizeof *requests && status == ISO_E_USAGE; ++i)
        status = load_tf(path, &requests[i], again);
    free(names);
}

/* ---- palettes ---- */

void fuzz_palette(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    iso_palette palette = {0}, again = {0};
    iso_error err = {""};
    iso_status status = iso_palette_load_csv(path, &palette, &err);
    fuzz_check_status(status, &err);
    if (status == ISO_OK) {
        fuzz_note_read();
        for (size_t i = 0; i < 3 * palette.count; ++i)
            if (!isfinite(palette.xyz[i]))
                fuzz_fail("entry %zu is no direction", i / 3);
        const char *copy = fuzz_beside("again.csv");
        status = iso_palette_save_csv(&palette, copy, &err);
        fuzz_check_status(status, &err);
        if (status == ISO_OK && (iso_palette_load_csv(copy, &again, &err) != ISO_OK || again.count != palette.count ||
                                 memcmp(again.xyz, palette.xyz, 3 * palette.count * sizeof(float)) != 0))
            fuzz_fail("a palette is not read back as it was written: %s", err.text);
        iso_palette_lookup *lookup = NULL;
        const float vectors[6] = {1, 0.5f, -2, 0, NAN, 1};
        uint16_t index[2] = {0, 0};
        if (palette.count < 300 && iso_palette_lookup_create(&palette, &lookup, &err) == ISO_OK)
            iso_palette_assign(lookup, vectors, index, 2);
        if (index[0] >= palette.count || index[1] != 0)
            fuzz_fail("indices %u and %u in a palette of %zu", index[0], index[1], palette.count);
        iso_palette_lookup_destroy(lookup);
    }
    iso_palette_destroy(&again);
    iso_palette_destroy(&palette);
}

/* ---- pictures ---- */

static void take_image(iso_status status, iso_image *image, const iso_error *err)
{
    fuzz_check_status(status, err);
    if (status == ISO_OK) {
        fuzz_note_read();
        iso_image_is_finite(image);
        iso_image_shown_share(image);
    }
    iso_image_destroy(image);
}

void fuzz_exr(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    iso_image image = {0};
    iso_exr_header header;
    iso_error err = {""};
    const iso_status status = iso_image_read_exr_header(path, &header, &err);
    fuzz_check_status(status, &err);
    take_image(iso_image_load_exr(path, &image, &err), &image, &err);
}

void fuzz_png(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    iso_image image = {0};
    iso_error err = {""};
    take_image(iso_image_load_png(path, &image, &err), &image, &err);
}

void fuzz_ppm(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    iso_image image = {0};
    iso_error err = {""};
    take_image(iso_image_load_ppm(path, &image, &err), &image, &err);
}

static uint32_t get_32(const uint8_t *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

/* The checksum of each chunk that is whole. */
void fuzz_repair_png(uint8_t *data, size_t size)
{
    for (size_t at = 8; at + 12 <= size;) {
        const size_t length = get_32(data + at);
        if (length > size - at - 12)
            return;
        const uint32_t sum = (uint32_t)crc32(0, data + at + 4, (uInt)length + 4);
        for (int i = 0; i < 4; ++i)
            data[at + 8 + length + (size_t)i] = (uint8_t)(sum >> (24 - 8 * i));
        at += length + 12;
    }
}

/* ---- words of command lines ---- */

void fuzz_words(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)path;
    char text[512] = "";
    memcpy(text, data, size < sizeof text ? size : sizeof text - 1);
    size_t sizes[3];
    double numbers[3], error, mm;
    const char *name;
    iso_viewpoint viewpoint;
    iso_error err = {""};
    fuzz_check_read(iso_words_parse_sizes(text, "--size", sizes, &err), &err);
    fuzz_check_read(iso_words_parse_numbers(text, "--spacing", numbers, &err), &err);
    fuzz_check_read(iso_words_parse_error("--error", text, &error, &err), &err);
    fuzz_check_read(iso_unit_parse("--unit", text, &mm, &name, &err), &err);
    fuzz_check_read(iso_viewpoint_parse(text, &viewpoint, &err), &err);
    iso_words_make_printable(text);
    if (iso_words_has_control(text))
        fuzz_fail("a text that was made printable has control characters");
}
