/* SPDX-License-Identifier: MIT */
/* type.h - sample types of volumes. */
#ifndef ISO_VOLUME_TYPE_H
#define ISO_VOLUME_TYPE_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* enum, name, C type */
/* clang-format off */
#define ISO_TYPE_LIST(X)              \
    X(ISO_U8, "uint8", uint8_t)       \
    X(ISO_I8, "int8", int8_t)         \
    X(ISO_U16, "uint16", uint16_t)    \
    X(ISO_I16, "int16", int16_t)      \
    X(ISO_U32, "uint32", uint32_t)    \
    X(ISO_I32, "int32", int32_t)      \
    X(ISO_F32, "float", float)        \
    X(ISO_F64, "double", double)
/* clang-format on */

typedef enum iso_type {
#define ISO_TYPE_ENUM(name, text, ctype) name,
    ISO_TYPE_LIST(ISO_TYPE_ENUM)
#undef ISO_TYPE_ENUM
} iso_type;

/* What becomes of slices that are not equally far apart, or of which some are missing. */
typedef enum iso_uneven {
    ISO_UNEVEN_REFUSE,
    ISO_UNEVEN_RESAMPLE, /* linear interpolation at the smallest distance of two */
    ISO_UNEVEN_FORCE     /* all are taken for equally far apart */
} iso_uneven;

const char *iso_type_name(iso_type type);
size_t iso_type_bytes(iso_type type);
/* Finds a type by its name. ISO_E_USAGE lists the names. */
iso_status iso_type_from_name(const char *name, iso_type *type, iso_error *err);

#endif
