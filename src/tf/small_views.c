/* SPDX-License-Identifier: MIT */
#include "tf/small_views.h"

#include <math.h>

#include "base/parallel.h"
#include "compare/ssim.h"

enum { PIXELS = ISO_SMALL_VIEWS_PIXELS };

/* A ray ends below this transmittance: half a step of 8 bits, enlarged 16 times. */
#define OPAQUE 1e-4

/* An orthographic camera in the index space of level 0. */
typedef struct small_camera {
    iso_vec3 corner, right, down, direction; /* first pixel's center; steps between pixels; ray step */
    double step_mm;
    long step_count;
} small_camera;

/* Returns v / 3, mirrored along one axis of the world; axis 0: not mirrored. */
static iso_vec3 turn(iso_vec3 v, int axis)
{
    return iso_v3((axis == 1 ? -v.x : v.x) / 3, (axis == 2 ? -v.y : v.y) / 3, (axis == 3 ? -v.z : v.z) / 3);
}

static const iso_vec3 directions[3][3] = {{{2, 2, -1}, {2, -1, 2}, {-1, 2, 2}},
                                          {{2, -1, 2}, {-1, 2, 2}, {2, 2, -1}},
                                          {{-1, 2, 2}, {2, 2, -1}, {2, -1, 2}}};

static small_camera frame_box(const iso_geometry *g, int view)
{
    const iso_vec3 center = iso_geometry_box_center_mm(g);
    iso_vec3 axes[3];
    double half[3] = {0}; /* half sizes of the box along the axes */
    for (int a = 0; a < 3; ++a)
        axes[a] = turn(directions[view % 3][a], view / 3);
    for (int corner = 0; corner < 8; ++corner) {
        const iso_vec3 index = iso_v3(corner & 1 ? g->box_index[0] : 0, corner & 2 ? g->box_index[1] : 0,
                                      corner & 4 ? g->box_index[2] : 0);
        for (int a = 0; a < 3; ++a)
            half[a] = fmax(half[a], fabs(iso_dot(axes[a], iso_sub(iso_geometry_to_world(g, index), center))));
    }
    const double extent = fmax(half[1], half[2]), pixel = 2 * extent / PIXELS;
    const iso_mat3 to_index = iso_mat3_inverse(g->index_to_world);
    small_camera c = {.step_mm = iso_geometry_min_spacing_mm(g)};
    iso_vec3 corner = iso_madd(center, axes[0], 0.5 * c.step_mm - half[0]);
    for (int a = 1; a < 3; ++a)
        corner = iso_madd(corner, axes[a], 0.5 * pixel - extent);
    c.step_count = (long)ceil(2 * half[0] / c.step_mm);
    c.corner = iso_geometry_to_index(g, corner);
    c.direction = iso_mul(to_index, iso_scale(axes[0], c.step_mm));
    c.right = iso_mul(to_index, iso_scale(axes[1], pixel));
    c.down = iso_mul(to_index, iso_scale(axes[2], pixel));
    return c;
}

/* Clips a ray from p to the box: its steps are [*first, *last]; none if *first > *last. */
static void clip_to_box(const small_camera *c, const iso_geometry *g, iso_vec3 p, long *first, long *last)
{
    const double at[3] = {p.x, p.y, p.z}, d[3] = {c->direction.x, c->direction.y, c->direction.z};
    double t0 = 0, t1 = (double)c->step_count;
    for (int a = 0; a < 3; ++a) {
        if (fabs(d[a]) < 1e-12) {
            t1 = at[a] < 0 || at[a] > g->box_index[a] ? -1 : t1;
            continue;
        }
        const double near = -at[a] / d[a], far = (g->box_index[a] - at[a]) / d[a];
        t0 = fmax(t0, fmin(near, far));
        t1 = fmin(t1, fmax(near, far));
    }
    *first = (long)ceil(t0);
    *last = t1 < t0 ? *first - 1 : (long)floor(t1);
}

/* A place between voxel centers at i + 1/2, clamped to the edge: index of the first of its eight voxels, offsets to the
 * others, and fractions between them. */
typedef struct place {
    size_t first, step[3];
    double f[3];
} place;

static place find_place(const iso_geometry *g, const double index[3])
{
    const size_t *n = g->size;
    place p = {.step = {1, n[0], n[0] * n[1]}};
    size_t i[3];
    for (int a = 0; a < 3; ++a) {
        const double last = (double)(n[a] - 1);
        double x = index[a] - 0.5;
        x = x > 0 ? (x < last ? x : last) : 0;
        i[a] = (size_t)x;
        p.f[a] = x - (double)i[a];
        p.step[a] = i[a] + 1 < n[a] ? p.step[a] : 0;
    }
    p.first = i[0] + n[0] * (i[1] + n[1] * i[2]);
    return p;
}

static double sample(const float *values, const place *p)
{
    const float *v = values + p->first;
    double rows[4];
    for (size_t row = 0; row < 4; ++row) {
        const float *r = v + (row & 1) * p->step[1] + (row >> 1) * p->step[2];
        rows[row] = (double)r[0] + p->f[0] * ((double)r[p->step[0]] - (double)r[0]);
    }
    const double near = rows[0] + p->f[1] * (rows[1] - rows[0]), far = rows[2] + p->f[1] * (rows[3] - rows[2]);
    return near + p->f[2] * (far - near);
}

static double sample_bytes(const uint8_t *bytes, const place *p)
{
    double sum = 0;
    for (size_t corner = 0; corner < 8; ++corner) {
        size_t at = p->first;
        double weight = 1;
        for (size_t a = 0; a < 3; ++a) {
            const bool high = corner >> a & 1;
            at += high ? p->step[a] : 0;
            weight *= high ? p->f[a] : 1 - p->f[a];
        }
        sum += weight * bytes[at];
    }
    return sum;
}

/* Adds a step to a pixel, front to back, and returns its visible opacity; pixel[3] is the transmittance. */
static double add_step(const double rgbs[4], double length_mm, double pixel[4])
{
    if (rgbs[3] <= 0 || pixel[3] <= OPAQUE)
        return 0;
    const double through = exp(-rgbs[3] * length_mm), seen = pixel[3] * (1 - through);
    for (int c = 0; c < 3; ++c)
        pixel[c] += seen * rgbs[c];
    pixel[3] *= through;
    return seen;
}

/* Looks up the coarse level at a place through transfer function i: color and extinction. The level's own scale counts
 * if it is the share of voxels with data. */
static void look_up(const iso_small_views_input *in, size_t i, const place *p, double value, double rgbs[4])
{
    if (in->tfs_2d[i])
        iso_tf_2d_lookup(in->tfs_2d[i], value, iso_tf_2d_row_of(sample_bytes(in->tfs_2d[i]->bytes, p)), rgbs);
    else
        iso_tf_lookup(in->tfs[i], value, rgbs);
    if (in->coarse->geometry.has_no_data && in->coarse->scale && rgbs[3] > 0)
        rgbs[3] *= iso_extinction_scale_of(sample_bytes(in->coarse->scale, p));
    if (in->octaves[i] && rgbs[3] > 0)
        rgbs[3] *= exp2(sample(in->octaves[i], p));
}

/* Returns the mask's byte of the coarse voxel that holds the index; 0 without a mask. */
static uint8_t emptiness(const iso_small_views_input *in, const double index[3])
{
    if (!in->empty)
        return 0;
    size_t i[3];
    for (int a = 0; a < 3; ++a) {
        const size_t n = in->coarse->geometry.size[a];
        i[a] = index[a] > 0 ? (size_t)index[a] : 0;
        i[a] = i[a] < n ? i[a] : n - 1;
    }
    return in->empty[i[0] + in->coarse->geometry.size[0] * (i[1] + in->coarse->geometry.size[1] * i[2])];
}

static void add_atomic(int64_t *sum, double seen)
{
    const int64_t more = llround(seen / ISO_SMALL_VIEWS_UNIT);
#pragma omp atomic
    *sum += more;
}

/* Adds `seen` to the two entries around the value, in proportion to their shares of the extinction. */
static void note_rows(const iso_tf_table *tf, const iso_small_views_rows *rows, double value, double seen, bool ghost)
{
    const double last = (double)(tf->count - 1), x = (value - tf->lo) / (tf->hi - tf->lo) * last;
    const double at = x > 0 ? (x < last ? x : last) : 0;
    const size_t i = at < last ? (size_t)at : tf->count - 2;
    const double f = at - (double)i, low = (1 - f) * (double)tf->entries[4 * i + 3];
    const double part = low / (low + f * (double)tf->entries[4 * i + 7]);
    for (size_t k = 0; k < 2; ++k) {
        const double more = seen * (k == 0 ? part : 1 - part);
        add_atomic(rows->seen + i + k, more);
        if (ghost)
            add_atomic(rows->ghost + i + k, more);
    }
}

/* Computes a pixel of level 0: premultiplied color and transmittance. */
static void march_fine(const iso_small_views_input *in, const small_camera *c, iso_vec3 from, double pixel[4])
{
    const double scale = ldexp(1, -(int)in->level);
    double rgbs[4];
    long first, last;
    clip_to_box(c, &in->fine->geometry, from, &first, &last);
    for (long k = first; k <= last && pixel[3] > OPAQUE; ++k) {
        const iso_vec3 p = iso_madd(from, c->direction, (double)k);
        if (emptiness(in, (double[]){scale * p.x, scale * p.y, scale * p.z}) == ISO_GHOST_CLEAR)
            continue;
        const place at = find_place(&in->fine->geometry, (double[]){p.x, p.y, p.z});
        iso_tf_lookup(in->original, sample(in->fine->scalar, &at), rgbs);
        add_step(rgbs, c->step_mm, pixel);
    }
}

/* Computes a pixel for each transfer function of the coarse level, and its opacity in voxels empty in level 0. */
static void march_coarse(const iso_small_views_input *in, const small_camera *c, iso_vec3 from,
                         double pixels[ISO_SMALL_VIEWS_MAX_TFS][4], double ghosts[ISO_SMALL_VIEWS_MAX_TFS])
{
    const double scale = ldexp(1, -(int)in->level);
    double rgbs[4];
    long first, last;
    clip_to_box(c, &in->fine->geometry, from, &first, &last);
    for (long k = first; k <= last; ++k) {
        const iso_vec3 p = iso_madd(from, c->direction, (double)k);
        const double coarse_index[3] = {scale * p.x, scale * p.y, scale * p.z};
        bool all_opaque = true;
        for (size_t i = 0; i < in->tf_count; ++i)
            all_opaque = all_opaque && pixels[i][3] <= OPAQUE;
        if (all_opaque)
            break;
        const place at = find_place(&in->coarse->geometry, coarse_index);
        const double value = sample(in->coarse->scalar, &at);
        const bool empty = emptiness(in, coarse_index) != 0;
        for (size_t i = 0; i < in->tf_count; ++i) {
            look_up(in, i, &at, value, rgbs);
            const double seen = add_step(rgbs, c->step_mm, pixels[i]);
            ghosts[i] += empty ? seen : 0;
            if (in->rows && i + 1 == in->tf_count && seen > 0)
                note_rows(in->tfs[i], in->rows, value, seen, empty);
        }
    }
}

static void set_pixel(iso_image *picture, int x, int y, const double pixel[4])
{
    float *to = picture->rgba + 4 * (size_t)(y * PIXELS + x);
    for (int k = 0; k < 3; ++k)
        to[k] = (float)pixel[k];
    to[3] = (float)(1 - pixel[3]);
}

static void draw_fine(const iso_small_views_input *in, int view, iso_image *picture, int64_t *shown)
{
    const small_camera c = frame_box(&in->fine->geometry, view);
#pragma omp parallel for schedule(dynamic, 4) num_threads(iso_threads(in->threads))
    for (int y = 0; y < PIXELS; ++y)
        for (int x = 0; x < PIXELS; ++x) {
            double pixel[4] = {0, 0, 0, 1};
            march_fine(in, &c, iso_madd(iso_madd(c.corner, c.right, x), c.down, y), pixel);
            set_pixel(picture, x, y, pixel);
            add_atomic(shown, 1 - pixel[3]);
        }
}

static void draw_coarse(const iso_small_views_input *in, int view, iso_image *pictures, int64_t *ghosts)
{
    const small_camera c = frame_box(&in->fine->geometry, view);
#pragma omp parallel for schedule(dynamic, 4) num_threads(iso_threads(in->threads))
    for (int y = 0; y < PIXELS; ++y)
        for (int x = 0; x < PIXELS; ++x) {
            double pixels[ISO_SMALL_VIEWS_MAX_TFS][4], ghost[ISO_SMALL_VIEWS_MAX_TFS];
            for (size_t i = 0; i < in->tf_count; ++i)
                pixels[i][0] = pixels[i][1] = pixels[i][2] = ghost[i] = 0, pixels[i][3] = 1;
            march_coarse(in, &c, iso_madd(iso_madd(c.corner, c.right, x), c.down, y), pixels, ghost);
            for (size_t i = 0; i < in->tf_count; ++i) {
                set_pixel(&pictures[i], x, y, pixels[i]);
                add_atomic(&ghosts[i], ghost[i]);
            }
        }
}

void iso_small_views_fine_destroy(iso_small_views_fine *fine)
{
    for (int view = 0; view < ISO_SMALL_VIEWS_COUNT; ++view)
        iso_image_destroy(&fine->views[view]);
    *fine = (iso_small_views_fine){0};
}

static iso_status draw_level_0(const iso_small_views_input *in, iso_small_views_fine *fine, iso_error *err)
{
    iso_status status = ISO_OK;
    for (int view = 0; view < ISO_SMALL_VIEWS_COUNT && status == ISO_OK && !fine->is_drawn; ++view) {
        status = iso_image_create(&fine->views[view], PIXELS, PIXELS, err);
        if (status == ISO_OK)
            draw_fine(in, view, &fine->views[view], &fine->shown);
    }
    fine->is_drawn = status == ISO_OK;
    return status;
}

/* Stores 1 - SSIM of a view and adds its mean square difference of color. */
static iso_status add_error(const iso_image *wanted, const iso_image *seen, int view, iso_small_views_error *e,
                            iso_error *err)
{
    double ssim = 0, square = 0, lost = 0;
    NEED(iso_ssim_mean(wanted, seen, &ssim, err));
    for (size_t i = 0; i < (size_t)4 * PIXELS * PIXELS; ++i) {
        const double d = (double)seen->rgba[i] - (double)wanted->rgba[i];
        square += i % 4 < 3 ? d * d : 0;
        lost += i % 4 == 3 && d < 0 ? -d : 0;
    }
    e->of_view[view] = 1 - ssim;
    e->ssim_dissimilarity += (1 - ssim) / ISO_SMALL_VIEWS_COUNT;
    e->lost += lost;
    e->rmse += square / (3.0 * PIXELS * PIXELS * ISO_SMALL_VIEWS_COUNT);
    return ISO_OK;
}

iso_status iso_small_views_compare(const iso_small_views_input *in,
                                   iso_small_views_error errors[ISO_SMALL_VIEWS_MAX_TFS], iso_error *err)
{
    iso_image pictures[ISO_SMALL_VIEWS_MAX_TFS] = {{0}};
    int64_t ghosts[ISO_SMALL_VIEWS_MAX_TFS] = {0};
    iso_small_views_fine own = {0}, *fine = in->kept ? in->kept : &own;
    iso_status status = draw_level_0(in, fine, err);
    for (size_t i = 0; i < in->tf_count && status == ISO_OK; ++i)
        status = iso_image_create(&pictures[i], PIXELS, PIXELS, err);
    for (size_t i = 0; i < in->tf_count; ++i)
        errors[i] = (iso_small_views_error){0};
    for (int view = 0; view < ISO_SMALL_VIEWS_COUNT && status == ISO_OK; ++view) {
        draw_coarse(in, view, pictures, ghosts);
        for (size_t i = 0; i < in->tf_count && status == ISO_OK; ++i)
            status = add_error(&fine->views[view], &pictures[i], view, &errors[i], err);
    }
    for (size_t i = 0; i < in->tf_count; ++i) {
        errors[i].rmse = sqrt(errors[i].rmse);
        errors[i].lost *= fine->shown > 0 ? 1 / ((double)fine->shown * ISO_SMALL_VIEWS_UNIT) : 0;
        errors[i].ghost = fine->shown > 0 ? (double)ghosts[i] / (double)fine->shown : 0;
        iso_image_destroy(&pictures[i]);
    }
    iso_small_views_fine_destroy(&own);
    return status;
}
