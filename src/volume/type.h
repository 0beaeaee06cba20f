/* SPDX-License-Identifier: MIT */
/* type.h - sample types of volumes. */
#pragma once

#include <stdbool.h>
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

/* Treatment of slices at uneven distances, or with gaps. */
typedef enum iso_uneven {
    ISO_UNEVEN_REFUSE,
    ISO_UNEVEN_RESAMPLE, /* linear interpolation at the smallest distance of two */
    ISO_UNEVEN_FORCE     /* all are taken for equally far apart */
} iso_uneven;

/* Value of voxels without data, in volumes and levels of floats and doubles. No renderer shows it, no range, histogram,
 * mean or gradient counts it. */
#define ISO_NO_DATA (-0x1p100f)
static inline bool iso_is_no_data(float value)
{
    return value == ISO_NO_DATA;
}

/* Samples of files that no iso_type describes. */
typedef enum iso_form {
    ISO_FORM_TYPE, /* an iso_type does */
    ISO_FORM_HALF, /* floats of 16 bits */
    ISO_FORM_I64,  /* integers of 64 bits, with a sign, or */
    ISO_FORM_U64,  /* without one, or */
    ISO_FORM_U64_OF_FITS, /* less 2^63, or */
    ISO_FORM_WHOLE /* as doubles */
} iso_form;

const char *iso_type_name(iso_type type);
size_t iso_type_bytes(iso_type type);
/* Finds a type by its name. ISO_E_USAGE lists the names. */
iso_status iso_type_from_name(const char *name, iso_type *type, iso_error *err);
/* Finds a type or a form of files by its name, such as float16, float32 or int64. ISO_E_USAGE lists the names. */
iso_status iso_file_type_from_name(const char *name, iso_type *type, iso_form *form, iso_error *err);
