/* SPDX-License-Identifier: MIT */
#include "scene/views.h"

static double golden_ratio(void)
{
    return 0.5 * (1 + sqrt(5));
}

/* Returns face i's center of an icosahedron. The centers are the corners of a dodecahedron. */
iso_vec3 iso_view_through_face(int i)
{
    const double g = golden_ratio(), s[2] = {-1, 1};
    if (i < 8)
        return iso_normalize(iso_v3(s[i & 1], s[i >> 1 & 1], s[i >> 2]));
    double a = s[i & 1] / g, b = s[i >> 1 & 1] * g;
    switch ((i - 8) / 4) {
    case 0: return iso_normalize(iso_v3(0, a, b));
    case 1: return iso_normalize(iso_v3(a, b, 0));
    default: return iso_normalize(iso_v3(b, 0, a));
    }
}

iso_vec3 iso_view_of_faces(int i, int count)
{
    return iso_view_through_face(i * ISO_FACE_VIEWS / count);
}

iso_vec3 iso_view_along_diagonal(int i)
{
    const double g = golden_ratio();
    const iso_vec3 diagonals[ISO_DIAGONAL_VIEWS] = {{0, 1, g},  {1, g, 0},  {g, 0, 1},
                                                    {0, -1, g}, {-1, g, 0}, {-g, 0, 1}};
    return iso_normalize(diagonals[i % ISO_DIAGONAL_VIEWS]);
}

iso_vec3 iso_view_spread(int i, int count)
{
    return count <= ISO_DIAGONAL_VIEWS ? iso_view_along_diagonal(i) : iso_view_of_faces(i, count);
}

iso_vec3 iso_view_up(iso_vec3 direction)
{
    return fabs(direction.z) < 0.8 ? iso_v3(0, 0, 1) : iso_v3(0, 1, 0);
}
