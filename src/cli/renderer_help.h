/* SPDX-License-Identifier: MIT */
/* renderer_help.h - texts for --help that name renderers: `describe` of an option's row (options/option.h). */
#pragma once

#include "options/option.h"
#include "renderers/renderers.h"

/* Return the row's text with "%s" replaced by the renderers that have all traits of `about`, in memory to be freed. NULL:
 * no memory. */
char *iso_help_names_renderers(const iso_option *option); /* "gl, cpu and povray" */
char *iso_help_names_choice(const iso_option *option);    /* "gl, cpu or povray" */
char *iso_help_names_usual(const iso_option *option);     /* those that take part by default: "gl,cpu,povray" */

/* A row's end for each. */
#define ISO_NAMES_RENDERERS(traits) .describe = iso_help_names_renderers, .about = (traits)
#define ISO_NAMES_CHOICE(traits) .describe = iso_help_names_choice, .about = (traits)
#define ISO_NAMES_USUAL(traits) .describe = iso_help_names_usual, .about = (traits)
