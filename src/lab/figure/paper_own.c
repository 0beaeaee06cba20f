/* SPDX-License-Identifier: MIT */
#include "lab/figure/paper_own.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/provenance.h"
#include "scene/viewpoint.h"

FILE *iso_paper_drawing(const iso_paper *p, size_t row, size_t column, const char *title, const char *note)
{
    const iso_page_box box = iso_paper_panel(p, row, column, title, note);
    FILE *gp = iso_page_plot_begin(p->page, &box);
    fprintf(gp,
            "thick(mm) = pen(72 / 25.4 * mm)\nunset border; unset tics; unset key\n"
            "set xrange [0:%.5f]; set yrange [0:%.5f]\n",
            box.width, box.height);
    return gp;
}

double iso_paper_tick_step(double range)
{
    const double decade = pow(10, floor(log10(range / 3)));
    return range / 3 >= 5 * decade ? 5 * decade : range / 3 >= 2 * decade ? 2 * decade : decade;
}

const char *iso_paper_volume_name(const iso_figure_job *job, const iso_paper_own *own)
{
    return job->input ? iso_provenance_title(job->input) : own->name;
}

iso_status iso_paper_load(const iso_figure_job *job, const iso_paper_own *own, const iso_pyramid_options *build,
                          iso_pyramid *p, iso_error *err)
{
    const iso_progress progress = iso_cli_progress(job->cli);
    iso_pyramid_options options = *build;
    OWNED(iso_volume) v = {0};
    options.threads = job->cli->threads;
    if (job->input) {
        iso_status status = iso_subject_load_pyramid(job->input, &job->volume, &options, &progress, p, err);
        TRY(status, iso_subject_refuse_labels(p, job->input, "this kind of figure", err));
        return status;
    }
    iso_status status = own->make(&v, err);
    TRY(status, iso_pyramid_build(&v, own->name, &options, p, &progress, err));
    return status;
}

static iso_status own_scene(const iso_figure_job *job, const iso_paper_look *own, const iso_pyramid *p,
                            iso_scene *scene, iso_error *err)
{
    const iso_cli_look *look = &job->look;
    iso_viewpoint from;
    size_t width = own->width, height = own->height;
    double zoom = job->input ? 1 : own->zoom;
    if (look->size)
        NEED(iso_subject_parse_image_size(look->size, &width, &height, err));
    if (look->zoom)
        NEED(iso_cli_zoom_parse(look->zoom, &zoom, err));
    NEED(iso_viewpoint_parse(look->view ? look->view : own->view, &from, err));
    iso_tf_point *points = malloc(own->point_count * sizeof *points);
    NEED_MEMORY(points, err, "figure: out of memory");
    memcpy(points, own->points, own->point_count * sizeof *points);
    *scene = iso_scene_first(&p->levels[0].geometry, &from, width, height);
    scene->zoom = zoom;
    scene->shading = own->shading;
    for (int c = 0; c < 3; ++c)
        scene->background[c] = 1;
    scene->tf = (iso_tf){.fit_range = true,
                         .unit_distance = 1,
                         .unit_is_voxels = true,
                         .table_size = 256,
                         .point_count = own->point_count,
                         .points = points};
    return ISO_OK;
}

iso_status iso_paper_scene(const iso_figure_job *job, const iso_paper_look *own, const iso_pyramid *p, iso_scene *scene,
                           iso_error *err)
{
    iso_subject_look look;
    NEED(iso_cli_look_check(&job->look, job->cli->threads, &look, err));
    const iso_status made = look.scene || look.tf ? iso_subject_make_scene(&look, p, scene, err)
                                                  : own_scene(job, own, p, scene, err);
    if (job->has_background)
        memcpy(scene->background, job->background, sizeof scene->background);
    return made;
}
