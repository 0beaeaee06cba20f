/* fit.h - the constants of the best fits, which encoders and their exact
 * counterparts share. */
#ifndef ISO_ENCODE_FIT_H
#define ISO_ENCODE_FIT_H

/* A length may be off by 1/mu times what a direction may. Filtering two
 * directions theta apart, a relative difference of length turns the result by
 * theta / 4 of it, so the best mu grows with theta: 0.05 suits unit vectors about
 * 15 degrees apart. Shorter vectors are means of directions that disagree, and
 * their neighbours do so too: mu = ISO_FIT_MU + ISO_FIT_MU_SHORT (1 - |d|). */
#define ISO_FIT_MU 0.05
#define ISO_FIT_MU_SHORT 0.2

/* Whole numbers of the largest component tried on either side of the wanted
 * length: the mean error is within 2 % of the search over all. */
#define ISO_FIT_WINDOW 4

/* The thickness of the shell of lengths that code "shell" uses. */
#define ISO_SHELL_MIN 0.95

#endif
