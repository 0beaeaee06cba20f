/* SPDX-License-Identifier: MIT */
/* target_nanovdb.c - the grids of the target vdb as a NanoVDB file. */
#include "targets/targets.h"
#include "vdb/vdb.h"

extern const iso_export_target iso_export_target_vdb;

static iso_status write_nanovdb(const iso_export_job *job, iso_error *err)
{
    const char *version;
    if (job->bake && job->bake->usd)
        return iso_fail(err, ISO_E_USAGE,
                        "--usd, which --for %s may set, has no meaning for --to nanovdb: a .usda needs OpenVDB files",
                        job->bake->program ? job->bake->program->name : "PROGRAM");
    NEED(iso_vdb_find_nanovdb(job->output, &version, err)); /* before the work starts */
    iso_export_job grids = *job;
    grids.nanovdb = true;
    NEED(iso_export_target_vdb.write(&grids, err));
    /* Other formats note the version in the file, too. */
    if (job->results)
        json_object_set_new(job->results, "nanovdb", json_pack("{ss}", "format", version));
    if (job->notes)
        fprintf(job->notes, "NanoVDB %s, not compressed\n", version);
    return ISO_OK;
}

const iso_export_target iso_export_target_nanovdb = {
    .name = "nanovdb",
    .title = "NanoVDB",
    .stages = {"NanoVDB grids"},
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
