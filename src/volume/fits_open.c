/* SPDX-License-Identifier: MIT */
/* fits_open.c - FITS images of three axes, and a fourth for frames: headers of lines of 80 letters in blocks of 2880
 * bytes, each followed by its samples, big-endian. FILE:PART is an image's number, from 0, or its EXTNAME.
 *
 * Axes of one sample are left out. Positions count if all three axes have a unit of length; angles and frequencies
 * are none, so --spacing is needed. */
#define _GNU_SOURCE
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/words.h"
#include "volume/reader.h"
#include "volume/unit.h"

enum { CARD_BYTES = 80, BLOCK_BYTES = 2880, MOST_BLOCKS = 10000, MOST_PARTS = 1000, MOST_AXES = 9, WORD_BYTES = 24 };

typedef struct fits_axis {
    double size, step, value, pixel; /* CDELT, CRVAL at the pixel CRPIX, from 1 */
    char unit[WORD_BYTES];
} fits_axis;

/* A header, and where its samples are. */
typedef struct fits {
    double bits, axis_count, scale, zero, blank, heap, groups;
    fits_axis axis[MOST_AXES];
    double turn[MOST_AXES][MOST_AXES]; /* CDi_j, or PCi_j: axis i of the world by axis j of the array; NAN: absent */
    bool has_steps;                    /* True for CDi_j, which contain CDELT */
    char name[CARD_BYTES], kind[WORD_BYTES];
    bool is_packed;
    double at, bytes;
} fits;

/* Reads a text between quotes, without spaces at its end. */
static void read_word(const char *value, char *out, size_t size)
{
    const char *start = strchr(value, '\'');
    const char *end = start ? strchr(start + 1, '\'') : NULL;
    size_t n = end ? (size_t)(end - start - 1) : 0;
    while (n > 0 && start[n] == ' ')
        --n;
    snprintf(out, size, "%.*s", (int)n, start ? start + 1 : "");
}

/* Takes a line "KEY     = value". */
static void take_card(fits *h, const char *card)
{
    const struct {
        const char *key;
        double *number;
    } numbers[] = {{"BITPIX", &h->bits}, {"NAXIS", &h->axis_count}, {"BSCALE", &h->scale}, {"BZERO", &h->zero},
                   {"BLANK", &h->blank}, {"PCOUNT", &h->heap},      {"GCOUNT", &h->groups}};
    static const char *const of_axes[] = {"NAXIS", "CDELT", "CRVAL", "CRPIX"};
    char key[9], value[CARD_BYTES];
    snprintf(key, sizeof key, "%.*s", (int)strcspn(card, " ") < 8 ? (int)strcspn(card, " ") : 8, card);
    snprintf(value, sizeof value, "%.*s", CARD_BYTES - 10, card + 10);
    for (char *c = value; *c && *c != '/' && *c != '\''; ++c)
        *c = *c == 'D' ? 'E' : *c;
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
        if (strcmp(key, numbers[i].key) == 0)
            *numbers[i].number = strtod(value, NULL);
    const size_t digit = strlen(key) == 6 && key[5] >= '1' && key[5] <= '9' ? (size_t)(key[5] - '1') : MOST_AXES;
    for (size_t i = 0; i < 4 && digit < MOST_AXES; ++i) {
        fits_axis *axis = &h->axis[digit];
        double *const of[] = {&axis->size, &axis->step, &axis->value, &axis->pixel};
        if (strncmp(key, of_axes[i], 5) == 0)
            *of[i] = strtod(value, NULL);
    }
    if (strlen(key) == 5 && (key[0] == 'C' || key[0] == 'P') && strchr("DC", key[1]) && key[3] == '_' &&
        key[2] >= '1' && key[2] <= '9' && key[4] >= '1' && key[4] <= '9') {
        h->turn[key[2] - '1'][key[4] - '1'] = strtod(value, NULL);
        h->has_steps = h->has_steps || key[1] == 'D';
    }
    if (digit < MOST_AXES && strncmp(key, "CUNIT", 5) == 0)
        read_word(value, h->axis[digit].unit, WORD_BYTES);
    if (strcmp(key, "EXTNAME") == 0)
        read_word(value, h->name, sizeof h->name);
    if (strcmp(key, "XTENSION") == 0)
        read_word(value, h->kind, sizeof h->kind);
    h->is_packed = h->is_packed || strcmp(key, "ZIMAGE") == 0;
}

/* Reads the header at the file's position; false at the end of the file, or without the line END. */
static bool read_header(FILE *f, fits *h)
{
    char block[BLOCK_BYTES];
    *h = (fits){.scale = 1, .blank = NAN, .groups = 1};
    for (int i = 0; i < MOST_AXES; ++i)
        h->axis[i] = (fits_axis){.step = 1, .pixel = 1};
    for (int i = 0; i < MOST_AXES * MOST_AXES; ++i)
        h->turn[i / MOST_AXES][i % MOST_AXES] = NAN;
    for (int blocks = 0; blocks < MOST_BLOCKS && fread(block, 1, BLOCK_BYTES, f) == BLOCK_BYTES; ++blocks)
        for (int at = 0; at < BLOCK_BYTES; at += CARD_BYTES) {
            const char *card = block + at;
            if (strncmp(card, "END     ", 8) == 0) {
                h->at = (double)ftello(f);
                h->bytes = h->axis_count > 0 ? fabs(h->bits) / 8 : 0;
                for (int a = 0; a < h->axis_count && a < MOST_AXES; ++a)
                    h->bytes *= h->axis[a].size;
                h->bytes = h->groups * (h->bytes + fabs(h->bits) / 8 * h->heap);
                return true;
            }
            if (card[8] == '=')
                take_card(h, card);
        }
    return false;
}

/* Leaves out axes of one sample while there are more than three. Returns the number of the others. */
static size_t used_axes(const fits *h, size_t used[MOST_AXES])
{
    const size_t all = h->axis_count >= 0 && h->axis_count <= MOST_AXES ? (size_t)h->axis_count : 0;
    size_t left = all, count = 0;
    for (size_t a = 0; a < all; ++a) {
        if (h->axis[a].size == 1 && left > 3)
            --left;
        else
            used[count++] = a;
    }
    return count;
}

static bool is_image(const fits *h)
{
    size_t used[MOST_AXES] = {0};
    return (*h->kind == 0 || strcmp(h->kind, "IMAGE") == 0) && used_axes(h, used) >= 3;
}

static bool is_named(const fits *h, size_t number, const char *part)
{
    char *end;
    const unsigned long long wanted = strtoull(part, &end, 10);
    return (isdigit((unsigned char)*part) && *end == 0 && wanted == number) || strcasecmp(part, h->name) == 0;
}

/* Finds the image of that name, or the only one. */
static iso_status find_image(FILE *f, const iso_volume_source *source, fits *found, iso_error *err)
{
    fits h;
    size_t images = 0, packed = 0, number = 0;
    char list[160] = "";
    for (; number < MOST_PARTS && read_header(f, &h); ++number) {
        packed += h.is_packed;
        if (is_image(&h)) {
            const size_t length = strlen(list);
            snprintf(list + length, sizeof list - length, "%s%zu%s%.20s", length ? ", " : "", number,
                     *h.name ? " " : "", h.name);
        }
        if (is_image(&h) && (!source->part || is_named(&h, number, source->part)) && images++ == 0)
            *found = h;
        const double next = h.at + ceil(h.bytes / BLOCK_BYTES) * BLOCK_BYTES;
        if (!(h.bytes >= 0 && next < 9e15) || fseeko(f, (off_t)next, SEEK_SET) != 0)
            break;
    }
    if (images == 1)
        return ISO_OK;
    if (images > 1 || (source->part && *list))
        return iso_fail(err, ISO_E_USAGE, "%s: %s of three axes, FILE:PART must be one of: %s", source->path,
                        images > 1 ? "holds several images" : "has no such image", list);
    return iso_fail(err, ISO_E_FORMAT, "%s: %s", source->path,
                    packed ? "holds images that fpack packed, which are not read; funpack unpacks them"
                           : "holds no image of three axes");
}

/* True for integers of 64 bits that stand without 2^63: doubles could not add it. */
static bool is_unsigned(const fits *h)
{
    return h->bits == 64 && h->scale == 1 && h->zero == 0x1p63;
}

static iso_status take_type(const fits *h, iso_volume_source *source, iso_error *err)
{
    const struct {
        double bits;
        iso_type type;
    } types[] = {{8, ISO_U8}, {16, ISO_I16}, {32, ISO_I32}, {64, ISO_F64}, {-32, ISO_F32}, {-64, ISO_F64}};
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i)
        if (h->bits == types[i].bits) {
            source->header.type = types[i].type;
            if (h->bits == 64)
                iso_source_set_form(source, is_unsigned(h) ? ISO_FORM_U64_OF_FITS : ISO_FORM_I64);
            source->swap_bytes = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ && h->bits != 8;
            return ISO_OK;
        }
    return iso_fail(err, ISO_E_FORMAT, "%s: BITPIX is %g, must be 8, 16, 32, 64, -32 or -64", source->path, h->bits);
}

/* Returns how far a pixel along axis `a` of the array leads along axis r of the world. */
static double step_of(const fits *h, size_t r, size_t a)
{
    const double turn = isnan(h->turn[r][a]) ? (r == a && !h->has_steps ? 1 : 0) : h->turn[r][a];
    return h->has_steps ? turn : turn * h->axis[r].step;
}

static iso_status take_geometry(const fits *h, const size_t *used, iso_volume_source *source, iso_error *err)
{
    size_t size[3];
    double step[3][3], first[3], mm[3];
    const char *name;
    bool are_lengths = true;
    for (int a = 0; a < 3; ++a) {
        const fits_axis *axis = &h->axis[used[a]];
        size[a] = (size_t)axis->size;
        are_lengths = *axis->unit && iso_unit_find(axis->unit, &mm[a], &name) && are_lengths;
    }
    for (int r = 0; r < 3; ++r) {
        first[r] = are_lengths ? h->axis[used[r]].value * mm[r] : -((double)size[r] - 1) / 2;
        for (int a = 0; a < 3; ++a) {
            step[a][r] = are_lengths ? step_of(h, used[r], used[a]) * mm[r] : r == a;
            first[r] += are_lengths ? (1 - h->axis[used[a]].pixel) * step[a][r] : 0;
        }
    }
    if (!are_lengths) {
        char what[120] = "of its voxels in a unit of length (its axes have: ";
        for (int a = 0; a < 3; ++a)
            iso_words_append(what, sizeof what, "%s%s", *h->axis[used[a]].unit ? h->axis[used[a]].unit : "none",
                             a < 2 ? ", " : ")");
        NEED(iso_source_need_spacing(source, what, err));
    }
    return iso_reader_place(source, size, step, first, "mm", err);
}

static iso_status take_image(const fits *h, iso_volume_source *source, iso_error *err)
{
    size_t used[MOST_AXES] = {0};
    const size_t count = used_axes(h, used);
    if (count > 4)
        return iso_fail(err, ISO_E_FORMAT, "%s: an image of %zu axes, must be 3, or 4 with frames", source->path,
                        count);
    for (size_t a = 0; a < count; ++a)
        if (!(h->axis[used[a]].size >= 1 && h->axis[used[a]].size < 1e9))
            return iso_fail(err, ISO_E_RANGE, "%s: NAXIS%zu is %g, must be 1 to 1e9", source->path, used[a] + 1,
                            h->axis[used[a]].size);
    if (h->scale == 0 || !isfinite(h->scale) || !isfinite(h->zero))
        return iso_fail(err, ISO_E_FORMAT, "%s: BSCALE is %g, BZERO %g, must be finite, and BSCALE not 0", source->path,
                        h->scale, h->zero);
    NEED(take_type(h, source, err));
    NEED(take_geometry(h, used, source, err));
    source->header.notes.scale_slope = h->scale;
    source->header.notes.scale_intercept = is_unsigned(h) ? 0 : h->zero;
    const iso_extra_axes axes = {.frame = {.count = count > 3 ? (size_t)h->axis[used[3]].size : 1, .stride = 1}};
    NEED(iso_source_choose(source, &axes, err));
    if (h->bits > 0)
        iso_source_note_fill(source, h->blank);
    return iso_source_take_part(source, source->path, (size_t)h->at, err);
}

static iso_status read_fits(FILE *f, iso_volume_source *source, iso_error *err)
{
    fits h = {0};
    NEED(find_image(f, source, &h, err));
    return take_image(&h, source, err);
}

const iso_volume_format iso_volume_format_fits = {
    .name = "fits",
    .title = "FITS",
    .summary = "images of 3 axes, with frames 4, FILE:PART; plane by plane",
    .suffixes = ".fits .fit .fts",
    .starts = "\"SIMPLE  =\"",
    .takes_part = true,
    .marks = {ISO_MARK(0, "SIMPLE  =")},
    .read = read_fits,
};
