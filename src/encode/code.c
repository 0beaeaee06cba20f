/* SPDX-License-Identifier: MIT */
#include "encode/code.h"

#include <math.h>
#include <string.h>

#include "encode/decode_double.h"
#include "encode/decode_kernel.h"
#include "encode/encode_kernel.h"

typedef void encoder(const float *restrict directions, uint8_t *restrict bytes, size_t count);

static const struct {
    iso_code_info info;
    encoder *encode;
} codes[ISO_CODE_COUNT] = {
    [ISO_CODE_SNORM] = {{.name = "snorm",
                         .help = "signed bytes of the vector itself, rounded",
                         .bytes = 3,
                         .is_textured = true,
                         .is_signed = true,
                         .keeps_length = true,
                         .is_linear = true,
                         .decoder = ISO_DECODER_LINEAR},
                        iso_encode_snorm},
    [ISO_CODE_FIT] = {{.name = "fit",
                       .help = "signed bytes near the vector, with the best direction at almost its length",
                       .bytes = 3,
                       .is_textured = true,
                       .is_signed = true,
                       .keeps_length = true,
                       .is_linear = true,
                       .decoder = ISO_DECODER_LINEAR},
                      iso_encode_fit},
    [ISO_CODE_SHELL] = {{.name = "shell",
                         .help = "the best direction at a length of 0.95 to 1; direction only",
                         .bytes = 3,
                         .is_textured = true,
                         .is_signed = true,
                         .is_linear = true,
                         .decoder = ISO_DECODER_LINEAR},
                        iso_encode_shell},
    [ISO_CODE_FREE] = {{.name = "free",
                        .help = "the best direction at any length; direction only",
                        .bytes = 3,
                        .is_textured = true,
                        .is_signed = true,
                        .decoder = ISO_DECODER_UNIT},
                       iso_encode_free},
    [ISO_CODE_CUBE] = {{.name = "cube",
                        .help = "projected on the cube and rounded; direction only",
                        .bytes = 3,
                        .is_textured = true,
                        .decoder = ISO_DECODER_UNIT},
                       iso_encode_cube},
    [ISO_CODE_REGION48] = {{.name = "region48",
                            .help = "48 regions, lambda 0.61 (gradients-2017); direction only",
                            .bytes = 3,
                            .is_textured = true,
                            .decoder = ISO_DECODER_REGION48},
                           iso_encode_region48},
    [ISO_CODE_SQUEEZE] = {{.name = "squeeze",
                           .help = "48 regions, half the hole of region48; direction only",
                           .bytes = 3,
                           .is_textured = true,
                           .decoder = ISO_DECODER_SQUEEZE},
                          iso_encode_squeeze},
    [ISO_CODE_OCT24] = {{.name = "oct24",
                         .help = "octahedral map, 12 + 12 bits, for nearest fetches; direction only",
                         .bytes = 3,
                         .decoder = ISO_DECODER_OCT},
                        iso_encode_oct24},
    [ISO_CODE_HALF] = {{.name = "half",
                        .help = "three half floats",
                        .bytes = 6,
                        .is_signed = true,
                        .keeps_length = true,
                        .is_linear = true,
                        .decoder = ISO_DECODER_LINEAR},
                       iso_encode_half},
};

const iso_code_info *iso_code_describe(iso_code code)
{
    return &codes[code].info;
}

iso_status iso_code_from_name(const char *name, iso_code *code, iso_error *err)
{
    char known[256] = "";
    for (int i = 0; i < ISO_CODE_COUNT; ++i) {
        if (strcmp(codes[i].info.name, name) == 0) {
            *code = (iso_code)i;
            return ISO_OK;
        }
        strncat(known, " ", sizeof known - strlen(known) - 1);
        strncat(known, codes[i].info.name, sizeof known - strlen(known) - 1);
    }
    return iso_fail(err, ISO_E_USAGE, "direction code \"%s\" is unknown; there are:%s", name, known);
}

void iso_code_encode(iso_code code, const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    codes[code].encode(directions, bytes, count);
}

static double from_half(const uint8_t *bytes)
{
    int bits = bytes[0] | bytes[1] << 8, exponent = bits >> 10 & 31, fraction = bits & 1023;
    double size = exponent ? ldexp(1024 + fraction, exponent - 25) : ldexp(fraction, -24);
    return bits & 0x8000 ? -size : size;
}

void iso_code_lattice(iso_code code, const uint8_t *bytes, double e[3])
{
    if (code == ISO_CODE_OCT24) {
        e[0] = 2 * (bytes[0] | (bytes[1] & 15) << 8) / 4095.0 - 1;
        e[1] = 2 * (bytes[1] >> 4 | bytes[2] << 4) / 4095.0 - 1;
        e[2] = 0;
        return;
    }
    for (int a = 0; a < 3; ++a)
        e[a] = code == ISO_CODE_HALF          ? from_half(bytes + 2 * a)
               : codes[code].info.is_signed ? fmax((int8_t)bytes[a] / 127.0, -1)
                                              : (2 * bytes[a] - 255) / 255.0;
}

void iso_code_decode(iso_code code, const double e[3], double d[3])
{
    iso_vec3 v = iso_decode(codes[code].info.decoder, iso_v3(e[0], e[1], e[2]));
    d[0] = v.x;
    d[1] = v.y;
    d[2] = v.z;
}

/* The three bytes of each of count directions to lattice vectors. */
static void lattice_floats(iso_code code, const uint8_t *restrict bytes, float *restrict lattice, size_t count)
{
    if (codes[code].info.bytes == 3 && codes[code].info.is_textured) {
        if (codes[code].info.is_signed)
            for (size_t i = 0; i < 3 * count; ++i)
                lattice[i] = (float)(int8_t)bytes[i] / 127.0f;
        else
            for (size_t i = 0; i < 3 * count; ++i)
                lattice[i] = (float)(2 * bytes[i] - 255) / 255.0f;
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        double e[3];
        iso_code_lattice(code, bytes + codes[code].info.bytes * i, e);
        for (int a = 0; a < 3; ++a)
            lattice[3 * i + a] = (float)e[a];
    }
}

void iso_code_decode_all(iso_code code, const uint8_t *restrict bytes, float *restrict directions, size_t count)
{
    enum { BLOCK = 256 };
    float lattice[3 * BLOCK];
    for (size_t at = 0; at < count; at += BLOCK) {
        size_t n = count - at < BLOCK ? count - at : BLOCK;
        lattice_floats(code, bytes + codes[code].info.bytes * at, lattice, n);
        iso_decode_floats(codes[code].info.decoder, lattice, directions + 3 * at, n);
    }
}

void iso_code_normal(const double d[3], double n[3])
{
    iso_vec3 v = iso_shading_normal(iso_v3(d[0], d[1], d[2]));
    n[0] = v.x;
    n[1] = v.y;
    n[2] = v.z;
}
