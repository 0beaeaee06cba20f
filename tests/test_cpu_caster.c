/* SPDX-License-Identifier: MIT */
/* The CPU ray caster against the reference with the same samples, over all sources of directions, volumes and views;
 * and the same bits from each instruction set, each number of threads, and with empty space left out. */
#include "difference.h"
#include "rendered.h"
#include "test.h"

#include "fit/extinction_scale.h"
#include "brick/occupancy.h"
#include "pyramid/narrow.h"
#include "render/cpu/cast_bricks.h"
#include "render/cpu/caster.h"
#include "render/reference.h"

/* Causes: floats of the filter's sums (6e-8 of the largest value), of the entry's place in the table (its value times
 * 64 entries), of colors and of the shading normal. A ray's sum has its rest beside it. 3e-8 and 4e-7 were seen; 1e-7
 * and 2.5e-6 of segments 37 voxels long. */
#define RMSE 3e-7
#define MAX_ABS 5e-6

typedef struct volume_case {
    iso_type type;
    iso_code code;
    size_t size[3];
    bool labels;
} volume_case;

static iso_volume make_volume(const volume_case *of)
{
    const size_t *n = of->size;
    const iso_field field = {.kind = ISO_FIELD_NOISE, .geometry = rotated_geometry(n[0], n[1], n[2]), .seed = 3};
    iso_volume v;
    assert_ok(iso_field_sample(&field, of->type, &v, &err));
    return v;
}

static iso_pyramid_options options_of(const volume_case *of)
{
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 1;
    opt.code = of->code;
    opt.keep_float = true;
    return opt;
}

static iso_pyramid make_pyramid(const volume_case *of)
{
    const iso_pyramid_options opt = options_of(of);
    OWNED(iso_volume) v = make_volume(of);
    iso_pyramid p;
    assert_ok(iso_pyramid_build(&v, "noise", &opt, &p, NULL, &err));
    p.levels[0].labels = of->labels;
    return p;
}

static iso_view make_view(const iso_pyramid *p, bool orthographic)
{
    static iso_tf_point points[] = {{0, {0.9, 0.3, 0.2}, 0},
                                    {0.45, {0.9, 0.3, 0.2}, 0},
                                    {0.55, {0.9, 0.8, 0.3}, 0.2},
                                    {0.7, {0.2, 0.5, 0.9}, 0.02},
                                    {1, {0.3, 0.9, 0.5}, 0.3}};
    const iso_scene scene = scene_of_points(points, 5);
    iso_view view = view_of(&scene, p);
    view.width = 45; /* no multiple of a packet's or a tile's */
    view.height = 37;
    view.camera.orthographic = orthographic;
    if (orthographic)
        view.camera.half_height = 0.8 * iso_geometry_box_radius_mm(&p->levels[0].geometry);
    return view;
}

/* ---- pictures ---- */

static iso_image draw(const iso_pyramid *p, const iso_view *view, iso_cpu_options opt)
{
    iso_image image;
    assert_ok(iso_cpu_render(&p->levels[0], p->options.code, view, &opt, &image, &err));
    return image;
}

static void expect_same_bits(const iso_pyramid *p, const iso_view *view, iso_cpu_options opt, const iso_image *image,
                             const char *what)
{
    OWNED(iso_image) other = draw(p, view, opt);
    if (memcmp(image->rgba, other.rgba, 4 * image->width * image->height * sizeof(float)) != 0)
        fail_msg("%s: %g apart", what, difference_of(image, &other).max_abs);
}

/* The reference's samples within rounding; and the same bits however they were made. */
static void expect_picture(const iso_pyramid *p, const iso_view *view, iso_direction_source source, const char *what)
{
    static const iso_cpu_width widths[] = {ISO_CPU_BASELINE, ISO_CPU_ONE, ISO_CPU_BASELINE, ISO_CPU_AVX2,
                                           ISO_CPU_AVX512};
    iso_reference_options o = iso_reference_defaults();
    iso_cpu_options opt = iso_cpu_defaults();
    OWNED(iso_image) truth;
    o.quadrature = ISO_QUADRATURE_MIDPOINT;
    o.source = opt.source = source;
    opt.threads = 1;
    opt.skip = ISO_CPU_SKIP_NEVER;
    assert_ok(iso_reference_render(&p->levels[0], p->options.code, view, &o, &truth, NULL, &err));
    OWNED(iso_image) image = draw(p, view, opt);
    const difference d = difference_of(&truth, &image);
    print_message("%-40s rmse %.2g, most %.2g\n", what, d.rmse, d.max_abs);
    if (!(d.rmse <= RMSE && d.max_abs <= MAX_ABS))
        fail_msg("%s: rmse %g, most %g", what, d.rmse, d.max_abs);
    for (size_t i = 0; i < sizeof widths / sizeof *widths; ++i) {
        if (widths[i] > iso_cpu_widest())
            continue;
        opt.width = widths[i];
        opt.threads = 1 + (int)i;
        opt.skip = i % 2 ? ISO_CPU_SKIP_ALWAYS : ISO_CPU_SKIP_NEVER;
        expect_same_bits(p, view, opt, &image, iso_cpu_width_name(widths[i]));
    }
    opt.width = ISO_CPU_WIDEST;
    opt.skip = ISO_CPU_SKIP_ALWAYS;
    expect_same_bits(p, view, opt, &image, "empty space is left out");
}

TEST(it_has_the_samples_of_the_reference)
{
    static const volume_case volumes[] = {{ISO_U8, ISO_CODE_FIT, {22, 27, 17}, false},
                                          {ISO_I16, ISO_CODE_FREE, {16, 15, 33}, false},
                                          {ISO_F32, ISO_CODE_REGION48, {9, 40, 1}, false},
                                          {ISO_U16, ISO_CODE_CUBE, {1, 2, 31}, false}};
    static const iso_direction_source sources[] = {ISO_FROM_CODES, ISO_FROM_DECODED, ISO_FROM_FLOAT, ISO_FROM_FLIPPED,
                                                   ISO_FROM_ON_THE_FLY};
    for (size_t v = 0; v < sizeof volumes / sizeof *volumes; ++v) {
        OWNED(iso_pyramid) p = make_pyramid(&volumes[v]);
        for (size_t s = 0; s < sizeof sources / sizeof *sources; ++s) {
            char what[96];
            OWNED(iso_view) view = make_view(&p, s % 2);
            snprintf(what, sizeof what, "%s, %s", iso_code_describe(volumes[v].code)->name,
                     iso_direction_source_name(sources[s]));
            expect_picture(&p, &view, sources[s], what);
        }
    }
}

TEST(it_has_clip_planes_cameras_inside_and_any_step)
{
    const volume_case of = {ISO_U8, ISO_CODE_FIT, {22, 27, 17}, false};
    OWNED(iso_pyramid) p = make_pyramid(&of);
    OWNED(iso_view) view = make_view(&p, false);
    const iso_vec3 middle = iso_geometry_box_center_mm(&p.levels[0].geometry);
    view.clip_count = 2;
    view.clips[0].normal = iso_normalize(iso_v3(1, 0.4, -0.2));
    view.clips[0].offset_mm = iso_dot(view.clips[0].normal, middle) - 2;
    view.clips[1].normal = iso_normalize(iso_v3(0.1, -1, 0.3));
    view.clips[1].offset_mm = iso_dot(view.clips[1].normal, middle) - 5;
    expect_picture(&p, &view, ISO_FROM_CODES, "clip planes");
    view.clip_count = 0;
    view.camera.position = middle;
    expect_picture(&p, &view, ISO_FROM_CODES, "inside");
    view.step_voxels = 37; /* some rays have one segment, cut at both ends */
    expect_picture(&p, &view, ISO_FROM_CODES, "a long step");
    view.step_voxels = 0.07;
    expect_picture(&p, &view, ISO_FROM_CODES, "a short step");
}

/* Along z, a ray through each voxel's center and one between every two: on faces of cells all along, where a place in
 * floats does not tell the cell. */
static void look_along_z(iso_pyramid *p, iso_view *view, double tilt)
{
    const size_t *size = p->levels[0].geometry.size;
    p->levels[0].geometry = iso_geometry_axis_aligned(size, (const double[3]){1, 1, 1});
    const iso_vec3 middle = iso_geometry_box_center_mm(&p->levels[0].geometry);
    view->width = 41; /* inside the box: on its own face a ray may as well miss it */
    view->height = 33;
    view->camera.orthographic = true;
    view->camera.half_height = 0.25 * (double)view->height;
    view->camera.forward = iso_v3(tilt, 0, 1);
    view->camera.right = iso_v3(1, 0, 0);
    view->camera.up = iso_v3(0, 1, 0);
    view->camera.position = iso_sub(middle, iso_v3(0, 0, 40));
}

TEST(rays_on_faces_of_cells_miss_nothing)
{
    const volume_case of = {ISO_U8, ISO_CODE_FIT, {22, 27, 17}, false};
    OWNED(iso_pyramid) p = make_pyramid(&of);
    OWNED(iso_view) view = make_view(&p, true);
    look_along_z(&p, &view, 0);
    expect_picture(&p, &view, ISO_FROM_CODES, "on faces of cells");
    expect_picture(&p, &view, ISO_FROM_ON_THE_FLY, "on faces of cells, on the fly");
}

/* Next to a face behind which all is empty, so near that a float is on the other side: 301 - 1.2e-5 is 301. What is
 * empty is so by five thousandths of the table's entry, and the rays' samples are seven into the next one. */
TEST(rays_next_to_what_is_empty_miss_nothing)
{
    const volume_case of = {ISO_F32, ISO_CODE_FIT, {600, 5, 4}, false};
    OWNED(iso_pyramid) p = make_pyramid(&of);
    OWNED(iso_view) view = make_view(&p, true);
    const iso_tf_table *tf = &view.tf;
    size_t last = 0; /* entry before the first one that shows */
    while (!(tf->entries[4 * (last + 1) + 3] > 0))
        ++last;
    const double entry = (tf->hi - tf->lo) / (double)(tf->count - 1);
    for (size_t i = 0; i < 600 * 5 * 4; ++i)
        p.levels[0].scalar[i] = (float)(tf->lo + entry * ((double)last + (i % 600 < 300 ? 999.995 : -0.005)));
    look_along_z(&p, &view, 0);
    view.camera.position = iso_sub(view.camera.position, iso_v3(1.2e-5, 0.1, 0));
    expect_picture(&p, &view, ISO_FROM_CODES, "next to what is empty");
}

/* A camera's axes are sines and cosines: one that should be 0 is 1e-17. Below 0, that was a step of a whole voxel in
 * numbers of 32 bits before and 32 bits behind the point. */
TEST(a_direction_just_below_zero_is_next_to_zero)
{
    const volume_case of = {ISO_U8, ISO_CODE_FIT, {22, 27, 17}, false};
    OWNED(iso_pyramid) p = make_pyramid(&of);
    OWNED(iso_view) view = make_view(&p, true);
    look_along_z(&p, &view, -1e-17);
    view.camera.position.x += 0.1; /* off the faces of cells */
    expect_picture(&p, &view, ISO_FROM_CODES, "a direction just below 0");
}

/* The box cuts the first and the last segment, and the middle of what is left is moved along the ray: by next to
 * nothing across it. Next to nothing below 0 was a whole voxel. */
TEST(what_the_box_cuts_moves_nothing_across_the_ray)
{
    const volume_case of = {ISO_U8, ISO_CODE_FIT, {22, 27, 17}, false};
    static const double tilts[] = {-1e-17, 1e-17, -1e-9, 1e-9};
    OWNED(iso_pyramid) p = make_pyramid(&of);
    OWNED(iso_view) view = make_view(&p, true);
    for (size_t i = 0; i < sizeof tilts / sizeof *tilts; ++i) {
        look_along_z(&p, &view, tilts[i]);
        view.camera.position = iso_add(view.camera.position, iso_v3(0.1, 0, 0.17)); /* off the faces of cells */
        expect_picture(&p, &view, ISO_FROM_CODES, "a direction next to 0, and segments that are cut");
    }
}

TEST(it_has_labels)
{
    const volume_case of = {ISO_U8, ISO_CODE_FIT, {22, 27, 17}, true};
    OWNED(iso_pyramid) p = make_pyramid(&of);
    OWNED(iso_view) view = make_view(&p, false);
    for (size_t i = 0; i < 22 * 27 * 17; ++i)
        p.levels[0].scalar[i] = (float)(16 * (int)(p.levels[0].scalar[i] / 16)); /* values between labels would show */
    p.levels[0].min = 16 * floor(p.levels[0].min / 16);
    expect_picture(&p, &view, ISO_FROM_CODES, "labels");
    expect_picture(&p, &view, ISO_FROM_ON_THE_FLY, "labels, on the fly");
}

/* A second value that follows its own wave, and an extinction scale that follows another. */
TEST(it_has_2d_transfer_functions_and_extinction_scales)
{
    const volume_case of = {ISO_U8, ISO_CODE_FIT, {22, 27, 17}, false};
    OWNED(iso_pyramid) p = make_pyramid(&of);
    OWNED(iso_view) view = make_view(&p, false);
    const size_t count = 22 * 27 * 17;
    iso_tf_2d *tf = calloc(1, sizeof *tf);
    uint8_t *bytes = malloc(count), *scale = malloc(count);
    assert_non_null(tf);
    assert_non_null(bytes);
    assert_non_null(scale);
    for (size_t i = 0; i < count; ++i) {
        bytes[i] = (uint8_t)(127.5 + 127.5 * sin(0.37 * (double)(i % 22) + 0.011 * (double)i));
        scale[i] = (uint8_t)(ISO_EXTINCTION_SCALE_ONE + 45 * sin(0.3 + 0.9 * (double)(i % 22)));
    }
    view.extinction_scale = scale;
    expect_picture(&p, &view, ISO_FROM_CODES, "an extinction scale");
    for (int r = 0; r < ISO_TF_2D_ROWS; ++r) {
        assert_ok(iso_tf_table_copy(&view.tf, &tf->rows[r], &err));
        for (size_t i = 0; i < view.tf.count; ++i) {
            tf->rows[r].entries[4 * i + 3] *= (float)r;
            tf->rows[r].entries[4 * i] *= 0.1f * (float)(r + 2);
        }
    }
    tf->bytes = bytes;
    view.tf_2d = tf;
    expect_picture(&p, &view, ISO_FROM_CODES, "a 2D transfer function");
}

/* Bricks that are made from samples when a ray looks into them. */
static void a_part_has_the_picture_of_the_whole(const volume_case *of, iso_gradient_method estimator, bool is_lit)
{
    iso_volume v = make_volume(of);
    OWNED(iso_pyramid) whole = {0}, part = {0};
    iso_pyramid_options build = options_of(of);
    iso_cpu_options opt = iso_cpu_defaults();
    build.gradient.method = estimator;
    assert_ok(iso_pyramid_build(&v, "noise", &build, &whole, NULL, &err));
    assert_ok(iso_pyramid_begin(&v, "noise", &build, &part, &err));
    assert_null(part.levels[0].scalar);
    assert_null(part.levels[0].codes);
    OWNED(iso_view) view = make_view(&whole, false);
    if (!is_lit)
        view.shading.diffuse = view.shading.specular = 0;
    assert_int_equal(iso_view_is_lit(&view), is_lit);
    OWNED(iso_image) image = draw(&whole, &view, opt);
    for (int skip = ISO_CPU_SKIP_AUTO; skip <= ISO_CPU_SKIP_ALWAYS; ++skip) {
        opt.skip = (iso_cpu_skip)skip;
        opt.threads = 1 + skip;
        opt.width = skip ? ISO_CPU_ONE : ISO_CPU_WIDEST;
        opt.once = true;
        expect_same_bits(&part, &view, opt, &image, iso_type_name(of->type));
        expect_same_bits(&whole, &view, opt, &image, iso_type_name(of->type));
    }
    /* Another code of the whole is seen. */
    memset(whole.levels[0].codes, 0, 3 * iso_geometry_voxel_count(&whole.levels[0].geometry));
    OWNED(iso_image) unlike = draw(&whole, &view, opt);
    assert_int_equal(memcmp(image.rgba, unlike.rgba, 4 * image.width * image.height * sizeof(float)) != 0, is_lit);
    /* Another sample is seen. */
    const size_t middle = iso_geometry_voxel_count(&part.volume->geometry) / 2 + of->size[0] / 2;
    memset((char *)part.volume->data + middle * iso_type_bytes(of->type), 0, 3 * iso_type_bytes(of->type));
    OWNED(iso_image) other = draw(&part, &view, opt);
    assert_memory_not_equal(image.rgba, other.rgba, 4 * image.width * image.height * sizeof(float));
}

TEST(bricks_that_are_made_for_rays_have_the_same_bits)
{
    static const volume_case cases[] = {{ISO_U8, ISO_CODE_FIT, {35, 18, 50}, false},
                                        {ISO_I16, ISO_CODE_FIT, {17, 33, 16}, false},
                                        {ISO_F32, ISO_CODE_REGION48, {40, 21, 19}, false},
                                        {ISO_I32, ISO_CODE_FIT, {5, 40, 3}, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        for (int is_lit = 0; is_lit < 2; ++is_lit)
            a_part_has_the_picture_of_the_whole(&cases[i],
                                                (iso_gradient_method)((i + (size_t)is_lit) % ISO_GRADIENT_COUNT),
                                                is_lit);
}

TEST(a_part_becomes_the_whole)
{
    const volume_case of = {ISO_U16, ISO_CODE_FIT, {12, 9, 7}, false};
    const iso_pyramid_options opt = options_of(&of);
    iso_volume v = make_volume(&of);
    OWNED(iso_pyramid) whole = make_pyramid(&of), part = {0};
    assert_ok(iso_pyramid_begin(&v, "noise", &opt, &part, &err));
    assert_null(v.data);
    iso_cpu_options without = iso_cpu_defaults();
    OWNED(iso_view) view = make_view(&whole, false);
    iso_image image;
    without.source = ISO_FROM_FLOAT;
    assert_status(iso_cpu_render(&part.levels[0], opt.code, &view, &without, &image, &err), ISO_E_RANGE);
    assert_ok(iso_pyramid_complete(&part, NULL, &err));
    const size_t count = iso_geometry_voxel_count(&whole.levels[0].geometry);
    assert_memory_equal(part.levels[0].scalar, whole.levels[0].scalar, count * sizeof(float));
    assert_memory_equal(part.levels[0].codes, whole.levels[0].codes, 3 * count);
    assert_true(part.levels[0].min == whole.levels[0].min && part.levels[0].max == whole.levels[0].max);
}

/* A cell shows if its eight values reach what the transfer function shows. */
static size_t wrong_cells(const iso_pyramid *p, const iso_tf_table *tf, const iso_cast_blocks *b)
{
    const size_t *n = p->levels[0].geometry.size;
    size_t wrong = 0, at[3];
    for (at[2] = 0; at[2] <= n[2]; ++at[2])
        for (at[1] = 0; at[1] <= n[1]; ++at[1])
            for (at[0] = 0; at[0] <= n[0]; ++at[0]) {
                float min = INFINITY, max = -INFINITY;
                for (size_t i = 0; i < 8; ++i) {
                    size_t v = 0;
                    for (int a = 2; a >= 0; --a)
                        v = v * n[a] + iso_cast_inner(at[a] + (i >> a & 1), n[a]);
                    min = fminf(min, p->levels[0].scalar[v]);
                    max = fmaxf(max, p->levels[0].scalar[v]);
                }
                const size_t block = at[0] / 4 + b->count[0] * (at[1] / 4 + b->count[1] * (at[2] / 4));
                const size_t bit = at[0] % 4 + 4 * (at[1] % 4) + 16 * (at[2] % 2);
                const bool shows = b->cells[2 * block + at[2] / 2 % 2] >> bit & 1;
                wrong += shows != iso_tf_shows(tf, (double)min, (double)max);
            }
    return wrong;
}

/* Of transfer functions with one and with two ranges of visible values, at the ends and inside. */
TEST(cells_show_what_their_values_reach)
{
    static const double opacities[][5] = {{0, 0, 1, 1, 1}, {1, 1, 0, 0, 0}, {0, 1, 0, 0, 0}, {1, 0, 0, 1, 1},
                                          {0, 1, 0, 1, 0}, {0, 0, 0, 0, 0}, {1, 1, 1, 1, 1}};
    static const volume_case cases[] = {{ISO_U8, ISO_CODE_FIT, {18, 9, 7}, false},
                                        {ISO_F32, ISO_CODE_FIT, {4, 11, 10}, false}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        OWNED(iso_pyramid) p = make_pyramid(&cases[c]);
        for (size_t t = 0; t < sizeof opacities / sizeof *opacities; ++t) {
            OWNED(iso_view) view = make_view(&p, false);
            OWNED(iso_cast_blocks) blocks;
            for (size_t i = 0; i < view.tf.count; ++i)
                view.tf.entries[4 * i + 3] = (float)opacities[t][5 * i / view.tf.count];
            assert_ok(iso_cast_blocks_create(&blocks, &p.levels[0], &view.tf, 2, &err));
            assert_int_equal(wrong_cells(&p, &view.tf, &blocks), 0);
            blocks.cells[0] ^= 1;
            assert_int_equal(wrong_cells(&p, &view.tf, &blocks), 1);
        }
    }
}

/* Planted: a volume that stands a thousandth of a voxel off, and a step that is a thousandth longer, are far beyond the
 * limits that validation holds the renderer to. */
TEST(what_is_a_little_wrong_is_beyond_the_limits)
{
    const volume_case of = {ISO_U8, ISO_CODE_FIT, {22, 27, 17}, false};
    OWNED(iso_pyramid) p = make_pyramid(&of);
    OWNED(iso_view) view = make_view(&p, false);
    iso_cpu_options opt = iso_cpu_defaults();
    OWNED(iso_image) image = draw(&p, &view, opt);
    const iso_vec3 origin = p.levels[0].geometry.origin_mm;
    p.levels[0].geometry.origin_mm = iso_add(origin, iso_v3(1e-3, 1e-3, 1e-3));
    OWNED(iso_image) shifted = draw(&p, &view, opt);
    assert_more_than(difference_of(&image, &shifted).max_abs, 4 * MAX_ABS);
    p.levels[0].geometry.origin_mm = origin;
    opt.step_voxels = 1.001 * view.step_voxels;
    OWNED(iso_image) stepped = draw(&p, &view, opt);
    assert_more_than(difference_of(&image, &stepped).max_abs, 4 * MAX_ABS);
}

TEST(what_it_cannot_draw_is_refused)
{
    const volume_case of = {ISO_U8, ISO_CODE_FIT, {5, 6, 7}, false};
    OWNED(iso_pyramid) p = make_pyramid(&of);
    OWNED(iso_view) view = make_view(&p, false);
    iso_cpu_options opt = iso_cpu_defaults();
    iso_image image;
    opt.step_voxels = NAN;
    view.step_voxels = NAN;
    assert_status(iso_cpu_render(&p.levels[0], p.options.code, &view, &opt, &image, &err), ISO_E_RANGE);
    opt.step_voxels = 1;
    opt.width = (iso_cpu_width)3;
    assert_status(iso_cpu_render(&p.levels[0], p.options.code, &view, &opt, &image, &err), ISO_E_RANGE);
    opt.width = ISO_CPU_WIDEST;
    opt.source = ISO_FROM_PALETTE;
    assert_status(iso_cpu_render(&p.levels[0], p.options.code, &view, &opt, &image, &err), ISO_E_RANGE);
}

TEST_MAIN(NULL, NULL)
