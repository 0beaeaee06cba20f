/* SPDX-License-Identifier: MIT */
/* faults.c - failures that no option produces, planted in the level's data. */
#include <math.h>

#include "brick/bricks.h"
#include "atlas/atlas.h"
#include "encode/decode_double.h"

static iso_vec3 center_of(const iso_geometry *g, size_t i)
{
    return iso_v3((double)(i % g->size[0]) + 0.5, (double)(i / g->size[0] % g->size[1]) + 0.5,
                  (double)(i / (g->size[0] * g->size[1])) + 0.5);
}

static void put_direction(iso_level *l, size_t i, iso_vec3 n)
{
    float *d = l->directions + 3 * i;
    d[0] = (float)n.x, d[1] = (float)n.y, d[2] = (float)n.z;
}

iso_status iso_atlas_true_normals(const iso_atlas_scene *scene, iso_pyramid *p, size_t level, iso_error *err)
{
    (void)err;
    iso_level *l = &p->levels[level];
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        iso_vec3 n;
        scene->field(iso_geometry_to_world(&l->geometry, center_of(&l->geometry, i)), &n);
        put_direction(l, i, n);
    }
    return ISO_OK;
}

/* Stores index gradients without the inverse transpose that covariant gradients need. */
iso_status iso_atlas_index_gradients(const iso_atlas_scene *scene, iso_pyramid *p, size_t level, iso_error *err)
{
    (void)scene;
    (void)err;
    iso_level *l = &p->levels[level];
    double mm[3];
    iso_geometry_spacing_mm(&l->geometry, mm);
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        const float *d = l->directions + 3 * i;
        put_direction(l, i, iso_normalize(iso_v3((double)d[0] * mm[0], (double)d[1] * mm[1], (double)d[2] * mm[2])));
    }
    return ISO_OK;
}

iso_status iso_atlas_folded_codes(const iso_atlas_scene *scene, iso_pyramid *p, size_t level, iso_error *err)
{
    (void)scene;
    iso_level *l = &p->levels[level];
    NEED(iso_code_from_name("oct24", &p->options.code, err));
    iso_code_encode(p->options.code, l->directions, l->codes, iso_geometry_voxel_count(&l->geometry));
    return ISO_OK;
}

/* ---- two angles ---- */

/* Converts azimuth and cosine of the polar angle to a unit vector. */
static iso_vec3 from_angles(double azimuth, double z)
{
    double r = sqrt(fmax(1 - z * z, 0));
    return iso_v3(r * cos(azimuth), r * sin(azimuth), z);
}

/* Interpolates the direction at a voxel from the eight stored directions around it, as vectors or as angles. The stored
 * grid is four times coarser. */
static iso_vec3 filtered_direction(const iso_atlas_scene *scene, const iso_geometry *g, size_t voxel, bool angles)
{
    enum { coarse = 4 };
    const iso_vec3 at = center_of(g, voxel);
    const double x[3] = {at.x / coarse - 0.5, at.y / coarse - 0.5, at.z / coarse - 0.5};
    iso_vec3 vector = {0, 0, 0};
    double azimuth = 0, cosine = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
        double weight = 1, q[3];
        for (int a = 0; a < 3; ++a) {
            double f = x[a] - floor(x[a]);
            q[a] = (floor(x[a]) + (corner >> a & 1) + 0.5) * coarse;
            weight *= corner >> a & 1 ? f : 1 - f;
        }
        iso_vec3 n;
        scene->field(iso_geometry_to_world(g, iso_v3(q[0], q[1], q[2])), &n);
        vector = iso_madd(vector, n, weight);
        azimuth += weight * atan2(n.y, n.x);
        cosine += weight * n.z;
    }
    return angles ? from_angles(azimuth, cosine) : iso_normalize(vector);
}

static void filter_from_coarse(const iso_atlas_scene *scene, iso_level *l, bool angles)
{
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i)
        put_direction(l, i, filtered_direction(scene, &l->geometry, i, angles));
}

iso_status iso_atlas_coarse_angles(const iso_atlas_scene *scene, iso_pyramid *p, size_t level, iso_error *err)
{
    (void)err;
    filter_from_coarse(scene, &p->levels[level], true);
    return ISO_OK;
}

iso_status iso_atlas_coarse_vectors(const iso_atlas_scene *scene, iso_pyramid *p, size_t level, iso_error *err)
{
    (void)err;
    filter_from_coarse(scene, &p->levels[level], false);
    return ISO_OK;
}

/* ---- lambda of Eq. 2 ---- */

/* Computes [diaz-garcia-2017] Eq. 2, for sorted lattice points e.x >= e.y >= e.z >= 0; not normalized. */
static iso_vec3 equation2(double lambda, iso_vec3 e)
{
    double t[3] = {1 - e.y / e.x, (e.y - e.z) / e.x, e.z / e.x};
    for (int i = 0; i < 3; ++i)
        t[i] = lambda * t[i] * t[i] + (1 - lambda) * t[i];
    return iso_v3(t[0] + t[1] + t[2], t[1] + t[2], t[2]);
}

static double inverse_of_equation2(double lambda, double y)
{
    const double k = 1 - lambda;
    return y > 0 ? 2 * y / (k + sqrt(k * k + 4 * lambda * y)) : 0;
}

/* Inverts Eq. 2: the lattice direction (1, b, c) moved to sorted d. The unknown is its scale. */
static iso_vec3 before_equation2(double lambda, iso_vec3 d)
{
    const double u = (d.x - d.y) / d.x, v = (d.y - d.z) / d.x, w = d.z / d.x;
    double lo = 0, hi = 1;
    for (int i = 0; i < 50; ++i) {
        double s = 0.5 * (lo + hi);
        double sum = inverse_of_equation2(lambda, s * u) + inverse_of_equation2(lambda, s * v) +
                     inverse_of_equation2(lambda, s * w);
        *(sum < 1 ? &lo : &hi) = s;
    }
    double c = inverse_of_equation2(lambda, hi * w);
    return iso_v3(1, c + inverse_of_equation2(lambda, hi * v), c);
}

/* Finds the stored direction nearest to sorted d: odd components up to 255, all lengths, all roundings. */
static iso_vec3 nearest_of_48_regions(double lambda, iso_vec3 d)
{
    const iso_vec3 t = before_equation2(lambda, d);
    iso_vec3 best = d;
    double least = INFINITY;
    for (double a = 255; a > 85; a -= 2)
        for (int i = 0; i < 9; ++i) {
            double b = 2 * floor(a * t.y / 2) + 1 + 2 * (i % 3 - 1), c = 2 * floor(a * t.z / 2) + 1 + 2 * (i / 3 - 1);
            if (b > a || c > b || c < 1)
                continue;
            iso_vec3 stored = iso_normalize(equation2(lambda, iso_v3(a, b, c))), off = iso_sub(stored, d);
            if (iso_dot(off, off) < least) {
                least = iso_dot(off, off);
                best = stored;
            }
        }
    return best;
}

iso_status iso_atlas_draw_holes(const iso_volume *v, iso_atlas_which which, iso_image *image, double *value,
                                iso_error *err)
{
    const double lambda = which == ISO_ATLAS_FAILURE ? 0 : ISO_REGION48_LAMBDA, degree = 0.017453292519943295;
    const double reach = 1.5 * degree, brightest = 0.35;
    (void)v;
    *value = 0;
    NEED(iso_image_create(image, ISO_ATLAS_PIXELS, ISO_ATLAS_PIXELS, err));
    for (size_t i = 0; i < ISO_ATLAS_PIXELS * ISO_ATLAS_PIXELS; ++i) {
        double y = fabs(((double)(i % ISO_ATLAS_PIXELS) + 0.5) / ISO_ATLAS_PIXELS * 2 - 1) * reach;
        double z = fabs(((double)(i / ISO_ATLAS_PIXELS) + 0.5) / ISO_ATLAS_PIXELS * 2 - 1) * reach;
        /* The code is symmetric: the chamber x >= y >= z >= 0 is enough. */
        const iso_vec3 d = iso_normalize(iso_v3(1, fmax(y, z), fmin(y, z)));
        const iso_vec3 off = iso_sub(which == ISO_ATLAS_RIGHT ? d : nearest_of_48_regions(lambda, d), d);
        const double angle = 2 * asin(0.5 * iso_norm(off)) / degree;
        for (size_t c = 0; c < 3; ++c)
            image->rgba[4 * i + c] = (float)(angle / brightest);
        image->rgba[4 * i + 3] = 1;
        *value = fmax(*value, angle);
    }
    return ISO_OK;
}

/* ---- bricks ---- */

/* Draws a cut as gray values. The left half lies in a fine brick, the right half in a coarse one. */
static iso_status show_cut(const iso_brick_field *f, iso_image *image, double *jump, iso_error *err)
{
    const double face = (double)f->nodes->brick_voxels, tiny = 1e-7, n = ISO_ATLAS_PIXELS;
    NEED(iso_image_create(image, ISO_ATLAS_PIXELS, ISO_ATLAS_PIXELS, err));
    *jump = 0;
    for (size_t i = 0; i < ISO_ATLAS_PIXELS * ISO_ATLAS_PIXELS; ++i) {
        double u = ((double)(i % ISO_ATLAS_PIXELS) + 0.5) / n, w = ((double)(i / ISO_ATLAS_PIXELS) + 0.5) / n;
        double v[ISO_NODE_CHANNELS], left[ISO_NODE_CHANNELS], right[ISO_NODE_CHANNELS];
        iso_brick_sample(f, iso_v3(face + 8 * (u - 0.5) + 0.5, 8 * w + 0.5, 6.3), v);
        iso_brick_sample(f, iso_v3(face - tiny + 0.5, 8 * w + 0.5, 6.3), left);
        iso_brick_sample(f, iso_v3(face + tiny + 0.5, 8 * w + 0.5, 6.3), right);
        for (size_t c = 0; c < 3; ++c)
            image->rgba[4 * i + c] = (float)v[0];
        image->rgba[4 * i + 3] = 1;
        *jump = fmax(*jump, fabs(left[0] - right[0]));
    }
    return ISO_OK;
}

iso_status iso_atlas_cut_bricks(const iso_volume *v, iso_atlas_which which, iso_image *image, double *value,
                                iso_error *err)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    OWNED(iso_pyramid) p = {0};
    OWNED(iso_node_levels) nodes = {0};
    uint8_t levels[64] = {0};
    build.level_count = 1;
    NEED(iso_pyramid_build(v, "atlas", &build, &p, NULL, err));
    NEED(iso_node_levels_create(&nodes, &p.levels[0], 8, 2, false, 0, err));
    for (size_t b = 0; which != ISO_ATLAS_RIGHT && b < iso_brick_count(&nodes) && b < sizeof levels; ++b)
        levels[b] = b % nodes.count[0] > 0; /* the first column of bricks is fine */
    const iso_brick_field f = {.nodes = &nodes,
                               .levels = levels,
                               .faces = which == ISO_ATLAS_FAILURE ? ISO_FACES_OWN : ISO_FACES_BAKED};
    return show_cut(&f, image, value, err);
}
