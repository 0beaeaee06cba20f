/* SPDX-License-Identifier: MIT */
#include "scene/subject_narrow.h"

#include "pyramid/narrow.h"
#include "volume/input.h"

static iso_status see(const iso_subject_look *look, const iso_pyramid *p, iso_subject_sight *sight, iso_error *err)
{
    if (!look)
        return ISO_OK;
    NEED(iso_subject_make_view(look, p, &sight->view, err));
    sight->visible = iso_visible_measure(&p->levels[0], &sight->view, NULL, look->threads);
    return ISO_OK;
}

/* Makes the view with a pyramid of one level whose scalars are the volume's samples. */
static iso_status see_volume(const iso_subject_look *look, const iso_volume *v, const char *path,
                             const iso_pyramid_options *opt, iso_subject_sight *sight, iso_error *err)
{
    if (!look)
        return ISO_OK;
    const iso_volume_stats stats = iso_volume_measure(v);
    iso_level level = {.geometry = v->geometry,
                       .stored_type = v->type,
                       .samples = v,
                       .min = stats.min,
                       .max = stats.max};
    const iso_pyramid p = {.options = *opt,
                           .source = (char *)path,
                           .unit = iso_pyramid_unit_of(&v->notes),
                           .level_count = 1,
                           .levels = &level};
    return see(look, &p, sight, err);
}

static iso_status load_whole(iso_volume *v, const char *path, const iso_pyramid_options *opt,
                             const iso_subject_look *look, const iso_progress *progress, iso_pyramid *p,
                             iso_subject_sight *sight, iso_error *err)
{
    iso_pyramid_options own = *opt;
    if (v->notes.label_count)
        own.scalar_filter = ISO_SCALAR_MAJORITY;
    const iso_status status = iso_pyramid_build(v, path, &own, p, progress, err);
    iso_volume_destroy(v);
    return status == ISO_OK ? see(look, p, sight, err) : status;
}

iso_status iso_subject_load_narrow(const char *path, const iso_volume_input *input, const iso_pyramid_options *opt,
                                   const iso_subject_look *look, const iso_progress *progress, iso_pyramid *p,
                                   iso_volume *v, iso_subject_sight *sight, iso_error *err)
{
    *p = (iso_pyramid){0};
    *v = (iso_volume){0};
    *sight = (iso_subject_sight){0};
    if (iso_pyramid_is_one(path)) {
        const iso_status status = iso_pyramid_load(path, p, err);
        return status == ISO_OK ? see(look, p, sight, err) : status;
    }
    NEED(iso_volume_input_load(path, input, v, err));
    if (v->notes.label_count || iso_type_bytes(v->type) > sizeof(float))
        return load_whole(v, path, opt, look, progress, p, sight, err);
    iso_status status = see_volume(look, v, path, opt, sight, err);
    return status == ISO_OK ? iso_pyramid_build_narrow(v, path, opt, p, progress, err) : status;
}
