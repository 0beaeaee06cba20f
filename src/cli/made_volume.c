/* SPDX-License-Identifier: MIT */
#include "cli/made_volume.h"

#include <stdlib.h>
#include <string.h>

#include "cli/commands.h"

extern const iso_command iso_command_make;

iso_status iso_cli_make_volume(const char *make, const char *path, iso_error *err)
{
    int argc;
    const char **words;
    if (poptParseArgvString(make, &argc, &words) != 0)
        return iso_fail(err, ISO_E_FORMAT, "\"make\" is \"%s\", which is no list of words", make);
    const char **argv = calloc((size_t)argc + 5, sizeof *argv);
    iso_status status = argv ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    if (status == ISO_OK) {
        argv[0] = "make";
        memcpy(argv + 1, words, (size_t)argc * sizeof *argv);
        argv[argc + 1] = "-q", argv[argc + 2] = "-o", argv[argc + 3] = path;
        status = iso_command_make.run(&iso_command_make, argc + 4, argv, err);
    }
    free(argv);
    free(words);
    return status;
}
