/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/renderer_help.h"

#include <stdio.h>
#include <string.h>

static char *replace(const char *text, const char *names)
{
    const size_t before = strcspn(text, "%");
    char *whole;
    return asprintf(&whole, "%.*s%s%s", (int)before, text, names, text + before + strlen("%s")) < 0 ? NULL : whole;
}

char *iso_help_names_renderers(const iso_option *option)
{
    char names[256];
    return replace(option->help, iso_renderers_with(option->about, ", ", " and ", names, sizeof names));
}

char *iso_help_names_choice(const iso_option *option)
{
    char names[256];
    return replace(option->help, iso_renderers_with(option->about, ", ", " or ", names, sizeof names));
}

char *iso_help_names_usual(const iso_option *option)
{
    char names[256];
    return replace(option->help, iso_renderers_by_default(option->about, names, sizeof names));
}
