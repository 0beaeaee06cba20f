/* SPDX-License-Identifier: MIT */
#include "lab/rivals/rivals.h"

void iso_rival_destroy(iso_rival *r)
{
    if (r->release)
        r->release(r->field);
    *r = (iso_rival){0};
}

iso_fine_box iso_fine_box_of(const iso_pyramid *p, size_t level, size_t voxel)
{
    const size_t *fine = p->levels[0].geometry.size, *n = p->levels[level].geometry.size;
    const size_t at[3] = {voxel % n[0], voxel / n[0] % n[1], voxel / (n[0] * n[1])};
    iso_fine_box b;
    for (int a = 0; a < 3; ++a) {
        b.lo[a] = at[a] << level;
        b.hi[a] = (at[a] + 1) << level;
        b.hi[a] = b.hi[a] < fine[a] ? b.hi[a] : fine[a];
    }
    return b;
}
