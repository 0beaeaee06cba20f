/* SPDX-License-Identifier: MIT */
#include "compare/flip.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/order.h"
#include "base/parallel.h"

#define PI 3.14159265358979323846
#define MAX_RADIUS 1024 /* of a filter, pixels: more would be an observer closer than 5 mm */

/* sRGB's primaries and white point (IEC 61966-2-1), derived from its chromaticities. */
static const double xyz_from_rgb[3][3] = {
    {0.41239079926595951, 0.35758433938387796, 0.18048078840183429},
    {0.21263900587151036, 0.71516867876775592, 0.07219231536073371},
    {0.01933081871559185, 0.11919477979462599, 0.95053215224966058},
};
static const double rgb_from_xyz[3][3] = {
    {3.24096994190452134, -1.53738317757009346, -0.49861076029300328},
    {-0.96924363628087983, 1.87596750150772067, 0.04155505740717561},
    {0.05563007969699361, -0.20397695888897657, 1.05697151424287856},
};
static const double white[3] = {0.95045592705167183, 1.0, 1.08905775075987852}; /* sums of the rows */

/* Paper, Table 1: contrast sensitivity as sums of two Gaussians a exp(-(pi x)^2 / b), one row per channel. */
static const struct {
    double a1, b1, a2, b2;
} sensitivity[3] = {
    {1, 0.0047, 0, 1e-5},      /* achromatic */
    {1, 0.0053, 0, 1e-5},      /* red - green */
    {34.1, 0.04, 13.5, 0.025}, /* blue - yellow */
};
static const double q_color = 0.7, p_color = 0.4, p_top = 0.95; /* sec. 4.1.3 */
static const double q_feature = 0.5, feature_width_deg = 0.082; /* sec. 4.2 */

typedef struct planes {
    double *at[3];
    size_t width, height;
} planes;

/* The features of one image: adapted L*a*b* after the eye's filter, edges and points. */
typedef struct percept {
    planes color;
    double *edges, *points;
} percept;

static void multiply(const double m[3][3], const double in[3], double out[3])
{
    for (int i = 0; i < 3; ++i)
        out[i] = m[i][0] * in[0] + m[i][1] * in[1] + m[i][2] * in[2];
}

static double clip(double x)
{
    return x > 0 ? (x < 1 ? x : 1) : 0; /* NaN becomes 0 */
}

/* Converts to the linear opponent space YyCxCz (sec. 4.1.1). */
static void opponent_from_rgb(const double rgb[3], double out[3])
{
    double xyz[3];
    multiply(xyz_from_rgb, rgb, xyz);
    double x = xyz[0] / white[0], y = xyz[1] / white[1], z = xyz[2] / white[2];
    out[0] = 116 * y - 16;
    out[1] = 500 * (x - y);
    out[2] = 200 * (y - z);
}

static void rgb_from_opponent(const double in[3], double rgb[3])
{
    double y = (in[0] + 16) / 116;
    double xyz[3] = {(in[1] / 500 + y) * white[0], y * white[1], (y - in[2] / 200) * white[2]};
    multiply(rgb_from_xyz, xyz, rgb);
}

static double lab_curve(double t)
{
    const double d = 6.0 / 29;
    return t > d * d * d ? cbrt(t) : t / (3 * d * d) + 4.0 / 29;
}

/* Converts to L*a*b*, a* and b* scaled by lightness: the Hunt effect (sec. 4.1.2). */
static void adapted_lab(const double rgb[3], double lab[3])
{
    double xyz[3];
    multiply(xyz_from_rgb, rgb, xyz);
    double fx = lab_curve(xyz[0] / white[0]), fy = lab_curve(xyz[1] / white[1]), fz = lab_curve(xyz[2] / white[2]);
    lab[0] = 116 * fy - 16;
    lab[1] = 0.01 * lab[0] * 500 * (fx - fy);
    lab[2] = 0.01 * lab[0] * 200 * (fy - fz);
}

static double hyab(const double a[3], const double b[3])
{
    return fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]);
}

/* Returns the largest color difference in the gamut: green against blue. */
static double largest_color_difference(void)
{
    double green[3], blue[3];
    adapted_lab((double[3]){0, 1, 0}, green);
    adapted_lab((double[3]){0, 0, 1}, blue);
    return pow(hyab(green, blue), q_color);
}

/* Maps differences up to p_color of the largest to [0, p_top], and presses the rest above. */
static double spread(double difference, double largest)
{
    double d = pow(difference, q_color), knee = p_color * largest;
    return d < knee ? p_top / knee * d : p_top + (d - knee) / (largest - knee) * (1 - p_top);
}

/* Adds w * in[x + shift] to out[x]; beyond the row its end repeats. */
static void add_shifted_row(const double *restrict in, size_t width, long shift, double w, double *restrict out)
{
    size_t before = shift < 0 ? (size_t)-shift : 0, behind = shift > 0 ? (size_t)shift : 0;
    size_t first = before < width ? before : width, last = behind < width ? width - behind : 0;
    for (size_t x = 0; x < first; ++x)
        out[x] += w * in[0];
    for (size_t x = first; x < last; ++x)
        out[x] += w * in[(size_t)((long)x + shift)];
    for (size_t x = last > first ? last : first; x < width; ++x)
        out[x] += w * in[width - 1];
}

/* weight times a filter along x, then one along y; taps -radius .. radius. */
typedef struct separable {
    const double *along_x, *along_y;
    size_t radius;
    double weight;
} separable;

/* Adds the filtered in to out; edges repeat. The rows pass through scratch. */
static void add_separable(const double *restrict in, const planes *size, const separable *filter,
                          double *restrict scratch, double *restrict out)
{
    const size_t width = size->width, height = size->height, radius = filter->radius;
    const double *row_filter = filter->along_x, *column_filter = filter->along_y, weight = filter->weight;
    const int threads = width * height < 40000 ? 1 : iso_threads(0); /* starting them costs more than 1 ms of work */
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t y = 0; y < height; ++y) {
        memset(scratch + y * width, 0, width * sizeof *scratch);
        for (size_t k = 0; k <= 2 * radius; ++k)
            add_shifted_row(in + y * width, width, (long)k - (long)radius, row_filter[k], scratch + y * width);
    }
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t y = 0; y < height; ++y)
        for (size_t k = 0; k <= 2 * radius; ++k) {
            size_t at = y + k < radius ? 0 : y + k - radius;
            const double *row = scratch + (at < height ? at : height - 1) * width;
            double w = weight * column_filter[k];
            for (size_t x = 0; x < width; ++x)
                out[y * width + x] += w * row[x];
        }
}

/* Fills the taps -radius .. radius, unit apart, with exp(-x^2 factor); returns their sum. */
static double gaussian(double factor, size_t radius, double *taps)
{
    double sum = 0;
    for (size_t k = 0; k <= 2 * radius; ++k) {
        double x = (double)k - (double)radius;
        sum += taps[k] = exp(-x * x * factor);
    }
    return sum;
}

/* Applies the eye's filter of one channel (sec. 4.1.1), normalized to keep a constant. */
static void filter_channel(const double *in, const planes *size, int channel, double ppd, size_t radius,
                           double *scratch, double *out)
{
    double first[2 * MAX_RADIUS + 1], second[2 * MAX_RADIUS + 1];
    double b1 = sensitivity[channel].b1, b2 = sensitivity[channel].b2;
    double w1 = sensitivity[channel].a1 * sqrt(PI / b1), w2 = sensitivity[channel].a2 * sqrt(PI / b2);
    double sum1 = gaussian(PI * PI / (b1 * ppd * ppd), radius, first);
    double sum2 = gaussian(PI * PI / (b2 * ppd * ppd), radius, second);
    double total = w1 * sum1 * sum1 + w2 * sum2 * sum2;
    memset(out, 0, size->width * size->height * sizeof *out);
    add_separable(in, size, &(separable){first, first, radius, w1 / total}, scratch, out);
    if (w2 > 0)
        add_separable(in, size, &(separable){second, second, radius, w2 / total}, scratch, out);
}

/* Scales the positive taps to a sum of 1 and the negative ones to -1 (sec. 4.2). */
static void balance(double *taps, size_t radius)
{
    double positive = 0, negative = 0;
    for (size_t k = 0; k <= 2 * radius; ++k)
        *(taps[k] > 0 ? &positive : &negative) += fabs(taps[k]);
    for (size_t k = 0; k <= 2 * radius; ++k)
        taps[k] /= taps[k] > 0 ? positive : negative > 0 ? negative : 1;
}

/* Computes the length of (filter along x, filter along y) of the luminance; the other axis is smoothed. */
static void detect(const double *luminance, const planes *size, const separable *along, double *scratch,
                   double *along_y, double *out)
{
    const separable across = {along->along_y, along->along_x, along->radius, along->weight};
    size_t count = size->width * size->height;
    memset(out, 0, count * sizeof *out);
    memset(along_y, 0, count * sizeof *along_y);
    add_separable(luminance, size, along, scratch, out);
    add_separable(luminance, size, &across, scratch, along_y);
    for (size_t i = 0; i < count; ++i)
        out[i] = hypot(out[i], along_y[i]);
}

static void detect_features(const double *luminance, double ppd, double *scratch, double *scratch2, percept *p)
{
    double sigma = 0.5 * feature_width_deg * ppd;
    size_t radius = (size_t)ceil(3 * sigma);
    double smooth[2 * MAX_RADIUS + 1], edge[2 * MAX_RADIUS + 1], point[2 * MAX_RADIUS + 1];
    double sum = gaussian(1 / (2 * sigma * sigma), radius, smooth);
    for (size_t k = 0; k <= 2 * radius; ++k) {
        double x = (double)k - (double)radius;
        edge[k] = -x * smooth[k];
        point[k] = (x * x / (sigma * sigma) - 1) * smooth[k];
        smooth[k] /= sum;
    }
    balance(edge, radius);
    balance(point, radius);
    detect(luminance, &p->color, &(separable){edge, smooth, radius, 1}, scratch, scratch2, p->edges);
    detect(luminance, &p->color, &(separable){point, smooth, radius, 1}, scratch, scratch2, p->points);
}

static void percept_destroy(percept *p)
{
    for (int c = 0; c < 3; ++c)
        free(p->color.at[c]);
    free(p->edges);
    free(p->points);
}

/* Scales, then applies the tone curve if tone is set, then clips. */
static void display_color(const float *rgba, double scale, bool tone, double rgb[3])
{
    for (int c = 0; c < 3; ++c) {
        double x = scale * rgba[c];
        if (tone) { /* ACES fit of Narkowicz, with its exposure factor of 0.6 */
            x = x > 0 ? 0.6 * x : 0;
            x = isfinite(x) ? x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14) : 0;
        }
        rgb[c] = clip(x);
    }
}

static iso_status perceive(const iso_image *image, double ppd, double scale, bool tone, percept *p, iso_error *err)
{
    size_t count = image->width * image->height;
    *p = (percept){.color = {.width = image->width, .height = image->height}};
    double *opponent[3] = {calloc(count, 8), calloc(count, 8), calloc(count, 8)};
    double *scratch = calloc(count, 8);
    bool good = opponent[0] && opponent[1] && opponent[2] && scratch;
    for (int c = 0; c < 3; ++c)
        good = (p->color.at[c] = calloc(count, 8)) && good;
    p->edges = calloc(count, 8);
    p->points = calloc(count, 8);
    good = good && p->edges && p->points;
    for (size_t i = 0; good && i < count; ++i) {
        double rgb[3], out[3];
        display_color(image->rgba + 4 * i, scale, tone, rgb);
        opponent_from_rgb(rgb, out);
        for (int c = 0; c < 3; ++c)
            opponent[c][i] = out[c];
    }
    if (good) {
        size_t radius = (size_t)ceil(3 * sqrt(0.04 / (2 * PI * PI)) * ppd); /* 3 sigma of the widest Gaussian */
        for (int c = 0; c < 3; ++c)
            filter_channel(opponent[c], &p->color, c, ppd, radius, scratch, p->color.at[c]);
        for (size_t i = 0; i < count; ++i) {
            double rgb[3], lab[3];
            rgb_from_opponent((double[3]){p->color.at[0][i], p->color.at[1][i], p->color.at[2][i]}, rgb);
            for (int c = 0; c < 3; ++c)
                rgb[c] = clip(rgb[c]);
            adapted_lab(rgb, lab);
            for (int c = 0; c < 3; ++c)
                p->color.at[c][i] = lab[c];
            opponent[0][i] = (opponent[0][i] + 16) / 116;
        }
        detect_features(opponent[0], ppd, scratch, opponent[1], p);
    }
    for (int c = 0; c < 3; ++c)
        free(opponent[c]);
    free(scratch);
    if (good)
        return ISO_OK;
    percept_destroy(p);
    *p = (percept){0};
    return iso_fail(err, ISO_E_MEMORY, "FLIP: no memory for %zu pixels", count);
}

/* Combines color difference raised to 1 - feature difference (Eq. 7); map keeps the larger of it and its old value. */
static void combine(const percept *a, const percept *b, size_t count, float *map)
{
    double largest = largest_color_difference();
    for (size_t i = 0; i < count; ++i) {
        double lab_a[3] = {a->color.at[0][i], a->color.at[1][i], a->color.at[2][i]};
        double lab_b[3] = {b->color.at[0][i], b->color.at[1][i], b->color.at[2][i]};
        double color = spread(hyab(lab_a, lab_b), largest);
        double feature = fmax(fabs(a->edges[i] - b->edges[i]), fabs(a->points[i] - b->points[i]));
        double value = pow(color, 1 - pow(feature / sqrt(2), q_feature));
        map[i] = fmaxf(map[i], (float)clip(value));
    }
}

static iso_status check(const iso_image *a, const iso_image *b, double ppd, iso_error *err)
{
    if (a->width == 0 || a->height == 0 || !a->rgba)
        return iso_fail(err, ISO_E_RANGE, "FLIP: the image is empty");
    if (a->width != b->width || a->height != b->height)
        return iso_fail(err, ISO_E_RANGE, "FLIP: images of %zux%zu and %zux%zu pixels", a->width, a->height, b->width,
                        b->height);
    double limit = MAX_RADIUS / 0.14; /* 3 sigma of the widest Gaussian is 0.135 degrees */
    if (!(ppd >= 1 && ppd <= limit))
        return iso_fail(err, ISO_E_RANGE, "FLIP: %g pixels a degree, must be 1 to %g", ppd, limit);
    return ISO_OK;
}

static iso_status flip_at(const iso_image *a, const iso_image *b, double ppd, double scale, bool tone, float *map,
                          iso_error *err)
{
    OWNED(percept) pa = {0}, pb = {0};
    NEED(perceive(a, ppd, scale, tone, &pa, err));
    NEED(perceive(b, ppd, scale, tone, &pb, err));
    combine(&pa, &pb, a->width * a->height, map);
    return ISO_OK;
}

iso_status iso_flip_ldr(const iso_image *a, const iso_image *b, double pixels_per_degree, float *map, iso_error *err)
{
    NEED(check(a, b, pixels_per_degree, err));
    memset(map, 0, a->width * a->height * sizeof *map);
    return flip_at(a, b, pixels_per_degree, 1, false, map, err);
}

/* Computes the exposures of [andersson-2021] sec. 3.2: the tone curve reaches 0.85 at `bright`. */
iso_status iso_flip_exposures(const iso_image *reference, double *start, double *stop, size_t *count, iso_error *err)
{
    size_t pixels = reference->width * reference->height;
    double *luminance = calloc(pixels, sizeof *luminance);
    NEED_MEMORY(luminance, err, "FLIP: no memory for %zu pixels", pixels);
    for (size_t i = 0; i < pixels; ++i) {
        double sum = 0;
        for (int c = 0; c < 3; ++c)
            sum += xyz_from_rgb[1][c] * reference->rgba[4 * i + c];
        luminance[i] = isfinite(sum) && sum > 0 ? sum : 0;
    }
    qsort(luminance, pixels, sizeof *luminance, iso_order_doubles);
    double brightest = luminance[pixels - 1];
    double median = pixels % 2 ? luminance[pixels / 2] : 0.5 * (luminance[pixels / 2 - 1] + luminance[pixels / 2]);
    free(luminance);
    /* 0.36 (2.51 - 0.85 2.43) x^2 + 0.6 (0.03 - 0.85 0.59) x - 0.85 0.14 = 0 */
    double a = 0.36 * (2.51 - 0.85 * 2.43), b = 0.6 * (0.03 - 0.85 * 0.59), c = -0.85 * 0.14;
    double bright = (-b + sqrt(b * b - 4 * a * c)) / (2 * a);
    *start = brightest > 0 ? log2(bright / brightest) : 0;
    /* No exposure lifts a black median (background); the range then spans 8 stops. */
    *stop = median > 0 ? fmin(log2(bright / median), *start + 20) : *start + 8;
    *count = (size_t)fmax(2, ceil(*stop - *start));
    return ISO_OK;
}

iso_status iso_flip_hdr(const iso_image *reference, const iso_image *b, double pixels_per_degree, float *map,
                        iso_error *err)
{
    double start = 0, stop = 0;
    size_t count = 0;
    NEED(check(reference, b, pixels_per_degree, err));
    NEED(iso_flip_exposures(reference, &start, &stop, &count, err));
    memset(map, 0, reference->width * reference->height * sizeof *map);
    for (size_t k = 0; k < count; ++k)
        NEED(flip_at(reference, b, pixels_per_degree, exp2(start + (stop - start) * (double)k / (double)(count - 1)),
                     true, map, err));
    return ISO_OK;
}

double iso_flip_mean(const float *map, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; ++i)
        sum += map[i];
    return count ? sum / (double)count : NAN;
}
