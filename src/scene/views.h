/* SPDX-License-Identifier: MIT */
/* views.h - views of benchmarks: sets of evenly spread directions, none along an axis of the grid. */
#pragma once

#include "base/linalg.h"

/* Views through the centers of an icosahedron's faces, i below 20: the views of [diaz-garcia-2016] sec. 5. Eight of
 * them are the cube's diagonals. */
enum { ISO_FACE_VIEWS = 20 };
iso_vec3 iso_view_through_face(int i);
/* Returns view i of `count` below twenty, spread over them. */
iso_vec3 iso_view_of_faces(int i, int count);

/* Views along the six diagonals of an icosahedron. */
enum { ISO_DIAGONAL_VIEWS = 6 };
iso_vec3 iso_view_along_diagonal(int i);
/* Returns view i of `count`: diagonals without opposite views; beyond six also views through faces. */
iso_vec3 iso_view_spread(int i, int count);

/* Returns an up vector far from the direction. */
iso_vec3 iso_view_up(iso_vec3 direction);
