/* SPDX-License-Identifier: MIT */
#include "base/simd.h"

#include <stdint.h>
#include <string.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

void iso_copy_streaming(void *restrict to, const void *restrict from, size_t bytes)
{
#ifdef __SSE2__
    char *out = to;
    const char *in = from;
    size_t head = (64 - (uintptr_t)out % 64) % 64;
    if (bytes >= head + 64) {
        memcpy(out, in, head);
        size_t at = head;
        for (; at + 64 <= bytes; at += 64) /* a cache line at a time: it goes out whole */
            for (size_t i = 0; i < 64; i += 16)
                _mm_stream_si128((__m128i *)(void *)(out + at + i),
                                 _mm_loadu_si128((const __m128i *)(const void *)(in + at + i)));
        memcpy(out + at, in + at, bytes - at);
        return;
    }
#endif
    memcpy(to, from, bytes);
}
