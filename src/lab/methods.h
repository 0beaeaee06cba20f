/* SPDX-License-Identifier: MIT */
/* methods.h - the transfer functions of a coarse level that `isoshade-lab consistency` compares: the original, and ways to adapt it. */
#ifndef ISO_LAB_METHODS_H
#define ISO_LAB_METHODS_H

#include "tf/adapt.h"

typedef struct iso_lab_method {
    const char *name;
    bool adapt;
    iso_adapt_options options;
    iso_second_value tf_2d; /* of a 2D transfer function, or 0 */
    bool extinction_scale;  /* made for the transfer function (fit/extinction_scale.h) */
} iso_lab_method;

/* The first is the original. */
enum { ISO_LAB_METHOD_COUNT = 13 };
extern const iso_lab_method iso_lab_methods[ISO_LAB_METHOD_COUNT];

/* Which are named in `text`: "all", or names separated by commas; the original always. ISO_E_USAGE: another word. */
iso_status iso_lab_choose_methods(const char *text, bool wanted[ISO_LAB_METHOD_COUNT], iso_error *err);

#endif
