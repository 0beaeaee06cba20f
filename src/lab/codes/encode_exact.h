/* SPDX-License-Identifier: MIT */
/* encode_exact.h - searches for the best codes, to judge the encoders of src/encode. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* Searches exhaustively in double precision over every lattice point that could be best for fit and for region48. Slow. */
void iso_encode_fit_exact(const float *restrict directions, uint8_t *restrict bytes, size_t count);
/* Finds the best fit with another mu (fit.h), the same for all lengths. */
void iso_encode_fit_with_mu(double mu, const float *restrict directions, uint8_t *restrict bytes, size_t count);
void iso_encode_region48_exact(const float *restrict directions, uint8_t *restrict bytes, size_t count);
