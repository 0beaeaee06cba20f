/* SPDX-License-Identifier: MIT */
/* The report: verdicts, order, files, page, JUnit. With a path as argument the example is left there to look at. */
#define _GNU_SOURCE

#include "base/file.h"
#include "base/process.h"
#include "base/words.h"
#include "report/gnuplot.h"
#include "report/report.h"
#include "tests/folder.h"
#include "tests/test.h"

static size_t example_size = 48; /* pixels; larger for a look */

/* A shaded ball, shifted by `shift` pixels and `bias` brighter: something to look at. */
static iso_image ball(size_t size, double shift, double bias, double blur)
{
    iso_image image;
    assert_ok(iso_image_create(&image, size, size, &err));
    for (size_t y = 0; y < size; ++y)
        for (size_t x = 0; x < size; ++x) {
            double u = (2 * ((double)x + 0.5 - shift) / (double)size - 1) / 0.8;
            double v = (2 * ((double)y + 0.5) / (double)size - 1) / 0.8, r2 = u * u + v * v;
            double a = 1 / (1 + exp((r2 - 1) * 30 / (1 + blur))), z = sqrt(fmax(1 - r2, 0));
            double shade = 0.2 + 0.8 * fabs(0.5 * -u + 0.6 * -v + 0.62 * z) +
                           0.08 * sin(20 * u) * sin(17 * v) / (1 + blur);
            const double color[3] = {0.85, 0.55 + 0.2 * v, 0.35};
            for (int c = 0; c < 3; ++c)
                image.rgba[4 * (y * size + x) + (size_t)c] = (float)(a * shade * color[c] + bias);
            image.rgba[4 * (y * size + x) + 3] = (float)a;
        }
    return image;
}

static void add_image(iso_report *r, const char *name, iso_image *image)
{
    assert_ok(iso_report_add_image(r, name, image, "a ball", &err));
}

static iso_report_agreement compare(const iso_image *a, const iso_image *b)
{
    iso_report_agreement row = {.error_bar = NAN};
    assert_ok(iso_metrics_measure(a, b, &row.metrics, &err));
    return row;
}

static void add_consistency(iso_report *r)
{
    const char *const methods[] = {"on the fly", "naive average", "moments, codes"};
    for (int m = 0; m < 3; ++m)
        for (size_t level = 1; level < 4; ++level) {
            char name[64];
            double error = 0.02 * (double)(1 << level) * (1.2 - 0.3 * m);
            iso_image image = ball(example_size, 0, 0, error * 20);
            snprintf(name, sizeof name, "level%zu-method%d", level, m);
            add_image(r, name, &image);
            iso_image_destroy(&image);
            assert_ok(
                iso_report_add_consistency(r,
                                           &(iso_report_consistency){.level = level,
                                                                     .views = 20,
                                                                     .method = methods[m],
                                                                     .ssim_dissimilarity_mean = error,
                                                                     .flip_mean = error / 2,
                                                                     .gradient_angle_mean_deg = m == 0 ? NAN
                                                                                                       : 40 * error,
                                                                     .gradient_angle_p95_deg = 120 * error,
                                                                     .image = name,
                                                                     .reference_image = "reference-0"},
                                           &err));
            /* Under the adapted TF: at level 1 adapting is refused. */
            double part = level == 1 ? 1 : 0.6;
            assert_ok(iso_report_add_consistency(
                r,
                &(iso_report_consistency){.level = level,
                                          .views = 20,
                                          .method = methods[m],
                                          .adapted = true,
                                          .original_kept = level == 1 ? "it would be \"no\" nearer" : NULL,
                                          .ssim_dissimilarity_mean = part * error,
                                          .flip_mean = part * error / 2,
                                          .gradient_angle_mean_deg = m == 0 ? NAN : 40 * error,
                                          .gradient_angle_p95_deg = 120 * error,
                                          .image = name,
                                          .reference_image = "reference-0"},
                &err));
        }
}

static void add_agreement(iso_report *r)
{
    const double biases[] = {2e-7, 3e-6, 4e-5, 2e-3};
    const char *const renderers[] = {"gl", "povray", "cycles", "gl"}, *const variants[] = {"codes", "", "h/16",
                                                                                           "on the fly"};
    OWNED(iso_image) reference = ball(example_size, 0, 0, 0);
    add_image(r, "reference-0", &reference);
    for (size_t level = 0; level < 2; ++level)
        for (int k = 0; k < 4; ++k) {
            char name[64];
            OWNED(iso_image) image = ball(example_size, k == 3 && level ? 0.5 : 0, biases[k], 0);
            snprintf(name, sizeof name, "image%d-level%zu", k, level);
            add_image(r, name, &image);
            iso_report_agreement row = compare(&reference, &image);
            row.level = level, row.scene = "smooth <head> & \"neck\"", row.a = "reference", row.renderer = renderers[k],
            row.variant = variants[k];
            row.image_a = "reference-0", row.image_b = name, row.tier = "tight";
            row.error_bar = biases[k] / 2, row.tolerances = (iso_tolerances){.rmse = 1e-4, .max_abs = 1e-3};
            row.why = "same sampling in single precision: rounding of 1e-7 a sample over 300 samples.";
            row.command = "isoshade compare a.exr b.exr --max-rmse 1e-4 --max-abs 1e-3";
            if (k == 3 && level == 0) {
                row.tolerances = (iso_tolerances){.rmse = 1e-2};
                row.uncompared = ISO_UNCOMPARED_FAINT, row.uncompared_why = "the reference shows too little";
            }
            assert_ok(iso_report_add_agreement(r, &row, &err));
        }
    iso_report_agreement refused = {.level = 1,
                                    .scene = "thin shells",
                                    .a = "reference",
                                    .renderer = "cycles",
                                    .variant = "h/16",
                                    .error_bar = NAN,
                                    .refused = "Cycles failed its slab calibration: 0.02, limit 0.001",
                                    .tolerances = {.rmse = 1e-3}};
    assert_ok(iso_report_add_agreement(r, &refused, &err));
}

static iso_report *example(const char *dir)
{
    iso_report *r;
    const iso_report_about about = {"Shaded ball", "isoshade validate ball.nrrd --scene smooth.scene.json -o report",
                                    "ball.nrrd", "smooth.scene.json"};
    assert_ok(iso_report_create(&r, dir, &about, &err));
    iso_report_describe_machine(r);
    iso_report_put(r, "versions", "isoshade", json_string("0.1.0"));
    iso_report_put(r, "versions", "markup", json_string("</script><b>@DATA@"));
    iso_report_put(r, "options", "levels", json_integer(3));
    add_agreement(r);
    add_consistency(r);
    const iso_report_calibration checks[] = {
        {"gl", "texture filter keeps the bits of R16", 0.00001, 0.0001, "of range", "16 bits kept", false},
        {"cycles", "placement of the centroid", 0.003, 0.01, "voxels", NULL, false},
        {"cycles", "slab against 1 - exp(-sigma d)", 0.02, 0.001, NULL, "opacity of 0.5 and 2 mm", false},
    };
    for (int i = 0; i < 3; ++i)
        assert_ok(iso_report_add_calibration(r, &checks[i], &err));
    return r;
}

static char *inside(const char *name)
{
    char *path = iso_path_join(folder, name);
    assert_non_null(path);
    return path;
}

static void read_text(const char *path, char **text)
{
    size_t size;
    assert_ok(iso_file_read(path, text, &size, &err));
}

/* The object inside <script id="data">. */
static json_t *data_of_page(const char *page)
{
    const char *mark = "id=\"data\">";
    size_t start = (size_t)(strstr(page, mark) - page) + strlen(mark);
    size_t length = (size_t)(strstr(page + start, "</script>") - page) - start;
    return json_loadb(page + start, length, 0, NULL);
}

TEST(every_file_is_there_and_the_data_is_whole)
{
    FREED char *dir = inside("whole");
    iso_report *r = example(dir);
    assert_ok(iso_report_finish(r, &err));
    const char *const files[] = {"index.html",
                                 "report.json",
                                 "images/reference-0.exr",
                                 "images/reference-0.png",
                                 "charts/agreement.svg",
                                 "charts/agreement.csv",
                                 "charts/agreement.gp",
                                 "charts/consistency.svg",
                                 "charts/consistency.csv",
                                 "charts/consistency.gp",
                                 "charts/style.gp"};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; ++i) {
        char *path = iso_path_join(dir, files[i]);
        if (!iso_path_exists(path))
            fail_msg("%s is missing", files[i]);
        free(path);
    }
    char *path = iso_path_join(dir, "report.json");
    json_auto_t *root;
    assert_ok(iso_json_load(path, &root, &err));
    assert_string_equal(json_string_value(json_object_get(root, "schema")), "isoshade.validate/1");
    assert_string_equal(json_string_value(json_object_get(root, "verdict")), "differ");
    assert_int_equal(json_array_size(json_object_get(root, "agreement")), 9);
    assert_int_equal(json_array_size(json_object_get(root, "consistency")), 18);
    const char *const keys[] = {"level",   "scene",     "a",       "b",      "rmse", "max_abs",
                                "p99_abs", "error_bar", "verdict", "limits", "why"};
    const char *const more[] = {"level",
                                "method",
                                "tf",
                                "original_kept",
                                "views",
                                "ssim_dissimilarity_mean",
                                "flip_mean",
                                "gradient_angle_mean_deg",
                                "gradient_angle_p95_deg"};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i)
        assert_non_null(json_object_get(json_array_get(json_object_get(root, "agreement"), 3), keys[i]));
    for (size_t i = 0; i < sizeof more / sizeof more[0]; ++i)
        assert_non_null(json_object_get(json_array_get(json_object_get(root, "consistency"), 0), more[i]));
    free(path);
    iso_report_destroy(r);
}

TEST(the_worst_comes_first)
{
    FREED char *dir = inside("order");
    iso_report *r = example(dir);
    assert_ok(iso_report_finish(r, &err));
    const json_t *rows = json_object_get(iso_report_json(r), "agreement");
    const char *const wanted[] = {"differ", "refused", "not compared"};
    for (size_t i = 0; i < 3; ++i)
        assert_string_equal(json_string_value(json_object_get(json_array_get(rows, i), "verdict")), wanted[i]);
    double last = INFINITY;
    for (size_t i = 3; i < json_array_size(rows); ++i) {
        double severity = json_number_value(json_object_get(json_array_get(rows, i), "severity"));
        assert_at_most(severity, last);
        last = severity;
    }

    iso_report_destroy(r);
}

static size_t count_of(const char *text, const char *what)
{
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, what)); at += strlen(what))
        ++count;
    return count;
}

TEST(the_page_needs_nothing_from_outside)
{
    char *dir = inside("page"), *path, *page;
    iso_report *r = example(dir);
    assert_ok(iso_report_finish(r, &err));
    path = iso_path_join(dir, "index.html");
    read_text(path, &page);
    assert_int_equal(count_of(page, "://"), 0); /* no address of any kind */
    assert_int_equal(count_of(page, "src=\""), 0);
    assert_int_equal(count_of(page, "url("), 0);
    assert_int_equal(count_of(page, "@import"), 0);
    assert_int_equal(count_of(page, "</script>"), 3);                   /* its own: text in the data cannot end one */
    assert_int_equal(count_of(page, "data:image/png;base64,"), 18 + 8); /* images and differences */
    assert_int_equal(count_of(page, "data:image/svg+xml;base64,"), 2);
    iso_report_summary summary = iso_report_summarize(r);
    const char *last = strstr(summary.sentence, "The renderers do not all agree"); /* after names, which are escaped */
    assert_non_null(last);
    assert_int_equal(count_of(page, last), 2); /* in the page, and in the data */
    json_auto_t *root = data_of_page(page), *alone;
    assert_non_null(root);
    free(path);
    path = iso_path_join(dir, "report.json");
    assert_ok(iso_json_load(path, &alone, &err));
    assert_true(json_equal(root, alone)); /* the page shows what report.json holds */
    free(page);
    free(path);
    free(dir);
    iso_report_destroy(r);
}

TEST(the_sentence_tells_each_outcome)
{
    FREED char *dir = inside("sentence");
    iso_report *r;
    const iso_report_about about = {.title = "nothing"};
    assert_ok(iso_report_create(&r, dir, &about, &err));
    assert_false(iso_report_summarize(r).good); /* nothing compared is not agreement */
    iso_report_agreement row = {.scene = "s", .a = "a", .renderer = "b", .error_bar = NAN, .tolerances = {.rmse = 1}};
    assert_ok(iso_report_add_agreement(r, &row, &err));
    assert_true(iso_report_summarize(r).good);
    assert_ok(iso_report_add_calibration(r, &(iso_report_calibration){"gl", "check", NAN, 1, NULL, NULL, false}, &err));
    assert_false(iso_report_summarize(r).good); /* NaN fails a calibration */
    row.metrics.nonfinite_count = 1;
    row.uncompared = ISO_UNCOMPARED_FAINT; /* not even a row that shows too little forgives NaN */
    assert_ok(iso_report_add_agreement(r, &row, &err));
    assert_int_equal(iso_report_summarize(r).differed, 1);
    row.metrics.nonfinite_count = 0;
    row.metrics.rmse = NAN;
    row.uncompared = ISO_UNCOMPARED_NOT;
    assert_ok(iso_report_add_agreement(r, &row, &err));
    assert_int_equal(iso_report_summarize(r).differed, 2);
    iso_report_destroy(r);
}

/* What could not be compared is no disagreement, and no agreement either. */
TEST(a_refusal_is_told_as_what_it_is)
{
    FREED char *dir = inside("refusal");
    iso_report *r;
    const iso_report_about about = {.title = "t"};
    iso_report_agreement row = {.scene = "s", .a = "a", .renderer = "b", .error_bar = NAN, .tolerances = {.rmse = 1}};
    assert_ok(iso_report_create(&r, dir, &about, &err));
    assert_ok(iso_report_add_agreement(r, &row, &err));
    row.refused = "missing: povray";
    assert_ok(iso_report_add_agreement(r, &row, &err));
    iso_report_summary s = iso_report_summarize(r);
    assert_false(s.good);
    assert_non_null(strstr(s.sentence, "1 comparison agrees; 1 could not be made"));
    iso_report_destroy(r);
}

TEST(junit_counts_failures_and_escapes)
{
    FREED char *dir = inside("junit"), *path = inside("junit.xml"), *xml;
    iso_report *r = example(dir);
    assert_ok(
        iso_report_add_calibration(r, &(iso_report_calibration){"povray", "answers", NAN, 0, NULL, "no such program", false},
                                   &err));
    assert_ok(iso_report_write_junit(r, path, &err));
    read_text(path, &xml);
    assert_int_equal(count_of(xml, "<testcase "), 14);
    assert_int_equal(count_of(xml, "<failure "),
                     3);                           /* one differs, one calibration fails, one scene is refused whole */
    assert_int_equal(count_of(xml, "<error "), 1); /* and one renderer is not there */
    assert_int_equal(count_of(xml, "<skipped "), 2); /* one is refused, one is not compared */
    assert_non_null(strstr(xml, "tests=\"4\" failures=\"1\" errors=\"1\" skipped=\"0\""));
    assert_non_null(strstr(xml, "tests=\"10\" failures=\"2\" errors=\"0\" skipped=\"2\""));
    assert_non_null(strstr(xml, "message=\"rmse "));
    assert_non_null(strstr(xml, "smooth &lt;head&gt; &amp; &quot;neck&quot;"));
    /* Consistency has no limit: figures beside the cases, not cases that cannot fail. */
    assert_non_null(strstr(xml, "name=\"consistency\""));
    assert_non_null(strstr(xml, "tests=\"0\" failures=\"0\" errors=\"0\" skipped=\"0\""));
    assert_non_null(
        strstr(xml, "<property name=\"level 2: naive average+adapted: ssim_dissimilarity_mean\" value=\"0.0432\"/>"));
    assert_int_equal(count_of(xml, "original_kept\" value=\"it would be &quot;no&quot; nearer\"/>"), 3);
    iso_report_destroy(r);
}

/* All green where nothing was compared would read as agreement: a scene whose rows are all refused or not compared
 * fails. */
TEST(junit_fails_a_scene_of_which_nothing_was_compared)
{
    char *dir = inside("nothing"), *path = inside("nothing.xml"), *xml;
    iso_report *r;
    const iso_report_about about = {.title = "t"};
    iso_report_agreement row = {
        .scene = "dark", .a = "a", .renderer = "b", .error_bar = NAN, .uncompared = ISO_UNCOMPARED_FAINT};
    assert_ok(iso_report_create(&r, dir, &about, &err));
    assert_ok(iso_report_write_junit(r, path, &err));
    read_text(path, &xml);
    assert_int_equal(count_of(xml, "<failure "), 1); /* no row at all */
    free(xml);
    assert_ok(iso_report_add_agreement(r, &row, &err));
    row.refused = "no such program";
    assert_ok(iso_report_add_agreement(r, &row, &err));
    row = (iso_report_agreement){
        .scene = "bright", .a = "a", .renderer = "b", .error_bar = NAN, .tolerances = {.rmse = 1}};
    assert_ok(iso_report_add_agreement(r, &row, &err));
    assert_ok(iso_report_write_junit(r, path, &err));
    read_text(path, &xml);
    assert_non_null(strstr(xml, "tests=\"4\" failures=\"1\" errors=\"0\" skipped=\"2\""));
    assert_non_null(strstr(xml, "classname=\"agreement.dark\" time=\"0.000\" name=\"something is compared\""));
    assert_int_equal(count_of(xml, "<failure "), 1);
    free(xml);
    free(path);
    free(dir);
    iso_report_destroy(r);
}

/* What is asked besides the metrics: a gate that is not held is a difference, by its name. */
TEST(gates_decide_too)
{
    char *dir = inside("gates"), *path = inside("gates.xml"), *xml;
    iso_report *r;
    const iso_report_about about = {.title = "t"};
    assert_ok(iso_report_create(&r, dir, &about, &err));
    iso_report_agreement row = {.scene = "s",
                                .a = "a",
                                .renderer = "b",
                                .error_bar = 1e-4,
                                .tolerances = {.rmse = 1},
                                .gate_count = 2,
                                .gates = {{ISO_GATE_ERROR_BAR, 1e-4, 4e-4}, {ISO_GATE_PIXELS, 0, 0}}};
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_AGREE);
    row.tolerances = (iso_tolerances){0}; /* gates alone are enough */
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_AGREE);
    row.metrics.nonfinite_count = 1;
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_DIFFER);
    row.metrics.nonfinite_count = 0;
    row.gates[0].value = NAN;
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_DIFFER);
    row.gates[0].value = 1e-4;
    row.tolerances.rmse = 1;
    row.metrics.rmse = 2; /* nor do gates make up for a metric */
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_DIFFER);
    row.metrics.rmse = 0.5;
    row.gates[1].value = 3;
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_DIFFER);
    json_auto_t *facts = json_pack("{s:f}", "order", 1.5);
    row.statistics = facts;
    assert_ok(iso_report_add_agreement(r, &row, &err));
    const json_t *kept = json_array_get(json_object_get(iso_report_json(r), "agreement"), 0);
    assert_int_equal(json_array_size(json_object_get(kept, "gates")), 2);
    const json_t *last = json_array_get(json_object_get(kept, "gates"), 1);
    assert_string_equal(json_string_value(json_object_get(last, "gate")),
                        "pixels"); /* for programs; the name is for people */
    assert_string_equal(json_string_value(json_object_get(last, "name")), "pixels beyond chance");
    assert_within(json_number_value(json_object_get(json_object_get(kept, "statistics"), "order")), 1.5, 0);
    assert_true(json_is_null(json_object_get(kept, "severity"))); /* infinite: a gate at 0 was passed by */
    assert_ok(iso_report_write_junit(r, path, &err));
    read_text(path, &xml);
    assert_non_null(strstr(xml, "pixels beyond chance 3, at most 0"));
    assert_null(strstr(xml, "error bar")); /* it was held */
    free(xml);
    row.gates[0].value = NAN;
    row.gates[1].value = 0;
    assert_ok(iso_report_add_agreement(r, &row, &err));
    assert_ok(iso_report_write_junit(r, path, &err));
    read_text(path, &xml);
    assert_non_null(strstr(xml, "error bar is not a number, at most 0.0004"));
    free(xml);
    free(path);
    free(dir);
    iso_report_destroy(r);
}

/* A block a method and TF, levels ascending: what the chart draws. */
TEST(the_data_of_the_chart_keeps_the_tfs_apart)
{
    char *dir = inside("csv"), *path, *csv;
    iso_report *r = example(dir);
    assert_ok(iso_report_finish(r, &err));
    path = iso_path_join(dir, "charts/consistency.csv");
    read_text(path, &csv);
    assert_int_equal(count_of(csv, "\n\n\n"), 5); /* between three methods under two TFs */
    assert_int_equal(count_of(csv, ",original,0,0\n"), 9);
    assert_int_equal(count_of(csv, ",adapted,1,0\n"), 3);
    assert_int_equal(count_of(csv, ",adapted,0,0\n"), 6);
    assert_non_null(strstr(csv, "\nmoments; codes,3,20,0.096,0.048,3.84,11.52,original,0,0\n\n\n"
                                "moments; codes,1,20,0.024,0.012,0.96,2.88,adapted,1,0\n"));
    free(csv);
    free(path);
    path = iso_path_join(dir, "charts/consistency.svg");
    read_text(path, &csv);
    assert_non_null(strstr(csv, "adapted TF"));
    assert_non_null(strstr(csv, "original TF kept"));
    assert_int_equal(count_of(csv, "stroke-dasharray") > 0, 1);
    free(csv);
    free(path);
    iso_report_destroy(r);
    free(dir);
}

TEST(an_unfinished_report_leaves_nothing)
{
    FREED char *dir = inside("unfinished"), *temporary;
    iso_report *r = example(dir);
    temporary = strdup(iso_report_dir(r));
    assert_true(iso_path_is_dir(temporary));
    iso_report_destroy(r);
    assert_false(iso_path_exists(temporary));
    assert_false(iso_path_exists(dir));
}

TEST(only_a_report_is_replaced)
{
    FREED char *dir = inside("mine"), *file = NULL;
    iso_report *r;
    const iso_report_about about = {.title = "t"};
    assert_ok(iso_report_create(&r, dir, &about, &err));
    assert_ok(iso_report_finish(r, &err));
    iso_report_destroy(r);
    assert_ok(iso_report_create(&r, dir, &about, &err));
    assert_ok(iso_report_finish(r, &err));
    iso_report_destroy(r);
    file = iso_path_join(dir, "report.json");
    remove(file);
    assert_status(iso_report_create(&r, dir, &about, &err), ISO_E_IO);
}

TEST(bad_names_are_refused)
{
    FREED char *dir = inside("names");
    iso_report *r;
    const iso_report_about about = {.title = "t"};
    OWNED(iso_image) image = ball(16, 0, 0, 0), small = ball(12, 0, 0, 0);
    assert_ok(iso_report_create(&r, dir, &about, &err));
    assert_status(iso_report_add_image(r, "../a", &image, NULL, &err), ISO_E_RANGE);
    assert_status(iso_report_add_image(r, "", &image, NULL, &err), ISO_E_RANGE);
    assert_ok(iso_report_add_image(r, "a", &image, NULL, &err));
    assert_ok(iso_report_add_image(r, "small", &small, NULL, &err));
    assert_status(iso_report_add_image(r, "a", &image, NULL, &err), ISO_E_RANGE);
    iso_report_agreement row = {.scene = "s", .a = "a", .renderer = "b", .image_a = "a", .image_b = "none"};
    assert_status(iso_report_add_agreement(r, &row, &err), ISO_E_RANGE);
    row.image_b = "small";
    assert_status(iso_report_add_agreement(r, &row, &err), ISO_E_RANGE);
    assert_int_equal(json_array_size(json_object_get(iso_report_json(r), "agreement")), 0);
    iso_report_destroy(r);
}

TEST(without_gnuplot_there_are_no_charts_and_it_says_so)
{
    FREED char *dir = inside("plain");
    setenv("ISOSHADE_GNUPLOT", "/nonexistent/gnuplot", 1);
    iso_report *r = example(dir);
    assert_ok(iso_report_finish(r, &err));
    unsetenv("ISOSHADE_GNUPLOT");
    assert_non_null(json_object_get(iso_report_json(r), "charts_missing"));
    iso_report_destroy(r);
}

TEST(a_restyled_chart_keeps_its_style)
{
    FREED char *dir = inside("style"), *style, *svg, *text;
    iso_report *r = example(dir);
    assert_ok(iso_report_finish(r, &err));
    iso_report_destroy(r);
    FREED char *command = NULL;
    style = iso_path_join(dir, "charts/style.gp");
    svg = iso_path_join(dir, "charts/agreement.svg");
    size_t size = 0;
    FILE *f = open_memstream(&command, &size);
    fprintf(f, "cd %s/charts && sed -i 's/#d55e00/#123456/' style.gp && gnuplot agreement.gp", dir);
    fclose(f);
    assert_int_equal(system(command), 0);
    read_text(svg, &text);
    assert_non_null(strstr(text, "rgb( 18,  52,  86)"));
}

/* gnuplot prints a text as it was: all bytes, and those that mean something in scripts, next to each other. */
TEST(quoted_texts_are_what_gnuplot_reads)
{
    static const char *const odd[] = {"''a''''b'",       "\"\"",           "\\", "\\\\\"", "'1\"07\\0\n12",
                                      "`date`$HOME@a%d#", "{/Bold x}^2_{3}", "",   "a'; system('touch x'); print 'b"};
    FREED char *script = inside("quoted.gp"), *printed = inside("quoted.txt"), *gnuplot = NULL, *said;
    char wanted[4096] = "", all[256];
    for (int c = 1; c < 256; ++c)
        all[c - 1] = (char)c, all[c] = 0;
    FILE *gp = fopen(script, "w");
    assert_non_null(gp);
    fputs("set encoding utf8\nset print 'quoted.txt'\n", gp);
    for (size_t i = 0; i <= sizeof odd / sizeof *odd; ++i) {
        const char *text = i < sizeof odd / sizeof *odd ? odd[i] : all;
        fputs("print ", gp);
        iso_gnuplot_put_quoted(gp, text);
        fputc('\n', gp);
        iso_words_append(wanted, sizeof wanted, "%s\n", text);
    }
    assert_int_equal(fclose(gp), 0);
    assert_ok(iso_process_find("gnuplot", "gnuplot-nox", &gnuplot, &err));
    const iso_process_options options = {.directory = folder};
    assert_ok(iso_process_run((const char *[]){gnuplot, "-d", script, NULL}, &options, &err));
    read_text(printed, &said);
    assert_string_equal(said, wanted);
}

int main(int argc, char **argv)
{
    if (argc > 1) {
        example_size = 160;
        iso_report *r = example(argv[1]);
        assert_ok(iso_report_finish(r, &err));
        iso_report_destroy(r);
        return 0;
    }
    return run_cases(make_folder, remove_folder);
}
