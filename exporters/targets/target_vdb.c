/* SPDX-License-Identifier: MIT */
/* target_vdb.c - levels, or the bricks of a plan, as grids of one OpenVDB file. */
#include <stdlib.h>

#include "targets/target_vdb_baked.h"
#include "vdb/vdb.h"

static iso_status write_planned(const iso_export_job *job, iso_vdb_options *o, iso_error *err)
{
    o->half_directions = !job->float_directions;
    OWNED(iso_planned_lattices) lattices = {0};
    NEED(iso_planned_lattices_create(job->planned, job->merged, false, job->threads, &lattices, err));
    return iso_vdb_save_lattices(lattices.items, lattices.count, job->pyramid->source, job->output, o, job->progress,
                                 err);
}

/* One view per level of the file, and the voxels that they show. */
typedef struct shown_levels {
    iso_view views[64];
    iso_vdb_shown shown[64];
} shown_levels;

static iso_status find_shown(const iso_export_job *job, shown_levels *l, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t k = 0; k < job->level_count && status == ISO_OK; ++k) {
        iso_view *view = &l->views[k];
        if (job->is_shown)
            status = job->view_of_level(job, job->level + k, view, err);
        if (status == ISO_OK && view->tf_2d)
            l->shown[k] = (iso_vdb_shown){.tfs = view->tf_2d->rows, .tf_count = ISO_TF_2D_ROWS};
        else if (status == ISO_OK && job->is_shown)
            l->shown[k] = (iso_vdb_shown){.tfs = &view->tf, .tf_count = 1};
        l->shown[k].has_background = job->background != NULL;
        l->shown[k].background = job->background ? *job->background : 0;
    }
    return status;
}

static iso_status write_vdb(const iso_export_job *job, iso_error *err)
{
    if (job->bake)
        return iso_target_vdb_baked(job, err);
    iso_vdb_options o = iso_vdb_defaults();
    o.half_float = job->half_float;
    o.unit = job->pyramid->unit.name;
    o.command = job->command;
    o.threads = job->threads;
    o.volume = job->volume;
    if (job->planned)
        return write_planned(job, &o, err);
    shown_levels *l = calloc(1, sizeof *l);
    iso_status status = l ? find_shown(job, l, err) : iso_fail(err, ISO_E_MEMORY, "export: out of memory");
    if (status == ISO_OK) {
        const bool sparse = (job->is_shown || job->background) && !job->dense;
        o.shown = sparse ? l->shown : NULL;
        o.half_directions = sparse && !job->float_directions;
        const bool has_shares = job->pyramid->levels[0].geometry.has_no_data; /* each level adds its own */
        for (size_t k = 0; k < job->level_count && !o.extinction_scale && !has_shares; ++k)
            o.extinction_scale = l->views[k].extinction_scale; /* refused if there are more levels */
        status = iso_vdb_save(job->pyramid, job->level, job->level_count, job->output, &o, job->progress, err);
    }
    for (size_t k = 0; l && k < job->level_count; ++k)
        iso_view_destroy(&l->views[k]);
    free(l);
    return status;
}

const iso_export_target iso_export_target_vdb = {
    .name = "vdb",
    .title = "OpenVDB",
    .stages = {"OpenVDB grids"},
    .summary = "an OpenVDB file: float grid density, vec3s grid gradient",
    .baked = "an OpenVDB file of baked grids",
    .output = "NAME.vdb",
    .options = ISO_EXPORT_TAKES(ISO_EXPORT_PLAN) | ISO_EXPORT_TAKES(ISO_EXPORT_LEVELS) |
               ISO_EXPORT_TAKES(ISO_EXPORT_HALF) | ISO_EXPORT_TAKES(ISO_EXPORT_GRIDS) |
               ISO_EXPORT_TAKES(ISO_EXPORT_EXTINCTION_SCALE) | ISO_EXPORT_TAKES(ISO_EXPORT_BAKE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_DENSE) | ISO_EXPORT_TAKES(ISO_EXPORT_BACKGROUND) |
               ISO_EXPORT_TAKES(ISO_EXPORT_SHOWN),
    .narrow = true,
    .write = write_vdb,
    .suffix = ".vdb",
};
