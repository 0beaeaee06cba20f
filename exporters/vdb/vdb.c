/* SPDX-License-Identifier: MIT */
/* vdb.c - saving: the metadata of a file, and the file. */
#define _GNU_SOURCE
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "base/provenance.h"
#include "vdb/vdb_file.h"
#include "volume/unit.h"

iso_vdb_options iso_vdb_defaults(void)
{
    return (iso_vdb_options){.half_float = false, .gradient = true, .pad_voxels = 0, .creator = "isoshade"};
}

/* Fills the transform to the world of a voxel's center: origin + index_to_world (ijk + 1/2). */
static void center_transform(const iso_geometry *g, double m[3][4])
{
    iso_vec3 first = iso_geometry_to_world(g, iso_v3(0.5, 0.5, 0.5));
    const double translation[3] = {first.x, first.y, first.z};
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
            m[r][c] = g->index_to_world.m[r][c];
        m[r][3] = translation[r];
    }
}

iso_status iso_vdb_fail(int code, const char *path, const iso_vdb_message *message, iso_error *err)
{
    static const iso_status statuses[] = {[ISO_OPENVDB_OK] = ISO_OK,
                                          [ISO_OPENVDB_IO] = ISO_E_IO,
                                          [ISO_OPENVDB_NO_GRID] = ISO_E_FORMAT,
                                          [ISO_OPENVDB_MEMORY] = ISO_E_MEMORY,
                                          [ISO_OPENVDB_FAILED] = ISO_E_PROGRAM};
    return iso_fail(err, statuses[code], "%s: OpenVDB: %s", path, message->text);
}

static bool suits(double voxel_mm, double unit_mm)
{
    return voxel_mm >= 1e-3 * unit_mm && voxel_mm <= 1e3 * unit_mm;
}

const char *iso_vdb_choose_unit(double voxel_mm, const char *preferred, double *mm)
{
    static const char *const units[] = {"m", "um", "nm", "pm"};
    const char *name = "mm";
    *mm = 1;
    if (voxel_mm >= 1e-4 && voxel_mm <= 1e5)
        return name;
    if (preferred && iso_unit_find(preferred, mm, &name) && suits(voxel_mm, *mm))
        return name;
    for (size_t i = 0; i < sizeof units / sizeof *units; ++i)
        if (iso_unit_find(units[i], mm, &name) && suits(voxel_mm, *mm))
            return name;
    *mm = pow(10, rint(log10(voxel_mm)));
    return "";
}

/* Converts the geometry to the unit of the file, and notes the unit. */
static void take_unit(iso_vdb_source *source, const iso_geometry *g, const iso_vdb_options *opt)
{
    source->unit = "";
    source->unit_mm = opt->unit_mm;
    if (opt->unit_mm > 0) {
        const double origin[3] = {opt->origin_mm.x, opt->origin_mm.y, opt->origin_mm.z};
        memcpy(source->origin_mm, origin, sizeof origin);
        for (int a = 0; a < 3; ++a)
            source->spacing_mm[a] *= opt->unit_mm;
        if (opt->unit_mm == 1)
            source->unit = "mm";
        return;
    }
    source->unit = iso_vdb_choose_unit(iso_geometry_min_spacing_mm(g), opt->unit, &source->unit_mm);
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c)
            source->index_to_world[r][c] /= source->unit_mm;
}

iso_vdb_source iso_vdb_describe(const iso_geometry *g, const char *made_from, const iso_vdb_options *opt)
{
    iso_vdb_source source = {.creator = opt->creator ? opt->creator : "isoshade",
                             .made_from = iso_provenance_name(made_from),
                             .threads = iso_threads(opt->threads),
                             .direction_scale = 1};
    memcpy(source.size, g->size, sizeof source.size);
    memcpy(source.box_index, g->box_index, sizeof source.box_index);
    iso_geometry_spacing_mm(g, source.spacing_mm);
    center_transform(g, source.index_to_world);
    take_unit(&source, g, opt);
    return source;
}

static iso_status check_levels(const iso_pyramid *p, size_t first, size_t count, const char *path,
                               const iso_vdb_options *opt, iso_error *err)
{
    if (count == 0 || first >= p->level_count || count > p->level_count - first)
        return iso_fail(err, ISO_E_RANGE, "%s: levels %zu to %zu, the pyramid has levels 0 to %zu", path, first,
                        first + count - 1, p->level_count - 1);
    if (opt->tf_2d && count != 1)
        return iso_fail(err, ISO_E_RANGE, "%s: a 2D transfer function with %zu levels, it belongs to one", path, count);
    if (opt->extinction_scale && count != 1)
        return iso_fail(err, ISO_E_RANGE, "%s: an extinction scale with %zu levels, it belongs to one", path, count);
    const size_t limit = 64; /* voxels of rim */
    if (opt->pad_voxels > limit)
        return iso_fail(err, ISO_E_RANGE, "%s: a rim of %zu voxels, at most %zu", path, opt->pad_voxels, limit);
    for (int a = 0; a < 3; ++a)
        if (p->levels[first].geometry.size[a] > INT_MAX - 2 * limit)
            return iso_fail(err, ISO_E_RANGE, "%s: %zu voxels along an axis, OpenVDB takes at most %zu", path,
                            p->levels[first].geometry.size[a], INT_MAX - 2 * limit);
    return ISO_OK;
}

/* Data to save: levels of a pyramid, or lattices. */
typedef struct save_job {
    const iso_pyramid *pyramid;
    size_t first;
    const iso_lattice *lattices;
    const char *made_from;
    size_t count;
    iso_vdb_grids *grids; /* count */
} save_job;

static iso_status result(const iso_vdb_job *job, int code, const iso_vdb_message *message, iso_error *err)
{
    return code == ISO_OPENVDB_OK ? ISO_OK : iso_vdb_fail(code, job->path, message, err);
}

iso_status iso_vdb_note(const iso_vdb_job *job, const char *key, const char *text, iso_error *err)
{
    iso_vdb_message message = {""};
    const int code = text && *text ? job->openvdb->note(job->file, key, text, &message) : ISO_OPENVDB_OK;
    return result(job, code, &message, err);
}

iso_status iso_vdb_add(const iso_vdb_job *job, const iso_vdb_source *source, iso_error *err)
{
    iso_vdb_message message = {""};
    return result(job, job->openvdb->add(job->file, source, &message), &message, err);
}

static iso_status write(const iso_vdb_job *job, const char *path, bool nanovdb, iso_error *err)
{
    iso_vdb_message message = {""};
    const bool is_small = job->opt && job->opt->half_directions;
    const iso_openvdb_form form = nanovdb ? ISO_OPENVDB_NANO : is_small ? ISO_OPENVDB_SMALL : ISO_OPENVDB_PLAIN;
    return result(job, job->openvdb->write(job->file, path, form, &message), &message, err);
}

iso_status iso_vdb_save_file(const iso_vdb_contents *c, const char *path, const iso_progress *progress, iso_error *err)
{
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    const char *stage = c->nanovdb ? "NanoVDB grids" : "OpenVDB grids";
    const iso_openvdb *openvdb = iso_vdb_library(path, err);
    iso_status status = openvdb ? iso_output_begin(&out, path, err) : ISO_E_MISSING;
    if (status != ISO_OK)
        return status;
    const iso_vdb_job job = {openvdb, openvdb->create(), path, c->opt, c->count == 1};
    if (!job.file)
        status = iso_fail(err, ISO_E_MEMORY, "%s: OpenVDB cannot be started", path);
    TRY(status, c->note(&job, c->user, err));
    for (size_t i = 0; i < c->count && status == ISO_OK; ++i) {
        iso_progress_report(progress, stage, (double)i / (double)(2 * c->count));
        status = iso_progress_check(progress, err);
        TRY(status, c->add(&job, c->user, i, err));
    }
    iso_progress_report(progress, stage, 0.5);
    TRY(status, iso_progress_check(progress, err));
    TRY(status, write(&job, out.temp_path, c->nanovdb, err));
    openvdb->destroy(job.file);
    TRY(status, iso_output_commit(&out, err));
    iso_progress_report(progress, stage, 1);
    return status;
}

/* Writes the file's metadata, and whether values are no data: an optimized level has those that show a scene best
 * (plan/optimize.h). */
static iso_status note(const iso_vdb_job *job, void *user, iso_error *err)
{
    const save_job *what = user;
    const iso_vdb_options *o = job->opt;
    const iso_pyramid *p = what->pyramid;
    const char *made_from = p ? p->source : what->made_from;
    const iso_vdb_source source = iso_vdb_describe(p ? &p->levels[what->first].geometry : &what->lattices[0].geometry,
                                                   made_from, o);
    bool is_optimized = false;
    char units[64];
    snprintf(units, sizeof units, *source.unit ? "%s" : "%s%.9g mm", source.unit, source.unit_mm);
    for (size_t i = 0; p && i < what->count; ++i)
        is_optimized = is_optimized || p->levels[what->first + i].is_optimized;
    NEED(iso_vdb_note(job, "creator", o->creator, err));
    NEED(iso_vdb_note(job, "source", source.made_from, err));
    NEED(iso_vdb_note(job, "units", units, err));
    NEED(iso_vdb_note(job, "command", o->command, err));
    return iso_vdb_note(job, "values", is_optimized ? ISO_OPTIMIZED_VALUES : "", err);
}

static iso_status add(const iso_vdb_job *job, void *user, size_t i, iso_error *err)
{
    const save_job *what = user;
    const iso_vdb_shown *shown = job->opt->shown ? &job->opt->shown[i] : NULL;
    return what->pyramid ? iso_vdb_add_level(job, what->pyramid, what->first + i, shown, &what->grids[i], err)
                         : iso_vdb_add_lattice(job, &what->lattices[i], what->made_from, &what->grids[i], err);
}

static iso_status save(save_job *what, const char *path, const iso_vdb_options *opt, const iso_progress *progress,
                       iso_error *err)
{
    FREED iso_vdb_grids *grids = what->grids = calloc(what->count, sizeof *grids);
    NEED_MEMORY(grids, err, "%s: no memory for %zu grids", path, what->count);
    const iso_status status = iso_vdb_save_file(&(iso_vdb_contents){note, add, what, what->count, opt, opt->nanovdb},
                                                path, progress, err);
    for (size_t i = 0; i < what->count; ++i)
        iso_vdb_grids_destroy(&grids[i]);
    return status;
}

iso_status iso_vdb_find_nanovdb(const char *path, const char **version, iso_error *err)
{
    const iso_openvdb *openvdb = iso_vdb_library(path, err);
    if (!openvdb)
        return ISO_E_MISSING;
    *version = openvdb->nanovdb_version();
    if (*version)
        return ISO_OK;
    return iso_fail(err, ISO_E_MISSING,
                    "%s: isoshade was built without NanoVDB (on Debian: libnanovdb-dev, then make clean all)", path);
}

bool iso_vdb_is_ours(const char *path)
{
    /* A key, the type of its value, and the value, each after its length. Only the command precedes it. */
    static const char key[] = "creator\6\0\0\0string", name[] = "isoshade";
    enum { HEAD_BYTES = 1 << 16, LENGTH_BYTES = 4 };
    FREED char *head = calloc(HEAD_BYTES + sizeof key + LENGTH_BYTES + sizeof name, 1);
    FILE *file = fopen(path, "rbe");
    const size_t size = head && file ? fread(head, 1, HEAD_BYTES, file) : 0;
    const char *at = size > 0 ? memmem(head, size, key, sizeof key - 1) : NULL;
    const bool found = at && strncmp(at + sizeof key - 1 + LENGTH_BYTES, name, sizeof name - 1) == 0;
    if (file)
        fclose(file);
    return found;
}

iso_status iso_vdb_save(const iso_pyramid *p, size_t first, size_t count, const char *path, const iso_vdb_options *opt,
                        const iso_progress *progress, iso_error *err)
{
    NEED(check_levels(p, first, count, path, opt, err));
    save_job job = {.pyramid = p, .first = first, .count = count};
    return save(&job, path, opt, progress, err);
}

iso_status iso_vdb_save_lattices(const iso_lattice *lattices, size_t count, const char *made_from, const char *path,
                                 const iso_vdb_options *opt, const iso_progress *progress, iso_error *err)
{
    save_job job = {.lattices = lattices, .count = count, .made_from = made_from};
    return save(&job, path, opt, progress, err);
}
