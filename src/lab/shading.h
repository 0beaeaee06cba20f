/* SPDX-License-Identifier: MIT */
/* shading.h - isoshade-lab consistency --shading: directions across levels. */
#pragma once

#include "options/cli.h"

extern const iso_command iso_lab_shading;
