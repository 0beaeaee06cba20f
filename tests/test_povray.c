/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
/* POV-Ray against the reference. These tests fail, not skip, without POV-Ray. */
#include <signal.h>

#include "base/file.h"
#include "base/process.h"
#include "compare/extrapolation.h"
#include "image/image.h"
#include "povray/df3.h"
#include "povray/povray.h"
#include "render/reference.h"
#include "povray_scenes.h"
#include "pyramid/narrow.h"
#include "scene/level_view.h"
#include "test.h"

static void check_lock_step(comparison c)
{
    double rmse;
    assert_at_most(compare(&c, &rmse), lock_step_max);
    end_comparison(&c);
}

TEST(lock_step_agrees_in_perspective)
{
    check_lock_step(lock_step(0, false, 256));
}

TEST(lock_step_agrees_in_orthographic_projection)
{
    check_lock_step(lock_step(1, true, 256));
}

TEST(lock_step_agrees_with_a_table_of_4096_entries)
{
    check_lock_step(lock_step(1, false, 4096));
}

TEST(lock_step_agrees_from_inside_the_volume)
{
    comparison c = lock_step(0, false, 256);
    c.view.camera.position = iso_madd(iso_geometry_box_center_mm(&c.pyramid.levels[0].geometry), c.view.camera.right,
                                      5);
    check_lock_step(c);
}

TEST(lock_step_agrees_with_planes)
{
    ENDED_BY(end_comparison) comparison c = lock_step(0, false, 256);
    double most;
    iso_image wanted;
    iso_reference_options opt = iso_reference_defaults();
    c.options.planes = 3;
    c.options.intervals = 20;
    opt.quadrature = c.quadrature;
    opt.intervals = c.options.intervals;
    render_povray(&c.pyramid, c.level, &c.view, &c.options, &c.image);
    for (opt.planes = 2; opt.planes <= 3; ++opt.planes) {
        assert_ok(iso_reference_render(&c.pyramid.levels[0], ISO_CODE_SNORM, &c.view, &opt, &wanted, NULL, &err));
        most = difference_of(&c.image, &wanted).max_abs;
        if (opt.planes == 3)
            assert_at_most(most, lock_step_max);
        else
            assert_more_than(most, 5 * lock_step_max);
        iso_image_destroy(&wanted);
    }
}

TEST(lock_step_agrees_with_float_directions)
{
    ENDED_BY(end_comparison) comparison c = lock_step(1, false, 256);
    c.options.float_directions = true;
    iso_reference_options opt = iso_reference_defaults();
    opt.quadrature = c.quadrature;
    opt.source = ISO_FROM_FLOAT;
    opt.intervals = c.options.intervals;
    OWNED(iso_image) wanted;
    double rmse;
    render_povray(&c.pyramid, c.level, &c.view, &c.options, &c.image);
    assert_ok(iso_reference_render(&c.pyramid.levels[1], ISO_CODE_SNORM, &c.view, &opt, &wanted, NULL, &err));
    assert_at_most(difference_of(&c.image, &wanted).max_abs, lock_step_max);
    /* Their own reference, not the codes': half a code step turns a direction by .2 degrees. */
    assert_more_than(compare(&c, &rmse), 10 * lock_step_max);
}

static void plant_half_voxel_shift(comparison *c)
{
    iso_geometry *g = &c->pyramid.levels[c->level].geometry;
    g->origin_mm = iso_madd(g->origin_mm, iso_column(g->index_to_world, 0), 0.5);
}

static void plant_swapped_axes(comparison *c)
{
    iso_mat3 *m = &c->pyramid.levels[c->level].geometry.index_to_world;
    for (int r = 0; r < 3; ++r) {
        const double keep = m->m[r][0];
        m->m[r][0] = m->m[r][1];
        m->m[r][1] = keep;
    }
}

static void plant_srgb_tf(comparison *c)
{
    for (size_t i = 0; i < 4 * c->view.tf.count; ++i) {
        const double v = (double)c->view.tf.entries[i];
        if (i % 4 != 3)
            c->view.tf.entries[i] = (float)(v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055);
    }
}

static void plant_light_from_the_wrong_side(comparison *c)
{
    c->view.lights[0].direction.x *= -1;
}

typedef void (*fault)(comparison *);
static const fault faults[] = {plant_half_voxel_shift, plant_swapped_axes, plant_srgb_tf,
                               plant_light_from_the_wrong_side};

/* Each fault, planted into what the reference sees, is far beyond the threshold that the clean comparison keeps. */
static void check_faults(comparison (*make)(size_t level), bool by_rmse, double threshold)
{
    ENDED_BY(end_comparison) comparison c = make(1);
    double rmse, most = compare(&c, &rmse);
    assert_at_most(by_rmse ? rmse : most, threshold);
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        ENDED_BY(end_comparison) comparison bad = make(1);
        bad.image = c.image;
        faults[i](&bad);
        most = compare(&bad, &rmse);
        assert_more_than(by_rmse ? rmse : most, 5 * threshold);
        bad.image = (iso_image){0};
    }
}

static comparison lock_step_of_level(size_t level)
{
    return lock_step(level, false, 256);
}

TEST(lock_step_agrees_at_a_level_that_overhangs_and_rejects_planted_faults)
{
    check_faults(lock_step_of_level, false, lock_step_max);
}

TEST(converged_agrees_and_rejects_planted_faults)
{
    check_faults(converged, true, converged_rmse);
}

/* Replaces the pyramid by one whose voxels have no data in a corner and in every seventh plane. */
static void remove_data(comparison *c)
{
    const iso_level *l = &c->pyramid.levels[0];
    const size_t *n = l->geometry.size;
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &l->geometry, ISO_F32, "field", &err));
    v.geometry.has_no_data = true;
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        const size_t x = i % n[0], y = i / n[0] % n[1];
        ((float *)v.data)[i] = (x > 25 && y < 30) || y % 7 == 3 ? ISO_NO_DATA : l->scalar[i];
    }
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = 2;
    opt.code = ISO_CODE_SNORM;
    release(&c->pyramid);
    assert_ok(iso_pyramid_build(&v, "field", &opt, &c->pyramid, NULL, &err));
}

/* The planted fault: values in 1/17 of the cells next to voxels without data, as the stand-in of other files gives. */
static void plant_values_without_data(iso_level *l)
{
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i)
        if (iso_is_no_data(l->scalar[i]))
            l->scalar[i] = iso_level_stand_in(l, ISO_STAND_IN_FILE);
}

TEST(lock_step_agrees_without_data_in_some_voxels)
{
    for (size_t level = 0; level < 2; ++level) {
        comparison c = lock_step(level, false, 256);
        double rmse;
        bool found;
        remove_data(&c);
        assert_ok(iso_view_take_level(&c.view, &c.pyramid, level, &found, &err));
        assert_true(!found && !c.view.extinction_scale == (level == 0));
        assert_at_most(compare(&c, &rmse), lock_step_max); /* no sample is in the 1/16385 of a cell */
        iso_povray_options surface = c.options;
        iso_image none;
        surface.isosurface = true;
        surface.iso = 30000;
        assert_status(iso_povray_render(&c.pyramid, level, &c.view, &surface, &none, NULL, &err), ISO_E_USAGE);
        plant_values_without_data(&c.pyramid.levels[level]);
        assert_more_than(compare(&c, &rmse), 50 * lock_step_max);
        iso_pyramid_destroy(&c.pyramid);
        c.pyramid = (iso_pyramid){0};
        iso_view_destroy(&c.view);
        c.view.tf.entries = NULL;
        end_comparison(&c);
    }
}

TEST(halving_the_intervals_quarters_the_error_and_the_limit_lies_within_its_bars)
{
    ENDED_BY(end_comparison) comparison c = converged(1);
    iso_image images[3], limit, reference;
    double error[3], limit_error;
    iso_extrapolation bar;
    c.options.planes = 0;
    c.options.extrapolate = false;
    render_reference(&c.pyramid, 1, &c.view, c.quadrature, 1, 0, &reference);
    for (size_t i = 0; i < 3; ++i) {
        c.options.intervals = (size_t)30 << i;
        render_povray(&c.pyramid, c.level, &c.view, &c.options, &images[i]);
        error[i] = difference_of(&images[i], &reference).rmse;
    }
    assert_ok(iso_richardson(&images[1], &images[2], 2, 2, &limit, &bar, &err));
    /* Second order; where cells' borders fall between the samples is chance, and scatters it. */
    assert_within(log2(error[0] / error[1]), 2, 0.5);
    assert_within(log2(error[1] / error[2]), 2, 0.5);
    /* Independent errors e and 4 e of the two finest would leave 1.9 e in the limit, at a bar of 1.4 e. */
    limit_error = difference_of(&limit, &reference).rmse;
    assert_at_most(limit_error, 2 * bar.error_bar + 1e-5);
    iso_image_destroy(&reference);
    plant_half_voxel_shift(&c);
    render_reference(&c.pyramid, 1, &c.view, c.quadrature, 1, 0, &reference);
    limit_error = difference_of(&limit, &reference).rmse;
    assert_more_than(limit_error, 2 * bar.error_bar + 1e-5);
    iso_image_destroy(&reference);
    for (size_t i = 0; i < 3; ++i)
        iso_image_destroy(&images[i]);
    iso_image_destroy(&limit);
}

static uint32_t big_endian(const char *bytes, size_t count)
{
    uint32_t value = 0;
    for (size_t i = 0; i < count; ++i)
        value = value << 8 | (uint8_t)bytes[i];
    return value;
}

TEST(df3_files_are_big_endian_with_a_rim_of_edge_values)
{
    char *dir = iso_make_temp_dir(), *path = iso_path_join(dir, "a.df3"), *data;
    const size_t size[3] = {4, 3, 2};
    float values[24];
    for (int i = 0; i < 24; ++i)
        values[i] = (float)(1000 * (i / 12) + 100 * (i / 4 % 3) + i % 4);
    for (unsigned bits = 8; bits <= 32; bits *= 2) {
        const iso_df3_coding coding = {bits, 0, bits == 8 ? 2550 : bits == 16 ? 65535 : 4294967295.0};
        size_t bytes;
        assert_ok(iso_df3_write(path, size, values, 1, 0, &coding, &err));
        assert_ok(iso_file_read(path, &data, &bytes, &err));
        assert_int_equal(bytes, 6 + 6 * 5 * 4 * bits / 8);
        assert_int_equal(big_endian(data, 2), 6);
        assert_int_equal(big_endian(data + 2, 2), 5);
        assert_int_equal(big_endian(data + 4, 2), 4);
        for (int z = 0; z < 4; ++z)
            for (int y = 0; y < 5; ++y)
                for (int x = 0; x < 6; ++x) {
                    const int cx = x < 1   ? 0
                                   : x > 4 ? 3
                                           : x - 1,
                              cy = y < 1   ? 0
                                   : y > 3 ? 2
                                           : y - 1,
                              cz = z < 2 ? 0 : 1;
                    const double value = 1000 * cz + 100 * cy + cx;
                    const uint32_t sample = big_endian(data + 6 + (size_t)((z * 5 + y) * 6 + x) * bits / 8, bits / 8);
                    assert_int_equal(sample, (uint32_t)(bits == 8 ? floor(value / 10 + 0.5) : value));
                }
        free(data);
    }
    const iso_df3_coding coding = {8, 0, 1};
    assert_status(iso_df3_write(path, (size_t[]){65534, 1, 1}, values, 1, 0, &coding, &err), ISO_E_RANGE);
    iso_remove_tree(dir);
    free(path);
    free(dir);
}

/* Voxels of several channels in stretches of a few that are alike, and of others. */
enum { RUN_CHANNELS = 2, RUN_X = 37, RUN_Y = 3, RUN_Z = 2 };
typedef struct run_source {
    float values[RUN_Z * RUN_Y * RUN_X][RUN_CHANNELS];
    size_t read;
    bool lies; /* the planted fault: different values are reported as equal */
} run_source;

static bool is_even(size_t voxel)
{
    return voxel % RUN_X / 5 % 2 == 0;
}

static size_t next_run(const void *user, size_t first, size_t count, bool *alike)
{
    const run_source *s = user;
    size_t n = 1;
    *alike = s->lies || is_even(first);
    while (n < count && is_even(first + n) == is_even(first))
        ++n;
    return n;
}

static void read_run(const void *user, size_t first, size_t count, float *out)
{
    run_source *s = (run_source *)user;
    memcpy(out, s->values[first], count * sizeof *s->values);
    s->read += count;
}

TEST(df3_files_of_runs_are_those_of_all_samples)
{
    run_source user = {.read = 0};
    char *dir = iso_make_temp_dir(), *paths[3], *data[3];
    const size_t count = sizeof user.values / sizeof *user.values;
    for (size_t i = 0; i < count; ++i)
        for (size_t c = 0; c < RUN_CHANNELS; ++c)
            user.values[i][c] = is_even(i) ? 0.25f + 0.5f * (float)c : (float)(i * (c + 1) % 97) / 97;
    for (size_t i = 0; i < 3; ++i)
        paths[i] = iso_path_join(dir, (const char *const[]){"a.df3", "b.df3", "all.df3"}[i]);
    for (unsigned bits = 8; bits <= 32; bits *= 2)
        for (int lies = 0; lies < 2; ++lies) {
            const iso_df3_coding coding = {bits, 0, 1};
            const iso_df3_source source = {
                .size = {RUN_X, RUN_Y, RUN_Z}, .channels = 2, .read = read_run, .run = next_run, .user = &user};
            user.read = 0;
            user.lies = lies > 0;
            assert_ok(iso_df3_write_from(&source, (const char *const *)paths, &coding, 1, &err));
            assert_true(user.read < (RUN_Y + 2) * (RUN_Z + 2) * RUN_X);
            for (size_t c = 0; c < RUN_CHANNELS; ++c) {
                size_t size[2];
                assert_ok(iso_df3_write(paths[2], source.size, user.values[0], RUN_CHANNELS, c, &coding, &err));
                assert_ok(iso_file_read(paths[c], &data[c], &size[0], &err));
                assert_ok(iso_file_read(paths[2], &data[2], &size[1], &err));
                assert_int_equal(size[0], size[1]);
                assert_int_equal(memcmp(data[c], data[2], size[0]) != 0, lies);
                free(data[c]);
                free(data[2]);
            }
        }
    for (size_t i = 0; i < 3; ++i)
        free(paths[i]);
    iso_remove_tree(dir);
    free(dir);
}

/* Of colors, which a PNG holds from 0 to 1. */
static double largest_color_difference(const iso_image *png, const iso_image *image)
{
    double most = 0;
    assert_int_equal(png->width, image->width);
    assert_int_equal(png->height, image->height);
    for (size_t i = 0; i < 4 * image->width * image->height; ++i)
        if (i % 4 != 3)
            most = fmax(most, fabs((double)png->rgba[i] - fmin((double)image->rgba[i], 1)));
    return most;
}

/* Half a step of 16 bits, 7.6e-6 as sRGB, is 2.27 times that in linear light where it is brightest; and half a step of
 * both of the passes that a render is made of. */
static const double png_max = 4e-5;

TEST(an_exported_folder_renders_where_it_lies)
{
    ENDED_BY(end_comparison) comparison c = lock_step(1, true, 300);
    c.options.planes = 2;
    FREED char *base = iso_make_temp_dir(), *dir = iso_path_join(base, "two words"), *program;
    assert_ok(iso_povray_export(&c.pyramid, 1, &c.view, dir, &c.options, NULL, &err));
    static const char *const names[] = {"two_words.pov",        "two_words.inc",    "two_words.ini",
                                        "two_words_scalar.df3", "two_words_dx.df3", "two_words_dy.df3",
                                        "two_words_dz.df3"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        FREED char *path = iso_path_join(dir, names[i]);
        assert_true(iso_path_exists(path));
    }
    assert_ok(iso_process_find("povray", "povray", &program, &err));
    const char *argv[] = {program, "two_words.ini", NULL};
    const iso_process_options options = {.directory = dir};
    assert_ok(iso_process_run(argv, &options, &err));
    FREED char *png = iso_path_join(dir, "two_words.png");
    OWNED(iso_image) picture;
    assert_ok(iso_image_load_png(png, &picture, &err));
    render_povray(&c.pyramid, 1, &c.view, &c.options, &c.image);
    assert_at_most(largest_color_difference(&picture, &c.image), png_max);
    iso_image_destroy(&c.image);
    c.options.intervals /= 2; /* another step is another picture */
    render_povray(&c.pyramid, 1, &c.view, &c.options, &c.image);
    assert_more_than(largest_color_difference(&picture, &c.image), 2 * png_max);
    /* The same name again replaces it, but for what POV-Ray drew into it; a folder of something else stays. */
    assert_status(iso_povray_export(&c.pyramid, 0, &c.view, dir, &c.options, NULL, &err), ISO_E_IO);
    assert_true(iso_path_exists(png));
    assert_int_equal(remove(png), 0);
    assert_ok(iso_povray_export(&c.pyramid, 0, &c.view, dir, &c.options, NULL, &err));
    assert_status(iso_povray_export(&c.pyramid, 0, &c.view, base, &c.options, NULL, &err), ISO_E_IO);
    iso_remove_tree(base);
}

TEST(options_outside_their_limits_are_refused)
{
    ENDED_BY(end_comparison) comparison c = lock_step(0, false, 256);
    iso_image image;
    const iso_povray_options good = c.options;
    iso_povray_options bad = good;
    assert_status(iso_povray_render(&c.pyramid, 2, &c.view, &good, &image, NULL, &err), ISO_E_RANGE);
    bad.intervals = 256;
    assert_status(iso_povray_render(&c.pyramid, 0, &c.view, &bad, &image, NULL, &err), ISO_E_RANGE);
    bad = good;
    bad.planes = 101;
    assert_status(iso_povray_render(&c.pyramid, 0, &c.view, &bad, &image, NULL, &err), ISO_E_RANGE);
    bad = good;
    bad.df3_bits = 12;
    assert_status(iso_povray_render(&c.pyramid, 0, &c.view, &bad, &image, NULL, &err), ISO_E_RANGE);
}

TEST(a_missing_program_is_named)
{
    ENDED_BY(end_comparison) comparison c = lock_step(1, false, 256);
    iso_image image;
    char version[32];
    setenv("ISOSHADE_POVRAY", "/no/such/povray", 1);
    assert_status(iso_povray_render(&c.pyramid, 1, &c.view, &c.options, &image, NULL, &err), ISO_E_MISSING);
    assert_status(iso_povray_version(version, sizeof version, &err), ISO_E_MISSING);
    setenv("ISOSHADE_POVRAY", "/bin/false", 1);
    assert_status(iso_povray_version(version, sizeof version, &err), ISO_E_PROGRAM);
    assert_status(iso_povray_render(&c.pyramid, 1, &c.view, &c.options, &image, NULL, &err), ISO_E_PROGRAM);
    unsetenv("ISOSHADE_POVRAY");
    assert_ok(iso_povray_version(version, sizeof version, &err));
    assert_true(strncmp(version, "3.", 2) == 0);
}

/* A POV-Ray whose threads did not start in time, and that stays. */
static const char *const late_and_stays[] = {"/bin/sh", "-c",
                                             "echo Timed out waiting for worker thread startup; exec sleep 3600", NULL};

static void count_line(void *user, const char *line)
{
    (void)line;
    ++*(int *)user;
}

TEST(one_that_is_ended_at_its_limit_is_not_started_again)
{
    int lines = 0;
    iso_process_outcome outcome;
    const iso_process_options options = {.line = count_line,
                                         .user = &lines,
                                         .timeout_seconds = 0.5,
                                         .outcome = &outcome};
    assert_status(iso_povray_run_program(late_and_stays, &options, &err), ISO_E_PROGRAM);
    assert_true(outcome.timed_out);
    assert_true(lines <= 1);
}

static void count_and_interrupt(void *user, const char *line)
{
    count_line(user, line);
    raise(SIGTERM);
}

/* The last one: who was interrupted starts nothing again. */
TEST(one_that_a_person_ends_is_not_started_again)
{
    int lines = 0;
    const iso_process_options options = {.line = count_and_interrupt, .user = &lines};
    iso_error err = {""};
    assert_int_equal(iso_povray_run_program(late_and_stays, &options, &err), ISO_E_PROGRAM);
    assert_non_null(strstr(err.text, "stopped by signal 15"));
    assert_int_equal(lines, 1);
}

TEST_MAIN(NULL, NULL)
