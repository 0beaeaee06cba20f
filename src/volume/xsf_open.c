/* SPDX-License-Identifier: MIT */
/* xsf_open.c - XCrySDen's files: the grid after BEGIN_DATAGRID_3D, in angstrom, as text, x fastest. Its three
 * vectors span from the first sample to the last, which periodic grids have on both sides. */
#define _GNU_SOURCE
#include <string.h>

#include "base/file.h"
#include "volume/reader.h"

enum { LINE_BYTES = 1024 };

static bool is_grid(const char *line)
{
    return strstr(line, "BEGIN_DATAGRID_3D") || strncmp(line + strspn(line, " \t"), "DATAGRID_3D", 11) == 0;
}

/* Reads up to the line before the grid's sizes. False: there is none. */
static bool find_grid(FILE *f)
{
    char line[LINE_BYTES];
    while (fgets(line, sizeof line, f))
        if (is_grid(line))
            return true;
    return false;
}

static bool is_xsf(const char *path)
{
    if (!iso_reader_is_named(path, ".xsf"))
        return false;
    FILE *f = fopen(path, "rb");
    const bool is_one = !f || find_grid(f) || ferror(f); /* a read error is reported on opening */
    if (f)
        fclose(f);
    return is_one;
}

static bool read_grid(FILE *f, size_t size[3], double origin[3], double span[3][3])
{
    bool well = fscanf(f, "%18zu %18zu %18zu", &size[0], &size[1], &size[2]) == 3 &&
                fscanf(f, "%lf %lf %lf", &origin[0], &origin[1], &origin[2]) == 3;
    for (int a = 0; a < 3 && well; ++a)
        well = fscanf(f, "%lf %lf %lf", &span[a][0], &span[a][1], &span[a][2]) == 3 && size[a] > 1;
    return well;
}

static iso_status take_geometry(iso_volume_source *source, const size_t size[3], const double origin[3],
                                double span[3][3], iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    double mm;
    NEED(iso_source_unit(source, "angstrom", "angstrom", &mm, err));
    *g = iso_geometry_axis_aligned(size, (double[]){1, 1, 1});
    for (int a = 0; a < 3; ++a)
        for (int r = 0; r < 3; ++r)
            g->index_to_world.m[r][a] = mm * span[a][r] / (double)(size[a] - 1);
    g->origin_mm = iso_sub(iso_scale(iso_v3(origin[0], origin[1], origin[2]), mm),
                           iso_mul(g->index_to_world, iso_v3(0.5, 0.5, 0.5)));
    source->header.type = ISO_F32;
    return iso_source_check_geometry(source, err);
}

static iso_status read_xsf(FILE *f, iso_volume_source *source, iso_error *err)
{
    size_t size[3];
    double origin[3], span[3][3];
    if (!find_grid(f) || !read_grid(f, size, origin, span))
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated before the values of an XSF file, or of less than 2 samples",
                        source->path);
    NEED(take_geometry(source, size, origin, span, err));
    NEED(iso_source_take_text(source, f, (iso_text_layout){.words_follow = true}, err));
    return find_grid(f) ? iso_fail(err, ISO_E_FORMAT, "%s: has several grids, must be one", source->path) : ISO_OK;
}

const iso_volume_format iso_volume_format_xsf = {
    .name = "xsf",
    .title = "XSF",
    .summary = "XCrySDen's grids of three dimensions, in angstrom, at once",
    .suffixes = ".xsf",
    .starts = "a line BEGIN_DATAGRID_3D, named .xsf",
    .probe_path = is_xsf,
    .read = read_xsf,
};
