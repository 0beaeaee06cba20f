#include "pyramid/filter_kernel.h"

#include <float.h>
#include <math.h>

iso_taps iso_taps_mean(void)
{
    return (iso_taps){.count = 2, .weight = {0.5f, 0.5f}};
}

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

void iso_state_from_gradients(iso_direction_filter f, const float *restrict g, size_t count, float *restrict state)
{
    for (size_t i = 0; i < count; ++i) {
        const float *v = g + 3 * i;
        float m2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], m = sqrtf(m2);
        float weight = f == ISO_DIRECTION_NAIVE ? 1 : m;
        state[4 * i] = weight * v[0];
        state[4 * i + 1] = weight * v[1];
        state[4 * i + 2] = weight * v[2];
        state[4 * i + 3] = f == ISO_DIRECTION_MOMENTS ? m2 : f == ISO_DIRECTION_EQ1 ? m : 0;
    }
}

/* gradients-2017 Eq. 1: the sums of G m g and of m g have been taken; their
 * quotient is the filtered gradient, whose own length weighs the next level. */
void iso_state_finish(iso_direction_filter f, float *state, size_t count)
{
    if (f != ISO_DIRECTION_EQ1)
        return;
    for (float *s = state; s < state + 4 * count; s += 4) {
        float inverse = s[3] >= FLT_MIN ? 1 / s[3] : 0;
        float x = s[0] * inverse, y = s[1] * inverse, z = s[2] * inverse;
        float m = sqrtf(x * x + y * y + z * z);
        s[0] = m * x;
        s[1] = m * y;
        s[2] = m * z;
        s[3] = m;
    }
}

/* Quotients are taken before squares, so that small gradients do not underflow. */
void iso_state_directions(iso_direction_filter f, bool fine, const float *restrict state, size_t count,
                          float *restrict directions, float *restrict magnitude)
{
    for (size_t i = 0; i < count; ++i) {
        const float *s = state + 4 * i;
        float *d = directions + 3 * i;
        float x = s[0], y = s[1], z = s[2];
        float length = sqrtf(x * x + y * y + z * z);
        if (magnitude)
            magnitude[i] = f == ISO_DIRECTION_MOMENTS ? sqrtf(s[3]) : f == ISO_DIRECTION_EQ1 ? s[3] : length;
        float factor;
        if (f == ISO_DIRECTION_MOMENTS && !fine) {
            float inverse = s[3] >= FLT_MIN ? 1 / s[3] : 0;
            x *= inverse;
            y *= inverse;
            z *= inverse;
            factor = sqrtf(x * x + y * y + z * z); /* (N/|N|) L^2 = (N/S) L */
        } else {
            factor = length >= FLT_MIN ? 1 / length : 0;
        }
        d[0] = x * factor;
        d[1] = y * factor;
        d[2] = z * factor;
    }
}
