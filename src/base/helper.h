/* SPDX-License-Identifier: MIT */
/* helper.h - parts of the program in separate files, because they need large libraries. They are left out if those
 * libraries are not installed, and are started or loaded only when needed. */
#pragma once

/* Returns the path of such a file: next to the program or library in a build, or in the folder of `make install`,
 * wherever both were moved to. The caller frees it; NULL if there is none. */
char *iso_helper_find(const char *name);
