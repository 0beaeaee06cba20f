/* SPDX-License-Identifier: MIT */
#include "tf/format.h"

#include <stdio.h>
#include <string.h>

#include "base/file.h"

#define ISO_TF_FORMAT_DECLARE(name) extern const iso_tf_format iso_tf_format_##name;
ISO_TF_FORMAT_LIST(ISO_TF_FORMAT_DECLARE)
#undef ISO_TF_FORMAT_DECLARE

#define ISO_TF_FORMAT_POINTER(name) &iso_tf_format_##name,
static const iso_tf_format *const formats[] = {ISO_TF_FORMAT_LIST(ISO_TF_FORMAT_POINTER)};
#undef ISO_TF_FORMAT_POINTER
enum { FORMAT_COUNT = sizeof formats / sizeof *formats };

const iso_names iso_tf_format_names = ISO_NAMES_OF_POINTERS("transfer-function format", formats);

const iso_tf_format *iso_tf_format_at(size_t row)
{
    return row < FORMAT_COUNT ? formats[row] : NULL;
}

const iso_tf_format *iso_tf_format_of(const char *path)
{
    const iso_tf_format *found = NULL;
    for (size_t i = 0; i < FORMAT_COUNT; ++i)
        if (iso_path_ends_with(path, formats[i]->suffix) &&
            (!found || strlen(formats[i]->suffix) > strlen(found->suffix)))
            found = formats[i];
    return found;
}

char *iso_tf_format_written(char *text, size_t size)
{
    size_t length = 0, left = 0;
    for (size_t i = 0; i < FORMAT_COUNT; ++i)
        left += formats[i]->save != NULL;
    text[0] = '\0';
    for (size_t i = 0; i < FORMAT_COUNT && length < size; ++i)
        if (formats[i]->save) {
            --left;
            length += (size_t)snprintf(text + length, size - length, "%s%s", formats[i]->suffix,
                                       left > 1    ? ", "
                                       : left == 1 ? " or "
                                                   : "");
        }
    return text;
}

iso_status iso_tf_load(const char *path, iso_tf *tf, iso_error *err)
{
    const iso_tf_format *format = iso_tf_format_of(path);
    if (!format || !format->load) /* what it is not is said by the reader of our own format */
        format = &iso_tf_format_json;
    return format->load(path, tf, err);
}
