/* SPDX-License-Identifier: MIT */
#include "lab/rivals/palette_tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/linalg.h"

static void put(float *xyz, size_t at, iso_vec3 v)
{
    iso_vec3 n = iso_normalize(v);
    xyz[3 * at] = (float)n.x;
    xyz[3 * at + 1] = (float)n.y;
    xyz[3 * at + 2] = (float)n.z;
}

/* ---- [van-gelder-1996]: icosahedron joined with its dual, triangles cut in four ---- */

size_t iso_subdivision_faces(int level)
{
    return (size_t)60 << (2 * level);
}

static size_t subdivision_vertices(int level)
{
    return ((size_t)30 << (2 * level)) + 2;
}

typedef struct mesh {
    size_t vertex_count, face_count;
    iso_vec3 *vertices;
    uint32_t (*faces)[3];
} mesh;

/* Adds the icosahedron's 12 vertices, and one of the dodecahedron's 20 over each of its faces. */
static void start_vertices(mesh *m)
{
    const double g = 0.5 * (1 + sqrt(5));
    m->vertex_count = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (int sign = 0; sign < 4; ++sign) {
            double p[3] = {0, 0, 0};
            p[(axis + 1) % 3] = sign & 1 ? -1 : 1;
            p[(axis + 2) % 3] = sign & 2 ? -g : g;
            m->vertices[m->vertex_count++] = iso_normalize(iso_v3(p[0], p[1], p[2]));
        }
    for (int a = 0; a < 12; ++a)
        for (int b = a + 1; b < 12; ++b)
            for (int c = b + 1; c < 12; ++c) {
                iso_vec3 p = m->vertices[a], q = m->vertices[b], r = m->vertices[c];
                /* Neighbors in the icosahedron have a cosine of 1/sqrt(5) = .447, other pairs at most -.447. */
                if (iso_dot(p, q) > 0 && iso_dot(q, r) > 0 && iso_dot(r, p) > 0)
                    m->vertices[m->vertex_count++] = iso_normalize(iso_add(iso_add(p, q), r));
            }
}

/* Adds a triangle for each edge of the dodecahedron and the icosahedron's vertex on either side: 60 triangles. */
static void start_mesh(mesh *m)
{
    start_vertices(m);
    m->face_count = 0;
    for (uint32_t a = 12; a < 32; ++a)
        for (uint32_t b = a + 1; b < 32; ++b)
            for (uint32_t c = 0; c < 12; ++c) {
                iso_vec3 p = m->vertices[a], q = m->vertices[b], r = m->vertices[c];
                /* Cosines of neighbors: .745 along the dodecahedron's edges, .795 to the icosahedron's vertices; other
                 * pairs at most .333. */
                if (iso_dot(p, q) < 0.6 || iso_dot(q, r) < 0.6 || iso_dot(r, p) < 0.6)
                    continue;
                bool outward = iso_dot(iso_cross(p, q), r) > 0;
                uint32_t *face = m->faces[m->face_count++];
                face[0] = outward ? a : b;
                face[1] = outward ? b : a;
                face[2] = c;
            }
}

/* Returns the midpoint of an edge, found by its ends; each is created once, by the first of two triangles. */
static uint32_t midpoint(mesh *m, uint32_t (*edges)[3], size_t mask, uint32_t a, uint32_t b)
{
    uint32_t lo = a < b ? a : b, hi = a < b ? b : a;
    size_t slot = (lo * 2654435761u ^ hi * 40503u) & mask;
    while (edges[slot][2]) {
        if (edges[slot][0] == lo && edges[slot][1] == hi)
            return edges[slot][2] - 1;
        slot = (slot + 1) & mask;
    }
    m->vertices[m->vertex_count] = iso_normalize(iso_add(m->vertices[a], m->vertices[b]));
    edges[slot][0] = lo;
    edges[slot][1] = hi;
    edges[slot][2] = (uint32_t)++m->vertex_count;
    return edges[slot][2] - 1;
}

static void refine_mesh(mesh *m, uint32_t (*edges)[3], size_t mask)
{
    memset(edges, 0, (mask + 1) * sizeof *edges);
    size_t old = m->face_count;
    for (size_t f = 0; f < old; ++f) {
        uint32_t a = m->faces[f][0], b = m->faces[f][1], c = m->faces[f][2];
        uint32_t ab = midpoint(m, edges, mask, a, b), bc = midpoint(m, edges, mask, b, c),
                 ca = midpoint(m, edges, mask, c, a);
        const uint32_t parts[4][3] = {{ab, bc, ca}, {a, ab, ca}, {b, bc, ab}, {c, ca, bc}};
        memcpy(m->faces[f], parts[0], sizeof parts[0]);
        memcpy(m->faces[m->face_count], parts[1], 3 * sizeof parts[1]);
        m->face_count += 3;
    }
}

iso_status iso_palette_subdivide(int level, float *xyz, iso_error *err)
{
    size_t face_count = iso_subdivision_faces(level), mask = 127;
    while (mask + 1 < 2 * face_count)
        mask = 2 * mask + 1;
    mesh m = {.vertices = malloc(subdivision_vertices(level) * sizeof *m.vertices),
              .faces = malloc(face_count * sizeof *m.faces)};
    uint32_t(*edges)[3] = malloc((mask + 1) * sizeof *edges);
    iso_status status = ISO_OK;
    if (!m.vertices || !m.faces || !edges) {
        status = iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu triangles", face_count);
    } else {
        start_mesh(&m);
        for (int i = 0; i < level; ++i)
            refine_mesh(&m, edges, mask);
        for (size_t i = 0; i < m.face_count; ++i) {
            iso_vec3 a = m.vertices[m.faces[i][0]], b = m.vertices[m.faces[i][1]], c = m.vertices[m.faces[i][2]];
            put(xyz, i, iso_cross(iso_sub(b, a), iso_sub(c, a)));
        }
    }
    free(m.vertices);
    free(m.faces);
    free(edges);
    return status;
}
