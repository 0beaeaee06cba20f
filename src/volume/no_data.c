/* SPDX-License-Identifier: MIT */
/* no_data.c - voxels without data: NaN, the file's fill values, or the caller's range of values. They become
 * ISO_NO_DATA while samples are read, so that all formats have them in the same way. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "volume/half.h"
#include "volume/stream_kernel.h"

iso_status iso_no_data_parse(const char *text, iso_no_data *rule, iso_error *err)
{
    char *end;
    *rule = (iso_no_data){0};
    if (!text)
        return ISO_OK;
    rule->is_given = true;
    rule->is_none = strcmp(text, "none") == 0;
    if (rule->is_none)
        return ISO_OK;
    rule->lo = rule->hi = strtod(text, &end);
    bool is_good = end != text;
    if (is_good && *end == ',') {
        const char *second = end + 1;
        rule->hi = strtod(second, &end);
        is_good = end != second;
    }
    if (!is_good || *end || !(rule->lo <= rule->hi))
        return iso_fail(err, ISO_E_USAGE, "--no-data is \"%s\", must be a value, a range such as -3024,-1025, or none",
                        text);
    return ISO_OK;
}

double iso_form_value(iso_form form, const void *cells, size_t at)
{
    switch (form) {
    case ISO_FORM_HALF: return (double)iso_half_to_float(((const uint16_t *)cells)[at]);
    case ISO_FORM_I64: return (double)((const int64_t *)cells)[at];
    case ISO_FORM_U64: return (double)((const uint64_t *)cells)[at];
    case ISO_FORM_U64_OF_FITS: return (double)(((const uint64_t *)cells)[at] ^ (uint64_t)1 << 63);
    default: return ((const double *)cells)[at];
    }
}

/* Returns sample `at` of the file. */
static double stored_value(const iso_volume_source *s, const void *cells, size_t at)
{
    if (s->form)
        return iso_form_value(s->form, cells, at);
/* clang-format off */
#define ISO_STORED_CASE(name, text, ctype) case name: return (double)((const ctype *)cells)[at];
    /* clang-format on */
    switch (iso_source_stored_type(s)) {
        ISO_TYPE_LIST(ISO_STORED_CASE)
    }
#undef ISO_STORED_CASE
    return NAN;
}

/* True if a sample means no data. stored: in the file; given: to the caller. */
static bool is_absent(const iso_volume_source *s, double stored, double given)
{
    const iso_no_data *rule = &s->hints.no_data;
    if (isnan(given))
        return !rule->is_none;
    if (rule->is_given && !rule->is_none && given >= rule->lo && given <= rule->hi)
        return true;
    for (size_t f = 0; s->has_fills && f < s->look.fill_count; ++f)
        if (stored == s->look.fill[f])
            return true;
    return false;
}

void iso_source_mark_no_data(const iso_volume_source *s, const void *cells, size_t count, void *out)
{
    const iso_source_choice *c = &s->choice;
    float *floats = s->header.type == ISO_F32 ? out : NULL;
    double *doubles = s->header.type == ISO_F64 ? out : NULL;
    const bool only_nan = !s->has_fills && !s->hints.no_data.is_given;
    for (size_t i = 0; i < count && (floats || doubles); ++i) {
        const double given = floats ? (double)floats[i] : doubles[i];
        if (only_nan && !isnan(given))
            continue;
        if (!is_absent(s, s->has_fills ? stored_value(s, cells, i * c->inside_count + c->inside_at) : 0, given))
            continue;
        if (floats)
            floats[i] = ISO_NO_DATA;
        else
            doubles[i] = (double)ISO_NO_DATA;
    }
}

void iso_source_hold_no_data(iso_volume_source *s)
{
    if (s->header.type == ISO_F32 || s->header.type == ISO_F64)
        return;
    if (s->form)
        s->header.type = ISO_F64;
    else
        iso_source_make_floats(s);
}

/* True if voxels have fill values outside of the range of all others. A fill value among them is a value, and zero
 * next to a single other value is a mask's. */
static bool fills_stand_out(const iso_source_look *k)
{
    const bool is_zero = k->least_fill == 0 && k->most_fill == 0;
    if (k->filled == 0 || (k->hi == k->lo && is_zero))
        return false;
    return !(k->least_fill >= k->lo && k->most_fill <= k->hi);
}

iso_status iso_source_look_for_fills(iso_volume_source *all, bool *found, iso_error *err)
{
    const size_t *n = all->header.geometry.size;
    FREED char *plane = malloc(n[0] * n[1] * iso_type_bytes(all->header.type));
    NEED_MEMORY(plane, err, "%s: no memory for a plane", all->path);
    all->only_looks = true;
    for (size_t z = 0; z < n[2]; ++z)
        NEED(iso_source_read(all, 1, plane, err));
    *found = fills_stand_out(&all->look);
    return ISO_OK;
}
