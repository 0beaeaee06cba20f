/* SPDX-License-Identifier: MIT */
/* dx_open.c - OpenDX grids of APBS, VMD and others: a regular grid as text, z fastest, in angstrom. */
#define _GNU_SOURCE
#include <string.h>

#include "base/file.h"
#include "volume/reader.h"

enum { LINE_BYTES = 1024, MOST_LINES = 10000 };

typedef struct dx {
    size_t size[3], items;
    double origin[3], step[3][3];
    int steps;
    char form[64]; /* of the samples: after their count */
} dx;

/* Reads up to the line before the samples; false if it is missing. */
static bool read_header(FILE *f, dx *d)
{
    char line[LINE_BYTES];
    for (int i = 0; i < MOST_LINES && fgets(line, sizeof line, f); ++i) {
        const char *counts = strstr(line, "counts"), *items = strstr(line, "items"), *word = line + strspn(line, " \t");
        if (strstr(line, "gridpositions") && counts)
            sscanf(counts, "counts %18zu %18zu %18zu", &d->size[0], &d->size[1], &d->size[2]);
        else if (strncmp(word, "origin", 6) == 0)
            iso_reader_numbers(word + 6, d->origin, 3);
        else if (strncmp(word, "delta", 5) == 0 && d->steps < 3)
            d->steps += iso_reader_numbers(word + 5, d->step[d->steps], 3) == 3;
        else if (strstr(line, "class array") && items)
            return sscanf(items, "items %18zu %63[^\n]", &d->items, d->form) == 2;
    }
    return false;
}

static bool is_dx(const char *path)
{
    return iso_reader_is_named(path, ".dx") && iso_reader_may_hold(path, "gridpositions");
}

static iso_status check_header(const dx *d, const char *path, iso_error *err)
{
    if (d->steps < 3 || d->size[0] < 1 || d->size[1] < 1 || d->size[2] < 1)
        return iso_fail(err, ISO_E_FORMAT, "%s: a grid of %zu x %zu x %zu with %d lines \"delta\", must be 3 of each",
                        path, d->size[0], d->size[1], d->size[2], d->steps);
    if (strncmp(d->form, "data follows", 12) != 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: its samples are \"%.40s\", must be \"data follows\": text in this file",
                        path, d->form);
    return (double)d->items == (double)d->size[0] * (double)d->size[1] * (double)d->size[2]
               ? ISO_OK
               : iso_fail(err, ISO_E_FORMAT, "%s: %zu samples for a grid of %zu x %zu x %zu", path, d->items,
                          d->size[0], d->size[1], d->size[2]);
}

static iso_status read_dx(FILE *f, iso_volume_source *source, iso_error *err)
{
    dx d = {0};
    if (!read_header(f, &d))
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated before the samples of an OpenDX file", source->path);
    NEED(check_header(&d, source->path, err));
    source->header.type = ISO_F32;
    NEED(iso_reader_place(source, d.size, d.step, d.origin, "angstrom", err));
    return iso_source_take_text(source, f, (iso_text_layout){.z_fastest = true, .words_follow = true}, err);
}

const iso_volume_format iso_volume_format_dx = {
    .name = "dx",
    .title = "OpenDX",
    .summary = "regular grids as text, in angstrom, at once",
    .suffixes = ".dx",
    .starts = "a line with gridpositions, named .dx",
    .probe_path = is_dx,
    .read = read_dx,
};
