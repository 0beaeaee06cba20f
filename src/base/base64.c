/* SPDX-License-Identifier: MIT */
#include "base/base64.h"

void iso_base64_put(FILE *f, const unsigned char *bytes, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char text[4096];
    size_t used = 0;
    for (size_t i = 0; i < size; i += 3) {
        const unsigned n = (unsigned)bytes[i] << 16 | (i + 1 < size ? (unsigned)bytes[i + 1] << 8 : 0) |
                           (i + 2 < size ? bytes[i + 2] : 0);
        text[used++] = digits[n >> 18];
        text[used++] = digits[n >> 12 & 63];
        text[used++] = i + 1 < size ? digits[n >> 6 & 63] : '=';
        text[used++] = i + 2 < size ? digits[n & 63] : '=';
        if (used == sizeof text) {
            fwrite(text, 1, used, f);
            used = 0;
        }
    }
    fwrite(text, 1, used, f);
}
