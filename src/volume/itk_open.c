/* SPDX-License-Identifier: MIT */
/* itk_open.c - what the program isoshade-itk reads: DICOM series, stacks of pictures, and other formats that ITK knows. */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/beside.h"
#include "base/file.h"
#include "volume/itk_stream.h"
#include "volume/stream_kernel.h"

typedef struct itk_reader {
    pid_t pid;
    FILE *output;
} itk_reader;

/* How the files begin that are known without ITK, so that a message can name it where it is missing. */
static bool has_known_start(const char *path)
{
    static const struct {
        size_t at, size;
        const char *bytes;
    } starts[] = {
        {128, 4, "DICM"}, {0, 8, "\x89PNG\r\n\x1a\n"}, {0, 3, "\xff\xd8\xff"}, /* JPEG */
    };
    char head[256];
    FILE *f = fopen(path, "rb");
    const size_t size = f ? fread(head, 1, sizeof head, f) : 0;
    if (f)
        fclose(f);
    for (size_t i = 0; i < sizeof starts / sizeof starts[0]; ++i)
        if (size >= starts[i].at + starts[i].size && memcmp(head + starts[i].at, starts[i].bytes, starts[i].size) == 0)
            return true;
    return false;
}

/* A folder of files, whatever they are. */
static bool holds_files(const char *path)
{
    DIR *dir = opendir(path);
    bool found = false;
    for (const struct dirent *entry; dir && !found && (entry = readdir(dir));) {
        char *file = entry->d_name[0] == '.' ? NULL : iso_path_join(path, entry->d_name);
        found = file && !iso_path_is_dir(file);
        free(file);
    }
    if (dir)
        closedir(dir);
    return found;
}

static bool can_read(const char *path)
{
    return iso_path_is_dir(path) ? holds_files(path) : has_known_start(path);
}

extern char **environ;

/* Starts the program, whose output is ours to read; what it and its libraries print goes nowhere. */
static iso_status start(itk_reader *r, const char *program, const char *path, const char *series, iso_error *err)
{
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        return iso_fail(err, ISO_E_IO, "%s: no pipe: %s", path, strerror(errno));
    const char *const words[] = {program, path, series, NULL};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    const int failed = posix_spawn(&r->pid, program, &actions, NULL, (char *const *)words, environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    r->output = failed ? NULL : fdopen(ends[0], "rb");
    if (!r->output)
        close(ends[0]);
    return failed ? iso_fail(err, ISO_E_MISSING, "%s: cannot be started: %s", program, strerror(failed)) : ISO_OK;
}

static iso_status get(iso_volume_source *source, void *data, size_t bytes, iso_error *err)
{
    const itk_reader *r = source->reader;
    if (r->output && fread(data, 1, bytes, r->output) == bytes)
        return ISO_OK;
    return iso_fail(err, ISO_E_FORMAT, "%s: damaged: ITK ends before the samples do", source->path);
}

static iso_status get_answer(const iso_itk_answer *answer, iso_status status, iso_error *err)
{
    return status != ISO_OK           ? status
           : answer->status != ISO_OK ? iso_fail(err, answer->status, "%s", answer->error.text)
                                      : ISO_OK;
}

static iso_status read_planes(iso_volume_source *source, size_t plane_count, void *out, iso_error *err)
{
    const size_t plane = iso_source_plane_bytes(source);
    iso_status status = ISO_OK;
    for (size_t i = 0; i < plane_count && status == ISO_OK; ++i) {
        iso_itk_answer answer;
        status = get(source, &answer, sizeof answer, err);
        status = get_answer(&answer, status, err);
        if (status == ISO_OK)
            status = get(source, (char *)out + i * plane, plane, err);
    }
    return status;
}

/* It ends when nobody reads its output. */
static void close_reader(iso_volume_source *source)
{
    itk_reader *r = source->reader;
    if (r && r->output)
        fclose(r->output);
    if (r && r->pid > 0)
        while (waitpid(r->pid, NULL, 0) < 0 && errno == EINTR)
            ;
    free(r);
}

/* ITK's world is left, posterior, superior. */
static void take_geometry(const iso_itk_header *h, double mm, iso_volume *header)
{
    iso_geometry *g = &header->geometry;
    const double sign[3] = {h->is_patient ? -mm : mm, h->is_patient ? -mm : mm, mm};
    *g = iso_geometry_axis_aligned(h->size, (double[]){1, 1, 1});
    for (int a = 0; a < 3; ++a)
        for (int r = 0; r < 3; ++r)
            g->index_to_world.m[r][a] = sign[r] * h->step_mm[a][r];
    const iso_vec3 half = iso_mul(g->index_to_world, iso_v3(0.5, 0.5, 0.5));
    g->origin_mm = iso_v3(0, 0, 0);
    if (h->is_patient)
        g->origin_mm = iso_sub(iso_v3(sign[0] * h->first_mm[0], sign[1] * h->first_mm[1], sign[2] * h->first_mm[2]),
                               half);
    else
        g->origin_mm = iso_scale(iso_geometry_box_center_mm(g), -1);
    header->type = h->type;
    header->notes.world_is_ras = h->is_patient;
}

static iso_status start_reader(iso_volume_source *source, iso_error *err)
{
    char *program = iso_beside_find(ISO_ITK_PROGRAM);
    itk_reader *r = calloc(1, sizeof *r);
    source->reader = r;
    source->read_planes = read_planes;
    source->close_reader = close_reader;
    iso_status status = !r         ? iso_fail(err, ISO_E_MEMORY, "%s: out of memory", source->path)
                        : !program ? iso_fail(err, ISO_E_MISSING,
                                              "%s: files of this kind are read by " ISO_ITK_PROGRAM
                                              ", which is missing (built without libinsighttoolkit5-dev?)",
                                              source->path)
                                   : start(r, program, source->path, source->hints.series, err);
    free(program);
    return status;
}

static iso_status open_itk(iso_volume_source *source, iso_error *err)
{
    iso_itk_header h;
    double mm;
    iso_status status = start_reader(source, err);
    if (status == ISO_OK)
        status = get(source, &h, sizeof h, err);
    if (status == ISO_OK && strcmp(h.version, ISO_VERSION) != 0)
        return iso_fail(err, ISO_E_MISSING, ISO_ITK_PROGRAM " is of version %.15s, isoshade of " ISO_VERSION,
                        h.version);
    status = get_answer(&h.answer, status, err);
    if (status == ISO_OK && h.unspaced[0])
        status = iso_source_need_spacing(source, h.unspaced, err);
    if (status == ISO_OK)
        status = iso_source_unit(source, h.is_patient ? "mm" : NULL, "mm", &mm, err);
    if (status != ISO_OK)
        return status;
    take_geometry(&h, mm, &source->header);
    return iso_geometry_check(&source->header.geometry, source->path, err);
}

const iso_volume_format iso_volume_format_itk = {
    .name = "itk",
    .title = "DICOM, PNG and JPEG",
    .summary = "by ITK, if it is installed: a folder of a DICOM series or of pictures, slice by slice; "
               "multi-frame DICOM at once",
    .suffixes = ".dcm",
    .starts = "by ITK",
    .probe_path = can_read,
    .open = open_itk,
};
