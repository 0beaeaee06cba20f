/* SPDX-License-Identifier: MIT */
/* target_vdb.c - levels, or what a plan leaves, as grids of one OpenVDB file. */
#include "targets/target_vdb_baked.h"
#include "vdb/vdb.h"

static iso_status write_planned(const iso_export_job *job, const iso_vdb_options *o, iso_error *err)
{
    iso_planned_lattices lattices;
    iso_status status = iso_planned_lattices_create(job->planned, job->merged, false, job->threads, &lattices, err);
    if (status != ISO_OK)
        return status;
    status = iso_vdb_save_lattices(lattices.items, lattices.count, job->pyramid->source, job->output, o, job->progress,
                                   err);
    iso_planned_lattices_destroy(&lattices);
    return status;
}

static iso_status write_vdb(const iso_export_job *job, iso_error *err)
{
    if (job->bake)
        return iso_target_vdb_baked(job, err);
    iso_vdb_options o = iso_vdb_defaults();
    o.half_float = job->half_float;
    o.unit = job->pyramid->unit.name;
    if (job->planned)
        return write_planned(job, &o, err);
    iso_view view = {0};
    iso_status status = job->extinction_scale ? job->view_of_level(job, job->level, &view, err) : ISO_OK;
    o.extinction_scale = view.extinction_scale;
    if (status == ISO_OK)
        status = iso_vdb_save(job->pyramid, job->level, job->level_count, job->output, &o, job->progress, err);
    iso_view_destroy(&view);
    return status;
}

const iso_export_target iso_export_target_vdb = {
    .name = "vdb",
    .title = "OpenVDB",
    .stages = {"OpenVDB grids"},
    .summary = "an OpenVDB file: float grid density, vec3s grid gradient",
    .output = "NAME.vdb",
    .options = ISO_EXPORT_TAKES(ISO_EXPORT_LEVELS) | ISO_EXPORT_TAKES(ISO_EXPORT_HALF) |
               ISO_EXPORT_TAKES(ISO_EXPORT_GRIDS) | ISO_EXPORT_TAKES(ISO_EXPORT_EXTINCTION_SCALE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_BAKE),
    .write = write_vdb,
    .suffix = ".vdb",
};
