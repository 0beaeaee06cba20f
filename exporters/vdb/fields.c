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

/* Writes the file's metadata, with the keys of vdb.h. */
static iso_status note(const iso_vdb_job *job, void *user, iso_error *err)
{
    const iso_vdb_fields *f = *(const iso_vdb_fields **)user;
    NEED(iso_vdb_note(job, "creator", "isoshade " ISO_VERSION, err));
    NEED(iso_vdb_note(job, "source", f->made_from, err));
    NEED(iso_vdb_note(job, "values", f->values, err));
    return iso_vdb_note(job, "units", f->convention.unit, err);
}

static iso_status add(const iso_vdb_job *job, void *user, size_t i, iso_error *err)
{
    const iso_vdb_fields *f = *(const iso_vdb_fields **)user;
    const iso_vdb_source source = describe(f, &f->items[i]);
    return iso_vdb_add(job, &source, err);
}

iso_status iso_vdb_save_fields(const iso_vdb_fields *f, const char *path, const iso_progress *progress, iso_error *err)
{
    NEED(check_size(f, path, err));
    return iso_vdb_save_file(&(iso_vdb_contents){note, add, &f, f->count, NULL, f->nanovdb}, path, progress, err);
}
