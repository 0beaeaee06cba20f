/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "povray/povray.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/parallel.h"
#include "base/process.h"
#include "povray/scene_text.h"
#include "scene/roi.h"

iso_povray_options iso_povray_defaults(void)
{
    return (iso_povray_options){.intervals = ISO_POVRAY_MAX_INTERVALS, .planes = 8, .extrapolate = true, .df3_bits = 32};
}

static iso_status find_povray(char **path, iso_error *err)
{
    return iso_process_find("povray", "povray", path, err);
}

typedef struct version_search {
    char *version;
    size_t size;
} version_search;

/* "POV-Ray 3.7.0.10.unofficial" */
static void take_version(void *user, const char *line)
{
    version_search *search = user;
    static const char prefix[] = "POV-Ray ";
    if (search->version[0] || strncmp(line, prefix, sizeof prefix - 1) != 0 || !isdigit((unsigned char)line[sizeof prefix - 1]))
        return;
    const char *number = line + sizeof prefix - 1;
    size_t length = strspn(number, "0123456789.");
    while (length > 0 && number[length - 1] == '.')
        --length;
    snprintf(search->version, search->size, "%.*s", (int)length, number);
}

iso_status iso_povray_version(char *version, size_t size, iso_error *err)
{
    char *program = NULL;
    version[0] = 0;
    iso_status status = find_povray(&program, err);
    if (status != ISO_OK)
        return status;
    version_search search = {version, size};
    const char *argv[] = {program, "--version", NULL};
    const iso_process_options options = {.line = take_version, .user = &search, .timeout_seconds = 60};
    status = iso_process_run(argv, &options, err);
    if (status == ISO_OK && !version[0])
        status = iso_fail(err, ISO_E_PROGRAM, "%s: --version names no version of POV-Ray", program);
    free(program);
    return status;
}

static iso_status check_options(const iso_pyramid *p, size_t level, const iso_view *view, const iso_povray_options *opt,
                                iso_error *err)
{
    if (level >= p->level_count)
        return iso_fail(err, ISO_E_RANGE, "povray: level %zu, the pyramid has 0 to %zu", level, p->level_count - 1);
    if (opt->intervals < 2 || opt->intervals > ISO_POVRAY_MAX_INTERVALS)
        return iso_fail(err, ISO_E_RANGE, "povray: %zu intervals, must be 2 to %d", opt->intervals, ISO_POVRAY_MAX_INTERVALS);
    if (opt->planes > ISO_POVRAY_MAX_PLANES)
        return iso_fail(err, ISO_E_RANGE, "povray: %zu planes, at most %d", opt->planes, ISO_POVRAY_MAX_PLANES);
    if (opt->df3_bits != 16 && opt->df3_bits != 32)
        return iso_fail(err, ISO_E_RANGE, "povray: DF3 files of %u bits, must be 16 or 32", opt->df3_bits);
    if (opt->isosurface && !isfinite(opt->iso))
        return iso_fail(err, ISO_E_RANGE, "povray: the isosurface's value is %g, must be finite", opt->iso);
    if (opt->isosurface && view->roi)
        return iso_fail(err, ISO_E_USAGE, "povray: a region of interest is no surface");
    if (opt->float_directions && !p->levels[level].directions)
        return iso_fail(err, ISO_E_RANGE, "povray: level %zu has no float directions; build the pyramid with them", level);
    if (view->tf.count < 2 || !(view->tf.hi > view->tf.lo))
        return iso_fail(err, ISO_E_RANGE, "povray: the transfer function has %zu entries from %g to %g", view->tf.count,
                        view->tf.lo, view->tf.hi);
    return ISO_OK;
}

/* Whole samples where the type has them. */
static iso_df3_coding scalar_coding(const iso_level *level, unsigned bits)
{
    switch (level->stored_type) {
    case ISO_U8: return (iso_df3_coding){8, 0, 255};
    case ISO_I8: return (iso_df3_coding){8, -128, 127};
    case ISO_U16: return (iso_df3_coding){16, 0, 65535};
    case ISO_I16: return (iso_df3_coding){16, -32768, 32767};
    default: return (iso_df3_coding){bits, level->min, level->max > level->min ? level->max : level->min + 1};
    }
}

/* A whole sample stands for 0: 128 of 255, 32768 of 65535, 2^31 of 2^32 - 1. */
static iso_df3_coding direction_coding(unsigned bits)
{
    double half = ldexp(1, (int)bits - 1);
    return (iso_df3_coding){bits, -half / (half - 1), 1};
}

static bool is_byte_lattice(iso_code code)
{
    const iso_code_info *info = iso_code_describe(code);
    return info->is_textured && info->is_signed && info->is_linear;
}

/* No slope of the trilinear field is steeper: in each cell at most the steepest of its edges along each axis. */
static double steepest(const iso_level *level)
{
    const size_t *n = level->geometry.size;
    const size_t step[3] = {1, n[0], n[0] * n[1]};
    double most = 0;
    for (size_t z = 0; z + 1 < n[2] || z == 0; ++z)
        for (size_t y = 0; y + 1 < n[1] || y == 0; ++y)
            for (size_t x = 0; x + 1 < n[0] || x == 0; ++x) {
                const size_t at = x + n[0] * (y + n[1] * z);
                double square = 0;
                for (int a = 0; a < 3; ++a) {
                    const int b = (a + 1) % 3, c = (a + 2) % 3;
                    const size_t along = n[a] > 1 ? step[a] : 0, u = n[b] > 1 ? step[b] : 0, v = n[c] > 1 ? step[c] : 0;
                    const size_t edges[4] = {at, at + u, at + v, at + u + v};
                    double edge = 0;
                    for (int e = 0; e < 4; ++e)
                        edge = fmax(edge, fabs((double)level->scalar[edges[e] + along] - (double)level->scalar[edges[e]]));
                    square += edge * edge;
                }
                most = fmax(most, square);
            }
    return sqrt(most);
}

/* Letters, digits, "-" and "_": nothing that needs a quote in POV-Ray's files or in a shell. */
static char *scene_name(const char *dir)
{
    size_t end = strlen(dir);
    while (end > 0 && dir[end - 1] == '/')
        --end;
    size_t start = end;
    while (start > 0 && dir[start - 1] != '/')
        --start;
    char *name = end > start ? strndup(dir + start, end - start) : strdup("volume");
    for (char *c = name; c && *c; ++c)
        if (!isalnum((unsigned char)*c) && *c != '-' && *c != '_')
            *c = '_';
    return name;
}

/* The path of "dir/name_suffix". */
static char *file_path(const char *dir, const char *name, const char *suffix)
{
    size_t size = strlen(dir) + strlen(name) + strlen(suffix) + 2;
    char *path = malloc(size);
    if (path)
        snprintf(path, size, "%s/%s%s", dir, name, suffix);
    return path;
}

static iso_status no_memory(iso_error *err)
{
    return iso_fail(err, ISO_E_MEMORY, "povray: no memory");
}

static iso_status write_directions(const iso_level *level, iso_code code, const iso_povray_scene *s, const char *dir,
                                   const iso_progress *progress, iso_error *err)
{
    const size_t count = iso_geometry_voxel_count(&level->geometry);
    float *decoded = NULL;
    const float *directions = level->directions;
    if (!s->options->float_directions) {
        directions = decoded = malloc(3 * count * sizeof *decoded);
        if (!decoded)
            return iso_fail(err, ISO_E_MEMORY, "povray: no memory for %zu directions", count);
        iso_code_decode_all(code, level->codes, decoded, count);
    }
    static const char *const suffix[3] = {"_dx.df3", "_dy.df3", "_dz.df3"};
    iso_status status = ISO_OK;
    for (size_t a = 0; a < 3 && status == ISO_OK; ++a) {
        iso_progress_report(progress, "povray: writing DF3", 0.25 * (double)(a + 1));
        char *path = file_path(dir, s->name, suffix[a]);
        status = path ? iso_df3_write(path, level->geometry.size, directions, 3, a, &s->direction, err) : no_memory(err);
        free(path);
    }
    free(decoded);
    return status;
}

/* The entries of all classes, row by row; to be freed. */
static float *class_rows(const iso_tf_2d *tf_2d)
{
    const size_t row = 4 * tf_2d->tables[0].count;
    float *rows = malloc(ISO_TF_2D_ROWS * row * sizeof *rows);
    for (size_t c = 0; rows && c < ISO_TF_2D_ROWS; ++c)
        memcpy(rows + c * row, tf_2d->tables[c].entries, row * sizeof *rows);
    return rows;
}

static iso_status write_class_bytes(const iso_povray_scene *s, const char *dir, iso_error *err)
{
    const size_t count = iso_geometry_voxel_count(&s->voxels->geometry);
    const iso_df3_coding coding = {8, 0, 255};
    float *values = malloc(count * sizeof *values);
    char *path = file_path(dir, s->name, "_class.df3");
    iso_status status = values && path ? ISO_OK : no_memory(err);
    for (size_t i = 0; i < count && status == ISO_OK; ++i)
        values[i] = s->tf_2d->bytes[i];
    if (status == ISO_OK)
        status = iso_df3_write(path, s->voxels->geometry.size, values, 1, 0, &coding, err);
    free(path);
    free(values);
    return status;
}

static iso_status write_tf_tables(const iso_povray_scene *s, const char *dir, iso_error *err)
{
    static const char *const suffix[4] = {"_tf_red.df3", "_tf_green.df3", "_tf_blue.df3", "_tf_extinction.df3"};
    const iso_tf_2d *tf_2d = s->tf_2d;
    float *rows = tf_2d ? class_rows(tf_2d) : NULL;
    if (tf_2d && !rows)
        return no_memory(err);
    double most[4] = {s->peak_color, s->peak_color, s->peak_color, s->peak_extinction};
    iso_status status = tf_2d ? write_class_bytes(s, dir, err) : ISO_OK;
    for (size_t c = 0; c < 4 && status == ISO_OK; ++c) {
        if (!iso_povray_needs_tables(s, c < 3))
            continue;
        const iso_df3_coding coding = {32, 0, most[c]};
        char *path = file_path(dir, s->name, suffix[c]);
        status = path ? iso_df3_write_table(path, rows ? rows : s->tf->entries, s->tf->count, rows ? ISO_TF_2D_ROWS : 1, 4, c, &coding, err)
                      : no_memory(err);
        free(path);
    }
    free(rows);
    return status;
}

static iso_status write_text(const iso_povray_scene *s, const char *dir, const char *suffix,
                             void (*write)(FILE *, const iso_povray_scene *), iso_error *err)
{
    char *path = file_path(dir, s->name, suffix);
    FILE *file = path ? fopen(path, "w") : NULL;
    iso_status status = ISO_OK;
    if (file) {
        write(file, s);
        bool failed = ferror(file) != 0;
        if (fclose(file) != 0 || failed)
            status = iso_fail(err, ISO_E_IO, "%s: cannot be written: %s", path, strerror(errno));
    } else {
        status = path ? iso_fail(err, ISO_E_IO, "%s: cannot be written: %s", path, strerror(errno)) : no_memory(err);
    }
    free(path);
    return status;
}

/* level: the voxels, of the pyramid's level or of a region of interest; tf: what bounds the transfer function. */
static iso_povray_scene describe(const iso_pyramid *p, size_t number, const iso_level *level, const iso_view *view,
                                 const iso_tf_table *tf, const char *name, const iso_povray_options *opt)
{
    const iso_geometry *g = &p->levels[number].geometry;
    iso_povray_scene s = {.name = name, .source = p->source ? iso_path_base(p->source) : "a volume", .level = number,
                          .geometry = g, .voxels = level, .lattice_scale = 1, .view = view, .tf = tf, .options = opt};
    s.scalar = scalar_coding(level, opt->df3_bits);
    s.direction = direction_coding(!opt->float_directions && is_byte_lattice(p->options.code) ? 8 : opt->df3_bits);
    s.center_mm = iso_geometry_box_center_mm(g);
    s.units_per_mm = 0.5 * ISO_POVRAY_UNITS_ACROSS / iso_geometry_box_radius_mm(g);
    iso_povray_measure_peaks(&s);
    /* 1 %: the solver divides by it, and rounds. A constant field has no slope at all. */
    if (opt->isosurface)
        s.max_gradient = fmax(1.01 * steepest(level) / (s.scalar.hi - s.scalar.lo), 1e-6);
    return s;
}

/* A scene with what it points to. */
typedef struct prepared_scene {
    iso_povray_scene scene, inner;
    iso_tf_table envelope; /* of the view's classes */
    char *inner_name;
} prepared_scene;

static void release(prepared_scene *s)
{
    iso_tf_table_destroy(&s->envelope);
    free(s->inner_name);
}

static iso_status prepare(const iso_pyramid *p, size_t level, const iso_view *view, const char *name, const iso_povray_options *opt,
                          prepared_scene *s, iso_error *err)
{
    const iso_roi *f = opt->isosurface ? NULL : view->roi;
    *s = (prepared_scene){0};
    const iso_tf_2d *tf_2d = opt->isosurface ? NULL : view->tf_2d; /* a surface takes its colour from the view's TF */
    iso_status status = tf_2d ? iso_tf_2d_envelope(tf_2d, &s->envelope, err) : ISO_OK;
    if (status == ISO_OK && f && asprintf(&s->inner_name, "%s_fine", name) < 0) {
        s->inner_name = NULL;
        status = no_memory(err);
    }
    if (status != ISO_OK) {
        release(s);
        return status;
    }
    s->scene = describe(p, level, &p->levels[level], view, tf_2d ? &s->envelope : &view->tf, name, opt);
    s->scene.tf_2d = tf_2d;
    if (f) {
        s->inner = describe(p, level, &f->level, view, &f->tf, s->inner_name, opt);
        s->inner.lattice_scale = f->scale;
        memcpy(s->inner.lattice_offset, f->offset, sizeof f->offset);
        s->scene.inner = &s->inner;
        s->scene.peak = fmax(s->scene.peak, s->inner.peak);
    }
    return ISO_OK;
}

/* The data of one layer: values, directions, and tables where the TF needs them. */
static iso_status write_layer(const iso_pyramid *p, const iso_povray_scene *s, const char *dir, const iso_progress *progress,
                              iso_error *err)
{
    char *path = file_path(dir, s->name, "_scalar.df3");
    iso_status status = path ? iso_df3_write(path, s->voxels->geometry.size, s->voxels->scalar, 1, 0, &s->scalar, err) : no_memory(err);
    free(path);
    if (status == ISO_OK)
        status = write_directions(s->voxels, p->options.code, s, dir, progress, err);
    if (status == ISO_OK && !s->options->isosurface)
        status = write_tf_tables(s, dir, err);
    return status;
}

/* All files of a scene into a folder that exists. */
static iso_status write_all(const iso_pyramid *p, const iso_povray_scene *s, const char *dir, const iso_progress *progress,
                            iso_error *err)
{
    iso_progress_report(progress, "povray: writing DF3", 0);
    iso_status status = write_layer(p, s, dir, progress, err);
    if (status == ISO_OK && s->inner)
        status = write_layer(p, s->inner, dir, progress, err);
    if (status == ISO_OK)
        status = write_text(s, dir, ".inc", iso_povray_write_include, err);
    if (status == ISO_OK)
        status = write_text(s, dir, ".pov", iso_povray_write_scene, err);
    if (status == ISO_OK)
        status = write_text(s, dir, ".ini", iso_povray_write_ini, err);
    iso_progress_report(progress, "povray: writing DF3", 1);
    return status;
}

iso_status iso_povray_export(const iso_pyramid *p, size_t level, const iso_view *view, const char *dir,
                             const iso_povray_options *opt, const iso_progress *progress, iso_error *err)
{
    iso_status status = check_options(p, level, view, opt, err);
    if (status != ISO_OK)
        return status;
    char *name = scene_name(dir), *marker = name ? file_path("", name, ".ini") : NULL;
    if (!marker) {
        free(name);
        return no_memory(err);
    }
    iso_output out = {0};
    prepared_scene s;
    status = prepare(p, level, view, name, opt, &s, err);
    if (status == ISO_OK)
        status = iso_output_begin_dir(&out, dir, marker + 1, err);
    if (status == ISO_OK) {
        status = write_all(p, &s.scene, out.temp_path, progress, err);
        if (status == ISO_OK)
            status = iso_output_commit(&out, err);
    }
    iso_output_abandon(&out);
    release(&s);
    free(marker);
    free(name);
    return status;
}

/* One run of POV-Ray among several, for the progress. */
typedef struct run_progress {
    const iso_progress *progress;
    double from, to;
    iso_povray_stats *stats; /* or NULL */
    bool after_trace;        /* the next line says how long all threads took */
} run_progress;

/* "Rendered 1234 of 2304 pixels (53%)", and "  Trace Time:       0 hours  0 minutes  1 seconds (1.234 seconds)" followed by
 * "              using 2 thread(s) with 2.345 CPU-seconds total" */
static void take_progress(void *user, const char *line)
{
    run_progress *run = user;
    size_t done, total, threads;
    const char *at = strstr(line, "Rendered ");
    if (at && sscanf(at, "Rendered %zu of %zu pixels", &done, &total) == 2 && total > 0)
        iso_progress_report(run->progress, "povray: rendering",
                            run->from + (run->to - run->from) * (double)done / (double)total);
    double seconds;
    if (!run->stats)
        return;
    if (run->after_trace && sscanf(line, " using %zu thread(s) with %lf CPU-seconds", &threads, &seconds) == 2)
        run->stats->processor_seconds += seconds;
    run->after_trace = strstr(line, "Trace Time:") != NULL;
    at = run->after_trace ? strchr(line, '(') : NULL;
    if (at && sscanf(at, "(%lf seconds)", &seconds) == 1)
        run->stats->trace_seconds += seconds;
}

static iso_status run_povray(const char *program, const char *dir, const iso_view *view, iso_povray_pass pass,
                             size_t intervals, const iso_povray_options *opt, run_progress *run, iso_image *image,
                             iso_error *err)
{
    char width[32], height[32], threads[48], declare_pass[48], declare_intervals[48];
    snprintf(width, sizeof width, "Width=%zu", view->width);
    snprintf(height, sizeof height, "Height=%zu", view->height);
    snprintf(threads, sizeof threads, "Work_Threads=%d", iso_threads(opt->threads));
    snprintf(declare_pass, sizeof declare_pass, "Declare=Iso_Pass=%d", (int)pass);
    snprintf(declare_intervals, sizeof declare_intervals, "Declare=Iso_Intervals=%zu", intervals);
    const char *argv[] = {program, "Input_File_Name=scene.pov", "Output_File_Name=pass.ppm", "Output_File_Type=P",
                          "Bits_Per_Color=16", "File_Gamma=1.0", "Dither=Off", "Antialias=Off", "Display=Off",
                          "Pause_When_Done=Off", "Verbose=On", width, height, threads, declare_pass, declare_intervals, NULL};
    const iso_process_options options = {.directory = dir, .line = take_progress, .user = run};
    iso_status status = iso_process_run(argv, &options, err);
    if (status != ISO_OK)
        return status;
    char *path = iso_path_join(dir, "pass.ppm");
    status = path ? iso_image_load_ppm(path, image, err) : no_memory(err);
    free(path);
    if (status == ISO_OK && (image->width != view->width || image->height != view->height)) {
        status = iso_fail(err, ISO_E_PROGRAM, "povray: the image has %zu x %zu pixels, wanted %zu x %zu", image->width,
                          image->height, view->width, view->height);
        iso_image_destroy(image);
    }
    return status;
}

/* Emission and transmittance to premultiplied colour over the background, and alpha. */
static void compose(iso_image *emission, const iso_image *transmittance, const iso_view *view, double peak)
{
    for (size_t i = 0; i < emission->width * emission->height; ++i) {
        float *to = emission->rgba + 4 * i;
        const double through = (double)transmittance->rgba[4 * i];
        for (int c = 0; c < 3; ++c)
            to[c] = (float)((double)to[c] * peak + through * view->background[c]);
        to[3] = (float)(1 - through);
    }
}

/* Both passes with n intervals. */
static iso_status render_once(const char *program, const char *dir, const iso_povray_scene *s, size_t intervals,
                              const run_progress *run, iso_image *image, iso_error *err)
{
    iso_image transmittance = {0};
    const double split = run->from + 0.3 * (run->to - run->from);
    run_progress first = {run->progress, run->from, split, run->stats, false}, second = {run->progress, split, run->to, run->stats, false};
    iso_status status = run_povray(program, dir, s->view, ISO_POVRAY_TRANSMITTANCE, intervals, s->options, &first,
                                   &transmittance, err);
    if (status == ISO_OK)
        status = run_povray(program, dir, s->view, ISO_POVRAY_EMISSION, intervals, s->options, &second, image, err);
    if (status == ISO_OK)
        compose(image, &transmittance, s->view, s->peak);
    iso_image_destroy(&transmittance);
    return status;
}

/* The error of n intervals is of order 1 / n^2: image += (image - coarse) / ((n / m)^2 - 1). */
static void extrapolate(iso_image *image, const iso_image *coarse, size_t n, size_t m)
{
    const double ratio = (double)n / (double)m, factor = 1 / (ratio * ratio - 1);
    for (size_t i = 0; i < 4 * image->width * image->height; ++i)
        image->rgba[i] += (float)(((double)image->rgba[i] - (double)coarse->rgba[i]) * factor);
}

static iso_status render_scene(const char *program, const char *dir, const iso_povray_scene *s, const iso_progress *progress,
                               iso_image *image, iso_error *err)
{
    const size_t n = s->options->intervals;
    const bool extrapolated = s->options->extrapolate && !s->options->isosurface;
    const double split = extrapolated ? 1.0 / 3 : 0;
    run_progress coarse_run = {progress, 0, split, s->options->stats, false}, fine_run = {progress, split, 1, s->options->stats, false};
    iso_image coarse = {0};
    iso_status status = ISO_OK;
    iso_progress_report(progress, "povray: rendering", 0);
    if (extrapolated)
        status = render_once(program, dir, s, n / 2, &coarse_run, &coarse, err);
    if (status == ISO_OK)
        status = render_once(program, dir, s, n, &fine_run, image, err);
    if (status == ISO_OK && extrapolated)
        extrapolate(image, &coarse, n, n / 2);
    iso_image_destroy(&coarse);
    iso_progress_report(progress, "povray: rendering", 1);
    return status;
}

double iso_povray_df3_bytes(const char *folder)
{
    double sum = 0;
    DIR *dir = opendir(folder);
    for (struct dirent *e = dir ? readdir(dir) : NULL; e; e = readdir(dir)) {
        char *path = iso_path_join(folder, e->d_name);
        struct stat about;
        if (path && iso_path_ends_with(path, ".df3") && stat(path, &about) == 0)
            sum += (double)about.st_size;
        free(path);
    }
    if (dir)
        closedir(dir);
    return sum;
}

iso_status iso_povray_render(const iso_pyramid *p, size_t level, const iso_view *view, const iso_povray_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err)
{
    *image = (iso_image){0};
    char *program = NULL, *dir = NULL;
    iso_status status = check_options(p, level, view, opt, err);
    if (status == ISO_OK)
        status = find_povray(&program, err);
    if (status == ISO_OK && !(dir = iso_make_temp_dir()))
        status = iso_fail(err, ISO_E_IO, "povray: no temporary folder can be made");
    prepared_scene s = {0};
    if (status == ISO_OK)
        status = prepare(p, level, view, "scene", opt, &s, err);
    if (status == ISO_OK)
        status = write_all(p, &s.scene, dir, progress, err);
    if (status == ISO_OK && opt->stats)
        *opt->stats = (iso_povray_stats){.df3_bytes = iso_povray_df3_bytes(dir)};
    if (status == ISO_OK)
        status = render_scene(program, dir, &s.scene, progress, image, err);
    if (dir)
        iso_remove_tree(dir);
    release(&s);
    free(dir);
    free(program);
    return status;
}
