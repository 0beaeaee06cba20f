/* SPDX-License-Identifier: MIT */
/* version.h - the one place of the version. */
#ifndef ISO_VERSION_H
#define ISO_VERSION_H

#define ISO_VERSION "0.1.0"

#endif
