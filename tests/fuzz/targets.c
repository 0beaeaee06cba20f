/* SPDX-License-Identifier: MIT */
/* targets.c - the table of readers, and what they have in common. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <float.h>
#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "tests/fuzz/readers.h"

/* clang-format off */
const fuzz_target fuzz_targets[] = {
    {"nrrd", "input.nrrd", FUZZ_LINES, fuzz_volume, NULL, "src/volume/nrrd_open.c src/volume/source*.c src/volume/geometry.c src/volume/unit.c"},
    {"nhdr", "input.nhdr", FUZZ_LINES, fuzz_volume, NULL, "src/volume/nrrd_open.c"},
    {"segments", "input.seg.nrrd", FUZZ_LINES, fuzz_volume, NULL, "src/volume/nrrd_open.c src/volume/segments.c"},
    {"nifti", "input.nii", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/nifti_open.c"},
    {"metaimage", "input.mha", FUZZ_LINES, fuzz_volume, NULL, "src/volume/metaimage_open.c src/volume/zlib_samples.c"},
    {"vtk", "input.vtk", FUZZ_LINES, fuzz_volume, NULL, "src/volume/vtk_open.c src/volume/text_samples.c"},
    {"vti", "input.vti", FUZZ_LINES, fuzz_volume, NULL, "src/volume/vti_open.c src/volume/text_samples.c"},
    {"tiff", "input.tif", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/tiff_open.c"},
    {"mrc", "input.mrc", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/mrc_open.c"},
    {"cube", "input.cube", FUZZ_LINES, fuzz_volume, NULL, "src/volume/cube_open.c src/volume/text_samples.c"},
    {"xsf", "input.xsf", FUZZ_LINES, fuzz_volume, NULL, "src/volume/xsf_open.c src/volume/text_samples.c"},
    {"npy", "input.npy", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/npy_open.c"},
    {"npz", "input.npz", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/npy_open.c src/volume/unpack.c"},
    {"mgh", "input.mgh", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/mgh_open.c src/volume/reader.c"},
    {"fits", "input.fits", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/fits_open.c"},
    {"dx", "input.dx", FUZZ_LINES, fuzz_volume, NULL, "src/volume/dx_open.c"},
    {"vasp", "CHGCAR", FUZZ_LINES, fuzz_volume, NULL, "src/volume/vasp_open.c"},
    {"mif", "input.mif", FUZZ_LINES, fuzz_volume, NULL, "src/volume/mif_open.c"},
    {"afni", "input.HEAD", FUZZ_LINES, fuzz_afni, NULL, "src/volume/afni_open.c"},
    {"pvti", "input.pvti", FUZZ_LINES, fuzz_pvti, NULL, "src/volume/pvti_open.c"},
    {"packed", "input.mrc", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/unpack.c"},
    {"gipl", "input.gipl", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/gipl_open.c"},
    {"raw", "input.raw", FUZZ_LINES, fuzz_raw, NULL, "src/volume/input.c"},
    {"series", "input.pvd", FUZZ_LINES, fuzz_volume, NULL, "src/volume/numbered_files.c src/volume/frames.c"},
    {"hdf5", "input.h5", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/arrays/arrays_read.cc src/volume/arrays/hdf5_store.cc src/volume/arrays/placement.cc"},
    {"netcdf", "input.nc", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/arrays/netcdf_store.cc"},
    {"zarr", "input.zarr/", FUZZ_LINES, fuzz_volume, NULL, "src/volume/arrays/zarr_store.cc"},
    {"vdb", "input.vdb", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/vdb/vdb_read.cc"},
    {"dicom", "input.dcm", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/itk/*.cc"},
    {"slices", "input/", FUZZ_BYTES, fuzz_volume, NULL, "src/volume/itk/*.cc"},
    {"tf_csv", "input.csv", FUZZ_LINES, fuzz_tf, NULL, "src/tf/format_csv.c src/tf/tf.c"},
    {"tf_json", "input.tf.json", FUZZ_JSON, fuzz_tf, NULL, "src/tf/format_json.c src/tf/tf.c"},
    {"tf_slicer", "input.vp.json", FUZZ_JSON, fuzz_tf, NULL, "src/tf/format_slicer.c"},
    {"tf_slicer_mrml", "input.mrml", FUZZ_LINES, fuzz_tf, NULL, "src/tf/format_slicer_mrml.c src/tf/xml.c"},
    {"tf_slicer_vp", "input.vp", FUZZ_LINES, fuzz_tf, NULL, "src/tf/format_slicer_vp.c"},
    {"tf_paraview", "input.json", FUZZ_JSON, fuzz_tf, NULL, "src/tf/format_paraview.c"},
    {"tf_paraview_xml", "input.xml", FUZZ_LINES, fuzz_tf, NULL, "src/tf/format_paraview_xml.c src/tf/xml.c"},
    {"tf_niivue", "input.json", FUZZ_JSON, fuzz_tf, NULL, "src/tf/format_niivue.c"},
    {"tf_inviwo", "input.itf", FUZZ_LINES, fuzz_tf, NULL, "src/tf/format_inviwo.c src/tf/xml.c"},
    {"tf_voreen", "input.tfi", FUZZ_LINES, fuzz_tf, NULL, "src/tf/format_voreen.c src/tf/xml.c"},
    {"tf_imagej", "input.lut", FUZZ_BYTES, fuzz_tf, NULL, "src/tf/format_imagej.c"},
    {"scene", "input.scene.json", FUZZ_JSON, fuzz_scene, NULL, "src/scene/scene_json.c src/scene/scene.c"},
    {"iso", "input.iso/", FUZZ_JSON, fuzz_pyramid, fuzz_repair_pyramid, "src/pyramid/pyramid_file.c src/pyramid/pyramid_layout.c"},
    {"joint", "level_1_joint8.nrrd", FUZZ_LINES, fuzz_joint, NULL, "src/tf/histogram_file.c"},
    {"plan", "input.plan.json", FUZZ_JSON, fuzz_plan, NULL, "src/plan/planned.c"},
    {"report", "report.json", FUZZ_JSON, fuzz_report, NULL, "src/report/difference.c src/report/markdown.c src/report/rows.c"},
    {"renderers", "renderers.json", FUZZ_JSON, fuzz_renderers, NULL, "src/renderers/external_json.c"},
    {"manifest", "folder/", FUZZ_LINES, fuzz_manifest, NULL, "src/base/manifest.c"},
    {"palette", "palette.csv", FUZZ_LINES, fuzz_palette, NULL, "src/palette/palette_export.c"},
    {"exr", "input.exr", FUZZ_BYTES, fuzz_exr, NULL, "src/image/exr.c src/image/exr_codec.cc src/image/exr_header.c"},
    {"png", "input.png", FUZZ_BYTES, fuzz_png, fuzz_repair_png, "src/image/png_read.c src/image/picture_bytes.c"},
    {"ppm", "input.ppm", FUZZ_BYTES, fuzz_ppm, NULL, "src/image/image.c"},
    {"words", "words.txt", FUZZ_LINES, fuzz_words, NULL, "src/base/words.c src/scene/viewpoint.c src/volume/unit.c"},
    {"planted", "planted.json", FUZZ_JSON, fuzz_planted, NULL, "tests/fuzz/trees.c"},
    {0},
};
/* clang-format on */

static char folder[128], file_path[256];

bool fuzz_has_failed, fuzz_was_read;
unsigned fuzz_assertions;

void fuzz_fail(const char *format, ...)
{
    va_list args;
    fuzz_has_failed = true;
    va_start(args, format);
    fputs("fuzz: a contract is broken: ", stderr);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
    va_end(args);
    abort();
}

void fuzz_check_status(iso_status status, const iso_error *err)
{
    if (status == ISO_OK)
        return;
    if ((int)status < 0 || status > 10)
        fuzz_fail("status %d is none", (int)status);
    if (!err->text[0])
        fuzz_fail("status %d has no message", (int)status);
    if (strchr(err->text, '\n'))
        fuzz_fail("a message is more than one line: %s", err->text);
}

void fuzz_note_read(void)
{
    fuzz_was_read = true;
}

void fuzz_check_read(iso_status status, const iso_error *err)
{
    fuzz_check_status(status, err);
    if (status == ISO_OK)
        fuzz_note_read();
}

/* A direction that is normalized twice may differ by some roundings: three squares and two sums, a root and a division,
 * each of 1.1e-16, twice over, and what a square below the smallest normal number loses. */
static bool is_about(double a, double b)
{
    return fabs(a - b) <= 1e-14 * fmax(fabs(a), fabs(b)) + DBL_MIN;
}

static bool is_same(const json_t *a, const json_t *b)
{
    bool same = json_typeof(a) == json_typeof(b);
    if (same && json_is_real(a))
        return is_about(json_real_value(a), json_real_value(b));
    if (same && json_is_array(a)) {
        same = json_array_size(a) == json_array_size(b);
        for (size_t i = 0; same && i < json_array_size(a); ++i)
            same = is_same(json_array_get(a, i), json_array_get(b, i));
        return same;
    }
    if (!same || !json_is_object(a))
        return same && json_equal(a, b);
    same = json_object_size(a) == json_object_size(b);
    json_t *of = (json_t *)(size_t)a; /* which is not changed */
    for (void *at = json_object_iter(of); same && at; at = json_object_iter_next(of, at)) {
        const json_t *value = json_object_get(b, json_object_iter_key(at));
        same = value && is_same(json_object_iter_value(at), value);
    }
    return same;
}

void fuzz_check_same(const char *what, const json_t *written, const json_t *read)
{
    if (is_same(written, read))
        return;
    char *a = json_dumps(written, 0), *b = json_dumps(read, 0);
    fuzz_fail("%s is not read back as it was written:\n%s\n%s", what, a ? a : "", b ? b : "");
}

const fuzz_target *fuzz_find(const char *name)
{
    for (const fuzz_target *t = fuzz_targets; t->name; ++t)
        if (strcmp(t->name, name) == 0)
            return t;
    return NULL;
}

const char *fuzz_beside(const char *name)
{
    static char path[4][512];
    static unsigned next;
    char *to = path[next++ % 4];
    snprintf(to, sizeof *path, "%s/%s", folder, name);
    return to;
}

/* A library that ends a process which was forked for some inputs leaves the others their folder. */
static pid_t folder_owner;
static void remove_folder(void)
{
    if (getpid() == folder_owner)
        iso_remove_tree(folder);
}

void fuzz_begin(const fuzz_target *target)
{
    const char *shared = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/isoshade-fuzz-XXXXXX", shared ? shared : "/tmp");
    if (!mkdtemp(folder)) {
        fprintf(stderr, "fuzz: no folder for the input: %s\n", strerror(errno));
        exit(1);
    }
    folder_owner = getpid();
    atexit(remove_folder);
    snprintf(file_path, sizeof file_path, "%s/%s", folder, target->file);
    const size_t length = strlen(file_path);
    if (file_path[length - 1] == '/') {
        file_path[length - 1] = 0;
        mkdir(file_path, 0700);
    }
}

static void write_file(const char *path, const void *data, size_t size)
{
    const int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0)
        return; /* the name is none: the reader finds no such file */
    if (write(fd, data, size) != (ssize_t)size)
        fuzz_fail("the input cannot be written to %s: %s", path, strerror(errno));
    close(fd);
}

/* The input's own file stays open: to open it again for each input, and to give its pages back, took a third of the
 * time of the quickest readers. */
static void write_first(const uint8_t *data, size_t size)
{
    static int fd = -1;
    static off_t length;
    if (fd < 0)
        fd = open(file_path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0 || pwrite(fd, data, size, 0) != (ssize_t)size ||
        ((off_t)size < length && ftruncate(fd, (off_t)size) != 0))
        fuzz_fail("the input cannot be written to %s: %s", file_path, strerror(errno));
    length = (off_t)size;
}

/* Further names: letters, digits and "._-", and in a folder one level of folders below it. */
static bool take_name(const char *line, size_t length, bool in_folder, char name[64])
{
    size_t slashes = 0;
    if (length == 0 || length >= 64 || line[0] == '.')
        length = line[0] == '.' && (line[1] == 'z' || line[1] == 'i') && length < 64 ? length : 0; /* .zarray, .isoshade-files */
    for (size_t i = 0; i < length; ++i) {
        const char c = line[i];
        const bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
                          c == '_' || c == '-';
        slashes += c == '/';
        if (!good && !(c == '/' && in_folder && i > 0 && slashes == 1))
            return false;
        name[i] = c;
    }
    name[length] = 0;
    return length > 0 && !strstr(name, "..");
}

static const char mark[] = "\n==== ";
enum { MARK = sizeof mark - 1 };

static void make_folder_of(char *path)
{
    char *slash = strrchr(path, '/');
    *slash = 0;
    mkdir(path, 0700);
    *slash = '/';
}

/* Further files go to the folder of the first, or into the one that the target is. */
static void write_input(const fuzz_target *target, const uint8_t *data, size_t size)
{
    const bool in_folder = target->file[strlen(target->file) - 1] == '/';
    const uint8_t *end = data + size, *next = memmem(data, size, mark, MARK);
    if (in_folder) {
        iso_remove_tree(file_path);
        mkdir(file_path, 0700);
        if (size >= MARK - 1 && memcmp(data, mark + 1, MARK - 1) == 0)
            next = data - 1;
    } else {
        write_first(data, next ? (size_t)(next - data) : size);
    }
    for (int files = 0; next && files < 16; ++files) {
        const uint8_t *line = next + MARK, *stop = memchr(line, '\n', (size_t)(end - line));
        char name[64], path[400];
        if (!stop)
            return;
        next = memmem(stop, (size_t)(end - stop), mark, MARK);
        if (!take_name((const char *)line, (size_t)(stop - line), in_folder, name))
            continue;
        snprintf(path, sizeof path, "%s/%s", in_folder ? file_path : folder, name);
        if (strchr(name, '/'))
            make_folder_of(path);
        ++stop;
        write_file(path, stop, next ? (size_t)((next >= stop ? next : stop) - stop) : (size_t)(end - stop));
    }
}

void fuzz_run(const fuzz_target *target, const uint8_t *data, size_t size)
{
    fuzz_was_read = false;
    write_input(target, data, size);
    target->run(target, file_path, data, size);
}
