/* SPDX-License-Identifier: MIT */
/* sink.c - NRRD files plane by plane. The header is short enough to be written
 * here, which teem, wanting all samples in memory, would not allow; tests read
 * it back through teem. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "base/file.h"
#include "volume/stream.h"

#define GZ_CHUNK_BYTES ((size_t)1 << 30)

struct iso_volume_sink {
    iso_output output;
    iso_volume like;
    FILE *file;
    gzFile gz;
    size_t planes_done;
};

static bool write_header(FILE *file, const iso_volume *v, bool gzip)
{
    const iso_geometry *g = &v->geometry;
    iso_vec3 first = iso_geometry_to_world(g, iso_v3(0.5, 0.5, 0.5));
    const char *endian = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? "little" : "big";
    fprintf(file, "NRRD0005\n# made by isoshade\ntype: %s\ndimension: 3\n", iso_type_name(v->type));
    fprintf(file, v->notes.world_is_ras ? "space: right-anterior-superior\n" : "space dimension: 3\n");
    fprintf(file, "sizes: %zu %zu %zu\nspace directions:", g->size[0], g->size[1], g->size[2]);
    for (int a = 0; a < 3; ++a) {
        iso_vec3 c = iso_column(g->index_to_world, a);
        fprintf(file, " (%.17g,%.17g,%.17g)", c.x, c.y, c.z);
    }
    fprintf(file, "\ncenterings: cell cell cell\nkinds: domain domain domain\nendian: %s\nencoding: %s\n", endian,
            gzip ? "gzip" : "raw");
    fprintf(file, "space units: \"mm\" \"mm\" \"mm\"\nspace origin: (%.17g,%.17g,%.17g)\n", first.x, first.y, first.z);
    if (v->notes.scale_slope != 1 || v->notes.scale_intercept != 0)
        fprintf(file, "scale_slope:=%.17g\nscale_intercept:=%.17g\n", v->notes.scale_slope, v->notes.scale_intercept);
    return fprintf(file, "\n") > 0 && fflush(file) == 0;
}

static iso_status write_failed(const iso_volume_sink *s, iso_error *err)
{
    return iso_fail(err, ISO_E_IO, "%s: cannot be written: %s", s->output.final_path, strerror(errno ? errno : EIO));
}

iso_status iso_sink_open(const char *path, const iso_volume *like, bool gzip, iso_volume_sink **sink, iso_error *err)
{
    *sink = NULL;
    NEED(iso_geometry_check(&like->geometry, path, err));
    iso_volume_sink *s = calloc(1, sizeof *s);
    NEED_MEMORY(s, err, "%s: out of memory", path);
    s->like = *like;
    s->like.data = NULL;
    iso_status status = iso_output_begin(&s->output, path, err);
    if (status == ISO_OK) {
        errno = 0;
        s->file = fopen(s->output.temp_path, "wb");
        bool good = s->file && write_header(s->file, like, gzip);
        if (good && gzip) {
            int fd = dup(fileno(s->file));
            s->gz = fd < 0 ? NULL : gzdopen(fd, "wb");
            good = s->gz != NULL;
        }
        if (!good)
            status = write_failed(s, err);
    }
    if (status != ISO_OK)
        iso_sink_abandon(s);
    else
        *sink = s;
    return status;
}

iso_status iso_sink_write(iso_volume_sink *s, size_t plane_count, const void *planes, iso_error *err)
{
    const size_t *n = s->like.geometry.size;
    size_t bytes = n[0] * n[1] * iso_type_bytes(s->like.type) * plane_count;
    if (plane_count > n[2] - s->planes_done)
        return iso_fail(err, ISO_E_RANGE, "%s: plane %zu given, there are %zu", s->output.final_path,
                        s->planes_done + plane_count, n[2]);
    errno = 0;
    bool good = true;
    for (size_t done = 0; s->gz && good && done < bytes;) {
        size_t chunk = bytes - done < GZ_CHUNK_BYTES ? bytes - done : GZ_CHUNK_BYTES;
        good = gzwrite(s->gz, (const char *)planes + done, (unsigned)chunk) == (int)chunk;
        done += chunk;
    }
    if (!s->gz)
        good = fwrite(planes, 1, bytes, s->file) == bytes;
    s->planes_done += plane_count;
    return good ? ISO_OK : write_failed(s, err);
}

/* True when all bytes reached the file. */
static bool close_files(iso_volume_sink *s)
{
    errno = 0;
    bool good = true;
    if (s->gz)
        good = gzclose(s->gz) == Z_OK;
    if (s->file && fclose(s->file) != 0)
        good = false;
    s->gz = NULL;
    s->file = NULL;
    return good;
}

iso_status iso_sink_commit(iso_volume_sink *s, iso_error *err)
{
    iso_status status = ISO_OK;
    if (s->planes_done != s->like.geometry.size[2])
        status = iso_fail(err, ISO_E_RANGE, "%s: %zu planes written, there are %zu", s->output.final_path,
                          s->planes_done, s->like.geometry.size[2]);
    else if (!close_files(s))
        status = write_failed(s, err);
    else
        status = iso_output_commit(&s->output, err);
    iso_sink_abandon(s);
    return status;
}

void iso_sink_abandon(iso_volume_sink *s)
{
    if (!s)
        return;
    close_files(s);
    iso_output_abandon(&s->output);
    free(s);
}
