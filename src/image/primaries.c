/* SPDX-License-Identifier: MIT */
#include "image/primaries.h"

#include <math.h>
#include <string.h>

enum { WHITE = 3 };
static const iso_primaries rec709 = {{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}}};

/* Rounded digits of one standard differ by less, primaries of different standards by more. */
static const double same_chromaticity = 5e-4;

static bool is_rec709(const iso_primaries *p)
{
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 2; ++k)
            if (!(fabs(p->xy[i][k] - rec709.xy[i][k]) < same_chromaticity))
                return false;
    return true;
}

static void multiply(double a[3][3], double b[3][3], double product[3][3])
{
    double sum[3][3] = {{0}};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                sum[i][j] += a[i][k] * b[k][j];
    memcpy(product, sum, sizeof sum);
}

/* Inverts by cofactors. False: the matrix is singular. */
static bool invert(double m[3][3], double inverse[3][3])
{
    double cofactor[3][3], determinant = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            cofactor[j][i] = m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3] -
                             m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3];
    for (int j = 0; j < 3; ++j)
        determinant += m[0][j] * cofactor[j][0];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            inverse[i][j] = cofactor[i][j] / determinant;
    return fabs(determinant) > 1e-9 && isfinite(determinant);
}

/* Computes XYZ of a chromaticity with Y = 1. False: it has no finite XYZ. */
static bool xyz_of(const double xy[2], double xyz[3])
{
    xyz[0] = xy[0] / xy[1];
    xyz[1] = 1;
    xyz[2] = (1 - xy[0] - xy[1]) / xy[1];
    return fabs(xy[1]) > 1e-9 && isfinite(xyz[0]) && isfinite(xyz[2]);
}

/* Computes the matrix from RGB to XYZ: columns are the primaries, scaled so that (1, 1, 1) is white (SMPTE RP 177). */
static bool rgb_to_xyz(const iso_primaries *p, double matrix[3][3])
{
    double columns[3][3], inverse[3][3], white[3];
    for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
            columns[i][j] = i == 2 ? 1 - p->xy[j][0] - p->xy[j][1] : p->xy[j][i];
    if (!xyz_of(p->xy[WHITE], white) || !invert(columns, inverse))
        return false;
    for (int j = 0; j < 3; ++j) {
        const double scale = inverse[j][0] * white[0] + inverse[j][1] * white[1] + inverse[j][2] * white[2];
        for (int i = 0; i < 3; ++i)
            matrix[i][j] = columns[i][j] * scale;
    }
    return true;
}

/* Computes the matrix from XYZ under one white point to another: a diagonal in Bradford's space of cone responses. */
static bool adapt(const double from[2], const double to[2], double matrix[3][3])
{
    double cones[3][3] = {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}};
    double a[3], b[3], inverse[3][3], scaled[3][3];
    if (!xyz_of(from, a) || !xyz_of(to, b) || !invert(cones, inverse))
        return false;
    for (int i = 0; i < 3; ++i) {
        double of_a = 0, of_b = 0;
        for (int j = 0; j < 3; ++j) {
            of_a += cones[i][j] * a[j];
            of_b += cones[i][j] * b[j];
        }
        if (!(fabs(of_a) > 1e-9))
            return false;
        for (int j = 0; j < 3; ++j)
            scaled[i][j] = cones[i][j] * of_b / of_a;
    }
    multiply(inverse, scaled, matrix);
    return true;
}

bool iso_primaries_matrix(const iso_primaries *from, double matrix[3][3])
{
    static const double identity[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double to_xyz[3][3], between[3][3], ours[3][3], from_xyz[3][3];
    memcpy(matrix, identity, sizeof identity);
    if (is_rec709(from))
        return true;
    if (!rgb_to_xyz(from, to_xyz) || !adapt(from->xy[WHITE], rec709.xy[WHITE], between) || !rgb_to_xyz(&rec709, ours) ||
        !invert(ours, from_xyz))
        return false;
    multiply(between, to_xyz, matrix);
    multiply(from_xyz, matrix, matrix);
    return true;
}

iso_status iso_primaries_convert(const char *path, const iso_primaries *from, iso_image *image, iso_error *err)
{
    double m[3][3];
    if (is_rec709(from))
        return ISO_OK;
    if (!iso_primaries_matrix(from, m))
        return iso_fail(err, ISO_E_FORMAT, "%s: red, green and blue have chromaticities on one line, must span colors", path);
    for (size_t i = 0; i < image->width * image->height; ++i) {
        float *p = image->rgba + 4 * i;
        const double r = p[0], g = p[1], b = p[2];
        for (int c = 0; c < 3; ++c)
            p[c] = (float)(m[c][0] * r + m[c][1] * g + m[c][2] * b);
    }
    return ISO_OK;
}
