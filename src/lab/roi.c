/* SPDX-License-Identifier: MIT */
/* roi.c - measures the seam around a region of interest: the step of emission across the faces of the box and of its
 * band, and the step in an image that looks along them. Compares with a hard edge, with the original TF outside, and
 * with the variation of the finest level itself ([diaz-garcia-2016], Figure 11; scene/roi.h). */
#include "lab/roi.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "lab/lab.h"
#include "options/input.h"
#include "options/look.h"
#include "image/image.h"

/* Computes emission and absorption of a point over one level-0 voxel, unshaded: premultiplied color and opacity. */
static void emit(const iso_roi_setup *s, const iso_sampler *at, iso_vec3 index, const iso_tf_table *tf, double weight,
                 double e[4])
{
    double rgbs[4];
    if (weight <= 0)
        return;
    iso_tf_lookup(tf, iso_sample_scalar(at, index), rgbs);
    double opacity = -expm1(-weight * rgbs[3] * s->length_mm);
    for (int c = 0; c < 3; ++c)
        e[c] += opacity * rgbs[c];
    e[3] += opacity;
}

static double distance(const double a[4], const double b[4])
{
    double sum = 0;
    for (int c = 0; c < 4; ++c)
        sum += (a[c] - b[c]) * (a[c] - b[c]);
    return sqrt(sum);
}

/* Does so for the region of interest at an index of the level around it; kind: with the weights of roi. */
static void emit_blended(const iso_roi_setup *s, const iso_roi *roi, const iso_tf_table *around, iso_vec3 index,
                         double e[4])
{
    const double w = iso_roi_weight(roi, index);
    for (int c = 0; c < 4; ++c)
        e[c] = 0;
    emit(s, &s->inside, iso_roi_inside(roi, index), &roi->tf, w, e);
    emit(s, &s->around, index, around, 1 - w, e);
}

typedef struct squares {
    double sum, largest;
    size_t count;
} squares;

static void note(squares *q, double d)
{
    q->sum += d * d;
    q->largest = fmax(q->largest, d);
    ++q->count;
}

static double rms(const squares *q)
{
    return q->count ? sqrt(q->sum / (double)q->count) : 0;
}

/* Returns the i-th point of a face of the box grown by `grown`, spread by an additive recurrence. */
static iso_vec3 face_point(const iso_roi *f, double grown, size_t i, double normal[3])
{
    const int axis = (int)(i % 3), b = (axis + 1) % 3, c = (axis + 2) % 3;
    const bool upper = i / 3 % 2;
    double p[3], u = fmod(0.5 + 0.7548776662466927 * (double)i, 1), v = fmod(0.5 + 0.5698402909980532 * (double)i, 1);
    p[axis] = upper ? f->hi[axis] + grown : f->lo[axis] - grown;
    p[b] = f->lo[b] + u * (f->hi[b] - f->lo[b]);
    p[c] = f->lo[c] + v * (f->hi[c] - f->lo[c]);
    normal[0] = normal[1] = normal[2] = 0;
    normal[axis] = upper ? 1 : -1;
    return iso_v3(p[0], p[1], p[2]);
}

static iso_vec3 shifted(iso_vec3 p, const double normal[3], double by)
{
    return iso_v3(p.x + by * normal[0], p.y + by * normal[1], p.z + by * normal[2]);
}

iso_status iso_roi_setup_create(iso_roi_setup *s, const iso_pyramid *p, size_t level, const iso_roi *roi,
                                iso_error *err)
{
    *s = (iso_roi_setup){.length_mm = iso_geometry_mean_spacing_mm(&p->levels[0].geometry), .roi = roi};
    iso_status status = iso_sampler_create(&s->around, &p->levels[level], p->options.code, ISO_FROM_CODES, err);
    TRY(status, iso_sampler_create(&s->inside, &roi->level, p->options.code, ISO_FROM_CODES, err));
    return status;
}

void iso_roi_setup_destroy(iso_roi_setup *s)
{
    iso_sampler_destroy(&s->around);
    iso_sampler_destroy(&s->inside);
}

iso_roi_step iso_roi_measure_step(const iso_roi_setup *s, const iso_roi *roi, const iso_tf_table *around)
{
    enum { points = 3000 };
    static const double limit = 1e-6; /* in voxels of the level around the box, to either side */
    squares step = {0}, own = {0}, change = {0};
    double inside_mean[4] = {0}, around_mean[4] = {0};
    for (size_t i = 0; i < points; ++i) {
        double normal[3], before[4], behind[4];
        for (int band = 0; band < 2; ++band) {
            iso_vec3 at = face_point(roi, band * roi->band, i, normal);
            emit_blended(s, roi, around, shifted(at, normal, -limit), before);
            emit_blended(s, roi, around, shifted(at, normal, limit), behind);
            note(&step, distance(before, behind));
        }
        /* The finer level's own variation over a voxel, and the difference between both levels in one place. */
        iso_vec3 at = iso_roi_inside(roi, face_point(roi, 0, i, normal));
        double here[4] = {0}, beyond[4] = {0};
        before[0] = before[1] = before[2] = before[3] = behind[0] = behind[1] = behind[2] = behind[3] = 0;
        emit(s, &s->inside, shifted(at, normal, -0.5), &roi->tf, 1, before);
        emit(s, &s->inside, shifted(at, normal, 0.5), &roi->tf, 1, behind);
        note(&own, distance(before, behind));
        emit(s, &s->inside, at, &roi->tf, 1, here);
        emit(s, &s->around, face_point(roi, 0, i, normal), around, 1, beyond);
        note(&change, distance(here, beyond));
        for (int c = 0; c < 4; ++c) {
            inside_mean[c] += here[c] / points;
            around_mean[c] += beyond[c] / points;
        }
    }
    return (iso_roi_step){rms(&step), step.largest, rms(&own), rms(&change), distance(inside_mean, around_mean)};
}

iso_status iso_roi_make_view(const iso_scene *scene, const iso_pyramid *p, iso_view *view, iso_error *err)
{
    const iso_geometry *g = &p->levels[0].geometry;
    double h[3];
    iso_geometry_spacing_mm(g, h);
    *view = (iso_view){0};
    if (!iso_geometry_is_axis_aligned(g))
        return iso_fail(err, ISO_E_RANGE,
                        "isoshade-lab roi: the volume's grid is rotated; this needs an axis-aligned one");
    iso_scene along = *scene; /* borrowed, except for the camera */
    const iso_vec3 center = iso_geometry_box_center_mm(g);
    along.camera_fit = false;
    along.orthographic = true;
    along.camera_direction = iso_v3(0, 0, -1);
    along.camera_up = iso_v3(0, 1, 0);
    along.camera_position = iso_madd(center, along.camera_direction, -2 * iso_geometry_box_radius_mm(g));
    along.camera_look_at = center;
    along.height_mm = g->box_index[1] * h[1];
    along.height = ISO_ROI_PIXELS * g->size[1];
    along.width = (size_t)lrint((double)along.height * g->box_index[0] * h[0] / along.height_mm);
    return iso_scene_resolve(&along, g, p->levels[0].min, p->levels[0].max, view, err);
}

/* Returns the RMS color difference of two neighboring columns, over the rows in between. */
static double column_step(const iso_image *image, size_t column, size_t row0, size_t row1)
{
    squares q = {0};
    for (size_t row = row0; row < row1; ++row)
        for (int c = 0; c < 3; ++c) {
            const float *pixel = image->rgba + 4 * (row * image->width + column) + c;
            note(&q, fabs((double)pixel[0] - (double)pixel[-4]));
        }
    return rms(&q);
}

double iso_roi_image_step(const iso_image *image, const iso_pyramid *p, const iso_roi_options *box)
{
    const double x_scale = (double)image->width / (double)p->levels[0].geometry.size[0];
    const double y_scale = (double)image->height / (double)p->levels[0].geometry.size[1];
    /* Row 0 is the top, at the largest y. */
    size_t row0 = (size_t)((double)image->height - box->hi[1] * y_scale),
           row1 = (size_t)((double)image->height - box->lo[1] * y_scale);
    double left = column_step(image, (size_t)lrint(box->lo[0] * x_scale), row0, row1);
    double right = column_step(image, (size_t)lrint(box->hi[0] * x_scale), row0, row1);
    return sqrt(0.5 * (left * left + right * right));
}

/* ---- the command ------------------------------------------------------------------------ */

enum { VARIANT_COUNT = 4 };
static const struct variant {
    const char *name;
    bool blended, adapted;
} variants[VARIANT_COUNT] = {{"blended, TF_k outside", true, true},
                             {"hard edge, TF_k outside", false, true},
                             {"blended, original TF outside", true, false},
                             {"hard edge, original TF outside", false, false}};

typedef struct bench_run {
    const iso_cli *cli;
    iso_volume_input input;
    iso_cli_look look;
    char *picture;
    int level;
    iso_gl *gl;
    iso_pyramid pyramid;
    iso_view view;
    iso_tf_table adapted;
    iso_roi_options box;
    json_t *cases;
} bench_run;

/* Chooses the middle third in x and y and all of z: each ray sees one side only, which shows a seam best. */
static void choose_box(bench_run *run)
{
    const size_t *n = run->pyramid.levels[0].geometry.size;
    run->box = iso_roi_defaults();
    for (int a = 0; a < 3; ++a) {
        run->box.lo[a] = a < 2 ? floor((double)n[a] / 3) : 0;
        run->box.hi[a] = a < 2 ? ceil(2 * (double)n[a] / 3) : (double)n[a];
    }
}

static iso_status render(const bench_run *run, size_t level, const iso_tf_table *tf, iso_roi *roi, iso_image *image,
                         iso_error *err)
{
    iso_gl_options opt = iso_gl_defaults();
    iso_view view = run->view; /* borrowed */
    view.tf = *tf;
    view.roi = roi;
    return iso_gl_render(run->gl, &run->pyramid.levels[level], run->pyramid.options.code, &view, &opt, image, err);
}

/* Reports one case. step: NULL for a single level. */
static void report(bench_run *run, const char *name, const iso_roi_step *step, double image_step, const iso_metrics *m)
{
    json_t *row = json_pack("{s:s, s:f, s:f, s:f}", "case", name, "image_step_rms", image_step, "ssim_dissimilarity",
                            1 - m->ssim, "rmse", m->rmse);
    if (step)
        json_object_update_new(row, json_pack("{s:f, s:f, s:f, s:f, s:f}", "step_rms", step->rms, "step_max",
                                              step->largest, "own_variation_rms", step->own, "levels_differ_rms",
                                              step->change, "levels_differ_mean", step->tone));
    json_array_append_new(run->cases, row);
    if (!run->cli->json && step)
        printf("%-31s %8.1e %8.1e %8.1e %8.1e %8.1e   %8.1e %7.4f %7.4f\n", name, step->rms, step->largest, step->own,
               step->change, step->tone, image_step, 1 - m->ssim, m->rmse);
    else if (!run->cli->json)
        printf("%-31s %44s   %8.1e %7.4f %7.4f\n", name, "", image_step, 1 - m->ssim, m->rmse);
}

static iso_status run_variant(bench_run *run, const struct variant *v, const iso_image *finest, iso_error *err)
{
    const iso_tf_table *around = v->adapted ? &run->adapted : &run->view.tf;
    iso_roi roi;
    iso_roi_setup setup = {0};
    iso_image image = {0};
    iso_metrics m = {0};
    iso_roi_options box = run->box;
    box.band = v->blended ? box.band : 0;
    iso_status status = iso_roi_create(&run->pyramid, (size_t)run->level, &run->view.tf, &box, &roi, err);
    TRY(status, iso_roi_setup_create(&setup, &run->pyramid, (size_t)run->level, &roi, err));
    TRY(status, render(run, (size_t)run->level, around, &roi, &image, err));
    TRY(status, iso_metrics_measure(finest, &image, &m, err));
    if (status == ISO_OK) {
        iso_roi_step step = iso_roi_measure_step(&setup, &roi, around);
        report(run, v->name, &step, iso_roi_image_step(&image, &run->pyramid, &run->box), &m);
    }
    if (status == ISO_OK && run->picture && v->blended && v->adapted)
        status = iso_image_save_png(&image, run->picture, 1, err);
    iso_image_destroy(&image);
    iso_roi_setup_destroy(&setup);
    iso_roi_destroy(&roi);
    return status;
}

static iso_status run_level_alone(bench_run *run, const char *name, size_t level, const iso_tf_table *tf,
                                  const iso_image *finest, iso_error *err)
{
    iso_image image = {0};
    iso_metrics m = {0};
    iso_status status = render(run, level, tf, NULL, &image, err);
    TRY(status, iso_metrics_measure(finest, &image, &m, err));
    if (status == ISO_OK)
        report(run, name, NULL, iso_roi_image_step(&image, &run->pyramid, &run->box), &m);
    iso_image_destroy(&image);
    return status;
}

static iso_status measure(bench_run *run, iso_error *err)
{
    iso_image finest = {0};
    iso_adapt_options opt = iso_adapt_defaults();
    opt.fall_back = false;
    opt.threads = run->cli->threads;
    choose_box(run);
    iso_status status = iso_adapt_level(&run->pyramid, (size_t)run->level, &run->view.tf, &opt, &run->adapted, NULL,
                                        err);
    TRY(status, render(run, 0, &run->view.tf, NULL, &finest, err));
    if (status == ISO_OK && !run->cli->json)
        printf("%-31s %8s %8s %8s %8s %8s   %8s %7s %7s\n", "", "step", "largest", "own", "levels", "tone", "image",
               "1-SSIM", "RMSE");
    for (int i = 0; i < VARIANT_COUNT && status == ISO_OK; ++i)
        status = run_variant(run, &variants[i], &finest, err);
    TRY(status, run_level_alone(run, "level 0 alone", 0, &run->view.tf, &finest, err));
    TRY(status, run_level_alone(run, "level k alone, TF_k", (size_t)run->level, &run->adapted, &finest, err));
    TRY(status, run_level_alone(run, "level k alone, original TF", (size_t)run->level, &run->view.tf, &finest, err));
    iso_image_destroy(&finest);
    iso_tf_table_destroy(&run->adapted);
    return status;
}

static iso_status load_and_measure(bench_run *run, iso_error *err)
{
    iso_progress progress = iso_cli_progress(run->cli);
    iso_pyramid_options build = iso_pyramid_defaults();
    iso_scene scene = {0};
    iso_subject_look look;
    iso_status status = ISO_OK;
    build.level_count = (size_t)run->level + 1;
    build.threads = run->cli->threads;
    TRY(status, iso_cli_look_check(&run->look, run->cli->threads, &look, err));
    TRY(status, iso_subject_load_pyramid(run->cli->arguments[0], &run->input, &build, &progress, &run->pyramid, err));
    if (status == ISO_OK && (size_t)run->level >= run->pyramid.level_count)
        status = iso_fail(err, ISO_E_RANGE, "--level is %d, the pyramid has levels 0 to %zu", run->level,
                          run->pyramid.level_count - 1);
    TRY(status, iso_subject_make_scene(&look, &run->pyramid, &scene, err));
    TRY(status, iso_roi_make_view(&scene, &run->pyramid, &run->view, err));
    TRY(status, iso_gl_create(&run->gl, NULL, err));
    run->cases = json_array();
    TRY(status, measure(run, err));
    if (status == ISO_OK && run->cli->json) {
        json_t *root = iso_cli_json(run->cli);
        json_object_set(root, "cases", run->cases);
        iso_cli_print_json(root);
    }
    json_decref(run->cases);
    iso_gl_destroy(run->gl);
    iso_view_destroy(&run->view);
    iso_pyramid_destroy(&run->pyramid);
    iso_scene_destroy(&scene);
    return status;
}

static const iso_option options[] = {
    ISO_OPTIONS_OF(bench_run, look, iso_scene_rows),
    ISO_OPTIONS_OF(bench_run, look, iso_tf_rows),
    {"level", 0, "use level K around the box", "K", ISO_IN(bench_run, level), .flags = ISO_SHOWN, .least = 1,
     .most = 6},
    {"output", 'o', "write a picture of the blended case", "FILE.png", ISO_IN(bench_run, picture)},
    ISO_OPTIONS_OF(bench_run, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    bench_run *b = values;
    b->cli = cli;
    return load_and_measure(b, err);
}

const iso_command iso_lab_roi = {
    .name = "roi",
    .summary = "the seam round a region of interest: full resolution in the middle third of a coarse level",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME [--scene SCENE.scene.json] [options]",
    .details =
        "Differences of emission and absorption of a point over one voxel of level 0 (color and opacity). step:\n"
        "across the faces of the box and of its band (rms and largest). own: of the finest level over one voxel\n"
        "there, for comparison. levels: between the two levels at the same place (rms). tone: between the means of\n"
        "the two levels. image: between the pixels on both sides of the box's faces, seen along them. 1-SSIM and\n"
        "RMSE compare the whole image with level 0.",
    .examples = "  isoshade make noise --size 48 --type uint8 -o noise.nrrd\n"
                "  isoshade-lab roi noise.nrrd --scene refscenes/marschner-lobb.scene.json --level 1\n",
    ISO_COMMAND_OPTIONS(bench_run, options, .level = 2),
    .run = run,
};
