#include "cli/faults.h"

#include <math.h>

static const struct {
    const char *name, *check;
} faults[] = {
    [ISO_FAULT_NONE] = {"nothing", NULL},
#define ISO_FAULT_ROW(value, text, check) [value] = {text, check},
    ISO_FAULT_LIST(ISO_FAULT_ROW)
#undef ISO_FAULT_ROW
};

const char *iso_fault_name(iso_fault fault) { return faults[fault].name; }
const char *iso_fault_check(iso_fault fault) { return faults[fault].check; }

static void swap_xy(iso_level *level)
{
    for (size_t i = 0; i < iso_geometry_voxel_count(&level->geometry); ++i) {
        uint8_t *c = level->codes + 3 * i, t = c[0];
        c[0] = c[1];
        c[1] = t;
    }
}

static void reverse_scalar(iso_level *level)
{
    for (size_t i = 0, j = iso_geometry_voxel_count(&level->geometry) - 1; i < j; ++i, --j) {
        float t = level->scalar[i];
        level->scalar[i] = level->scalar[j];
        level->scalar[j] = t;
    }
}

/* Takes every direction back to the index and out again by the wrong matrix. */
static void send_by_the_matrix(iso_level *level, iso_code code)
{
    const iso_mat3 m = level->geometry.index_to_world;
    for (size_t i = 0; i < iso_geometry_voxel_count(&level->geometry); ++i) {
        float d[3];
        iso_code_decode_all(code, level->codes + 3 * i, d, 1);
        iso_vec3 index = iso_mul(iso_mat3_transpose(m), iso_v3((double)d[0], (double)d[1], (double)d[2]));
        iso_vec3 wrong = iso_normalize(iso_mul(m, index));
        const float out[3] = {(float)wrong.x, (float)wrong.y, (float)wrong.z};
        iso_code_encode(code, out, level->codes + 3 * i, 1);
    }
}

void iso_fault_plant(iso_fault fault, iso_pyramid *p, size_t k, iso_view *view)
{
    iso_level *level = &p->levels[k];
    iso_geometry *g = &level->geometry;
    iso_tf_table *tf = &view->tf;
    float *e = tf->entries;
    switch (fault) {
    case ISO_FAULT_HALF_VOXEL: g->origin_mm = iso_geometry_to_world(g, iso_v3(0.5, 0.5, 0.5)); break;
    case ISO_FAULT_MIRRORED:
        for (int r = 0; r < 3; ++r)
            g->index_to_world.m[r][0] = -g->index_to_world.m[r][0];
        break;
    case ISO_FAULT_STALE: reverse_scalar(level); break;
    case ISO_FAULT_UNIT:
        for (size_t i = 3; i < tf->count * 4; i += 4)
            e[i] *= 1.1f;
        break;
    case ISO_FAULT_SRGB:
        for (size_t i = 0; i < tf->count * 4; ++i)
            e[i] = i % 4 == 3 ? e[i] : powf(e[i], 2.2f);
        break;
    case ISO_FAULT_RANGE: tf->hi += (tf->hi - tf->lo) / (double)(tf->count - 1); break;
    case ISO_FAULT_AXIS_SWAP: swap_xy(level); break;
    case ISO_FAULT_NOT_INVERSE_TRANSPOSE: send_by_the_matrix(level, p->options.code); break;
    case ISO_FAULT_LIGHT: view->lights[0].direction.x = -view->lights[0].direction.x; break;
    case ISO_FAULT_ONE_SIDED: view->shading.diffuse = view->shading.specular = 0; break; /* the gradient looks away */
    default: break;
    }
}

void iso_fault_spoil(iso_fault fault, iso_image *image)
{
    for (size_t i = 0; i < image->width * image->height; ++i) {
        float *p = image->rgba + 4 * i;
        for (int c = 0; c < 3; ++c)
            p[c] = fault == ISO_FAULT_PREMULTIPLIED ? p[c] * p[3] : fault == ISO_FAULT_CLIPPED ? fminf(p[c], 1) : p[c];
    }
}
