/* faults.h - planted faults: known ways for a renderer or an exporter to be wrong, so that tests and
 * `isoshade bench power` can show that each is rejected, and by which check. */
#ifndef ISO_CLI_FAULTS_H
#define ISO_CLI_FAULTS_H

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "render/scene.h"

/* enum, name, the check of calibrate.h that is made for it */
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

const char *iso_fault_name(iso_fault fault);  /* "nothing" for ISO_FAULT_NONE */
const char *iso_fault_check(iso_fault fault); /* NULL for it */

/* Spoils what a renderer is given: level `level` of p, and the view. */
void iso_fault_plant(iso_fault fault, iso_pyramid *p, size_t level, iso_view *view);
/* Faults of the picture itself. */
void iso_fault_spoil(iso_fault fault, iso_image *image);

#endif
