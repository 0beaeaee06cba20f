/* SPDX-License-Identifier: MIT */
#include "options/adapted.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fit/extinction_scale.h"
#include "options/cli.h"
#include "scene/level_view.h"
#include "tf/level_look.h"
#include "tf/ghost.h"

const iso_option iso_adapt_method_rows[] = {
    {"bits", 0, "bits of the joint histogram, 8 to 16", "N", ISO_IN(iso_cli_adapted, bits), .flags = ISO_SHOWN},
    {"always", 0, "adapt even if small views show no gain", NULL, ISO_IN(iso_cli_adapted, always)},
    ISO_OPTIONS_END,
};

const iso_option iso_adapted_rows[] = {
    {"adapt", 0, "adapt the transfer function to the level", NULL, ISO_IN(iso_cli_adapted, wanted)},
    {"extinction-scale", 0, "scale coarse voxels' extinction to match the opacity of fine ones", NULL,
     ISO_IN(iso_cli_adapted, extinction_scale)},
    {"tf-2d", 0, "use a 2D transfer function with this second value", "deviation|gradient",
     ISO_IN(iso_cli_adapted, tf_2d), .flags = ISO_ONE_OF},
    {.table = iso_adapt_method_rows},
    ISO_OPTIONS_END,
};

iso_status iso_cli_adapt_options(const iso_cli_adapted *a, int threads, iso_adapt_options *opt, iso_error *err)
{
    *opt = iso_adapt_defaults();
    const iso_status status = iso_words_check_range("--bits", a->bits, 8, 16, err);
    opt->bits = a->bits;
    opt->fall_back = !a->always;
    opt->threads = threads;
    return status;
}

/* Reads --tf-2d. */
static iso_second_value second_value(const iso_cli_adapted *a)
{
    return !a->tf_2d                            ? ISO_SECOND_VALUE_NONE
           : strcmp(a->tf_2d, "deviation") == 0 ? ISO_SECOND_VALUE_DEVIATION
                                                : ISO_SECOND_VALUE_GRADIENT;
}

/* True if an option says how to adapt; without --adapt it would have no effect. */
static bool has_method(const iso_cli_adapted *a)
{
    return a->tf_2d || a->always || a->bits != iso_adapt_defaults().bits;
}

/* Largest share of opacity that is lost without a warning. At level 1 seven scans and five synthetic volumes lost at most
 * 0.035, or at least 0.125: sheets thinner than a voxel. tests/check_ghost.sh has one of each kind. */
#define MOST_LOST 0.1

/* Reports a ghost in one line: drawn, or left out. */
static void report_ghost(const iso_cli_adapted *a, size_t level, double ghost, bool is_left_out)
{
    if (!a->cli)
        return;
    iso_progress_line_hide(a->cli->progress);
    fprintf(stderr,
            "isoshade %s: %s: level %zu: the adapted transfer function %s a ghost, %.1f %% of level 0's opacity, where "
            "level 0 is empty%s; --extinction-scale avoids ghosts\n",
            a->cli->command->name, is_left_out ? "note" : "warning", level, is_left_out ? "would draw" : "draws",
            100 * ghost, is_left_out ? ", so its values keep the original transfer function" : "");
}

/* Warns if small views show that a level lacks opacity of level 0. */
static void look_for_loss(const iso_cli_adapted *a, size_t level, const iso_adapt_judgment *j)
{
    const double lost = (j->use_original ? j->seen_original : j->seen_adapted).lost;
    if (!a->cli || !j->seen || !(lost > MOST_LOST))
        return;
    iso_progress_line_hide(a->cli->progress);
    fprintf(stderr,
            "isoshade %s: warning: level %zu lacks %.0f %% of level 0's opacity in small views: thin sheets break up; "
            "--extinction-scale keeps them\n",
            a->cli->command->name, level, 100 * lost);
}

/* Measures the ghost of a level without small views, and reports it if it is above the limit. */
static iso_status look_for_ghost(const iso_cli_adapted *a, const iso_pyramid *p, size_t level,
                                 const iso_tf_table *original, const iso_tf_table *tf, const iso_tf_2d *tf_2d,
                                 iso_error *err)
{
    double ghost = 0;
    NEED(iso_ghost_measure(p, level, original, tf, tf_2d, a->cli ? a->cli->threads : 0, &ghost, err));
    if (ghost > ISO_GHOST_LIMIT)
        report_ghost(a, level, ghost, false);
    return ISO_OK;
}

/* Adapts the view's 1D transfer function; with a second value makes the 2D one, too: a ColorRamp and an isosurface take
 * only 1D. */
static iso_status adapt(const iso_cli_adapted *a, const iso_pyramid *p, size_t level, iso_second_value second,
                        iso_adapt_options *opt, iso_view *view, iso_error *err)
{
    iso_adapt_judgment judgment = {0};
    iso_tf_table table = {0};
    iso_tf_2d *tf_2d = NULL;
    iso_status status = ISO_OK;
    if (second != ISO_SECOND_VALUE_NONE && level > 0) {
        opt->fall_back = false;
        tf_2d = calloc(1, sizeof *tf_2d);
        status = tf_2d ? iso_adapt_tf_2d(p, level, second, &view->tf, opt, tf_2d, err)
                       : iso_fail(err, ISO_E_MEMORY, "adapt: out of memory");
    }
    TRY(status, iso_adapt_level(p, level, &view->tf, opt, &table, &judgment, err));
    if (status == ISO_OK && level > 0 && !a->extinction_scale)
        look_for_loss(a, level, &judgment);
    if (status == ISO_OK && judgment.given_back > 0)
        report_ghost(a, level, judgment.ghost, true);
    if (status == ISO_OK && a->cli && level > 0 && !opt->fall_back && !a->extinction_scale)
        status = look_for_ghost(a, p, level, &view->tf, &table, tf_2d, err);
    if (status != ISO_OK) {
        iso_tf_table_destroy(&table);
        iso_tf_2d_destroy(tf_2d);
        free(tf_2d);
        return status;
    }
    iso_tf_table_destroy(&view->tf);
    view->tf = table;
    view->tf_2d = tf_2d;
    return ISO_OK;
}

static iso_status adapt_view(const iso_cli_adapted *a, const char *path, const iso_pyramid *p, size_t level,
                             iso_view *view, int threads, iso_error *err)
{
    iso_adapt_options opt;
    const iso_second_value second = second_value(a);
    NEED(iso_cli_adapt_options(a, threads, &opt, err));
    if (a->extinction_scale)
        opt.fall_back = false;
    if (second != ISO_SECOND_VALUE_NONE)
        NEED(iso_words_check_range("--bits with --tf-2d", a->bits, 8, 12, err));
    opt.folder = iso_pyramid_is_one(path) ? path : NULL;
    return adapt(a, p, level, second, &opt, view, err);
}

static iso_status check_together(const iso_cli_adapted *a, iso_error *err)
{
    if (!a->wanted && has_method(a))
        return iso_fail(err, ISO_E_USAGE, "--tf-2d, --bits and --always go with --adapt");
    if (a->extinction_scale && a->tf_2d)
        return iso_fail(err, ISO_E_USAGE, "--extinction-scale needs a 1D transfer function, without --tf-2d");
    return ISO_OK;
}

/* Reports that a level was made for another transfer function than the view's. */
static void warn_of_other_tf(const iso_cli_adapted *a, const iso_pyramid *p, size_t level)
{
    if (!a->cli || a->cli->quiet)
        return;
    FREED char *scenes = iso_level_scene_names(p);
    iso_progress_line_hide(a->cli->progress);
    fprintf(stderr,
            "isoshade %s: warning: level %zu was made for the transfer function of %s and looks less like level 0 "
            "under another one; build without --for, or for this scene\n",
            a->cli->command->name, level, scenes && *scenes ? scenes : "another scene");
}

iso_status iso_cli_adapt_view(const iso_cli_adapted *a, const char *path, const iso_pyramid *p, size_t level,
                              iso_view *view, int threads, iso_error *err)
{
    OWNED(iso_tf_table) original = {0};
    bool is_made_for = false;
    const iso_level *l = level < p->level_count ? &p->levels[level] : NULL;
    const bool has_share = l && l->scale && l->geometry.has_no_data;
    NEED(check_together(a, err));
    if (a->extinction_scale && l && l->geometry.has_no_data)
        return iso_fail(err, ISO_E_RANGE,
                        "some voxels have no data, and the share that has scales the extinction of coarse levels; "
                        "leave out --extinction-scale");
    if (l)
        NEED(a->tf_2d ? has_share ? iso_view_take_scale(view, l, err) : ISO_OK
                      : iso_view_take_level(view, p, level, &is_made_for, err));
    if (is_made_for)
        return ISO_OK;
    if (l && (l->made_for_scene || l->scale) && !has_share)
        warn_of_other_tf(a, p, level);
    const bool scales = a->extinction_scale || (l && l->is_optimized && l->scale);
    if (scales)
        NEED(iso_tf_table_copy(&view->tf, &original, err));
    if (a->wanted)
        NEED(adapt_view(a, path, p, level, view, threads, err));
    if (scales)
        NEED(iso_extinction_scale_level(p, level, &original, &view->tf, threads, &view->extinction_scale, err));
    return ISO_OK;
}
