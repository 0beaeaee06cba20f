/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lab/rivals/palette_mesh.h"
#include "lab/rivals/palettes.h"

/* [bremer-2001] Figure 4 and section 3: random moves of a random vertex, reassignment of the directions in the changed
 * patch to its triangles, Metropolis acceptance.
 *
 * A direction belongs to the triangle that contains it (the paper's second way, section 3.1), since this can be updated
 * locally. The finished palette is used by the nearest entry (the paper's first way), which is never worse.
 *
 * Each triangle has two lists of its directions, as in the paper's Figure 7: the old one, and the new one that is built
 * during a trial move. The lists are chains through two arrays of links, one link per direction each. */

#define END UINT32_MAX

typedef struct face {
    double normal[3];  /* of the triangle's plane; the palette's entry */
    double edge[3][3]; /* normals of the planes through the center and each edge, inwards */
    double cost;       /* sum of w (1 - cos) */
    uint32_t head;
} face;

typedef struct annealer {
    const iso_direction_set *set;
    mesh mesh;
    face *old_face, *new_face;     /* one per triangle */
    uint32_t *old_next, *new_next; /* one per direction */
    double cost;
} annealer;

static void put3(double out[3], iso_vec3 v)
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static void shape_face(const annealer *a, uint32_t t, face *f)
{
    const uint32_t *v = a->mesh.triangle[t].v;
    iso_vec3 p = a->mesh.position[v[0]], q = a->mesh.position[v[1]], r = a->mesh.position[v[2]];
    put3(f->normal, iso_normalize(iso_cross(iso_sub(q, p), iso_sub(r, p))));
    put3(f->edge[0], iso_cross(q, r));
    put3(f->edge[1], iso_cross(r, p));
    put3(f->edge[2], iso_cross(p, q));
    f->cost = 0;
    f->head = END;
}

static double dot3(const double a[3], const float b[3])
{
    return a[0] * (double)b[0] + a[1] * (double)b[1] + a[2] * (double)b[2];
}

/* Returns the depth of u inside the triangle's cone: positive inside. */
static double depth_in(const face *f, const float u[3])
{
    return fmin(fmin(dot3(f->edge[0], u), dot3(f->edge[1], u)), dot3(f->edge[2], u));
}

/* Assigns direction i to the triangle in which it lies deepest (rounding may leave it slightly outside of all). */
static void assign_to(annealer *a, uint32_t i, const uint32_t *triangles, size_t count, face *faces, uint32_t *next)
{
    const float *u = a->set->xyz + 3 * (size_t)i;
    uint32_t best = triangles[0];
    double best_depth = -INFINITY;
    for (size_t j = 0; j < count && best_depth < 0; ++j) {
        double depth = depth_in(&faces[triangles[j]], u);
        if (depth > best_depth)
            best_depth = depth, best = triangles[j];
    }
    face *f = &faces[best];
    f->cost += a->set->weight[i] * (1 - (double)a->set->length[i] * dot3(f->normal, u));
    next[i] = f->head;
    f->head = i;
}

/* Builds the new lists and costs of the patch; returns the change of the cost. */
static double reassign(annealer *a)
{
    const mesh *m = &a->mesh;
    double before = 0, after = 0;
    for (size_t j = 0; j < m->patch_count; ++j)
        shape_face(a, m->patch[j], &a->new_face[m->patch[j]]);
    for (size_t j = 0; j < m->patch_count; ++j) {
        const face *f = &a->old_face[m->patch[j]];
        before += f->cost;
        for (uint32_t i = f->head; i != END; i = a->old_next[i])
            assign_to(a, i, m->patch, m->patch_count, a->new_face, a->new_next);
    }
    for (size_t j = 0; j < m->patch_count; ++j)
        after += a->new_face[m->patch[j]].cost;
    return after - before;
}

/* Accepts the move: the new lists become the old ones. */
static void keep(annealer *a, double change)
{
    mesh *m = &a->mesh;
    for (size_t j = 0; j < m->patch_count; ++j) {
        uint32_t t = m->patch[j];
        a->old_face[t] = a->new_face[t];
        for (uint32_t i = a->new_face[t].head; i != END; i = a->new_next[i])
            a->old_next[i] = a->new_next[i];
    }
    a->cost += change;
    iso_mesh_keep(m);
}

static bool random_move(annealer *a, const iso_anneal_options *opt, iso_random *random)
{
    const double radians = acos(-1) / 180;
    uint32_t vertex = (uint32_t)iso_random_below(random, a->mesh.vertex_count);
    double angle = opt->move_deg[0] + (opt->move_deg[1] - opt->move_deg[0]) * iso_random_unit(random);
    return iso_mesh_move(&a->mesh, vertex, angle * radians, random);
}

/* Returns the temperature at which a move that costs the mean change is accepted with START_PROB (section 4). The mean
 * is of absolute changes: from a random start signed ones nearly cancel, and their mean can be negative. */
static double start_temperature(annealer *a, const iso_anneal_options *opt, iso_random *random)
{
    double sum = 0;
    size_t tried = 0;
    for (int i = 0; i < 400; ++i) {
        if (!random_move(a, opt, random))
            continue;
        sum += fabs(reassign(a));
        ++tried;
        iso_mesh_revert(&a->mesh);
    }
    return tried ? -sum / (double)tried / log(opt->start_prob) : 0;
}

static iso_status annealer_create(annealer *a, const iso_direction_set *set, size_t triangles, iso_random *random,
                                  iso_error *err)
{
    *a = (annealer){.set = set};
    NEED(iso_mesh_create_random(&a->mesh, triangles, random, err));
    a->old_face = calloc(triangles, sizeof *a->old_face);
    a->new_face = calloc(triangles, sizeof *a->new_face);
    a->old_next = malloc((set->count + 1) * sizeof *a->old_next);
    a->new_next = malloc((set->count + 1) * sizeof *a->new_next);
    uint32_t *all = malloc(triangles * sizeof *all);
    if (!a->old_face || !a->new_face || !a->old_next || !a->new_next || !all) {
        free(all);
        return iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu directions", set->count);
    }
    for (uint32_t t = 0; t < triangles; ++t) {
        all[t] = t;
        shape_face(a, t, &a->old_face[t]);
    }
    for (uint32_t i = 0; i < set->count; ++i)
        assign_to(a, i, all, triangles, a->old_face, a->old_next);
    free(all);
    for (uint32_t t = 0; t < triangles; ++t)
        a->cost += a->old_face[t].cost;
    return ISO_OK;
}

static void annealer_destroy(annealer *a)
{
    iso_mesh_destroy(&a->mesh);
    free(a->old_face);
    free(a->new_face);
    free(a->old_next);
    free(a->new_next);
}

/* Runs Figure 4 of the paper. */
static void anneal(annealer *a, const iso_anneal_options *opt, iso_random *random, iso_tessellation *stats)
{
    double temperature = start_temperature(a, opt, random);
    stats->start_temperature = temperature;
    for (size_t cycle = 0; cycle < opt->cycles; ++cycle) {
        for (size_t step = 0; step < opt->steps; ++step) {
            ++stats->moves;
            if (!random_move(a, opt, random)) {
                ++stats->refused;
                continue;
            }
            double change = reassign(a);
            if (change <= 0 || iso_random_unit(random) <= exp(-change / temperature)) {
                ++stats->accepted;
                keep(a, change);
            } else {
                iso_mesh_revert(&a->mesh);
            }
        }
        temperature *= opt->temp_fac;
    }
    stats->end_temperature = temperature;
}

void iso_tessellation_destroy(iso_tessellation *t)
{
    if (!t)
        return;
    free(t->vertices);
    free(t->faces);
    *t = (iso_tessellation){0};
}

static iso_status export_mesh(const mesh *m, iso_tessellation *t, iso_error *err)
{
    t->vertex_count = m->vertex_count;
    t->face_count = m->triangle_count;
    t->vertices = malloc(3 * m->vertex_count * sizeof *t->vertices);
    t->faces = malloc(m->triangle_count * sizeof *t->faces);
    if (!t->vertices || !t->faces) {
        iso_tessellation_destroy(t);
        return iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu triangles", m->triangle_count);
    }
    for (size_t i = 0; i < m->vertex_count; ++i)
        put3(t->vertices + 3 * i, m->position[i]);
    for (size_t i = 0; i < m->triangle_count; ++i)
        memcpy(t->faces[i], m->triangle[i].v, sizeof t->faces[i]);
    return ISO_OK;
}

iso_status iso_rival_palette_anneal(const iso_direction_set *set, const iso_rival_options *opt, iso_palette *palette,
                                    iso_tessellation *tessellation, iso_error *err)
{
    *palette = (iso_palette){0};
    if (tessellation)
        *tessellation = (iso_tessellation){0};
    iso_rival_options checked = *opt;
    checked.method = ISO_RIVAL_ANNEAL;
    iso_status status = iso_rival_palette_check(&checked, err);
    if (status == ISO_OK && set->count >= END)
        status = iso_fail(err, ISO_E_RANGE, "palette: %zu bundles of directions, at most %u", set->count, END - 1);
    if (status != ISO_OK)
        return status;
    iso_random random = {opt->fit.seed};
    iso_tessellation own = {0};
    OWNED(annealer) a = {0};
    status = annealer_create(&a, set, opt->fit.directions, &random, err);
    if (status == ISO_OK) {
        anneal(&a, &opt->anneal, &random, &own);
        own.assigned_norm1 = a.cost;
        status = iso_palette_create(palette, opt->fit.directions, err);
    }
    if (status == ISO_OK && tessellation)
        status = export_mesh(&a.mesh, &own, err);
    for (size_t i = 0; status == ISO_OK && i < opt->fit.directions; ++i)
        for (size_t c = 0; c < 3; ++c)
            palette->xyz[3 * (i + 1) + c] = (float)a.old_face[i].normal[c];
    if (status == ISO_OK && tessellation)
        *tessellation = own;
    if (status != ISO_OK)
        iso_palette_destroy(palette);
    return status;
}
