/* SPDX-License-Identifier: MIT */
#include "plan/planned.h"

#include <stdlib.h>
#include <string.h>

#include "base/inputs.h"
#include "base/json.h"
#include "base/parallel.h"
#include "brick/occupancy.h"
#include "brick/pack.h"

/* ---- the file ------------------------------------------------------------------ */

static iso_status read_bricks(const char *path, const char *levels, const char *use, iso_plan_file *plan,
                              iso_error *err)
{
    size_t count = plan->count[0] * plan->count[1] * plan->count[2];
    if (strlen(levels) != count || strlen(use) != count)
        return iso_fail(err, ISO_E_FORMAT, "%s: %zu levels and %zu uses of bricks, there are %zu x %zu x %zu", path,
                        strlen(levels), strlen(use), plan->count[0], plan->count[1], plan->count[2]);
    plan->levels = malloc(count);
    plan->drawn = malloc(count);
    plan->seen = malloc(count);
    NEED_MEMORY(plan->levels && plan->drawn && plan->seen, err, "%s: no memory for %zu bricks", path, count);
    for (size_t i = 0; i < count; ++i) {
        size_t level = (size_t)(levels[i] - '0');
        if (level >= plan->level_count || !strchr("dhu", use[i]))
            return iso_fail(err, ISO_E_FORMAT,
                            "%s: level '%c' and use '%c' of brick %zu, must be 0 to %zu and d, h or u", path, levels[i],
                            use[i], i, plan->level_count - 1);
        plan->levels[i] = (uint8_t)level;
        plan->drawn[i] = use[i] == 'd';
        plan->seen[i] = use[i] != 'u';
    }
    return ISO_OK;
}

json_t *iso_plan_file_bricks(const uint8_t *levels, const uint8_t *drawn, const uint8_t *seen, size_t count)
{
    FREED char *digits = malloc(count + 1), *use = malloc(count + 1);
    for (size_t i = 0; digits && use && i < count; ++i) {
        digits[i] = (char)('0' + levels[i]);
        use[i] = drawn[i] ? 'd' : seen[i] ? 'h' : 'u';
    }
    json_t *both = digits && use ? json_pack("{s:s%, s:s%}", "levels", digits, count, "use", use, count) : NULL;
    return both;
}

iso_status iso_plan_file_load(const char *path, iso_plan_file *plan, iso_error *err)
{
    json_auto_t *root = NULL;
    *plan = (iso_plan_file){0};
    NEED(iso_inputs_note(path, err));
    NEED(iso_json_load(path, &root, err));
    return iso_plan_file_from_json(root, path, plan, err);
}

iso_status iso_plan_file_from_json(const json_t *root, const char *path, iso_plan_file *plan, iso_error *err)
{
    const char *levels, *use;
    double count[3] = {0};
    *plan = (iso_plan_file){0};
    iso_json_reader r = {.path = path, .err = err};
    static const char *const schemas[] = {"isoshade.plan/1", NULL};
    int schema;
    iso_json_get_word(&r, root, "schema", true, schemas, &schema);
    iso_json_get_numbers(&r, root, "bricks", true, &(iso_json_list){count, 3, 1, 65536});
    iso_json_get_size(&r, root, "brick_voxels", true, 2, 64, &plan->brick_voxels);
    iso_json_get_size(&r, root, "level_count", true, 1, ISO_BRICK_MAX_LEVELS, &plan->level_count);
    iso_json_get_string(&r, root, "levels", true, &levels);
    iso_json_get_string(&r, root, "use", true, &use);
    for (int a = 0; a < 3; ++a)
        plan->count[a] = (size_t)count[a];
    iso_status status = r.status == ISO_OK ? read_bricks(path, levels, use, plan, err) : r.status;
    if (status != ISO_OK)
        iso_plan_file_destroy(plan);
    return status;
}

void iso_plan_file_destroy(iso_plan_file *plan)
{
    if (!plan)
        return;
    free(plan->levels);
    free(plan->seen);
    free(plan->drawn);
    *plan = (iso_plan_file){0};
}

/* ---- the model ----------------------------------------------------------------- */

static iso_brick_field field_of(const iso_planned *p)
{
    return (iso_brick_field){.nodes = &p->nodes, .levels = p->plan.levels, .faces = ISO_FACES_BAKED};
}

/* True if the transfer function shows a brick that the plan hides. Voxel ranges decide most bricks without building
 * nodes. */
static bool is_wrong(const iso_planned *p, const iso_tf_table *tf, size_t i)
{
    const iso_brick_field field = field_of(p);
    const float *range = p->nodes.ranges[0][i].whole;
    const size_t *count = p->nodes.count, brick[3] = {i % count[0], i / count[0] % count[1], i / (count[0] * count[1])};
    if (!p->plan.seen[i] || p->plan.drawn[i] ||
        (p->plan.levels[i] == 0 && !iso_tf_shows(tf, (double)range[0], (double)range[1])))
        return false;
    const bool shows = iso_brick_make(&p->nodes, i, ISO_BRICK_SCALARS, NULL) == ISO_OK &&
                       iso_brick_shows(&field, tf, brick);
    iso_brick_forget(&p->nodes, i);
    return shows;
}

/* Checks the transfer functions: if the plan was made for others, these show bricks that it marks as hidden. Rounding
 * alone affects only a few. */
static iso_status check_match(const char *path, const iso_planned *p, int threads, iso_error *err)
{
    const size_t count = iso_brick_count(&p->nodes);
    size_t wrong = 0, drawn = 0;
    for (size_t t = 0; t < p->tf_count; ++t)
#pragma omp parallel for schedule(dynamic, 16) num_threads(iso_threads(threads)) reduction(+ : wrong)
        for (size_t i = 0; i < count; ++i)
            wrong += is_wrong(p, &p->tfs[t], i);
    for (size_t i = 0; i < count; ++i)
        drawn += p->plan.drawn[i];
    if (100 * wrong > drawn)
        return iso_fail(err, ISO_E_RANGE,
                        "%s: this scene shows %zu bricks that the plan hides: it was made for another one", path,
                        wrong);
    return drawn > 0 ? ISO_OK
                     : iso_fail(err, ISO_E_RANGE, "%s: the plan draws none of its %zu bricks: there is nothing to export",
                                path, count);
}

/* Checks the number of bricks for the volume's size, before the nodes are made. */
static iso_status check_bricks(const char *path, const iso_plan_file *plan, const iso_geometry *g, iso_error *err)
{
    size_t have[3];
    for (int a = 0; a < 3; ++a)
        have[a] = g->size[a] > 1 ? (g->size[a] - 2) / plan->brick_voxels + 1 : 1;
    if (memcmp(have, plan->count, sizeof have) != 0)
        return iso_fail(err, ISO_E_RANGE, "%s: %zu x %zu x %zu bricks of %zu voxels, the volume has %zu x %zu x %zu",
                        path, plan->count[0], plan->count[1], plan->count[2], plan->brick_voxels, have[0], have[1],
                        have[2]);
    return ISO_OK;
}

iso_status iso_planned_create(const char *path, const iso_planned_subject *subject, int threads, iso_planned *p,
                              iso_error *err)
{
    iso_plan_file plan;
    *p = (iso_planned){0};
    NEED(iso_plan_file_load(path, &plan, err));
    return iso_planned_create_of(&plan, path, subject, threads, p, err);
}

iso_status iso_planned_create_of(iso_plan_file *plan, const char *path, const iso_planned_subject *subject, int threads,
                                 iso_planned *p, iso_error *err)
{
    double start = iso_clock_seconds();
    *p = (iso_planned){.plan = *plan, .tfs = subject->tfs, .tf_count = subject->tf_count};
    *plan = (iso_plan_file){0};
    iso_status status = check_bricks(path, &p->plan, &subject->level0->geometry, err);
    TRY(status, iso_node_levels_create_for(&p->nodes, subject->level0, p->plan.brick_voxels, p->plan.level_count,
                                           p->plan.levels, &subject->code, threads, err));
    TRY(status, iso_node_levels_measure_ranges(&p->nodes, threads, err));
    TRY(status, check_match(path, p, threads, err));
    p->build_seconds = iso_clock_seconds() - start;
    if (status != ISO_OK)
        iso_planned_destroy(p);
    return status;
}

void iso_planned_destroy(iso_planned *p)
{
    if (!p)
        return;
    iso_plan_file_destroy(&p->plan);
    iso_node_levels_destroy(&p->nodes);
    *p = (iso_planned){0};
}

static bool draws_level(const iso_planned *p, size_t level)
{
    for (size_t i = 0; i < iso_brick_count(&p->nodes); ++i)
        if (p->plan.drawn[i] && p->plan.levels[i] == level)
            return true;
    return false;
}

iso_status iso_planned_lattices_create(const iso_planned *p, bool merged, bool whole_box, int threads,
                                       iso_planned_lattices *lattices, iso_error *err)
{
    const iso_brick_field field = field_of(p);
    iso_lattice_options opt = {.drawn = p->plan.drawn,
                               .seen = p->plan.seen,
                               .tfs = p->tfs,
                               .tf_count = p->tf_count,
                               .merged = merged,
                               .whole_box = whole_box,
                               .threads = threads};
    iso_status status = ISO_OK;
    *lattices = (iso_planned_lattices){0};
    for (size_t l = 0; l < (merged ? 1 : p->nodes.level_count) && status == ISO_OK; ++l) {
        opt.level = l;
        if (!merged && !draws_level(p, l))
            continue;
        status = iso_lattice_create(&lattices->items[lattices->count], &field, &opt, err);
        lattices->count += status == ISO_OK;
    }
    if (status != ISO_OK)
        iso_planned_lattices_destroy(lattices);
    return status;
}

void iso_planned_lattices_destroy(iso_planned_lattices *lattices)
{
    for (size_t i = 0; i < lattices->count; ++i)
        iso_lattice_destroy(&lattices->items[i]);
    *lattices = (iso_planned_lattices){0};
}

/* ---- the crop ------------------------------------------------------------------ */

/* Finds the volume's box in the lattice: its voxel v is at the volume's index step (first + v - 1/2) + 1/2. */
static void find_box(const iso_lattice *l, const iso_geometry *g, double box[2][3])
{
    double step = (double)((size_t)1 << l->level);
    for (int a = 0; a < 3; ++a) {
        double low = -0.5 / step - (double)l->first[a] + 0.5,
               high = (g->box_index[a] - 0.5) / step - (double)l->first[a] + 0.5;
        box[0][a] = low > 0 ? low : 0;
        box[1][a] = high < (double)l->size[a] ? high : (double)l->size[a];
    }
}

/* Returns the greatest common step of all integer scalars, sampled ones included (lattice.h); 0: there is none. */
static double quantum_of(const iso_planned *p, const iso_level *level0)
{
    const bool whole = level0->stored_type != ISO_F32 && level0->stored_type != ISO_F64;
    const double step = iso_lattice_step(&p->nodes);
    return whole && step <= 1 ? step : 0;
}

iso_status iso_planned_crop_create(const iso_planned *p, const iso_level *level0, int threads, iso_planned_crop *crop,
                                   iso_error *err)
{
    iso_planned_lattices merged;
    *crop = (iso_planned_crop){0};
    NEED(iso_planned_lattices_create(p, true, false, threads, &merged, err));
    const iso_lattice *l = &crop->lattice;
    crop->lattice = merged.items[0];
    bool sampled = false;
    for (size_t k = 1; k < p->nodes.level_count; ++k)
        sampled = sampled || draws_level(p, k);
    crop->level = (iso_level){.geometry = l->geometry,
                              .stored_type = sampled ? ISO_F32 : level0->stored_type,
                              .min = l->min,
                              .max = l->max};
    find_box(l, &p->nodes.geometry, crop->box);
    crop->quantum = quantum_of(p, level0);
    return ISO_OK;
}

void iso_planned_crop_destroy(iso_planned_crop *crop)
{
    iso_lattice_destroy(&crop->lattice);
    *crop = (iso_planned_crop){0};
}
