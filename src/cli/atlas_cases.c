/* atlas_cases.c - the list of failures. Fields are functions of millimetres in a box from -1 to 1. */
#include <math.h>
#include <string.h>

#include "brick/bricks.h"
#include "cli/atlas.h"
#include "tf/adapt.h"

/* ---- fields ---- */

static double ball(iso_vec3 p, iso_vec3 *n)
{
    double r = iso_norm(p);
    *n = iso_scale(iso_normalize(p), -1);
    return fmax(1 - r, 0);
}

/* A solid ball whose surface is one fine voxel thick, as a well-taken scan has it. */
static double solid_ball(iso_vec3 p, iso_vec3 *n)
{
    *n = iso_scale(iso_normalize(p), -1);
    return fmin(fmax(0.5 + (0.7 - iso_norm(p)) / 0.06, 0), 1);
}

static double plate(iso_vec3 p, iso_vec3 *n)
{
    *n = iso_normalize(iso_v3(0.3, 0.8, 0.5));
    double d = iso_dot(p, *n) / 0.04;
    return exp(-0.5 * d * d);
}

/* A helix of a vessel, one fine voxel across. */
static double vessel(iso_vec3 p, iso_vec3 *n)
{
    double angle = 7 * p.z, d = hypot(p.x - 0.5 * cos(angle), p.y - 0.5 * sin(angle));
    *n = iso_normalize(iso_v3(p.x - 0.5 * cos(angle), p.y - 0.5 * sin(angle), 0));
    return fabs(p.z) < 0.8 ? exp(-0.5 * d * d / (0.035 * 0.035)) : 0;
}

static double shells(iso_vec3 p, iso_vec3 *n)
{
    double r = iso_norm(p), a = (r - 0.75) / 0.035, b = (r - 0.55) / 0.035;
    *n = iso_normalize(p);
    return exp(-0.5 * a * a) + 0.8 * exp(-0.5 * b * b);
}

/* Small balls side by side: near every surface there is another one that faces it. */
static double balls(iso_vec3 p, iso_vec3 *n)
{
    const double cell = 0.4;
    iso_vec3 q = {p.x - cell * round(p.x / cell), p.y - cell * round(p.y / cell), p.z - cell * round(p.z / cell)};
    *n = iso_scale(iso_normalize(q), -1);
    return fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))) < 0.8 ? fmax(1 - iso_norm(q) / 0.2, 0) : 0;
}

/* A homogeneous block of 115/255, and beside it plates of twice that, two fine voxels thick: one in each of two coarse
 * voxels, whose mean is the block's value. */
static double block_and_plates(iso_vec3 p, iso_vec3 *n)
{
    const long voxel = (long)floor((p.x + 1) * 24), in_turn = voxel % 8;
    *n = iso_v3(1, 0, 0);
    return voxel < 30 ? 115.0 / 255 : in_turn == 1 || in_turn == 2 ? 230.0 / 255 : 0;
}

/* Two textures of the same mean: on one side grey, on the other black and white in cells of a fine voxel. */
static double two_textures(iso_vec3 p, iso_vec3 *n)
{
    const double voxels_per_mm = 24;
    *n = iso_v3(0, 0, 0);
    const long cell = (long)(floor(p.x * voxels_per_mm) + floor(p.y * voxels_per_mm) + floor(p.z * voxels_per_mm));
    return p.x < 0 ? 0.5 : (double)(cell & 1);
}

/* ---- shared shapes of a case ---- */

/* The last step of most cases: both pictures against the right one. */
static iso_status judge_pictures(iso_atlas_result *out, iso_error *err)
{
    iso_status status = iso_atlas_rmse(&out->truth, &out->failure, &out->bad, err);
    return status == ISO_OK ? iso_atlas_rmse(&out->truth, &out->mended, &out->good, err) : status;
}

/* One stage, two sources of directions at one level, measured against the picture with the closed form's. */
static iso_status two_sources(iso_atlas_stage *s, size_t level, iso_direction_source bad, iso_direction_source good,
                              iso_atlas_result *out, iso_error *err)
{
    iso_status status = iso_atlas_render_truth(s, level, &out->truth, err);
    if (status == ISO_OK)
        status = iso_atlas_render(s, level, bad, 0.25, &out->failure, err);
    if (status == ISO_OK)
        status = iso_atlas_render(s, level, good, 0.25, &out->mended, err);
    return status == ISO_OK ? judge_pictures(out, err) : status;
}

/* How two builds of one field are shown and judged. */
typedef struct comparison {
    size_t level;
    double lo, hi, extinction; /* of the TF */
    bool by_image;             /* RMSE to the picture with true normals, instead of the angle */
} comparison;

static iso_status measure_build(iso_atlas_stage *s, const comparison *c, const iso_image *truth, iso_image *image, double *value,
                                iso_error *err)
{
    iso_status status = iso_atlas_render(s, c->level, ISO_FROM_CODES, 0.25, image, err);
    if (status != ISO_OK)
        return status;
    return c->by_image ? iso_atlas_rmse(truth, image, value, err) : iso_atlas_angle(s, c->level, ISO_FROM_CODES, value, err);
}

static iso_status two_builds(iso_atlas_field field, const iso_atlas_options *bad, const iso_atlas_options *good, const comparison *c,
                             iso_atlas_result *out, iso_error *err)
{
    iso_atlas_stage s;
    iso_status status = iso_atlas_stage_create(&s, field, bad, err);
    if (status != ISO_OK)
        return status;
    status = iso_atlas_show_above(&s, c->lo, c->hi, c->extinction, err);
    if (status == ISO_OK)
        status = iso_atlas_render_truth(&s, c->level, &out->truth, err);
    if (status == ISO_OK)
        status = measure_build(&s, c, &out->truth, &out->failure, &out->bad, err);
    iso_atlas_stage_destroy(&s);
    if (status == ISO_OK)
        status = iso_atlas_stage_create(&s, field, good, err);
    if (status != ISO_OK)
        return status;
    status = iso_atlas_show_above(&s, c->lo, c->hi, c->extinction, err);
    if (status == ISO_OK)
        status = measure_build(&s, c, &out->truth, &out->mended, &out->good, err);
    iso_atlas_stage_destroy(&s);
    return status;
}

/* ---- the cases ---- */

static iso_status staircases(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_stage s;
    iso_atlas_options opt = iso_atlas_defaults();
    iso_status status = iso_atlas_stage_create(&s, solid_ball, &opt, err);
    if (status == ISO_OK)
        status = iso_atlas_show_above(&s, 0.2, 0.8, 60, err);
    if (status == ISO_OK)
        status = two_sources(&s, 1, ISO_FROM_ON_THE_FLY, ISO_FROM_CODES, out, err);
    iso_atlas_stage_destroy(&s);
    return status;
}

static iso_status opposite_normals(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_options naive = iso_atlas_defaults(), tensor = iso_atlas_defaults();
    naive.build.direction_filter = ISO_DIRECTION_NAIVE;
    tensor.build.direction_filter = ISO_DIRECTION_TENSOR;
    const comparison c = {.level = 2, .lo = 0.1, .hi = 0.4, .extinction = 40, .by_image = true};
    return two_builds(plate, &naive, &tensor, &c, out, err);
}

static iso_status noise(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_options central = iso_atlas_defaults(), sobel;
    central.noise = 0.04;
    sobel = central;
    sobel.build.gradient.method = ISO_GRADIENT_SOBEL;
    const comparison c = {.level = 0, .lo = 0.25, .hi = 0.35, .extinction = 40};
    return two_builds(ball, &central, &sobel, &c, out, err);
}

static iso_status vanishing_gradients(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_options central = iso_atlas_defaults(), sobel;
    central.type = ISO_U8;
    central.steps = 9;
    sobel = central;
    sobel.build.gradient.method = ISO_GRADIENT_SOBEL;
    const comparison c = {.level = 0, .lo = 0.25, .hi = 0.35, .extinction = 40};
    return two_builds(ball, &central, &sobel, &c, out, err);
}

static iso_status wide_filter(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_options wide = iso_atlas_defaults(), small = iso_atlas_defaults();
    wide.build.direction_filter = ISO_DIRECTION_EQ1;
    wide.build.gauss_radius = 4;
    wide.build.gauss_sigma_voxels = 3;
    const comparison c = {.level = 1, .lo = 0.3, .hi = 0.6, .extinction = 40, .by_image = true};
    return two_builds(balls, &wide, &small, &c, out, err);
}

/* Without the magnitude, the directions of noise count as much as those of the surface beside them. */
static iso_status no_weight(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_options plain = iso_atlas_defaults(), weighted;
    plain.noise = 0.02;
    plain.build.direction_filter = ISO_DIRECTION_EQ1;
    plain.build.eq1_exponent = 0;
    weighted = plain;
    weighted.build.eq1_exponent = 1;
    const comparison c = {.level = 2, .lo = 0.2, .hi = 0.8, .extinction = 60};
    return two_builds(solid_ball, &plain, &weighted, &c, out, err);
}

/* With a high power of it, the strongest voxel decides alone, and that is the noisiest one. */
static iso_status high_exponent(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_options high = iso_atlas_defaults(), weighted;
    high.noise = 0.06;
    high.build.direction_filter = ISO_DIRECTION_EQ1;
    high.build.eq1_exponent = 4;
    weighted = high;
    weighted.build.eq1_exponent = 1;
    const comparison c = {.level = 1, .lo = 0.25, .hi = 0.35, .extinction = 40};
    return two_builds(ball, &high, &weighted, &c, out, err);
}

/* The failure forgets that gradients are covariant: it takes the index gradient for the world's. */
static iso_status spacing(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_stage s;
    iso_atlas_options opt = iso_atlas_defaults();
    const size_t size[3] = {48, 48, 16};
    const double mm[3] = {2.0 / 48, 2.0 / 48, 2.0 / 16};
    iso_geometry g = iso_geometry_axis_aligned(size, mm);
    opt.geometry = &g;
    opt.build.level_count = 1;
    iso_status status = iso_atlas_stage_create(&s, ball, &opt, err);
    if (status == ISO_OK)
        status = iso_atlas_show_above(&s, 0.25, 0.35, 40, err);
    iso_level *l = &s.pyramid.levels[0];
    for (size_t i = 0; status == ISO_OK && i < iso_geometry_voxel_count(&g); ++i) {
        float *d = l->directions + 3 * i;
        iso_vec3 n = iso_normalize(iso_v3((double)d[0] * mm[0], (double)d[1] * mm[1], (double)d[2] * mm[2]));
        d[0] = (float)n.x, d[1] = (float)n.y, d[2] = (float)n.z;
    }
    if (status == ISO_OK)
        status = two_sources(&s, 0, ISO_FROM_FLOAT, ISO_FROM_CODES, out, err);
    iso_atlas_stage_destroy(&s);
    return status;
}

static iso_status large_steps(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_stage s;
    iso_atlas_options opt = iso_atlas_defaults();
    opt.build.level_count = 1;
    iso_status status = iso_atlas_stage_create(&s, shells, &opt, err);
    if (status == ISO_OK)
        status = iso_atlas_show_band(&s, 0.5, 0.1, 150, err);
    if (status == ISO_OK)
        status = iso_atlas_render(&s, 0, ISO_FROM_CODES, 0, &out->truth, err);
    if (status == ISO_OK)
        status = iso_atlas_render(&s, 0, ISO_FROM_CODES, 1, &out->failure, err);
    if (status == ISO_OK)
        status = iso_atlas_render(&s, 0, ISO_FROM_CODES, 1.0 / 16, &out->mended, err);
    if (status == ISO_OK)
        status = judge_pictures(out, err);
    iso_atlas_stage_destroy(&s);
    return status;
}

/* The level with its adapted TF (how NULL: with the original), or with tables over value and class. */
static iso_status render_adapted(iso_atlas_stage *s, size_t level, const iso_adapt_options *how, iso_joint_split split, iso_image *image,
                                 iso_error *err)
{
    iso_tf_table adapted = {0}, original = s->view.tf;
    iso_class_tables classes = {0};
    iso_status status = ISO_OK;
    if (how && split == ISO_SPLIT_NONE)
        status = iso_adapt_level(&s->pyramid, NULL, level, &original, how, &adapted, NULL, err);
    else if (how)
        status = iso_adapt_classes(&s->pyramid, NULL, level, split, &original, how, &classes, err);
    if (adapted.entries)
        s->view.tf = adapted;
    s->view.classes = classes.bytes ? &classes : NULL; /* lent */
    if (status == ISO_OK)
        status = iso_atlas_render(s, level, ISO_FROM_CODES, 0.25, image, err);
    s->view.tf = original;
    s->view.classes = NULL;
    iso_tf_table_destroy(&adapted);
    iso_class_tables_destroy(&classes);
    return status;
}

/* Level 0 is right; two ways to show level 1. */
typedef struct tf_case {
    double lo, hi; /* of the TF's ramp; or of a band */
    bool band;
    const iso_adapt_options *bad, *good;
    iso_joint_split split; /* of the good one */
} tf_case;

static iso_status two_tfs(iso_atlas_field field, const tf_case *c, iso_atlas_result *out, iso_error *err)
{
    iso_atlas_stage s;
    iso_atlas_options opt = iso_atlas_defaults();
    iso_status status = iso_atlas_stage_create(&s, field, &opt, err);
    if (status == ISO_OK)
        status = c->band ? iso_atlas_show_band(&s, (c->lo + c->hi) / 2, (c->hi - c->lo) / 2, 60, err)
                         : iso_atlas_show_above(&s, c->lo, c->hi, 60, err);
    if (status == ISO_OK)
        status = iso_atlas_render(&s, 0, ISO_FROM_CODES, 0.25, &out->truth, err);
    if (status == ISO_OK)
        status = render_adapted(&s, 1, c->bad, ISO_SPLIT_NONE, &out->failure, err);
    if (status == ISO_OK)
        status = render_adapted(&s, 1, c->good, c->split, &out->mended, err);
    if (status == ISO_OK)
        status = judge_pictures(out, err);
    iso_atlas_stage_destroy(&s);
    return status;
}

static iso_status sharp_tf(iso_atlas_result *out, iso_error *err)
{
    const iso_adapt_options how = iso_adapt_defaults();
    return two_tfs(shells, &(tf_case){0.65, 1.05, true, NULL, &how, ISO_SPLIT_NONE}, out, err);
}

static iso_status shared_value(iso_atlas_result *out, iso_error *err)
{
    iso_adapt_options how = iso_adapt_defaults(), wide = how;
    wide.window = 3;
    return two_tfs(block_and_plates, &(tf_case){0.6, 0.7, false, &wide, &how, ISO_SPLIT_DEVIATION}, out, err);
}

static iso_status shared_mean(iso_atlas_result *out, iso_error *err)
{
    const iso_adapt_options how = iso_adapt_defaults();
    return two_tfs(two_textures, &(tf_case){0.6, 0.7, false, &how, &how, ISO_SPLIT_DEVIATION}, out, err);
}

/* No transfer function brings back what a coarse voxel does not hold: a finer level does. */
static iso_status thin_vessels(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_stage s;
    iso_atlas_options opt = iso_atlas_defaults();
    iso_status status = iso_atlas_stage_create(&s, vessel, &opt, err);
    if (status == ISO_OK)
        status = iso_atlas_show_above(&s, 0.3, 0.6, 60, err);
    for (size_t level = 0; level < 3 && status == ISO_OK; ++level)
        status = iso_atlas_render(&s, level == 1 ? 0 : level, ISO_FROM_CODES, level == 1 ? 0.5 : 0.25,
                                  level == 0 ? &out->truth : level == 1 ? &out->mended : &out->failure, err);
    if (status == ISO_OK)
        status = judge_pictures(out, err);
    iso_atlas_stage_destroy(&s);
    return status;
}

/* An octahedral code folds the sphere: between two codes across a fold the filter meets a third side. A pyramid
 * refuses such a code, so the failure is planted. */
static iso_status code_folds(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_stage s;
    iso_atlas_options opt = iso_atlas_defaults();
    iso_code oct = ISO_CODE_SNORM;
    opt.size = 16;
    opt.build.level_count = 1;
    iso_status status = iso_code_from_name("oct24", &oct, err);
    if (status == ISO_OK)
        status = iso_atlas_stage_create(&s, ball, &opt, err);
    if (status != ISO_OK)
        return status;
    status = iso_atlas_show_above(&s, 0.25, 0.35, 40, err);
    if (status == ISO_OK)
        status = iso_atlas_render_truth(&s, 0, &out->truth, err);
    if (status == ISO_OK)
        status = iso_atlas_render(&s, 0, ISO_FROM_CODES, 0.25, &out->mended, err);
    iso_level *level = &s.pyramid.levels[0];
    iso_code_encode(oct, level->directions, level->codes, iso_geometry_voxel_count(&level->geometry));
    s.pyramid.options.code = oct;
    if (status == ISO_OK)
        status = iso_atlas_render(&s, 0, ISO_FROM_CODES, 0.25, &out->failure, err);
    if (status == ISO_OK)
        status = judge_pictures(out, err);
    iso_atlas_stage_destroy(&s);
    return status;
}

/* Azimuth and cosine of the polar angle, filtered as numbers and then decoded. */
static iso_vec3 from_angles(double azimuth, double z)
{
    double r = sqrt(fmax(1 - z * z, 0));
    return iso_v3(r * cos(azimuth), r * sin(azimuth), z);
}

/* The direction at p from the eight stored ones round it: vectors, or angles. The stored grid is four times as coarse. */
static iso_vec3 filtered_direction(const iso_level *level, size_t voxel, bool angles)
{
    enum { coarse = 4 };
    const iso_geometry *g = &level->geometry;
    const size_t at[3] = {voxel % g->size[0], voxel / g->size[0] % g->size[1], voxel / (g->size[0] * g->size[1])};
    iso_vec3 vector = {0, 0, 0};
    double azimuth = 0, cosine = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
        double weight = 1, q[3];
        for (int a = 0; a < 3; ++a) {
            double x = ((double)at[a] + 0.5) / coarse - 0.5, f = x - floor(x);
            q[a] = (floor(x) + (corner >> a & 1) + 0.5) * coarse;
            weight *= corner >> a & 1 ? f : 1 - f;
        }
        iso_vec3 n;
        ball(iso_geometry_to_world(g, iso_v3(q[0], q[1], q[2])), &n);
        vector = iso_madd(vector, n, weight);
        azimuth += weight * atan2(n.y, n.x);
        cosine += weight * n.z;
    }
    return angles ? from_angles(azimuth, cosine) : iso_normalize(vector);
}

/* Two angles have poles, and a seam where the azimuth turns over: no code here is made of them, so the failure is
 * planted. The ball's directions are read from a grid four times as coarse, by filtering angles or vectors. */
static iso_status code_poles(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_stage s;
    iso_atlas_options opt = iso_atlas_defaults();
    opt.build.level_count = 1;
    iso_status status = iso_atlas_stage_create(&s, ball, &opt, err);
    if (status == ISO_OK)
        status = iso_atlas_show_above(&s, 0.25, 0.35, 40, err);
    if (status == ISO_OK)
        status = iso_atlas_render_truth(&s, 0, &out->truth, err);
    for (int angles = 0; angles < 2 && status == ISO_OK; ++angles) {
        iso_level *level = &s.pyramid.levels[0];
        for (size_t i = 0; i < iso_geometry_voxel_count(&level->geometry); ++i) {
            iso_vec3 n = filtered_direction(level, i, angles);
            float *d = level->directions + 3 * i;
            d[0] = (float)n.x, d[1] = (float)n.y, d[2] = (float)n.z;
        }
        status = iso_atlas_render(&s, 0, ISO_FROM_FLOAT, 0.25, angles ? &out->failure : &out->mended, err);
    }
    if (status == ISO_OK)
        status = judge_pictures(out, err);
    iso_atlas_stage_destroy(&s);
    return status;
}

/* A cut through a fine and a coarse brick, as grey values; the largest step over the common face. */
static iso_status show_cut(const iso_brick_field *f, iso_image *image, double *jump, iso_error *err)
{
    const double face = (double)f->nodes->brick_voxels, tiny = 1e-7;
    iso_status status = iso_image_create(image, ISO_ATLAS_PIXELS, ISO_ATLAS_PIXELS, err);
    *jump = 0;
    for (size_t i = 0; status == ISO_OK && i < ISO_ATLAS_PIXELS * ISO_ATLAS_PIXELS; ++i) {
        double u = ((double)(i % ISO_ATLAS_PIXELS) + 0.5) / ISO_ATLAS_PIXELS, w = ((double)(i / ISO_ATLAS_PIXELS) + 0.5) / ISO_ATLAS_PIXELS;
        double v[ISO_NODE_CHANNELS], left[ISO_NODE_CHANNELS], right[ISO_NODE_CHANNELS];
        iso_brick_sample(f, iso_v3(face + 8 * (u - 0.5) + 0.5, 8 * w + 0.5, 6.3), v);
        iso_brick_sample(f, iso_v3(face - tiny + 0.5, 8 * w + 0.5, 6.3), left);
        iso_brick_sample(f, iso_v3(face + tiny + 0.5, 8 * w + 0.5, 6.3), right);
        for (size_t c = 0; c < 3; ++c)
            image->rgba[4 * i + c] = (float)v[0];
        image->rgba[4 * i + 3] = 1;
        *jump = fmax(*jump, fabs(left[0] - right[0]));
    }
    return status;
}

static double ripples(iso_vec3 p, iso_vec3 *n)
{
    *n = iso_v3(0, 0, 0);
    return 0.5 + 0.25 * sin(19 * p.x + 9 * p.y) + 0.25 * cos(21 * p.y - 5 * p.z);
}

static iso_status brick_seams(iso_atlas_result *out, iso_error *err)
{
    iso_atlas_stage s;
    iso_atlas_options opt = iso_atlas_defaults();
    iso_node_levels nodes = {0};
    uint8_t levels[64] = {0}, fine[64] = {0};
    opt.size = 33;
    opt.build.level_count = 1;
    iso_status status = iso_atlas_stage_create(&s, ripples, &opt, err);
    if (status == ISO_OK)
        status = iso_node_levels_create(&nodes, &s.pyramid.levels[0], 16, 2, false, 0, err);
    for (size_t b = 0; status == ISO_OK && b < iso_brick_count(&nodes) && b < sizeof levels; ++b)
        levels[b] = b % nodes.count[0] > 0; /* the first column of bricks is fine */
    iso_brick_field f = {.nodes = &nodes, .levels = fine, .faces = ISO_FACES_BAKED};
    double none = 0;
    if (status == ISO_OK)
        status = show_cut(&f, &out->truth, &none, err);
    f.levels = levels;
    f.faces = ISO_FACES_OWN;
    if (status == ISO_OK)
        status = show_cut(&f, &out->failure, &out->bad, err);
    f.faces = ISO_FACES_BAKED;
    if (status == ISO_OK)
        status = show_cut(&f, &out->mended, &out->good, err);
    iso_node_levels_destroy(&nodes);
    iso_atlas_stage_destroy(&s);
    return status;
}

#define ANGLE "mean angle to the true normals where the volume shows, degrees"
#define IMAGE_NORMALS "RMSE to the picture with true normals"

/* The limits stand about a fifth off what was measured: the cases are deterministic but for compilers' rounding. */
const iso_atlas_case iso_atlas_cases[] = {
    {"staircases", "Staircases", "A coarse level of a solid ball: its surface has steps, and gradients taken from it follow them.",
     IMAGE_NORMALS, "gradients on the fly from level 1", "directions from level 0, filtered to level 1", 0.008, 0.0045, staircases},
    {"opposite-normals", "Opposite normals", "Both faces of a thin plate fall into one coarse voxel: their gradients cancel, and what is left of the sum points anywhere.",
     IMAGE_NORMALS, "plain mean, stored as a unit vector", "tensor mean: no sign to cancel", 0.018, 0.012, opposite_normals},
    {"vanishing-gradients", "Vanishing gradients", "A smooth ball in nine grey values: central differences are zero on the plateaus, and the shade falls to ambient there.",
     ANGLE, "central differences", "Sobel, which looks at 26 neighbours", 40, 18, vanishing_gradients},
    {"noise", "Noise", "Noise of 4 % of the range outweighs the slope over two voxels.", ANGLE, "central differences", "Sobel, which averages across", 23, 13, noise},
    {"wide-filter", "A filter that is too wide", "Eq. 1 with a radius of four voxels mixes the directions of neighbouring balls.",
     IMAGE_NORMALS, "Eq. 1, radius 4, sigma 3", "moments of the own eight children", 0.03, 0.02, wide_filter},
    {"no-weight", "Eq. 1 without the magnitude", "With an exponent of 0 the noise inside and outside of a solid ball has as much say in a coarse voxel as its surface.",
     ANGLE, "Eq. 1, exponent 0", "Eq. 1, exponent 1", 9.8, 9.5, no_weight},
    {"high-exponent", "Eq. 1 with a high power of the magnitude", "The longest gradient of the neighbourhood decides alone, and where there is noise that is the noisiest.",
     ANGLE, "Eq. 1, exponent 4", "Eq. 1, exponent 1", 6.9, 6.7, high_exponent},
    {"spacing", "Gradients are covariant", "Slices three times as thick as their pixels: an index gradient taken for the world's leans towards the plane of the slices.",
     IMAGE_NORMALS, "index gradient, as it is", "by the inverse transpose", 0.035, 0.001, spacing},
    {"large-steps", "Ray steps that miss a shell", "A band of values thinner than a voxel is met or missed by chance.", "RMSE to the converged picture",
     "one voxel a step", "1/16 voxel a step", 0.08, 2e-4, large_steps},
    {"sharp-tf", "A transfer function that the coarse level no longer meets", "Averages of a thin shell do not reach the values that the TF shows.",
     "RMSE to level 0", "level 1 with the original TF", "level 1 with its adapted TF", 0.2, 0.08, sharp_tf},
    {"shared-value", "A tissue that shares its value with thin plates", "Plates that fill half of their coarse voxels have the value of the block beside them, which lights up. A table over the value cannot tell them apart: with the default's narrower window the plates go dark instead.",
     "RMSE to level 0", "adapted over the value, window of 3 deviations", "adapted over value and deviation", 0.29, 0.06, shared_value},
    {"shared-mean", "Two textures of one mean", "Grey, and black and white in turns, are the same at level 1: any table over the value gives both the same look.",
     "RMSE to level 0", "adapted over the value", "adapted over value and deviation", 0.27, 0.19, shared_mean},
    {"thin-vessels", "Thin vessels vanish", "A vessel thinner than a coarse voxel is not in the coarse level, and no transfer function brings it back.",
     "RMSE to level 0", "level 2", "level 0 at twice the step", 0.07, 0.01, thin_vessels},
    {"brick-seams", "Seams between bricks", "A fine and a coarse brick interpolate different nodes on their common face.", "largest step over the face, of the range",
     "each brick its own nodes", "nodes on the face baked from the coarser brick", 0.1, 1e-5, brick_seams},
    {"code-folds", "Codes that fold", "The octahedral map is folded along its edges: a filter between codes on two sides of a fold meets a third direction.",
     IMAGE_NORMALS, "oct24, filtered", "fit, filtered: linear", 0.012, 0.001, code_folds},
    {"code-poles", "Codes with poles", "Azimuth and polar angle as two numbers: a filter turns the long way round at the seam, and directions scatter at the poles.",
     IMAGE_NORMALS, "angles, filtered", "vectors, filtered", 0.0043, 0.0003, code_poles},
};
const size_t iso_atlas_case_count = sizeof iso_atlas_cases / sizeof *iso_atlas_cases;

iso_status iso_atlas_run(const iso_atlas_case *c, iso_atlas_result *out, iso_error *err)
{
    *out = (iso_atlas_result){.bad = NAN, .good = NAN};
    iso_status status = c->run(out, err);
    if (status == ISO_OK)
        return ISO_OK;
    iso_atlas_clear(out);
    return iso_fail_in(err, status, "%s", c->id);
}

void iso_atlas_clear(iso_atlas_result *out)
{
    iso_image_destroy(&out->truth);
    iso_image_destroy(&out->failure);
    iso_image_destroy(&out->mended);
    *out = (iso_atlas_result){0};
}
