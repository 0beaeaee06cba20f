/* SPDX-License-Identifier: MIT */
/* lab.h - the list of isoshade-lab's commands: they reproduce the four papers, rival methods and the experiments of
 * doc/results. src/lab/NAME.c defines iso_lab_NAME, an iso_command. No file outside src/lab includes one of these
 * headers. */
#pragma once

#include "options/cli.h"

#define ISO_LAB_LIST(X) \
    X(bound) \
    X(consistency) \
    X(convergence) \
    X(encode) \
    X(figure) \
    X(fit) \
    X(ghosts) \
    X(gradient) \
    X(levels) \
    X(palette) \
    X(plan) \
    X(power) \
    X(reference) \
    X(seams) \
    X(tf) \
    X(triangle)
