/* SPDX-License-Identifier: MIT */
/* volume_files.h - files of volumes for tests, in the folder of folder.h. */
#pragma once

#include "folder.h"
#include "test.h"

#include <nifti1.h>
#include <nifti2.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "volume/stream_kernel.h"

/* A path in the test's folder; one at a time. */
static inline const char *in_dir(const char *name)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static inline void write_bytes(const char *name, const void *bytes, size_t size)
{
    unlink(in_dir(name)); /* truncating a file makes some file systems flush it */
    FILE *file = fopen(in_dir(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

static inline nifti_1_header nifti_header(short nx, short ny, short nz)
{
    nifti_1_header h = {.sizeof_hdr = 348,
                        .dim = {3, nx, ny, nz, 1, 1, 1, 1},
                        .datatype = 4,
                        .bitpix = 16,
                        .pixdim = {1, 1, 2, 3, 0, 0, 0, 0},
                        .vox_offset = 352,
                        .xyzt_units = 2,
                        .magic = "n+1"};
    return h;
}

static inline void write_nifti(const char *name, nifti_1_header h, const void *samples, size_t bytes, bool gzip)
{
    gzFile gz = gzopen(in_dir(name), gzip ? "wb" : "wbT");
    gzwrite(gz, &h, 348);
    gzwrite(gz, "\0\0\0\0", 4);
    gzwrite(gz, samples, (unsigned)bytes);
    gzclose(gz);
}

static const int16_t nifti_samples[12] = {5, -6, 7, -8, 9, 10, 11, 12, 13, 14, 15, -32768};

/* The status, and what the message has to name besides the file. */
static inline void assert_refused(const char *name, iso_status wanted, const char *part)
{
    iso_volume v;
    iso_error err = {""};
    iso_status status = iso_volume_load(in_dir(name), &v, &err);
    if (status != wanted || !strstr(err.text, name) || !strstr(err.text, part) || strchr(err.text, '\n') || v.data)
        fail_msg("%s: status %d, wanted %d and \"%s\": %s", name, (int)status, (int)wanted, part, err.text);
}

static inline nifti_2_header nifti_2(void)
{
    nifti_2_header h = {.sizeof_hdr = 540,
                        .magic = {'n', '+', '2', 0, '\r', '\n', '\032', '\n'},
                        .datatype = 4,
                        .bitpix = 16,
                        .dim = {3, 2, 3, 2, 1, 1, 1, 1},
                        .pixdim = {1, 1, 2, 3, 0, 0, 0, 0},
                        .vox_offset = 544,
                        .xyzt_units = 2,
                        .sform_code = 1,
                        .scl_slope = 2,
                        .scl_inter = -1024};
    const double rows[3][4] = {{0, -2, 0, 10.000000001}, {1, 0, 0, 20}, {0, 0, 3, 30}};
    memcpy(h.srow_x, rows[0], 32), memcpy(h.srow_y, rows[1], 32), memcpy(h.srow_z, rows[2], 32);
    return h;
}

static inline void write_nifti_2(const char *name, nifti_2_header h, const void *samples, size_t bytes, bool gzip)
{
    gzFile gz = gzopen(in_dir(name), gzip ? "wb" : "wbT");
    gzwrite(gz, &h, 540);
    gzwrite(gz, "\0\0\0\0", 4);
    gzwrite(gz, samples, (unsigned)bytes);
    gzclose(gz);
}
