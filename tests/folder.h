/* SPDX-License-Identifier: MIT */
/* folder.h - a folder of a test program's own: made before its tests, removed after them with all that is in it. */
#pragma once

#include <stdlib.h>

#include "base/file.h"

static char *folder;

static int make_folder(void **state)
{
    (void)state;
    folder = iso_make_temp_dir();
    return folder ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    iso_remove_tree(folder);
    free(folder);
    return 0;
}
