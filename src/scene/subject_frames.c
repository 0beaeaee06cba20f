/* SPDX-License-Identifier: MIT */
#include "scene/subject_frames.h"

#include <stdio.h>

#include "volume/frames_all.h"

static iso_status load(const iso_subject_frames *f, size_t frame, iso_pyramid *p, iso_error *err)
{
    char number[24];
    iso_volume_input one = *f->input;
    snprintf(number, sizeof number, "%zu", frame);
    one.frame = number;
    one.no_labels = one.no_labels || !f->are_labels; /* one decision for all frames */
    one.labels = f->are_labels;
    NEED(iso_subject_load_pyramid(f->path, &one, &f->build, f->progress, p, err));
    /* Voxels without data get a value below the range of all frames (iso_level_stand_in), where their transfer function
     * shows nothing. */
    for (size_t k = 0; k < p->level_count && p->levels[0].geometry.has_no_data; ++k) {
        p->levels[k].min = f->build.value_range[0];
        p->levels[k].max = f->build.value_range[1];
    }
    return ISO_OK;
}

/* True if the grids agree up to the last decimals, which may differ within a series. */
static bool is_same_grid(const iso_geometry *a, const iso_geometry *b)
{
    const double far = 1e-3 * iso_geometry_min_spacing_mm(a);
    bool same = true;
    for (int i = 0; i < 3; ++i)
        same = same && a->size[i] == b->size[i];
    for (int corner = 0; same && corner < 8; ++corner) {
        const iso_vec3 at = iso_v3((corner & 1) * (double)a->size[0], (corner >> 1 & 1) * (double)a->size[1],
                                   (corner >> 2) * (double)a->size[2]);
        const iso_vec3 off = iso_sub(iso_geometry_to_world(a, at), iso_geometry_to_world(b, at));
        same = iso_norm(off) <= far;
    }
    return same;
}

/* Checks the frames' grids by their headers, before anything is written. */
static iso_status check_grids(const iso_subject_frames *f, iso_error *err)
{
    iso_geometry first = {.size = {0}};
    for (size_t k = 0; k < f->count; ++k) {
        char number[24];
        iso_volume_source *source;
        iso_volume_input one = *f->input;
        snprintf(number, sizeof number, "%zu", k);
        one.frame = number;
        NEED(iso_volume_input_open(f->path, &one, &source, err));
        const iso_geometry own = iso_source_volume(source)->geometry;
        iso_source_close(source);
        if (k == 0)
            first = own;
        else if (!is_same_grid(&first, &own))
            return iso_fail(err, ISO_E_RANGE,
                            "%s: frame %zu has another grid than frame 0; one scene needs equal grids", f->path, k);
    }
    return ISO_OK;
}

iso_status iso_subject_frames_create(const char *path, const iso_volume_input *input, const iso_pyramid_options *build,
                                     const iso_subject_look *look, const iso_progress *progress, iso_subject_frames *f,
                                     iso_error *err)
{
    iso_subject_look of_all = look ? *look : (iso_subject_look){0};
    of_all.frames_box = true;
    iso_frames_facts facts;
    OWNED(iso_pyramid) p = {0};
    size_t labels = 0;
    *f = (iso_subject_frames){.path = path, .input = input, .progress = progress, .build = *build};
    if (iso_pyramid_is_one(path))
        return iso_fail(err, ISO_E_USAGE, "%s: is a pyramid, which has one frame; remove --frames all", path);
    if (input->frame)
        return iso_fail(err, ISO_E_USAGE, "--frames all excludes --frame; remove one");
    NEED(iso_frames_measure(path, input, &facts, err));
    NEED(iso_frames_labels(path, input, &labels, err));
    f->count = facts.count;
    f->widest = facts.widest;
    f->are_labels = labels > 0;
    f->build.value_range[0] = facts.range[0];
    f->build.value_range[1] = facts.range[1];
    iso_status status = check_grids(f, err);
    TRY(status, load(f, f->widest, &p, err));
    if (status == ISO_OK)
        f->geometry = p.levels[0].geometry;
    f->geometry.has_no_data = f->geometry.has_no_data || facts.has_no_data;
    if (status == ISO_OK && look) {
        status = iso_subject_make_scene(&of_all, &p, &f->scene, err);
        f->has_scene = status == ISO_OK;
    }
    return status;
}

iso_status iso_subject_frames_load(const iso_subject_frames *f, size_t frame, iso_pyramid *p, iso_error *err)
{
    return load(f, frame, p, err);
}

iso_status iso_subject_frames_view(const iso_subject_frames *f, const iso_pyramid *p, iso_view *view, iso_error *err)
{
    return iso_scene_resolve(&f->scene, &f->geometry, iso_pyramid_lo(p), iso_pyramid_hi(p), view, err);
}

void iso_subject_frames_destroy(iso_subject_frames *f)
{
    if (f->has_scene)
        iso_scene_destroy(&f->scene);
    *f = (iso_subject_frames){0};
}
