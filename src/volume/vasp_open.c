/* SPDX-License-Identifier: MIT */
/* vasp_open.c - VASP's CHGCAR, LOCPOT and the like: a cell in angstrom, its atoms, and a periodic grid as text, x
 * fastest, whose first sample is at the cell's corner. A second grid, of spins, is not read.
 *
 * Densities are stored times the cell's volume: the scale divides by it. */
#define _GNU_SOURCE
#include <ctype.h>
#include <math.h>
#include <string.h>

#include "base/file.h"
#include "volume/reader.h"

enum { LINE_BYTES = 4096, MOST_KINDS = 512, MOST_ATOMS = 10000000 };

static const struct {
    const char *name;
    bool is_density;
} files[] = {{"CHGCAR", true}, {"CHG", true}, {"PARCHG", true}, {"AECCAR", true}, {"LOCPOT", false}, {"ELFCAR", false}};
enum { FILES = sizeof files / sizeof *files };

typedef struct vasp {
    double cell[3][3];
    size_t size[3];
} vasp;

/* Returns the row of a file by its name, FILES: none. */
static size_t row_of(const char *path)
{
    size_t i = 0;
    while (i < FILES && !strstr(iso_path_base(path), files[i].name))
        ++i;
    return i;
}

static double determinant(double m[3][3])
{
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* Reads the scale and the cell. A negative scale is the cell's volume. */
static bool read_cell(FILE *f, vasp *v)
{
    char line[LINE_BYTES];
    double scale = 0;
    bool well = fgets(line, sizeof line, f) && fgets(line, sizeof line, f) && iso_reader_numbers(line, &scale, 1) == 1;
    for (int a = 0; a < 3 && well; ++a)
        well = fgets(line, sizeof line, f) && iso_reader_numbers(line, v->cell[a], 3) == 3;
    const double volume = well ? fabs(determinant(v->cell)) : 0;
    if (!(volume > 0) || !isfinite(scale) || scale == 0)
        return false;
    scale = scale < 0 ? cbrt(-scale / volume) : scale;
    for (int i = 0; i < 9; ++i)
        v->cell[i / 3][i % 3] *= scale;
    return true;
}

/* Reads over the atoms: names of elements since VASP 5, their counts, words, and a line for each. */
static bool skip_atoms(FILE *f)
{
    char line[LINE_BYTES];
    double counts[MOST_KINDS], sum = 0;
    size_t kinds = 0;
    for (int i = 0; i < 2 && kinds == 0; ++i)
        kinds = fgets(line, sizeof line, f) ? iso_reader_numbers(line, counts, MOST_KINDS) : 0;
    for (size_t i = 0; i < kinds; ++i)
        sum += counts[i];
    if (!(sum >= 1 && sum <= MOST_ATOMS) || !fgets(line, sizeof line, f))
        return false;
    if (toupper((unsigned char)line[strspn(line, " \t")]) == 'S' &&
        !fgets(line, sizeof line, f)) /* "Selective dynamics" */
        return false;
    for (double i = 0; i < sum; ++i)
        if (!fgets(line, sizeof line, f))
            return false;
    return true;
}

static bool read_header(FILE *f, vasp *v)
{
    return read_cell(f, v) && skip_atoms(f) &&
           fscanf(f, "%18zu %18zu %18zu", &v->size[0], &v->size[1], &v->size[2]) == 3;
}

static bool is_vasp(const char *path)
{
    vasp v;
    if (row_of(path) == FILES)
        return false;
    ENDED_BY(iso_close_file) FILE *f = fopen(path, "rb");
    return !f || read_header(f, &v) || ferror(f); /* a read error is reported on opening */
}

static iso_status read_vasp(FILE *f, iso_volume_source *source, iso_error *err)
{
    vasp v = {0};
    double step[3][3], first[3] = {0, 0, 0};
    const size_t row = row_of(source->path);
    if (!read_header(f, &v))
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated before the grid of a VASP file", source->path);
    for (int a = 0; a < 3; ++a) {
        if (v.size[a] < 1)
            return iso_fail(err, ISO_E_RANGE, "%s: axis %d has size 0, must be at least 1", source->path, a + 1);
        for (int r = 0; r < 3; ++r)
            step[a][r] = v.cell[a][r] / (double)v.size[a];
    }
    source->header.type = ISO_F32;
    NEED(iso_reader_place(source, v.size, step, first, "angstrom", err));
    NEED(iso_source_take_text(source, f, (iso_text_layout){.anything_follows = true}, err));
    if (row < FILES && files[row].is_density)
        source->header.notes.scale_slope = 1 / fabs(determinant(v.cell));
    return ISO_OK;
}

const iso_volume_format iso_volume_format_vasp = {
    .name = "vasp",
    .title = "VASP",
    .summary = "CHGCAR, CHG, PARCHG, AECCAR, LOCPOT, ELFCAR by name, in angstrom, at once",
    .suffixes = ".vasp",
    .starts = "a cell and its atoms, named CHGCAR, LOCPOT or the like",
    .probe_path = is_vasp,
    .read = read_vasp,
};
