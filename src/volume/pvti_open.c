/* SPDX-License-Identifier: MIT */
/* pvti_open.c - VTK's parallel image data and rectilinear grids: a .pvti or .pvtr that names pieces, .vti or .vtr files
 * next to it. Pieces may overlap; together they fill the whole, with even steps. All are read at once. */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "volume/reader.h"

#define MOST_OFF 0.01 /* of a step, as in rectilinear.h */

enum { MOST_BYTES = 16 << 20, MOST_PIECES = 1 << 16, NAME_BYTES = 1024 };

typedef struct pvti {
    long extent[6];
    size_t size[3]; /* samples: cells if `of_cells` */
    bool of_cells;
    const char *ending; /* of pieces: ".vti", ".vtr" */
    unsigned char *is_filled; /* of each sample */
} pvti;

static bool read_extent(const char *tag, const char *name, long e[6])
{
    char word[NAME_BYTES];
    return iso_reader_attribute(tag, name, word, sizeof word) &&
           sscanf(word, "%18ld %18ld %18ld %18ld %18ld %18ld", &e[0], &e[1], &e[2], &e[3], &e[4], &e[5]) == 6 &&
           e[0] <= e[1] && e[2] <= e[3] && e[4] <= e[5];
}

/* Opens a piece; its grid gives directions and spacing, which all share. */
static iso_status open_piece(const pvti *p, const iso_volume_source *whole, const char *name, iso_volume_source **piece,
                             iso_error *err)
{
    FREED char *path = NULL;
    const char *base = iso_path_base(whole->path);
    iso_volume_hints hints = whole->hints;
    hints.is_piece = true;
    *piece = NULL;
    if (*name == '/' || strstr(name, "..") || !iso_path_ends_with(name, p->ending))
        return iso_fail(err, ISO_E_FORMAT, "%s: its piece is \"%.200s\", must be a %s in its folder or below",
                        whole->path, name, p->ending);
    if (asprintf(&path, "%.*s%s", (int)(base - whole->path), whole->path, name) < 0)
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", whole->path);
    return iso_source_open_with(path, &hints, piece, err);
}

/* Copies a row of samples and marks them. */
static void put_row(const pvti *p, const char *row, size_t count, size_t to, size_t sample, char *out)
{
    memcpy(out + to * sample, row, count * sample);
    memset(p->is_filled + to, 1, count);
}

/* Refuses a piece that is not where even steps from the whole's first sample lead. */
static iso_status check_place(const iso_volume_source *whole, const iso_volume_source *piece, const size_t at[3],
                              iso_error *err)
{
    const iso_geometry *g = &whole->header.geometry, *own = &iso_source_volume(piece)->geometry;
    const iso_vec3 begin = iso_geometry_to_index(g, own->origin_mm);
    const double to[3] = {begin.x, begin.y, begin.z};
    for (int a = 0; a < 3; ++a) {
        const double ratio = iso_norm(iso_column(own->index_to_world, a)) / iso_norm(iso_column(g->index_to_world, a));
        if (!(fabs(to[a] - (double)at[a]) <= MOST_OFF && fabs(ratio - 1) <= MOST_OFF))
            return iso_fail(err, ISO_E_FORMAT,
                            "%s: uneven: %s begins %g steps along axis %d, must be %zu, with steps of %g, must be 1; "
                            "merge the pieces, and read the result with --resample",
                            whole->path, piece->path, to[a], a + 1, at[a], ratio);
    }
    return ISO_OK;
}

static iso_status put_piece(pvti *p, iso_volume_source *whole, iso_volume_source *piece, const long e[6],
                            iso_error *err)
{
    const iso_volume *v = iso_source_volume(piece);
    const size_t *n = v->geometry.size, sample = iso_type_bytes(v->type);
    size_t at[3];
    for (int a = 0; a < 3; ++a) {
        const long samples = e[2 * a + 1] - e[2 * a] + (p->of_cells ? 0 : 1);
        at[a] = (size_t)(e[2 * a] - p->extent[2 * a]);
        if (e[2 * a] < p->extent[2 * a] || e[2 * a + 1] > p->extent[2 * a + 1] || n[a] != (size_t)samples)
            return iso_fail(err, ISO_E_FORMAT, "%s: %s has %zu samples along axis %d, must be %ld within %ld to %ld",
                            whole->path, piece->path, n[a], a + 1, samples, p->extent[2 * a], p->extent[2 * a + 1]);
    }
    if (v->type != whole->header.type)
        return iso_fail(err, ISO_E_FORMAT, "%s: %s is of type %s, the first piece of %s", whole->path, piece->path,
                        iso_type_name(v->type), iso_type_name(whole->header.type));
    NEED(check_place(whole, piece, at, err));
    FREED char *plane = malloc(n[0] * n[1] * sample);
    NEED_MEMORY(plane, err, "%s: no memory for a plane", whole->path);
    for (size_t z = 0; z < n[2]; ++z) {
        NEED(iso_source_read(piece, 1, plane, err));
        for (size_t y = 0; y < n[1]; ++y)
            put_row(p, plane + y * n[0] * sample, n[0], ((at[2] + z) * p->size[1] + at[1] + y) * p->size[0] + at[0],
                    sample, whole->preloaded);
    }
    return ISO_OK;
}

/* Takes the whole's grid from a piece that begins at extent `e`, and memory for its samples, at most as many bytes as
 * `packed` bytes of pieces may hold. */
static iso_status begin(pvti *p, iso_volume_source *whole, const iso_volume_source *piece, const long e[6],
                        double packed, iso_error *err)
{
    const iso_volume *v = iso_source_volume(piece);
    iso_geometry *g = &whole->header.geometry;
    iso_vec3 back = iso_v3(0, 0, 0);
    p->of_cells = v->geometry.size[0] == (size_t)(e[1] - e[0]) && v->geometry.size[1] == (size_t)(e[3] - e[2]);
    for (int a = 0; a < 3; ++a) {
        const double points = (double)p->extent[2 * a + 1] - (double)p->extent[2 * a] + (p->of_cells ? 0 : 1);
        p->size[a] = points >= 1 && points < 1e12 ? (size_t)points : 0;
        back = iso_madd(back, iso_column(v->geometry.index_to_world, a), (double)(p->extent[2 * a] - e[2 * a]));
    }
    *g = iso_geometry_axis_aligned(p->size, (double[]){1, 1, 1});
    g->index_to_world = v->geometry.index_to_world;
    g->origin_mm = iso_add(v->geometry.origin_mm, back);
    whole->header.type = v->type;
    whole->header.notes = v->notes;
    NEED(iso_source_check_geometry(whole, err));
    NEED(iso_source_check_packed(whole, whole->path, packed, ISO_SOURCE_DEFLATE_MOST, err));
    whole->preloaded = malloc(iso_source_bytes(whole));
    p->is_filled = calloc(iso_geometry_voxel_count(g), 1);
    return whole->preloaded && p->is_filled ? ISO_OK
                                            : iso_fail(err, ISO_E_MEMORY, "%s: no memory for its samples", whole->path);
}

/* Returns the bytes of all pieces. */
static double bytes_of_pieces(const char *text, const char *path)
{
    char name[NAME_BYTES], *file = NULL;
    double bytes = 0;
    struct stat st;
    for (const char *tag = text; (tag = strstr(tag, "<Piece ")); ++tag)
        if (iso_reader_attribute(tag, "Source", name, sizeof name) &&
            asprintf(&file, "%.*s%s", (int)(iso_path_base(path) - path), path, name) >= 0) {
            bytes += stat(file, &st) == 0 ? (double)st.st_size : 0;
            free(file);
        }
    return bytes;
}

static iso_status read_pieces(pvti *p, const char *text, iso_volume_source *whole, iso_error *err)
{
    const double packed = bytes_of_pieces(text, whole->path);
    char name[NAME_BYTES];
    long e[6];
    size_t pieces = 0;
    for (const char *tag = text; (tag = strstr(tag, "<Piece ")); ++tag) {
        ENDED_BY(iso_source_close_owned) iso_volume_source *piece = NULL;
        if (++pieces > MOST_PIECES || !read_extent(tag, "Extent", e) ||
            !iso_reader_attribute(tag, "Source", name, sizeof name))
            return iso_fail(err, ISO_E_FORMAT, "%s: damaged: piece %zu has no extent and source, or is one of too many",
                            whole->path, pieces);
        NEED(open_piece(p, whole, name, &piece, err));
        if (pieces == 1)
            NEED(begin(p, whole, piece, e, packed, err));
        NEED(put_piece(p, whole, piece, e, err));
    }
    if (pieces == 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated, or without pieces", whole->path);
    for (size_t i = 0; i < iso_geometry_voxel_count(&whole->header.geometry); ++i)
        if (!p->is_filled[i])
            return iso_fail(err, ISO_E_FORMAT, "%s: its %zu pieces do not fill the whole: sample %zu is in none",
                            whole->path, pieces, i);
    return ISO_OK;
}

static iso_status open_pvti(iso_volume_source *source, iso_error *err)
{
    pvti p = {0};
    FREED char *text = NULL;
    size_t size;
    struct stat st;
    if (stat(source->path, &st) == 0 && st.st_size > MOST_BYTES)
        return iso_fail(err, ISO_E_FORMAT, "%s: a list of %.0f bytes, must be at most %d", source->path,
                        (double)st.st_size, MOST_BYTES);
    NEED(iso_file_read(source->path, &text, &size, err));
    const char *grid = strstr(text, "<PImageData");
    p.ending = grid ? ".vti" : ".vtr";
    if (!grid)
        grid = strstr(text, "<PRectilinearGrid");
    if (!grid || !read_extent(grid, "WholeExtent", p.extent))
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated, or no parallel grid with a WholeExtent", source->path);
    if (source->hints.uneven != ISO_UNEVEN_REFUSE)
        return iso_fail(err, ISO_E_USAGE, "%s: --resample and --force-spacing read no grid in pieces; merge them",
                        source->path);
    const iso_status status = read_pieces(&p, text, source, err);
    free(p.is_filled);
    return status;
}

static bool starts_like_pvti(const unsigned char *head, size_t size)
{
    return memmem(head, size, "<VTKFile", 8) &&
           (memmem(head, size, "\"PImageData\"", 12) || memmem(head, size, "\"PRectilinearGrid\"", 18));
}

const iso_volume_format iso_volume_format_pvti = {
    .name = "pvti",
    .title = "VTK XML, parallel",
    .summary = "image data and rectilinear grids in several .vti or .vtr files, at once",
    .suffixes = ".pvti .pvtr",
    .starts = "\"<VTKFile\"",
    .probe = starts_like_pvti,
    .open = open_pvti,
};
