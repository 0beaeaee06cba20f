/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "report/gnuplot.h"

#include <ctype.h>
#include <stdbool.h>
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
    FREED char *path = NULL;
    if (asprintf(&path, "%s/%s%s", dir, name, ending) < 0)
        return iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    return iso_file_write(path, content, strlen(content), err);
}

/* First and last bytes of a picture file. */
static const struct {
    const char *format, *first, *last;
} forms[] = {
    {"png", "\x89PNG", "IEND"},
    {"svg", "<?xml", "</svg>"},
    {"pdf", "%PDF", "%%EOF"},
    {"tex", "% GNUPLOT", "\\endgroup"},
};

/* Checks the written picture: gnuplot may report success without one, or with another file, and ignores a full disk. */
static iso_status check_content(const char *picture, const char *format, const char *data, size_t size, iso_error *err)
{
    enum { TAIL = 32 };
    size_t f = 0;
    while (strcmp(forms[f].format, format) != 0)
        ++f;
    if (size == 0)
        return iso_fail(err, ISO_E_PROGRAM, "%s: gnuplot wrote no picture", picture);
    if (size < strlen(forms[f].first) || memcmp(data, forms[f].first, strlen(forms[f].first)) != 0)
        return iso_fail(err, ISO_E_PROGRAM, "%s: gnuplot wrote a file that is not %s", picture, format);
    if (size < TAIL || !memmem(data + size - TAIL, TAIL, forms[f].last, strlen(forms[f].last)))
        return iso_fail(err, ISO_E_IO, "%s: gnuplot wrote an incomplete picture; check the free disk space", picture);
    return ISO_OK;
}

static iso_status check_picture(const char *picture, const char *format, iso_error *err)
{
    FREED char *data = NULL;
    size_t size = 0;
    if (!iso_path_is_file(picture))
        return iso_fail(err, ISO_E_PROGRAM, "%s: gnuplot wrote no picture", picture);
    NEED(iso_file_read(picture, &data, &size, err));
    return check_content(picture, format, data, size, err);
}

/* A terminal that gnuplot opens before it reads the script. One with windows fails in the sandbox. */
static const char foreign_setting[] = "GNUTERM";

static iso_status run_gnuplot(const char *dir, const char *name, const char *format, iso_error *err)
{
    FREED char *gnuplot = NULL, *script = NULL, *setting = NULL, *picture = NULL;
    NEED(iso_process_find("gnuplot", "gnuplot-nox", &gnuplot, err));
    /* "overlay" draws a PNG without its pictures (figure/page.h); charts have none. */
    if (asprintf(&script, "%s.gp", name) < 0 ||
        asprintf(&setting, "format='%s'%s", format, strcmp(format, "png") == 0 ? "; overlay=1" : "") < 0 ||
        asprintf(&picture, "%s/%s%s.%s", dir, name, strcmp(format, "tex") == 0 ? "-latex" : "", format) < 0)
        return iso_fail(err, ISO_E_MEMORY, "chart: out of memory");
    const char *argv[] = {gnuplot, "-d", "-e", setting, script, NULL};
    const iso_process_options process = {.directory = dir,
                                         .sandbox = {.without = foreign_setting},
                                         .timeout_seconds = 600};
    NEED(iso_process_run(argv, &process, err));
    return check_picture(picture, format, err);
}

iso_status iso_gnuplot_use_style(const char *from, const char *dir, iso_error *err)
{
    FREED char *content = NULL, *path = iso_path_join(dir, "style.gp");
    size_t size = 0;
    NEED(path ? iso_file_read(from, &content, &size, err) : iso_fail(err, ISO_E_MEMORY, "chart: out of memory"));
    return iso_file_write(path, content, size, err);
}

iso_status iso_gnuplot_draw_script(const char *dir, const char *name, const char *script, const char *format,
                                   iso_error *err)
{
    FREED char *style = iso_path_join(dir, "style.gp");
    NEED_MEMORY(style, err, "chart: out of memory");
    if (!iso_path_exists(style))
        NEED(write_beside(dir, "style", ".gp", iso_gnuplot_style_gp, err));
    NEED(write_beside(dir, name, ".gp", script, err));
    return run_gnuplot(dir, name, format, err);
}

iso_status iso_gnuplot_draw(const char *dir, const char *name, const char *csv, const char *script, const char *format,
                            iso_error *err)
{
    const iso_status status = write_beside(dir, name, ".csv", csv, err);
    return status == ISO_OK ? iso_gnuplot_draw_script(dir, name, script, format, err) : status;
}

/* ---- one picture alone ----------------------------------------------------------------------------------------------- */

void iso_gnuplot_put_quoted(FILE *gp, const char *text)
{
    bool is_escaped = false;
    fputc('"', gp);
    for (; *text; ++text) {
        const unsigned char c = (unsigned char)*text;
        /* gnuplot 5.4 reads all following digits as part of the escape */
        is_escaped = !(c >= 0x80 || isalpha(c) || strchr(" ./_-", c) || (isdigit(c) && !is_escaped));
        fprintf(gp, is_escaped ? "\\%03o" : "%c", c);
    }
    fputc('"', gp);
}

const char *iso_gnuplot_ending(const char *output)
{
    static const char *const endings[] = {"png", "svg", "pdf"};
    char ending[8];
    for (size_t i = 0; i < sizeof endings / sizeof *endings; ++i) {
        snprintf(ending, sizeof ending, ".%s", endings[i]);
        if (iso_path_ends_with(output, ending))
            return endings[i];
    }
    return NULL;
}

static void put_terminal(FILE *gp, const char *format, double width, double height)
{
    if (strcmp(format, "png") == 0)
        fprintf(gp, "set terminal pngcairo size %.0f,%.0f font 'DejaVu Sans,10' fontscale 2 linewidth 2 pointscale 2\n",
                2 * width, 2 * height);
    else if (strcmp(format, "pdf") == 0)
        fprintf(gp, "set terminal pdfcairo size %.3f,%.3f font 'DejaVu Sans,10' rounded\n", width / 96, height / 96);
    else
        fprintf(gp, "set terminal svg size %.0f,%.0f font 'DejaVu Sans,sans-serif,13' background '#ffffff'\n", width,
                height);
}

static iso_status write_script(const char *path, const char *format, const char *picture, double width, double height,
                               iso_gnuplot_writer write, void *user, iso_error *err)
{
    FILE *gp = fopen(path, "w");
    if (!gp)
        return iso_fail(err, ISO_E_IO, "%s: cannot be written", path);
    put_terminal(gp, format, width, height);
    fputs("set encoding utf8\nset output ", gp);
    iso_gnuplot_put_quoted(gp, picture);
    fputc('\n', gp);
    const iso_status written = write(gp, user, err);
    const bool failed = ferror(gp) != 0; /* an incomplete script would draw another picture */
    const bool is_whole = fclose(gp) == 0 && !failed;
    NEED(written);
    return is_whole ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be written", path);
}

iso_status iso_gnuplot_picture(const char *output, double width, double height, iso_gnuplot_writer write, void *user,
                               iso_error *err)
{
    FREED char *gnuplot = NULL;
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    const char *format = iso_gnuplot_ending(output);
    if (!format)
        return iso_fail(err, ISO_E_USAGE, "\"%s\" must end with .png or .svg or .pdf", output);
    NEED(iso_process_find("gnuplot", "gnuplot-nox", &gnuplot, err));
    ENDED_BY(iso_end_temp_dir) char *dir = iso_make_temp_dir();
    if (!dir)
        return iso_temp_dir_fail(err);
    FREED char *script = iso_path_join(dir, "picture.gp");
    NEED(script ? iso_output_begin(&out, output, err) : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    NEED(write_script(script, format, out.temp_path, width, height, write, user, err));
    const iso_process_options process = {.sandbox = {.output = out.temp_path, .without = foreign_setting},
                                         .timeout_seconds = 600};
    NEED(iso_process_run((const char *[]){gnuplot, "-d", script, NULL}, &process, err));
    NEED(check_picture(out.temp_path, format, err));
    return iso_output_commit(&out, err);
}
