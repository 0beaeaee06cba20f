/* SPDX-License-Identifier: MIT */
#include "tf/tf_2d.h"

#include <math.h>
#include <stdlib.h>

void iso_tf_2d_destroy(iso_tf_2d *t)
{
    if (!t)
        return;
    for (size_t c = 0; c < ISO_TF_2D_ROWS; ++c)
        iso_tf_table_destroy(&t->rows[c]);
    free(t->bytes);
    *t = (iso_tf_2d){0};
}

iso_status iso_tf_2d_envelope(const iso_tf_2d *t, iso_tf_table *envelope, iso_error *err)
{
    *envelope = t->rows[0];
    envelope->entries = calloc(4 * envelope->count, sizeof *envelope->entries);
    if (!envelope->entries) {
        *envelope = (iso_tf_table){0};
        return iso_fail(err, ISO_E_MEMORY, "transfer function: no memory for %zu entries", t->rows[0].count);
    }
    for (size_t c = 0; c < ISO_TF_2D_ROWS; ++c)
        for (size_t i = 0; i < 4 * envelope->count; ++i)
            envelope->entries[i] = fmaxf(envelope->entries[i], t->rows[c].entries[i]);
    return ISO_OK;
}
