/* SPDX-License-Identifier: MIT */
#include "options/roi.h"

#include <stdlib.h>

#include "options/cli.h"
#include "tf/level_look.h"

const iso_option iso_roi_rows[] = {
    {"roi", 0, "show a finer level in this box of level-0 voxels", "X0,Y0,Z0,X1,Y1,Z1", ISO_IN(iso_cli_roi, box)},
    {"roi-level", 0, "level inside the box (0)", "J", ISO_IN(iso_cli_roi, level)},
    {"roi-band", 0, "blended band around the box, in voxels; 0: hard edge", "VOXELS", ISO_IN(iso_cli_roi, band),
     .flags = ISO_SHOWN},
    ISO_OPTIONS_END,
};

static iso_status parse_box(const char *text, double lo[3], double hi[3], iso_error *err)
{
    const char *at = text;
    for (int i = 0; i < 6; ++i) {
        char *end;
        (i < 3 ? lo : hi)[i % 3] = strtod(at, &end);
        if (end == at || *end != (i < 5 ? ',' : '\0'))
            return iso_fail(err, ISO_E_USAGE,
                            "--roi is \"%s\", must be six numbers: x0,y0,z0,x1,y1,z1 in voxels of level 0", text);
        at = end + 1;
    }
    return ISO_OK;
}

/* Makes the table for the level inside: the scene's, or adapted to the level. */
static iso_status roi_tf(const iso_cli_roi_place *at, size_t level, const iso_tf_table *tf, iso_tf_table *table,
                         iso_error *err)
{
    iso_adapt_options opt;
    bool is_made_for = false;
    iso_status status = iso_level_look(at->pyramid, level, tf, table, &is_made_for, err);
    if (status == ISO_OK && at->pyramid->levels[level].scale)
        status = iso_fail(err, ISO_E_USAGE, "--roi-level %zu: the level has an extinction scale; use level 0", level);
    if (status != ISO_OK || is_made_for)
        return status;
    if (!at->adapted->wanted)
        level = 0; /* copies the table */
    status = iso_cli_adapt_options(at->adapted, at->threads, &opt, err);
    opt.folder = iso_pyramid_is_one(at->path) ? at->path : NULL;
    return status == ISO_OK ? iso_adapt_level(at->pyramid, level, tf, &opt, table, NULL, err) : status;
}

iso_status iso_cli_roi_view(const iso_cli_roi *r, const iso_cli_roi_place *at, iso_view *view, iso_error *err)
{
    const size_t level = at->level;
    iso_roi_options opt = iso_roi_defaults();
    OWNED(iso_tf_table) table = {0};
    if (!r->box && (r->level != 0 || r->band != opt.band))
        return iso_fail(err, ISO_E_USAGE, "--roi-level and --roi-band need --roi");
    if (!r->box)
        return ISO_OK;
    NEED(parse_box(r->box, opt.lo, opt.hi, err));
    NEED(iso_words_check_range("--roi-band", r->band, 0, 64, err));
    if (level < 1)
        return iso_fail(err, ISO_E_USAGE, "--roi needs a coarser level around the box: --level 1 or more");
    NEED(iso_words_check_range("--roi-level", r->level, 0, (double)level - 1, err));
    opt.level = (size_t)r->level;
    opt.band = r->band;
    NEED(roi_tf(at, opt.level, &view->tf, &table, err));
    if (!(view->roi = calloc(1, sizeof *view->roi)))
        return iso_fail(err, ISO_E_MEMORY, "region of interest: out of memory");
    return iso_roi_create(at->pyramid, level, &table, &opt, view->roi, err);
}
