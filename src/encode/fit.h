/* SPDX-License-Identifier: MIT */
/* fit.h - the constants of the best fits, which encoders and their exact
 * counterparts share. */
#ifndef ISO_ENCODE_FIT_H
#define ISO_ENCODE_FIT_H

/* The fit minimizes the error across the direction plus mu times the error along it (the length), so that a length may
 * be off by 1/mu times as much as a direction. When two directions theta apart are filtered, a relative difference of
 * their lengths turns the result by up to theta / 4 times that difference, so the best mu grows with theta: the mean
 * error between neighbors 15 degrees apart is least at 0.08, at 60 degrees from 0.3 on, where nothing is left of the
 * gain at 15. 0.15 is 7 % above the one and 10 % above the other (doc/results/direction-codes.md). Shorter vectors are
 * means of directions that disagree, their neighbors do so too, and what they add to a filtered sum is their error in
 * steps: mu = ISO_FIT_MU + ISO_FIT_MU_SHORT (1 - |d|), at most 1, plain rounding; the slope is the one of the least
 * error in images of coarse levels. */
#define ISO_FIT_MU 0.15
#define ISO_FIT_MU_SHORT 2.5

/* Of the largest component these whole numbers are tried: so many below and above
 * the one at or below the wanted length. The mean error is within 2 % of the search
 * over all. */
#define ISO_FIT_BELOW 1
#define ISO_FIT_ABOVE 2

/* How far a fit can be from the wanted length, in steps: 2 sqrt(3) of the window
 * (one-sided where the largest component is near 127), and half a cell. */
#define ISO_FIT_REACH 4.4

/* The thickness of the shell of lengths that code "shell" uses. */
#define ISO_SHELL_MIN 0.95

#endif
