/* SPDX-License-Identifier: MIT */
/* The levels of a pyramid as slices through the middle; each voxel is a square. */
#include <math.h>

#include "figure/columns.h"
#include "figure/kinds.h"
#include "figure/picture.h"
#include "tf/color_space.h"

enum { USUAL_LEVELS = 4 };

/* Returns the value at x, y, as parts of level 0's extent: the same place in all levels. */
static float value_at(const iso_level *l, const iso_geometry *level0, size_t level, double u, double v)
{
    const double scale = ldexp(1, (int)level);
    const size_t *n = l->geometry.size;
    const double index[3] = {u * (double)level0->size[0] / scale, v * (double)level0->size[1] / scale,
                             0.5 * (double)level0->size[2] / scale};
    size_t i[3];
    for (int a = 0; a < 3; ++a)
        i[a] = (size_t)fmin(fmax(index[a], 0), (double)n[a] - 1);
    return l->scalar[i[0] + n[0] * (i[1] + n[1] * i[2])];
}

static iso_status render(void *user, size_t column, size_t width, size_t height, iso_image *image, double *mm_per_pixel,
                         iso_error *err)
{
    const iso_figure_subject *s = user;
    const iso_level *l = &s->pyramid.levels[column], *level0 = &s->pyramid.levels[0];
    const iso_status status = iso_image_create(image, width, height, err);
    for (size_t i = 0; i < width * height && status == ISO_OK; ++i) {
        unsigned char rgb[3];
        const double u = ((double)(i % width) + 0.5) / (double)width,
                     v = 1 - ((double)(i / width) + 0.5) / (double)height; /* y upwards */
        const double value = (double)value_at(l, &level0->geometry, column, u, v);
        iso_colormap_lookup(s->job->map, (value - level0->min) / fmax(level0->max - level0->min, 1e-300), rgb);
        for (size_t c = 0; c < 4; ++c)
            image->rgba[4 * i + c] = c < 3 ? (float)iso_srgb_to_linear(rgb[c] / 255.0) : 1;
    }
    *mm_per_pixel = iso_norm(iso_column(level0->geometry.index_to_world, 0)) * (double)level0->geometry.size[0] /
                    (double)width;
    return status;
}

static iso_status draw_slices(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    char value[32] = "value";
    iso_figure_subject s = {0};
    iso_figure_columns c = {.job = job,
                            .count = job->levels ? (size_t)job->levels : USUAL_LEVELS,
                            .color_text = value,
                            .render = render,
                            .user = &s};
    const iso_status status = iso_figure_subject_load(&s, job, c.count, NULL, err);
    if (status != ISO_OK) {
        iso_figure_subject_end(&s);
        return status;
    }
    iso_figure_value_text(job, value, sizeof value);
    const iso_level *level0 = &s.pyramid.levels[0];
    const iso_geometry *g = &level0->geometry;
    for (size_t i = 0; i < c.count; ++i)
        snprintf(c.titles[i], sizeof c.titles[i], "level %zu", i);
    c.color_range[0] = level0->min, c.color_range[1] = level0->max;
    c.aspect = iso_norm(iso_column(g->index_to_world, 0)) * (double)g->size[0] /
               (iso_norm(iso_column(g->index_to_world, 1)) * (double)g->size[1]);
    fputs("Slices through the middle of the levels", iso_page_caption(page));
    iso_figure_put_subject(&s, iso_page_caption(page));
    fputs(", across the volume's third axis, with the stored voxels", iso_page_caption(page));
    const iso_status drawn = iso_figure_draw_columns(&c, page, err);
    iso_figure_subject_end(&s);
    return drawn;
}

const iso_figure_info iso_figure_slices = {
    .name = "slices",
    .summary = "the levels of a pyramid as slices through the middle, voxel by voxel",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LEVELS | ISO_FIGURE_HAS_INSET,
    .draw = draw_slices,
};
