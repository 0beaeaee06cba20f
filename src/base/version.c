/* SPDX-License-Identifier: MIT */
#include "base/version.h"

int iso_version_number(void)
{
    return ISO_VERSION_NUMBER;
}

const char *iso_version(void)
{
    return ISO_VERSION;
}
