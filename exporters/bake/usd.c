/* SPDX-License-Identifier: MIT */
/* usd.c - the text of a .usda for a file of grids: a Volume with a relationship to an OpenVDBAsset per grid.
 *
 *   Volume  rel field:density = <density>       https://openusd.org/release/api/usd_vol_page_front.html
 *   OpenVDBAsset  filePath, fieldName, fieldIndex, fieldDataType, fieldClass, vectorDataRoleHint
 *                                               https://openusd.org/release/user_guides/schemas/usdVol/OpenVDBAsset.html
 *
 * Lengths are scene units as in the grids, so metersPerUnit is that of the unit. The grid file is named without folder,
 * so that both files can be moved together. There is no material: each renderer has its own for volumes. */
#define _GNU_SOURCE
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "bake/grids.h"
#include "base/file.h"

/* Makes a prim name: letters, digits and _, not starting with a digit. */
static void prim_name(const char *path, char *name, size_t size)
{
    const char *base = iso_path_base(path), *end = base;
    while (*end && *end != '.')
        ++end;
    size_t n = 0;
    if (base == end || isdigit((unsigned char)*base))
        name[n++] = '_';
    for (const char *c = base; c < end && n + 1 < size; ++c)
        name[n++] = isalnum((unsigned char)*c) ? *c : '_';
    name[n] = '\0';
}

/* Computes the box of the lattice's points and their cells, along the scene's axes. */
static void find_extent(const iso_baked *b, const iso_vdb_convention *c, double lo[3], double hi[3])
{
    const iso_geometry *g = &b->geometry;
    for (int a = 0; a < 3; ++a) {
        lo[a] = INFINITY;
        hi[a] = -INFINITY;
    }
    for (int i = 0; i < 8; ++i) {
        const iso_vec3 corner = iso_v3(i & 1 ? (double)g->size[0] : 0, i & 2 ? (double)g->size[1] : 0,
                                       i & 4 ? (double)g->size[2] : 0);
        const iso_vec3 p = iso_vdb_in_scene(c, iso_geometry_to_world(g, corner));
        const double at[3] = {p.x, p.y, p.z};
        for (int a = 0; a < 3; ++a) {
            lo[a] = fmin(lo[a], at[a]);
            hi[a] = fmax(hi[a], at[a]);
        }
    }
}

/* Writes an asset. Its path stands between '@', or between "@@@" if it contains '@'. */
static void write_asset(FILE *f, const iso_bake_request *r, int grid, const char *file)
{
    const bool color = grid == ISO_BAKE_CD || grid == ISO_BAKE_EMISSION;
    const char *quote = NULL;
    for (const char *c = file; *c; ++c)
        quote = *c == '@' ? "@@@" : quote;
    quote = quote ? quote : "@";
    fprintf(f, "\n    def OpenVDBAsset \"%s\"\n    {\n", r->name[grid]);
    fprintf(f, "        asset filePath = %s./%s%s\n", quote, file, quote);
    fprintf(f, "        token fieldName = \"%s\"\n        int fieldIndex = 0\n", r->name[grid]);
    /* float even if the file stores half floats, as readers convert them */
    fprintf(f, "        token fieldDataType = \"float%s\"\n", color ? "3" : "");
    fprintf(f, "        token fieldClass = \"fogVolume\"\n");
    if (color)
        fprintf(f, "        token vectorDataRoleHint = \"Color\"\n");
    fprintf(f, "    }\n");
}

char *iso_bake_usda(const iso_baked *b, const iso_bake_request *r, const char *path)
{
    char *text = NULL, name[64];
    size_t size = 0;
    double lo[3], hi[3];
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    prim_name(path, name, sizeof name);
    find_extent(b, &r->convention, lo, hi);
    fprintf(f, "#usda 1.0\n(\n    defaultPrim = \"%s\"\n    metersPerUnit = %.9g\n    upAxis = \"%s\"\n)\n", name,
            r->convention.unit_mm / 1000, r->convention.y_up ? "Y" : "Z");
    fprintf(f, "\ndef Volume \"%s\"\n{\n", name);
    fprintf(f, "    float3[] extent = [(%.9g, %.9g, %.9g), (%.9g, %.9g, %.9g)]\n", lo[0], lo[1], lo[2], hi[0], hi[1],
            hi[2]);
    for (int i = 0; i < ISO_BAKE_GRIDS; ++i)
        if (r->has[i])
            fprintf(f, "    rel field:%s = </%s/%s>\n", r->name[i], name, r->name[i]);
    for (int i = 0; i < ISO_BAKE_GRIDS; ++i)
        if (r->has[i])
            write_asset(f, r, i, iso_path_base(path));
    fprintf(f, "}\n");
    const bool failed = ferror(f) != 0;
    if (fclose(f) != 0 || failed) {
        free(text);
        return NULL;
    }
    return text;
}
