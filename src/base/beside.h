/* SPDX-License-Identifier: MIT */
/* beside.h - parts of the program that stand on large libraries, in files of their own: they are left out where those
 * libraries are not installed, and only started or loaded when they are needed. */
#ifndef ISO_BESIDE_H
#define ISO_BESIDE_H

/* The path of such a file: beside the program or the library as they are built, or where `make install` puts it, wherever
 * both were moved to. To be freed; NULL where there is none. */
char *iso_beside_find(const char *name);

#endif
