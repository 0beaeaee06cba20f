/* SPDX-License-Identifier: MIT */
#include "bench/volumes.h"

#include "base/file.h"
#include "scene/subject.h"

iso_status iso_bench_check_pictures(const iso_bench_pictures *p, iso_error *err)
{
    iso_status status = ISO_OK;
    if (p->most_views > 0)
        status = iso_words_check_range("--views", p->views, 1, p->most_views, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--size", p->size, 16, 4096, err);
    return status == ISO_OK ? iso_words_check_range("--levels", p->levels, 2, p->most_levels, err) : status;
}

static iso_status visit_volume(const iso_bench_volumes *volumes, size_t i, iso_bench_visit visit, void *user,
                               iso_error *err)
{
    const char *path = volumes->cli->arguments[i];
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_pyramid p = {0};
    build.level_count = (size_t)volumes->levels;
    build.threads = volumes->cli->threads;
    iso_status status = iso_subject_load_pyramid(path, volumes->input, &build, volumes->loading, &p, err);
    for (size_t t = 0; t < ISO_LEVEL_TF_COUNT && status == ISO_OK; ++t) {
        const iso_bench_visited visited = {.volume = iso_path_base(path),
                                           .pyramid = &p,
                                           .tf = &iso_level_tfs[t],
                                           .number = i * ISO_LEVEL_TF_COUNT + t,
                                           .count = volumes->cli->argument_count * ISO_LEVEL_TF_COUNT};
        status = visit(user, &visited, err);
    }
    iso_pyramid_destroy(&p);
    return status;
}

iso_status iso_bench_visit_volumes(const iso_bench_volumes *volumes, iso_bench_visit visit, void *user, iso_error *err)
{
    iso_status status = ISO_OK;
    for (size_t i = 0; i < volumes->cli->argument_count && status == ISO_OK; ++i)
        status = visit_volume(volumes, i, visit, user, err);
    return status;
}
