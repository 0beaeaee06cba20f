/* SPDX-License-Identifier: MIT */
/* adapt_level.c - the table for a level: the adapted one, or the original if that gives better pictures. */
#include "tf/adapt.h"

#include <math.h>
#include <stdlib.h>

#include "tf/ghost.h"
#include "tf/level_look.h"

/* Premultiplied color and opacity over a length, and the square of their norm. */
typedef struct seen {
    double rgba[4], square;
} seen;

static seen see(const iso_tf_table *tf, double value, double length_mm)
{
    seen p;
    iso_tf_lookup(tf, value, p.rgba);
    p.rgba[3] = -expm1(-p.rgba[3] * length_mm);
    for (int c = 0; c < 3; ++c)
        p.rgba[c] *= p.rgba[3];
    p.square = p.rgba[0] * p.rgba[0] + p.rgba[1] * p.rgba[1] + p.rgba[2] * p.rgba[2] + p.rgba[3] * p.rgba[3];
    return p;
}

/* Returns sum count |z - s|^2 from the row's moments: sum of the squares - 2 s sum + count s^2. */
static double row_error(const seen *sums, double count, const seen *s)
{
    double product = 0;
    for (int c = 0; c < 4; ++c)
        product += sums->rgba[c] * s->rgba[c];
    return fmax(sums->square - 2 * product + count * s->square, 0);
}

iso_status iso_adapt_judge(const iso_joint *j, const iso_tf_table *tf, const iso_tf_table *adapted,
                           const iso_geometry *level0, iso_adapt_judgment *judgment, iso_error *err)
{
    const double length_mm = iso_geometry_mean_spacing_mm(level0), n = j->voxel_count > 0 ? (double)j->voxel_count : 1;
    double original_sum = 0, adapted_sum = 0;
    seen *at_z = malloc(j->z.count * sizeof *at_z);
    NEED_MEMORY(at_z, err, "adapt: no memory for %zu bins", j->z.count);
    for (size_t i = 0; i < j->z.count; ++i)
        at_z[i] = see(tf, j->z.lo + (double)i * j->z.step, length_mm);
    for (size_t row = 0; row < j->s.count; ++row) {
        const double s = j->s.lo + (double)row * j->s.step;
        seen sums = {{0}, 0};
        double row_count = 0;
        for (size_t i = j->row_start[row]; i < j->row_start[row + 1]; ++i) {
            const seen *z = &at_z[j->entry_z[i]];
            const double count = (double)j->entry_count_of[i];
            row_count += count;
            for (int c = 0; c < 4; ++c)
                sums.rgba[c] += count * z->rgba[c];
            sums.square += count * z->square;
        }
        if (row_count == 0)
            continue;
        const seen original = see(tf, s, length_mm), other = see(adapted, s, length_mm);
        original_sum += row_error(&sums, row_count, &original);
        adapted_sum += row_error(&sums, row_count, &other);
    }
    free(at_z);
    *judgment = (iso_adapt_judgment){.rms_original = sqrt(original_sum / n), .rms_adapted = sqrt(adapted_sum / n)};
    judgment->use_original = !(judgment->rms_adapted < judgment->rms_original);
    return ISO_OK;
}

bool iso_adapt_is_nearer(const iso_small_views_error *original, const iso_small_views_error *adapted)
{
    const double n = ISO_SMALL_VIEWS_COUNT, mean = adapted->ssim_dissimilarity - original->ssim_dissimilarity;
    double squares = 0, worst = -INFINITY;
    for (int i = 0; i < ISO_SMALL_VIEWS_COUNT; ++i) {
        const double d = adapted->of_view[i] - original->of_view[i];
        squares += (d - mean) * (d - mean);
        worst = fmax(worst, d);
    }
    const bool nearer = mean + 2 * sqrt(squares / (n * (n - 1))) < 0 && adapted->rmse <= original->rmse;
    const bool much_nearer_by_rmse = mean <= ISO_ADAPT_SSIM_LOSS &&
                                     adapted->rmse < ISO_ADAPT_RMSE_GAIN * original->rmse;
    return (nearer || much_nearer_by_rmse) && worst <= ISO_ADAPT_WORST_VIEW;
}

/* Sets up views of the level through both tables. empty: mask of ghost.h, or NULL. */
static iso_small_views_input views_of(const iso_pyramid *p, size_t level, const iso_tf_table *tf,
                                      const iso_tf_table *adapted, const uint8_t *empty, iso_small_views_fine *level_0,
                                      int threads)
{
    return (iso_small_views_input){.fine = &p->levels[0],
                                   .coarse = &p->levels[level],
                                   .level = level,
                                   .original = tf,
                                   .tfs = {tf, adapted},
                                   .tf_count = 2,
                                   .empty = empty,
                                   .kept = level_0,
                                   .threads = threads};
}

/* Lets small views decide, if there are samples to draw; first frees an adapted TF of its ghost. */
static iso_status look(const iso_pyramid *p, size_t level, const iso_tf_table *tf, iso_tf_table *adapted,
                       const iso_adapt_options *opt, iso_adapt_judgment *judgment, iso_error *err)
{
    iso_small_views_fine own = {0};
    iso_small_views_error errors[ISO_SMALL_VIEWS_MAX_TFS];
    uint8_t *empty = NULL;
    if (!p->levels[0].scalar || !p->levels[level].scalar ||
        iso_geometry_voxel_count(&p->levels[0].geometry) > ISO_SMALL_VIEWS_MAX_VOXELS)
        return ISO_OK;
    iso_status status = iso_ghost_mask(&p->levels[0], &p->levels[level], level, tf, opt->threads, &empty, err);
    const iso_small_views_input in = views_of(p, level, tf, adapted, empty, opt->level_0 ? opt->level_0 : &own,
                                              opt->threads);
    TRY(status, iso_small_views_compare(&in, errors, err));
    judgment->ghost = status == ISO_OK ? errors[1].ghost : 0;
    if (judgment->ghost > ISO_GHOST_LIMIT)
        status = iso_ghost_remove(&in, adapted, &judgment->given_back, err);
    if (status == ISO_OK && judgment->given_back > 0)
        status = iso_small_views_compare(&in, errors, err);
    free(empty);
    iso_small_views_fine_destroy(&own);
    if (status != ISO_OK)
        return status;
    judgment->seen = true;
    judgment->seen_original = errors[0];
    judgment->seen_adapted = errors[1];
    judgment->use_original = !iso_adapt_is_nearer(&errors[0], &errors[1]) || errors[1].ghost > ISO_GHOST_LIMIT;
    return ISO_OK;
}

iso_status iso_adapt_level(const iso_pyramid *p, size_t level, const iso_tf_table *tf, const iso_adapt_options *opt,
                           iso_tf_table *table, iso_adapt_judgment *judgment, iso_error *err)
{
    const iso_geometry *level0 = &p->levels[0].geometry;
    OWNED(iso_joint) joint = {0};
    iso_adapter *adapter = NULL;
    iso_adapt_judgment verdict = {.use_original = true};
    *table = (iso_tf_table){0};
    bool is_made_for = false;
    const bool falls_back = opt->fall_back && !p->levels[level].edits_are_scaled;
    iso_status status = iso_level_look(p, level, tf, table, &is_made_for, err);
    if (status != ISO_OK || is_made_for || level == 0) {
        verdict.use_original = !is_made_for || (iso_tf_table_equals(table, tf) && !p->levels[level].scale);
        if (judgment)
            *judgment = verdict;
        return status != ISO_OK || is_made_for ? status : iso_tf_table_copy(tf, table, err);
    }
    status = iso_joint_obtain(p, opt->folder, &(iso_joint_key){level, opt->bits, ISO_SECOND_VALUE_NONE}, opt->threads,
                              &joint, err);
    TRY(status, iso_adapter_create(&joint, opt, &adapter, err));
    TRY(status, iso_adapter_apply(adapter, tf, level0, level, table, err));
    TRY(status, iso_adapt_judge(&joint, tf, table, level0, &verdict, err));
    if (status == ISO_OK && falls_back)
        status = look(p, level, tf, table, opt, &verdict, err);
    verdict.use_original = verdict.use_original && falls_back;
    if (status == ISO_OK && verdict.use_original) {
        iso_tf_table_destroy(table);
        status = iso_tf_table_copy(tf, table, err);
    }
    if (status == ISO_OK && level0->has_no_data)
        status = iso_tf_table_end_below(table, p->levels[0].min, err);
    if (judgment)
        *judgment = verdict;
    iso_adapter_destroy(adapter);
    return status;
}

iso_status iso_tf_from_table(const iso_tf_table *table, iso_tf *tf, iso_error *err)
{
    float largest = 0;
    for (size_t i = 0; i < table->count; ++i)
        largest = fmaxf(largest, table->entries[4 * i + 3]);
    if (!(largest <= ISO_TF_MOST_EXTINCTION)) {
        *tf = (iso_tf){0};
        return iso_fail(err, ISO_E_RANGE, "an extinction of %g per mm exceeds the limit of transfer functions, %g",
                        (double)largest, ISO_TF_MOST_EXTINCTION);
    }
    /* Opacities are for 1 mm; for another length if those for 1 mm would be close to the cap or to 0. */
    const bool fits_mm = largest == 0 || (largest >= 1e-3f && largest <= 4);
    const double unit_mm = fits_mm ? 1 : fmin(fmax(4 / (double)largest, ISO_TF_LEAST_UNIT), ISO_TF_MOST_UNIT);
    *tf = (iso_tf){.point_count = table->count,
                   .range = {table->lo, table->hi},
                   .unit_distance = unit_mm,
                   .table_size = table->count};
    tf->points = malloc(table->count * sizeof *tf->points);
    if (!tf->points) {
        *tf = (iso_tf){0};
        return iso_fail(err, ISO_E_MEMORY, "no memory for %zu points", table->count);
    }
    for (size_t i = 0; i < table->count; ++i) {
        const float *e = table->entries + 4 * i;
        iso_tf_point *point = &tf->points[i];
        point->value = table->lo + (double)i / (double)(table->count - 1) * (table->hi - table->lo);
        for (int c = 0; c < 3; ++c)
            point->rgb_linear[c] = e[c];
        point->opacity = -expm1(-(double)e[3] * unit_mm);
    }
    return ISO_OK;
}
