/* SPDX-License-Identifier: MIT */
#include "render/cpu/adjoint.h"

#include <stdlib.h>

#include "render/cpu/cast_scene.h"
#include "render/cpu/cast_width.h"

static iso_cast_adjoint *adjoint_of(iso_cpu_width width)
{
    const iso_cpu_width widest = iso_cpu_widest();
    switch (width ? width : widest) {
    case ISO_CPU_ONE: return iso_cast_adjoint_1;
    case ISO_CPU_BASELINE: return iso_cast_adjoint_4;
#ifdef ISO_CAST_HAS_X86
    case ISO_CPU_AVX2: return widest >= ISO_CPU_AVX2 ? iso_cast_adjoint_8 : NULL;
    case ISO_CPU_AVX512: return widest >= ISO_CPU_AVX512 ? iso_cast_adjoint_16 : NULL;
#endif
    default: return NULL;
    }
}

/* A field as the kernels take it. */
typedef struct prepared {
    iso_cast cast;
    iso_cast_field field;
    iso_cast_adjoint *run;
    float *entries; /* owned */
} prepared;

static iso_status prepare(const iso_adjoint_field *f, const iso_view *view, iso_cpu_width width, prepared *p,
                          iso_error *err)
{
    const iso_geometry *g = f->geometry;
    size_t bytes;
    *p = (prepared){.run = adjoint_of(width), .field = {.voxels = f->voxels, .octaves = f->octaves}};
    if (iso_geometry_voxel_count(g) > INT32_MAX)
        return iso_fail(err, ISO_E_RANGE, "adjoint: %zu voxels, at most %d", iso_geometry_voxel_count(g), INT32_MAX);
    if (!p->run)
        return iso_fail(err, ISO_E_RANGE, "adjoint: this machine does not cast %d rays at a time", (int)width);
    int32_t stride = 1;
    for (int a = 0; a < 3; ++a) {
        p->field.size[a] = (int32_t)g->size[a];
        p->field.stride[a] = stride;
        stride *= (int32_t)g->size[a];
    }
    iso_cast_set_camera(&p->cast, g, view, view->step_voxels * iso_geometry_min_spacing_mm(g));
    iso_cast_set_light(&p->cast, view);
    p->entries = iso_cast_set_tf(&p->cast, view, 0, 1, &bytes);
    return p->entries ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "adjoint: no memory for %zu entries", view->tf.count);
}

iso_status iso_adjoint_draw(const iso_adjoint_field *field, const iso_view *view, const iso_adjoint_tile *tile,
                            float *rgba, iso_error *err)
{
    prepared p;
    const iso_status status = prepare(field, view, tile->width, &p, err);
    if (status == ISO_OK)
        p.run(&p.cast, &p.field, &(iso_cast_tile_at){tile->x, tile->y, tile->seed, rgba, NULL}, NULL);
    free(p.entries);
    return status;
}

/* Adds derivatives by depth and colors of segments to those by the table's colors and extinction. */
static void add_table(const iso_view *view, double step_mm, const float *from, double *to)
{
    for (size_t i = 0; i < view->tf.count; ++i) {
        for (size_t k = 0; k < 3; ++k)
            to[4 * i + k] += (double)from[4 * i + k + 1];
        to[4 * i + 3] += step_mm * (double)from[4 * i];
    }
}

iso_status iso_adjoint_differentiate(const iso_adjoint_field *field, const iso_view *view, const iso_adjoint_tile *tile,
                                     const float *rgba, const float *by_pixel, const iso_adjoint_gradient *gradient,
                                     iso_error *err)
{
    prepared p;
    FREED float *table = gradient->table ? calloc(4 * view->tf.count, sizeof *table) : NULL;
    iso_status status = prepare(field, view, tile->width, &p, err);
    if (status == ISO_OK && gradient->table && !table)
        status = iso_fail(err, ISO_E_MEMORY, "adjoint: no memory for %zu entries", view->tf.count);
    const iso_cast_gradient g = {gradient->voxels, gradient->octaves, table};
    if (status == ISO_OK)
        p.run(&p.cast, &p.field,
              &(iso_cast_tile_at){tile->x, tile->y, tile->seed, (float *)(uintptr_t)rgba, by_pixel}, &g);
    if (status == ISO_OK && table)
        add_table(view, p.cast.step_mm, table, gradient->table);
    free(p.entries);
    return status;
}
