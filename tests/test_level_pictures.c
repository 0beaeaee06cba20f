/* SPDX-License-Identifier: MIT */
/* Wrong levels are seen in pictures alone: what is stored is not looked at here, although it would tell as well. */
#include <string.h>

#include "scene/views.h"
#include "tests/validated.h"

enum { pixels = 48, levels = 3 };
static const subject_size size = {pixels, levels, ISO_DIAGONAL_VIEWS};
static const size_t volume_size[3] = {26, 24, 21}, tubes_size[3] = {34, 30, 27}; /* level 2 of fewer has no tubes */

static iso_scene make_scene(void)
{
    static iso_tf_point points[] = {{0, {0.9, 0.7, 0.4}, 0},
                                    {0.3, {0.9, 0.7, 0.4}, 0},
                                    {0.45, {1, 0.9, 0.6}, 0.6},
                                    {1, {0.9, 0.8, 0.7}, 0.6}};
    return scene_of_points(points, 4, pixels, 0.2);
}

static iso_field field_of(iso_field_kind kind)
{
    return (iso_field){.kind = kind,
                       .seed = 3,
                       .geometry = iso_geometry_axis_aligned(kind == ISO_FIELD_TUBES ? tubes_size : volume_size,
                                                             (double[]){1, 1.2, 0.9})};
}

/* ---- faults ---- */

static void of_another_volume(iso_pyramid *p, size_t level)
{
    const iso_field other = {.kind = ISO_FIELD_SHELLS, .seed = 3, .geometry = p->levels[0].geometry};
    iso_pyramid_options opt = iso_pyramid_defaults();
    opt.level_count = levels;
    OWNED(iso_pyramid) q = sampled_pyramid(&other, ISO_F32, &opt);
    const size_t count = iso_geometry_voxel_count(&p->levels[level].geometry);
    memcpy(p->levels[level].scalar, q.levels[level].scalar, count * sizeof(float));
    memcpy(p->levels[level].codes, q.levels[level].codes, 3 * count);
}

/* The codes of the level above or below at the same indices, as a copy of the wrong file's bytes would have them. */
static void directions_of_a_neighbor(iso_pyramid *p, size_t level)
{
    iso_level *l = &p->levels[level];
    const iso_level *from = &p->levels[level + 1 < levels ? level + 1 : level - 1];
    const size_t count = 3 * iso_geometry_voxel_count(&l->geometry),
                 there = 3 * iso_geometry_voxel_count(&from->geometry);
    for (size_t i = 0; i < count; ++i)
        l->codes[i] = from->codes[i % there];
}

static void mirrored(iso_pyramid *p, size_t level)
{
    iso_level *l = &p->levels[level];
    const size_t *n = l->geometry.size;
    for (size_t row = 0; row < n[1] * n[2]; ++row)
        for (size_t x = 0; x < n[0] / 2; ++x) {
            const size_t a = row * n[0] + x, b = row * n[0] + n[0] - 1 - x;
            const float value = l->scalar[a];
            uint8_t code[3];
            l->scalar[a] = l->scalar[b], l->scalar[b] = value;
            memcpy(code, l->codes + 3 * a, 3);
            memcpy(l->codes + 3 * a, l->codes + 3 * b, 3);
            memcpy(l->codes + 3 * b, code, 3);
        }
}

/* x and y of the directions. */
static void exchanged(iso_pyramid *p, size_t level)
{
    iso_level *l = &p->levels[level];
    for (size_t i = 0; i < iso_geometry_voxel_count(&l->geometry); ++i) {
        const uint8_t x = l->codes[3 * i];
        l->codes[3 * i] = l->codes[3 * i + 1];
        l->codes[3 * i + 1] = x;
    }
}

/* ---- pictures, and the comparison with levels that are built again ---- */

typedef void fault(iso_pyramid *p, size_t level);

/* Which checks of levels 1 and 2 hold: pictures against the simple way's, and what is stored. NULL plants nothing. */
typedef struct held {
    bool pictures[levels], stored[levels], nearer[levels]; /* nearer: smaller angles than gradients on the fly */
} held;

static held held_with(iso_field_kind kind, fault *in_level_1, fault *in_level_2)
{
    static int number;
    held h = {0};
    ENDED_BY(close_subject) subject s;
    char name[32];
    const iso_field field = field_of(kind);
    snprintf(name, sizeof name, "pictures-%d", number++);
    open_field(&s, &field, make_scene(), name, size);
    if (in_level_1)
        in_level_1(&s.pyramid, 1);
    if (in_level_2)
        in_level_2(&s.pyramid, 2);
    measure_levels(&s);
    const json_t *rows = json_object_get(iso_report_json(s.validation.report), "levels");
    for (size_t k = 1; k < levels; ++k) {
        const json_t *row = json_array_get(rows, k - 1);
        h.pictures[k] = json_is_true(json_object_get(row, "simple_held"));
        h.nearer[k] = iso_row_number(json_object_get(row, "directions"), "difference_deg") < -5;
        h.stored[k] = json_is_true(json_object_get(json_object_get(row, "stored"), "held"));
    }
    return h;
}

TEST(right_levels_are_held)
{
    const held clean = held_with(ISO_FIELD_BALLS, NULL, NULL);
    assert_true(clean.pictures[1] && clean.pictures[2]);
}

VALUES_TEST(gross_faults_are_seen_in_pictures)
{
    assert_false(held_with(ISO_FIELD_BALLS, of_another_volume, NULL).pictures[1]);
    assert_false(held_with(ISO_FIELD_BALLS, directions_of_a_neighbor, NULL).pictures[1]);
    const held both = held_with(ISO_FIELD_BALLS, mirrored, exchanged);
    assert_false(both.pictures[1]);
    assert_false(both.pictures[2]);
}

/* In tubes as thin as a voxel the adapted TF alone brings a level so much nearer to level 0 that wrong directions do
 * not put it behind gradients on the fly under the original TF; another volume does. The comparison with levels that
 * are built again finds the directions. */
VALUES_TEST(wrong_directions_of_thin_tubes_are_not_those_of_level_0)
{
    const held clean = held_with(ISO_FIELD_TUBES, NULL, NULL);
    assert_true(clean.pictures[1] && clean.pictures[2] && clean.stored[1] && clean.stored[2] && clean.nearer[2]);
    assert_false(held_with(ISO_FIELD_TUBES, mirrored, of_another_volume).pictures[2]);
    const held both = held_with(ISO_FIELD_TUBES, exchanged, directions_of_a_neighbor);
    assert_false(both.stored[1] || both.stored[2]);
}

TEST_MAIN(make_folder, end_renderers_and_folder)
