/* SPDX-License-Identifier: MIT */
#include "lab/codes/paper_table.h"

#include <math.h>
#include <stdlib.h>

#include "encode/decode_double.h"
#include "lab/codes/region48.h"

iso_status iso_paper_table_create(size_t size, iso_paper_table *table, iso_error *err)
{
    *table = (iso_paper_table){0};
    if (size < 2 || size > 1024)
        return iso_fail(err, ISO_E_RANGE, "table of T: size %zu, must be 2 to 1024", size);
    table->entries = calloc(size * size, sizeof *table->entries);
    NEED_MEMORY(table->entries, err, "table of T: no memory for %zu entries", size * size);
    table->size = size;
    const double step = 1 / (double)(size - 1);
    for (size_t i = 0; i < size; ++i)
        for (size_t j = 0; i + j < size; ++j) {
            double u = (double)i * step, v = (double)j * step;
            iso_vec3 t = iso_region48_transform(iso_v3(u, v, fmax(1 - u - v, 0)));
            double *entry = table->entries[i * size + j];
            entry[0] = t.x, entry[1] = t.y, entry[2] = t.z;
        }
    return ISO_OK;
}

void iso_paper_table_destroy(iso_paper_table *table)
{
    if (table)
        free(table->entries);
}

/* Interpolates between the three entries around (u, v); each cell consists of two triangles. */
static iso_vec3 look_up(const iso_paper_table *table, double u, double v)
{
    const size_t last = table->size - 1;
    double x = u * (double)last, y = v * (double)last;
    size_t i = (size_t)fmin(x, (double)last), j = (size_t)fmin(y, (double)(last - i));
    x -= (double)i, y -= (double)j;
    double weights[3];
    const double *corners[3];
    double(*row)[3] = table->entries + i * table->size + j, (*next)[3] = row + table->size;
    if (i + j == last) { /* a point on the plane's edge */
        return iso_v3(row[0][0], row[0][1], row[0][2]);
    } else if (x + y <= 1 || i + j + 1 == last) {
        corners[0] = row[0], corners[1] = next[0], corners[2] = row[1];
        weights[0] = 1 - x - y, weights[1] = x, weights[2] = y;
    } else {
        corners[0] = next[1], corners[1] = row[1], corners[2] = next[0];
        weights[0] = x + y - 1, weights[1] = 1 - x, weights[2] = 1 - y;
    }
    double t[3] = {0, 0, 0};
    for (int c = 0; c < 3; ++c)
        for (int a = 0; a < 3; ++a)
            t[a] += weights[c] * corners[c][a];
    return iso_v3(t[0], t[1], t[2]);
}

static void encode_one(const iso_paper_table *table, const float *direction, uint8_t *bytes)
{
    double v[3] = {direction[0], direction[1], direction[2]};
    int order[3];
    iso_rank(v, order);
    iso_vec3 d = iso_normalize(iso_v3(fabs(v[order[0]]), fabs(v[order[1]]), fabs(v[order[2]])));
    if (!(d.x > 0)) {
        bytes[0] = bytes[1] = bytes[2] = 128;
        return;
    }
    iso_vec3 t = look_up(table, (d.x - d.y) / d.x, (d.y - d.z) / d.x);
    iso_vec3 best = {255, 1, 1};
    double best_distance = INFINITY;
    for (double a = 255; a > 0; a -= 2) {
        iso_vec3 e = {a, fmin(iso_nearest_odd(a * (t.y + t.z)), a), 0};
        e.z = fmax(fmin(iso_nearest_odd(a * t.z), e.y), 1);
        iso_vec3 off = iso_sub(iso_normalize(iso_decode_region48(iso_scale(e, 255 / a))), d);
        double distance = iso_dot(off, off);
        if (distance < best_distance * (1 - 1e-9)) { /* equal directions: the first one, which is the longest */
            best_distance = distance;
            best = e;
        }
    }
    iso_region48_bytes(v, order, best, bytes);
}

void iso_paper_encode(const iso_paper_table *table, const float *restrict directions, uint8_t *restrict bytes,
                      size_t count)
{
    for (size_t i = 0; i < count; ++i)
        encode_one(table, directions + 3 * i, bytes + 3 * i);
}
