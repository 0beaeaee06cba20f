/* SPDX-License-Identifier: MIT */
/* codes.h - random directions, and what a code makes of them. */
#pragma once

#include "base/linalg.h"
#include "base/random.h"
#include "encode/code.h"

static const double degree = 0.017453292519943295;

static uint64_t random_state = 20170613; /* the seed of every random test here */
static double uniform(void)
{
    return iso_xorshift_unit(&random_state);
}

static iso_vec3 random_direction(void)
{
    double z = 2 * uniform() - 1, phi = 6.283185307179586 * uniform(), r = sqrt(1 - z * z);
    return iso_v3(r * cos(phi), r * sin(phi), z);
}

/* What a nearest fetch decodes to. */
static iso_vec3 round_trip(iso_code code, iso_vec3 d)
{
    float in[3] = {(float)d.x, (float)d.y, (float)d.z}, out[3];
    uint8_t bytes[8];
    iso_code_encode(code, in, bytes, 1);
    iso_code_decode_all(code, bytes, out, 1);
    return iso_v3(out[0], out[1], out[2]);
}

static double angle_deg(iso_vec3 a, iso_vec3 b)
{
    return atan2(iso_norm(iso_cross(a, b)), iso_dot(a, b)) / degree;
}
