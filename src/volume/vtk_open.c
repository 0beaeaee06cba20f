/* SPDX-License-Identifier: MIT */
/* vtk_open.c - VTK's legacy files: lines of words, then samples, big-endian or as text; structured points, and
 * rectilinear grids (rectilinear.h). */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "volume/reader.h"
#include "volume/rectilinear.h"

enum { LINE_BYTES = 1024, HEADER_LINES = 4096 };

typedef struct vtk_header {
    size_t points[3];
    double spacing[3], origin[3];
    bool is_text, of_cells, is_color, found;
    bool has_data, is_field; /* after POINT_DATA or CELL_DATA; a line of FIELD is next */
    int components;
    char dataset[64], type[64];
    char damaged[24]; /* "", or the coordinates that cannot be read */
    iso_rectilinear coordinates;
} vtk_header;

/* Reads a coordinate: as text, or big-endian of 4 or 8 bytes. */
static bool read_coordinate(FILE *f, bool is_text, bool is_double, double *value)
{
    unsigned char bytes[8];
    const size_t count = is_double ? 8 : 4;
    if (is_text)
        return fscanf(f, "%lf", value) == 1;
    if (fread(bytes, 1, count, f) != count)
        return false;
    uint64_t bits = 0;
    for (size_t i = 0; i < count; ++i)
        bits = bits << 8 | bytes[i];
    const uint32_t half = (uint32_t)bits;
    float single;
    memcpy(&single, &half, sizeof single);
    if (is_double)
        memcpy(value, &bits, sizeof bits);
    else
        *value = (double)single;
    return isfinite(*value);
}

/* Reads "X_COORDINATES 7 float" and the numbers after it. */
static void take_coordinates(FILE *f, vtk_header *h, const char *line)
{
    enum { MOST = 1 << 24, ROOM = 1024 };
    const int axis = line[0] - 'X';
    double *at = NULL;
    size_t count = 0;
    char type[16] = "";
    sscanf(line, "%*s %18zu %15s", &count, type);
    const bool is_double = strcmp(type, "double") == 0;
    bool well = (is_double || strcmp(type, "float") == 0) && count >= 1 && count <= MOST && !h->coordinates.at[axis];
    for (size_t i = 0; i < count && well; ++i) {
        double *more = i % ROOM == 0 ? realloc(at, (i + ROOM) * sizeof *at) : at;
        at = more ? more : at;
        well = more && read_coordinate(f, h->is_text, is_double, &at[i]);
    }
    if (!well)
        snprintf(h->damaged, sizeof h->damaged, "%c_COORDINATES", line[0]);
    if (h->coordinates.at[axis])
        free(at);
    else
        h->coordinates.at[axis] = at, h->coordinates.count[axis] = count;
}

/* Reads one line before the samples. found: samples follow the line, or the line LOOKUP_TABLE. The fields of the
 * whole file, before POINT_DATA, are no samples. */
static void take(vtk_header *h, const char *line)
{
    double v[3];
    char word[64] = "";
    sscanf(line, "%63s", word);
    if (h->is_field) { /* "NAME components tuples type" */
        h->is_field = false;
        h->found = sscanf(line, "%*s %d %*s %63s", &h->components, h->type) == 2;
    } else if (strcmp(word, "DATASET") == 0)
        sscanf(line, "%*s %63s", h->dataset);
    else if (strcmp(word, "DIMENSIONS") == 0)
        sscanf(line, "%*s %18zu %18zu %18zu", &h->points[0], &h->points[1], &h->points[2]);
    else if ((strcmp(word, "SPACING") == 0 || strcmp(word, "ASPECT_RATIO") == 0) &&
             sscanf(line, "%*s %lf %lf %lf", &v[0], &v[1], &v[2]) == 3)
        memcpy(h->spacing, v, sizeof v);
    else if (strcmp(word, "ORIGIN") == 0 && sscanf(line, "%*s %lf %lf %lf", &v[0], &v[1], &v[2]) == 3)
        memcpy(h->origin, v, sizeof v);
    else if (strcmp(word, "CELL_DATA") == 0 || strcmp(word, "POINT_DATA") == 0)
        h->of_cells = word[0] == 'C', h->has_data = true;
    else if (strcmp(word, "SCALARS") == 0) {
        h->components = 1;
        h->found = sscanf(line, "%*s %*s %63s %d", h->type, &h->components) >= 1;
    } else if (strcmp(word, "COLOR_SCALARS") == 0) { /* how VTK writes bytes */
        h->found = h->is_color = sscanf(line, "%*s %*s %d", &h->components) == 1;
        snprintf(h->type, sizeof h->type, "unsigned_char");
    } else if (strcmp(word, "VECTORS") == 0 || strcmp(word, "NORMALS") == 0) {
        h->components = 3;
        h->found = sscanf(line, "%*s %*s %63s", h->type) == 1;
    } else
        h->is_field = h->has_data && strcmp(word, "FIELD") == 0;
}

/* Leaves the file at the first sample. */
static iso_status read_header(FILE *f, const char *path, vtk_header *h, iso_error *err)
{
    char line[LINE_BYTES];
    *h = (vtk_header){.spacing = {1, 1, 1}};
    for (int i = 0; i < HEADER_LINES && !h->found && fgets(line, sizeof line, f); ++i) {
        if (i == 2)
            h->is_text = strncmp(line, "ASCII", 5) == 0;
        else if (i > 2)
            take(h, line);
        if (i > 2 && line[0] >= 'X' && line[0] <= 'Z' && strncmp(line + 1, "_COORDINATES ", 13) == 0)
            take_coordinates(f, h, line);
        if (h->damaged[0])
            return iso_fail(err, ISO_E_FORMAT, "%s: %s are truncated, not finite, or no float or double", path,
                            h->damaged);
        if (h->dataset[0] && strcmp(h->dataset, "STRUCTURED_POINTS") != 0 &&
            strcmp(h->dataset, "RECTILINEAR_GRID") != 0)
            return iso_fail(err, ISO_E_FORMAT,
                            "%s: a dataset of VTK's kind %s, must be STRUCTURED_POINTS or RECTILINEAR_GRID", path,
                            h->dataset);
    }
    if (!h->found)
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: truncated, or without SCALARS, VECTORS or FIELD: no samples in a VTK file", path);
    if (h->components < 1)
        return iso_fail(err, ISO_E_FORMAT, "%s: %d components per voxel, must be at least 1", path, h->components);
    if (h->is_color && h->is_text)
        return iso_fail(err, ISO_E_FORMAT, "%s: its samples are bytes as text (COLOR_SCALARS), which is not read",
                        path);
    const off_t at = ftello(f);
    if (!h->is_color && (!fgets(line, sizeof line, f) || strncmp(line, "LOOKUP_TABLE", 12) != 0))
        fseeko(f, at, SEEK_SET);
    return ISO_OK;
}

/* Takes the geometry. Points stand at ORIGIN and every SPACING from there; cells lie between them. */
static iso_status take_geometry(vtk_header *h, iso_volume_source *source, iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    size_t size[3];
    double mm, spacing[3], corner[3];
    NEED(iso_source_unit(source, NULL, "mm", &mm, err));
    if (strcmp(h->dataset, "RECTILINEAR_GRID") == 0)
        NEED(iso_rectilinear_measure(&h->coordinates, source, h->points, h->origin, h->spacing, err));
    memcpy(spacing, h->spacing, sizeof spacing); /* 1 if the file gives none, as VTK has it */
    NEED(iso_source_take_spacing(source, spacing, err));
    for (int a = 0; a < 3; ++a) {
        size[a] = h->of_cells && h->points[a] > 0 ? h->points[a] - 1 : h->points[a];
        spacing[a] *= mm;
        corner[a] = h->origin[a] * mm - (h->of_cells ? 0 : spacing[a] / 2);
    }
    *g = iso_geometry_axis_aligned(size, spacing);
    g->origin_mm = iso_v3(corner[0], corner[1], corner[2]);
    return iso_source_check_geometry(source, err);
}

/* Reads the header and finds the samples; leaves coordinates to be released also on failure. */
static iso_status read_samples(FILE *f, vtk_header *h, iso_volume_source *source, iso_error *err)
{
    NEED(read_header(f, source->path, h, err));
    NEED(iso_reader_need_type(source, h->type, err));
    NEED(take_geometry(h, source, err));
    /* Bytes are always written as colors: three or four of them count as such. */
    const iso_extra_axes axes = {.channel = {.count = (size_t)h->components, .inside = true, .stride = 1},
                                 .is_color = h->is_color && h->components >= 3 && h->components <= 4};
    NEED(iso_source_choose(source, &axes, err));
    if (h->is_text)
        return iso_source_take_text(source, f, (iso_text_layout){.words_follow = true}, err);
    source->swap_bytes = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ && iso_type_bytes(source->header.type) > 1;
    return iso_source_take_part(source, source->path, (size_t)ftello(f), err);
}

static iso_status read_vtk(FILE *f, iso_volume_source *source, iso_error *err)
{
    vtk_header h;
    iso_status status = iso_source_check_read(f, source->path, read_samples(f, &h, source, err), err);
    TRY(status, iso_rectilinear_resample(&h.coordinates, source, err));
    iso_rectilinear_destroy(&h.coordinates);
    return status;
}

const iso_volume_format iso_volume_format_vtk = {
    .name = "vtk",
    .title = "VTK legacy",
    .summary = "structured points and rectilinear grids, of points or cells; binary plane by plane, text at once",
    .suffixes = ".vtk",
    .starts = "\"# vtk DataFile\"",
    .marks = {ISO_MARK(0, "# vtk DataFile")},
    .read = read_vtk,
};
