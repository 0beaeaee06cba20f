/* SPDX-License-Identifier: MIT */
/* unit.h - units of length in headers. World coordinates are millimeters for every file. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

/* The names for messages and --help: those that --unit takes; headers may spell them out (micrometer, microns). */
#define ISO_UNIT_NAMES "m, cm, mm, um, nm, pm, angstrom, bohr, inch or km"

/* Finds a unit in millimeters, and its short name, which may be NULL; false if the unit is unknown. Not sensitive to
 * case. */
bool iso_unit_find(const char *text, double *mm, const char **name);

/* Does the same for the value of an option. ISO_E_USAGE lists the names. */
iso_status iso_unit_parse(const char *option, const char *text, double *mm, const char **name, iso_error *err);

/* Returns the unit in which a length is neither tiny nor huge: angstrom, nm, um, mm or m; mm from 0.01 to 10 000. */
const char *iso_unit_fitting(double length_mm, double *unit_mm);
/* Returns the symbol that pictures and texts for people have in place of --unit's spelling: "µm", "Å", else the name. */
const char *iso_unit_symbol(const char *name);
/* Writes "2.5 µm": a length in the unit that fits, with so many digits. Returns the text. */
char *iso_unit_text(double length_mm, int digits, char *text, size_t size);
