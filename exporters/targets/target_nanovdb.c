/* SPDX-License-Identifier: MIT */
/* target_nanovdb.c - the grids of the target vdb as a NanoVDB file, by a temporary OpenVDB file next to it. */
#include <stdlib.h>

#include "base/file.h"
#include "base/unfinished.h"
#include "targets/targets.h"
#include "vdb/nanovdb.h"

extern const iso_export_target iso_export_target_vdb;

static const char stage[] = "NanoVDB grids";

/* Prints the version, which other formats note in the file, too. */
static void print_version(const iso_export_job *job)
{
    if (job->results)
        json_object_set_new(job->results, "nanovdb", json_pack("{ss}", "format", iso_nanovdb_version()));
    if (job->notes)
        fprintf(job->notes, "NanoVDB %s, not compressed\n", iso_nanovdb_version());
}

static iso_status write_nanovdb(const iso_export_job *job, iso_error *err)
{
    if (job->bake && job->bake->usd)
        return iso_fail(err, ISO_E_USAGE,
                        "--usd, which --for %s may set, has no meaning for --to nanovdb: a .usda needs OpenVDB files",
                        job->bake->program ? job->bake->program->name : "PROGRAM");
    if (!iso_nanovdb_version()) /* before the work starts */
        return iso_nanovdb_from_vdb("", job->output, err);
    FREED char *folder = iso_path_dir(job->output);
    FREED char *vdb = folder ? iso_temporary_path(folder, iso_path_base(job->output)) : NULL;
    if (vdb)
        iso_unfinished_add(vdb, false); /* before it exists; its writer removes the entry when it is finished */
    iso_export_job grids = *job;
    grids.output = vdb;
    grids.float_directions = true; /* NanoVDB has no metadata for the scale of half floats */
    iso_status status = vdb ? iso_export_target_vdb.write(&grids, err)
                            : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", job->output);
    iso_progress_report(job->progress, stage, 0);
    TRY(status, iso_nanovdb_from_vdb(vdb, job->output, err));
    iso_progress_report(job->progress, stage, 1);
    if (status == ISO_OK)
        print_version(job);
    if (vdb)
        iso_remove_tree(vdb);
    return status;
}

const iso_export_target iso_export_target_nanovdb = {
    .name = "nanovdb",
    .title = "NanoVDB",
    .stages = {"OpenVDB grids", stage},
    .summary = "a NanoVDB file: the grids of --to vdb, for programs on GPUs",
    .baked = "a NanoVDB file of baked grids",
    .output = "NAME.nvdb",
    .options = ISO_EXPORT_TAKES(ISO_EXPORT_PLAN) | ISO_EXPORT_TAKES(ISO_EXPORT_LEVELS) |
               ISO_EXPORT_TAKES(ISO_EXPORT_GRIDS) | ISO_EXPORT_TAKES(ISO_EXPORT_EXTINCTION_SCALE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_BAKE) | ISO_EXPORT_TAKES(ISO_EXPORT_DENSE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_BACKGROUND) | ISO_EXPORT_TAKES(ISO_EXPORT_SHOWN),
    .narrow = true,
    .write = write_nanovdb,
    .suffix = ".nvdb",
};
