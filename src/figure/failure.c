/* SPDX-License-Identifier: MIT */
/* One entry of the failure atlas: the correct picture, the failure of a method, and the remedy. */
#include <stdio.h>
#include <string.h>

#include "atlas/atlas.h"
#include "figure/columns.h"
#include "figure/kinds.h"

typedef struct entry {
    iso_atlas_case one; /* at the figure's size */
    iso_volume volume;
    iso_tf_table tf; /* empty if the case is not rendered */
} entry;

static void entry_destroy(entry *e)
{
    iso_tf_table_destroy(&e->tf);
    iso_volume_destroy(&e->volume);
}

static iso_status render(void *user, size_t column, size_t width, size_t height, iso_image *image, double *mm_per_pixel,
                         iso_error *err)
{
    entry *e = user;
    iso_image drawn = {0};
    double unused;
    e->one.scene.pixels = width;
    *mm_per_pixel = e->one.draw ? 0 : iso_atlas_picture_mm(&e->one.scene) / (double)width;
    iso_status status = iso_atlas_show(&e->one, (iso_atlas_which)column, e->one.scene.field ? &e->volume : NULL, &drawn,
                                       &unused, err);
    if (status == ISO_OK && drawn.width == width) {
        *image = drawn;
        return ISO_OK;
    }
    /* Cases that are not rendered have pictures of one size: enlarges their pixels. */
    TRY(status, iso_image_create(image, width, height, err));
    for (size_t i = 0; i < width * height && status == ISO_OK; ++i)
        for (size_t c = 0; c < 4; ++c)
            image->rgba[4 * i + c] =
                drawn.rgba[4 * (i / width * drawn.height / height * drawn.width + i % width * drawn.width / width) + c];
    iso_image_destroy(&drawn);
    return status;
}

static iso_status find(const char *id, const iso_atlas_case **found, iso_error *err)
{
    char names[1024] = "";
    size_t used = 0;
    *found = id ? iso_atlas_find(id) : &iso_atlas_cases[0];
    for (size_t i = 0; i < iso_atlas_case_count && used < sizeof names; ++i)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", iso_atlas_cases[i].id);
    return *found ? ISO_OK : iso_fail(err, ISO_E_USAGE, "--case: the atlas has no \"%s\"; it has %s", id, names);
}

/* True if some pictures are under another transfer function than the scene's. */
static bool is_adapted(const iso_atlas_case *c)
{
    for (int i = 0; i < ISO_ATLAS_WAYS; ++i)
        if (c->ways[i].render && strstr(c->ways[i].render, "--adapt"))
            return true;
    return false;
}

static iso_status draw_failure(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    OWNED(entry) e = {0};
    ENDED_BY(iso_atlas_clear) iso_atlas_result r = {0};
    const iso_atlas_case *found;
    iso_figure_columns c = {.job = job,
                            .count = ISO_ATLAS_WAYS,
                            .titles = {"right", "failure", "what helps"},
                            .aspect = 1,
                            .compared = true,
                            .render = render,
                            .user = &e};
    NEED(find(job->atlas_case, &found, err));
    e.one = *found;
    NEED(iso_atlas_run(found, &r, err)); /* the figures that the atlas checks are for its own size */
    if (found->scene.field)
        NEED(iso_atlas_volume(&found->scene, &e.volume, err));
    if (found->scene.field && !found->draw)
        NEED(iso_atlas_tf(&found->scene, &e.volume.geometry, &e.tf, err));
    /* the atlas' own unit, a micrometer, shows nothing */
    e.tf.unit_mm = iso_geometry_mean_spacing_mm(&e.volume.geometry);
    fprintf(iso_page_caption(page),
            "%s. %s %s: %.3g, with the remedy %.3g. Remedy: %s. Correct: %s; failure: %s; "
            "remedy: %s",
            found->title, found->cause, iso_atlas_measure(found), r.values[ISO_ATLAS_FAILURE],
            r.values[ISO_ATLAS_FALLBACK], found->advice, found->ways[ISO_ATLAS_RIGHT].what,
            found->ways[ISO_ATLAS_FAILURE].what, found->ways[ISO_ATLAS_FALLBACK].what);
    c.tf = (iso_figure_tf_foot){.tf = &e.tf, .range = {0, 1}, .of_level0 = is_adapted(found)};
    return iso_figure_draw_columns(&c, page, err);
}

const iso_figure_info iso_figure_failure = {
    .name = "failure",
    .summary = "one entry of `isoshade atlas`: correct picture, failure, remedy",
    .takes = ISO_FIGURE_OF_NOTHING | ISO_FIGURE_HAS_CASE | ISO_FIGURE_HAS_INSET,
    .draw = draw_failure,
};
