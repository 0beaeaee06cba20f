/* SPDX-License-Identifier: MIT */
/* decode_kernel.h - conversion of lattice vectors to directions in single precision. */
#pragma once

#include <stddef.h>

/* Decodes count lattice vectors; decoder: ISO_DECODER_*; 3 floats per vector. */
void iso_decode_floats(int decoder, const float *restrict lattice, float *restrict directions, size_t count);
