#include "gradient/gradient_kernel.h"

void iso_gradient_row_central(const iso_gradient_rows *rows, size_t n, const float m[9], float *restrict gx,
                              float *restrict gy, float *restrict gz)
{
    const float *here = rows->here, *y0 = rows->y0, *y1 = rows->y1, *z0 = rows->z0, *z1 = rows->z1;
    const float fy = rows->y_factor, fz = rows->z_factor;
    gx[0] = n > 1 ? here[1] - here[0] : 0;
    for (size_t x = 1; x + 1 < n; ++x)
        gx[x] = 0.5f * (here[x + 1] - here[x - 1]);
    if (n > 1)
        gx[n - 1] = here[n - 1] - here[n - 2];
    for (size_t x = 0; x < n; ++x) {
        float dx = gx[x], dy = fy * (y1[x] - y0[x]), dz = fz * (z1[x] - z0[x]);
        gx[x] = m[0] * dx + m[1] * dy + m[2] * dz;
        gy[x] = m[3] * dx + m[4] * dy + m[5] * dz;
        gz[x] = m[6] * dx + m[7] * dy + m[8] * dz;
    }
}
