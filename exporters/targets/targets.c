/* SPDX-License-Identifier: MIT */
#include "targets/targets.h"

#define ISO_EXPORT_TARGET_DECLARE(name) extern const iso_export_target iso_export_target_##name;
ISO_EXPORT_TARGET_LIST(ISO_EXPORT_TARGET_DECLARE)
#undef ISO_EXPORT_TARGET_DECLARE

#define ISO_EXPORT_TARGET_POINTER(name) &iso_export_target_##name,
static const iso_export_target *const targets[] = {ISO_EXPORT_TARGET_LIST(ISO_EXPORT_TARGET_POINTER)};
#undef ISO_EXPORT_TARGET_POINTER
const iso_names iso_export_target_names = ISO_NAMES_OF_POINTERS("export target", targets);

const iso_export_target *iso_export_target_at(size_t row)
{
    return targets[row];
}

const char *iso_export_option_text(iso_export_option option)
{
    static const char *const texts[] = {
#define ISO_EXPORT_OPTION_TEXT(option, text) text,
        ISO_EXPORT_OPTION_LIST(ISO_EXPORT_OPTION_TEXT)
#undef ISO_EXPORT_OPTION_TEXT
    };
    return texts[option];
}
