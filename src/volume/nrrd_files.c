/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/nrrd_files.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/types.h>

#include "base/file.h"

enum { MOST_FILES = 65536, HEADER_BYTES = 1 << 20 };

static iso_status check_file(const char *header, const char *name, iso_error *err)
{
    struct stat st;
    char *dir = iso_path_dir(header), *path = dir ? iso_path_join(dir, name) : NULL;
    iso_status status = path ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", header);
    if (status == ISO_OK && stat(path, &st) == 0 && !S_ISREG(st.st_mode))
        status = iso_fail(err, ISO_E_IO, "%s: its samples, %s, are not a regular file", header, path);
    free(path);
    free(dir);
    return status;
}

/* "slice%04d.raw FIRST LAST STEP": a number goes where %04d is. Other patterns are left to teem. */
static iso_status check_pattern(const char *header, const char *text, iso_error *err)
{
    double first, last, step;
    char format[1024];
    if (sscanf(text, " %1023s %lf %lf %lf", format, &first, &last, &step) != 4 || step == 0)
        return ISO_OK;
    const double count = floor(fabs(last - first) / fabs(step)) + 1;
    if (!(count <= MOST_FILES))
        return iso_fail(err, ISO_E_RANGE, "%s: names %.0f data files, at most %d", header, count, MOST_FILES);
    char *at = strchr(format, '%'), *end;
    const long width = strtol(at + 1, &end, 10);
    if (*end != 'd' || width < 0 || width > 64)
        return ISO_OK;
    *at = 0;
    iso_status status = ISO_OK;
    for (double i = 0; i < count && status == ISO_OK; ++i) {
        char name[2 * sizeof format];
        const int number = (int)(first + i * (last < first ? -fabs(step) : fabs(step)));
        snprintf(name, sizeof name, at[1] == '0' ? "%s%0*d%s" : "%s%*d%s", format, (int)width, number, end + 1);
        status = check_file(header, name, err);
    }
    return status;
}

static char *trim(char *text)
{
    text += strspn(text, " \t");
    text[strcspn(text, "\r\n")] = 0;
    return text;
}

/* "LIST" or "LIST 2": a name a line until the file ends. */
static iso_status check_list(const char *header, FILE *file, iso_error *err)
{
    char *line = NULL;
    size_t room = 0, count = 0;
    iso_status status = ISO_OK;
    while (status == ISO_OK && getline(&line, &room, file) > 0) {
        if (++count > MOST_FILES)
            status = iso_fail(err, ISO_E_RANGE, "%s: names more than %d data files", header, MOST_FILES);
        else if (*trim(line))
            status = check_file(header, trim(line), err);
    }
    free(line);
    return status;
}

iso_status iso_nrrd_check_files(const char *path, iso_error *err)
{
    FILE *file = fopen(path, "re");
    if (!file)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    char *line = NULL;
    size_t room = 0, bytes = 0;
    iso_status status = ISO_OK;
    for (ssize_t n; status == ISO_OK && bytes < HEADER_BYTES && (n = getline(&line, &room, file)) > 0 &&
                    *line != '\n' && *line != '\r';
         bytes += (size_t)n) {
        if (strncasecmp(line, "data file:", 10) != 0 && strncasecmp(line, "datafile:", 9) != 0)
            continue;
        char *value = trim(strchr(line, ':') + 1);
        status = strncmp(value, "LIST", 4) == 0 ? check_list(path, file, err)
                 : strchr(value, '%')           ? check_pattern(path, value, err)
                                                : check_file(path, value, err);
    }
    free(line);
    fclose(file);
    return status;
}
