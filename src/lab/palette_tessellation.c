/* SPDX-License-Identifier: MIT */
/* palette_tessellation.c - [bremer-2001] Figure 9: the front of an annealed tessellation over the set's directions. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/linalg.h"
#include "lab/palette.h"

typedef struct view {
    iso_vec3 right, up, toward;
} view;

/* Returns a view from the front right and above, as in the scenes. */
static view front_view(void)
{
    view v;
    v.toward = iso_normalize(iso_v3(0.6, -1.0, 0.45));
    v.right = iso_normalize(iso_cross(iso_v3(0, 0, 1), v.toward));
    v.up = iso_cross(v.toward, v.right);
    return v;
}

static iso_vec3 vertex(const iso_tessellation *t, uint32_t i)
{
    return iso_v3(t->vertices[3 * i], t->vertices[3 * i + 1], t->vertices[3 * i + 2]);
}

static void svg_point(FILE *file, const char *format, const view *v, iso_vec3 p)
{
    fprintf(file, format, 256 + 240 * iso_dot(p, v->right), 256 - 240 * iso_dot(p, v->up));
}

static void svg_write(FILE *file, const iso_tessellation *t, const iso_direction_set *set, const view *v)
{
    fputs("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 512 512\" width=\"512\" height=\"512\">\n"
          "<rect width=\"512\" height=\"512\" fill=\"white\"/>\n"
          "<path fill=\"none\" stroke=\"#c33\" stroke-width=\"1.6\" stroke-linecap=\"round\" d=\"\n",
          file);
    for (size_t i = 0; i < set->count; ++i) {
        iso_vec3 d = iso_v3((double)set->xyz[3 * i], (double)set->xyz[3 * i + 1], (double)set->xyz[3 * i + 2]);
        if (iso_dot(d, v->toward) > 0)
            svg_point(file, "M%.1f %.1fh0\n", v, d);
    }
    fputs("\"/>\n<path fill=\"none\" stroke=\"black\" stroke-width=\".8\" d=\"\n", file);
    for (size_t f = 0; f < t->face_count; ++f)
        for (int e = 0; e < 3; ++e) {
            uint32_t i = t->faces[f][e], j = t->faces[f][(e + 1) % 3];
            iso_vec3 a = vertex(t, i), b = vertex(t, j);
            /* Each edge once, and only if its middle faces the viewer. */
            if (i > j || iso_dot(iso_add(a, b), v->toward) <= 0)
                continue;
            svg_point(file, "M%.1f %.1f", v, a);
            svg_point(file, "L%.1f %.1f\n", v, b);
        }
    fputs("\"/>\n</svg>\n", file);
}

static iso_status save(const iso_tessellation *t, const iso_direction_set *set, const char *path, iso_error *err)
{
    const view v = front_view();
    FREED char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (memory)
        svg_write(memory, t, set, &v);
    bool good = memory && fclose(memory) == 0;
    return good ? iso_file_write(path, text, size, err)
                : iso_fail(err, ISO_E_MEMORY, "%s: no memory for its text", path);
}

iso_status iso_palette_bench_tessellation(const palette_bench *b, iso_error *err)
{
    enum { POINTS = 5000 };
    iso_rival_options opt = iso_rival_defaults();
    OWNED(iso_direction_set) set = {0};
    OWNED(iso_palette) palette = {0};
    OWNED(iso_tessellation) tessellation = {0};
    FREED float *vectors = malloc(3 * POINTS * sizeof *vectors);
    opt.fit.directions = (size_t)b->entries;
    opt.anneal.cycles = (size_t)b->cycles;
    opt.anneal.steps = (size_t)b->steps;
    if (vectors)
        iso_ellipsoid_gradients(vectors, POINTS, false, 1);
    NEED(vectors ? iso_direction_set_create(&set, vectors, NULL, POINTS, err)
                 : iso_fail(err, ISO_E_MEMORY, "no memory for %d gradients", POINTS));
    NEED(iso_rival_palette_anneal(&set, &opt, &palette, &tessellation, err));
    return save(&tessellation, &set, b->tessellation, err);
}
