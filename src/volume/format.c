/* SPDX-License-Identifier: MIT */
#include "volume/format.h"

#include <string.h>

#define ISO_VOLUME_FORMAT_DECLARE(name) extern const iso_volume_format iso_volume_format_##name;
ISO_VOLUME_FORMAT_LIST(ISO_VOLUME_FORMAT_DECLARE)
#undef ISO_VOLUME_FORMAT_DECLARE

#define ISO_VOLUME_FORMAT_POINTER(name) &iso_volume_format_##name,
static const iso_volume_format *const formats[] = {ISO_VOLUME_FORMAT_LIST(ISO_VOLUME_FORMAT_POINTER)};
#undef ISO_VOLUME_FORMAT_POINTER
const iso_names iso_volume_format_names = ISO_NAMES_OF_POINTERS("volume format", formats);

enum { BUILT_IN = sizeof formats / sizeof *formats, ADDED_MAX = 32 };
static const iso_volume_format *added[ADDED_MAX];
static size_t added_count;

const iso_volume_format *iso_volume_format_at(size_t row)
{
    return row < BUILT_IN ? formats[row] : row - BUILT_IN < added_count ? added[row - BUILT_IN] : NULL;
}

bool iso_marks_fit(const iso_mark *marks, size_t count, const unsigned char *head, size_t size)
{
    for (size_t i = 0; i < count && marks[i].bytes; ++i)
        if (size >= marks[i].at + marks[i].size && memcmp(head + marks[i].at, marks[i].bytes, marks[i].size) == 0)
            return true;
    return false;
}

iso_status iso_volume_format_add(const iso_volume_format *format, iso_error *err)
{
    if (added_count == ADDED_MAX)
        return iso_fail(err, ISO_E_RANGE, "volume format %s: %d formats are added already, no more can be",
                        format->name, ADDED_MAX);
    added[added_count++] = format;
    return ISO_OK;
}

/* Returns the length of the longest word of `suffixes` that `name` ends with. */
static size_t longest_suffix(const char *suffixes, const char *name)
{
    const size_t length = strlen(name);
    size_t longest = 0;
    for (const char *at = suffixes + strspn(suffixes, " "); *at; at += strspn(at, " ")) {
        const size_t n = strcspn(at, " ");
        if (n < length && n > longest && strncmp(name + length - n, at, n) == 0)
            longest = n;
        at += n;
    }
    return longest;
}

size_t iso_volume_format_suffix_bytes(const char *name)
{
    size_t longest = 0;
    const iso_volume_format *f;
    for (size_t i = 0; (f = iso_volume_format_at(i)); ++i) {
        const size_t n = longest_suffix(f->suffixes, name);
        longest = n > longest ? n : longest;
    }
    return longest;
}
