/* SPDX-License-Identifier: MIT */
/* Figures from a report: what they hold, where panels stand, the scale bar's length, and what is refused. */
#define _GNU_SOURCE
#include <sys/stat.h>

#include "base/file.h"
#include "figure/job.h"
#include "figure/page_text.h"
#include "figure/sheet.h"
#include "report/report.h"
#include "scene/scene.h"
#include "tests/folder.h"
#include "tests/test.h"

static const iso_cli none;

static iso_figure_job job_of(const char *kind, const char *report, const char *out)
{
    iso_figure_job job = {.input = report,
                          .output = out,
                          .cli = &none,
                          .width_mm = 178,
                          .height_mm = 230,
                          .dpi = 72,
                          .formats = "pdf",
                          .with_sources = true};
    assert_ok(iso_figure_kind_from_name(&iso_figure_kind_names, kind, &job.kind, &err));
    assert_ok(iso_colormap_from_name("magma", &job.map, &err));
    return job;
}

enum { width = 40, height = 30 };

static char *inside(const char *name)
{
    char *path = iso_path_join(folder, name);
    assert_non_null(path);
    return path;
}

static void read_text(const char *dir, const char *name, char **text, size_t *size)
{
    FREED char *path = iso_path_join(dir, name);
    assert_ok(iso_file_read(path, text, size, &err));
}

/* Gray, brighter by `bias` in the left half. */
static void add_picture(iso_report *r, const char *name, double bias, double mm_per_pixel)
{
    OWNED(iso_image) image;
    assert_ok(iso_image_create(&image, width, height, &err));
    for (size_t i = 0; i < (size_t)width * height; ++i)
        for (size_t c = 0; c < 4; ++c)
            image.rgba[4 * i + c] = c == 3 ? 1 : 0.25f + (i % width < width / 2 ? (float)bias : 0);
    assert_ok(iso_report_add_image(r, name, &image, name, &err));
    iso_report_set_scale(r, name, mm_per_pixel);
}

static char *make_report(const char *name, double mm_per_pixel)
{
    char *dir = inside(name);
    iso_report *r;
    const iso_report_about about = {.title = "t", .volume = "gray, \"quoted\".nrrd", .scene = "s"};
    assert_ok(iso_report_create(&r, dir, &about, &err));
    add_picture(r, "fine", 0, mm_per_pixel);
    const char *const methods[] = {"a", "b, c", "d"};
    for (int m = 0; m < 3; ++m)
        for (size_t level = 1; level < 3; ++level) {
            char image[32];
            snprintf(image, sizeof image, "m%d-%zu", m, level);
            add_picture(r, image, 0.125 * (double)level, mm_per_pixel);
            iso_report_consistency row = {.level = level,
                                          .views = 1,
                                          .method = methods[m],
                                          .image = image,
                                          .ssim_dissimilarity_mean = 0.0321,
                                          .reference_image = "fine"};
            assert_ok(iso_report_add_consistency(r, &row, &err));
            /* Adapted, half as far off; refused at level 1. */
            row.adapted = true;
            row.original_kept = level == 1 ? "no nearer" : NULL;
            snprintf(image, sizeof image, "m%d-%zu-own", m, level);
            add_picture(r, image, level == 1 ? 0.125 : 0.0625 * (double)level, mm_per_pixel);
            assert_ok(iso_report_add_consistency(r, &row, &err));
        }
    iso_report_agreement row = {.level = 1,
                                .scene = "s",
                                .a = "reference",
                                .renderer = "gl",
                                .image_a = "fine",
                                .image_b = "m0-1",
                                .tolerances = {.rmse = 1},
                                .error_bar = NAN};
    assert_ok(iso_report_add_agreement(r, &row, &err));
    assert_ok(iso_report_finish(r, &err));
    iso_report_destroy(r);
    return dir;
}

typedef struct row {
    int kind;
    char file[32], title[96], note[96], side[96], bar_text[32];
    double w, h, left, right, bottom, top, bar, low, high, logs, figure_width, figure_height;
} row;

static size_t read_rows(const char *dir, row *rows, size_t room)
{
    FREED char *text;
    size_t size, count = 0;
    read_text(dir, "figure.csv", &text, &size);
    for (char *line = strchr(text, '\n') + 1; *line && count < room; line = strchr(line, '\n') + 1) {
        row *r = &rows[count++];
        assert_int_equal(
            sscanf(line, "%d,%31[^,],%lf,%lf,%lf,%lf,%lf,%lf,%95[^,],%95[^,],%95[^,],%lf,%31[^,],%lf,%lf,%lf,%lf,%lf",
                   &r->kind, r->file, &r->w, &r->h, &r->left, &r->right, &r->bottom, &r->top, r->title, r->note,
                   r->side, &r->bar, r->bar_text, &r->low, &r->high, &r->logs, &r->figure_width, &r->figure_height),
            18);
    }
    return count;
}

static bool overlap(const row *a, const row *b)
{
    return a->left < b->right && b->left < a->right && a->bottom < b->top && b->bottom < a->top;
}

TEST(panels_lie_inside_and_apart_with_enough_pixels)
{
    FREED char *report = make_report("r1", 2), *out = inside("f1");
    row rows[32];
    for (int kind = 0; kind < 2; ++kind) {
        iso_figure_job job = job_of(kind == 0 ? "levels" : "renderers", report, out);
        job.level = kind;
        job.dpi = 300;
        assert_ok(iso_figure_make(&job, &err));
        size_t count = read_rows(out, rows, 32);
        assert_int_equal(count, kind == 0 ? 1 + 2 * 4 : 3); /* level 0, and of two methods two levels and two maps */
        for (size_t i = 0; i < count; ++i) {
            assert_true(rows[i].left >= 0 && rows[i].right <= 1 && rows[i].bottom >= 0 && rows[i].top <= 1);
            double inches = (rows[i].right - rows[i].left) * rows[i].figure_width / 96;
            assert_more_than(rows[i].w / inches, 299.9); /* rounding of the figures in the file */
            double aspect = (rows[i].top - rows[i].bottom) * rows[i].figure_height / (inches * 96);
            assert_within(aspect, (double)height / width, 1e-4);
            assert_at_most(rows[i].figure_width, job.width_mm / 25.4 * 96 + 0.1);
            for (size_t j = 0; j < i; ++j)
                assert_false(overlap(&rows[i], &rows[j]));
        }
    }
}

TEST(the_scale_bar_has_its_length)
{
    FREED char *report = make_report("r2", 2), *unknown = make_report("r3", 0), *out = inside("f2");
    iso_figure_job job = job_of("levels", report, out);
    row rows[32];
    assert_ok(iso_figure_make(&job, &err));
    read_rows(out, rows, 32);
    assert_string_equal(rows[0].bar_text, "20 mm"); /* 40 pixels of 2 mm: at most a third of 80 mm */
    assert_within(rows[0].bar, 0.25, 1e-6);
    assert_within(rows[1].bar, 0, 0);
    job.input = unknown;
    assert_ok(iso_figure_make(&job, &err));
    read_rows(out, rows, 32);
    assert_within(rows[0].bar, 0, 0);
}

/* Where the scale bar stands on a picture of 40 x 30 mm whose pixels are opaque where `is_shown` says so: its
 * middle. */
typedef bool shown_at(size_t x, size_t y);
static bool nowhere(size_t x, size_t y)
{
    return x > 2 * width && y > 2 * height;
}
static bool everywhere(size_t x, size_t y)
{
    return !nowhere(x, y);
}
static bool on_the_left(size_t x, size_t y)
{
    return 2 * x < width && y < height;
}
static bool below(size_t x, size_t y)
{
    return x < width && 2 * y > height;
}

static void find_bar(shown_at *is_shown, double *x, double *y)
{
    FREED char *out = inside("bar"), *text;
    size_t size;
    OWNED(iso_image) image;
    iso_page *page;
    double left, bottom, right, top;
    if (!iso_path_exists(out))
        assert_int_equal(mkdir(out, 0777), 0);
    assert_ok(iso_image_create(&image, width, height, &err));
    for (size_t i = 0; i < (size_t)width * height; ++i)
        image.rgba[4 * i + 3] = is_shown(i % width, i / width) ? 1 : 0;
    assert_ok(iso_page_create(&page, out, 72, &err));
    iso_page_set_size(page, 40, 30);
    iso_page_put_scale_bar(page, &(iso_page_box){.width = 40, .height = 30}, &image, 1);
    assert_ok(iso_page_finish(page, "pdf", 1, &err));
    iso_page_destroy(page);
    read_text(out, "figure.gp", &text, &size);
    const char *at = strstr(text, "set object rectangle");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "set object rectangle from %lf, %lf to %lf, %lf", &left, &bottom, &right, &top), 4);
    assert_within(right - left, 10, 1e-3); /* a third of 40 at most */
    *x = 0.5 * (left + right), *y = 0.5 * (bottom + top);
}

TEST(the_scale_bar_stands_where_little_is_shown)
{
    const struct {
        shown_at *is_shown;
        bool right, top;
    } cases[] = {{nowhere, false, false}, {everywhere, false, false}, {on_the_left, true, false}, {below, true, true}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        double x, y;
        find_bar(cases[i].is_shown, &x, &y);
        assert_int_equal(x > 20, cases[i].right);
        assert_int_equal(y < 15, cases[i].top);
    }
}

/* A soft volume fills the picture, or the text is wider than the picture: the caption has the width instead. */
TEST(a_picture_without_room_has_no_scale_bar)
{
    const struct {
        float opacity;
        double width_mm;
        bool has_bar;
    } cases[] = {{0.005f, 40, true}, {0.02f, 40, false}, {0, 40, true}, {0, 7, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        OWNED(iso_image) image;
        iso_page *page;
        assert_ok(iso_image_create(&image, width, height, &err));
        for (size_t p = 0; p < (size_t)width * height; ++p)
            image.rgba[4 * p + 3] = cases[i].opacity;
        assert_ok(iso_page_create(&page, folder, 72, &err));
        iso_page_set_size(page, 50, 50);
        const iso_page_box box = {.width = cases[i].width_mm, .height = 0.75 * cases[i].width_mm};
        assert_int_equal(iso_page_scale_bar_mm(page, &box, &image, 2.5) > 0, cases[i].has_bar);
        iso_page_destroy(page);
    }
}

TEST(numbers_are_written_for_readers)
{
    const struct {
        double value, apart;
        const char *text;
    } cases[] = {{0, 1, "0"},          {-0.2, 1, "0"},      {-1020.4, 10, "−1020"}, {12.5, 0.5, "12.5"},
                 {0.25, 0.01, "0.25"},  {99999, 1, "99999"}, {1e5, 1e5, "10⁵"},      {2.5e6, 5e5, "2.5×10⁶"},
                 {-1e6, 1e6, "−10⁶"},  {999999, 1e4, "10⁶"}, {5e-4, 5e-4, "5×10⁻⁴"}, {0, 1e-7, "0"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char text[64];
        iso_page_number(cases[i].value, cases[i].apart, text);
        assert_string_equal(text, cases[i].text);
    }
}

TEST(scales_end_at_round_numbers)
{
    const double rounded[][2] = {{0.443, 0.5}, {0.25, 0.25}, {0.99, 1}, {1, 1},
                                 {1.01, 1.2},  {7e-4, 8e-4}, {0, 1},    {NAN, 1}};
    for (size_t i = 0; i < sizeof rounded / sizeof *rounded; ++i)
        assert_within(iso_figure_round_up(rounded[i][0]), rounded[i][1], 1e-12);
}

TEST(maps_hold_the_differences)
{
    char *report = make_report("r4", 2), *out = inside("f4"), *data;
    size_t size;
    iso_figure_job job = job_of("levels", report, out);
    unsigned char colors[3];
    job.methods = "d";
    assert_ok(iso_figure_make(&job, &err));
    row rows[32];
    assert_int_equal(read_rows(out, rows, 32), 5);
    assert_within(rows[0].high, 0.25, 1e-6); /* of level 2, the larger */
    read_text(out, rows[2].file, &data, &size);
    assert_int_equal(size, (size_t)(rows[2].w * rows[2].h) * sizeof colors);
    iso_colormap_lookup(job.map, 0.125 / 0.25, colors);
    assert_memory_equal(data, colors, sizeof colors);
    iso_colormap_lookup(job.map, 0, colors);
    assert_memory_equal(data + sizeof colors * ((size_t)rows[2].w - 1), colors, sizeof colors);
    free(data);
    assert_non_null(strstr(rows[2].note, "RMSE 0.0765")); /* 1/8 in 3 of 4 channels of half the pixels */
    read_text(out, "caption.txt", &data, &size);
    assert_non_null(strstr(data, "d, level 2: 1 - SSIM 0.0321"));
    assert_null(strstr(data, "b, c"));
    free(data);
    free(report);
    free(out);
}

/* The adapted TF is a method of its own, by its name. */
TEST(the_adapted_tf_can_be_asked_for)
{
    FREED char *report = make_report("r7", 2), *out = inside("f7"), *data;
    size_t size;
    iso_figure_job job = job_of("levels", report, out);
    row rows[32];
    job.methods = "d,d+adapted";
    assert_ok(iso_figure_make(&job, &err));
    assert_int_equal(read_rows(out, rows, 32), 9); /* level 0 stands there once */
    assert_string_equal(rows[0].side, "d");
    assert_string_equal(rows[5].side, "d (adapted TF)");
    assert_non_null(strstr(rows[4].note, "RMSE 0.153"));  /* of level 2: 1/4 in 3 of 4 channels of half the pixels */
    assert_non_null(strstr(rows[8].note, "RMSE 0.0765")); /* planted otherwise: the original's */
    read_text(out, "caption.txt", &data, &size);
    assert_non_null(strstr(data, "d, level 1: "));
    assert_non_null(strstr(
        data,
        "d with the adapted transfer function, level 1: 1 - SSIM 0.0321, FLIP 0, direction error 0 degrees (adapting refused, the original kept)."));
    job.methods = "zz+adapted";
    iso_error why = {""};
    assert_int_equal(iso_figure_make(&job, &why), ISO_E_RANGE);
    assert_non_null(strstr(why.text, "\"zz+adapted\", but of a, a+adapted, ")); /* what there is */
}

TEST(text_is_vector_and_fonts_are_embedded)
{
    char *report = make_report("r5", 2), *out = inside("f5"), *data;
    size_t size;
    iso_figure_job job = job_of("levels", report, out);
    job.formats = "svg";
    assert_ok(iso_figure_make(&job, &err));
    read_text(out, "figure.pdf", &data, &size);
    assert_non_null(memmem(data, size, "FontFile", 8));
    free(data);
    read_text(out, "figure.svg", &data, &size);
    assert_non_null(strstr(data, ">level 2<"));
    assert_non_null(strstr(data, "20 mm"));
    assert_non_null(strstr(data, "data:image/png;base64")); /* pictures inside, not beside */
    free(data);
    free(report);
    free(out);
}

TEST(bad_requests_are_refused_and_leave_nothing)
{
    FREED char *report = make_report("r6", 2), *out = inside("f6"), *missing = inside("none");
    iso_figure_job job = job_of("levels", missing, out);
    assert_status(iso_figure_make(&job, &err), ISO_E_IO);
    job = job_of("levels", report, out);
    job.methods = "a,zz";
    assert_status(iso_figure_make(&job, &err), ISO_E_RANGE);
    job = job_of("levels", report, out);
    job.width_mm = NAN;
    assert_status(iso_figure_make(&job, &err), ISO_E_RANGE);
    job = job_of("renderers", report, out);
    job.level = 9;
    assert_status(iso_figure_make(&job, &err), ISO_E_RANGE);
    assert_false(iso_path_exists(out));
    FREED char *json = iso_path_join(report, "report.json");
    assert_ok(iso_file_write(json, "{\"schema\": \"other\"}", 19, &err));
    job = job_of("levels", report, out);
    assert_status(iso_figure_make(&job, &err), ISO_E_FORMAT);
    assert_status(iso_figure_kind_from_name(&iso_figure_kind_names, "photo", &job.kind, &err), ISO_E_USAGE);
}

/* A pixel's size from two rays: where neighbors meet the plane through the center of the box. */
TEST(the_pixel_of_a_view_is_measured_at_the_center)
{
    const size_t size[3] = {20, 30, 24};
    const double spacing[3] = {1, 0.5, 2};
    iso_geometry g = iso_geometry_axis_aligned(size, spacing);
    for (int orthographic = 0; orthographic < 2; ++orthographic) {
        iso_view view = {.width = 50, .height = 40};
        view.camera = (iso_camera){.orthographic = orthographic,
                                   .position = iso_v3(3, 4, 200),
                                   .forward = iso_v3(0, 0, -1),
                                   .right = iso_v3(1, 0, 0),
                                   .up = iso_v3(0, 1, 0),
                                   .half_height = orthographic ? 30 : 0.2};
        iso_ray a = iso_camera_ray(&view.camera, 50, 40, 24, 20), b = iso_camera_ray(&view.camera, 50, 40, 25, 20);
        double z = iso_geometry_box_center_mm(&g).z;
        double xa = a.origin.x + a.direction.x * (z - a.origin.z) / a.direction.z;
        double xb = b.origin.x + b.direction.x * (z - b.origin.z) / b.direction.z;
        assert_within(iso_view_mm_per_pixel(&view, &g), xb - xa, 1e-12);
    }
    iso_view behind = {.width = 50,
                       .height = 40,
                       .camera = {.position = {0, 0, 200}, .forward = {0, 0, 1}, .half_height = 1}};
    assert_within(iso_view_mm_per_pixel(&behind, &g), 0, 0);
}

TEST_MAIN(make_folder, remove_folder)
