/* SPDX-License-Identifier: MIT */
#include "plan/patch_loss.h"

#include <math.h>

enum { TILE = ISO_ADJOINT_TILE };

/* Returns the loss of a float of a picture; *slope gets its derivative. */
static float loss_of(float drawn, uint16_t truth, bool is_alpha, float *slope)
{
    const float x = drawn > 0 ? drawn < 1 ? drawn : 1 : 0;
    const float root = is_alpha ? 0 : powf(x > 0.0031308f ? x : 0.0031308f, 1 / 2.4f);
    const float shown = is_alpha ? x : x <= 0.0031308f ? 12.92f * x : 1.055f * root - 0.055f;
    const float rate = is_alpha ? 1 : x <= 0.0031308f ? 12.92f : 1.055f / 2.4f * root / x;
    const float d = shown - (float)truth / 65535, length = sqrtf(d * d + 1e-4f);
    *slope = drawn >= 1 ? d > 0 ? rate * d / length : 0 : rate * d / length;
    return length - 0.01f;
}

/* Adds the derivatives of the loss in small to the slopes. Returns the sum of the losses of the boxes' pixels. */
static double loss_in_small(const iso_patch_truth *t, const float *rgba, float *slopes)
{
    const size_t n = t->box, across = TILE / n, pixels = n * n;
    double loss = 0;
    for (size_t i = 0; i < 4 * across * across; ++i) {
        const size_t x = i / 4 % across * n, y = i / 4 / across * n, k = i % 4;
        const size_t truth = (t->y + y) / n * t->small_side + (t->x + x) / n;
        float sum = 0, slope;
        if (t->x + x + n > t->side || t->y + y + n > t->side)
            continue;
        for (size_t j = 0; j < pixels; ++j)
            sum += rgba[4 * ((y + j / n) * TILE + x + j % n) + k];
        loss += (double)pixels * (double)loss_of(sum / (float)pixels, t->small[4 * truth + k], k == 3, &slope);
        for (size_t j = 0; j < pixels; ++j)
            slopes[4 * ((y + j / n) * TILE + x + j % n) + k] += ISO_SMALL_WEIGHT * slope;
    }
    return (double)ISO_SMALL_WEIGHT * loss;
}

double iso_patch_loss(const iso_patch_truth *t, const float *rgba, float *slopes)
{
    double loss = 0;
    for (size_t i = 0; i < 4 * ISO_ADJOINT_PIXELS; ++i) {
        const size_t x = t->x + i / 4 % TILE, y = t->y + i / 4 / TILE;
        slopes[i] = 0;
        if (x < t->side && y < t->side)
            loss += (double)loss_of(rgba[i], t->rgba[4 * (y * t->side + x) + i % 4], i % 4 == 3, &slopes[i]);
    }
    return loss + loss_in_small(t, rgba, slopes);
}
