/* SPDX-License-Identifier: MIT */
/* itk_open.c - what the program isoshade-itk reads: DICOM series, stacks of pictures, and other formats that ITK knows. */
#define _GNU_SOURCE
#include <dirent.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "volume/child.h"

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
    const bool is_unread = !f || ferror(f); /* which is told when it is opened */
    if (f)
        fclose(f);
    for (size_t i = 0; i < sizeof starts / sizeof starts[0]; ++i)
        if (size >= starts[i].at + starts[i].size && memcmp(head + starts[i].at, starts[i].bytes, starts[i].size) == 0)
            return true;
    return is_unread;
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

static iso_status open_itk(iso_volume_source *source, iso_error *err)
{
    static const iso_child_program itk = {"isoshade-itk", "ITK", "libinsighttoolkit5-dev"};
    return iso_child_open(source, &itk, source->hints.series, err);
}

const iso_volume_format iso_volume_format_itk = {
    .name = "itk",
    .title = "DICOM, PNG and JPEG",
    .summary = "by ITK, if it is installed: a folder of a DICOM series or of pictures, slice by slice; "
               "multi-frame DICOM at once",
    .suffixes = ".dcm",
    .starts = "by ITK",
    .takes_series = true,
    .probe_path = can_read,
    .open = open_itk,
};
