/* SPDX-License-Identifier: MIT */
/* reference_ray.c - what one ray meets, and its integral: converged, by equal intervals, by midpoints, by the TF's
 * means, or the first hit of a surface. */
#include "render/reference_ray.h"

#include <math.h>

#include "fit/extinction_scale.h"
#include "render/cell_ray.h"
#include "scene/roi.h"

/* Computes the half vectors between lights and viewer. */
static void find_halves(const iso_view *view, iso_vec3 to_viewer, iso_vec3 half[ISO_MAX_LIGHTS])
{
    for (size_t i = 0; i < view->light_count; ++i)
        half[i] = iso_normalize(iso_add(view->lights[i].direction, to_viewer));
}

static double shade(const iso_view *view, iso_vec3 n, const iso_vec3 half[ISO_MAX_LIGHTS])
{
    const iso_shading *m = &view->shading;
    double sum = m->ambient;
    for (size_t i = 0; i < view->light_count; ++i) {
        const iso_light *light = &view->lights[i];
        sum += light->intensity * m->diffuse * fabs(iso_dot(n, light->direction));
        if (m->specular > 0)
            sum += light->intensity * m->specular * pow(fabs(iso_dot(n, half[i])), m->power);
    }
    return sum;
}

/* Computes shade(d) of scene/scene.h. */
double iso_shade(const iso_view *view, iso_vec3 n, iso_vec3 to_viewer)
{
    iso_vec3 half[ISO_MAX_LIGHTS];
    find_halves(view, to_viewer, half);
    return shade(view, n, half);
}

/* Returns q(x) of fit/extinction_scale.h, or 1 without a scale. */
static double extinction_scale_at(const layer *l, iso_vec3 p)
{
    return l->extinction_scale ? iso_extinction_scale_of(iso_sample_bytes(l->sampler, l->extinction_scale, p)) : 1;
}

static double classify(const layer *l, iso_vec3 p, double rgbs[4])
{
    double s = iso_sample_scalar(l->sampler, p);
    if (l->tf_2d)
        iso_tf_2d_lookup(l->tf_2d, s, iso_tf_2d_row_of(iso_sample_bytes(l->sampler, l->tf_2d->bytes, p)), rgbs);
    else
        iso_tf_lookup(l->tf, s, rgbs);
    if (rgbs[3] > 0)
        rgbs[3] *= extinction_scale_at(l, p);
    return s;
}

double iso_reference_classify(const iso_sampler *sampler, const iso_view *view, iso_vec3 index, double rgbs[4])
{
    const layer l = {.sampler = sampler,
                     .tf = &view->tf,
                     .tf_2d = view->tf_2d,
                     .extinction_scale = view->extinction_scale,
                     .scale = 1};
    return classify(&l, index, rgbs);
}

static iso_vec3 layer_point(const ray_state *ray, const layer *l, double t)
{
    iso_vec3 p = iso_madd(ray->origin, ray->direction, t);
    return iso_v3(l->scale * p.x - l->offset[0], l->scale * p.y - l->offset[1], l->scale * p.z - l->offset[2]);
}

/* Computes one layer's emission sigma c shade at t. Returns extinction sigma per mm. */
static double layer_emission(const ray_state *ray, const layer *l, double t, double color[3])
{
    iso_vec3 p = layer_point(ray, l, t);
    double rgbs[4];
    classify(l, p, rgbs);
    double scale = 0;
    if (rgbs[3] > 0)
        scale = rgbs[3] * shade(ray->view, iso_sample_normal(l->sampler, p), ray->half);
    for (int c = 0; c < 3; ++c)
        color[c] = scale * rgbs[c];
    return rgbs[3];
}

/* Computes the same for all layers: two media in one place (roi.h). */
static double emission(const ray_state *ray, double t, double color[3])
{
    if (ray->emitter)
        return ray->emitter->emit(ray->emitter,
                                  &(iso_emitter_place){ray->view, ray->layer->sampler,
                                                       iso_madd(ray->origin, ray->direction, t), ray->to_viewer},
                                  color);
    double w = ray->roi ? iso_roi_weight(ray->view->roi, iso_madd(ray->origin, ray->direction, t)) : 0, inside[3];
    if (w <= 0)
        return layer_emission(ray, ray->layer, t, color);
    double sigma = w * layer_emission(ray, ray->roi, t, inside);
    double around = w < 1 ? (1 - w) * layer_emission(ray, ray->layer, t, color) : 0;
    for (int c = 0; c < 3; ++c)
        color[c] = w * inside[c] + (w < 1 ? (1 - w) * color[c] : 0);
    return sigma + around;
}

/* Returns the t at which the ray leaves the largest empty block around it; t itself if there is none. */
static double leave_empty_block(const ray_state *ray, double t)
{
    if (!ray->empty->seen[0])
        return t;
    const double p[3] = {ray->origin.x + t * ray->direction.x, ray->origin.y + t * ray->direction.y,
                         ray->origin.z + t * ray->direction.z};
    const double d[3] = {ray->direction.x, ray->direction.y, ray->direction.z};
    int cell[3], lo[3], hi[3];
    for (int a = 0; a < 3; ++a)
        cell[a] = (int)fmin(fmax(floor(p[a] + 0.5), 0), (double)(ray->empty->cells[a] - 1));
    if (!iso_empty_space_at(ray->empty, cell, lo, hi))
        return t;
    double end = INFINITY;
    for (int a = 0; a < 3; ++a)
        if (d[a] != 0) /* cells end half an index before their number */
            end = fmin(end, t + ((d[a] > 0 ? hi[a] : lo[a]) - 0.5 - p[a]) / d[a]);
    return fmax(end, t);
}

/* Composes front over back. */
static stretch compose(stretch front, stretch back)
{
    double t = exp(-front.depth);
    for (int c = 0; c < 3; ++c)
        front.color[c] += t * back.color[c];
    front.depth += back.depth;
    return front;
}

/* Sums n equal intervals, samples in the middle, weight ds exp(-sigma ds / 2): POV-Ray's method 2. */
static stretch sum_intervals(const ray_state *ray, double a, double b, size_t n)
{
    stretch s = {{0}, 0};
    double ds = (b - a) / (double)n;
    for (size_t i = 0; i < n; ++i) {
        double color[3];
        double sigma = emission(ray, a + ((double)i + 0.5) * ds, color);
        double weight = ds * exp(-(s.depth + 0.5 * sigma * ds));
        for (int c = 0; c < 3; ++c)
            s.color[c] += weight * color[c];
        s.depth += sigma * ds;
    }
    return s;
}

/* Returns (4 fine - coarse) / 3, which removes the error's term in ds^2. */
static stretch extrapolate(stretch fine, stretch coarse)
{
    for (int c = 0; c < 3; ++c)
        fine.color[c] += (fine.color[c] - coarse.color[c]) / 3;
    fine.depth += (fine.depth - coarse.depth) / 3;
    return fine;
}

static double distance(stretch a, stretch b)
{
    double d = fabs(a.depth - b.depth);
    for (int c = 0; c < 3; ++c)
        d = fmax(d, fabs(a.color[c] - b.color[c]));
    return d;
}

/* Returns the ray's place at t on the layer's table, in entries. */
static double entry_at(const ray_state *ray, const layer *l, double t)
{
    const iso_tf_table *tf = l->tf;
    double s = iso_sample_scalar(l->sampler, layer_point(ray, l, t));
    return (s - tf->lo) / (tf->hi - tf->lo) * (double)(tf->count - 1);
}

/* Returns the place to cut [a, b] for a bend of the TF inside it; a if there is none. The cut is in the middle until
 * one bend is singled out, then at the bend. Otherwise samples could miss a shell of opacity between them. */
static double cut_at_bend(const ray_state *ray, const layer *l, double a, double b)
{
    enum { few = 4, bisections = 40 };
    const size_t *bends = l->bends;
    const double slack = 1e-6, last = (double)(l->tf->count - 1), middle = 0.5 * (a + b);
    double at_a = entry_at(ray, l, a), at_middle = entry_at(ray, l, middle), at_b = entry_at(ray, l, b);
    double lo = fmin(at_a, fmin(at_middle, at_b)) + slack, hi = fmax(at_a, fmax(at_middle, at_b)) - slack;
    double first = ceil(fmax(lo, 0)), end = floor(fmin(hi, last));
    if (!(first <= end) || bends[(size_t)end + 1] == bends[(size_t)first])
        return a;
    if (hi - lo > few || (at_middle - at_a) * (at_b - at_middle) < 0)
        return middle;
    size_t bend = (size_t)first;
    while (bends[bend + 1] == bends[bend])
        ++bend;
    for (int i = 0; i < bisections; ++i) {
        double t = 0.5 * (a + b);
        if ((entry_at(ray, l, t) < (double)bend) == (at_a < at_b))
            a = t;
        else
            b = t;
    }
    return 0.5 * (a + b);
}

/* Integrates a piece that is smooth between cell borders and bends of the TF; halves it until its extrapolation is
 * accurate. weight is the transmittance in front of the piece, so that hidden pieces are not refined. At a kink of
 * |n.l| or a slight bend two sums can agree by chance: their difference has to be well below the tolerance. */
static stretch integrate_piece(const ray_state *ray, double a, double b, double weight, double tolerance, int depth,
                               double *error)
{
    enum { max_depth = 24 };
    static const double caution = 0.01;
    stretch two = sum_intervals(ray, a, b, 2), four = sum_intervals(ray, a, b, 4);
    stretch coarse = extrapolate(two, sum_intervals(ray, a, b, 1)), fine = extrapolate(four, two);
    if (depth >= max_depth || weight <= tolerance) {
        *error += weight * distance(fine, coarse);
        return fine;
    }
    double cut = ray->emitter ? a : cut_at_bend(ray, ray->layer, a, b); /* an emitter has no bends */
    if (!(cut > a && cut < b) && ray->roi)
        cut = cut_at_bend(ray, ray->roi, a, b);
    if (!(cut > a && cut < b)) {
        if (weight * distance(fine, coarse) <= caution * tolerance) {
            *error += weight * distance(fine, coarse);
            return fine;
        }
        cut = 0.5 * (a + b);
    }
    stretch front = integrate_piece(ray, a, cut, weight, 0.5 * tolerance, depth + 1, error);
    stretch back = integrate_piece(ray, cut, b, weight * exp(-front.depth), 0.5 * tolerance, depth + 1, error);
    return compose(front, back);
}

/* Returns t from index position p to the next plane of voxel centers (i + 1/2). */
static double to_next_plane(double p, double d)
{
    if (d == 0)
        return INFINITY;
    double q = p - 0.5;
    double plane = d > 0 ? floor(q) + 1 : ceil(q) - 1;
    return (plane - q) / d;
}

/* Returns t to the next face of the region of interest or of its band. */
static double to_next_face(const iso_roi *f, iso_vec3 index, iso_vec3 direction)
{
    const double p[3] = {index.x, index.y, index.z}, d[3] = {direction.x, direction.y, direction.z};
    double least = INFINITY;
    for (int a = 0; a < 3; ++a) {
        const double faces[4] = {f->lo[a] - f->band, f->lo[a], f->hi[a], f->hi[a] + f->band};
        for (int i = 0; i < 4 && d[a] != 0; ++i) {
            double t = (faces[i] - p[a]) / d[a];
            least = t > 0 ? fmin(least, t) : least;
        }
    }
    return least;
}

/* Returns t to the next face of a voxel: labels change there, between the centers where directions bend. */
static double to_next_voxel(iso_vec3 p, iso_vec3 d)
{
    return fmin(to_next_plane(p.x + 0.5, d.x), fmin(to_next_plane(p.y + 0.5, d.y), to_next_plane(p.z + 0.5, d.z)));
}

/* Returns the end of the ray's piece that starts at a and stays in one cell of each layer. */
static double cell_end(const ray_state *ray, double a, double least, double t1)
{
    iso_vec3 p = iso_madd(ray->origin, ray->direction, a + least);
    double step = fmin(to_next_plane(p.x, ray->direction.x),
                       fmin(to_next_plane(p.y, ray->direction.y), to_next_plane(p.z, ray->direction.z)));
    if (ray->layer->sampler->level->labels)
        step = fmin(step, to_next_voxel(p, ray->direction));
    if (ray->roi) {
        const iso_roi *f = ray->view->roi;
        const iso_vec3 q = iso_roi_inside(f, p), d = iso_scale(ray->direction, f->scale);
        step = fmin(step, to_next_face(f, p, ray->direction));
        if (iso_roi_weight(f, p) > 0)
            step = fmin(step, fmin(to_next_plane(q.x, d.x), fmin(to_next_plane(q.y, d.y), to_next_plane(q.z, d.z))));
    }
    return fmin(a + least + step, t1);
}

/* Skips slivers of rounding at the planes; far below any tolerance. */
static const double least_piece = 1e-9;

static stretch integrate_converged(const ray_state *ray, double t0, double t1, double tolerance, double *error)
{
    stretch whole = {{0}, 0};
    for (double a = t0; a < t1;) {
        const double empty_until = leave_empty_block(ray, a + least_piece * (t1 - t0));
        if (empty_until > a + 2 * least_piece * (t1 - t0)) {
            a = empty_until;
            continue;
        }
        double b = cell_end(ray, a, least_piece * (t1 - t0), t1);
        double weight = exp(-whole.depth);
        if (weight < ISO_REFERENCE_LEFT) {
            *error += weight;
            break;
        }
        whole = compose(whole, integrate_piece(ray, a, b, weight, tolerance * (b - a) / (t1 - t0), 0, error));
        a = b > a ? b : t1;
    }
    return whole;
}

static double value_at(const ray_state *ray, double t)
{
    return iso_sample_scalar(ray->layer->sampler, iso_madd(ray->origin, ray->direction, t));
}

/* Returns the first t in [a, b], inside one cell, with a value of at least iso; infinite if there is none. The value is
 * a cubic of t: its Bezier points bound it, and intervals that they cannot exclude are halved. */
static double first_hit(const ray_state *ray, double iso, double a, double b, int depth)
{
    enum { max_depth = 44 };
    double s[4];
    for (int i = 0; i < 4; ++i)
        s[i] = value_at(ray, a + (b - a) * i / 3);
    const double inner[2] = {(-5 * s[0] + 18 * s[1] - 9 * s[2] + 2 * s[3]) / 6,
                             (2 * s[0] - 9 * s[1] + 18 * s[2] - 5 * s[3]) / 6};
    if (s[0] >= iso)
        return a;
    if (fmax(s[3], fmax(inner[0], inner[1])) < iso)
        return INFINITY;
    if (depth >= max_depth)
        return s[3] >= iso ? b : INFINITY;
    const double front = first_hit(ray, iso, a, 0.5 * (a + b), depth + 1);
    return isfinite(front) ? front : first_hit(ray, iso, 0.5 * (a + b), b, depth + 1);
}

/* Makes a hit opaque: the optical depth beyond it is infinite. */
static stretch hit_surface(const ray_state *ray, double t0, double t1, double iso, iso_surface_output output)
{
    stretch s = {{0}, 0};
    double t = INFINITY;
    for (double a = t0; a < t1 && !isfinite(t);) {
        double b = cell_end(ray, a, least_piece * (t1 - t0), t1);
        t = first_hit(ray, iso, a, b, 0);
        a = b > a ? b : t1;
    }
    if (!isfinite(t))
        return s;
    const iso_vec3 p = iso_madd(ray->origin, ray->direction, t);
    const iso_vec3 normal = output == ISO_SURFACE_POSITION ? p : iso_sample_normal(ray->layer->sampler, p);
    double rgbs[4];
    iso_tf_lookup(&ray->view->tf, iso, rgbs);
    const double light = iso_shade(ray->view, normal, ray->to_viewer), shown[3] = {normal.x, normal.y, normal.z};
    for (int c = 0; c < 3; ++c)
        s.color[c] = output == ISO_SURFACE_COLOR ? light * rgbs[c] : shown[c];
    s.depth = INFINITY;
    return s;
}

/* Integrates segments [k ds, (k+1) ds], clipped to the box, by the ray caster's midpoint rule: 1 - exp(-sigma
 * length). */
static stretch integrate_midpoint(const ray_state *ray, double t0, double t1, double ds)
{
    /* Beyond optical depth 40 transmittance is below 4.3e-18. */
    const double opaque = ray->plain ? INFINITY : 40;
    stretch s = {{0}, 0};
    for (double k = floor(t0 / ds); k * ds < t1 && s.depth < opaque; ++k) {
        double a = fmax(k * ds, t0), b = fmin((k + 1) * ds, t1), color[3];
        if (!(b > a))
            continue;
        double sigma = emission(ray, 0.5 * (a + b), color);
        if (sigma <= 0) {
            /* On to the last middle that is not beyond the block: those between show nothing. */
            const double end = leave_empty_block(ray, 0.5 * (a + b));
            k = fmax(k, fmin(floor(end / ds - 0.5), ceil(t1 / ds)) - 1);
            continue;
        }
        double weight = exp(-s.depth) * -expm1(-sigma * (b - a)) / sigma;
        for (int c = 0; c < 3; ++c)
            s.color[c] += weight * color[c];
        s.depth += sigma * (b - a);
    }
    return s;
}

/* Integrates the midpoint rule's segments with the TF's means between the values at their ends. */
static stretch integrate_means(const ray_state *ray, double t0, double t1, double ds)
{
    stretch s = {{0}, 0};
    double back = value_at(ray, t0);
    for (double k = floor(t0 / ds); k * ds < t1; ++k) {
        double a = fmax(k * ds, t0), b = fmin((k + 1) * ds, t1), front = back, mean[4];
        if (!(b > a))
            continue;
        back = value_at(ray, b);
        iso_tf_integral_mean(ray->integral, front, back, mean);
        if (mean[3] <= 0)
            continue;
        const iso_vec3 middle = iso_madd(ray->origin, ray->direction, 0.5 * (a + b));
        const double scale = extinction_scale_at(ray->layer, middle);
        for (int c = 0; c < 4; ++c)
            mean[c] *= scale;
        iso_vec3 normal = iso_sample_normal(ray->layer->sampler, middle);
        double depth = mean[3] * (b - a);
        double weight = exp(-s.depth) * -expm1(-depth) / mean[3] * iso_shade(ray->view, normal, ray->to_viewer);
        for (int c = 0; c < 3; ++c)
            s.color[c] += weight * mean[c];
        s.depth += depth;
    }
    return s;
}

/* Sums opt->intervals per piece. Planes across the view, at equal distances through the box, cut the pieces. */
static stretch integrate_pieces(const ray_state *ray, const iso_reference_options *opt, double t0, double t1)
{
    const iso_geometry *g = &ray->layer->sampler->level->geometry;
    const iso_vec3 forward = ray->view->camera.forward, start = iso_geometry_to_world(g, ray->origin);
    const double along = -iso_dot(ray->to_viewer, forward); /* of a millimeter of the ray */
    const double middle = iso_dot(iso_sub(iso_geometry_box_center_mm(g), start), forward);
    double reach = 0; /* half the extent of the box along the view */
    for (int a = 0; a < 3; ++a)
        reach += 0.5 * fabs(iso_dot(iso_column(g->index_to_world, a), forward)) * g->box_index[a];
    stretch s = {{0}, 0};
    double from = t0;
    for (size_t k = 1; k <= opt->planes; ++k) {
        const double at = (middle + reach * (2 * (double)k / (double)(opt->planes + 1) - 1)) / along;
        if (!(at > from && at < t1))
            continue;
        s = compose(s, sum_intervals(ray, from, at, opt->intervals));
        from = at;
    }
    return compose(s, sum_intervals(ray, from, t1, opt->intervals));
}

stretch iso_reference_integrate(ray_state *ray, const iso_reference_options *opt, double t0, double t1, double *error)
{
    find_halves(ray->view, ray->to_viewer, ray->half);
    const iso_geometry *g = &ray->layer->sampler->level->geometry, *finest = iso_view_step_geometry(ray->view, g);
    const double step = opt->step_voxels > 0 ? opt->step_voxels : ray->view->step_voxels;
    if (opt->quadrature == ISO_QUADRATURE_CONVERGED)
        return integrate_converged(ray, t0, t1, opt->tolerance, error);
    if (opt->quadrature == ISO_QUADRATURE_MIDPOINT)
        return integrate_midpoint(ray, t0, t1, step * iso_geometry_min_spacing_mm(finest));
    if (opt->quadrature == ISO_QUADRATURE_PREINTEGRATED)
        return integrate_means(ray, t0, t1, step * iso_geometry_min_spacing_mm(g));
    if (opt->quadrature == ISO_QUADRATURE_FIRST_HIT)
        return hit_surface(ray, t0, t1, opt->iso, opt->output);
    return integrate_pieces(ray, opt, t0, t1);
}
