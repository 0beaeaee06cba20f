/* fit.h - the constants of the best fits, which encoders and their exact
 * counterparts share. */
#ifndef ISO_ENCODE_FIT_H
#define ISO_ENCODE_FIT_H

/* A length may be off by 1/mu times what a direction may. Filtering two
 * directions theta apart, a relative difference of length turns the result by up
 * to theta / 4 of it, so the best mu grows with theta. For unit vectors 0.07 has
 * the least mean error between neighbours 15 degrees apart, and a largest one of
 * 0.43 (0.05: 0.50). Shorter vectors are means of directions that disagree, and
 * their neighbours do so too: mu = ISO_FIT_MU + ISO_FIT_MU_SHORT (1 - |d|). */
#define ISO_FIT_MU 0.07
#define ISO_FIT_MU_SHORT 0.2

/* Whole numbers of the largest component tried on either side of the wanted
 * length: the mean error is within 2 % of the search over all. */
#define ISO_FIT_WINDOW 3

/* How far a fit can be from the wanted length, in steps: the window, one-sided where
 * the largest component is near 127, and half a cell. */
#define ISO_FIT_REACH 6.9

/* The thickness of the shell of lengths that code "shell" uses. */
#define ISO_SHELL_MIN 0.95

#endif
