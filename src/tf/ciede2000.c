/* SPDX-License-Identifier: MIT */
#include "tf/ciede2000.h"

#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

/* ---- color difference [sharma-2005] ---- */

static double square(double x)
{
    return x * x;
}

/* Returns sqrt(c^7 / (c^7 + 25^7)). */
static double chroma_weight(double chroma)
{
    const double c = pow(chroma, 7);
    return sqrt(c / (c + 6103515625.0));
}

/* Returns the hue angle, 0 to 2 pi; 0 for gray. */
static double hue_of(double a, double b)
{
    const double hue = a == 0 && b == 0 ? 0 : atan2(b, a);
    return hue < 0 ? hue + 2 * pi : hue;
}

static double mean_hue(double h1, double h2, bool has_gray)
{
    const double sum = h1 + h2;
    if (has_gray)
        return sum;
    if (fabs(h1 - h2) <= pi)
        return 0.5 * sum;
    return sum < 2 * pi ? 0.5 * sum + pi : 0.5 * sum - pi;
}

double iso_ciede2000(const double lab1[3], const double lab2[3])
{
    const double g = 0.5 * (1 - chroma_weight(0.5 * (hypot(lab1[1], lab1[2]) + hypot(lab2[1], lab2[2]))));
    const double a1 = (1 + g) * lab1[1], a2 = (1 + g) * lab2[1];
    const double c1 = hypot(a1, lab1[2]), c2 = hypot(a2, lab2[2]);
    const double h1 = hue_of(a1, lab1[2]), h2 = hue_of(a2, lab2[2]);
    const bool has_gray = c1 * c2 == 0;
    const double turn = has_gray ? 0 : remainder(h2 - h1, 2 * pi);
    const double dl = lab2[0] - lab1[0], dc = c2 - c1, dh = 2 * sqrt(c1 * c2) * sin(0.5 * turn);
    const double l = 0.5 * (lab1[0] + lab2[0]), c = 0.5 * (c1 + c2), h = mean_hue(h1, h2, has_gray);
    const double degree = pi / 180;
    const double t = 1 - 0.17 * cos(h - 30 * degree) + 0.24 * cos(2 * h) + 0.32 * cos(3 * h + 6 * degree) -
                     0.2 * cos(4 * h - 63 * degree);
    const double rotation = 30 * degree * exp(-square((h - 275 * degree) / (25 * degree)));
    const double sl = 1 + 0.015 * square(l - 50) / sqrt(20 + square(l - 50));
    const double sc = 1 + 0.045 * c, sh = 1 + 0.015 * c * t;
    const double l_part = dl / sl, c_part = dc / sc, h_part = dh / sh;
    const double rt = -sin(2 * rotation) * 2 * chroma_weight(c);
    return sqrt(square(l_part) + square(c_part) + square(h_part) + rt * c_part * h_part);
}

/* ---- grid and shortest paths ---- */

enum { SIDE = 17, CELLS = SIDE * SIDE * SIDE, NEIGHBORS = 26, NOWHERE = -1 };

/* Cells are numbered with red slowest: of two at the same distance VTK continues from the one with less red, then less
 * green, then less blue. */
typedef struct grid {
    double lab[CELLS][3];
    float edge[CELLS][NEIGHBORS];
    double distance[CELLS];
    int next[CELLS]; /* one step nearer to the end of the path */
    bool done[CELLS];
} grid;

static void color_of(int cell, double rgb[3])
{
    const int place[3] = {cell / (SIDE * SIDE), cell / SIDE % SIDE, cell % SIDE};
    for (int c = 0; c < 3; ++c)
        rgb[c] = place[c] / (double)(SIDE - 1);
}

static int cell_of(const double rgb[3])
{
    int cell = 0;
    for (int c = 0; c < 3; ++c)
        cell = SIDE * cell + (int)(rgb[c] * (SIDE - 1) + 0.5);
    return cell;
}

/* Returns the n-th neighbor; NOWHERE beyond the border. */
static int neighbor(int cell, int n)
{
    const int place[3] = {cell / (SIDE * SIDE), cell / SIDE % SIDE, cell % SIDE};
    const int k = n < NEIGHBORS / 2 ? n : n + 1; /* skips the cell itself */
    const int step[3] = {k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1};
    int found = 0;
    for (int c = 0; c < 3; ++c) {
        const int at = place[c] + step[c];
        if (at < 0 || at >= SIDE)
            return NOWHERE;
        found = SIDE * found + at;
    }
    return found;
}

static grid *make_grid(void)
{
    grid *g = malloc(sizeof *g);
    double rgb[3];
    for (int i = 0; g && i < CELLS; ++i) {
        color_of(i, rgb);
        iso_color_to_lab(rgb, g->lab[i]);
    }
    for (int i = 0; g && i < CELLS; ++i)
        for (int n = 0; n < NEIGHBORS; ++n) {
            const int other = neighbor(i, n);
            g->edge[i][n] = other == NOWHERE ? INFINITY : (float)iso_ciede2000(g->lab[i], g->lab[other]);
        }
    return g;
}

/* Returns the nearest cell whose distance is not final; NOWHERE if none can be reached. */
static int nearest(const grid *g)
{
    int found = NOWHERE;
    for (int i = 0; i < CELLS; ++i)
        if (!g->done[i] && g->distance[i] < (found == NOWHERE ? INFINITY : g->distance[found]))
            found = i;
    return found;
}

/* Runs Dijkstra's algorithm from the end of the path until it reaches the start. */
static void find_path(grid *g, int start, int end)
{
    for (int i = 0; i < CELLS; ++i) {
        g->distance[i] = INFINITY;
        g->done[i] = false;
    }
    g->distance[end] = 0;
    for (int at; (at = nearest(g)) != NOWHERE && at != start;) {
        g->done[at] = true;
        for (int n = 0; n < NEIGHBORS; ++n) {
            const int other = neighbor(at, n);
            if (other != NOWHERE && g->distance[at] + (double)g->edge[at][n] < g->distance[other]) {
                g->distance[other] = g->distance[at] + (double)g->edge[at][n];
                g->next[other] = at;
            }
        }
    }
}

/* Appends the nodes of the path between two nodes; both ends have the grid's colors. */
static iso_status add_path(grid *g, const iso_tf_node *from, const iso_tf_node *to, iso_tf_curve *curve,
                           const char *path, iso_error *err)
{
    const int start = cell_of(from->y), end = cell_of(to->y);
    double rgb[3];
    iso_status status = ISO_OK;
    find_path(g, start, end);
    const double length = g->distance[start];
    for (int at = start; status == ISO_OK; at = g->next[at]) {
        const double t = length > 0 ? 1 - g->distance[at] / length : 0;
        color_of(at, rgb);
        status = iso_tf_curve_add_color(curve, from->x + t * (to->x - from->x), rgb, path, err);
        if (at == end)
            break;
    }
    return status;
}

iso_status iso_ciede2000_expand(iso_tf_curve *color, const char *path, iso_error *err)
{
    OWNED(iso_tf_curves) paths = {0};
    FREED grid *g = make_grid();
    NEED_MEMORY(g, err, "%s: out of memory", path);
    iso_tf_curve_sort(color);
    for (size_t i = 0; i < color->count; ++i) {
        /* Grid colors between the nodes; the first and the last node keep the file's colors. */
        if (i == 0 || i + 1 == color->count)
            NEED(iso_tf_curve_add(&paths.color, color->nodes[i], 3, path, err));
        if (i + 1 < color->count && color->nodes[i + 1].x > color->nodes[i].x)
            NEED(add_path(g, &color->nodes[i], &color->nodes[i + 1], &paths.color, path, err));
    }
    const iso_tf_curve before = *color;
    *color = paths.color;
    paths.color = before;
    return ISO_OK;
}
