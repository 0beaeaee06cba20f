/* SPDX-License-Identifier: MIT */
/* programs.h - the table of programs that read OpenVDB grids, with the grids they expect: `export --to vdb --for NAME`.
 *
 * A row is a set of options of --bake; options given with --for override it. Rows name their sources and the tests that
 * were run; doc/guide/other-programs.md has them as a table. */
#pragma once

#include <stdbool.h>

#include "base/names.h"

typedef struct iso_grid_program {
    const char *name, *summary;
    const char *grids; /* of --bake */
    const char *unit;  /* of --scene-unit */
    const char *up;    /* of --up */
    bool half, usd;
    const char *tested;  /* "not run", or the test that was run */
    const char *setting; /* settings there that give the baked picture */
    const char *source;  /* pages with these facts */
} iso_grid_program;

extern const iso_names iso_grid_program_names;
const iso_grid_program *iso_grid_program_at(size_t row);
