/* encode_snorm.c - the vector itself, rounded to 1/127. */
#include <math.h>

#include "encode/encode_kernel.h"

void iso_encode_snorm(const float *restrict directions, uint8_t *restrict bytes, size_t count)
{
    for (size_t i = 0; i < 3 * count; ++i) {
        float scaled = fminf(fmaxf(127 * directions[i], -127), 127);
        bytes[i] = (uint8_t)(int8_t)lrintf(scaled);
    }
}
