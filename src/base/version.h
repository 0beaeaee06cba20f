/* SPDX-License-Identifier: MIT */
/* version.h - ISO_VERSION, "MAJOR.MINOR.PATCH", from the library's own header. */
#ifndef ISO_VERSION_H
#define ISO_VERSION_H

#include "isoshade.h"

#endif
