/* SPDX-License-Identifier: MIT */
/* itk_open.c - opens the formats of the program isoshade-itk: DICOM series, stacks of pictures, and other formats of
 * ITK. */
#define _GNU_SOURCE
#include <dirent.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "volume/child.h"

/* First bytes of the files that are recognized without ITK, so that a message can name it if it is missing. */
static const iso_mark starts[] = {
    ISO_MARK(128, "DICM"), ISO_MARK(0, "\x89PNG\r\n\x1a\n"), ISO_MARK(0, "\xff\xd8\xff"), /* JPEG */
};

/* True if the file starts with one of the first `count`. */
static bool has_known_start(const char *path, size_t count)
{
    unsigned char head[256];
    FILE *f = fopen(path, "rb");
    const size_t size = f ? fread(head, 1, sizeof head, f) : 0;
    const bool is_unread = !f || ferror(f); /* reported on opening */
    if (f)
        fclose(f);
    return is_unread || iso_marks_fit(starts, count, head, size);
}

/* True for a folder that holds any files. */
static bool holds_files(const char *path)
{
    DIR *dir = opendir(path);
    bool found = false;
    for (const struct dirent *entry; dir && !found && (entry = readdir(dir));) {
        FREED char *file = entry->d_name[0] == '.' ? NULL : iso_path_join(path, entry->d_name);
        found = file && !iso_path_is_dir(file);
    }
    if (dir)
        closedir(dir);
    return found;
}

/* True if a folder below, of at most `depth` levels, holds a DICOM file; looks at no more than *left entries. */
static bool holds_dicom_below(const char *path, int depth, int *left)
{
    DIR *dir = opendir(path);
    bool found = false;
    for (const struct dirent *entry; dir && !found && *left > 0 && (entry = readdir(dir));) {
        FREED char *file = entry->d_name[0] == '.' ? NULL : iso_path_join(path, entry->d_name);
        --*left;
        found = file && (iso_path_is_dir(file)    ? depth > 0 && holds_dicom_below(file, depth - 1, left)
                         : iso_path_is_file(file) ? has_known_start(file, 1)
                                                  : false);
    }
    if (dir)
        closedir(dir);
    return found;
}

static bool can_read(const char *path)
{
    enum { DEPTH = 6, ENTRIES = 20000 };
    int left = ENTRIES;
    return iso_path_is_dir(path) ? holds_files(path) || holds_dicom_below(path, DEPTH, &left)
                                 : has_known_start(path, sizeof starts / sizeof *starts);
}

/* Notes the files of a folder that ITK reads: of a series the DICOM files, of pictures all. */
static iso_status note_slices(const char *folder, bool is_series, iso_error *err)
{
    DIR *dir = opendir(folder);
    iso_status status = ISO_OK;
    size_t noted = 0;
    for (const struct dirent *entry; dir && status == ISO_OK && (entry = readdir(dir));) {
        FREED char *file = entry->d_name[0] == '.' ? NULL : iso_path_join(folder, entry->d_name);
        if (file && iso_path_is_file(file) && (!is_series || has_known_start(file, 1)))
            status = iso_inputs_note(file, err), ++noted;
    }
    if (dir)
        closedir(dir);
    return status == ISO_OK && noted == 0 ? iso_inputs_note_folder(folder, err) : status; /* slices are below */
}

static iso_status open_itk(iso_volume_source *source, iso_error *err)
{
    static const iso_child_program itk = {"isoshade-itk", "ITK", "libinsighttoolkit5-dev"};
    NEED(iso_child_open(source, &itk, source->hints.series, err));
    return iso_path_is_dir(source->path) ? note_slices(source->path, source->header.notes.world_is_ras, err) : ISO_OK;
}

const iso_volume_format iso_volume_format_itk = {
    .name = "itk",
    .title = "DICOM, PNG, JPEG and BMP",
    .summary = "by ITK, if it is installed: a folder of a DICOM series or of pictures, slice by slice; "
               "multi-frame DICOM at once",
    .suffixes = ".dcm",
    .starts = "by ITK",
    .takes_series = true,
    .probe_path = can_read,
    .open = open_itk,
};
