/* SPDX-License-Identifier: MIT */
/* fit.h - the constants of the best fits, shared by the encoders and their exact
 * counterparts. */
#pragma once

/* The fit minimizes the error across the direction plus mu times the error along it (the length): a length may be off
 * by 1/mu times as much as a direction. If two directions theta apart are filtered, a relative difference of their
 * lengths turns the result by up to theta / 4 times that difference, so the best mu grows with theta. The mean error
 * between neighbors 15 degrees apart is least at 0.08. At 60 degrees it is least from 0.3 on, but there the gain at 15
 * is lost. 0.15 is 7 % above the first minimum and 10 % above the second (doc/results/direction-codes.md). Shorter
 * vectors are means of directions that disagree, as do their neighbors; in a filtered sum their error in steps counts.
 * So mu = ISO_FIT_MU + ISO_FIT_MU_SHORT (1 - |d|), at most 1, which is plain rounding; the slope gives the least error
 * in images of coarse levels. */
#define ISO_FIT_MU 0.15
#define ISO_FIT_MU_SHORT 2.5

/* Candidates for the largest component: this many whole numbers below and above the one at or below the intended
 * length. The mean error is within 2 % of that of a full search. */
#define ISO_FIT_BELOW 1
#define ISO_FIT_ABOVE 2

/* Largest distance of a fit from the intended length, in steps: 2 sqrt(3) of the window (one-sided if the largest
 * component is near 127), and half a cell. */
#define ISO_FIT_REACH 4.4

/* Smallest length used by code "shell"; the largest is 1. */
#define ISO_SHELL_MIN 0.95
