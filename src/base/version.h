/* SPDX-License-Identifier: MIT */
/* version.h - ISO_VERSION, "MAJOR.MINOR.PATCH", from the library's own header. */
#pragma once

#include "isoshade.h"
