/* SPDX-License-Identifier: MIT */
/* encode_kernel.h - the encoders, one per code, and the decoder. They cannot fail, allocate or print.
 * directions: 3 finite floats each; bytes: 3 each, 6 for half. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* NAME uses AVX2 if the machine has it, NAME_baseline never; the bytes are the same. */
/* clang-format off */
#define ISO_ENCODER_LIST(X) \
    X(iso_encode_snorm)     \
    X(iso_encode_fit)       \
    X(iso_encode_shell)     \
    X(iso_encode_free)      \
    X(iso_encode_cube)      \
    X(iso_encode_region48)  \
    X(iso_encode_oct24)

#define ISO_ENCODER_DECLARE(name)                                                              \
    void name(const float *restrict directions, uint8_t *restrict bytes, size_t count);        \
    void name##_baseline(const float *restrict directions, uint8_t *restrict bytes, size_t count);
/* clang-format on */
ISO_ENCODER_LIST(ISO_ENCODER_DECLARE)
#undef ISO_ENCODER_DECLARE

void iso_encode_half(const float *restrict directions, uint8_t *restrict bytes, size_t count);

/* Decodes count lattice vectors to directions in single precision; decoder: ISO_DECODER_*; 3 floats per vector. */
void iso_decode_floats(int decoder, const float *restrict lattice, float *restrict directions, size_t count);
