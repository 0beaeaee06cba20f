/* SPDX-License-Identifier: MIT */
/* lab.h - the one list of isoshade-lab's commands: what reproduces the four papers, rival methods, and the experiments
 * whose tables stand in doc/results. src/lab/NAME.c defines iso_lab_NAME, which is called and parses as a command of
 * isoshade does. Nothing outside src/lab includes a file of it. */
#ifndef ISO_LAB_H
#define ISO_LAB_H

#include "options/cli.h"

#define ISO_LAB_LIST(X) \
    X(bound) \
    X(consistency) \
    X(convergence) \
    X(encode) \
    X(extinction_scale) \
    X(figure) \
    X(fit) \
    X(ghosts) \
    X(gradient) \
    X(levels) \
    X(noise) \
    X(palette) \
    X(plan) \
    X(power) \
    X(reference) \
    X(roi) \
    X(seams) \
    X(tf)

#endif
