/* SPDX-License-Identifier: MIT */
#include "encode/code.h"

#include <math.h>

#include "encode/code_kernel.h"
#include "encode/encode_kernel.h"

#define ISO_CODE_POINTER(code, row) [ISO_CODE_##code] = &iso_code_##row,
static const iso_code_info *const codes[] = {ISO_CODE_LIST(ISO_CODE_POINTER)};
#undef ISO_CODE_POINTER
const iso_names iso_code_names = ISO_NAMES_OF_POINTERS("direction code", codes);

const iso_code_info *iso_code_describe(iso_code code)
{
    return codes[code];
}

iso_status iso_code_from_name(const char *name, iso_code *code, iso_error *err)
{
    size_t row = 0;
    NEED(iso_names_find(&iso_code_names, name, &row, err));
    *code = (iso_code)row;
    return ISO_OK;
}

void iso_code_encode(iso_code code, const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    codes[code]->encode(directions, bytes, count);
}

void iso_code_lattice(iso_code code, const uint8_t *bytes, double e[3])
{
    if (codes[code]->lattice) {
        codes[code]->lattice(bytes, e);
        return;
    }
    for (int a = 0; a < 3; ++a)
        e[a] = codes[code]->is_signed ? fmax((int8_t)bytes[a] / 127.0, -1) : (2 * bytes[a] - 255) / 255.0;
}

void iso_code_decode(iso_code code, const double e[3], double d[3])
{
    iso_vec3 v = iso_decode(codes[code]->decoder, iso_v3(e[0], e[1], e[2]));
    d[0] = v.x;
    d[1] = v.y;
    d[2] = v.z;
}

/* Converts the bytes of count directions to lattice vectors. */
static void lattice_floats(iso_code code, const uint8_t *restrict bytes, float *restrict lattice, size_t count)
{
    if (!codes[code]->lattice) {
        if (codes[code]->is_signed)
            for (size_t i = 0; i < 3 * count; ++i)
                lattice[i] = (float)(int8_t)bytes[i] / 127.0f;
        else
            for (size_t i = 0; i < 3 * count; ++i)
                lattice[i] = (float)(2 * bytes[i] - 255) / 255.0f;
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        double e[3];
        iso_code_lattice(code, bytes + codes[code]->bytes * i, e);
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
        lattice_floats(code, bytes + codes[code]->bytes * at, lattice, n);
        iso_decode_floats(codes[code]->decoder, lattice, directions + 3 * at, n);
    }
}

void iso_code_normal(const double d[3], double n[3])
{
    iso_vec3 v = iso_shading_normal(iso_v3(d[0], d[1], d[2]));
    n[0] = v.x;
    n[1] = v.y;
    n[2] = v.z;
}
