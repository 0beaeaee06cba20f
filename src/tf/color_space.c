/* SPDX-License-Identifier: MIT */
#include "tf/color_space.h"

#include <math.h>
#include <string.h>

static const struct {
    const char *name, *summary;
} spaces[] = {
    {"RGB", "display colors"},
    {"HSV", "hue, saturation, value; hue is interpolated without wrapping"},
    {"Wrapped", "HSV; hue takes the shorter way round the circle"},
    {"Lab", "CIE L*a*b*"},
    {"Diverging", "Msh: through white if two saturated colors differ much in hue"},
    {"ProLab", "ProLab"},
    {"Step", "constant: each interval has the color of its upper point"},
};
const iso_names iso_color_space_names = ISO_NAMES_OF_ROWS("color space", spaces);

static const double pi = 3.14159265358979323846;

double iso_srgb_to_linear(double c)
{
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

double iso_linear_to_srgb(double c)
{
    return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
}

/* ---- RGB to the spaces and back --------------------------------------------------------------------------------- */

static void hsv_of(const double rgb[3], double hsv[3])
{
    const double most = fmax(rgb[0], fmax(rgb[1], rgb[2])), least = fmin(rgb[0], fmin(rgb[1], rgb[2]));
    const double chroma = most - least;
    hsv[0] = 0;
    hsv[1] = most > 0 ? chroma / most : 0;
    hsv[2] = most;
    if (!(chroma > 0))
        return;
    const int c = rgb[0] == most ? 0 : rgb[1] == most ? 1 : 2; /* strongest component: hue 0 of its sector */
    hsv[0] = c / 3.0 + (rgb[(c + 1) % 3] - rgb[(c + 2) % 3]) / chroma / 6;
    if (hsv[0] < 0)
        hsv[0] += 1;
}

static void rgb_of_hsv(const double hsv[3], double rgb[3])
{
    for (int c = 0; c < 3; ++c) { /* hue distance to this component, in sixths of the circle */
        double away = fabs(6 * (hsv[0] - c / 3.0));
        away = fmin(away, 6 - away);
        const double full = fmin(fmax(2 - away, 0), 1);
        rgb[c] = hsv[2] * (hsv[1] * full + 1 - hsv[1]);
    }
}

static const double white[3] = {0.9505, 1, 1.089}; /* D65, 2 degrees */

/* Converts a display color to CIE XYZ, each component 1 for white. */
static void xyz_of(const double rgb[3], double xyz[3])
{
    static const double m[3][3] = {{0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}};
    double linear[3];
    for (int c = 0; c < 3; ++c)
        linear[c] = iso_srgb_to_linear(rgb[c]);
    for (int i = 0; i < 3; ++i)
        xyz[i] = (m[i][0] * linear[0] + m[i][1] * linear[1] + m[i][2] * linear[2]) / white[i];
}

/* Converts XYZ to sRGB. Scales colors outside the display's gamut to its brightest, then clamps them, as VTK does. */
static void rgb_of_xyz(const double xyz[3], double rgb[3])
{
    static const double m[3][3] = {{3.2406, -1.5372, -0.4986}, {-0.9689, 1.8758, 0.0415}, {0.0557, -0.2040, 1.0570}};
    double most = 1;
    for (int c = 0; c < 3; ++c) {
        const double linear = m[c][0] * xyz[0] * white[0] + m[c][1] * xyz[1] * white[1] + m[c][2] * xyz[2] * white[2];
        rgb[c] = iso_linear_to_srgb(linear);
        most = fmax(most, rgb[c]);
    }
    for (int c = 0; c < 3; ++c)
        rgb[c] = fmax(rgb[c] / most, 0);
}

void iso_color_to_lab(const double rgb[3], double lab[3])
{
    double f[3];
    xyz_of(rgb, f);
    for (int i = 0; i < 3; ++i)
        f[i] = f[i] > 0.008856 ? cbrt(f[i]) : 7.787 * f[i] + 16.0 / 116;
    lab[0] = 116 * f[1] - 16;
    lab[1] = 500 * (f[0] - f[1]);
    lab[2] = 200 * (f[1] - f[2]);
}

static void rgb_of_lab(const double lab[3], double rgb[3])
{
    const double y = (lab[0] + 16) / 116;
    double xyz[3] = {lab[1] / 500 + y, y, y - lab[2] / 200};
    for (int i = 0; i < 3; ++i) {
        const double cube = xyz[i] * xyz[i] * xyz[i];
        xyz[i] = cube > 0.008856 ? cube : (xyz[i] - 16.0 / 116) / 7.787;
    }
    rgb_of_xyz(xyz, rgb);
}

/* Converts to ProLab, a projective map of XYZ; its matrix and the inverse as in vtkMath. */
static void prolab_of(const double rgb[3], double lab[3])
{
    double v[3];
    xyz_of(rgb, v);
    const double w = 0.7554 * v[0] + 3.8666 * v[1] + 1.6739 * v[2] + 1;
    lab[0] = (75.54 * v[0] + 486.66 * v[1] + 167.39 * v[2]) / w;
    lab[1] = (617.72 * v[0] - 595.45 * v[1] - 22.27 * v[2]) / w;
    lab[2] = (48.34 * v[0] + 194.94 * v[1] - 243.28 * v[2]) / w;
}

static void rgb_of_prolab(const double lab[3], double rgb[3])
{
    static const double m[4][3] = {{0.00137063282117354, 0.00138738203138321, 0.000816068851107095},
                                   {0.00137063282117354, -0.000243154854293407, 0.000965329194924993},
                                   {0.00137063282117354, 8.08345942991924e-05, -0.00317481896776885},
                                   {-0.00862936717882646, -0.000243154854293407, 0.000965329194924994}};
    double v[4], xyz[3];
    for (int i = 0; i < 4; ++i)
        v[i] = m[i][0] * lab[0] + m[i][1] * lab[1] + m[i][2] * lab[2] + (i == 3);
    for (int i = 0; i < 3; ++i)
        xyz[i] = v[i] / v[3];
    rgb_of_xyz(xyz, rgb);
}

/* ---- Msh [moreland-2009] ------------------------------------------------------------------------------------- */

static void msh_of(const double rgb[3], double msh[3])
{
    double lab[3];
    iso_color_to_lab(rgb, lab);
    msh[0] = sqrt(lab[0] * lab[0] + lab[1] * lab[1] + lab[2] * lab[2]);
    msh[1] = msh[0] > 0.001 ? acos(lab[0] / msh[0]) : 0;
    msh[2] = msh[1] > 0.001 ? atan2(lab[2], lab[1]) : 0;
}

/* Returns the hue for a gray end of a path to a saturated color, rotated so that the steps look equal. */
static double hue_for_gray(const double saturated[3], double gray)
{
    if (saturated[0] >= gray - 0.1)
        return saturated[2];
    const double spin = saturated[1] * sqrt(gray * gray - saturated[0] * saturated[0]) /
                        (saturated[0] * sin(saturated[1]));
    return saturated[2] > -0.3 * pi ? saturated[2] + spin : saturated[2] - spin;
}

static double hue_difference(double a, double b)
{
    return remainder(a - b, 2 * pi);
}

static void mix_diverging(const double from[3], const double to[3], double s, double rgb[3])
{
    double a[3], b[3], msh[3];
    msh_of(from, a);
    msh_of(to, b);
    if (a[1] > 0.05 && b[1] > 0.05 && fabs(hue_difference(a[2], b[2])) > 0.33 * pi) {
        const double middle[3] = {fmax(88, fmax(a[0], b[0])), 0, 0};
        memcpy(s < 0.5 ? b : a, middle, sizeof middle);
        s = s < 0.5 ? 2 * s : 2 * s - 1;
    }
    if (a[1] < 0.05 && b[1] > 0.05)
        a[2] = hue_for_gray(b, a[0]);
    else if (b[1] < 0.05 && a[1] > 0.05)
        b[2] = hue_for_gray(a, b[0]);
    for (int i = 0; i < 2; ++i)
        msh[i] = (1 - s) * a[i] + s * b[i];
    msh[2] = a[2] + s * hue_difference(b[2], a[2]);
    const double radius = msh[0] * sin(msh[1]);
    rgb_of_lab((double[]){msh[0] * cos(msh[1]), radius * cos(msh[2]), radius * sin(msh[2])}, rgb);
}

/* ---- interpolation between two colors ---------------------------------------------------------------------------- */

double iso_sharp_mix(double from, double to, double s, double sharpness)
{
    if (sharpness < 0.01)
        return (1 - s) * from + s * to;
    /* Cubic from `from` to `to`; the slope at both ends falls with the sharpness. */
    const double h = s * s * (3 - 2 * s), slopes = s * (2 * s - 1) * (s - 1);
    return from + (to - from) * (h + (1 - sharpness) * slopes);
}

typedef void (*conversion)(const double from[3], double to[3]);

static void unchanged(const double from[3], double to[3])
{
    memcpy(to, from, 3 * sizeof *to);
}

void iso_color_mix(iso_color_space space, const double from[3], const double to[3], double s, double sharpness,
                   double rgb[3])
{
    static const struct {
        conversion into, back;
    } ways[] = {[ISO_SPACE_RGB] = {unchanged, unchanged},
                [ISO_SPACE_HSV] = {hsv_of, rgb_of_hsv},
                [ISO_SPACE_WRAPPED] = {hsv_of, rgb_of_hsv},
                [ISO_SPACE_LAB] = {iso_color_to_lab, rgb_of_lab},
                [ISO_SPACE_PROLAB] = {prolab_of, rgb_of_prolab}};
    if (space == ISO_SPACE_STEP) {
        unchanged(to, rgb);
        return;
    }
    if (space == ISO_SPACE_DIVERGING) { /* VTK ignores the sharpness here, too */
        mix_diverging(from, to, s, rgb);
        return;
    }
    double a[3], b[3], mixed[3];
    ways[space].into(from, a);
    ways[space].into(to, b);
    if (space == ISO_SPACE_WRAPPED && fabs(a[0] - b[0]) > 0.5)
        *(a[0] > b[0] ? a : b) -= 1;
    for (int i = 0; i < 3; ++i)
        mixed[i] = iso_sharp_mix(a[i], b[i], s, sharpness);
    if (space == ISO_SPACE_WRAPPED && mixed[0] < 0)
        mixed[0] += 1;
    ways[space].back(mixed, rgb);
    for (int c = 0; c < 3; ++c)
        rgb[c] = fmin(fmax(rgb[c], 0), 1);
}
