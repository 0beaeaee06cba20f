/* SPDX-License-Identifier: MIT */
#include "lab/rivals/palette_mesh.h"

#include <math.h>
#include <stdlib.h>

#define MARK_SAVED 1
#define MARK_PATCH 2
/* A move affects about ten triangles and a hundred edges to check; with more edges than this it is refused. */
#define EDGE_CAPACITY 4096
/* Least volume of a triangle seen from the center, and of a concave edge: well above the rounding error of a
 * determinant of unit vectors (1e-16), well below the volumes of real triangles (1e-4). */
#define LEAST_VOLUME 1e-12

static double volume(iso_vec3 a, iso_vec3 b, iso_vec3 c)
{
    return iso_dot(iso_cross(a, b), c);
}

static void save(mesh *m, uint32_t t, bool shape)
{
    if (!(m->mark[t] & MARK_SAVED)) {
        m->mark[t] |= MARK_SAVED;
        m->saved[m->saved_count++] = (mesh_saved){t, m->triangle[t]};
    }
    if (shape && !(m->mark[t] & MARK_PATCH)) {
        m->mark[t] |= MARK_PATCH;
        m->patch[m->patch_count++] = t;
    }
}

static int side_to(const mesh *m, uint32_t t, uint32_t neighbor)
{
    const uint32_t *n = m->triangle[t].n;
    return n[0] == neighbor ? 0 : n[1] == neighbor ? 1 : 2;
}

static int corner_of(const mesh *m, uint32_t t, uint32_t vertex)
{
    const uint32_t *v = m->triangle[t].v;
    return v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2;
}

static void push_edge(mesh *m, uint32_t t, int side)
{
    if (m->edge_count < EDGE_CAPACITY)
        m->edges[m->edge_count++] = 3 * t + (uint32_t)side;
    else
        m->too_many = true;
}

/* Swaps the edge of t opposite its corner `side`:
 *
 *     t = (p, a, b), o = (q, b, a)    becomes    t = (p, a, q), o = (q, b, p) */
static void swap_edge(mesh *m, uint32_t t, int side)
{
    uint32_t o = m->triangle[t].n[side];
    int i = side, j = side_to(m, o, t);
    save(m, t, true);
    save(m, o, true);
    mesh_triangle *x = &m->triangle[t], *y = &m->triangle[o];
    uint32_t p = x->v[i], a = x->v[(i + 1) % 3], b = x->v[(i + 2) % 3], q = y->v[j];
    uint32_t beyond_bp = x->n[(i + 1) % 3], beyond_pa = x->n[(i + 2) % 3];
    uint32_t beyond_aq = y->n[(j + 1) % 3], beyond_qb = y->n[(j + 2) % 3];
    save(m, beyond_bp, false);
    save(m, beyond_aq, false);
    m->triangle[beyond_bp].n[side_to(m, beyond_bp, t)] = o;
    m->triangle[beyond_aq].n[side_to(m, beyond_aq, o)] = t;
    *x = (mesh_triangle){{p, a, q}, {beyond_aq, o, beyond_pa}};
    *y = (mesh_triangle){{q, b, p}, {beyond_bp, t, beyond_qb}};
    m->triangle_of[p] = m->triangle_of[a] = m->triangle_of[q] = t;
    m->triangle_of[b] = o;
}

/* Returns the vertex across the edge opposite corner `side`. */
static uint32_t opposite(const mesh *m, uint32_t t, int side)
{
    uint32_t o = m->triangle[t].n[side];
    return m->triangle[o].v[side_to(m, o, t)];
}

/* True if the other triangle's far vertex lies above this one's plane. */
static bool is_concave(const mesh *m, uint32_t t, int side)
{
    const uint32_t *v = m->triangle[t].v;
    iso_vec3 a = m->position[v[0]], b = m->position[v[1]], c = m->position[v[2]], q = m->position[opposite(m, t, side)];
    return iso_dot(iso_cross(iso_sub(b, a), iso_sub(c, a)), iso_sub(q, a)) > LEAST_VOLUME;
}

/* True if both triangles after the swap would be positive seen from the center. */
static bool can_swap(const mesh *m, uint32_t t, int side)
{
    const uint32_t *v = m->triangle[t].v;
    iso_vec3 p = m->position[v[side]], a = m->position[v[(side + 1) % 3]], b = m->position[v[(side + 2) % 3]];
    iso_vec3 q = m->position[opposite(m, t, side)];
    return volume(p, a, q) > LEAST_VOLUME && volume(q, b, p) > LEAST_VOLUME;
}

/* Tests the listed edges; swaps concave ones and lists the four edges around each. */
static void make_convex(mesh *m)
{
    size_t swaps = 0;
    while (m->edge_count && !m->too_many) {
        uint32_t edge = m->edges[--m->edge_count], t = edge / 3;
        int side = (int)(edge % 3);
        if (!is_concave(m, t, side))
            continue;
        uint32_t o = m->triangle[t].n[side];
        if (!can_swap(m, t, side) || ++swaps > EDGE_CAPACITY) {
            m->too_many = true;
            break;
        }
        swap_edge(m, t, side);
        push_edge(m, t, 0);
        push_edge(m, t, 2);
        push_edge(m, o, 0);
        push_edge(m, o, 2);
    }
    m->edge_count = 0;
}

/* ---- moves ----------------------------------------------------------------------------- */

typedef struct path {
    iso_vec3 from, tangent;
    double angle;
} path;

static iso_vec3 path_at(const path *p, double angle)
{
    return iso_madd(iso_scale(p->from, cos(angle)), p->tangent, sin(angle));
}

static path random_path(iso_vec3 from, double angle, iso_random *random)
{
    double turn = 2 * acos(-1) * iso_random_unit(random);
    iso_vec3 other = fabs(from.x) < 0.6 ? iso_v3(1, 0, 0) : iso_v3(0, 1, 0);
    iso_vec3 e = iso_normalize(iso_cross(from, other)), f = iso_cross(from, e);
    return (path){from, iso_madd(iso_scale(e, cos(turn)), f, sin(turn)), angle};
}

/* Finds the first triangle around the vertex to degenerate on the path, at *angle. False: none does. */
static bool first_event(const mesh *m, uint32_t vertex, const path *p, double *angle, uint32_t *triangle)
{
    uint32_t start = m->triangle_of[vertex], t = start;
    bool found = false;
    *angle = p->angle;
    do {
        int i = corner_of(m, t, vertex);
        const uint32_t *v = m->triangle[t].v;
        iso_vec3 n = iso_cross(m->position[v[(i + 1) % 3]], m->position[v[(i + 2) % 3]]);
        double at_start = iso_dot(n, p->from), rate = iso_dot(n, p->tangent);
        /* volume(angle) = at_start cos + rate sin has one zero per half turn; a negative zero cannot be resolved. */
        if (at_start * cos(p->angle) + rate * sin(p->angle) <= LEAST_VOLUME) {
            double zero = atan2(at_start, -rate);
            if (!found || zero < *angle)
                *angle = zero, *triangle = t, found = true;
        }
        t = m->triangle[t].n[(i + 1) % 3];
    } while (t != start);
    return found;
}

static int degree(const mesh *m, uint32_t vertex)
{
    uint32_t start = m->triangle_of[vertex], t = start;
    int count = 0;
    do {
        ++count;
        t = m->triangle[t].n[(corner_of(m, t, vertex) + 1) % 3];
    } while (t != start);
    return count;
}

/* Swaps the edge that blocks triangle t, degenerate at p. False if an end of the edge would keep only two edges. */
static bool resolve(mesh *m, uint32_t vertex, uint32_t t, iso_vec3 p)
{
    int i = corner_of(m, t, vertex);
    iso_vec3 a = m->position[m->triangle[t].v[(i + 1) % 3]], b = m->position[m->triangle[t].v[(i + 2) % 3]];
    iso_vec3 n = iso_cross(a, b);
    double after_a = iso_dot(iso_cross(a, p), n), before_b = iso_dot(iso_cross(p, b), n);
    /* The vertex meets edge a b; or a lies on the edge to b, or b on that to a: swap this edge, which goes beyond t. */
    int side = after_a < 0 ? (i + 1) % 3 : before_b < 0 ? (i + 2) % 3 : i;
    if (degree(m, m->triangle[t].v[(side + 1) % 3]) < 4 || degree(m, m->triangle[t].v[(side + 2) % 3]) < 4)
        return false;
    swap_edge(m, t, side);
    return true;
}

/* Drags the vertex in the topology alone; its position is set at the end. */
static bool drag(mesh *m, uint32_t vertex, const path *p)
{
    for (int events = 0; events < 64; ++events) {
        double angle;
        uint32_t t = 0;
        if (!first_event(m, vertex, p, &angle, &t))
            return true;
        if (angle < 0 || !resolve(m, vertex, t, path_at(p, angle)))
            return false;
    }
    return false;
}

bool iso_mesh_move(mesh *m, uint32_t vertex, double angle, iso_random *random)
{
    path p = random_path(m->position[vertex], angle, random);
    m->moved_vertex = vertex;
    m->moved_from = p.from;
    m->too_many = false;
    if (!drag(m, vertex, &p)) {
        iso_mesh_revert(m);
        return false;
    }
    m->position[vertex] = iso_normalize(path_at(&p, angle));
    uint32_t start = m->triangle_of[vertex], t = start;
    do {
        const uint32_t *v = m->triangle[t].v;
        save(m, t, true);
        if (!(volume(m->position[v[0]], m->position[v[1]], m->position[v[2]]) > LEAST_VOLUME)) {
            iso_mesh_revert(m);
            return false;
        }
        t = m->triangle[t].n[(corner_of(m, t, vertex) + 1) % 3];
    } while (t != start);
    for (size_t i = 0; i < m->patch_count; ++i)
        for (int side = 0; side < 3; ++side)
            push_edge(m, m->patch[i], side);
    make_convex(m);
    if (m->too_many) {
        iso_mesh_revert(m);
        return false;
    }
    return true;
}

void iso_mesh_keep(mesh *m)
{
    for (size_t i = 0; i < m->saved_count; ++i)
        m->mark[m->saved[i].triangle] = 0;
    m->saved_count = m->patch_count = 0;
}

void iso_mesh_revert(mesh *m)
{
    m->position[m->moved_vertex] = m->moved_from;
    for (size_t i = 0; i < m->saved_count; ++i)
        m->triangle[m->saved[i].triangle] = m->saved[i].before;
    for (size_t i = 0; i < m->saved_count; ++i)
        for (int c = 0; c < 3; ++c)
            m->triangle_of[m->saved[i].before.v[c]] = m->saved[i].triangle;
    iso_mesh_keep(m);
}

bool iso_mesh_is_convex(const mesh *m)
{
    for (uint32_t t = 0; t < m->triangle_count; ++t) {
        const uint32_t *v = m->triangle[t].v;
        if (!(volume(m->position[v[0]], m->position[v[1]], m->position[v[2]]) > 0))
            return false;
        for (int side = 0; side < 3; ++side) {
            uint32_t o = m->triangle[t].n[side];
            if (m->triangle[o].n[side_to(m, o, t)] != t || is_concave(m, t, side))
                return false;
        }
    }
    return true;
}

/* ---- random mesh ---------------------------------------------------------------------------- */

static iso_vec3 random_point(iso_random *random)
{
    double z = 2 * iso_random_unit(random) - 1, turn = 2 * acos(-1) * iso_random_unit(random), r = sqrt(1 - z * z);
    return iso_v3(r * cos(turn), r * sin(turn), z);
}

/* Starts with (1,1,1), (1,-1,-1), (-1,1,-1), (-1,-1,1), turned at random. */
static void start_tetrahedron(mesh *m, iso_random *random)
{
    iso_vec3 e = random_point(random), f = iso_normalize(iso_cross(e, random_point(random))), g = iso_cross(e, f);
    const int sign[4][3] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    const mesh_triangle start[4] = {{{0, 1, 2}, {3, 2, 1}},
                                    {{0, 3, 1}, {3, 0, 2}},
                                    {{0, 2, 3}, {3, 1, 0}},
                                    {{1, 3, 2}, {2, 0, 1}}};
    for (int i = 0; i < 4; ++i) {
        m->position[i] = iso_normalize(iso_madd(iso_madd(iso_scale(e, sign[i][0]), f, sign[i][1]), g, sign[i][2]));
        m->triangle[i] = start[i];
        m->triangle_of[start[i].v[0]] = m->triangle_of[start[i].v[1]] = m->triangle_of[start[i].v[2]] = (uint32_t)i;
    }
    m->vertex_count = m->triangle_count = 4;
}

/* Cuts triangle t in three at the new vertex and makes the edges around it convex. */
static void insert(mesh *m, uint32_t t, iso_vec3 p)
{
    uint32_t vertex = (uint32_t)m->vertex_count++, second = (uint32_t)m->triangle_count, third = second + 1;
    m->triangle_count += 2;
    m->position[vertex] = p;
    mesh_triangle old = m->triangle[t];
    m->triangle[t] = (mesh_triangle){{vertex, old.v[0], old.v[1]}, {old.n[2], second, third}};
    m->triangle[second] = (mesh_triangle){{vertex, old.v[1], old.v[2]}, {old.n[0], third, t}};
    m->triangle[third] = (mesh_triangle){{vertex, old.v[2], old.v[0]}, {old.n[1], t, second}};
    m->triangle[old.n[0]].n[side_to(m, old.n[0], t)] = second;
    m->triangle[old.n[1]].n[side_to(m, old.n[1], t)] = third;
    m->triangle_of[vertex] = m->triangle_of[old.v[0]] = m->triangle_of[old.v[1]] = t;
    m->triangle_of[old.v[2]] = second;
    push_edge(m, t, 0);
    push_edge(m, second, 0);
    push_edge(m, third, 0);
    make_convex(m);
    iso_mesh_keep(m);
}

static uint32_t triangle_at(const mesh *m, iso_vec3 p)
{
    uint32_t best = 0;
    double best_depth = -INFINITY;
    for (uint32_t t = 0; t < m->triangle_count; ++t) {
        const uint32_t *v = m->triangle[t].v;
        iso_vec3 a = m->position[v[0]], b = m->position[v[1]], c = m->position[v[2]];
        double depth = fmin(fmin(volume(a, b, p), volume(b, c, p)), volume(c, a, p));
        if (depth > best_depth)
            best_depth = depth, best = t;
    }
    return best;
}

iso_status iso_mesh_create_random(mesh *m, size_t triangle_count, iso_random *random, iso_error *err)
{
    size_t vertices = triangle_count / 2 + 2; /* Euler's formula */
    *m = (mesh){0};
    m->position = malloc(vertices * sizeof *m->position);
    m->triangle_of = malloc(vertices * sizeof *m->triangle_of);
    m->triangle = malloc(triangle_count * sizeof *m->triangle);
    m->saved = malloc(triangle_count * sizeof *m->saved);
    m->patch = malloc(triangle_count * sizeof *m->patch);
    m->mark = calloc(triangle_count, 1);
    m->edges = malloc(EDGE_CAPACITY * sizeof *m->edges);
    if (!m->position || !m->triangle_of || !m->triangle || !m->saved || !m->patch || !m->mark || !m->edges) {
        iso_mesh_destroy(m);
        return iso_fail(err, ISO_E_MEMORY, "palette: no memory for %zu triangles", triangle_count);
    }
    start_tetrahedron(m, random);
    while (m->vertex_count < vertices) {
        iso_vec3 p = random_point(random);
        uint32_t t = triangle_at(m, p);
        const uint32_t *v = m->triangle[t].v;
        iso_vec3 a = m->position[v[0]], b = m->position[v[1]], c = m->position[v[2]];
        /* A point on an edge or on a vertex would make a flat triangle; then the next one is drawn. */
        if (volume(a, b, p) > 1e-9 && volume(b, c, p) > 1e-9 && volume(c, a, p) > 1e-9)
            insert(m, t, p);
    }
    return ISO_OK;
}

void iso_mesh_destroy(mesh *m)
{
    free(m->position);
    free(m->triangle_of);
    free(m->triangle);
    free(m->saved);
    free(m->patch);
    free(m->mark);
    free(m->edges);
    *m = (mesh){0};
}
