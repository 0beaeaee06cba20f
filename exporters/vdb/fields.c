/* SPDX-License-Identifier: MIT */
#include "vdb/fields.h"

#include <string.h>

#include "base/file.h"
#include "base/parallel.h"
#include "base/version.h"
#include "vdb/vdb_file.h"
#include "vdb/vdb_openvdb.h"

iso_vdb_convention iso_vdb_own_convention(void)
{
    return (iso_vdb_convention){.unit_mm = 1, .unit = "mm"};
}

iso_vec3 iso_vdb_turned(const iso_vdb_convention *c, iso_vec3 v)
{
    return c->y_up ? iso_v3(v.x, v.z, -v.y) : v;
}

iso_vec3 iso_vdb_in_scene(const iso_vdb_convention *c, iso_vec3 world_mm)
{
    return iso_scale(iso_vdb_turned(c, world_mm), 1 / c->unit_mm);
}

/* Makes the transform from integers at the points to scene units. */
static void place(const iso_vdb_fields *f, double m[3][4])
{
    const iso_geometry *g = f->geometry;
    iso_vec3 columns[4];
    for (int c = 0; c < 3; ++c)
        columns[c] = iso_vdb_in_scene(&f->convention, iso_column(g->index_to_world, c));
    columns[3] = iso_vdb_in_scene(&f->convention, iso_geometry_to_world(g, iso_v3(0.5, 0.5, 0.5)));
    for (int c = 0; c < 4; ++c) {
        m[0][c] = columns[c].x;
        m[1][c] = columns[c].y;
        m[2][c] = columns[c].z;
    }
}

/* OpenVDB refuses voxels of 1e-15 cubic units, and renderers' single precision needs some margin. */
static const double least_voxel = 5e-5, most_voxel = 1e6;

bool iso_vdb_fits(const iso_vdb_convention *c, const iso_geometry *g)
{
    const double voxel = iso_geometry_mean_spacing_mm(g) / c->unit_mm;
    return voxel >= least_voxel && voxel <= most_voxel;
}

static iso_status check_size(const iso_vdb_fields *f, const char *path, iso_error *err)
{
    return iso_vdb_fits(&f->convention, f->geometry)
               ? ISO_OK
               : iso_fail(err, ISO_E_RANGE,
                          "%s: a voxel is %.3g %s, OpenVDB takes %.3g to %.3g; leave --scene-unit out", path,
                          iso_geometry_mean_spacing_mm(f->geometry) / f->convention.unit_mm, f->convention.unit,
                          least_voxel, most_voxel);
}

static iso_vdb_source describe(const iso_vdb_fields *f, const iso_vdb_field *field)
{
    iso_vdb_source s = {.name = field->name,
                        .channels = field->channels,
                        .read = field->read,
                        .read_active = field->read_active,
                        .user = field->user,
                        .active_user = field->user,
                        .pad = f->rim,
                        .direction_scale = 1,
                        .half_float = f->half_float,
                        .fog_volume = true,
                        .is_color = field->channels == 3,
                        .y_up = f->convention.y_up,
                        .creator = "isoshade",
                        .made_from = f->made_from,
                        .threads = iso_threads(f->threads),
                        .meaning = field->meaning,
                        .level = f->level,
                        .value_min = field->value_min,
                        .value_max = field->value_max,
                        .unit = f->convention.unit,
                        .unit_mm = f->convention.unit_mm};
    memcpy(s.size, f->geometry->size, sizeof s.size);
    memcpy(s.box_index, f->geometry->box_index, sizeof s.box_index);
    iso_geometry_spacing_mm(f->geometry, s.spacing_mm);
    place(f, s.index_to_world);
    /* Not at 0: Cycles adds a voxel on each side, and bounds grids with negative indices wrongly. */
    iso_vdb_begin_at(&s, (const long[]){ISO_VDB_FIELDS_FIRST, ISO_VDB_FIELDS_FIRST, ISO_VDB_FIELDS_FIRST});
    return s;
}

typedef struct fields_file {
    const iso_openvdb *openvdb;
    iso_vdb_file *file;
    const char *path; /* for messages */
} fields_file;

/* Writes the file's metadata, with the keys of vdb.h. */
static iso_status note(const fields_file *to, const iso_vdb_fields *f, iso_error *err)
{
    const char *const entries[][2] = {{"creator", "isoshade " ISO_VERSION},
                                      {"source", f->made_from},
                                      {"values", f->values},
                                      {"units", f->convention.unit}};
    for (size_t i = 0; i < sizeof entries / sizeof *entries; ++i) {
        iso_vdb_message message = {""};
        if (*entries[i][1] && to->openvdb->note(to->file, entries[i][0], entries[i][1], &message) != ISO_OPENVDB_OK)
            return iso_fail(err, ISO_E_PROGRAM, "%s: OpenVDB: %s", to->path, message.text);
    }
    return ISO_OK;
}

static iso_status add(const fields_file *to, const iso_vdb_fields *f, size_t i, iso_error *err)
{
    const iso_vdb_source source = describe(f, &f->items[i]);
    iso_vdb_message message = {""};
    const int code = to->openvdb->add(to->file, &source, &message);
    if (code == ISO_OPENVDB_OK)
        return ISO_OK;
    return iso_fail(err, code == ISO_OPENVDB_MEMORY ? ISO_E_MEMORY : ISO_E_PROGRAM, "%s: OpenVDB: %s", to->path,
                    message.text);
}

iso_status iso_vdb_save_fields(const iso_vdb_fields *f, const char *path, const iso_progress *progress, iso_error *err)
{
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    const char *stage = f->nanovdb ? "NanoVDB grids" : "OpenVDB grids";
    const iso_openvdb_form form = f->nanovdb ? ISO_OPENVDB_NANO : ISO_OPENVDB_PLAIN;
    NEED(check_size(f, path, err));
    const iso_openvdb *openvdb = iso_vdb_library(path, err);
    iso_status status = openvdb ? iso_output_begin(&out, path, err) : ISO_E_MISSING;
    if (status != ISO_OK)
        return status;
    const fields_file to = {openvdb, openvdb->create(), path};
    if (!to.file)
        status = iso_fail(err, ISO_E_MEMORY, "%s: OpenVDB cannot be started", path);
    for (size_t i = 0; i < f->count && status == ISO_OK; ++i) {
        iso_progress_report(progress, stage, (double)i / (double)(f->count + 1));
        status = iso_progress_check(progress, err);
        TRY(status, add(&to, f, i, err));
    }
    TRY(status, note(&to, f, err));
    iso_vdb_message message = {""};
    if (status == ISO_OK && openvdb->write(to.file, out.temp_path, form, &message) != ISO_OPENVDB_OK)
        status = iso_fail(err, ISO_E_IO, "%s: OpenVDB: %s", path, message.text);
    openvdb->destroy(to.file);
    TRY(status, iso_output_commit(&out, err));
    iso_progress_report(progress, stage, 1);
    return status;
}
