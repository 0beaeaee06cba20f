/* SPDX-License-Identifier: MIT */
/* validate_result.h - the final output and exit code of `isoshade validate`. */
#pragma once

#include "options/cli.h"
#include "report/levels.h"
#include "validate/validate.h"

/* Returns the exit code: nothing differs; a difference of renderers or levels; or a renderer could not be compared. */
iso_status iso_cli_validate_verdict(const iso_validation *v, const iso_report_summary *summary,
                                    const iso_levels_summary *levels, iso_error *err);

/* Prints the verdicts, skipped comparisons with reasons, and the report's path; with --json the report itself. */
void iso_cli_validate_print(const char *output, const iso_cli *cli, const iso_validation *v,
                            const iso_report_summary *s, const iso_levels_summary *levels);
