/* SPDX-License-Identifier: MIT */
/* encode_paper.c - [diaz-garcia-2017]: Table 1, Figure 10, and the claim of convex interpolation. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/json.h"
#include "base/random.h"
#include "lab/encode.h"
#include "report/gnuplot.h"
#include "lab/codes/code_error.h"
#include "lab/codes/code_hole.h"
#include "encode/decode_double.h"
#include "lab/codes/region48.h"

static const double degree = 0.017453292519943295;

/* ---- Table 1 and Figure 10 ---- */

static iso_status draw_figure10(const char *dir, const json_t *sweep, iso_error *err)
{
    static const char script[] = "name = 'figure10'\n"
                                 "data = name . '.csv'\n"
                                 "width = 620\n"
                                 "load 'style.gp'\n"
                                 "set xlabel 'λ of Eq. 2'\n"
                                 "set ylabel 'biggest hole, °'\n"
                                 "set xrange [0:1]\n"
                                 "set yrange [0:*]\n"
                                 "stats data skip 1 using 1:2 nooutput\n"
                                 "set label 1 sprintf('%.4f at λ = %.2f', STATS_min_y, STATS_pos_min_y) at "
                                 "STATS_pos_min_y, STATS_min_y * 0.82 center\n"
                                 "plot data skip 1 using 1:2 with lines lt 1 notitle\n";
    FREED char *csv = NULL;
    size_t size = 0, i;
    json_t *row;
    FILE *f = open_memstream(&csv, &size);
    NEED_MEMORY(f, err, "no memory for a chart");
    fprintf(f, "lambda,hole_deg\n");
    json_array_foreach ((json_t *)sweep, i, row)
        fprintf(f, "%.4g,%.6f\n", json_real_value(json_object_get(row, "lambda")),
                json_real_value(json_object_get(row, "hole_deg")));
    fclose(f);
    return iso_gnuplot_draw(dir, "figure10", csv, script, "svg", err);
}

iso_status iso_lab_encode_holes(bool text, const char *chart_dir, json_t *root, iso_error *err)
{
    const double tolerance_deg = 1e-5;
    /* Section 4.1 takes the circle around a triangle of 4 pi / (2 N) and gives its diameter; other rows are radii. */
    const double least = 1.756 * sqrt(2 * 3.141592653589793) / 4096 / degree;
    iso_hole none, scheme, hole;
    iso_status status = iso_region48_hole(0, tolerance_deg, &none, err);
    TRY(status, iso_region48_hole(ISO_REGION48_LAMBDA, tolerance_deg, &scheme, err));
    json_t *sweep = json_array();
    json_object_set_new(root, "figure10", sweep);
    double best = 0, best_hole = INFINITY;
    for (int i = 0; i <= 98 && status == ISO_OK; ++i) { /* at 1 the decoder's edges fold */
        status = iso_region48_hole(0.01 * i, 1e-4, &hole, err);
        if (status == ISO_OK)
            json_array_append_new(sweep, json_pack("{s:f, s:f}", "lambda", 0.01 * i, "hole_deg", hole.radius_deg));
    }
    for (int i = 550; i <= 670 && status == ISO_OK; i += 5) { /* finer near the minimum */
        status = iso_region48_hole(0.001 * i, 1e-4, &hole, err);
        if (status == ISO_OK && hole.radius_deg < best_hole) {
            best_hole = hole.radius_deg;
            best = 0.001 * i;
        }
    }
    if (status != ISO_OK)
        return status;
    json_object_set_new(root, "table1",
                        json_pack("{s:{s:f, s:f}, s:{s:f, s:f}, s:{s:f, s:f, s:f}, s:{s:f, s:f}}", "no_treatment",
                                  "hole_deg", none.radius_deg, "paper_deg", 0.3177, "region48", "hole_deg",
                                  scheme.radius_deg, "paper_deg", 0.1730, "least_possible", "hole_deg", least / 2,
                                  "hole_diameter_deg", least, "paper_deg", 0.0615, "best_lambda", "lambda", best,
                                  "hole_deg", best_hole));
    if (text) {
        printf("Table 1: biggest hole in degrees, a radius (paper)\n"
               "  no treatment       %.4f  (0.3177)\n"
               "  48 regions         %.4f  (0.1730)\n"
               "  least possible     %.4f  (0.0615, its diameter: %.4f)\n"
               "Figure 10: smallest hole %.4f at lambda %.3f (0.1730 at 0.61)\n",
               none.radius_deg, scheme.radius_deg, least / 2, least, best_hole, best);
        printf("  lambda, hole:");
        for (size_t i = 0; i < json_array_size(sweep); i += 10)
            printf("  %.1f %.3f", 0.01 * (double)i,
                   json_real_value(json_object_get(json_array_get(sweep, i), "hole_deg")));
        putchar('\n');
    }
    return chart_dir ? draw_figure10(chart_dir, sweep, err) : ISO_OK;
}

/* ---- convexity ---- */

/* Draws a direction uniformly within `radius` of center. */
static iso_vec3 random_in_cap(iso_vec3 center, double radius, uint64_t *state)
{
    for (;;) {
        iso_vec3 across = iso_random_unit_vector(state);
        across = iso_normalize(iso_madd(across, center, -iso_dot(across, center)));
        double cosine = 1 - iso_xorshift_unit(state) * (1 - cos(radius));
        if (iso_norm(across) > 0.5)
            return iso_madd(iso_scale(center, cosine), across, sqrt(1 - cosine * cosine));
    }
}

/* Returns the vector on the cube's surface that decodes to d exactly, without quantization. */
static iso_vec3 warp(iso_vec3 d)
{
    double v[3] = {d.x, d.y, d.z}, e[3];
    int order[3];
    iso_rank(v, order);
    double high = fabs(v[order[0]]), middle = fabs(v[order[1]]), low = fabs(v[order[2]]);
    iso_vec3 t = iso_region48_transform(iso_v3((high - middle) / high, (middle - low) / high, low / high));
    e[order[0]] = copysign(1, v[order[0]]);
    e[order[1]] = copysign(t.y + t.z, v[order[1]]);
    e[order[2]] = copysign(t.z, v[order[2]]);
    return iso_v3(e[0], e[1], e[2]);
}

/* Returns the angle in degrees by which x lies outside the cone of three directions; 0 inside. */
static double outside_deg(iso_vec3 x, const iso_vec3 corners[3])
{
    double worst = 0, turn = iso_dot(iso_cross(corners[0], corners[1]), corners[2]) < 0 ? -1 : 1;
    for (int i = 0; i < 3; ++i) {
        iso_vec3 normal = iso_normalize(iso_cross(corners[i], corners[(i + 1) % 3]));
        worst = fmax(worst, -asin(fmin(fmax(turn * iso_dot(normal, iso_normalize(x)), -1), 1)) / degree);
    }
    return worst;
}

iso_status iso_lab_encode_convexity(bool text, json_t *root, iso_error *err)
{
    (void)err;
    /* The directions (1, .25, +-.1) with equal weights: the arc between them crosses z = 0 at (1, .25, 0). */
    iso_vec3 above = warp(iso_v3(1, 0.25, 0.1)), mean = iso_decode_region48(iso_v3(above.x, above.y, 0));
    double off = iso_angle_deg(mean, iso_v3(1, 0.25, 0));
    enum { TRIPLES = 100000 };
    uint64_t state = 20170613;
    size_t outside = 0;
    double worst = 0, pair_mean = 0, pair_max = 0;
    for (int i = 0; i < TRIPLES; ++i) {
        iso_vec3 center = iso_random_unit_vector(&state), corners[3], e = {0, 0, 0};
        double weights[3], sum = 0;
        for (int c = 0; c < 3; ++c)
            sum += weights[c] = -log(1 - iso_xorshift_unit(&state));
        for (int c = 0; c < 3; ++c) {
            corners[c] = random_in_cap(center, 15 * degree, &state);
            e = iso_madd(e, warp(corners[c]), weights[c] / sum);
        }
        double by = outside_deg(iso_decode_region48(e), corners);
        outside += by > 1e-9; /* above rounding of the warp and its inverse */
        worst = fmax(worst, by);
        /* Pairs 15 degrees apart. */
        iso_vec3 a = corners[0], across = iso_random_unit_vector(&state);
        across = iso_normalize(iso_madd(across, a, -iso_dot(across, a)));
        iso_vec3 b = iso_madd(iso_scale(a, cos(15 * degree)), across, sin(15 * degree));
        double t = iso_xorshift_unit(&state);
        e = iso_madd(iso_scale(warp(a), 1 - t), warp(b), t);
        double error = iso_angle_deg(iso_decode_region48(e), iso_madd(iso_scale(a, 1 - t), b, t));
        pair_mean += error / TRIPLES;
        pair_max = fmax(pair_max, error);
    }
    double fraction = (double)outside / TRIPLES;
    json_object_set_new(root, "convexity",
                        json_pack("{s:{s:f, s:f}, s:{s:f, s:i, s:f, s:f}, s:{s:f, s:f, s:f}}", "counter_example",
                                  "decoded_y_over_x", mean.y / mean.x, "off_arc_deg", off, "triples", "cap_radius_deg",
                                  15.0, "count", TRIPLES, "outside_fraction", fraction, "outside_max_deg", worst,
                                  "warp_without_quantization", "apart_deg", 15.0, "mean_error_deg", pair_mean,
                                  "max_error_deg", pair_max));
    if (text)
        printf(
            "Convexity: (1, .25, .1) and (1, .25, -.1) mixed equally decode to (1, %.4f, 0): %.2f degrees off their arc.\n"
            "  Of %d random triples in caps of 15 degrees %.1f %% decode outside the cone of their corners, by up to\n"
            "  %.2f degrees. The warp alone, without bytes, 15 degrees apart: mean error %.3f, largest seen %.2f.\n",
            mean.y / mean.x, off, TRIPLES, 100 * fraction, worst, pair_mean, pair_max);
    return ISO_OK;
}
