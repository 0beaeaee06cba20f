/* SPDX-License-Identifier: MIT */
/* faults.h - planted faults: known ways for a renderer or an exporter to be wrong. Tests and `isoshade-lab power` show
 * that the check of each fault rejects it, if its amount is large enough. */
#pragma once

#include "validate/calibrate.h"

/* enum, name, the check of calibrate.h that must find it */
/* clang-format off */
#define ISO_FAULT_LIST(X)                                                                    \
    X(ISO_FAULT_HALF_VOXEL, "the volume stands half a voxel off", "placement")               \
    X(ISO_FAULT_MIRRORED, "the direction matrix is mirrored along x", "placement")           \
    X(ISO_FAULT_STALE, "the volume is an older one", "placement")                            \
    X(ISO_FAULT_UNIT, "extinction is for 10 % more length", "slab")                          \
    X(ISO_FAULT_PREMULTIPLIED, "color is multiplied by alpha twice", "slab")                \
    X(ISO_FAULT_SRGB, "the TF's colors are taken for sRGB", "transfer function")            \
    X(ISO_FAULT_RANGE, "the TF's range is off by one entry", "transfer function")            \
    X(ISO_FAULT_LEVEL, "the level is off by one", "transfer function")                       \
    X(ISO_FAULT_AXIS_SWAP, "x and y of the directions are exchanged", "light")               \
    X(ISO_FAULT_NOT_INVERSE_TRANSPOSE, "gradients go to the world by the matrix itself", "light") \
    X(ISO_FAULT_LIGHT, "the light comes from the mirrored side", "light")                    \
    X(ISO_FAULT_ONE_SIDED, "the light is one-sided", "light")                                \
    X(ISO_FAULT_CLIPPED, "radiance is clipped at 1", "light")                                \
    X(ISO_FAULT_ORDER, "back and front are exchanged along the ray", "order")                \
    X(ISO_FAULT_VIEW_VECTOR, "highlights are those of the other projection", "view vector")  \
    X(ISO_FAULT_INTERPOLATION, "directions are not normalized after filtering", "interpolation")
/* clang-format on */

typedef enum iso_fault {
    ISO_FAULT_NONE,
#define ISO_FAULT_ENUM(name, text, check) name,
    ISO_FAULT_LIST(ISO_FAULT_ENUM)
#undef ISO_FAULT_ENUM
        ISO_FAULT_COUNT
} iso_fault;

const char *iso_fault_name(iso_fault fault);  /* "nothing" for ISO_FAULT_NONE */
const char *iso_fault_check(iso_fault fault); /* NULL for ISO_FAULT_NONE */

/* Faults with an amount, to find the smallest amount that is rejected: enum, name, unit, an obvious amount, the
 * check. An amount of 1 percent multiplies a length, an exponent ... by 1.01. */
/* clang-format off */
#define ISO_DEVIATION_LIST(X)                                                                      \
    X(ISO_DEVIATION_SHIFT, "the volume is shifted along all axes", "voxel", 0.5, "placement")      \
    X(ISO_DEVIATION_SPACING, "voxels are longer along x", "percent", 20.0, "placement")            \
    X(ISO_DEVIATION_CAMERA, "the camera sees more", "percent", 20.0, "placement")                  \
    X(ISO_DEVIATION_UNIT, "extinction is for more length", "percent", 20.0, "slab")                \
    X(ISO_DEVIATION_GAIN, "radiance is too bright", "percent", 20.0, "slab")                       \
    X(ISO_DEVIATION_PIXEL, "the middle pixel is too bright", "of 1", 1.0, "slab")                  \
    X(ISO_DEVIATION_GAMMA, "the TF's colors have a gamma", "percent", 120.0, "transfer function") \
    X(ISO_DEVIATION_RANGE, "the TF's range ends too late", "entry", 2.0, "transfer function")      \
    X(ISO_DEVIATION_DIRECTIONS, "the directions are turned", "degree", 20.0, "light")              \
    X(ISO_DEVIATION_LIGHT, "the lights are turned", "degree", 20.0, "light")                       \
    X(ISO_DEVIATION_EXPONENT, "the highlight's exponent is larger", "percent", 100.0, "light")
/* clang-format on */

typedef enum iso_deviation {
    ISO_DEVIATION_NONE,
#define ISO_DEVIATION_ENUM(name, text, unit, most, check) name,
    ISO_DEVIATION_LIST(ISO_DEVIATION_ENUM)
#undef ISO_DEVIATION_ENUM
        ISO_DEVIATION_COUNT
} iso_deviation;

const char *iso_deviation_name(iso_deviation d);  /* "nothing" for ISO_DEVIATION_NONE */
const char *iso_deviation_unit(iso_deviation d);  /* NULL for ISO_DEVIATION_NONE */
const char *iso_deviation_check(iso_deviation d); /* NULL for ISO_DEVIATION_NONE */
double iso_deviation_most(iso_deviation d);

/* A planted change: a fault, a deviation of an amount, or, zeroed, nothing. */
typedef struct iso_planted {
    iso_fault fault;
    iso_deviation deviation;
    double amount;
} iso_planted;

/* Returns the deviation that undoes *planted: exact, except that directions are encoded again. */
iso_planted iso_planted_inverse(const iso_planted *planted);

/* Puts the fault into a renderer's input: level `level` of p, and the view. planted NULL: no fault. */
void iso_plant(const iso_planted *planted, iso_pyramid *p, size_t level, iso_view *view);
/* Returns the level to render instead of `level`. */
size_t iso_planted_level(const iso_planted *planted, size_t level);
/* Returns a hook that puts faults of images into each rendered image; *planted has to outlive it. */
iso_image_hook iso_planted_hook(const iso_planted *planted);
/* Returns *planted as a fault of a calibration; *planted has to outlive it. */
iso_calibration_fault iso_planted_calibration(const iso_planted *planted);

/* Calls iso_plant() with only a fault. */
void iso_fault_plant(iso_fault fault, iso_pyramid *p, size_t level, iso_view *view);
