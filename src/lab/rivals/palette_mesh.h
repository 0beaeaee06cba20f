/* SPDX-License-Identifier: MIT */
/* palette_mesh.h - a convex triangulation of the unit sphere with moving vertices
 * ([bremer-2001] section 3.2).
 *
 * All vertices lie on the sphere, so that the locally convex triangulation is their convex
 * hull. A move drags a vertex along a great circle. If a triangle around it degenerates,
 * the edge in the way is swapped, which keeps the weaker condition: every triangle keeps
 * its orientation as seen from the center. Then further swaps make every affected edge
 * convex.
 *
 *         a                 triangle t: v[0..2] counter-clockwise from outside,
 *       / | \               n[i] the triangle across the edge opposite v[i]
 *      b  |  d
 *       \ | /               patch of a move: the triangles that it changed; its outline
 *         c                 stays, so that it contains the same directions as before */
#pragma once

#include "base/linalg.h"
#include "base/random.h"
#include "base/status.h"

typedef struct mesh_triangle {
    uint32_t v[3], n[3];
} mesh_triangle;

typedef struct mesh_saved {
    uint32_t triangle;
    mesh_triangle before;
} mesh_saved;

typedef struct mesh {
    size_t vertex_count, triangle_count;
    iso_vec3 *position;
    uint32_t *triangle_of; /* one of a vertex's triangles */
    mesh_triangle *triangle;
    /* State of the current move. */
    uint32_t moved_vertex;
    iso_vec3 moved_from;
    size_t saved_count, patch_count;
    mesh_saved *saved; /* triangles with changed neighbors or corners */
    uint32_t *patch;   /* triangles with changed shape */
    uint8_t *mark;     /* bit 0: saved, bit 1: in the patch */
    uint32_t *edges;   /* edges to make convex: 3 triangle + side */
    size_t edge_count;
    bool too_many; /* True if the move affects too many edges */
} mesh;

/* Creates a random mesh with an even number of triangles, at least 8. Four vertices are a randomly turned tetrahedron,
 * which contains the center; the others are uniform on the sphere. */
iso_status iso_mesh_create_random(mesh *m, size_t triangle_count, iso_random *random, iso_error *err);
void iso_mesh_destroy(mesh *m);

/* Moves a vertex by an angle in a random direction. False: the conditions would be violated; nothing has changed. After
 * True the caller reads the patch, and keeps or reverts the move. */
bool iso_mesh_move(mesh *m, uint32_t vertex, double angle, iso_random *random);
void iso_mesh_keep(mesh *m);
void iso_mesh_revert(mesh *m);

/* True if every edge is convex and every triangle positive seen from the center; for tests. */
bool iso_mesh_is_convex(const mesh *m);
