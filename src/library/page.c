/* SPDX-License-Identifier: MIT */
/* page.c - the viewer page of the library's interface, and memory that it returns. */
#include <stdlib.h>

#include "base/file.h"
#include "base/temporary.h"
#include "library/shared.h"
#include "view/viewer.h"

enum { PAGE_LEVELS = 5 };

void iso_free(void *memory)
{
    free(memory);
}

static iso_viewer viewer_of(const iso_pyramid *p, const iso_scene *scene, const iso_page_options *o)
{
    iso_viewer v = {.pyramid = p,
                    .scene = scene,
                    .title = o->title ? o->title : "volume",
                    .first = iso_viewer_finest_level(p,
                                                     o->most_voxels ? (double)o->most_voxels : ISO_VIEWER_MOST_VOXELS),
                    .compact = o->compact,
                    .code_count = 1,
                    .codes = {p->options.code},
                    .threads = o->threads};
    v.last = v.first + PAGE_LEVELS <= p->level_count ? v.first + PAGE_LEVELS - 1 : p->level_count - 1;
    return v;
}

/* Writes the page to a temporary folder and reads it. */
static iso_status make_page(const iso_viewer *v, const iso_progress *progress, char **html, iso_error *err)
{
    iso_viewer_size size;
    size_t bytes;
    ENDED_BY(iso_end_temp_dir) char *dir = iso_make_temp_dir();
    if (!dir)
        return iso_temp_dir_fail(err);
    FREED char *path = iso_path_join(dir, "page.html");
    NEED(path ? iso_viewer_save(v, path, progress, &size, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    return iso_file_read(path, html, &bytes, err);
}

iso_status iso_view_page(const iso_pyramid *pyramid, const iso_scene *scene, const iso_page_options *options,
                         char **html, iso_error *err)
{
    const iso_page_options given = options ? *options : (iso_page_options){0};
    iso_scene *automatic = NULL;
    iso_call call;
    *html = NULL;
    iso_call_begin(&call, given.progress, given.progress_user);
    iso_status status = ISO_OK;
    if (!iso_code_describe(pyramid->options.code)->is_textured)
        status = iso_fail(err, ISO_E_USAGE, "code %s: a page needs a code that textures can filter",
                          iso_code_describe(pyramid->options.code)->name);
    if (status == ISO_OK && !scene)
        status = iso_scene_automatic(pyramid, NULL, &automatic, err);
    const iso_viewer v = viewer_of(pyramid, scene ? scene : automatic, &given);
    TRY(status, make_page(&v, &call.progress, html, err));
    TRY(status, iso_progress_check(&call.progress, err));
    if (status != ISO_OK) {
        free(*html);
        *html = NULL;
    }
    iso_scene_free(automatic);
    return iso_call_end(&call, status, err);
}
