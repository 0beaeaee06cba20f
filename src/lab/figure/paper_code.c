/* SPDX-License-Identifier: MIT */
/* paper_code.c - pictures of direction codes: Figures 6, 8 and 11 of [diaz-garcia-2017], and the same dots for each
 * code. Everything is vector graphics, so that dots stay sharp at any size. */
#include <math.h>

#include "lab/figure/paper_own.h"
#include "lab/figure/paper_dots.h"
#include "lab/figure/paper_drawing.h"
#include "lab/figure/paper_kinds.h"

/* Returns the diameter at which dots cover about half of an area. */
static double dot_mm(double area_mm2, size_t count)
{
    return fmin(fmax(0.62 * sqrt(area_mm2 / (double)count), 0.1), 0.7);
}

/* ---- the sphere ---- */

static void draw_sphere(FILE *gp, double panel_mm, const iso_dots *dots, size_t *shown)
{
    const iso_drawing d = iso_drawing_begin(gp, panel_mm, 1.04);
    const double pi = 3.14159265358979;
    fputs("$dots << EOD\n", gp);
    *shown = 0;
    for (size_t i = 0; i < dots->count; ++i)
        if (iso_dot(dots->unit[i], d.toward) > 0) {
            iso_drawing_put_dot(&d, dots->unit[i]);
            ++*shown;
        }
    fprintf(
        gp,
        "EOD\nset object circle at first %.3f,%.3f size first %.3f fillcolor rgb '#f1f3f5' fillstyle solid border lc "
        "rgb '#9aa3ab' lw thick(0.12) behind\n"
        "plot $dots with lines lc rgb '#0b3c6f' lw thick(%.3f)\n",
        d.middle, d.middle, d.scale, dot_mm(2 * pi * d.scale * d.scale, *shown));
}

/* ---- the cube ---- */

/* Projects the direction to the cube; returns true if it lies on a visible face. */
static bool to_cube(const iso_drawing *d, iso_vec3 direction, iso_vec3 *dot)
{
    const double peak = fmax(fabs(direction.x), fmax(fabs(direction.y), fabs(direction.z)));
    bool seen = false;
    *dot = iso_scale(direction, 1 / peak);
    for (int axis = 0; axis < 3; ++axis)
        seen = seen || (fabs(iso_drawing_component(direction, axis)) > (1 - 1e-12) * peak &&
                        iso_drawing_component(direction, axis) * iso_drawing_component(d->toward, axis) > 0);
    return seen;
}

/* Computes the corners of one of the 48 regions of a face: the face's middle, an edge's middle, a corner. */
static void region(const iso_drawing *d, int face, int edge, double along, double beside, iso_vec3 corners[3])
{
    const int other = 3 - face - edge;
    corners[0] = iso_drawing_with(iso_v3(0, 0, 0), face, iso_drawing_component(d->toward, face) > 0 ? 1 : -1);
    corners[1] = iso_drawing_with(corners[0], edge, along);
    corners[2] = iso_drawing_with(corners[1], other, beside);
}

static void put_regions(const iso_drawing *d)
{
    iso_vec3 corners[3];
    for (int face = 0; face < 3; ++face)
        for (int edge = 0; edge < 3; ++edge)
            for (int k = 0; k < 4 && edge != face; ++k) {
                region(d, face, edge, k & 1 ? 1 : -1, k & 2 ? 1 : -1, corners);
                iso_drawing_put_triangle(d, corners);
            }
}

static void put_cube_edges(const iso_drawing *d)
{
    for (int face = 0; face < 3; ++face) {
        const iso_vec3 middle = iso_drawing_with(iso_v3(0, 0, 0), face,
                                                 iso_drawing_component(d->toward, face) > 0 ? 1 : -1);
        const int a = (face + 1) % 3, b = (face + 2) % 3;
        for (int k = 0; k < 2; ++k) {
            const double side = k ? 1 : -1;
            iso_drawing_put_line(d, iso_drawing_with(iso_drawing_with(middle, a, side), b, -1),
                                 iso_drawing_with(iso_drawing_with(middle, a, side), b, 1));
            iso_drawing_put_line(d, iso_drawing_with(iso_drawing_with(middle, b, side), a, -1),
                                 iso_drawing_with(iso_drawing_with(middle, b, side), a, 1));
        }
    }
}

static bool inside(const iso_vec3 corners[3], iso_vec3 direction)
{
    for (int i = 0; i < 3; ++i) {
        const iso_vec3 n = iso_cross(corners[i], corners[(i + 1) % 3]);
        if (iso_dot(n, direction) * iso_dot(n, corners[(i + 2) % 3]) < -1e-9)
            return false;
    }
    return true;
}

static void draw_cube(FILE *gp, double panel_mm, const iso_dots *dots, bool regions, size_t *shown)
{
    const iso_drawing d = iso_drawing_begin(gp, panel_mm, 1.58);
    iso_vec3 dot, corners[3];
    region(&d, 1, 0, 1, 1, corners); /* upper right of the front face */
    fputs("$dots << EOD\n", gp);
    *shown = 0;
    for (size_t i = 0; i < dots->count; ++i)
        if (to_cube(&d, dots->unit[i], &dot)) {
            iso_drawing_put_dot(&d, dot);
            ++*shown;
        }
    fputs("EOD\n$edges << EOD\n", gp);
    put_cube_edges(&d);
    if (regions) {
        fputs("EOD\n$regions << EOD\n", gp);
        put_regions(&d);
        fputs("EOD\n$one << EOD\n", gp);
        iso_drawing_put_triangle(&d, corners);
        fputs("EOD\n$inside << EOD\n", gp);
        for (size_t i = 0; i < dots->count; ++i)
            if (to_cube(&d, dots->unit[i], &dot) && inside(corners, dots->unit[i]))
                iso_drawing_put_dot(&d, dot);
    }
    const double thick = dot_mm(10 * d.scale * d.scale, *shown); /* three visible faces of 4 square units, slanted */
    fprintf(
        gp,
        "EOD\nplot %s$dots with lines lc rgb '%s' lw thick(%.3f), $edges with lines lc rgb '#9aa3ab' lw thick(0.12)",
        regions ? "$one with filledcurves closed fc rgb '#ffe3c2' notitle, " : "", regions ? "#8fa6bd" : "#0b3c6f",
        thick);
    if (regions)
        fprintf(gp,
                ", $regions with lines lc rgb '#6b7680' lw thick(0.12), $inside with lines lc rgb '#0b3c6f' "
                "lw thick(%.3f), "
                "$one with lines lc rgb '#d55e00' lw thick(0.4)",
                1.15 * thick);
    fputc('\n', gp);
}

/* ---- the cloud ---- */

/* Draws all lattice points of a texture; farther ones are paler. */
static void draw_cloud(FILE *gp, double panel_mm, int bits)
{
    enum { SHADES = 6 };
    const iso_drawing d = iso_drawing_begin(gp, panel_mm, 1.58);
    const long n = 1L << bits;
    const double reach = fabs(d.toward.x) + fabs(d.toward.y) + fabs(d.toward.z);
    for (int shade = 0; shade < SHADES; ++shade) {
        fprintf(gp, "$cloud%d << EOD\n", shade);
        for (long i = 0; i < n * n * n; ++i) {
            const iso_vec3 p = iso_v3(2.0 * (double)(i % n) / (double)(n - 1) - 1,
                                      2.0 * (double)(i / n % n) / (double)(n - 1) - 1,
                                      2.0 * (double)(i / n / n) / (double)(n - 1) - 1);
            const double depth = 0.5 + 0.5 * iso_dot(p, d.toward) / reach;
            if ((int)fmin(SHADES * depth, SHADES - 1) == shade)
                iso_drawing_put_dot(&d, p);
        }
        fputs("EOD\n", gp);
    }
    fputs("plot ", gp);
    for (int shade = 0; shade < SHADES; ++shade) {
        const double k = 1 - (shade + 0.5) / SHADES; /* towards white */
        fprintf(gp, "%s$cloud%d with lines lc rgb '#%02x%02x%02x' lw thick(%.3f)", shade ? ", " : "", shade,
                (int)(11 + k * 215), (int)(60 + k * 172), (int)(111 + k * 128),
                fmin(fmax(0.32 * 2 * d.scale / (double)n, 0.08), 0.6));
    }
    fputc('\n', gp);
}

/* ---- the figures ---- */

static int bits_of(const iso_figure_job *job)
{
    return iso_lab_figure_of(job)->bits ? iso_lab_figure_of(job)->bits : 5; /* the paper's value */
}

static iso_status make_dots(const iso_figure_job *job, iso_code own, iso_dots *dots, iso_error *err)
{
    iso_code code = own;
    iso_status status = iso_lab_figure_of(job)->code ? iso_code_from_name(iso_lab_figure_of(job)->code, &code, err) : ISO_OK;
    *dots = (iso_dots){0};
    return status == ISO_OK ? iso_dots_create(code, bits_of(job), dots, err) : status;
}

static void put_fact(const iso_figure_job *job, const char *name, const iso_dots *dots, double hole_deg)
{
    json_t *row = json_pack("{s:s, s:i, s:i, s:i}", "code", iso_code_describe(dots->code)->name, "bits", dots->bits,
                            "places", (int)dots->places, "directions", (int)dots->count);
    if (hole_deg > 0)
        json_object_set_new(row, "biggest_hole_deg", json_real(hole_deg));
    json_object_set_new(job->facts, name, row);
}

static iso_status row_of_two(iso_paper *p, const iso_figure_job *job, iso_page *page, iso_error *err)
{
    const iso_paper_row row = {
        .columns = 2, .aspect = 1, .gap_mm = 3, .most_mm = 80, .has_titles = true, .has_notes = true};
    return iso_paper_lay_out(p, job, page, &row, 1, err);
}

static void put_sphere(const iso_paper *p, size_t column, const char *title, const char *note, const iso_dots *dots,
                       size_t *shown)
{
    draw_sphere(iso_paper_drawing(p, 0, column, title, note), p->panel_mm[0], dots, shown);
    iso_page_plot_end(p->page);
}

static void put_cube(const iso_paper *p, size_t column, const char *title, const char *note, const iso_dots *dots,
                     bool regions, size_t *shown)
{
    draw_cube(iso_paper_drawing(p, 0, column, title, note), p->panel_mm[0], dots, regions, shown);
    iso_page_plot_end(p->page);
}

/* Draws two panels of one code's dots and writes the caption. */
typedef void (*two_panels)(const iso_paper *p, const iso_dots *dots, double hole_deg);

/* Draws two panels of a code's dots. with_hole: also finds the biggest hole. */
static iso_status draw_two(const iso_figure_job *job, iso_page *page, iso_code own, bool with_hole, two_panels put,
                           iso_error *err)
{
    iso_paper p;
    OWNED(iso_dots) dots = {0};
    double hole_deg = 0;
    NEED(make_dots(job, own, &dots, err));
    if (with_hole)
        NEED(iso_dots_hole_deg(&dots, &hole_deg, err));
    NEED(row_of_two(&p, job, page, err));
    put_fact(job, "dots", &dots, hole_deg);
    put(&p, &dots, hole_deg);
    return ISO_OK;
}

static void count_directions(const iso_dots *dots, char note[96])
{
    snprintf(note, 96, "%zu directions", dots->count);
}

static void put_points(const iso_paper *p, const iso_dots *dots, double unused)
{
    char note[96];
    size_t shown;
    const long places = 1L << (3 * dots->bits);
    (void)unused;
    snprintf(note, sizeof note, "%ld points", places);
    draw_cloud(iso_paper_drawing(p, 0, 0, "(a) points x, y, z", note), p->panel_mm[0], dots->bits);
    iso_page_plot_end(p->page);
    count_directions(dots, note);
    put_sphere(p, 1, "(b) on the sphere", note, dots, &shown);
    fprintf(iso_page_caption(p->page),
            "(a) The points of a texture with %d bits per component: %ld, evenly spread over a cube. (b) The same "
            "points projected to the unit sphere: %zu different directions; the %zu of the near half are drawn. "
            "Some bands stay empty.",
            dots->bits, places, dots->count, shown);
    json_object_set_new(p->job->facts, "points", json_integer(places));
    json_object_set_new(p->job->facts, "shown", json_integer((json_int_t)shown));
}

static void put_regions_of_cube(const iso_paper *p, const iso_dots *dots, double unused)
{
    char note[96];
    size_t shown;
    (void)unused;
    count_directions(dots, note);
    put_cube(p, 0, "(a) on the cube", note, dots, false, &shown);
    put_cube(p, 1, "(b) one of 48 regions", "8 on each face", dots, true, &shown);
    fprintf(iso_page_caption(p->page),
            "(a) The points of a texture with %d bits per component, projected to the surface of a cube: %zu different "
            "directions, %zu of them on the three visible faces. (b) The same, cut into the 48 regions in which "
            "the components' order and signs are equal, one of them marked: each has a margin without "
            "dots.",
            dots->bits, dots->count, shown);
    json_object_set_new(p->job->facts, "shown", json_integer((json_int_t)shown));
}

static void put_dots_of_code(const iso_paper *p, const iso_dots *dots, double hole_deg)
{
    const char *name = iso_code_describe(dots->code)->name;
    char note[96], title[96];
    size_t on_sphere, on_cube;
    count_directions(dots, note);
    snprintf(title, sizeof title, "(a) code %s on the cube", name);
    put_cube(p, 0, title, note, dots, false, &on_cube);
    snprintf(note, sizeof note, "biggest hole %.2f°", hole_deg);
    snprintf(title, sizeof title, "(b) code %s on the sphere", name);
    put_sphere(p, 1, title, note, dots, &on_sphere);
    fprintf(
        iso_page_caption(p->page),
        "The directions that the code %s decodes to, with %d bits per component instead of 8: %zu, (a) on a cube (%zu "
        "on the visible faces) and (b) on the unit sphere (%zu on the near half); %.3f degrees across the "
        "biggest hole.",
        name, dots->bits, dots->count, on_cube, on_sphere, hole_deg);
}

static iso_status code_points(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    return draw_two(job, page, ISO_CODE_CUBE, false, put_points, err);
}

static iso_status code_regions(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    return draw_two(job, page, ISO_CODE_CUBE, false, put_regions_of_cube, err);
}

static iso_status code_dots(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    return draw_two(job, page, ISO_CODE_FIT, true, put_dots_of_code, err);
}

/* Draws two codes next to each other, on spheres. */
static iso_status code_spheres(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    static const char *const names[] = {"without", "with"};
    iso_paper p;
    iso_dots dots[2] = {{0}, {0}};
    double hole_deg[2] = {0, 0};
    size_t shown;
    iso_status status = iso_dots_create(ISO_CODE_CUBE, bits_of(job), &dots[0], err);
    TRY(status, make_dots(job, ISO_CODE_REGION48, &dots[1], err));
    for (int k = 0; k < 2 && status == ISO_OK; ++k)
        status = iso_dots_hole_deg(&dots[k], &hole_deg[k], err);
    TRY(status, row_of_two(&p, job, page, err));
    if (status == ISO_OK) {
        fprintf(iso_page_caption(page),
                "Directions of a texture with %d bits per component, on the near half of the unit sphere: (a) "
                "untransformed components, (b) the code %s.",
                dots[0].bits, iso_code_describe(dots[1].code)->name);
        for (int k = 0; k < 2; ++k) {
            char title[96], note[96];
            snprintf(title, sizeof title, k ? "(b) code %s" : "(a) untransformed",
                     iso_code_describe(dots[k].code)->name);
            snprintf(note, sizeof note, "biggest hole %.2f°", hole_deg[k]);
            put_sphere(&p, (size_t)k, title, note, &dots[k], &shown);
            put_fact(job, names[k], &dots[k], hole_deg[k]);
            fprintf(iso_page_caption(page), " (%c): %zu directions, %.3f degrees across the biggest hole.", 'a' + k,
                    dots[k].count, hole_deg[k]);
        }
    }
    iso_dots_destroy(&dots[0]);
    iso_dots_destroy(&dots[1]);
    return status;
}

/* ---- the kinds ---- */

enum { OF_CODE = ISO_FIGURE_OF_NOTHING | ISO_LAB_FIGURE_HAS_CODE | ISO_LAB_FIGURE_HAS_BITS };

const iso_figure_info iso_figure_code_dots = {
    .name = "code-dots",
    .summary = "a code's directions on the cube and on the sphere",
    .takes = OF_CODE,
    .draw = code_dots,
};
const iso_figure_info iso_figure_code_points = {
    .name = "code-points",
    .summary = "a texture's points and their directions [diaz-garcia-2017], Figure 6",
    .takes = OF_CODE,
    .draw = code_points,
};
const iso_figure_info iso_figure_code_regions = {
    .name = "code-regions",
    .summary = "directions on the cube, one of 48 regions [diaz-garcia-2017], Figure 8",
    .takes = OF_CODE,
    .draw = code_regions,
};
const iso_figure_info iso_figure_code_spheres = {
    .name = "code-spheres",
    .summary = "directions without a code and with one [diaz-garcia-2017], Figure 11",
    .takes = OF_CODE,
    .draw = code_spheres,
};
