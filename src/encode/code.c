#include "encode/code.h"

#include <math.h>
#include <string.h>

#include "encode/decode_double.h"
#include "encode/encode_kernel.h"

static const iso_code_info infos[ISO_CODE_COUNT] = {
    [ISO_CODE_SNORM] = {.name = "snorm",
                        .help = "signed bytes of the vector itself; keeps its length",
                        .is_signed = true,
                        .keeps_length = true,
                        .is_linear = true,
                        .decoder = ISO_DECODER_LINEAR},
    [ISO_CODE_REGION48] = {.name = "region48",
                           .help = "48 regions, lambda 0.61 (gradients-2017); direction only",
                           .decoder = ISO_DECODER_REGION48},
};

const iso_code_info *iso_code_describe(iso_code code)
{
    return &infos[code];
}

iso_status iso_code_from_name(const char *name, iso_code *code, iso_error *err)
{
    char known[256] = "";
    for (int i = 0; i < ISO_CODE_COUNT; ++i) {
        if (strcmp(infos[i].name, name) == 0) {
            *code = (iso_code)i;
            return ISO_OK;
        }
        strncat(known, " ", sizeof known - strlen(known) - 1);
        strncat(known, infos[i].name, sizeof known - strlen(known) - 1);
    }
    return iso_fail(err, ISO_E_USAGE, "direction code \"%s\" is unknown; there are:%s", name, known);
}

void iso_code_encode(iso_code code, const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    if (code == ISO_CODE_REGION48)
        iso_encode_region48(directions, bytes, count);
    else
        iso_encode_snorm(directions, bytes, count);
}

void iso_code_lattice(iso_code code, const uint8_t bytes[3], double e[3])
{
    for (int a = 0; a < 3; ++a)
        e[a] = infos[code].is_signed ? fmax((int8_t)bytes[a] / 127.0, -1) : (2 * bytes[a] - 255) / 255.0;
}

void iso_code_decode(iso_code code, const double e[3], double d[3])
{
    iso_vec3 v = iso_decode(infos[code].decoder, iso_v3(e[0], e[1], e[2]));
    d[0] = v.x;
    d[1] = v.y;
    d[2] = v.z;
}

void iso_code_decode_all(iso_code code, const uint8_t *restrict bytes, float *restrict directions, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        double e[3], d[3];
        iso_code_lattice(code, bytes + 3 * i, e);
        iso_code_decode(code, e, d);
        for (int a = 0; a < 3; ++a)
            directions[3 * i + a] = (float)d[a];
    }
}

void iso_code_normal(const double d[3], double n[3])
{
    iso_vec3 v = iso_shading_normal(iso_v3(d[0], d[1], d[2]));
    n[0] = v.x;
    n[1] = v.y;
    n[2] = v.z;
}
