/* SPDX-License-Identifier: MIT */
#include "cli/build_auto.h"

#include <stdio.h>

#include "base/json.h"
#include "base/provenance.h"
#include "cli/build_for.h"
#include "plan/auto_choice.h"
#include "pyramid/agreement.h"
#include "tf/presets.h"

/* Refused before anything is read. */
static iso_status check(const iso_build_auto *b, iso_error *err)
{
    if (b->budget_bytes < ISO_AUTO_LEAST_BYTES)
        return iso_fail(err, ISO_E_USAGE, "--budget is %d, directions alone take %d bytes a voxel", b->budget_bytes,
                        ISO_AUTO_LEAST_BYTES);
    return iso_cli_check_memory("--auto", b->volume, b->input, b->memory_mb, err);
}

static iso_status choose(const iso_build_auto *b, const iso_volume *v, const iso_pyramid_options *opt,
                         iso_auto_choice *choice, const iso_progress *progress, iso_error *err)
{
    const iso_volume_stats stats = iso_volume_measure(v);
    iso_tf tf = {0};
    iso_tf_table table = {0};
    iso_status status = iso_tf_of_volume(b->look->tf, &b->look->request, v, b->cli->threads, &tf, err);
    if (status == ISO_OK)
        status = iso_tf_tabulate(&tf, stats.min, stats.max, &v->geometry, &table, err);
    if (status == ISO_OK)
        status = iso_auto_measure(v, opt, &table, choice, progress, err);
    if (status == ISO_OK)
        status = iso_auto_choose(choice, b->budget_bytes, err);
    iso_tf_table_destroy(&table);
    iso_tf_destroy(&tf);
    return status;
}

static void print_designs(const iso_build_auto *b, const iso_auto_choice *choice)
{
    printf("predicted error over the default's:");
    for (size_t d = 0; d < ISO_AUTO_DESIGNS; ++d) {
        const iso_auto_design *one = iso_auto_design_at(d);
        printf("%s %s %.2f%s", d > 0 ? "," : "", one->name, choice->predicted[d],
               one->bytes > b->budget_bytes ? " (above the budget)" : "");
    }
    printf("\n");
}

static void print(const iso_build_auto *b, const iso_pyramid *p, const iso_auto_choice *choice)
{
    const iso_auto_design *chosen = iso_auto_design_at(choice->chosen);
    if (b->cli->json) {
        json_t *root = iso_cli_json(b->cli);
        json_object_set_new(root, "output", json_string(b->output));
        json_object_set(root, "auto", p->chosen_by);
        iso_cli_print_json(root);
        return;
    }
    for (size_t k = 0; k < p->level_count; ++k) {
        const iso_level *l = &p->levels[k];
        char text[128];
        printf("level %zu  %zu x %zu x %zu  %s  %.6g to %.6g", k, l->geometry.size[0], l->geometry.size[1],
               l->geometry.size[2], iso_type_name(l->stored_type), l->min, l->max);
        if (k > 0 && p->options.choice.is_made)
            printf("  %s", iso_direction_choice_text(&p->options.choice, k, text, sizeof text));
        printf("\n");
    }
    print_designs(b, choice);
    printf("chosen: %s (%s), %d bytes a voxel beside the scalar%s%s\n%s\n", chosen->name, chosen->summary,
           chosen->bytes, *iso_auto_options(chosen) ? "; show it with " : "", iso_auto_options(chosen), b->output);
}

iso_status iso_cli_build_auto(const iso_build_auto *b, const iso_pyramid_options *opt, iso_error *err)
{
    const iso_progress progress = iso_cli_progress(b->cli);
    iso_pyramid_options own = *opt;
    iso_volume volume = {0};
    iso_pyramid p = {0};
    iso_auto_choice choice = {0};
    iso_cli_expect(b->cli, (const iso_cli_stage[]){{"choosing", 4}, {"pyramid", 1}}, 2);
    iso_status status = check(b, err);
    if (status == ISO_OK)
        status = iso_volume_input_load(b->volume, b->input, &volume, err);
    if (status == ISO_OK)
        status = choose(b, &volume, opt, &choice, &progress, err);
    own.scalar_filter = iso_auto_design_at(choice.chosen)->scalar;
    own.direction_filter = ISO_DIRECTION_AUTO;
    if (status == ISO_OK)
        status = iso_pyramid_build(&volume, b->volume, &own, &p, &progress, err);
    iso_volume_destroy(&volume);
    if (status == ISO_OK) {
        p.chosen_by = iso_auto_to_json(&choice, b->budget_bytes, b->look->tf ? iso_provenance_name(b->look->tf) : "auto");
        status = p.chosen_by ? iso_pyramid_save(&p, b->output, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
    }
    if (status == ISO_OK)
        print(b, &p, &choice);
    iso_pyramid_destroy(&p);
    return status;
}
