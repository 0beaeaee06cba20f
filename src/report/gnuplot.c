/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "report/gnuplot.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/process.h"

ISO_EMBED(iso_gnuplot_style_gp, "src/report/style.gp");

static iso_status write_beside(const char *dir, const char *name, const char *ending, const char *content,
                               iso_error *err)
{
    char *path = NULL;
    if (asprintf(&path, "%s/%s%s", dir, name, ending) < 0)
        return iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    iso_status status = iso_file_write(path, content, strlen(content), err);
    free(path);
    return status;
}

iso_status iso_gnuplot_check_whole(const char *picture, const char *format, iso_error *err)
{
    const char *last = strcmp(format, "pdf") == 0 ? "%%EOF" : strcmp(format, "png") == 0 ? "IEND" : "</svg>";
    enum { tail = 32 };
    char *data = NULL;
    size_t size = 0;
    iso_status status = iso_file_read(picture, &data, &size, err);
    bool whole = status == ISO_OK && size >= tail && memmem(data + size - tail, tail, last, strlen(last));
    if (status == ISO_OK && !whole)
        status = iso_fail(err, ISO_E_IO, "%s: gnuplot left it incomplete; is the disk full?", picture);
    free(data);
    return status;
}

static iso_status run_gnuplot(const char *dir, const char *name, const char *format, iso_error *err)
{
    char *gnuplot = NULL, *script = NULL, *setting = NULL, *picture = NULL;
    iso_status status = iso_process_find("gnuplot", "gnuplot-nox", &gnuplot, err);
    if (status != ISO_OK)
        return status;
    if (asprintf(&script, "%s.gp", name) < 0)
        script = NULL;
    if (asprintf(&setting, "format='%s'", format) < 0)
        setting = NULL;
    if (asprintf(&picture, "%s/%s.%s", dir, name, format) < 0)
        picture = NULL;
    if (script && setting && picture) {
        const char *argv[] = {gnuplot, "-d", "-e", setting, script, NULL};
        status = iso_process_run(argv, &(iso_process_options){.directory = dir, .timeout_seconds = 600}, err);
        if (status == ISO_OK && !iso_path_exists(picture))
            status = iso_fail(err, ISO_E_PROGRAM, "%s: gnuplot left no picture", picture);
        if (status == ISO_OK)
            status = iso_gnuplot_check_whole(picture, format, err);
    } else {
        status = iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    }
    free(gnuplot);
    free(script);
    free(setting);
    free(picture);
    return status;
}

iso_status iso_gnuplot_draw(const char *dir, const char *name, const char *csv, const char *script, const char *format,
                            iso_error *err)
{
    char *style = iso_path_join(dir, "style.gp");
    if (!style)
        return iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    iso_status status = ISO_OK;
    if (!iso_path_exists(style))
        status = write_beside(dir, "style", ".gp", iso_gnuplot_style_gp, err);
    free(style);
    if (status == ISO_OK)
        status = write_beside(dir, name, ".csv", csv, err);
    if (status == ISO_OK)
        status = write_beside(dir, name, ".gp", script, err);
    if (status == ISO_OK)
        status = run_gnuplot(dir, name, format, err);
    return status;
}
