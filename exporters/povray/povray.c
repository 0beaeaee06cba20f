/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "povray/povray.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "povray/povray_files.h"

iso_povray_options iso_povray_defaults(void)
{
    return (
        iso_povray_options){.intervals = ISO_POVRAY_MAX_INTERVALS, .planes = 8, .extrapolate = true, .df3_bits = 32};
}

void iso_povray_set_step(const iso_geometry *g, const iso_view *view, double step_voxels, iso_povray_options *o)
{
    double chord_voxels = 2 * iso_geometry_box_radius_mm(g) /
                          iso_geometry_min_spacing_mm(iso_view_step_geometry(view, g));
    double intervals = chord_voxels / step_voxels, most = ISO_POVRAY_MAX_INTERVALS;
    double pieces = fmin(fmax(ceil(intervals / most), 1), ISO_POVRAY_MAX_PLANES + 1);
    o->intervals = (size_t)fmin(fmax(ceil(intervals / pieces), 1), most);
    o->planes = (size_t)pieces - 1;
    o->extrapolate = false;
}

iso_status iso_povray_check(const iso_pyramid *p, size_t level, const iso_view *view, const iso_povray_options *opt,
                            iso_error *err)
{
    if (level >= p->level_count)
        return iso_fail(err, ISO_E_RANGE, "povray: level %zu, the pyramid has 0 to %zu", level, p->level_count - 1);
    if (opt->intervals < 2 || opt->intervals > ISO_POVRAY_MAX_INTERVALS)
        return iso_fail(err, ISO_E_RANGE, "povray: %zu intervals, must be 2 to %d", opt->intervals,
                        ISO_POVRAY_MAX_INTERVALS);
    if (opt->planes > ISO_POVRAY_MAX_PLANES)
        return iso_fail(err, ISO_E_RANGE, "povray: %zu planes, at most %d", opt->planes, ISO_POVRAY_MAX_PLANES);
    if (opt->df3_bits != 16 && opt->df3_bits != 32)
        return iso_fail(err, ISO_E_RANGE, "povray: DF3 files of %u bits, must be 16 or 32", opt->df3_bits);
    if (opt->isosurface && !isfinite(opt->iso))
        return iso_fail(err, ISO_E_RANGE, "povray: the isosurface's value is %g, must be finite", opt->iso);
    if (opt->isosurface && view->roi)
        return iso_fail(err, ISO_E_USAGE, "povray: an isosurface cannot have a region of interest");
    if (opt->isosurface && p->levels[level].geometry.has_no_data)
        return iso_fail(err, ISO_E_USAGE,
                        "povray: some voxels have no data, whose edge would be a surface; --with "
                        "reference draws the isosurface");
    if (p->levels[level].labels && (opt->isosurface || view->roi || view->tf_2d))
        return iso_fail(err, ISO_E_USAGE,
                        "povray: a label map has no surface, region of interest or 2D transfer function");
    if (opt->float_directions && !p->levels[level].directions)
        return iso_fail(err, ISO_E_RANGE, "povray: level %zu has no float directions; build the pyramid with them",
                        level);
    if (view->tf.count < 2 || !(view->tf.hi > view->tf.lo))
        return iso_fail(err, ISO_E_RANGE, "povray: the transfer function has %zu entries from %g to %g", view->tf.count,
                        view->tf.lo, view->tf.hi);
    return ISO_OK;
}

iso_status iso_povray_export(const iso_pyramid *p, size_t level, const iso_view *view, const char *dir,
                             const iso_povray_options *opt, const iso_progress *progress, iso_error *err)
{
    NEED(iso_povray_check(p, level, view, opt, err));
    FREED char *name = iso_path_plain_name(dir);
    if (!name)
        return iso_povray_no_memory(err);
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    iso_povray_prepared s;
    iso_status status = iso_povray_prepare(p, level, view, name, opt, &s, err);
    if (status == ISO_OK)
        status = iso_output_begin_dir(&out, dir, "*.ini", err); /* any name: the folder may have been renamed */
    if (status == ISO_OK) {
        status = iso_povray_write_files(&s, out.temp_path, progress, err);
        TRY(status, iso_output_commit(&out, err));
    }
    iso_povray_release(&s);
    return status;
}
