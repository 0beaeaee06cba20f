/* SPDX-License-Identifier: MIT */
/* programs.h - the table of programs that read OpenVDB grids, and what each expects: `export --to vdb --for NAME`.
 *
 * A row is a set of the options of --bake and nothing more: what is given beside --for stands instead of the row's. Rows say
 * where the facts are from and whether the program was run on such a file; doc/guide/other-programs.md has them as a table. */
#ifndef ISO_BAKE_PROGRAMS_H
#define ISO_BAKE_PROGRAMS_H

#include <stdbool.h>

#include "base/names.h"

typedef struct iso_grid_program {
    const char *name, *summary;
    const char *grids; /* of --bake */
    const char *unit;  /* of --scene-unit */
    const char *up;    /* of --up */
    bool half, usd;
    const char *tested;  /* "not run", or what was run */
    const char *setting; /* what to set there, so that the picture is the baked one */
    const char *source;  /* pages that say so */
} iso_grid_program;

extern const iso_names iso_grid_program_names;
const iso_grid_program *iso_grid_program_at(size_t row);

#endif
