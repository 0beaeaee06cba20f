/* calibrate.h - may a renderer be trusted? Four tiny volumes whose images are
 * known in closed form, so that no renderer is measured by another.
 *
 *   placement          a small blob off the centre of a rotated, anisotropic grid: the
 *                      centroid of the optical depth is the projection of the centroid
 *                      of the voxels. Half a voxel is about one pixel.
 *   slab               a constant volume, rotated, in perspective: 1 - exp(-sigma chord)
 *                      in every pixel.
 *   transfer function  a ramp seen from the side: every column shows one value, so the
 *                      colours and extinctions of the table stand side by side.
 *   light              a linear field has one gradient everywhere: one shade, by the
 *                      inverse transpose of the rotated, anisotropic matrix, from
 *                      behind, with a highlight above 1. */
#ifndef ISO_CLI_CALIBRATE_H
#define ISO_CLI_CALIBRATE_H

#include "cli/renderers.h"

enum { ISO_CALIBRATION_COUNT = 4 };

typedef struct iso_calibration {
    const char *check;
    const char *unit;
    double value, limit; /* trusted while value <= limit */
    const char *why;     /* the cause of the limit */
    bool passed;
} iso_calibration;

/* Planted faults, so that tests can show that each is rejected by the check made for it: enum, name, check. */
#define ISO_FAULT_LIST(X)                                                                    \
    X(ISO_FAULT_HALF_VOXEL, "the volume stands half a voxel off", "placement")               \
    X(ISO_FAULT_MIRRORED, "the direction matrix is mirrored along x", "placement")           \
    X(ISO_FAULT_STALE, "the volume is an older one", "placement")                            \
    X(ISO_FAULT_UNIT, "extinction is for 10 % more length", "slab")                          \
    X(ISO_FAULT_PREMULTIPLIED, "colour is multiplied by alpha twice", "slab")                \
    X(ISO_FAULT_SRGB, "the TF's colours are taken for sRGB", "transfer function")            \
    X(ISO_FAULT_RANGE, "the TF's range is off by one entry", "transfer function")            \
    X(ISO_FAULT_LEVEL, "the level is off by one", "transfer function")                       \
    X(ISO_FAULT_AXIS_SWAP, "x and y of the directions are exchanged", "light")               \
    X(ISO_FAULT_NOT_INVERSE_TRANSPOSE, "gradients go to the world by the matrix itself", "light") \
    X(ISO_FAULT_LIGHT, "the light comes from the mirrored side", "light")                    \
    X(ISO_FAULT_ONE_SIDED, "the light is one-sided", "light")                                \
    X(ISO_FAULT_CLIPPED, "radiance is clipped at 1", "light")

typedef enum iso_fault {
    ISO_FAULT_NONE,
#define ISO_FAULT_ENUM(name, text, check) name,
    ISO_FAULT_LIST(ISO_FAULT_ENUM)
#undef ISO_FAULT_ENUM
    ISO_FAULT_COUNT
} iso_fault;

/* ISO_OK when all checks could be made, passed or not. */
iso_status iso_calibrate(iso_renderers *r, iso_renderer which, iso_fault fault, iso_calibration out[ISO_CALIBRATION_COUNT],
                         const iso_progress *progress, iso_error *err);

#endif
