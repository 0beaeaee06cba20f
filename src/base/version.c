/* SPDX-License-Identifier: MIT */
#include "base/version.h"

const char *iso_version(void)
{
    return ISO_VERSION;
}
