/* SPDX-License-Identifier: MIT */
#include "pyramid/filter_kernel.h"

#include <float.h>
#include <math.h>
#include <string.h>

#ifdef __SSSE3__
#include <tmmintrin.h>
#endif

#include "base/simd.h"

size_t iso_state_count(iso_direction_filter f)
{
    return f == ISO_DIRECTION_NAIVE    ? 3
           : f == ISO_DIRECTION_TENSOR ? 9
           : f == ISO_DIRECTION_EQ1    ? 5
           : f == ISO_DIRECTION_AUTO   ? 10
                                       : 4;
}

/* ---- taps ---- */

iso_taps iso_taps_gauss(size_t radius, double sigma)
{
    iso_taps taps = {.count = 2 * radius};
    double sum = 0;
    for (size_t t = 0; t < taps.count; ++t) {
        double offset = (double)t + 0.5 - (double)radius;
        sum += exp(-0.5 * offset * offset / (sigma * sigma));
    }
    for (size_t t = 0; t < taps.count; ++t) {
        double offset = (double)t + 0.5 - (double)radius;
        taps.weight[t] = (float)(exp(-0.5 * offset * offset / (sigma * sigma)) / sum);
    }
    return taps;
}

/* ---- level 0 ---- */

/* Returns 1 / |g|, for d = g / |g|; zero for a gradient whose square vanishes. */
static inline float inverse_length(float m2, float m)
{
    float inverse = 1 / m;
    return m2 >= FLT_MIN ? inverse : 0;
}

static inline __attribute__((always_inline)) void moments_into(const float *gx, const float *gy, const float *gz,
                                                               size_t n, float *restrict ax, float *restrict ay,
                                                               float *restrict az, float *restrict as, bool add)
{
    for (size_t i = 0; i < n; ++i) {
        float x = gx[i], y = gy[i], z = gz[i], m2 = x * x + y * y + z * z, m = sqrtf(m2);
        ax[i] = add ? ax[i] + m * x : m * x;
        ay[i] = add ? ay[i] + m * y : m * y;
        az[i] = add ? az[i] + m * z : m * z;
        as[i] = add ? as[i] + m2 : m2;
    }
}

ISO_SIMD static void moments(const float *gx, const float *gy, const float *gz, size_t n, float *restrict acc,
                             size_t stride, bool add)
{
    float *ax = acc, *ay = acc + stride, *az = acc + 2 * stride, *as = acc + 3 * stride;
    if (add)
        moments_into(gx, gy, gz, n, ax, ay, az, as, true);
    else
        moments_into(gx, gy, gz, n, ax, ay, az, as, false);
}

ISO_SIMD static void moment_vectors(const float *restrict gx, const float *restrict gy, const float *restrict gz,
                                    size_t n, float *restrict acc, size_t stride, bool add)
{
    float *ax = acc, *ay = acc + stride, *az = acc + 2 * stride;
    for (size_t i = 0; i < n; ++i) {
        float x = gx[i], y = gy[i], z = gz[i], m = sqrtf(x * x + y * y + z * z);
        ax[i] = add ? ax[i] + m * x : m * x;
        ay[i] = add ? ay[i] + m * y : m * y;
        az[i] = add ? az[i] + m * z : m * z;
    }
}

static inline float power(float m, size_t exponent)
{
    float result = 1;
    for (size_t i = 0; i < exponent; ++i)
        result *= m;
    return result;
}

static inline __attribute__((always_inline)) void eq1_weigh_by(const float *gx, const float *gy, const float *gz,
                                                               size_t n, size_t exponent, float *restrict acc,
                                                               size_t stride)
{
    float *ax = acc, *ay = acc + stride, *az = acc + 2 * stride, *aw = acc + 3 * stride, *am = acc + 4 * stride;
    for (size_t i = 0; i < n; ++i) {
        float x = gx[i], y = gy[i], z = gz[i], m = sqrtf(x * x + y * y + z * z), w = power(m, exponent);
        ax[i] = w * x;
        ay[i] = w * y;
        az[i] = w * z;
        aw[i] = w;
        am[i] = m;
    }
}

ISO_SIMD static void eq1_weigh(const float *gx, const float *gy, const float *gz, size_t n, size_t exponent,
                               float *restrict acc, size_t stride)
{
    if (exponent == 1)
        eq1_weigh_by(gx, gy, gz, n, 1, acc, stride);
    else
        eq1_weigh_by(gx, gy, gz, n, exponent, acc, stride);
}

ISO_SIMD static void products(const float *restrict a, const float *restrict b, size_t n, float *restrict acc, bool add)
{
    for (size_t i = 0; i < n; ++i)
        acc[i] = add ? acc[i] + a[i] * b[i] : a[i] * b[i];
}

/* Returns the component at which T begins in a state. */
static size_t tensor_row(iso_direction_filter f)
{
    return f == ISO_DIRECTION_AUTO ? 4 : 3;
}

void iso_state_from_gradients(iso_direction_filter f, size_t eq1_exponent, float *const g[3], size_t n,
                              float *restrict acc, size_t stride, bool add)
{
    const float *gx = g[0], *gy = g[1], *gz = g[2];
    if (f == ISO_DIRECTION_MOMENTS) {
        moments(gx, gy, gz, n, acc, stride, add);
        return;
    }
    if (f == ISO_DIRECTION_EQ1) {
        eq1_weigh(gx, gy, gz, n, eq1_exponent, acc, stride);
        return;
    }
    if (f == ISO_DIRECTION_TENSOR || f == ISO_DIRECTION_AUTO) {
        static const int pair[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
        if (f == ISO_DIRECTION_AUTO)
            moments(gx, gy, gz, n, acc, stride, add);
        else
            moment_vectors(gx, gy, gz, n, acc, stride, add);
        for (size_t i = 0; i < 6; ++i)
            products(g[pair[i][0]], g[pair[i][1]], n, acc + (tensor_row(f) + i) * stride, add);
        return;
    }
    iso_accumulate_row(gx, n, acc, add);
    iso_accumulate_row(gy, n, acc + stride, add);
    iso_accumulate_row(gz, n, acc + 2 * stride, add);
}

/* Implements iso_unit_rows(). Each written row is a parameter of its own, because `restrict` counts for those. */
ISO_SIMD static void unit_rows(const float *gx, const float *gy, const float *gz, size_t n, float *restrict dx,
                               float *restrict dy, float *restrict dz, float *restrict length)
{
    for (size_t i = 0; i < n; ++i) {
        float x = gx[i], y = gy[i], z = gz[i], m2 = x * x + y * y + z * z, m = sqrtf(m2);
        float inverse = inverse_length(m2, m);
        dx[i] = x * inverse;
        dy[i] = y * inverse;
        dz[i] = z * inverse;
        if (length)
            length[i] = m;
    }
}

void iso_unit_rows(float *const g[3], size_t n, float *const d[3], float *restrict length)
{
    unit_rows(g[0], g[1], g[2], n, d[0], d[1], d[2], length);
}

/* Gets the range. Finite samples and a sign of zero that does not matter let the compiler vectorize the comparisons. */
ISO_SIMD __attribute__((optimize("finite-math-only", "no-signed-zeros"))) void iso_row_range(const float *row, size_t n,
                                                                                             float *lo, float *hi)
{
    float low = *lo, high = *hi;
    for (size_t i = 0; i < n; ++i) {
        low = row[i] < low && row[i] != ISO_NO_DATA ? row[i] : low;
        high = row[i] > high ? row[i] : high;
    }
    *lo = low;
    *hi = high;
}

ISO_SIMD static void u16_row(const uint16_t *restrict in, size_t n, float *restrict out)
{
    for (size_t i = 0; i < n; ++i)
        out[i] = (float)in[i];
}

ISO_SIMD static void u8_row(const uint8_t *restrict in, size_t n, float *restrict out)
{
    for (size_t i = 0; i < n; ++i)
        out[i] = (float)in[i];
}

void iso_scalar_row(const iso_planes *p, size_t y, size_t z, float *restrict row, float *restrict acc, bool add,
                    float range[2])
{
    const size_t n = p->size[0], first = ((z - p->first) * p->size[1] + y) * n;
    if (p->type == ISO_U16)
        u16_row((const uint16_t *)p->data + first, n, row);
    else if (p->type == ISO_U8)
        u8_row((const uint8_t *)p->data + first, n, row);
    else
        iso_planes_row(p, y, z, row);
    iso_row_range(row, n, &range[0], &range[1]);
    iso_accumulate_row(row, n, acc, add);
}

/* ---- from level to level ---- */

ISO_SIMD static void add_row(const float *restrict row, size_t n, float *restrict acc)
{
    for (size_t i = 0; i < n; ++i)
        acc[i] += row[i];
}

void iso_accumulate_row(const float *restrict row, size_t n, float *restrict acc, bool add)
{
    if (add)
        add_row(row, n, acc);
    else
        memcpy(acc, row, n * sizeof *row);
}

void iso_double_row(float *row, size_t n)
{
    for (size_t i = 0; i < n; ++i)
        row[i] *= 2;
}

void iso_scale_row(float *row, size_t n, float factor)
{
    for (size_t i = 0; i < n; ++i)
        row[i] *= factor;
}

/* Averages pairs along x of pairs along z of pairs along y: mirrored input gives mirrored output, bit for bit. */
ISO_SIMD static void mean_pairs(const float *restrict a, const float *restrict b, size_t half, float *restrict out)
{
    for (size_t i = 0; i < half; ++i)
        out[i] = 0.125f * ((a[2 * i] + b[2 * i]) + (a[2 * i + 1] + b[2 * i + 1]));
}

void iso_mean_row(float *restrict a, float *restrict b, size_t n, float *restrict out)
{
    if (n % 2) {
        a[n] = a[n - 1];
        b[n] = b[n - 1];
    }
    mean_pairs(a, b, (n + 1) / 2, out);
}

static float majority_of(const float label[8])
{
    float best = label[0];
    int most = 0;
    for (int i = 0; i < 8; ++i) {
        int count = 0;
        for (int j = 0; j < 8; ++j)
            count += label[j] == label[i];
        if (count > most || (count == most && label[i] > best)) {
            most = count;
            best = label[i];
        }
    }
    return best;
}

void iso_majority_row(const float *const rows[4], size_t n, float *restrict out)
{
    for (size_t i = 0; i < (n + 1) / 2; ++i) {
        const size_t x[2] = {2 * i, 2 * i + 1 < n ? 2 * i + 1 : 2 * i};
        float label[8];
        for (int c = 0; c < 8; ++c)
            label[c] = rows[c / 2][x[c % 2]];
        out[i] = majority_of(label);
    }
}

void iso_valid_mean_row(const float *const rows[4], size_t n, float *restrict out)
{
    for (size_t i = 0; i < (n + 1) / 2; ++i) {
        const size_t x[2] = {2 * i, 2 * i + 1 < n ? 2 * i + 1 : 2 * i};
        double sum = 0;
        int count = 0;
        for (int c = 0; c < 8; ++c) {
            const float value = rows[c / 2][x[c % 2]];
            sum += iso_is_no_data(value) ? 0 : (double)value;
            count += !iso_is_no_data(value);
        }
        out[i] = count ? (float)(sum / count) : ISO_NO_DATA;
    }
}

ISO_SIMD static void weigh_pairs(float weight, const float *restrict row, size_t half, float *restrict out)
{
    for (size_t i = 0; i < half; ++i)
        out[i] += weight * row[2 * i];
}

ISO_SIMD static void weigh_four(const float *restrict w, const float *restrict row, size_t half, float *restrict out)
{
    for (size_t i = 0; i < half; ++i)
        out[i] = ((w[0] * row[2 * i] + w[1] * row[2 * i + 1]) + w[2] * row[2 * i + 2]) + w[3] * row[2 * i + 3];
}

void iso_taps_row(const iso_taps *taps, const float *restrict row, size_t n, float *restrict padded,
                  float *restrict out)
{
    const size_t radius = taps->count / 2, half = (n + 1) / 2;
    for (size_t i = 0; i < radius - 1; ++i)
        padded[i] = row[0];
    memcpy(padded + radius - 1, row, n * sizeof *row);
    for (size_t i = 0; i < radius + 1; ++i)
        padded[radius - 1 + n + i] = row[n - 1];
    if (taps->count == 4) {
        weigh_four(taps->weight, padded, half, out);
        return;
    }
    memset(out, 0, half * sizeof *out);
    for (size_t t = 0; t < taps->count; ++t)
        weigh_pairs(taps->weight[t], padded + t, half, out);
}

/* Divides the sums of G m g by those of m g of [diaz-garcia-2017] Eq. 1; the quotient is the filtered gradient, whose
 * own length weighs the next level. */
ISO_SIMD void iso_eq1_finish(float *restrict state, size_t stride, size_t n, size_t exponent)
{
    float *sx = state, *sy = state + stride, *sz = state + 2 * stride, *sw = state + 3 * stride,
          *sm = state + 4 * stride;
    for (size_t i = 0; i < n; ++i) {
        float inverse = 1 / sw[i];
        inverse = sw[i] >= FLT_MIN ? inverse : 0;
        float x = sx[i] * inverse, y = sy[i] * inverse, z = sz[i] * inverse;
        float m = sqrtf(x * x + y * y + z * z), w = power(m, exponent);
        sx[i] = w * x;
        sy[i] = w * y;
        sz[i] = w * z;
        sw[i] = w;
        sm[i] = m;
    }
}

/* ---- from states to stored values ---- */

/* Computes (N / |N|) L^2 = (N / S) L: quotients before squares, so that small gradients do not underflow. */
ISO_SIMD static void moment_directions(const float *restrict state, size_t stride, size_t n, float *restrict dx,
                                       float *restrict dy, float *restrict dz)
{
    const float *sx = state, *sy = state + stride, *sz = state + 2 * stride, *ss = state + 3 * stride;
    for (size_t i = 0; i < n; ++i) {
        float inverse = 1 / ss[i];
        inverse = ss[i] >= FLT_MIN ? inverse : 0;
        float x = sx[i] * inverse, y = sy[i] * inverse, z = sz[i] * inverse;
        float length = sqrtf(x * x + y * y + z * z);
        dx[i] = x * length;
        dy[i] = y * length;
        dz[i] = z * length;
    }
}

/* Finds the main axis of T by squaring. T^64 is the axis alone, unless the two largest eigenvalues are within a few per
 * cent of each other and no axis is meaningful. The column of the largest diagonal element is the longest. */
ISO_SIMD static void tensor_directions(const float *restrict state, const float *restrict tensor, size_t stride,
                                       size_t n, float *restrict dx, float *restrict dy, float *restrict dz)
{
    for (size_t i = 0; i < n; ++i) {
        const float *s = state + i, *t = tensor + i;
        float trace = t[0] + t[stride] + t[2 * stride];
        float inverse = 1 / trace;
        inverse = trace >= FLT_MIN ? inverse : 0;
        float nx = s[0] * inverse, ny = s[stride] * inverse, nz = s[2 * stride] * inverse;
        float a = t[0] * inverse, b = t[stride] * inverse, c = t[2 * stride] * inverse;
        float d = t[3 * stride] * inverse, e = t[4 * stride] * inverse, f = t[5 * stride] * inverse;
        for (int step = 0; step < 6; ++step) { /* rows (a d e) (d b f) (e f c) */
            float a2 = a * a + d * d + e * e, b2 = d * d + b * b + f * f, c2 = e * e + f * f + c * c;
            float d2 = a * d + d * b + e * f, e2 = a * e + d * f + e * c, f2 = d * e + b * f + f * c;
            float sum = a2 + b2 + c2, scale = 1 / sum;
            scale = sum >= FLT_MIN ? scale : 0;
            a = a2 * scale, b = b2 * scale, c = c2 * scale;
            d = d2 * scale, e = e2 * scale, f = f2 * scale;
        }
        float x = a, y = d, z = e, most = a;
        x = b > most ? d : x, y = b > most ? b : y, z = b > most ? f : z, most = b > most ? b : most;
        x = c > most ? e : x, y = c > most ? f : y, z = c > most ? c : z;
        float length = sqrtf(x * x + y * y + z * z), unit = 1 / length;
        unit = length >= FLT_MIN ? unit : 0;
        float coherence = sqrtf(nx * nx + ny * ny + nz * nz);
        float factor = x * nx + y * ny + z * nz < 0 ? -coherence * unit : coherence * unit;
        dx[i] = x * factor;
        dy[i] = y * factor;
        dz[i] = z * factor;
    }
}

void iso_direction_rows(iso_direction_filter f, const iso_state_row *row, size_t n, float *const d[3],
                        float *restrict magnitude)
{
    const float *state = row->components, *tensor = state + tensor_row(row->of) * row->stride;
    const size_t stride = row->stride;
    const float *ss = f == ISO_DIRECTION_TENSOR ? tensor : state + 3 * stride;
    if (f == ISO_DIRECTION_MOMENTS)
        moment_directions(state, stride, n, d[0], d[1], d[2]);
    else if (f == ISO_DIRECTION_TENSOR)
        tensor_directions(state, tensor, stride, n, d[0], d[1], d[2]);
    else
        unit_rows(state, state + stride, state + 2 * stride, n, d[0], d[1], d[2], magnitude);
    if (!magnitude || f == ISO_DIRECTION_NAIVE)
        return;
    for (size_t i = 0; i < n; ++i)
        magnitude[i] = f == ISO_DIRECTION_MOMENTS  ? sqrtf(ss[i])
                       : f == ISO_DIRECTION_TENSOR ? sqrtf(ss[i] + ss[i + stride] + ss[i + 2 * stride])
                                                   : ss[i + stride];
}

ISO_SIMD void iso_interleave_rows(const float *dx, const float *dy, const float *dz, size_t n, float *restrict out)
{
    for (size_t i = 0; i < n; ++i) {
        out[3 * i] = dx[i];
        out[3 * i + 1] = dy[i];
        out[3 * i + 2] = dz[i];
    }
}

void iso_unpack_bytes(const uint32_t *packed, size_t n, uint8_t *restrict bytes)
{
    size_t i = 0;
#ifdef __SSSE3__
    const __m128i low_three = _mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1);
    for (; i + 4 <= n; i += 4) /* 16 bytes are stored, the next 12 overwrite the last 4 */
        _mm_storeu_si128((__m128i *)(void *)(bytes + 3 * i),
                         _mm_shuffle_epi8(_mm_loadu_si128((const __m128i *)(const void *)(packed + i)), low_three));
#endif
    for (; i < n; ++i) {
        bytes[3 * i] = (uint8_t)packed[i];
        bytes[3 * i + 1] = (uint8_t)(packed[i] >> 8);
        bytes[3 * i + 2] = (uint8_t)(packed[i] >> 16);
    }
}
