/* SPDX-License-Identifier: MIT */
/* scale.c - time and memory of the commands against the number of voxels, each run in a separate process. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/json.h"
#include "base/machine.h"
#include "base/names.h"
#include "base/process.h"
#include "base/words.h"
#include "bench/bench.h"
#include "bench/growth.h"
#include "report/gnuplot.h"

ISO_EMBED(iso_scale_gp, "src/bench/scale.gp");

enum { MOST_SIZES = 6, MOST_WORDS = 32, SHORT_SECONDS = 5 };

/* Sizes grow by a factor of 8 in voxels, the last one by 4. */
static const size_t sizes[MOST_SIZES][3] = {{64, 64, 64},    {128, 128, 128},    {256, 256, 256},
                                            {512, 512, 512}, {1024, 1024, 1024}, {2048, 2048, 1024}};

/* Contents of the volumes. Shells keep their thickness relative to the box, so that larger volumes have more voxels
 * equal to their neighbors. Grain has the same statistics around each voxel at every size. */
static const struct content {
    const char *name, *summary, *make;
} contents[] = {
    {"shells", "two thin shells: the larger, the more voxels equal their neighbors", "make shells"},
    {"grain", "noise in each voxel: the same statistics around a voxel at every size", "make constant --grain 0.1"},
};
static const iso_names content_names = ISO_NAMES_OF_ROWS("content", contents);

/* Commands in a folder with volume.nrrd, in an order in which each finds its input. */
static const struct stage {
    const char *name, *command;
    bool is_streamed; /* its memory must not grow with the volume */
    bool reads_pyramid;
} stages[] = {
    {"build", "build volume.nrrd -o volume.iso --levels 4 --memory 512", true, false},
    {"histogram", "info volume.nrrd", true, false},
    {"render", "render volume.iso --scene scale.scene.json --memory 256 -o paged.exr", true, true},
    {"render-whole", "render volume.iso --scene scale.scene.json --with cpu -o whole.exr", false, true},
    {"export", "export volume.nrrd --scene scale.scene.json --to vdb -o volume.vdb", false, false},
    {"plan", "plan volume.iso --scene scale.scene.json --size 64 --error 1/64 -o volume.plan.json", false, true},
};
enum { STAGES = sizeof stages / sizeof *stages, BUILD_STAGE = 0 };

typedef struct point {
    bool is_measured;
    double seconds, processor_seconds, peak_bytes;
    char why[160]; /* why it was not measured */
} point;

typedef struct scale_bench {
    char program[4096];
    char *folder;
    const struct content *content;
    const char *only;    /* names separated by commas; NULL: all */
    size_t count;        /* number of sizes */
    int repeat;          /* runs of a command shorter than SHORT_SECONDS; the least counts */
    point start[STAGES]; /* with 16^3 voxels: the cost of a process */
    point points[STAGES][MOST_SIZES];
    double slope[STAGES];
    size_t fitted[STAGES]; /* number of sizes in a slope */
} scale_bench;

static double voxels_of(size_t i)
{
    return (double)sizes[i][0] * (double)sizes[i][1] * (double)sizes[i][2];
}

/* ---- one command ---- */

static iso_status run_command(const scale_bench *b, const char *command, point *p, iso_error *err)
{
    const char *argv[MOST_WORDS] = {b->program};
    char *words = strdup(command), *rest = words;
    size_t count = 1;
    iso_process_outcome took = {0};
    const iso_process_options options = {.directory = b->folder, .outcome = &took};
    for (char *word; count + 2 < MOST_WORDS && (word = strsep(&rest, " "));)
        argv[count++] = word;
    argv[count++] = "-q";
    argv[count] = NULL;
    const iso_status status = words ? iso_process_run(argv, &options, err)
                                    : iso_fail(err, ISO_E_MEMORY, "out of memory");
    *p = (point){status == ISO_OK, took.seconds, took.processor_seconds, took.peak_bytes, ""};
    free(words);
    return status;
}

/* Measures a command. Other load only adds to a time, mostly to short ones: of these, the least counts. */
static iso_status measure_command(const scale_bench *b, const char *command, point *p, iso_error *err)
{
    iso_status status = run_command(b, command, p, err);
    for (int i = 1; i < b->repeat && status == ISO_OK && p->seconds < SHORT_SECONDS; ++i) {
        point again;
        status = run_command(b, command, &again, err);
        if (status == ISO_OK && again.processor_seconds < p->processor_seconds)
            *p = again;
    }
    return status;
}

static bool is_requested(const scale_bench *b, size_t stage)
{
    char list[256], name[64];
    snprintf(list, sizeof list, ",%s,", b->only ? b->only : "");
    snprintf(name, sizeof name, ",%s,", stages[stage].name);
    return !b->only || strstr(list, name);
}

/* True if the build is not measured but must run, because requested stages read its pyramid. */
static bool lacks_pyramid(const scale_bench *b)
{
    bool reads = false;
    for (size_t s = 0; s < STAGES; ++s)
        reads = reads || (is_requested(b, s) && stages[s].reads_pyramid);
    return reads && !is_requested(b, BUILD_STAGE);
}

/* Writes the volume and removes the previous size's pyramid, so that no stage reads it if the build fails. */
static iso_status make_volume(const scale_bench *b, const size_t size[3], iso_error *err)
{
    char command[160];
    point unused;
    FREED char *pyramid = iso_path_join(b->folder, "volume.iso");
    NEED_MEMORY(pyramid, err, "out of memory");
    iso_remove_tree(pyramid);
    snprintf(command, sizeof command, "%s --size %zux%zux%zu --type uint8 -o volume.nrrd", b->content->make, size[0],
             size[1], size[2]);
    const iso_status status = run_command(b, command, &unused, err);
    return status == ISO_OK && lacks_pyramid(b) ? run_command(b, stages[BUILD_STAGE].command, &unused, err) : status;
}

/* ---- all of them ---- */

/* Estimates from the previous size whether this one fits; if not, writes why. */
static bool fits_memory(const scale_bench *b, size_t stage, size_t i, char why[160])
{
    if (i == 0 || stages[stage].is_streamed)
        return true;
    const point *last = &b->points[stage][i - 1];
    const double have = 0.6 * (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE),
                 need = last->peak_bytes * voxels_of(i) / voxels_of(i - 1);
    if (!last->is_measured || need > have) {
        snprintf(why, 160, last->is_measured ? "memory: needs %.1f GB, limit %.1f GB" : "like the smaller size",
                 need / 1e9, have / 1e9);
        return false;
    }
    return true;
}

static void measure_size(scale_bench *b, size_t i, const iso_cli *cli)
{
    const iso_progress progress = iso_cli_progress(cli);
    for (size_t s = 0; s < STAGES; ++s) {
        point *p = &b->points[s][i];
        iso_error why = {""};
        if (!is_requested(b, s))
            snprintf(p->why, sizeof p->why, "not requested");
        else if (fits_memory(b, s, i, p->why) && measure_command(b, stages[s].command, p, &why) != ISO_OK) {
            *p = (point){.is_measured = false}; /* the time until a failure is not the command's time */
            snprintf(p->why, sizeof p->why, "%.150s", why.text);
        }
        iso_progress_report(&progress, "measure", (double)(i * STAGES + s + 1) / (double)(b->count * STAGES));
    }
}

/* Estimates the disk space: a volume of one byte per voxel, its pyramid with codes, and the exported file. */
static bool fits_disk(const scale_bench *b, size_t i, char why[160])
{
    struct statvfs disk;
    const double need = 10 * voxels_of(i);
    if (statvfs(b->folder, &disk) != 0)
        return true;
    const double have = (double)disk.f_bavail * (double)disk.f_frsize;
    snprintf(why, 160, "disk: needs %.1f GB, %.1f GB free", need / 1e9, have / 1e9);
    return need < have;
}

static void fit_slope(scale_bench *b, size_t stage)
{
    double voxels[MOST_SIZES], seconds[MOST_SIZES];
    for (size_t i = 0; i < b->count; ++i) {
        voxels[i] = voxels_of(i);
        seconds[i] = b->points[stage][i].processor_seconds;
    }
    b->slope[stage] = iso_growth_slope(voxels, seconds, b->count, b->start[stage].processor_seconds, &b->fitted[stage]);
}

static iso_status measure_all(scale_bench *b, const iso_cli *cli, iso_error *err)
{
    static const size_t least[3] = {16, 16, 16};
    static const char scene[] =
        "{\"schema\": \"isoshade.scene/1\", \"image\": {\"width\": 256, \"height\": 256},\n"
        " \"camera\": {\"projection\": \"perspective\", \"fit\": true, \"direction\": [0.7, 0.9, -0.5], "
        "\"up\": [0, 0, 1], \"fov_y_deg\": 25},\n"
        " \"lights\": [{\"direction\": [-0.4, 0.6, 1], \"space\": \"camera\", \"intensity\": 1}],\n"
        " \"shading\": {\"ambient\": 0.25, \"diffuse\": 0.75, \"specular\": 0, \"power\": 1},\n"
        " \"background\": [0, 0, 0], \"step_voxels\": 0.5, \"tf\": \"scale.tf.json\"}\n";
    static const char tf[] =
        "{\"schema\": \"isoshade.tf/1\", \"range\": \"fit\", \"unit_distance_voxels\": 1, \"color_space\": "
        "\"srgb\", \"table_size\": 256, \"points\": [\n"
        " {\"value\": 0, \"r\": 1, \"g\": 0.8, \"b\": 0.6, \"opacity\": 0},\n"
        " {\"value\": 0.4, \"r\": 1, \"g\": 0.8, \"b\": 0.6, \"opacity\": 0},\n"
        " {\"value\": 1, \"r\": 1, \"g\": 0.8, \"b\": 0.6, \"opacity\": 0.3}]}\n";
    FREED char *scene_path = iso_path_join(b->folder, "scale.scene.json"),
               *tf_path = iso_path_join(b->folder, "scale.tf.json");
    iso_status status = scene_path && tf_path ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    TRY(status, iso_file_write(scene_path, scene, sizeof scene - 1, err));
    TRY(status, iso_file_write(tf_path, tf, sizeof tf - 1, err));
    TRY(status, make_volume(b, least, err));
    for (size_t s = 0; s < STAGES && status == ISO_OK; ++s)
        if (is_requested(b, s))
            status = measure_command(b, stages[s].command, &b->start[s], err);
    for (size_t i = 0; i < b->count && status == ISO_OK; ++i) {
        char why[160];
        if (!fits_disk(b, i, why)) {
            for (size_t s = 0; s < STAGES; ++s)
                memcpy(b->points[s][i].why, why, sizeof why);
            continue;
        }
        status = make_volume(b, sizes[i], err);
        if (status == ISO_OK)
            measure_size(b, i, cli);
        if (status == ISO_OK && iso_process_was_stopped())
            status = iso_fail(err, ISO_E_PROGRAM, "stopped by a signal");
    }
    for (size_t s = 0; s < STAGES; ++s)
        fit_slope(b, s);
    return status;
}

/* ---- results ---- */

static json_t *point_to_json(const point *p, size_t i)
{
    json_t *size = json_pack("[I,I,I]", (json_int_t)sizes[i][0], (json_int_t)sizes[i][1], (json_int_t)sizes[i][2]);
    if (!p->is_measured)
        return json_pack("{s:o, s:s}", "size", size, "left_out", p->why);
    return json_pack("{s:o, s:f, s:f, s:f, s:f}", "size", size, "voxels", voxels_of(i), "seconds", p->seconds,
                     "processor_seconds", p->processor_seconds, "peak_bytes", p->peak_bytes);
}

static json_t *to_json(const scale_bench *b, size_t s)
{
    json_t *points = json_array();
    for (size_t i = 0; i < b->count; ++i)
        json_array_append_new(points, point_to_json(&b->points[s][i], i));
    json_t *stage = json_pack("{s:s, s:s, s:b, s:f, s:f, s:o}", "name", stages[s].name, "command", stages[s].command,
                              "is_streamed", stages[s].is_streamed, "process_seconds", b->start[s].processor_seconds,
                              "process_bytes", b->start[s].peak_bytes, "points", points);
    json_object_set_new(stage, "slope", iso_json_number(b->slope[s]));
    json_object_set_new(stage, "slope_of_sizes", json_integer((json_int_t)b->fitted[s]));
    json_object_set_new(stage, "met", isnan(b->slope[s]) ? json_null() : json_boolean(fabs(b->slope[s] - 1) <= 0.05));
    return stage;
}

static void print_stage(const scale_bench *b, size_t s)
{
    printf("%s: isoshade %s\n  %16s %10s %12s %12s\n", stages[s].name, stages[s].command, "voxels", "s", "processor s",
           "peak, MB");
    for (size_t i = 0; i < b->count; ++i) {
        const point *p = &b->points[s][i];
        if (p->is_measured)
            printf("  %4zux%4zux%4zu %13.2f %12.2f %12.0f\n", sizes[i][0], sizes[i][1], sizes[i][2], p->seconds,
                   p->processor_seconds, p->peak_bytes / 1e6);
        else
            printf("  %4zux%4zux%4zu left out: %s\n", sizes[i][0], sizes[i][1], sizes[i][2], p->why);
    }
    if (isnan(b->slope[s]))
        printf("  no slope: a process costs %.2f s, and only %zu sizes take ten times as long\n",
               b->start[s].processor_seconds, b->fitted[s]);
    else
        printf("  slope of processor time without the %.2f s of a process, of %zu sizes: %.3f\n",
               b->start[s].processor_seconds, b->fitted[s], b->slope[s]);
}

static void print(const scale_bench *b)
{
    for (size_t s = 0; s < STAGES; ++s)
        if (is_requested(b, s))
            print_stage(b, s);
}

static iso_status draw(const scale_bench *b, const char *output, const char *format, iso_error *err)
{
    FREED char *csv = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&csv, &size);
    NEED_MEMORY(f, err, "bench scale: no memory for the chart's data");
    fprintf(f, "stage,voxels,processor_seconds,peak_bytes\n");
    for (size_t s = 0; s < STAGES; ++s)
        for (size_t i = 0; i < b->count; ++i)
            if (b->points[s][i].is_measured)
                fprintf(f, "%s,%.9g,%.9g,%.9g\n", stages[s].name, voxels_of(i), b->points[s][i].processor_seconds,
                        b->points[s][i].peak_bytes);
    fclose(f);
    iso_output out = {0};
    iso_status status = iso_output_begin_dir(&out, output, "scale.csv", err);
    TRY(status, iso_gnuplot_draw(out.temp_path, "scale", csv, iso_scale_gp, format, err));
    TRY(status, iso_output_commit(&out, err));
    iso_output_abandon(&out);
    return status;
}

static iso_status report(const scale_bench *b, const iso_cli *cli, const char *output, const char *format,
                         iso_error *err)
{
    if (cli->json) {
        json_t *root = iso_cli_json(cli), *all = json_array();
        json_object_set_new(json_object_get(root, "options"), "of", json_string(b->content->name));
        for (size_t s = 0; s < STAGES; ++s)
            json_array_append_new(all, to_json(b, s));
        json_object_set_new(root, "machine", iso_machine_describe());
        json_object_set_new(root, "stages", all);
        iso_cli_print_json(root);
    } else {
        print(b);
    }
    return output ? draw(b, output, format, err) : ISO_OK;
}

/* ---- the command ---- */

static iso_status count_sizes(const char *largest, size_t *count, iso_error *err)
{
    for (*count = 1; *count <= MOST_SIZES; ++*count) {
        char name[40];
        snprintf(name, sizeof name, "%zu", sizes[*count - 1][0]);
        if (strcmp(name, largest) == 0)
            return ISO_OK;
    }
    return iso_fail(err, ISO_E_USAGE, "--largest is \"%s\", must be 64, 128, 256, 512, 1024 or 2048 (2048x2048x1024)",
                    largest);
}

static iso_status check_only(const char *only, iso_error *err)
{
    char *names = strdup(only), *rest = names;
    iso_status status = names ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "out of memory");
    for (char *name; status == ISO_OK && (name = strsep(&rest, ","));) {
        size_t s = 0;
        while (s < STAGES && strcmp(stages[s].name, name) != 0)
            ++s;
        if (s == STAGES)
            status = iso_fail(err, ISO_E_USAGE,
                              "--only has \"%s\", must be build, histogram, render, render-whole, export or plan",
                              name);
    }
    free(names);
    return status;
}

static iso_status run_all(scale_bench *b, const iso_cli *cli, const char *output, const char *format, iso_error *err)
{
    const ssize_t n = readlink("/proc/self/exe", b->program, sizeof b->program - 1);
    b->folder = iso_make_temp_dir();
    iso_status status = n > 0 && b->folder ? ISO_OK : iso_temp_dir_fail(err);
    TRY(status, measure_all(b, cli, err));
    TRY(status, report(b, cli, output, format, err));
    if (b->folder)
        iso_remove_tree(b->folder);
    free(b->folder);
    return status;
}

typedef struct scale_options {
    scale_bench bench;
    const char *largest, *of, *format;
    char *output, *only;
} scale_options;

static const iso_option options[] = {
    {"largest", 0, "measure 64^3 up to 128, 256, 512, 1024 or 2048 (2048x2048x1024)", "N",
     ISO_IN(scale_options, largest), .flags = ISO_SHOWN},
    {"of", 0, "set the volumes' content, see below", "NAME", ISO_IN(scale_options, of), .flags = ISO_SHOWN},
    {"only", 0, "measure only build, histogram, render, render-whole, export or plan (all)", "NAME,...",
     ISO_IN(scale_options, only)},
    {"repeat", 0, "run commands under 5 seconds N times; the least counts", "N", ISO_IN(scale_options, bench.repeat),
     .flags = ISO_SHOWN, .least = 1, .most = 100},
    {"output", 'o', "write the chart and its data", "FOLDER", ISO_IN(scale_options, output)},
    {"format", 0, "write the chart as svg or pdf", "svg|pdf", ISO_IN(scale_options, format),
     .flags = ISO_SHOWN | ISO_ONE_OF},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    scale_options *o = values;
    scale_bench *b = &o->bench;
    size_t row = 0;
    iso_status status = count_sizes(o->largest, &b->count, err);
    TRY(status, iso_names_find(&content_names, o->of, &row, err));
    if (status == ISO_OK && o->only)
        status = check_only(o->only, err);
    b->only = o->only;
    b->content = &contents[row];
    return status == ISO_OK ? run_all(b, cli, o->output, o->format, err) : status;
}

const iso_command iso_bench_scale = {
    .name = "bench scale",
    .summary = "time and memory of build, histogram, render, export and plan against the number of voxels",
    .usage = "[options]",
    .details =
        "Each command runs in a separate process, on volumes of 8 bits. Shells keep their thickness relative to the\n"
        "box, so that larger volumes have more voxels equal to their neighbors; grain has the same statistics at\n"
        "every size. With --only, other commands still run if their output is read, but are not measured. The slope\n"
        "is the exponent of time over voxels, without the cost of a process (16^3 voxels): 1 if time grows as the\n"
        "volume does. Sizes at which a process costs over a tenth of the time are not used. Sizes that exceed memory\n"
        "or disk are listed as left out.",
    .examples = "  isoshade bench scale --largest 64\n"
                "  isoshade bench scale --of grain --largest 128 --only build\n",
    .lists = (const iso_names *const[]){&content_names, NULL},
    ISO_COMMAND_OPTIONS(scale_options, options, .bench = {.repeat = 3}, .largest = "512", .of = "shells",
                        .format = "svg"),
    .run = run,
};
