/* SPDX-License-Identifier: MIT */
/* cube_open.c - Gaussian's cube files: two lines of words, the number of atoms and the grid's origin, three axes,
 * the atoms, and the values as text, z fastest. Lengths are bohr, or angstrom if an axis has a negative number of
 * samples. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "volume/reader.h"

enum { LINE_BYTES = 1024, ATOMS_MOST = 10000000 };

typedef struct cube {
    long atoms, count[3];
    double origin[3], step[3][3];
    long values; /* a voxel */
    iso_extra_axes axes;
} cube;

/* Reads a line of a count and three numbers; *more: a count after them, 1 if there is none. */
static bool take_line(FILE *f, long *count, double v[3], long *more)
{
    char line[LINE_BYTES];
    *more = 1;
    return fgets(line, sizeof line, f) && sscanf(line, "%ld %lf %lf %lf %ld", count, &v[0], &v[1], &v[2], more) >= 4;
}

static bool read_header(FILE *f, cube *c)
{
    char line[LINE_BYTES];
    long unused;
    bool well = fgets(line, sizeof line, f) && fgets(line, sizeof line, f) &&
                take_line(f, &c->atoms, c->origin, &c->values);
    for (int a = 0; a < 3 && well; ++a)
        well = take_line(f, &c->count[a], c->step[a], &unused) && c->count[a] != 0 && labs(c->count[a]) < 1000000;
    return well && labs(c->atoms) <= ATOMS_MOST && c->values >= 1 && c->values < 100000;
}

/* Leaves the file at the first value: after the atoms, and after the orbitals' numbers if the number of atoms is
 * negative. */
static bool skip_atoms(FILE *f, cube *c)
{
    char line[LINE_BYTES];
    bool well = true;
    for (long i = 0; i < labs(c->atoms) && well; ++i)
        well = fgets(line, sizeof line, f);
    long orbital;
    if (well && c->atoms < 0) {
        well = fscanf(f, "%ld", &c->values) == 1 && c->values >= 1 && c->values < 100000;
        for (long i = 0; i < c->values && well; ++i) {
            well = fscanf(f, "%ld", &orbital) == 1;
            if (well && i < ISO_NAMED_CHANNELS)
                snprintf(c->axes.channel_name[i], sizeof c->axes.channel_name[i], "orbital %ld", orbital);
        }
    }
    return well;
}

static bool is_cube(const char *path)
{
    cube c;
    if (!iso_reader_is_named(path, ".cube") && !iso_reader_is_named(path, ".cub"))
        return false;
    FILE *f = fopen(path, "rb");
    const bool is_one = !f || read_header(f, &c) || ferror(f); /* a read error is reported on opening */
    if (f)
        fclose(f);
    return is_one;
}

static iso_status take_geometry(const cube *c, iso_volume_source *source, iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    size_t size[3];
    double mm;
    for (int a = 0; a < 3; ++a)
        size[a] = (size_t)labs(c->count[a]);
    const char *unit = c->count[0] < 0 ? "angstrom" : "bohr";
    NEED(iso_source_unit(source, unit, unit, &mm, err));
    *g = iso_geometry_axis_aligned(size, (double[]){1, 1, 1});
    for (int a = 0; a < 3; ++a)
        for (int r = 0; r < 3; ++r)
            g->index_to_world.m[r][a] = mm * c->step[a][r];
    g->origin_mm = iso_sub(iso_scale(iso_v3(c->origin[0], c->origin[1], c->origin[2]), mm),
                           iso_mul(g->index_to_world, iso_v3(0.5, 0.5, 0.5)));
    source->header.type = ISO_F32;
    return iso_source_check_geometry(source, err);
}

static iso_status read_cube(FILE *f, iso_volume_source *source, iso_error *err)
{
    cube c = {0};
    if (!read_header(f, &c) || !skip_atoms(f, &c))
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated before the values of a cube file", source->path);
    c.axes.channel = (iso_extra_axis){.count = (size_t)c.values, .inside = true, .stride = 1};
    NEED(take_geometry(&c, source, err));
    NEED(iso_source_choose(source, &c.axes, err));
    return iso_source_take_text(source, f, (iso_text_layout){.z_fastest = true}, err);
}

const iso_volume_format iso_volume_format_cube = {
    .name = "cube",
    .title = "Gaussian cube",
    .summary = "densities and orbitals, in bohr or angstrom, at once",
    .suffixes = ".cube .cub",
    .starts = "two lines of words, named .cube",
    .probe_path = is_cube,
    .read = read_cube,
};
