/* fit.h - the constants of the best fits, which encoders and their exact
 * counterparts share. */
#ifndef ISO_ENCODE_FIT_H
#define ISO_ENCODE_FIT_H

/* A length may be off by 1/mu times what a direction may. Filtering two
 * directions theta apart, a relative difference of length turns the result by up
 * to theta / 4 of it, so the best mu grows with theta: the mean error between
 * neighbours 15 degrees apart is least at 0.08, at 60 degrees from 0.3 on, where
 * nothing is left of the gain at 15. 0.14 is 6 % above the one and 10 % above the
 * other (doc/gradients.md). Shorter vectors are means of directions that disagree,
 * their neighbours do so too, and what they add to a filtered sum is their error in
 * steps: mu = ISO_FIT_MU + ISO_FIT_MU_SHORT (1 - |d|), plain rounding at the end. */
#define ISO_FIT_MU 0.14
#define ISO_FIT_MU_SHORT 0.86

/* Whole numbers of the largest component tried on either side of the wanted
 * length: the mean error is within 2 % of the search over all. */
#define ISO_FIT_WINDOW 2

/* How far a fit can be from the wanted length, in steps: the window, one-sided where
 * the largest component is near 127, and half a cell. */
#define ISO_FIT_REACH 4.9

/* The thickness of the shell of lengths that code "shell" uses. */
#define ISO_SHELL_MIN 0.95

#endif
