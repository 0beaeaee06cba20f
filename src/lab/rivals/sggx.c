/* SPDX-License-Identifier: MIT */
/* sggx.c - directions of a voxel as a distribution of microflakes [heitz-2015]. */
#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "lab/rivals/rivals.h"
#include "render/reference_ray.h"
#include "render/sampler.h"

/* ---- the distribution ---- */

static const double half = 0.70710678118654752;

void iso_sggx_add(iso_sggx_sums *sums, iso_vec3 n, double weight)
{
    const iso_vec3 along[6] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {half, half, 0}, {half, 0, half}, {0, half, half}};
    sums->weight += weight;
    for (int i = 0; i < 6; ++i)
        sums->areas[i] += weight * fabs(iso_dot(n, along[i]));
}

/* Fits sigma(w)^2 = w.S w exactly at the six directions; sigma((x + y) / sqrt 2)^2 = (S_xx + S_yy) / 2 + S_xy. If the
 * six do not belong to one ellipsoid, the matrix may have a negative eigenvalue; the off-diagonals are clamped. */
void iso_sggx_matrix(const iso_sggx_sums *sums, double s[6])
{
    static const int first[3] = {0, 0, 1}, second[3] = {1, 2, 2};
    double squares[6];
    for (int i = 0; i < 6; ++i) {
        const double area = sums->weight > 0 ? sums->areas[i] / sums->weight : 0;
        squares[i] = area * area;
    }
    for (int i = 0; i < 3; ++i)
        s[i] = squares[i];
    for (int i = 0; i < 3; ++i) {
        const double most = sqrt(s[first[i]] * s[second[i]]);
        s[3 + i] = fmin(fmax(squares[3 + i] - 0.5 * (s[first[i]] + s[second[i]]), -most), most);
    }
}

static double quadratic(const double s[6], iso_vec3 a, iso_vec3 b)
{
    return s[0] * a.x * b.x + s[1] * a.y * b.y + s[2] * a.z * b.z + s[3] * (a.x * b.y + a.y * b.x) +
           s[4] * (a.x * b.z + a.z * b.x) + s[5] * (a.y * b.z + a.z * b.y);
}

/* Samples visible normals as the paper does, at fixed points of the unit disk, of equal area. Appendix: m = u M_k + v
 * M_j + w M_i of a point (u, v, w) of the hemisphere over the disk, M M^T = S. */
double iso_sggx_diffuse(const double s[6], iso_vec3 view, iso_vec3 light)
{
    enum { rings = 3, spokes = 6 };
    const iso_vec3 helper = fabs(view.x) < 0.6 ? iso_v3(1, 0, 0) : iso_v3(0, 1, 0);
    const iso_vec3 k = iso_normalize(iso_cross(helper, view)), j = iso_cross(view, k);
    const double ii = quadratic(s, view, view), size = s[0] + s[1] + s[2];
    if (!(ii > 1e-9 * size) || !(size > 0))
        return 0;
    const double ki = quadratic(s, k, view), ji = quadratic(s, j, view);
    const double jj = fmax(quadratic(s, j, j) - ji * ji / ii, 0), kj = quadratic(s, k, j) - ki * ji / ii;
    const double kk = quadratic(s, k, k) - ki * ki / ii, root = sqrt(jj);
    const double across = root > 1e-6 ? kj / root : 0, left = sqrt(fmax(kk - across * across, 0));
    double sum = 0;
    for (int ring = 0; ring < rings; ++ring)
        for (int spoke = 0; spoke < spokes; ++spoke) {
            const double radius = sqrt((ring + 0.5) / rings),
                         angle = 6.283185307179586 * (spoke + 0.25 * ring) / spokes;
            const double u = radius * cos(angle), v = radius * sin(angle), w = sqrt(fmax(1 - radius * radius, 0));
            const double at_k = u * left + v * across + w * ki / sqrt(ii), at_j = v * root + w * ji / sqrt(ii);
            const iso_vec3 m = iso_madd(iso_madd(iso_scale(k, at_k), j, at_j), view, w * sqrt(ii));
            sum += fabs(iso_dot(iso_normalize(m), light));
        }
    return sum / (rings * spokes);
}

/* ---- the field ---- */

static double emit(const iso_emitter *e, const iso_emitter_place *at, double color[3])
{
    double rgbs[4], s[6], shade = at->view->shading.ambient;
    iso_tf_lookup(&at->view->tf, iso_sample_scalar(at->sampler, at->index), rgbs);
    color[0] = color[1] = color[2] = 0;
    if (!(rgbs[3] > 0))
        return 0;
    iso_sample_floats(at->sampler, e->field, 6, at->index, s); /* xx, yy, zz, xy, xz, yz of each voxel */
    for (size_t i = 0; i < at->view->light_count && at->view->shading.diffuse > 0; ++i)
        shade += at->view->lights[i].intensity * at->view->shading.diffuse *
                 iso_sggx_diffuse(s, at->to_viewer, at->view->lights[i].direction);
    for (int c = 0; c < 3; ++c)
        color[c] = rgbs[3] * shade * rgbs[c];
    return rgbs[3];
}

/* Returns the squared length of the central differences, in value per mm. */
static double magnitude_squared(const iso_level *l, iso_mat3 to_world, size_t x, size_t y, size_t z)
{
    const size_t *n = l->geometry.size, at[3] = {x, y, z}, stride[3] = {1, n[0], n[0] * n[1]};
    const size_t i = x + n[0] * (y + n[1] * z);
    double g[3];
    for (int a = 0; a < 3; ++a) {
        const size_t up = at[a] + 1 < n[a] ? i + stride[a] : i, down = at[a] > 0 ? i - stride[a] : i;
        g[a] = up > down ? ((double)l->scalar[up] - (double)l->scalar[down]) / (double)((up - down) / stride[a]) : 0;
    }
    const iso_vec3 v = iso_mul(to_world, iso_v3(g[0], g[1], g[2]));
    return iso_dot(v, v);
}

static void matrix_of_box(const iso_sampler *fine, iso_mat3 to_world, const iso_fine_box *b, float out[6])
{
    const size_t *n = fine->level->geometry.size;
    iso_sggx_sums sums = {0};
    double s[6];
    for (size_t z = b->lo[2]; z < b->hi[2]; ++z)
        for (size_t y = b->lo[1]; y < b->hi[1]; ++y)
            for (size_t x = b->lo[0]; x < b->hi[0]; ++x) {
                float d[3];
                iso_sampler_vector(fine, x + n[0] * (y + n[1] * z), d);
                const iso_vec3 direction = iso_normalize(iso_v3((double)d[0], (double)d[1], (double)d[2]));
                if (iso_norm(direction) > 0)
                    iso_sggx_add(&sums, direction, magnitude_squared(fine->level, to_world, x, y, z));
            }
    iso_sggx_matrix(&sums, s);
    for (int i = 0; i < 6; ++i)
        out[i] = (float)s[i];
}

iso_status iso_rival_sggx(const iso_level_subject *s, iso_rival *r, iso_error *err)
{
    const size_t count = iso_geometry_voxel_count(&s->pyramid->levels[s->level].geometry);
    const iso_mat3 to_world = iso_geometry_gradient_to_world(&s->pyramid->levels[0].geometry);
    iso_sampler fine;
    iso_status status = iso_sampler_create(&fine, &s->pyramid->levels[0], s->pyramid->options.code, ISO_FROM_DECODED,
                                           err);
    float *matrices = status == ISO_OK ? malloc(6 * count * sizeof *matrices) : NULL;
    if (status == ISO_OK && !matrices)
        status = iso_fail(err, ISO_E_MEMORY, "no memory for the matrices of %zu voxels", count);
    const int threads = iso_threads(s->threads);
    if (status == ISO_OK) {
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads)
        for (size_t i = 0; i < count; ++i) {
            const iso_fine_box box = iso_fine_box_of(s->pyramid, s->level, i);
            matrix_of_box(&fine, to_world, &box, matrices + 6 * i);
        }
        *r = (iso_rival){{emit, matrices}, matrices, free};
    }
    iso_sampler_destroy(&fine);
    return status;
}
