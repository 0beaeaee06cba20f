/* SPDX-License-Identifier: MIT */
/* beside.h - parts of the program that need large libraries, in files of their own. They are left out if those
 * libraries are not installed, and are started or loaded only when needed. */
#ifndef ISO_BESIDE_H
#define ISO_BESIDE_H

/* Returns the path of such a file: next to the program or library in a build, or in the folder of `make install`,
 * wherever both were moved to. To be freed; NULL if there is none. */
char *iso_beside_find(const char *name);

#endif
