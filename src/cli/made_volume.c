/* SPDX-License-Identifier: MIT */
#include "cli/made_volume.h"

#include <stdlib.h>
#include <string.h>

#include "cli/commands.h"

extern const iso_command iso_command_make;

static bool names_output(const char *word)
{
    return strncmp(word, "-o", 2) == 0 || strncmp(word, "--output", 8) == 0;
}

/* Refuses options for the output, which a scene must not choose. */
static iso_status check_words(const char *make, const char *const words[], int count, iso_error *err)
{
    for (int i = 0; i < count; ++i)
        if (names_output(words[i]))
            return iso_fail(err, ISO_E_FORMAT, "\"make\" is \"%s\": a scene must not name an output (%s)", make,
                            words[i]);
    return ISO_OK;
}

/* Runs make. Wrong words are an error of the scene's file, not of the command line. */
static iso_status run_make(const char *make, int argc, const char **argv, iso_error *err)
{
    iso_command inner = iso_command_make;
    inner.is_inner = true;
    const iso_status status = iso_command_run(&inner, argc, argv, err);
    return status == ISO_E_USAGE ? iso_fail_in(err, ISO_E_FORMAT, "\"make\" is \"%s\"", make) : status;
}

iso_status iso_cli_make_volume(const char *make, const char *path, iso_error *err)
{
    int count;
    FREED const char **words = NULL, **argv = NULL;
    if (poptParseArgvString(make, &count, &words) != 0)
        return iso_fail(err, ISO_E_FORMAT, "\"make\" is \"%s\", must be a list of words", make);
    NEED(check_words(make, words, count, err));
    if (!(argv = calloc((size_t)count + 4, sizeof *argv)))
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    argv[0] = "make", argv[1] = "-o", argv[2] = path;
    memcpy(argv + 3, words, (size_t)count * sizeof *argv);
    return run_make(make, count + 3, argv, err);
}
