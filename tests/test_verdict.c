/* SPDX-License-Identifier: MIT */
/* What a report says of a row, and what a row is of: words, identity, and when nothing may be called agreement. */
#define _GNU_SOURCE

#include "compare/extrapolation.h"
#include "report/report.h"
#include "tests/folder.h"
#include "tests/test.h"

static char *inside(const char *name)
{
    char *path = iso_path_join(folder, name);
    assert_non_null(path);
    return path;
}

static iso_report *open_report(const char *name)
{
    const iso_report_about about = {.title = "t"};
    FREED char *dir = inside(name);
    iso_report *r;
    assert_ok(iso_report_create(&r, dir, &about, &err));
    return r;
}

static const json_t *row_of(const iso_report *r, size_t at)
{
    return json_array_get(json_object_get(iso_report_json(r), "agreement"), at);
}

TEST(every_word_of_a_verdict_is_read_again)
{
    for (int i = 0; i < ISO_VERDICT_UNKNOWN; ++i) {
        json_auto_t *word = json_string(iso_verdict_word((iso_verdict)i));
        assert_int_equal(iso_verdict_from(word), i);
    }
    json_auto_t *odd = json_string("agreed");
    assert_int_equal(iso_verdict_from(odd), ISO_VERDICT_UNKNOWN);
    assert_int_equal(iso_verdict_from(NULL), ISO_VERDICT_UNKNOWN);
    /* Less certain is worse, and nothing is less certain than no word. */
    assert_true(iso_verdict_doubt(ISO_VERDICT_NOT_COMPARED) > iso_verdict_doubt(ISO_VERDICT_AGREE));
    assert_true(iso_verdict_doubt(ISO_VERDICT_REFUSED) > iso_verdict_doubt(ISO_VERDICT_NOT_COMPARED));
    assert_true(iso_verdict_doubt(ISO_VERDICT_DIFFER) > iso_verdict_doubt(ISO_VERDICT_REFUSED));
    assert_true(iso_verdict_doubt(ISO_VERDICT_UNKNOWN) > iso_verdict_doubt(ISO_VERDICT_DIFFER));
}

/* A comma in a variant's or a renderer's name is no part of the row's form. */
TEST(a_row_holds_what_it_is_of_in_fields)
{
    iso_report *r = open_report("fields");
    iso_report_agreement row = {.scene = "s",
                                .a = "reference",
                                .renderer = "gl, of Mesa",
                                .comparison = ISO_COMPARISON_LIMIT,
                                .variant = "naive, adapted TF",
                                .error_bar = NAN,
                                .tolerances = {.rmse = 1}};
    assert_ok(iso_report_add_agreement(r, &row, &err));
    const json_t *kept = row_of(r, 0);
    assert_string_equal(iso_row_text(kept, "renderer"), "gl, of Mesa");
    assert_string_equal(iso_row_text(kept, "comparison"), "limit");
    assert_string_equal(iso_row_text(kept, "variant"), "naive, adapted TF");
    assert_string_equal(iso_row_text(kept, "b"), "gl, of Mesa, limit, naive, adapted TF");
    json_object_set_new((json_t *)kept, "b", json_string("a name for people alone"));
    iso_row_identity id = iso_row_identify(kept);
    assert_string_equal(id.renderer, "gl, of Mesa");
    assert_int_equal(id.comparison, ISO_COMPARISON_LIMIT);
    assert_string_equal(id.variant, "naive, adapted TF");
    iso_report_destroy(r);
}

TEST(rows_are_named_in_words)
{
    static const struct {
        const char *a, *renderer, *comparison, *variant;
        double seeds; /* 0: the row has none */
        const char *words;
    } rows[] = {
        {"reference", "gl", "limit", "naive, adapted TF", 0, "gl, limit of halved steps, naive, adapted TF"},
        {"reference", "gl", "limit", "", 1, "gl, limit of halved steps"},
        {"reference", "cycles", "limit", "", 4, "cycles, mean over seeds"},
        {"reference, same samples", "povray", "lock-step", "", 0, "povray, same samples"},
        {"reference", "povray", "lock-step", "naive", 0, "povray, naive"},
        {"reference", "gl", "exact lookups", "", 0, "gl, exact lookups"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        json_auto_t *row = json_pack("{s:s, s:s, s:s, s:s}", "a", rows[i].a, "renderer", rows[i].renderer,
                                "comparison", rows[i].comparison, "variant", rows[i].variant);
        char words[ISO_ROW_NAME_BYTES];
        if (rows[i].seeds > 0)
            json_object_set_new(row, "statistics", json_pack("{s:f}", "seeds", rows[i].seeds));
        iso_row_words_of(row, words);
        assert_string_equal(words, rows[i].words);
    }
}

/* ---- signal ---- */

/* So many of 100 pixels show this color and alpha before a background. */
static iso_image shown(size_t count, float color, float alpha, const double background[3])
{
    iso_image image;
    assert_ok(iso_image_create(&image, 10, 10, &err));
    for (size_t i = 0; i < 100; ++i)
        for (size_t c = 0; c < 4; ++c)
            image.rgba[4 * i + c] = c == 3 ? (i < count ? alpha : 0) : (float)background[c] + (i < count ? color : 0);
    return image;
}

static iso_signal signal_of(iso_image image, const double background[3], double limit, iso_signal_measure measure)
{
    iso_signal s;
    assert_ok(iso_signal_of(&image, background, limit, measure, &s, &err));
    iso_image_destroy(&image);
    return s;
}

TEST(a_signal_is_measured_above_the_background)
{
    const double gray[3] = {0.25, 0.5, 0.125};
    const iso_signal s = signal_of(shown(25, 0.5F, 0.75F, gray), gray, 1e-3, ISO_SIGNAL_RMS);
    assert_within(s.color, 0.25, 1e-12); /* a quarter of the pixels: half of it in RMS */
    assert_within(s.alpha, 0.375, 1e-12);
    assert_within(s.least, 0.1, 1e-12);
    assert_true(iso_signal_suffices(&s));
    /* The brightest 1 % of the pixels: two of a hundred are enough for that, one is not. */
    assert_within(signal_of(shown(2, 0.5F, 1, gray), gray, 1e-3, ISO_SIGNAL_P99).color, 0.5, 1e-12);
    assert_within(signal_of(shown(1, 0.5F, 1, gray), gray, 1e-3, ISO_SIGNAL_P99).color, 0, 1e-12);
    iso_image blue = shown(0, 0, 0, gray); /* one channel is enough */
    for (size_t i = 0; i < 50; ++i)
        blue.rgba[4 * i + 2] = 0.625F;
    assert_within(signal_of(blue, gray, 1e-3, ISO_SIGNAL_P99).color, 0.5, 1e-12);
    const iso_signal none = signal_of(shown(50, NAN, 1, gray), gray, 1e-3, ISO_SIGNAL_RMS),
                     neither = signal_of(shown(50, NAN, 1, gray), gray, 1e-3, ISO_SIGNAL_P99);
    assert_false(iso_signal_suffices(&none) || iso_signal_suffices(&neither));
}

TEST(both_color_and_alpha_have_to_show)
{
    const double black[3] = {0, 0, 0};
    static const struct {
        float color, alpha;
        bool enough;
        const char *said;
    } cases[] = {{0.125F, 0.125F, true, ""},
                 {0.124F, 0.125F, false, "0.124 above its background (RMS) in color"},
                 {0.125F, 0.124F, false, "0.124 above its background (RMS) in alpha"},
                 {0, 0, false, "only 0 above"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char text[512];
        const iso_signal s = signal_of(shown(100, cases[i].color, cases[i].alpha, black), black, 1.25e-3,
                                       ISO_SIGNAL_RMS);
        assert_int_equal(iso_signal_suffices(&s), cases[i].enough);
        iso_signal_explain(&s, text, sizeof text);
        if (!cases[i].enough && (!strstr(text, cases[i].said) || !strstr(text, "asks for at least 0.125")))
            fail_msg("said: %s", text);
    }
}

TEST(an_empty_image_is_its_background_in_every_bit)
{
    const double color[3] = {0.2, 0.3, 0.1};
    OWNED(iso_image) image = shown(0, 0, 0, color);
    assert_true(iso_image_is_empty(&image, color));
    for (size_t c = 0; c < 3; ++c) {
        image.rgba[40 + c] = nextafterf(image.rgba[40 + c], 1);
        assert_false(iso_image_is_empty(&image, color));
        image.rgba[40 + c] = (float)color[c];
    }
    image.rgba[43] = 1e-30F;
    assert_false(iso_image_is_empty(&image, color));
}

/* Noise explains part of a limit's bar, which is then no part of what holds the whole image. */
TEST(what_holds_a_limit_is_its_step_and_a_tenth_of_its_noise)
{
    iso_extrapolated l = {.step_bar = 1e-3, .bar = 2e-3, .allowed = 2.01e-3};
    assert_within(iso_extrapolated_held_to(&l), 2.01e-3, 1e-12); /* nothing is random */
    l.noise_bar = 1e-3, l.bar = 2 * hypot(1e-3, 1e-3), l.allowed = l.bar + 1e-5;
    assert_within(iso_extrapolated_held_to(&l), 2.01e-3, 1e-12);
    l.coarse_noise.square = l.fine_noise.square = 4.5e-6 *
                                                  0.75; /* explains three quarters of the step's bar, in squares */
    assert_within(iso_extrapolated_held_to(&l), 1.01e-3, 1e-12);
    l.coarse_noise.square = l.fine_noise.square = 9e-6; /* more than all of it */
    assert_within(iso_extrapolated_held_to(&l), l.allowed / 10, 1e-12);
    l.allowed = INFINITY;
    assert_true(isinf(iso_extrapolated_held_to(&l)));
}

/* ---- verdicts ---- */

TEST(a_faint_case_is_not_compared_unless_it_differs)
{
    iso_report_agreement row = {.error_bar = NAN,
                                .tolerances = {.rmse = 1e-3},
                                .metrics = {.rmse = 1e-4, .max_abs = 1e-4, .ssim = 1},
                                .uncompared = ISO_UNCOMPARED_FAINT,
                                .uncompared_why = "faint"};
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_NOT_COMPARED);
    row.metrics.rmse = 2e-3; /* a reference that shows nothing, and a renderer that draws something */
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_DIFFER);
    row.metrics.rmse = 1e-4;
    row.metrics.nonfinite_count = 1;
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_DIFFER);
    row.metrics.nonfinite_count = 0;
    row.gate_count = 1, row.gates[0] = (iso_report_gate){ISO_GATE_HALVING, 0.5, 0.3};
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_DIFFER);
    row.gate_count = 0;
    row.refused = "missing";
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_REFUSED);
}

/* Alpha 0 in both images, and another background: the colors differ, whatever alpha says. */
TEST(two_empty_images_with_other_backgrounds_differ)
{
    const double black[3] = {0, 0, 0}, gray[3] = {0.2, 0.2, 0.2};
    OWNED(iso_image) a = shown(0, 0, 0, black), b = shown(0, 0, 0, gray);
    iso_report_agreement row = {.error_bar = NAN, .tolerances = {.rmse = 1e-3}, .uncompared = ISO_UNCOMPARED_FAINT};
    assert_ok(iso_metrics_measure(&a, &b, &row.metrics, &err));
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_DIFFER);
    assert_ok(iso_metrics_measure(&a, &a, &row.metrics, &err));
    assert_int_equal(iso_report_verdict(&row), ISO_VERDICT_NOT_COMPARED);
}

TEST(without_limits_the_report_says_that_only_equal_images_agree)
{
    const double black[3] = {0, 0, 0};
    iso_report *r = open_report("equal");
    OWNED(iso_image) a = shown(3, 0.5F, 1, black);
    assert_ok(iso_report_add_image(r, "a", &a, NULL, &err));
    iso_report_agreement row = {
        .scene = "s", .a = "a", .renderer = "gl", .error_bar = NAN, .image_a = "a", .image_b = "a"};
    row.signal = (iso_signal){.color = 0.5, .alpha = 0.25, .least = 0.125};
    assert_ok(iso_report_add_agreement(r, &row, &err));
    const json_t *limits = json_object_get(row_of(r, 0), "limits"), *signal = json_object_get(row_of(r, 0), "signal");
    assert_true(json_is_number(json_object_get(limits, "max_abs")));
    assert_within(json_number_value(json_object_get(limits, "max_abs")), 0, 0);
    assert_within(json_number_value(json_object_get(signal, "color")), 0.5, 0);
    assert_within(json_number_value(json_object_get(signal, "least")), 0.125, 0);
    assert_string_equal(iso_row_text(signal, "measure"), "rms");
    iso_report_destroy(r);
}

/* ---- the sentence, the exit code and JUnit's XML ---- */

typedef struct told {
    const char *scene, *renderer;
    iso_verdict verdict;
    iso_uncompared reason;
} told;

static void add_told(iso_report *r, const told *t)
{
    const iso_report_agreement row = {.scene = t->scene,
                                      .a = "a",
                                      .renderer = t->renderer,
                                      .error_bar = NAN,
                                      .tolerances = {.rmse = 1},
                                      .metrics = {.rmse = t->verdict == ISO_VERDICT_DIFFER ? 2 : 0},
                                      .refused = t->verdict == ISO_VERDICT_REFUSED ? "missing" : NULL,
                                      .uncompared = t->reason,
                                      .uncompared_why = "why"};
    assert_int_equal(iso_report_verdict(&row), t->verdict);
    assert_ok(iso_report_add_agreement(r, &row, &err));
}

static size_t failures_of(const iso_report *r)
{
    FREED char *path = inside("junit.xml"), *xml;
    size_t size, count = 0;
    assert_ok(iso_report_write_junit(r, path, &err));
    assert_ok(iso_file_read(path, &xml, &size, &err));
    for (const char *at = xml; (at = strstr(at, "<failure ")); ++at)
        ++count;
    return count;
}

TEST(the_sentence_counts_what_was_asked_for)
{
    const iso_verdict agree = ISO_VERDICT_AGREE, differ = ISO_VERDICT_DIFFER, none = ISO_VERDICT_NOT_COMPARED;
    const iso_uncompared faint = ISO_UNCOMPARED_FAINT, trait = ISO_UNCOMPARED_TRAIT, stage = ISO_UNCOMPARED_STAGE;
    static const char open_gl[] = "nothing was compared of gl in the scene s";
    const struct {
        told rows[4];
        bool good;
        const char *said;
    } cases[] = {
        {{{"s", "gl", agree, 0}}, true, "The renderers agree: the 1 comparison is within its limits."},
        {{{"s", "gl", none, faint}},
         false,
         "Nothing was compared, so nothing is shown to agree; not compared: 1 case "},
        {{{"s", "gl", agree, 0}, {"s", "gl", none, faint}, {"s", "gl", none, faint}},
         true,
         "1 of 3 requested comparisons is within its limits; not compared: 2 cases that show too little"},
        /* A faint case does not decide whether the renderer is right, even if others are right. */
        {{{"s", "povray", agree, 0}, {"s", "gl", none, faint}}, false, open_gl},
        {{{"t", "gl", agree, 0}, {"s", "gl", none, faint}}, false, "nothing was compared in the scene s"},
        /* What a renderer does not have is no failure of it, but nothing at all is none either. */
        {{{"s", "gl", agree, 0}, {"s", "cycles", none, trait}}, true, "1 case with a feature that its renderer lacks"},
        {{{"s", "cycles", none, trait}}, false, "Nothing was compared"},
        {{{"t", "cycles", agree, 0}, {"s", "cycles", none, trait}}, true, "1 case with a feature"},
        {{{"s", "povray", agree, 0}, {"s", "", none, stage}}, true, "; not compared: 1 stage that did not run."},
        {{{"s", "", none, stage}}, false, "Nothing was compared"},
        {{{"s", "gl", differ, 0}, {"s", "gl", none, faint}}, false, "1 of 1 comparison differs; not compared: 1 case"},
        {{{"s", "gl", ISO_VERDICT_REFUSED, 0}, {"s", "povray", agree, 0}}, false, "1 could not be made"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        iso_report *r = open_report("asked");
        for (size_t k = 0; k < 4 && cases[i].rows[k].scene; ++k)
            add_told(r, &cases[i].rows[k]);
        const iso_report_summary s = iso_report_summarize(r);
        if (s.good != cases[i].good || !strstr(s.sentence, cases[i].said))
            fail_msg("case %zu: %s, said: %s", i, s.good ? "good" : "not good", s.sentence);
        /* What is not good is a failure there too, but for refused rows, whose renderer has an error of its own. */
        if (s.refused == 0)
            assert_int_equal(failures_of(r) > 0, !s.good);
        iso_report_destroy(r);
    }
}

/* The first sentence names the worst renderer, the size, and the cause that equal samples and small steps show. */
TEST(the_first_sentence_names_renderer_size_and_cause)
{
    static const struct {
        double same, limit;
        const char *said;
    } cases[] = {
        {2, 0.5, "; with small steps it agrees, so its samples stand elsewhere. "},
        {0.5, 3, "; with the same samples it agrees, so small steps are the cause. "},
        {4, 3, "; with small steps it differs, too, so steps are not the cause. "},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        iso_report *r = open_report("first");
        iso_report_agreement row = {.scene = "s", .a = "a", .renderer = "worse", .level = 1, .error_bar = NAN};
        char words[160];
        row.tolerances.rmse = 0.01;
        for (int k = 0; k < 2; ++k) {
            row.comparison = k ? ISO_COMPARISON_LIMIT : ISO_COMPARISON_LOCK_STEP;
            row.metrics.rmse = 0.01 * (k ? cases[i].limit : cases[i].same);
            assert_ok(iso_report_add_agreement(r, &row, &err));
        }
        row.renderer = "better"; /* its cause is another one */
        row.metrics.rmse = 0.011;
        assert_ok(iso_report_add_agreement(r, &row, &err));
        const iso_report_summary s = iso_report_summarize(r);
        const double worst = fmax(cases[i].same, cases[i].limit);
        snprintf(words, sizeof words, "worse differs in s, level 1: RMSE %.2g, %.2g times the limit%s", 0.01 * worst, worst,
                 cases[i].said);
        if (strncmp(s.sentence, words, strlen(words)) != 0)
            fail_msg("%s, said: %s", words, s.sentence);
        iso_report_destroy(r);
    }
}

/* Rows of a stage name it, and have no renderer. */
TEST(a_stage_that_did_not_run_has_a_row)
{
    iso_report *r = open_report("stage");
    const iso_report_agreement row = {.scene = "s",
                                      .comparison = ISO_COMPARISON_STAGE,
                                      .variant = "methods",
                                      .error_bar = NAN,
                                      .uncompared = ISO_UNCOMPARED_STAGE,
                                      .uncompared_why = "nobody takes part"};
    assert_ok(iso_report_add_agreement(r, &row, &err));
    const json_t *kept = row_of(r, 0);
    assert_string_equal(iso_row_text(kept, "verdict"), "not compared");
    assert_string_equal(iso_row_text(kept, "not_compared"), "stage");
    assert_string_equal(iso_row_text(kept, "comparison"), "stage");
    assert_string_equal(iso_row_text(kept, "variant"), "methods");
    assert_string_equal(iso_row_text(kept, "b"), "stage, methods");
    assert_string_equal(iso_row_text(kept, "why"), "nobody takes part");
    assert_true(json_is_null(json_object_get(kept, "rmse"))); /* no figure where no image is */
    iso_report_destroy(r);
}

TEST_MAIN(make_folder, remove_folder)
