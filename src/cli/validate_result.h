/* SPDX-License-Identifier: MIT */
/* validate_result.h - what `isoshade validate` says at its end: on the console, and by its exit code. */
#ifndef ISO_VALIDATE_RESULT_H
#define ISO_VALIDATE_RESULT_H

#include "options/cli.h"
#include "report/levels.h"
#include "validate/validate.h"

/* What the exit code says: nothing differed; a difference, of renderers or of levels; or a renderer that could not be
 * compared. */
iso_status iso_cli_validate_verdict(const iso_validation *v, const iso_report_summary *summary,
                                    const iso_levels_summary *levels, iso_error *err);

/* The sentences, what was not compared and why, and where the report is; or the report itself with --json. */
void iso_cli_validate_print(const char *output, const iso_cli *cli, const iso_validation *v,
                            const iso_report_summary *s, const iso_levels_summary *levels);

#endif
