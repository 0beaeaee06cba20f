/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/tf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/inputs.h"
#include "options/overwrite.h"
#include "pyramid/pyramid.h"
#include "tf/format.h"
#include "tf/presets.h"
#include "volume/unit.h"

void iso_cli_tf_table_destroy(iso_cli_tf_table *t)
{
    iso_tf_destroy(&t->tf);
    iso_tf_table_destroy(&t->table);
}

/* Sets the volume's range and unit length if the TF left them open. */
static void resolve(iso_tf *tf, const iso_tf_table *table, double unit_mm)
{
    if (tf->fit_range)
        for (size_t i = 0; i < tf->point_count; ++i)
            tf->points[i].value = table->lo + tf->points[i].value * (table->hi - table->lo);
    tf->fit_range = false;
    tf->range[0] = table->lo, tf->range[1] = table->hi;
    tf->unit_is_voxels = false;
    tf->unit_distance = unit_mm;
}

/* Checks a name before the volume is read, whose values presets need. */
static iso_status check_name(const iso_tf_arguments *a, const char *name, const iso_tf_request *request, iso_error *err)
{
    size_t row;
    if (iso_tf_preset_find(name, &row) && !a->volume)
        return iso_fail(err, ISO_E_USAGE, "%s: a preset needs a volume's values; give --volume FILE", name);
    return iso_tf_check_name(name, request, err);
}

iso_status iso_cli_tf_load_volume(const iso_tf_arguments *a, iso_volume *v, iso_error *err)
{
    *v = (iso_volume){0};
    if (a->volume && iso_pyramid_is_one(a->volume))
        return iso_fail(err, ISO_E_USAGE, "--volume is %s, a pyramid; give a volume, such as %s/level_0.nrrd",
                        a->volume, a->volume);
    return a->volume ? iso_volume_input_load(a->volume, &a->input, v, err) : ISO_OK;
}

iso_status iso_cli_tf_load_table(const iso_tf_arguments *a, const char *path, iso_cli_tf_table *t, iso_error *err)
{
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){1, 1, 1}, (double[]){1, 1, 1});
    iso_volume_stats stats = {.min = 0, .max = 1};
    iso_tf_request request;
    OWNED(iso_volume) v = {0};
    NEED(iso_cli_transfer_request(&a->look.transfer, &request, err));
    request.measure = true;
    NEED(check_name(a, path, &request, err));
    NEED(iso_cli_tf_load_volume(a, &v, err));
    if (a->volume)
        stats = iso_volume_measure(&v), g = v.geometry;
    NEED(iso_tf_of_volume(path, &request, &v, a->cli->threads, &t->tf, err));
    NEED(iso_tf_tabulate(&t->tf, stats.min, stats.max, &g, &t->table, err));
    t->voxel_mm = iso_geometry_mean_spacing_mm(&g);
    t->unit_mm = t->tf.unit_distance * (t->tf.unit_is_voxels ? t->voxel_mm : 1);
    if (a->volume)
        resolve(&t->tf, &t->table, t->unit_mm);
    return ISO_OK;
}

/* ---- convert ----------------------------------------------------------------------------------------------------- */

/* Returns the output: the argument after the file, or -o. NULL if neither or both are given. */
static const char *output_of(const iso_tf_arguments *a)
{
    const size_t count = a->cli->argument_count;
    return count == 2 ? a->output : count == 3 && !a->output ? a->cli->arguments[2] : NULL;
}

/* Returns the largest difference of table b from a at a's entries, in display color and in opacity of unit_mm. */
static iso_tf_loss distance(const iso_tf_table *a, const iso_tf_table *b, double unit_mm)
{
    iso_tf_loss loss = {.measured = true};
    double at[2][4];
    for (size_t i = 0; i < a->count; ++i) {
        const double x = a->lo + (a->hi - a->lo) * (double)i / (double)(a->count - 1);
        iso_tf_lookup(a, x, at[0]);
        iso_tf_lookup(b, x, at[1]);
        for (int c = 0; c < 3; ++c)
            loss.color = fmax(loss.color, fabs(iso_linear_to_srgb(at[0][c]) - iso_linear_to_srgb(at[1][c])));
        loss.opacity = fmax(loss.opacity, fabs(expm1(-at[0][3] * unit_mm) - expm1(-at[1][3] * unit_mm)));
    }
    return loss;
}

/* Reads the written file again, and compares. */
static iso_status read_again(const iso_tf_format *format, const char *path, double unit_mm, const iso_cli_tf_table *t,
                             iso_tf_loss *loss, iso_error *err)
{
    const iso_geometry g = iso_geometry_axis_aligned((size_t[]){1, 1, 1},
                                                     (double[]){t->voxel_mm, t->voxel_mm, t->voxel_mm});
    OWNED(iso_tf_table) again = {0};
    OWNED(iso_tf) tf = {0};
    iso_tf_request request = {0};
    if (!format->load)
        return ISO_OK;
    if (format->has_no_unit)
        request.unit_mm = unit_mm;
    NEED(iso_tf_load_as(path, &request, &tf, err));
    NEED(iso_tf_tabulate(&tf, t->table.lo, t->table.hi, &g, &again, err));
    *loss = distance(&t->table, &again, unit_mm);
    return ISO_OK;
}

static json_t *loss_json(const iso_tf_loss *loss)
{
    return loss->measured
               ? json_pack("{s:f, s:f, s:f}", "color", loss->color, "opacity", loss->opacity, "between", loss->between)
               : json_null();
}

static void print_loss(const char *of_what, const iso_tf_loss *loss)
{
    if (!loss->measured)
        return;
    printf("%s: color within %.2f/255, opacity within %.2f/255", of_what, 255 * loss->color, 255 * loss->opacity);
    if (255 * loss->between > 1)
        printf("; at steep curves, between two entries of the table, %.0f/255", 255 * loss->between);
    putchar('\n');
}

static void report(const iso_tf_arguments *a, const iso_cli_tf_table *t, const iso_tf_format *format, double unit_mm,
                   const iso_tf_loss *written)
{
    if (a->cli->json) {
        iso_cli_print_results(a->cli, json_pack("{s:s, s:s, s:o, s:f, s:I, s:I, s:o, s:o}", "output", output_of(a),
                                                "format", format->name, "range",
                                                t->tf.fit_range ? json_string("fit") : iso_json_numbers(t->tf.range, 2),
                                                "unit_distance_mm", unit_mm, "points", (json_int_t)t->tf.point_count,
                                                "entries", (json_int_t)t->table.count, "read", loss_json(&t->tf.loss),
                                                "written", loss_json(written)));
        return;
    }
    if (a->cli->quiet)
        return;
    char length[32];
    iso_unit_text(unit_mm, 6, length, sizeof length);
    if (t->tf.fit_range)
        printf("%s: %zu points over the volume's range, opacities for %s\n", output_of(a), t->tf.point_count, length);
    else
        printf("%s: %zu points from %g to %g, opacities for %s\n", output_of(a), t->tf.point_count, t->table.lo,
               t->table.hi, length);
    print_loss("read: against the other program", &t->tf.loss);
    print_loss("written: read again", written);
}

/* Refuses formats that store values if the range is an unknown volume's. */
static iso_status check_known(const iso_tf_arguments *a, const iso_tf_format *format, const iso_tf *tf, iso_error *err)
{
    if (format->needs_range && tf->fit_range)
        return iso_fail(err, ISO_E_USAGE,
                        "%s: its range is the volume's, and %s files hold values; give --volume FILE or --range LO,HI",
                        a->cli->arguments[1], format->suffix);
    return ISO_OK;
}

iso_status iso_cli_tf_convert(const iso_tf_arguments *a, iso_error *err)
{
    char written[256];
    OWNED(iso_cli_tf_table) t = {0};
    iso_tf_loss loss = {0};
    const char *output = output_of(a);
    if (!output)
        return iso_fail(err, ISO_E_USAGE, "usage: isoshade tf convert FILE|PRESET OUT, where OUT ends in %s",
                        iso_tf_format_written(written, sizeof written));
    NEED(iso_cli_refuse_same_file(output, a->cli->arguments[1], err));
    NEED(iso_inputs_announce(output, err));
    const iso_tf_format *format = iso_tf_format_of(output);
    if (!format || !format->save)
        return iso_fail(err, ISO_E_USAGE, "\"%s\" must end with %s", output,
                        iso_tf_format_written(written, sizeof written));
    NEED(iso_cli_tf_load_table(a, a->cli->arguments[1], &t, err));
    NEED(check_known(a, format, &t.tf, err));
    const double unit_mm = format->is_per_voxel ? t.voxel_mm : t.unit_mm;
    NEED(format->save(&(iso_tf_output){&t.tf, &t.table, unit_mm}, output, err));
    NEED(read_again(format, output, unit_mm, &t, &loss, err));
    report(a, &t, format, unit_mm, &loss);
    return ISO_OK;
}

/* ---- names ------------------------------------------------------------------------------------------------------- */

/* Prints names as JSON. text: one name per line. */
static void print_names_as_json(const iso_cli *cli, char *text)
{
    json_t *list = json_array();
    for (char *name; (name = strsep(&text, "\n"));)
        if (*name)
            json_array_append_new(list, json_string(name));
    iso_cli_print_results(cli, json_pack("{s:o}", "names", list));
}

iso_status iso_cli_tf_names(const iso_tf_arguments *a, iso_error *err)
{
    FREED char *names = NULL;
    OWNED(iso_tf) tf = {0};
    if (a->cli->argument_count != 2)
        return iso_fail(err, ISO_E_USAGE, "usage: isoshade tf names FILE");
    const iso_status status = iso_tf_load_as(a->cli->arguments[1], &(iso_tf_request){.names = &names}, &tf, err);
    if (!names && status == ISO_OK)
        return iso_fail(err, ISO_E_FORMAT, "%s: holds a single transfer function, without a name",
                        a->cli->arguments[1]);
    if (!names)
        return status;
    if (a->cli->json)
        print_names_as_json(a->cli, names);
    else
        fputs(names, stdout);
    return ISO_OK;
}
