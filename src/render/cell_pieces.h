/* SPDX-License-Identifier: MIT */
/* cell_pieces.h - the pieces of a ray within a cell: cut, bounded, and integrated eight at a time (cell_ray.h). */
#pragma once

#include "render/cell_ray.h"
#include "render/lanes.h"

enum { CELL_RULES = 3, CELL_POINTS = 8 };
/* Gauss and Legendre's, on [0, 1]. */
typedef struct cell_rule {
    int points;
    double at[CELL_POINTS], weight[CELL_POINTS];
} cell_rule;
static const cell_rule cell_rules[CELL_RULES] = {
    {3, {0.112701665379258311, 0.5, 0.887298334620741689}, {5.0 / 18, 4.0 / 9, 5.0 / 18}},
    {5,
     {0.0469100770306680036, 0.230765344947158454, 0.5, 0.769234655052841546, 0.953089922969331996},
     {0.118463442528094544, 0.239314335249683234, 0.284444444444444444, 0.239314335249683234, 0.118463442528094544}},
    {8,
     {0.0198550717512318842, 0.10166676129318663, 0.237233795041835507, 0.408282678752175098, 0.591717321247824902,
      0.762766204958164493, 0.89833323870681337, 0.980144928248768116},
     {0.0506142681451881296, 0.111190517226687235, 0.156853322938943644, 0.181341891689180991, 0.181341891689180991,
      0.156853322938943644, 0.111190517226687235, 0.0506142681451881296}}};

/* Linear piece of the transfer function between two entries at which it bends: r, g, b and the extinction per mm are
 * base + slope (X - entry). */
typedef struct cell_line {
    double entry, base[4], slope[4];
} cell_line;

/* Pieces that wait until there are eight for one rule. */
typedef struct cell_queue {
    lanes x[4], d[3][4];              /* X and d of u, the way through the cell */
    lanes from, width, length, depth; /* u of the piece; mm of the cell; optical depth in front of the piece */
    lanes entry, base[4], slope[4];
    int count;
} cell_queue;

typedef struct cell_pieces {
    const iso_cell_scene *scene;
    double tolerance_per_mm;
    size_t light_count;
    iso_vec3 light[ISO_MAX_LIGHTS], half[ISO_MAX_LIGHTS];
    double diffuse[ISO_MAX_LIGHTS], specular[ISO_MAX_LIGHTS];
    /* The cell at work. */
    double x[4], d[3][4], nl[ISO_MAX_LIGHTS][4], nh[ISO_MAX_LIGHTS][4], length;
    double depth, left; /* the optical depth so far; the most that the rest of the ray can add */
    double error, pool; /* bound of the sum so far; unused tolerance of earlier places */
    cell_queue queue[CELL_RULES];
    lanes color[3];
} cell_pieces;

ISO_LANES_INLINE double cubic_at(const double p[4], double u)
{
    return ((p[3] * u + p[2]) * u + p[1]) * u + p[0];
}

/* Turns eight corners into the cubics along from + u way, four fields at a time. */
ISO_LANES_INLINE void cubic_of_corners(cell_pieces *w, const four corner[8], const double from[3], const double way[3])
{
    const four x = corner[1] - corner[0], y = corner[2] - corner[0], z = corner[4] - corner[0];
    const four xy = corner[3] - corner[2] - x, xz = corner[5] - corner[4] - x, yz = corner[6] - corner[4] - y;
    const four xyz = corner[7] - corner[6] - corner[5] + corner[4] - xy;
    const double fx = from[0], fy = from[1], fz = from[2], wx = way[0], wy = way[1], wz = way[2];
    four p[4];
    p[0] = corner[0] + x * fx + y * fy + z * fz + xy * (fx * fy) + xz * (fx * fz) + yz * (fy * fz) +
           xyz * (fx * fy * fz);
    p[1] = (x + xy * fy + xz * fz + xyz * (fy * fz)) * wx + (y + xy * fx + yz * fz + xyz * (fx * fz)) * wy +
           (z + xz * fx + yz * fy + xyz * (fx * fy)) * wz;
    p[2] = (xy + xyz * fz) * (wx * wy) + (xz + xyz * fy) * (wx * wz) + (yz + xyz * fx) * (wy * wz);
    p[3] = xyz * (wx * wy * wz);
    for (int i = 0; i < 4; ++i) {
        w->x[i] = p[i][0];
        for (int a = 0; a < 3; ++a)
            w->d[a][i] = p[i][a + 1];
    }
    if (!w->scene->lit)
        return;
    for (size_t l = 0; l < w->light_count; ++l)
        for (int i = 0; i < 4; ++i) {
            w->nl[l][i] = p[i][1] * w->light[l].x + p[i][2] * w->light[l].y + p[i][3] * w->light[l].z;
            w->nh[l][i] = p[i][1] * w->half[l].x + p[i][2] * w->half[l].y + p[i][3] * w->half[l].z;
        }
}

/* Writes the directions at a cell's corners to fields 1 to 3 of corner; cell as in empty_space.h. */
void iso_cell_directions(const iso_cell_scene *c, const size_t voxel[8], const int cell[3], four corner[8]);
/* Finds the places in (0, 1) with zero slope of a cubic, ascending. Returns their number. */
int iso_cubic_extremes(const double p[4], double u[2]);
/* Finds the places in (0, 1) where a cubic changes its sign, ascending. Returns their number. */
int iso_cubic_zeros(const double p[4], double u[3]);
/* Solves for the place where a cubic that is monotone on [a, b] takes a value between those at its ends. */
double iso_cubic_solve(const double p[4], double value, double a, double b);

/* ---- the bound ---- */

/* Radii R of the discs round a section of the cell, in its half widths. */
#define CELL_RADII ((lanes){1.12, 1.35, 1.7, 2.3, 3.2, 5, 9, 20})

/* Bounds of the emission on discs round the section's middle. */
typedef struct cell_section {
    double middle, half; /* u */
    double x;            /* X in the middle */
    lanes x_far, shade;  /* |X - x| and |shade| at most, the latter without ... */
    lanes rough;         /* ... highlights that are not analytic on the disc, at most within the section */
} cell_section;

/* Computes a cubic's coefficients in z, u = middle + half z. */
ISO_LANES_INLINE void shift_cubic(const double p[4], double middle, double half, double z[4])
{
    z[0] = cubic_at(p, middle);
    z[1] = half * ((3 * p[3] * middle + 2 * p[2]) * middle + p[1]);
    z[2] = half * half * (3 * p[3] * middle + p[2]);
    z[3] = half * half * half * p[3];
}

/* Bounds |p(z) - p(0)| for |z| <= R. */
ISO_LANES_INLINE lanes reach(const double z[4])
{
    const lanes r = CELL_RADII;
    return ((r * fabs(z[3]) + fabs(z[2])) * r + fabs(z[1])) * r;
}

/* Bounds one light's highlight. A fractional power branches at n.h = 0, so discs that hold such a place give no bound.
 * On the ray itself the highlight is small there: *rough gets its bound. */
ISO_LANES_INLINE lanes bound_highlight(const cell_pieces *w, const cell_section *s, size_t light, lanes root,
                                       lanes *rough)
{
    const iso_cell_scene *c = w->scene;
    double z[4];
    shift_cubic(w->nh[light], s->middle, s->half, z);
    const lanes far = reach(z), most = (far + fabs(z[0])) * root;
    if (c->power >= 0)
        return lanes_power(most, c->power) * w->specular[light];
    /* Within the section |n.h| is at most 1, and the largest root is that of the smallest disc. */
    const double inside = (fabs(z[0]) + fabs(z[1]) + fabs(z[2]) + fabs(z[3])) * root[0];
    const double small = w->specular[light] * pow(inside < 1 ? inside : 1, c->view->shading.power);
    /* x^p is at most the whole power below p where x is below 1, and that above it elsewhere. */
    const lanes below = lanes_power(most, c->whole_power);
    const lanes power = lanes_select(most < lanes_all(1), below, below * most) * w->specular[light];
    const lane_bits analytic = far < lanes_all(fabs(z[0]));
    *rough += lanes_select(analytic, lanes_all(0), lanes_all(small));
    return lanes_select(analytic, power, lanes_all(0));
}

ISO_LANES_INLINE void bound_shade(const cell_pieces *w, cell_section *s)
{
    const iso_cell_scene *c = w->scene;
    double d[3][4], turn[4] = {0};
    lanes squares = lanes_all(0);
    for (int a = 0; a < 3; ++a) {
        shift_cubic(w->d[a], s->middle, s->half, d[a]);
        const lanes far = reach(d[a]);
        squares += far * far;
        for (int i = 0; i < 4; ++i)
            turn[i] += d[a][0] * d[a][i];
    }
    /* |d.d + eps^2| is at least its value in the middle less what d's change can take */
    const lanes least = lanes_all(turn[0] + c->eps_2) - reach(turn) * 2 - squares;
    const lane_bits there = least > lanes_all(0);
    const lanes root = 1 / lanes_sqrt(lanes_select(there, least, lanes_all(1)));
    lanes shade = lanes_all(c->view->shading.ambient);
    for (size_t l = 0; l < w->light_count; ++l) {
        double z[4];
        shift_cubic(w->nl[l], s->middle, s->half, z);
        shade += (reach(z) + fabs(z[0])) * root * w->diffuse[l];
        if (w->specular[l] > 0)
            shade += bound_highlight(w, s, l, root, &s->rough);
    }
    s->shade = lanes_select(there, shade, lanes_all(INFINITY));
}

ISO_LANES_INLINE cell_section make_section(const cell_pieces *w, double from, double to)
{
    cell_section s = {.middle = 0.5 * (from + to), .half = 0.5 * (to - from)};
    double z[4];
    shift_cubic(w->x, s.middle, s.half, z);
    s.x = z[0];
    s.x_far = reach(z);
    s.shade = lanes_all(w->scene->view->shading.ambient);
    s.rough = lanes_all(0);
    if (w->scene->lit)
        bound_shade(w, &s);
    return s;
}

/* Chooses the rule of fewest points with an error of at most `allowed` on [from, from + width], inside the section;
 * *bound gets its bound. CELL_RULES: none. */
ISO_LANES_INLINE int choose_rule(const cell_pieces *w, const cell_section *s, const cell_line *line, double width,
                                 double through, double allowed, double *bound)
{
    const double part = 0.5 * width / s->half, half_mm = 0.5 * width * w->length;
    /* The piece's ellipse lies in the section's disc: its semi-axis a ends at R - (1 - part). */
    const lanes a = (CELL_RADII - 1) * (1 / part) + 1;
    const lanes rho = a + lanes_sqrt(a * a - 1), q = 1 / (rho * rho);
    lanes most = lanes_all(0);
    for (int i = 0; i < 3; ++i)
        most = lanes_max(most,
                         s->x_far * fabs(line->slope[i]) + fabs(line->base[i] + line->slope[i] * (s->x - line->entry)));
    const lanes sigma = s->x_far * fabs(line->slope[3]) + fabs(line->base[3] + line->slope[3] * (s->x - line->entry));
    const lanes m = sigma * most * s->shade * lanes_exp(sigma * (a + 1) * half_mm);
    const lanes scale = m / (1 - q) * (64.0 / 15 * through * half_mm), q2 = q * q, q4 = q2 * q2;
    /* The integral and the rule's sum, whose weights are positive, can each take the largest value. */
    const lanes rest = sigma * most * s->rough * (4 * through * half_mm);
    const lanes of_rule[CELL_RULES] = {scale * (q2 * q) + rest, scale * (q4 * q) + rest, scale * (q4 * q4) + rest};
    for (int r = 0; r < CELL_RULES; ++r) {
        double least = INFINITY;
        for (int i = 0; i < LANES; ++i)
            least = of_rule[r][i] < least ? of_rule[r][i] : least;
        *bound = least;
        if (least <= allowed)
            return r;
    }
    return CELL_RULES;
}

/* ---- evaluation ---- */

ISO_LANES_INLINE lanes shade_pieces(const cell_pieces *w, const cell_queue *q, lanes u)
{
    const iso_cell_scene *c = w->scene;
    lanes d[3], square = lanes_all(c->eps_2);
    for (int a = 0; a < 3; ++a) {
        d[a] = ((q->d[a][3] * u + q->d[a][2]) * u + q->d[a][1]) * u + q->d[a][0];
        square += d[a] * d[a];
    }
    const lanes root = 1 / lanes_sqrt(square);
    lanes shade = lanes_all(c->view->shading.ambient);
    for (size_t l = 0; l < w->light_count; ++l) {
        const iso_vec3 *n = &w->light[l], *h = &w->half[l];
        shade += lanes_abs(d[0] * n->x + d[1] * n->y + d[2] * n->z) * root * w->diffuse[l];
        if (w->specular[l] > 0) {
            lanes nh = lanes_abs(d[0] * h->x + d[1] * h->y + d[2] * h->z) * root;
            if (c->power >= 0) {
                nh = lanes_power(nh, c->power);
            } else {
                for (int i = 0; i < LANES; ++i)
                    nh[i] = pow(nh[i], c->view->shading.power);
            }
            shade += nh * w->specular[l];
        }
    }
    return shade;
}

ISO_LANES_INLINE void evaluate_pieces(cell_pieces *w, int r)
{
    cell_queue *q = &w->queue[r];
    const cell_rule *rule = &cell_rules[r];
    for (int j = 0; j < rule->points; ++j) {
        const lanes step = q->width * rule->at[j], u = q->from + step, both = u + q->from;
        const lanes from = ((q->x[3] * u + q->x[2]) * u + q->x[1]) * u + (q->x[0] - q->entry);
        const lanes squares = u * u + q->from * q->from;
        const lanes mean = (q->x[0] - q->entry) + q->x[1] * both * 0.5 + q->x[2] * (squares + u * q->from) * (1.0 / 3) +
                           q->x[3] * both * squares * 0.25;
        const lanes depth = q->depth + q->length * step * (q->base[3] + q->slope[3] * mean);
        lanes light = (q->base[3] + q->slope[3] * from) * lanes_exp(-depth) * (q->length * q->width * rule->weight[j]);
        light *= w->scene->lit ? shade_pieces(w, q, u) : lanes_all(w->scene->view->shading.ambient);
        for (int i = 0; i < 3; ++i)
            w->color[i] += light * (q->base[i] + q->slope[i] * from);
    }
    q->count = 0;
}

ISO_LANES_INLINE void add_piece(cell_pieces *w, int r, const cell_line *line, double from, double width)
{
    cell_queue *q = &w->queue[r];
    const int i = q->count++;
    for (int j = 0; j < 4; ++j) {
        q->x[j][i] = w->x[j];
        q->base[j][i] = line->base[j];
        q->slope[j][i] = line->slope[j];
    }
    if (w->scene->lit)
        for (int a = 0; a < 3; ++a)
            for (int j = 0; j < 4; ++j)
                q->d[a][j][i] = w->d[a][j];
    q->from[i] = from;
    q->width[i] = width;
    q->length[i] = w->length;
    q->depth[i] = w->depth;
    q->entry[i] = line->entry;
    /* the depth of the whole piece, in closed form */
    const double u = from + width, both = u + from, squares = u * u + from * from;
    const double mean = (w->x[0] - line->entry) + w->x[1] * both * 0.5 + w->x[2] * (squares + u * from) * (1.0 / 3) +
                        w->x[3] * both * squares * 0.25;
    w->depth += w->length * width * (line->base[3] + line->slope[3] * mean);
    if (q->count == LANES)
        evaluate_pieces(w, r);
}

/* ---- cutting ---- */

/* Finds the table's line at X. True if it shows anything. */
ISO_LANES_INLINE bool line_at(const iso_tf_table *tf, double x, cell_line *line)
{
    const size_t last = tf->count - 1, i = x > 0 ? (x < (double)last ? (size_t)x : last) : 0;
    const float *e = tf->entries + 4 * i;
    const bool flat = !(x > 0 && x < (double)last);
    line->entry = (double)i;
    for (int c = 0; c < 4; ++c) {
        line->base[c] = (double)e[c];
        line->slope[c] = flat ? 0 : (double)e[4 + c] - (double)e[c];
    }
    return line->base[3] != 0 || line->slope[3] != 0;
}

/* Adds [from, to], within which the table does not bend. whole: a section that holds it, or NULL. */
ISO_LANES_INLINE void add_stretch(cell_pieces *w, double from, double to, const cell_section *whole)
{
    const double least_width = 0x1p-40, most_growth = 4;
    cell_line line;
    if (!(to > from) || !line_at(w->scene->tf, cubic_at(w->x, 0.5 * (from + to)), &line))
        return;
    double end = to;
    while (from < to) {
        const double width = end - from, through = lane_exp(-w->depth);
        const double allowed = w->tolerance_per_mm * w->length * width + (w->pool > 0 ? 0.5 * w->pool : 0);
        double bound = 0;
        int rule = CELL_RULES;
        if (whole)
            rule = choose_rule(w, whole, &line, width, through, allowed, &bound);
        if (rule == CELL_RULES) {
            const cell_section own = make_section(w, from, end);
            rule = choose_rule(w, &own, &line, width, through, allowed, &bound);
        }
        if (rule == CELL_RULES && width > least_width) {
            end = 0.5 * (from + end);
            continue;
        }
        if (rule == CELL_RULES) { /* so small that all it holds counts as error */
            rule = CELL_RULES - 1;
            bound = 2 * through * w->scene->brightest * w->length * width * (fabs(line.base[3]) + fabs(line.slope[3]));
        }
        add_piece(w, rule, &line, from, width);
        w->error += bound;
        w->pool -= bound > 0.5 * w->pool ? 0.5 * w->pool : bound;
        /* Towards a place where the shading is not analytic pieces become small; away from it they grow again. */
        from = end;
        end = from + most_growth * width < to ? from + most_growth * width : to;
    }
    w->left = lane_exp(-w->depth) * w->scene->brightest;
}

/* Adds [from, to], cut at the table's bends. X is monotone in it wherever the table bends. */
ISO_LANES_INLINE void add_section(cell_pieces *w, double from, double to)
{
    enum { FEW = 2 };
    const iso_cell_scene *c = w->scene;
    const double last = (double)(c->tf->count - 1), x0 = cubic_at(w->x, from), x1 = cubic_at(w->x, to);
    const double lo = x0 < x1 ? x0 : x1, hi = x0 < x1 ? x1 : x0;
    const double first = ceil(lo > 0 ? lo : 0), end = floor(hi < last ? hi : last);
    const size_t bends = first <= end ? c->bends[(size_t)end + 1] - c->bends[(size_t)first] : 0;
    if (bends > 0 && iso_shown_entries(c->shown, lo, hi)) {
        cell_section whole;
        if (bends > FEW)
            whole = make_section(w, from, to);
        double u = from;
        for (double n = 0; n <= end - first; ++n) {
            const double entry = x0 < x1 ? first + n : end - n;
            if (c->bends[(size_t)entry + 1] == c->bends[(size_t)entry])
                continue;
            const double v = iso_cubic_solve(w->x, entry, u, to);
            add_stretch(w, u, v, bends > FEW ? &whole : NULL);
            u = v;
        }
        from = u;
    }
    add_stretch(w, from, to, NULL);
}

enum { CELL_MOST_CUTS = 3 + 6 * ISO_MAX_LIGHTS + 2 };

ISO_LANES_INLINE int sorted_cuts(const cell_pieces *w, bool bends, double cut[CELL_MOST_CUTS])
{
    int count = 0;
    cut[count++] = 0;
    if (bends)
        count += iso_cubic_extremes(w->x, cut + count);
    for (size_t l = 0; w->scene->lit && l < w->light_count; ++l) {
        if (w->diffuse[l] > 0)
            count += iso_cubic_zeros(w->nl[l], cut + count);
        if (w->specular[l] > 0 && (w->scene->power < 0 || w->scene->power & 1))
            count += iso_cubic_zeros(w->nh[l], cut + count);
    }
    for (int i = 2; i < count; ++i)
        for (int j = i; j > 1 && cut[j] < cut[j - 1]; --j) {
            const double swap = cut[j];
            cut[j] = cut[j - 1];
            cut[j - 1] = swap;
        }
    cut[count] = 1;
    return count;
}

/* Adds the cell that read_cell() read. */
ISO_LANES_INLINE void add_cell(cell_pieces *w)
{
    const iso_cell_scene *c = w->scene;
    /* A cubic lies between its Bezier points. */
    const double b[4] = {w->x[0], w->x[0] + w->x[1] / 3, w->x[0] + (2 * w->x[1] + w->x[2]) / 3,
                         w->x[0] + w->x[1] + w->x[2] + w->x[3]};
    double lo = b[0], hi = b[0], cut[CELL_MOST_CUTS];
    for (int i = 1; i < 4; ++i) {
        lo = b[i] < lo ? b[i] : lo;
        hi = b[i] > hi ? b[i] : hi;
    }
    if (!iso_shown_entries(c->shown, lo, hi))
        return;
    const double last = (double)(c->tf->count - 1), first = ceil(lo > 0 ? lo : 0), end = floor(hi < last ? hi : last);
    const bool bends = first <= end && c->bends[(size_t)end + 1] > c->bends[(size_t)first];
    const int count = sorted_cuts(w, bends, cut);
    for (int i = 0; i < count; ++i)
        if (cut[i + 1] > cut[i])
            add_section(w, cut[i], cut[i + 1]);
}

/* ---- a ray ---- */

ISO_LANES_INLINE void start_pieces(cell_pieces *w, const iso_cell_scene *c, const iso_cell_ray *ray)
{
    const iso_shading *m = &c->view->shading;
    w->scene = c;
    w->tolerance_per_mm = ray->tolerance / (ray->t1 - ray->t0);
    w->light_count = c->lit ? c->view->light_count : 0;
    for (size_t l = 0; l < w->light_count; ++l) {
        w->light[l] = c->view->lights[l].direction;
        w->half[l] = iso_normalize(iso_add(w->light[l], ray->to_viewer));
        w->diffuse[l] = c->view->lights[l].intensity * m->diffuse;
        w->specular[l] = c->view->lights[l].intensity * m->specular;
    }
    w->depth = w->error = w->pool = 0;
    w->left = c->brightest;
    for (int r = 0; r < CELL_RULES; ++r)
        w->queue[r].count = 0;
    for (int i = 0; i < 3; ++i)
        w->color[i] = lanes_all(0);
}

ISO_LANES_INLINE stretch finish_pieces(cell_pieces *w, bool open, double *error)
{
    for (int r = 0; r < CELL_RULES; ++r) {
        cell_queue *q = &w->queue[r];
        const int count = q->count;
        if (count == 0)
            continue;
        for (int i = count; i < LANES; ++i) { /* lanes without a piece weigh nothing */
            for (int j = 0; j < 4; ++j) {
                q->x[j][i] = q->base[j][i] = q->slope[j][i] = 0;
                for (int a = 0; a < 3; ++a)
                    q->d[a][j][i] = 0;
            }
            q->from[i] = q->width[i] = q->length[i] = q->depth[i] = q->entry[i] = 0;
        }
        evaluate_pieces(w, r);
    }
    *error = w->error + (open ? 0 : w->left > ISO_REFERENCE_LEFT ? w->left : ISO_REFERENCE_LEFT);
    return (stretch){{lanes_sum(w->color[0]), lanes_sum(w->color[1]), lanes_sum(w->color[2])}, w->depth};
}
