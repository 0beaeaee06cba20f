/* SPDX-License-Identifier: MIT */
/* methods.h - methods of `isoshade-lab consistency` to show a coarse level: the original TF, and ways to adapt it. */
#pragma once

#include "tf/adapt.h"

typedef struct iso_lab_method {
    const char *name;
    bool adapt;
    iso_adapt_options options;
    iso_second_value tf_2d; /* second value of a 2D transfer function, or 0 */
    bool extinction_scale;  /* uses a scale made for the transfer function (fit/extinction_scale.h) */
} iso_lab_method;

/* Method 0 is the original. */
enum { ISO_LAB_METHOD_COUNT = 13 };
extern const iso_lab_method iso_lab_methods[ISO_LAB_METHOD_COUNT];

/* Parses "all" or names separated by commas; the original is always included. ISO_E_USAGE: unknown name. */
iso_status iso_lab_choose_methods(const char *text, bool wanted[ISO_LAB_METHOD_COUNT], iso_error *err);
