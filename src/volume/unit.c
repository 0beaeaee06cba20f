/* SPDX-License-Identifier: MIT */
#include "volume/unit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* The Bohr radius: CODATA 2018, 0.529177210903 angstrom. */
static const struct {
    const char *name;
    double mm;
    const char *also; /* words that mean it, each between two spaces */
} units[] = {
    {"mm", 1, " millimeter millimeters millimetre millimetres "},
    {"m", 1e3, " meter meters metre metres "},
    {"km", 1e6, " kilometer kilometers kilometre kilometres "},
    {"cm", 10, " centimeter centimeters centimetre centimetres "},
    /* The micro sign and the Greek mu, in UTF-8, in Latin-1, and as ImageJ writes them. */
    {"um", 1e-3,
     " micrometer micrometers micrometre micrometres micron microns \xc2\xb5m \xce\xbcm \xb5m \\u00b5m \\u03bcm "},
    {"nm", 1e-6, " nanometer nanometers nanometre nanometres "},
    {"pm", 1e-9, " picometer picometers picometre picometres "},
    {"angstrom", 1e-7, " angstroms a \xc3\x85 \xc3\xa5 \xe2\x84\xab \xc5 "},
    {"bohr", 0.529177210903e-7, " bohrs a.u. "},
    {"inch", 25.4, " in inches "},
};

/* True if the list has the word. */
static bool has_word(const char *list, const char *word, size_t length)
{
    for (const char *at = list; (at = strchr(at, ' ')) && at[1]; ++at)
        if (strcspn(at + 1, " ") == length && strncasecmp(at + 1, word, length) == 0)
            return true;
    return false;
}

bool iso_unit_find(const char *text, double *mm, const char **name)
{
    for (size_t i = 0; i < sizeof units / sizeof units[0]; ++i)
        if (strcasecmp(units[i].name, text) == 0 || has_word(units[i].also, text, strlen(text))) {
            *mm = units[i].mm;
            if (name)
                *name = units[i].name;
            return true;
        }
    return false;
}

iso_status iso_unit_parse(const char *option, const char *text, double *mm, const char **name, iso_error *err)
{
    if (iso_unit_find(text, mm, name))
        return ISO_OK;
    return iso_fail(err, ISO_E_USAGE, "%s is \"%s\", must be " ISO_UNIT_NAMES, option, text);
}

const char *iso_unit_fitting(double length_mm, double *unit_mm)
{
    static const struct {
        const char *name;
        double below_mm, mm;
    } fitting[] = {{"angstrom", 1e-6, 1e-7}, {"nm", 1e-4, 1e-6}, {"um", 1e-2, 1e-3}, {"mm", 1e4, 1}};
    for (size_t i = 0; i < sizeof fitting / sizeof *fitting; ++i)
        if (fabs(length_mm) < fitting[i].below_mm) {
            *unit_mm = fitting[i].mm;
            return fitting[i].name;
        }
    *unit_mm = 1e3;
    return "m";
}

const char *iso_unit_symbol(const char *name)
{
    return strcmp(name, "um") == 0 ? "µm" : strcmp(name, "angstrom") == 0 ? "Å" : name;
}

char *iso_unit_text(double length_mm, int digits, char *text, size_t size)
{
    double unit_mm;
    const char *name = iso_unit_fitting(length_mm, &unit_mm);
    snprintf(text, size, "%.*g %s", digits, length_mm / unit_mm, iso_unit_symbol(name));
    return text;
}
