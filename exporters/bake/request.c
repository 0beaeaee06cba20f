/* SPDX-License-Identifier: MIT */
/* request.c - makes a request for grids from command-line options. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "bake/grids.h"
#include "volume/unit.h"

static const struct {
    const char *name, *summary;
} grids[ISO_BAKE_GRIDS] = {
    [ISO_BAKE_DENSITY] = {"density", "float: extinction per scene unit, never negative"},
    [ISO_BAKE_CD] = {"Cd", "vec3s: linear color; transparent points next to visible ones have their color"},
    [ISO_BAKE_EMISSION] = {"emission", "vec3s: extinction times linear color, per scene unit"},
    [ISO_BAKE_TEMPERATURE] = {"temperature", "float: position in the transfer function's range, 0 to 1; not kelvins"},
};
const iso_names iso_bake_grid_names = ISO_NAMES_OF_ROWS("baked grid", grids);

/* True for a name that is valid in OpenVDB, USD and shaders. */
static bool is_identifier(const char *text)
{
    if (!isalpha((unsigned char)*text) && *text != '_')
        return false;
    for (; *text; ++text)
        if (!isalnum((unsigned char)*text) && *text != '_')
            return false;
    return true;
}

/* Parses "Cd" or "Cd=color". */
static iso_status take_grid(char *word, iso_bake_request *r, iso_error *err)
{
    size_t row;
    char *name = strchr(word, '='), all[128];
    if (name)
        *name++ = '\0';
    if (iso_names_find(&iso_bake_grid_names, word, &row, NULL) != ISO_OK)
        return iso_fail(err, ISO_E_USAGE, "--bake: unknown grid \"%s\"; grids: %s", word,
                        iso_names_join(&iso_bake_grid_names, "or", all, sizeof all));
    if (r->has[row])
        return iso_fail(err, ISO_E_USAGE, "--bake names %s twice", word);
    if (name && (!is_identifier(name) || strlen(name) >= sizeof r->name[row]))
        return iso_fail(err, ISO_E_USAGE, "--bake: %s=%s, a name has up to %zu letters, digits and _", word, name,
                        sizeof r->name[row] - 1);
    r->has[row] = true;
    snprintf(r->name[row], sizeof r->name[row], "%s", name ? name : grids[row].name);
    return ISO_OK;
}

static iso_status take_grids(const char *list, iso_bake_request *r, iso_error *err)
{
    char words[512], *rest = NULL;
    if (strlen(list) >= sizeof words)
        return iso_fail(err, ISO_E_USAGE, "--bake has %zu letters, at most %zu", strlen(list), sizeof words - 1);
    snprintf(words, sizeof words, "%s", list);
    for (char *word = strtok_r(words, ",", &rest); word; word = strtok_r(NULL, ",", &rest))
        NEED(take_grid(word, r, err));
    if (!r->has[ISO_BAKE_DENSITY])
        return iso_fail(err, ISO_E_USAGE, "--bake is \"%s\", must include density", list);
    for (int i = 0; i < ISO_BAKE_GRIDS; ++i)
        for (int k = 0; k < i; ++k)
            if (r->has[i] && r->has[k] && strcmp(r->name[i], r->name[k]) == 0)
                return iso_fail(err, ISO_E_USAGE, "--bake: two grids have the name \"%s\"", r->name[i]);
    return ISO_OK;
}

static iso_status take_up(const char *up, iso_bake_request *r, iso_error *err)
{
    if (strcmp(up, "z") != 0 && strcmp(up, "y") != 0)
        return iso_fail(err, ISO_E_USAGE, "--up is \"%s\", must be z or y", up);
    r->convention.y_up = *up == 'y';
    return ISO_OK;
}

static iso_status take_count(const char *option, int given, size_t *count, iso_error *err)
{
    if (given == 0)
        return ISO_OK;
    if (given < 1 || given > ISO_BAKE_MOST_POINTS)
        return iso_fail(err, ISO_E_USAGE, "%s is %d, must be 1 to %d", option, given, ISO_BAKE_MOST_POINTS);
    *count = (size_t)given;
    return ISO_OK;
}

/* Refuses options that need --bake or --for. */
static iso_status check_alone(const iso_bake_words *w, iso_error *err)
{
    const char *const alone = w->unit            ? "--scene-unit"
                              : w->up            ? "--up"
                              : w->usd           ? "--usd"
                              : w->lattice_alone ? NULL
                              : w->points        ? "--points"
                              : w->samples       ? "--supersample"
                                                 : NULL;
    if (alone)
        return iso_fail(err, ISO_E_USAGE, "%s needs --bake or --for: the scalar's own grids are in mm with z up",
                        alone);
    return ISO_OK;
}

iso_status iso_bake_request_make(const iso_bake_words *w, bool half, iso_bake_request *r, iso_error *err)
{
    size_t row = 0;
    *r = (iso_bake_request){.lattice = iso_bake_defaults(), .convention = iso_vdb_own_convention()};
    if (!w->program && !w->grids) {
        NEED(check_alone(w, err));
        NEED(take_count("--points", w->points, &r->lattice.points, err));
        return take_count("--supersample", w->samples, &r->lattice.samples, err);
    }
    if (w->program)
        NEED(iso_names_find(&iso_grid_program_names, w->program, &row, err));
    const iso_grid_program *p = w->program ? iso_grid_program_at(row) : NULL;
    r->wanted = true;
    r->program = p;
    r->half = half || (p && p->half);
    r->usd = w->usd || (p && p->usd);
    r->error_pixels = ISO_BAKE_ERROR_PIXELS;
    NEED(take_grids(w->grids ? w->grids : p->grids, r, err));
    const char *unit = w->unit ? w->unit : p ? p->unit : NULL, *up = w->up ? w->up : p ? p->up : NULL;
    r->unit_is_asked = w->unit != NULL;
    if (unit)
        NEED(iso_unit_parse("--scene-unit", unit, &r->convention.unit_mm, &r->convention.unit, err));
    if (up)
        NEED(take_up(up, r, err));
    NEED(take_count("--points", w->points, &r->lattice.points, err));
    return take_count("--supersample", w->samples, &r->lattice.samples, err);
}
