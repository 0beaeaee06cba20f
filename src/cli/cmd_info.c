/* SPDX-License-Identifier: MIT */
/* cmd_info.c - shows a volume's geometry, type, range and histogram, or a pyramid. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/provenance.h"
#include "cli/histogram_picture.h"
#include "fit/level_scalar.h"
#include "options/cli.h"
#include "options/input.h"
#include "pyramid/agreement.h"
#include "tf/histogram_verify.h"
#include "tf/level_look.h"
#include "volume/format.h"
#include "volume/segments.h"
#include "volume/overview.h"
#include "volume/unit.h"
#include "volume/value_unit.h"

/* Prints the unit of lengths in the file. */
static void print_unit(const iso_volume_notes *n)
{
    if (!n->unit[0])
        printf("  unit       none in the file: mm\n");
    else
        printf("  unit       %s = %.9g mm\n", n->unit, n->unit_mm);
}

/* Prints time steps and channels if the file has several. */
static void print_frames(const iso_volume_notes *n)
{
    if (n->frame_count > 1) {
        printf("  frames     %zu, this is %zu (from 0)", n->frame_count, n->frame);
        if (n->frame_step > 0)
            printf(", %g%s%s apart", n->frame_step, n->frame_unit[0] ? " " : "", n->frame_unit);
        printf("; --frame K chooses another\n");
    }
    if (n->channel_count <= 1)
        return;
    printf("  channels   %zu, this is ", n->channel_count);
    if (strcmp(n->channel_name, "luminance") == 0)
        printf("their luminance");
    else
        printf("%zu (from 0)%s%s", n->channel, n->channel_name[0] ? ": " : "", n->channel_name);
    printf("; --channel chooses another: %s\n", n->channel_list);
}

static json_t *frames_to_json(const iso_volume_notes *n)
{
    return json_pack("{s:I, s:I, s:f, s:s, s:I, s:I, s:s}", "frames", (json_int_t)(n->frame_count ? n->frame_count : 1),
                     "frame", (json_int_t)n->frame, "frame_step", n->frame_step, "frame_unit", n->frame_unit,
                     "channels", (json_int_t)(n->channel_count ? n->channel_count : 1), "channel",
                     (json_int_t)n->channel, "channel_name", n->channel_name);
}

static void print_scale(const iso_volume_notes *n)
{
    if (n->applied_slope != 0)
        printf("  scale      value = %.9g * stored + %.9g (ignore it with --stored)\n", n->applied_slope,
               n->applied_intercept);
    else if (n->scale_slope != 1 || n->scale_intercept != 0)
        printf("  scale      physical value = %.9g * sample + %.9g (ignored: --stored)\n", n->scale_slope,
               n->scale_intercept);
}

/* Prints names and colors of the labels if the file has them. */
static void print_segments(const json_t *segments)
{
    enum { LISTED = 48 };
    const size_t count = json_array_size(segments);
    for (size_t i = 0; i < count && i < LISTED; ++i) {
        const json_t *segment = json_array_get(segments, i);
        const long label = (long)json_integer_value(json_object_get(segment, "label"));
        double srgb[3];
        printf("  label      %ld: %s", label, json_string_value(json_object_get(segment, "name")));
        const json_t *id = json_object_get(segment, "id");
        if (id)
            printf(", value %" JSON_INTEGER_FORMAT, json_integer_value(id));
        if (iso_segments_color(segments, label, srgb))
            printf(", color #%02x%02x%02x", (unsigned)(255 * srgb[0] + 0.5), (unsigned)(255 * srgb[1] + 0.5),
                   (unsigned)(255 * srgb[2] + 0.5));
        printf("\n");
    }
    if (count > LISTED)
        printf("  label      and %zu more; list all with --json\n", count - LISTED);
}

static void print_text(const char *path, const iso_overview *f)
{
    const iso_volume *v = &f->header;
    const iso_geometry *g = &v->geometry;
    double spacing[3], mm;
    iso_geometry_spacing_mm(g, spacing);
    const char *unit = iso_unit_fitting(fmax(spacing[0], fmax(spacing[1], spacing[2])), &mm);
    printf("%s\n  size       %zu x %zu x %zu = %zu voxels of %s\n", path, g->size[0], g->size[1], g->size[2],
           iso_geometry_voxel_count(g), iso_type_name(v->type));
    printf("  spacing    %g x %g x %g %s\n  corner     %g, %g, %g %s (%s)\n", spacing[0] / mm, spacing[1] / mm,
           spacing[2] / mm, unit, g->origin_mm.x / mm, g->origin_mm.y / mm, g->origin_mm.z / mm, unit,
           v->notes.world_is_ras ? "right, anterior, superior" : "the file's own frame");
    print_unit(&v->notes);
    print_frames(&v->notes);
    if (v->notes.label_count)
        printf("  labels     label map, %zu labels, without interpolation (intensities: --no-labels)\n",
               v->notes.label_count);
    if (v->notes.label_count)
        print_segments(v->segments);
    for (int a = 0; a < 3; ++a) {
        iso_vec3 d = iso_normalize(iso_column(g->index_to_world, a));
        printf("  %c axis     %.6g, %.6g, %.6g\n", 'x' + a, d.x, d.y, d.z);
    }
    const char *of_values = iso_value_unit_of(&v->notes);
    printf("  range      %.9g to %.9g%s%s, mean %.6g\n", f->stats.min, f->stats.max, of_values[0] ? " " : "", of_values,
           f->stats.mean);
    if (f->stats.no_data_count > 0)
        printf("  no data    %zu of %zu voxels\n", f->stats.no_data_count, iso_geometry_voxel_count(g));
    printf("  percentiles");
    for (int p = 0; p < ISO_OVERVIEW_PERCENTS; ++p)
        printf("  %g %%: %.5g", iso_overview_percents[p], f->percentile[p]);
    printf("\n  histogram, counts in logs\n");
    iso_histogram_print(&f->shown, 2, stdout);
    print_scale(&v->notes);
    if (f->rounded > 0)
        printf("  rounding   to float changes %zu voxels, by at most %.3g\n", f->rounded, f->most_rounded);
}

static json_t *integers(const size_t *values, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; ++i)
        json_array_append_new(list, json_integer((json_int_t)values[i]));
    return list;
}

static void print_json(const iso_cli *cli, const char *path, const iso_overview *f)
{
    const iso_volume *v = &f->header;
    const iso_geometry *g = &v->geometry;
    double spacing[3], origin[3] = {g->origin_mm.x, g->origin_mm.y, g->origin_mm.z};
    iso_geometry_spacing_mm(g, spacing);
    const char *unit = v->notes.unit[0] ? v->notes.unit : "mm";
    json_t *root = iso_cli_json(cli), *matrix = json_array();
    for (int r = 0; r < 3; ++r)
        json_array_append_new(matrix, iso_json_numbers(g->index_to_world.m[r], 3));
    json_object_set_new(root, "volume", json_string(path));
    json_object_set_new(root, "size", integers(g->size, 3));
    json_object_set_new(root, "type", json_string(iso_type_name(v->type)));
    json_object_set_new(root, "spacing_mm", iso_json_numbers(spacing, 3));
    json_object_set_new(root, "origin_mm", iso_json_numbers(origin, 3));
    json_object_set_new(root, "index_to_world_mm", matrix);
    json_object_set_new(root, "world_is_ras", json_boolean(v->notes.world_is_ras));
    json_object_set_new(root, "min", json_real(f->stats.min));
    json_object_set_new(root, "max", json_real(f->stats.max));
    json_object_set_new(root, "mean", json_real(f->stats.mean));
    json_object_set_new(root, "no_data_voxels", json_integer((json_int_t)f->stats.no_data_count));
    json_object_set_new(root, "percents", iso_json_numbers(iso_overview_percents, ISO_OVERVIEW_PERCENTS));
    json_object_set_new(root, "percentiles", iso_json_numbers(f->percentile, ISO_OVERVIEW_PERCENTS));
    json_object_set_new(root, "histogram", integers(f->bins, ISO_OVERVIEW_BINS));
    json_object_set_new(root, "unit", json_string(unit));
    json_object_set_new(root, "unit_is_named", json_boolean(v->notes.unit[0] != 0));
    json_object_set_new(root, "unit_mm", json_real(v->notes.unit_mm));
    json_object_set_new(root, "value_unit", json_string(iso_value_unit_of(&v->notes)));
    json_object_set_new(root, "scale_slope", json_real(v->notes.scale_slope));
    json_object_set_new(root, "scale_intercept", json_real(v->notes.scale_intercept));
    json_object_set_new(root, "applied_slope", json_real(v->notes.applied_slope));
    json_object_set_new(root, "applied_intercept", json_real(v->notes.applied_intercept));
    json_object_update_new(root, frames_to_json(&v->notes));
    json_object_set_new(root, "labels", json_integer((json_int_t)v->notes.label_count));
    if (v->notes.label_count && v->segments)
        json_object_set(root, "segments", v->segments);
    json_object_set_new(root, "float_rounding_voxels", json_integer((json_int_t)f->rounded));
    json_object_set_new(root, "float_rounding_max", json_real(f->most_rounded));
    iso_cli_print_json(root);
}

/* Draws the histogram as a picture, with finer bins than the text. */
static iso_status draw_histogram(const char *path, const iso_overview *f, const char *picture, iso_error *err)
{
    const size_t *n = f->header.geometry.size;
    char title[512];
    snprintf(title, sizeof title, "%.200s: %zu x %zu x %zu voxels, %.6g to %.6g", iso_provenance_title(path), n[0],
             n[1], n[2], f->stats.min, f->stats.max);
    return iso_histogram_draw(&f->drawn, title, picture, err);
}

static iso_status show(const iso_cli *cli, const iso_volume_input *input, const char *picture, iso_error *err)
{
    enum { DRAWN_BINS = 512 };
    const char *path = cli->arguments[0];
    const iso_progress progress = iso_cli_progress(cli);
    const iso_overview_options opt = {.drawn_bins = picture ? DRAWN_BINS : 0, .threads = cli->threads};
    OWNED(iso_overview) facts = {0};
    NEED(iso_overview_run(path, input, &opt, &facts, &progress, err));
    if (picture)
        NEED(draw_histogram(path, &facts, picture, err));
    if (cli->json)
        print_json(cli, path, &facts);
    else
        print_text(path, &facts);
    return ISO_OK;
}

/* ---- pyramids ---- */

/* Results of --verify. */
typedef struct verified {
    iso_level_check levels[32];
    size_t joint_count;
    iso_joint_check *joints;
} verified;

static void verified_destroy(verified *found)
{
    free(found->joints);
}

/* Returns a level as JSON. check: NULL without --verify. */
static json_t *level_to_json(const iso_pyramid *p, size_t k, const iso_level_check *check)
{
    const iso_level *l = &p->levels[k];
    const iso_direction_choice *choice = &p->options.choice;
    json_t *o = json_pack("{s:o, s:s, s:f, s:f}", "size", integers(l->geometry.size, 3), "type",
                          iso_type_name(l->stored_type), "min", l->min, "max", l->max);
    if (k > 0 && choice->is_made)
        json_object_update_new(o, json_pack("{s:s, s:f, s:f}", "direction_filter",
                                            iso_direction_filter_name(choice->filter[k]), "mean_agreement",
                                            choice->mean_agreement[k], "axis_agreement", choice->axis_agreement[k]));
    if (check)
        json_object_update_new(o, json_pack("{s:I, s:s?, s:o}", "differing_voxels", (json_int_t)check->differing,
                                            "what_differs", check->what, "first_voxel",
                                            check->what ? integers(check->first, 3) : json_null()));
    return o;
}

static json_t *joints_to_json(const verified *found)
{
    json_t *list = json_array();
    for (size_t i = 0; i < found->joint_count; ++i) {
        const iso_joint_check *c = &found->joints[i];
        json_array_append_new(list, json_pack("{s:I, s:i, s:i, s:I, s:I, s:s}", "level", (json_int_t)c->key.level,
                                              "bits", c->key.bits, "second_value", (int)c->key.second, "voxels",
                                              (json_int_t)c->voxels, "differing_voxels", (json_int_t)c->differing,
                                              "unreadable", c->unreadable.text));
    }
    return list;
}

static void print_pyramid_json(const iso_cli *cli, const iso_pyramid *p, const verified *found)
{
    const iso_pyramid_options *opt = &p->options;
    json_t *levels = json_array();
    for (size_t k = 0; k < p->level_count; ++k)
        json_array_append_new(levels, level_to_json(p, k, found ? &found->levels[k] : NULL));
    json_t *root = json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:b, s:o}", "pyramid", cli->arguments[0], "source",
                             p->source, "built_by", p->built_by, "scalar_filter",
                             iso_scalar_filter_name(opt->scalar_filter), "direction_filter",
                             iso_direction_filter_name(opt->direction_filter), "estimator",
                             iso_gradient_name(opt->gradient.method), "code", iso_code_describe(opt->code)->name,
                             "verified", found != NULL, "levels", levels);
    if (found)
        json_object_set_new(root, "joint_histograms", joints_to_json(found));
    if (p->unit.name[0])
        json_object_set_new(root, "unit", json_pack("{s:s, s:f}", "name", p->unit.name, "mm", p->unit.mm));
    json_object_update_new(root, json_pack("{s:O*, s:O*}", "segments", p->segments, "made_for", p->made_for));
    iso_cli_print_results(cli, root);
}

/* Prints "level 1 least-squares, level 2 fitted" for a pyramid that was built for a scene. */
static void print_made_for(const iso_pyramid *p)
{
    const json_t *levels = json_object_get(p->made_for, "levels"), *level;
    FREED char *scenes = iso_level_scene_names(p);
    size_t i;
    printf("  made for   %s:", scenes ? scenes : "?");
    json_array_foreach (levels, i, level) {
        const char *scalar = json_string_value(json_object_get(level, "scalar"));
        printf("%s level %d %s", i > 0 ? "," : "", (int)json_integer_value(json_object_get(level, "level")),
               scalar ? scalar : "?");
    }
    printf("\n");
}

static void print_pyramid_text(const iso_cli *cli, const iso_pyramid *p, const verified *found)
{
    const iso_pyramid_options *opt = &p->options;
    char text[512];
    printf("%s\n  source     %s\n  built by   %s\n", cli->arguments[0], p->source, p->built_by);
    if (p->unit.name[0])
        printf("  unit       of its file: %s = %.9g mm\n", p->unit.name, p->unit.mm);
    printf("  options    --scalar-filter %s --direction-filter %s --estimator %s --code %s%s%s\n",
           iso_scalar_filter_name(opt->scalar_filter), iso_direction_filter_name(opt->direction_filter),
           iso_gradient_name(opt->gradient.method), iso_code_describe(opt->code)->name,
           opt->keep_float ? " --keep-float" : "", opt->keep_magnitude ? " --keep-magnitude" : "");
    if (opt->value_range[1] > opt->value_range[0])
        printf("  all frames %.9g to %.9g, the range of fitted TFs\n", opt->value_range[0], opt->value_range[1]);
    print_segments(p->segments);
    if (p->made_for)
        print_made_for(p);
    for (size_t k = 0; k < p->level_count; ++k) {
        const iso_level *l = &p->levels[k];
        const size_t *n = l->geometry.size;
        printf("  level %zu    %zu x %zu x %zu voxels of %s, %.9g to %.9g\n", k, n[0], n[1], n[2],
               iso_type_name(l->stored_type), l->min, l->max);
        if (k > 0 && opt->choice.is_made)
            printf("             %s\n", iso_direction_choice_text(&opt->choice, k, text, sizeof text));
    }
    for (size_t k = 0; found && k < p->level_count; ++k)
        printf("  %s\n", iso_level_check_text(&found->levels[k], k, text, sizeof text));
    for (size_t i = 0; found && i < found->joint_count; ++i)
        printf("  %s\n", iso_joint_check_text(&found->joints[i], text, sizeof text));
}

/* Reports the first failed check. */
static iso_status report_failed_check(const iso_cli *cli, const iso_pyramid *p, const verified *found, iso_error *err)
{
    char text[512];
    for (size_t k = 0; k < p->level_count; ++k)
        if (found->levels[k].what)
            return iso_fail(err, ISO_E_DIFFERS, "%s: %s", cli->arguments[0],
                            iso_level_check_text(&found->levels[k], k, text, sizeof text));
    for (size_t i = 0; i < found->joint_count; ++i)
        if (!iso_joint_check_is_good(&found->joints[i]))
            return iso_fail(err, ISO_E_DIFFERS, "%s: %s", cli->arguments[0],
                            iso_joint_check_text(&found->joints[i], text, sizeof text));
    return ISO_OK;
}

static iso_status show_pyramid(const iso_cli *cli, bool is_verified, iso_error *err)
{
    OWNED(iso_pyramid) p = {0};
    OWNED(verified) found = {0};
    const iso_progress progress = iso_cli_progress(cli);
    const char *path = cli->arguments[0];
    NEED((is_verified ? iso_pyramid_load : iso_pyramid_load_outline)(path, &p, err));
    if (is_verified) {
        NEED(iso_fit_verify(&p, cli->threads, found.levels, &progress, err));
        NEED(iso_joint_verify(&p, path, cli->threads, &found.joints, &found.joint_count, &progress, err));
    }
    if (cli->json)
        print_pyramid_json(cli, &p, is_verified ? &found : NULL);
    else
        print_pyramid_text(cli, &p, is_verified ? &found : NULL);
    return is_verified ? report_failed_check(cli, &p, &found, err) : ISO_OK;
}

typedef struct info_options {
    iso_volume_input input;
    char *picture;
    int verify;
} info_options;

static const iso_option options[] = {
    {"verify", 0, "pyramids: rebuild all levels from level 0, and compare", NULL, ISO_IN(info_options, verify)},
    {"histogram", 0, "volumes: draw the histogram with gnuplot: .png, .svg or .pdf", "FILE",
     ISO_IN(info_options, picture)},
    ISO_OPTIONS_OF(info_options, input, iso_input_rows),
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const info_options *o = values;
    const char *path = cli->arguments[0];
    const bool is_pyramid = iso_pyramid_is_one(path);
    if (o->picture && is_pyramid)
        return iso_fail(err, ISO_E_USAGE, "%s: a pyramid; --histogram needs a volume", path);
    if (o->verify && !is_pyramid)
        return iso_fail(err, ISO_E_USAGE, "%s: a volume; --verify needs a pyramid", path);
    return is_pyramid ? show_pyramid(cli, o->verify, err) : show(cli, &o->input, o->picture, err);
}

const iso_command iso_command_info = {
    .name = "info",
    .summary = "show a volume's geometry, type, range and histogram; or show and verify a pyramid",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "VOLUME|PYRAMID.iso [options]",
    .details =
        "A file's first bytes decide its format, not its name. Builds are deterministic: --verify rebuilds all files of a\n"
        "pyramid from its level 0, with its own options, and compares every bit. This finds a level of another volume\n"
        "even if its checksum is right. Joint histograms that tf adapt stored in the folder are counted again.\n"
        "Exit code 1: a level does not follow from level 0, or a histogram does not match the levels.",
    .common = "verify histogram spacing unit series frame channel no-data stored labels raw-size raw-type",
    .examples = "  isoshade make sphere --size 48 -o sphere.nrrd\n"
                "  isoshade info sphere.nrrd\n"
                "  isoshade info sphere.nrrd --json\n"
                "  isoshade info sphere.nrrd --histogram sphere.svg\n"
                "  isoshade build sphere.nrrd -o sphere.iso\n"
                "  isoshade info sphere.iso --verify\n",
    .lists = (const iso_names *const[]){&iso_volume_format_names, NULL},
    ISO_COMMAND_OPTIONS(info_options, options, .input = {.takes_first = true}),
    .run = run,
};
