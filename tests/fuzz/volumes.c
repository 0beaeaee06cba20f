/* SPDX-License-Identifier: MIT */
/* volumes.c - volumes: header, samples, geometry, labels. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fuzz/readers.h"
#include "volume/input.h"
#include "volume/labels.h"

static void check_volume(const iso_volume *v)
{
    const iso_geometry *g = &v->geometry;
    iso_error err = {""};
    fuzz_note_read();
    if (iso_geometry_check(g, "input", &err) != ISO_OK)
        fuzz_fail("a volume was read whose geometry is refused: %s", err.text);
    for (int i = 0; i < 3; ++i)
        if (!(g->box_index[i] > 0 && g->box_index[i] <= (double)g->size[i]))
            fuzz_fail("the box ends at %g of %zu samples", g->box_index[i], g->size[i]);
    const iso_volume_stats stats = iso_volume_measure(v);
    if (stats.nonfinite_count > 0)
        fuzz_fail("%zu samples are no numbers", stats.nonfinite_count);
    if (!(stats.min <= stats.mean && stats.mean <= stats.max))
        fuzz_fail("the mean %.17g lies outside of %.17g to %.17g", stats.mean, stats.min, stats.max);
    iso_label_facts facts;
    fuzz_check_status(iso_labels_look_at(v, false, &facts, &err), &err);
}

void fuzz_volume(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target, (void)data, (void)size;
    iso_volume v = {0};
    iso_error err = {""};
    iso_status status = iso_volume_load(path, &v, &err);
    fuzz_check_status(status, &err);
    if (status != ISO_OK && strstr(err.text, "--")) { /* what the file leaves open, an option says */
        const iso_volume_input inputs[] = {{.frame = "0"},
                                           {.channel = "0"},
                                           {.frame = "0", .channel = "luminance"},
                                           {.frame = "0", .channel = "0"},
                                           {.spacing = "1x1x1"},
                                           {.frame = "1", .channel = "1", .spacing = "1x2x3"},
                                           {.spacing = "1x1x1", .unit = "um"}};
        for (size_t i = 0; i < sizeof inputs / sizeof *inputs && status != ISO_OK; ++i) {
            iso_volume_destroy(&v);
            v = (iso_volume){0};
            status = iso_volume_input_load(path, &inputs[i], &v, &err);
            fuzz_check_status(status, &err);
        }
    }
    if (status == ISO_OK)
        check_volume(&v);
    iso_volume_destroy(&v);
}

/* Writes a file in the folder of the input, once. */
static void put_beside(const char *path, const char *name, const void *bytes, size_t size)
{
    char other[4096];
    const char *slash = strrchr(path, '/');
    snprintf(other, sizeof other, "%.*s%s", slash ? (int)(slash + 1 - path) : 0, path, name);
    FILE *f = fopen(other, "rb");
    if (!f && (f = fopen(other, "wb")) && fwrite(bytes, 1, size, f) != size)
        fuzz_fail("%s cannot be written", other);
    if (f)
        fclose(f);
}

/* The samples of the seed's header. */
void fuzz_afni(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    uint8_t samples[4 * 3 * 2 * 2 * 2];
    for (size_t i = 0; i < sizeof samples; ++i)
        samples[i] = (uint8_t)(37 * i);
    put_beside(path, "input.BRIK", samples, sizeof samples);
    fuzz_volume(target, path, data, size);
}

/* The piece of the seed. */
void fuzz_pvti(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    static const char piece[] =
        "<VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\">"
        "<ImageData WholeExtent=\"0 3 0 2 0 1\" Origin=\"1 2 3\" Spacing=\"1 2 3\"><Piece Extent=\"0 3 0 2 0 1\">"
        "<PointData Scalars=\"a\"><DataArray type=\"Int16\" Name=\"a\" format=\"ascii\">"
        "0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23</DataArray></PointData>"
        "</Piece></ImageData></VTKFile>";
    put_beside(path, "own_0.vti", piece, sizeof piece - 1);
    fuzz_volume(target, path, data, size);
}

/* The first line: size, type, spacing, bytes that are skipped, and which byte order. */
void fuzz_raw(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
{
    (void)target;
    char line[160] = "", words[4][40] = {"", "", "", ""};
    const uint8_t *end = memchr(data, '\n', size);
    const size_t length = end ? (size_t)(end - data) : 0;
    memcpy(line, data, length < sizeof line ? length : sizeof line - 1);
    sscanf(line, "%39s %39s %39s %39s", words[0], words[1], words[2], words[3]);
    const iso_volume_input input = {.raw_size = words[0],
                                    .raw_type = words[1],
                                    .raw_spacing = words[2][0] ? words[2] : NULL,
                                    .raw_skip_bytes = strtol(words[3], NULL, 10),
                                    .raw_big_endian = strchr(words[3], 'b') != NULL};
    iso_volume v = {0};
    iso_error err = {""};
    iso_status status = iso_volume_input_load(path, &input, &v, &err);
    fuzz_check_status(status, &err);
    if (status == ISO_OK)
        check_volume(&v);
    iso_volume_destroy(&v);
}
