/* encode_kernel.h - the encoders, one a code. They cannot fail, allocate or
 * print. directions: 3 finite floats each; bytes: 3 each. */
#ifndef ISO_ENCODE_KERNEL_H
#define ISO_ENCODE_KERNEL_H

#include <stddef.h>
#include <stdint.h>

void iso_encode_snorm(const float *restrict directions, uint8_t *restrict bytes, size_t count);
void iso_encode_region48(const float *restrict directions, uint8_t *restrict bytes, size_t count);

#endif
