/* SPDX-License-Identifier: MIT */
#include "pyramid/narrow.h"

#include <string.h>

void iso_level_scalars(const iso_level *level, const iso_volume *volume, size_t first, size_t count,
                       float *restrict out)
{
    if (level->scalar) {
        memcpy(out, level->scalar + first, count * sizeof *out);
        return;
    }
    switch (volume->type) {
/* clang-format off */
#define ISO_TYPE_CASE(name, text, ctype)                                \
    case name: {                                                        \
        const ctype *restrict in = (const ctype *)volume->data + first; \
        for (size_t i = 0; i < count; ++i)                              \
            out[i] = (float)in[i];                                      \
        break;                                                          \
    }
        /* clang-format on */
        ISO_TYPE_LIST(ISO_TYPE_CASE)
#undef ISO_TYPE_CASE
    }
}
