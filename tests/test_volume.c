/* SPDX-License-Identifier: MIT */
#include "folder.h"
#include "test.h"

#include <math.h>
#include <nifti1.h>
#include <nifti2.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "base/file.h"
#include "volume/stream_kernel.h"

/* A path in the test's folder; one at a time. */
static const char *in_dir(const char *name)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static void write_bytes(const char *name, const void *bytes, size_t size)
{
    unlink(in_dir(name)); /* truncating a file makes some file systems flush it */
    FILE *file = fopen(in_dir(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

/* A header as text, then samples. */
static void write_nrrd(const char *name, const char *header, const void *samples, size_t bytes)
{
    FILE *file = fopen(in_dir(name), "wb");
    assert_non_null(file);
    fputs(header, file);
    fwrite(samples, 1, bytes, file);
    fclose(file);
}

/* A rotation about z by 30 degrees, unequal spacings, a corner off the origin. */
static iso_geometry turned_geometry(size_t nx, size_t ny, size_t nz)
{
    iso_geometry g = iso_geometry_axis_aligned((size_t[]){nx, ny, nz}, (double[]){1, 1.5, 2.5});
    double c = cos(0.5), s = sin(0.5);
    g.index_to_world = (iso_mat3){{{c, -s * 1.5, 0}, {s, c * 1.5, 0}, {0, 0, 2.5}}};
    g.origin_mm = iso_v3(-7, 11, 0.25);
    return g;
}

static void assert_same_geometry(const iso_geometry *a, const iso_geometry *b)
{
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(a->size[i], b->size[i]);
        assert_within(a->box_index[i], b->box_index[i], 0);
        for (int j = 0; j < 3; ++j) /* 17 digits in the file; the corner is recomputed from a centre */
            assert_within(a->index_to_world.m[i][j], b->index_to_world.m[i][j], 1e-15);
    }
    assert_within(iso_norm(iso_sub(a->origin_mm, b->origin_mm)), 0, 1e-13);
}

/* Samples that use the type's whole width, different at every voxel. */
static void fill(iso_volume *v)
{
    size_t count = iso_geometry_voxel_count(&v->geometry), bytes = iso_type_bytes(v->type);
    for (size_t i = 0; i < count; ++i) {
        if (v->type == ISO_F32)
            ((float *)v->data)[i] = (float)i * -1.37f;
        else if (v->type == ISO_F64)
            ((double *)v->data)[i] = (double)i * 1e-3 + 1e9;
        else
            for (size_t b = 0; b < bytes; ++b)
                ((unsigned char *)v->data)[i * bytes + b] = (unsigned char)(i * 7 + b * 31 + 200);
    }
}

static void every_type_comes_back_from_raw_and_gzip_files(void **state)
{
    (void)state;
    iso_geometry g = turned_geometry(5, 4, 3);
    for (int type = ISO_U8; type <= ISO_F64; ++type)
        for (int gzip = 0; gzip < 2; ++gzip) {
            iso_volume v, back;
            assert_ok(iso_volume_create(&v, &g, (iso_type)type, "v", &err));
            fill(&v);
            v.notes = (iso_volume_notes){.world_is_ras = gzip, .scale_slope = 2.5, .scale_intercept = -1000};
            assert_ok(iso_volume_save(&v, in_dir("v.nrrd"), gzip, &err));
            assert_ok(iso_volume_load(in_dir("v.nrrd"), &back, &err));
            assert_int_equal(back.type, type);
            assert_same_geometry(&back.geometry, &g);
            assert_memory_equal(back.data, v.data, 60 * iso_type_bytes(v.type));
            assert_int_equal(back.notes.world_is_ras, gzip);
            assert_within(back.notes.scale_slope, 2.5, 0);
            assert_within(back.notes.scale_intercept, -1000, 0);
            iso_volume_destroy(&v);
            iso_volume_destroy(&back);
        }
}

static void planes_one_by_one_equal_the_whole(void **state)
{
    (void)state;
    iso_geometry g = turned_geometry(6, 5, 7);
    iso_volume v;
    assert_ok(iso_volume_create(&v, &g, ISO_U16, "v", &err));
    fill(&v);
    for (int gzip = 0; gzip < 2; ++gzip) {
        iso_volume_sink *sink;
        assert_ok(iso_sink_open(in_dir("p.nrrd"), &v, gzip, &sink, &err));
        for (size_t z = 0; z < 7; ++z)
            assert_ok(iso_sink_write(sink, 1, (uint16_t *)v.data + 30 * z, &err));
        assert_ok(iso_sink_commit(sink, &err));
        iso_volume_source *source;
        uint16_t planes[90];
        assert_ok(iso_source_open(in_dir("p.nrrd"), &source, &err));
        for (size_t z = 0; z < 7; z += 3) {
            size_t n = z + 3 < 7 ? 3 : 7 - z;
            assert_ok(iso_source_read(source, n, planes, &err));
            assert_memory_equal(planes, (uint16_t *)v.data + 30 * z, n * 60);
        }
        assert_status(iso_source_read(source, 1, planes, &err), ISO_E_RANGE);
        iso_source_close(source);
    }
    iso_volume_destroy(&v);
}

/* ---- a format from this file alone ---- */

static int readers_closed;

static bool starts_like_counting(const unsigned char *head, size_t size)
{
    return size >= 8 && memcmp(head, "COUNTING", 8) == 0;
}

/* Samples that no file holds: their own number. */
static iso_status count_planes(iso_volume_source *source, size_t plane_count, void *out, iso_error *err)
{
    const size_t *n = source->header.geometry.size, plane = n[0] * n[1];
    (void)err;
    for (size_t i = 0; i < plane * plane_count; ++i)
        ((uint16_t *)out)[i] = (uint16_t)(source->planes_done * plane + i);
    return ISO_OK;
}

static void close_counting(iso_volume_source *source)
{
    free(source->reader);
    ++readers_closed;
}

static iso_status open_counting(iso_volume_source *source, iso_error *err)
{
    source->header.type = ISO_U16;
    source->header.geometry = iso_geometry_axis_aligned((size_t[]){5, 3, 4}, (double[]){1, 2, 3});
    source->header.notes.scale_slope = 2;
    source->reader = malloc(1);
    source->read_planes = count_planes;
    source->close_reader = close_counting;
    return iso_geometry_check(&source->header.geometry, source->path, err);
}

static const iso_volume_format counting = {
    .name = "counting",
    .title = "COUNTING",
    .summary = "numbers",
    .suffixes = ".cnt .cnt.long",
    .starts = "\"COUNTING\"",
    .probe = starts_like_counting,
    .open = open_counting,
};

static void a_format_of_this_test_alone_is_read_skipped_and_named(void **state)
{
    (void)state;
    iso_volume v;
    iso_error why;
    write_bytes("a.cnt", "COUNTING", 8);
    assert_int_equal(iso_volume_load(in_dir("a.cnt"), &v, &why), ISO_E_FORMAT); /* not yet */
    assert_null(strstr(why.text, "COUNTING ("));
    assert_ok(iso_volume_format_add(&counting, &err));
    assert_ok(iso_volume_load(in_dir("a.cnt"), &v, &err));
    for (size_t i = 0; i < 60; ++i)
        assert_int_equal(((uint16_t *)v.data)[i], i);
    iso_volume_destroy(&v);
    iso_volume_source *source;
    float row[15];
    assert_ok(iso_source_open(in_dir("a.cnt"), &source, &err));
    iso_source_apply_scale(source);
    assert_ok(iso_source_skip(source, 2, &err));
    assert_ok(iso_source_read(source, 1, row, &err));
    assert_int_equal(row[0], 2 * 30);
    iso_source_close(source);
    assert_int_equal(readers_closed, 2);
    write_bytes("b.cnt", "COUNTERS", 8);
    assert_int_equal(iso_volume_load(in_dir("b.cnt"), &v, &why), ISO_E_FORMAT);
    assert_non_null(strstr(why.text, "COUNTING (\"COUNTING\")"));
    assert_non_null(strstr(why.text, "NRRD (\"NRRD000N\")"));
    assert_int_equal(iso_volume_format_suffix_bytes("a.cnt"), 4);
    assert_int_equal(iso_volume_format_suffix_bytes("a.cnt.long"), 9);
    assert_int_equal(iso_volume_format_suffix_bytes(".cnt"), 0);
    assert_int_equal(iso_volume_format_suffix_bytes("a.nii.gz"), 7);
}

static void each_format_has_a_whole_row(void **state)
{
    (void)state;
    for (size_t i = 0; i < iso_volume_format_names.count; ++i) {
        const iso_volume_format *f = iso_volume_format_at(i);
        assert_true(f->name && *f->name && f->title && *f->title && f->summary && *f->summary && f->suffixes[0] == '.');
        assert_true(!f->probe == !f->open && !f->probe == !f->starts);
        size_t row = 99;
        assert_ok(iso_names_find(&iso_volume_format_names, f->name, &row, &err)); /* and its name is its own */
        assert_int_equal(row, i);
    }
}

static void a_sink_that_lacks_planes_leaves_no_file(void **state)
{
    (void)state;
    iso_geometry g = turned_geometry(2, 2, 3);
    iso_volume like = {.geometry = g, .type = ISO_U8, .notes = {.scale_slope = 1}};
    iso_volume_sink *sink;
    assert_ok(iso_sink_open(in_dir("lack.nrrd"), &like, false, &sink, &err));
    assert_ok(iso_sink_write(sink, 2, "12345678", &err));
    assert_status(iso_sink_commit(sink, &err), ISO_E_RANGE);
    assert_false(iso_path_exists(in_dir("lack.nrrd")));
}

static void both_byte_orders_and_detached_headers_are_read(void **state)
{
    (void)state;
    static const unsigned char big[] = {0, 1, 0, 2, 255, 255, 128, 0}, little[] = {1, 0, 2, 0, 255, 255, 0, 128};
    static const int16_t wanted[] = {1, 2, -1, -32768};
    iso_volume v;
    write_nrrd("b.nrrd", "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 1 2\nendian: big\nencoding: raw\n\n", big, 8);
    assert_ok(iso_volume_load(in_dir("b.nrrd"), &v, &err));
    assert_memory_equal(v.data, wanted, 8);
    iso_volume_destroy(&v);
    write_nrrd("l.nrrd",
               "NRRD0001\r\ntype: int16\r\ndimension: 3\r\nsizes: 2 1 2\r\nendian: little\r\nencoding: raw\r\n\r\n",
               little, 8);
    assert_ok(iso_volume_load(in_dir("l.nrrd"), &v, &err));
    assert_memory_equal(v.data, wanted, 8);
    iso_volume_destroy(&v);
    write_bytes("d.raw", "xyz\0\1\0\2\377\377\200\0", 11);
    write_nrrd(
        "d.nhdr",
        "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 1 2\nendian: big\nencoding: raw\nbyte skip: 3\ndata file: d.raw\n",
        "", 0);
    assert_ok(iso_volume_load(in_dir("d.nhdr"), &v, &err));
    assert_memory_equal(v.data, wanted, 8);
    iso_volume_destroy(&v);
    write_nrrd(
        "e.nhdr",
        "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 1 2\nendian: big\nencoding: raw\nbyte skip: -1\ndata file: d.raw\n",
        "", 0);
    assert_ok(iso_volume_load(in_dir("e.nhdr"), &v, &err));
    assert_memory_equal(v.data, wanted, 8);
    iso_volume_destroy(&v);
    gzFile gz = gzopen(in_dir("d.raw.gz"), "wb");
    gzwrite(gz, big, 8);
    gzclose(gz);
    write_nrrd("g.nhdr",
               "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 1 2\nendian: big\nencoding: gzip\ndata file: d.raw.gz\n",
               "", 0);
    assert_ok(iso_volume_load(in_dir("g.nhdr"), &v, &err));
    assert_memory_equal(v.data, wanted, 8);
    iso_volume_destroy(&v);
}

static void text_samples_and_slices_in_files_of_their_own_are_read(void **state)
{
    (void)state;
    iso_volume v;
    write_nrrd("t.nrrd", "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 1 2\nencoding: ascii\n\n", "1 2.5 -3 4e3\n",
               13);
    assert_ok(iso_volume_load(in_dir("t.nrrd"), &v, &err));
    assert_memory_equal(v.data, ((float[]){1, 2.5f, -3, 4e3f}), 16);
    iso_volume_destroy(&v);
    write_bytes("s0.raw", "ab", 2);
    write_bytes("s1.raw", "cd", 2);
    write_nrrd("s.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 2\nencoding: raw\ndata file: s%d.raw 0 1 1\n",
               "", 0);
    assert_ok(iso_volume_load(in_dir("s.nhdr"), &v, &err));
    assert_memory_equal(v.data, "abcd", 4);
    iso_volume_destroy(&v);
}

static iso_geometry geometry_of(const char *header)
{
    iso_volume v;
    write_nrrd("geo.nrrd", header, "12345678", 8);
    assert_ok(iso_volume_load(in_dir("geo.nrrd"), &v, &err));
    iso_geometry g = v.geometry;
    iso_volume_destroy(&v);
    return g;
}

#define HEAD "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n"

static void the_space_origin_is_the_center_of_the_first_sample(void **state)
{
    (void)state;
    iso_geometry g = geometry_of(
        HEAD "space dimension: 3\nspace directions: (0,2,0) (0,0,3) (5,0,0)\nspace origin: (10,20,30)\n\n");
    iso_vec3 center = iso_geometry_to_world(&g, iso_v3(0.5, 0.5, 0.5));
    assert_within(iso_norm(iso_sub(center, iso_v3(10, 20, 30))), 0, 1e-14);
    assert_within(iso_norm(iso_sub(g.origin_mm, iso_v3(7.5, 19, 28.5))), 0, 1e-14);
    assert_within(g.index_to_world.m[1][0], 2, 0); /* the step along x is the first column */
    assert_within(g.index_to_world.m[2][1], 3, 0);
    assert_within(g.index_to_world.m[0][2], 5, 0);
}

static void anatomical_spaces_become_right_anterior_superior(void **state)
{
    (void)state;
#define FRAME "\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (10,20,30)\n\n"
    iso_geometry lps = geometry_of(HEAD "space: left-posterior-superior" FRAME);
    assert_within(iso_norm(iso_sub(iso_geometry_to_world(&lps, iso_v3(0.5, 0.5, 0.5)), iso_v3(-10, -20, 30))), 0,
                  1e-14);
    assert_within(lps.index_to_world.m[0][0], -1, 0);
    assert_within(lps.index_to_world.m[1][1], -2, 0);
    assert_within(iso_mat3_det(lps.index_to_world), 6, 1e-14); /* a half turn: right-handed still */
    iso_geometry las = geometry_of(HEAD "space: left-anterior-superior" FRAME);
    assert_within(iso_mat3_det(las.index_to_world), -6, 1e-14); /* a reflection */
    iso_geometry ras = geometry_of(HEAD "space: RAS" FRAME);
    assert_within(iso_norm(iso_sub(iso_geometry_to_world(&ras, iso_v3(0.5, 0.5, 0.5)), iso_v3(10, 20, 30))), 0, 1e-14);
}

static void spacings_axis_mins_and_units_are_kept(void **state)
{
    (void)state;
    iso_geometry g = geometry_of(HEAD "spacings: 1 2 3\n\n");
    assert_within(iso_norm(iso_sub(g.origin_mm, iso_v3(-1, -2, -3))), 0, 0); /* centred */
    g = geometry_of(HEAD "spacings: 1 2 3\naxis mins: 5 6 7\ncenterings: cell cell node\n\n");
    assert_within(iso_norm(iso_sub(g.origin_mm, iso_v3(5, 6, 5.5))), 0, 0);
    g = geometry_of(HEAD "spacings: 100 100 100\nunits: \"um\" \"um\" \"um\"\n\n");
    double spacing[3];
    iso_geometry_spacing_mm(&g, spacing);
    assert_within(spacing[1], 0.1, 1e-15);
    g = geometry_of(
        HEAD
        "space dimension: 3\nspace units: \"cm\" \"cm\" \"cm\"\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (1,1,1)\n\n");
    assert_within(g.origin_mm.x, 5, 1e-14);
}

static nifti_1_header nifti_header(short nx, short ny, short nz)
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

static void write_nifti(const char *name, nifti_1_header h, const void *samples, size_t bytes, bool gzip)
{
    gzFile gz = gzopen(in_dir(name), gzip ? "wb" : "wbT");
    gzwrite(gz, &h, 348);
    gzwrite(gz, "\0\0\0\0", 4);
    gzwrite(gz, samples, (unsigned)bytes);
    gzclose(gz);
}

static const int16_t nifti_samples[12] = {5, -6, 7, -8, 9, 10, 11, 12, 13, 14, 15, -32768};

static void nifti_places_centers_by_its_sform(void **state)
{
    (void)state;
    nifti_1_header h = nifti_header(2, 3, 2);
    h.sform_code = 1, h.qform_code = 1; /* the sform goes first */
    float rows[3][4] = {{0, -2, 0, 10}, {1, 0, 0, 20}, {0, 0, 3, 30}};
    memcpy(h.srow_x, rows[0], 16), memcpy(h.srow_y, rows[1], 16), memcpy(h.srow_z, rows[2], 16);
    h.scl_slope = 2, h.scl_inter = -1024;
    for (int gzip = 0; gzip < 2; ++gzip) {
        const char *name = gzip ? "n.nii.gz" : "n.nii";
        iso_volume v;
        write_nifti(name, h, nifti_samples, 24, gzip);
        assert_ok(iso_volume_load(in_dir(name), &v, &err));
        assert_int_equal(v.type, ISO_I16);
        assert_memory_equal(v.data, nifti_samples, 24);
        iso_vec3 at = iso_geometry_to_world(&v.geometry, iso_v3(1.5, 2.5, 0.5)); /* the centre of voxel (1, 2, 0) */
        assert_within(iso_norm(iso_sub(at, iso_v3(10 - 4, 20 + 1, 30))), 0, 1e-14);
        assert_true(v.notes.world_is_ras);
        assert_within(v.notes.scale_slope, 2, 0);
        assert_within(v.notes.scale_intercept, -1024, 0);
        iso_volume_destroy(&v);
    }
}

static void nifti_places_centers_by_its_qform(void **state)
{
    (void)state;
    nifti_1_header h = nifti_header(2, 3, 2);
    h.qform_code = 1;
    h.quatern_d = sqrtf(0.5f); /* a quarter turn about z */
    h.qoffset_x = 10, h.qoffset_y = 20, h.qoffset_z = 30;
    h.pixdim[0] = -1; /* and z reflected */
    iso_volume v;
    write_nifti("q.nii", h, nifti_samples, 24, false);
    assert_ok(iso_volume_load(in_dir("q.nii"), &v, &err));
    iso_vec3 at = iso_geometry_to_world(&v.geometry, iso_v3(1.5, 2.5, 1.5));
    assert_within(iso_norm(iso_sub(at, iso_v3(10 - 4, 20 + 1, 30 - 3))), 0, 2e-6); /* libnifti's floats */
    iso_volume_destroy(&v);
}

static void swap2(void *p, int count)
{
    unsigned char *b = p;
    for (int i = 0; i < count; ++i, b += 2) {
        unsigned char t = b[0];
        b[0] = b[1], b[1] = t;
    }
}

static void swap4(void *p, int count)
{
    unsigned char *b = p;
    for (int i = 0; i < count; ++i, b += 4) {
        unsigned char t[4] = {b[3], b[2], b[1], b[0]};
        memcpy(b, t, 4);
    }
}

static void nifti_of_the_other_byte_order_and_in_two_files_is_read(void **state)
{
    (void)state;
    nifti_1_header h = nifti_header(2, 3, 2);
    int16_t samples[12];
    memcpy(samples, nifti_samples, 24);
    swap4(&h.sizeof_hdr, 1), swap2(h.dim, 8), swap2(&h.datatype, 2), swap4(h.pixdim, 8), swap4(&h.vox_offset, 1);
    swap2(samples, 12);
    iso_volume v;
    write_nifti("o.nii", h, samples, 24, false);
    assert_ok(iso_volume_load(in_dir("o.nii"), &v, &err));
    assert_memory_equal(v.data, nifti_samples, 24);
    double spacing[3];
    iso_geometry_spacing_mm(&v.geometry, spacing);
    assert_within(spacing[2], 3, 0);
    assert_within(v.geometry.origin_mm.z, -3, 0); /* bare spacings: centred */
    iso_volume_destroy(&v);
    h = nifti_header(2, 3, 2);
    memcpy(h.magic, "ni1", 4);
    h.vox_offset = 0;
    write_bytes("two.hdr", &h, 348);
    write_bytes("two.img", nifti_samples, 24);
    assert_ok(iso_volume_load(in_dir("two.hdr"), &v, &err));
    assert_memory_equal(v.data, nifti_samples, 24);
    iso_volume_destroy(&v);
}

static void raw_files_follow_the_layout_that_is_given(void **state)
{
    (void)state;
    write_bytes("r.raw", "??\0\1\0\2\0\3\0\4\0\5\0\6", 14);
    iso_raw_layout layout = {
        .type = ISO_U16, .size = {3, 1, 2}, .spacing_mm = {1, 2, 3}, .big_endian = true, .skip_bytes = 2};
    iso_volume v;
    assert_ok(iso_volume_load_raw(in_dir("r.raw"), &layout, &v, &err));
    float row[3];
    iso_volume_row(&v, 0, 1, row);
    assert_memory_equal(row, ((float[]){4, 5, 6}), 12);
    iso_volume_destroy(&v);
    layout.skip_bytes = 1;
    assert_status(iso_volume_load_raw(in_dir("r.raw"), &layout, &v, &err), ISO_E_FORMAT);
    layout.skip_bytes = 3;
    assert_status(iso_volume_load_raw(in_dir("r.raw"), &layout, &v, &err), ISO_E_FORMAT);
    layout.size[0] = (size_t)1 << 62;
    assert_status(iso_volume_load_raw(in_dir("r.raw"), &layout, &v, &err), ISO_E_RANGE);
}

/* The status, and what the message has to name besides the file. */
static void assert_refused(const char *name, iso_status wanted, const char *part)
{
    iso_volume v;
    iso_error err = {""};
    iso_status status = iso_volume_load(in_dir(name), &v, &err);
    if (status != wanted || !strstr(err.text, name) || !strstr(err.text, part) || strchr(err.text, '\n') || v.data)
        fail_msg("%s: status %d, wanted %d and \"%s\": %s", name, (int)status, (int)wanted, part, err.text);
}

static void bad_nrrd_files_are_refused_with_the_reason(void **state)
{
    (void)state;
    static const struct {
        const char *header, *samples, *part;
        iso_status status;
    } cases[] = {
        {"", "", "empty", ISO_E_FORMAT},
        {"NRRX0004\ntype: uchar\n\n", "", "NRRX0004", ISO_E_FORMAT},
        {HEAD "\n", "1234567", "holds 7 bytes of samples, 2 x 2 x 2 of uint8 need 8", ISO_E_FORMAT},
        {HEAD "\n", "123456789", "too long", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\n", "", "hit end of header", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 0 2\nencoding: raw\n\n", "1", "", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4000000000 4000000000 4000000000\nencoding: raw\n\n", "1", "",
         ISO_E_RANGE},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 100000 100000 100\nencoding: raw\n\n", "1", "need 1000000000000",
         ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 100000 100000 100\nencoding: gzip\n\n", "1", "cannot hold",
         ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 100000 100000 100\nencoding: ascii\n\n", "1 2 3", "cannot hold",
         ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: gzip\n\n", "12345678", "not gzip", ISO_E_FORMAT},
        {"NRRD0004\ntype: quaternion\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n", "12345678", "quaternion",
         ISO_E_FORMAT},
        {"NRRD0004\ntype: int64\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nendian: little\n\n", "12345678",
         "8, 16 or 32 bits", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 2\nsizes: 2 4\nencoding: raw\n\n", "12345678",
         "2 axes, a scalar volume has 3", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 2 1 2\nencoding: raw\n\n", "123456789012", "4 axes",
         ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 2\nkinds: RGB-color domain domain\nencoding: raw\n\n",
         "123456789012", "RGB-color", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspacings: 1 0 1\n\n", "12345678", "",
         ISO_E_FORMAT},
        {HEAD "space dimension: 3\nspace directions: (1,0,0) (1,0,0) (0,0,1)\n\n", "12345678", "span no volume",
         ISO_E_RANGE},
        {HEAD "data file: nowhere.raw\n", "", "nowhere.raw", ISO_E_FORMAT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        write_nrrd("bad.nrrd", cases[i].header, cases[i].samples, strlen(cases[i].samples));
        assert_refused("bad.nrrd", cases[i].status, cases[i].part);
    }
    iso_volume v;
    assert_status(iso_volume_load(in_dir("absent.nrrd"), &v, &err), ISO_E_IO);
    assert_status(iso_volume_load(folder, &v, &err), ISO_E_IO);
}

static void swap8(void *p, int count)
{
    unsigned char *b = p;
    for (int i = 0; i < count; ++i, b += 8)
        for (int k = 0; k < 4; ++k) {
            unsigned char t = b[k];
            b[k] = b[7 - k], b[7 - k] = t;
        }
}

static nifti_2_header nifti_2(void)
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

static void write_nifti_2(const char *name, nifti_2_header h, const void *samples, size_t bytes, bool gzip)
{
    gzFile gz = gzopen(in_dir(name), gzip ? "wb" : "wbT");
    gzwrite(gz, &h, 540);
    gzwrite(gz, "\0\0\0\0", 4);
    gzwrite(gz, samples, (unsigned)bytes);
    gzclose(gz);
}

static void nifti_2_is_read_in_both_byte_orders(void **state)
{
    (void)state;
    for (int i = 0; i < 4; ++i) {
        nifti_2_header h = nifti_2();
        int16_t samples[12];
        memcpy(samples, nifti_samples, 24);
        if (i & 1) { /* every field, by the table of its header */
            swap4(&h.sizeof_hdr, 1), swap2(&h.datatype, 2), swap8(h.dim, 8), swap8(h.pixdim, 8),
                swap8(&h.vox_offset, 3);
            swap4(&h.sform_code, 1), swap8(h.srow_x, 12), swap4(&h.xyzt_units, 1);
            swap2(samples, 12);
        }
        iso_volume v;
        write_nifti_2("two.nii", h, samples, 24, i & 2);
        assert_ok(iso_volume_load(in_dir("two.nii"), &v, &err));
        assert_memory_equal(v.data, nifti_samples, 24);
        iso_vec3 at = iso_geometry_to_world(&v.geometry, iso_v3(1.5, 2.5, 0.5));
        assert_within(iso_norm(iso_sub(at, iso_v3(10.000000001 - 4, 20 + 1, 30))), 0,
                      1e-14); /* a float has no such 10 */
        assert_within(v.notes.scale_slope, 2, 0);
        iso_volume_destroy(&v);
    }
    nifti_2_header h = nifti_2();
    write_bytes("bad.nii", &h, 539);
    assert_refused("bad.nii", ISO_E_FORMAT, "truncated: 539 bytes, a NIfTI-2 header has 540");
    h.magic[4] = 'x'; /* as a transfer that turned the line's end would */
    write_nifti_2("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_FORMAT, "NIfTI-2 has \"n+2\"");
    h = nifti_2(), h.vox_offset = 352;
    write_nifti_2("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_RANGE, "samples start at byte 352, must be 544");
    h = nifti_2(), h.dim[1] = (int64_t)1 << 40;
    write_nifti_2("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_FORMAT, "need 13194139533312");
}

static void a_scale_is_applied_where_asked_for(void **state)
{
    (void)state;
    write_nifti_2("scaled.nii", nifti_2(), nifti_samples, 24, false);
    for (int apply = 0; apply < 2; ++apply) {
        iso_volume_source *source;
        float planes[6];
        assert_ok(iso_source_open(in_dir("scaled.nii"), &source, &err));
        if (apply)
            iso_source_apply_scale(source);
        assert_int_equal(iso_source_volume(source)->type, apply ? ISO_F32 : ISO_I16);
        assert_within(iso_source_volume(source)->notes.scale_slope, apply ? 1 : 2, 0);
        assert_ok(iso_source_skip(source, 1, &err));
        assert_ok(iso_source_read(source, 1, planes, &err));
        for (int i = 0; i < 6; ++i)
            assert_within(apply ? (double)planes[i] : ((int16_t *)(void *)planes)[i],
                          apply ? 2 * nifti_samples[6 + i] - 1024 : nifti_samples[6 + i], 0);
        assert_status(iso_source_skip(source, 1, &err), ISO_E_RANGE);
        iso_source_close(source);
    }
}

static void bad_nifti_files_are_refused_with_the_reason(void **state)
{
    (void)state;
    const nifti_1_header good = nifti_header(2, 3, 2);
    nifti_1_header h = good;
    write_bytes("bad.nii", &h, 200);
    assert_refused("bad.nii", ISO_E_FORMAT, "truncated: 200 bytes");
    memcpy(h.magic, "abc", 4);
    write_nifti("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_FORMAT, "magic");
    write_nifti("bad.nii", good, nifti_samples, 22, false);
    assert_refused("bad.nii", ISO_E_FORMAT, "holds 22 bytes of samples");
    write_nifti("bad.nii", good, nifti_samples, 22, true);
    assert_refused("bad.nii", ISO_E_FORMAT, "truncated");
    h = good, h.dim[0] = 4, h.dim[4] = 2;
    write_nifti("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_FORMAT, "4 axes");
    h = good, h.datatype = 128; /* RGB24 */
    write_nifti("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_FORMAT, "data type 128");
    h = good, h.dim[2] = -3;
    write_nifti("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_RANGE, "axis 2 has size -3");
    h = good, h.vox_offset = NAN;
    write_nifti("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_RANGE, "samples start");
    h = good, h.pixdim[1] = NAN;
    write_nifti("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_RANGE, "span no volume");
}

static void non_finite_voxels_are_counted_and_the_first_is_named(void **state)
{
    (void)state;
    iso_geometry g = turned_geometry(5, 4, 3);
    iso_volume v;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "v", &err));
    ((float *)v.data)[(1 * 4 + 2) * 5 + 3] = NAN;
    ((float *)v.data)[(2 * 4 + 0) * 5 + 1] = -INFINITY;
    assert_ok(iso_volume_save(&v, in_dir("nan.nrrd"), false, &err));
    assert_refused("nan.nrrd", ISO_E_RANGE, "2 of 60 voxels are NaN or infinite, none may be; the first is (3, 2, 1)");
    iso_volume_destroy(&v);
}

static void damage_inside_compressed_samples_is_found(void **state)
{
    (void)state;
    iso_geometry g = turned_geometry(16, 16, 16);
    iso_volume v;
    char *bytes;
    size_t size;
    assert_ok(iso_volume_create(&v, &g, ISO_U16, "v", &err));
    fill(&v);
    assert_ok(iso_volume_save(&v, in_dir("z.nrrd"), true, &err));
    assert_ok(iso_file_read(in_dir("z.nrrd"), &bytes, &size, &err));
    bytes[size - 6] ^= 1; /* the checksum behind the data */
    write_bytes("crc.nrrd", bytes, size);
    assert_refused("crc.nrrd", ISO_E_FORMAT, "damaged");
    bytes[size - 6] ^= 1;
    write_bytes("cut.nrrd", bytes, size - 9);
    assert_refused("cut.nrrd", ISO_E_FORMAT, "cut.nrrd: ");
    write_bytes("tail.nrrd", bytes, size - 4); /* all samples are there, only the checksum's end is not */
    assert_refused("tail.nrrd", ISO_E_FORMAT, "the end is missing");
    free(bytes);
    iso_volume_destroy(&v);
}

static void statistics_are_those_of_the_samples(void **state)
{
    (void)state;
    iso_geometry g = turned_geometry(3, 2, 2);
    iso_volume v;
    assert_ok(iso_volume_create(&v, &g, ISO_I16, "v", &err));
    for (int i = 0; i < 12; ++i)
        ((int16_t *)v.data)[i] = (int16_t)(i - 4);
    iso_volume_stats s = iso_volume_measure(&v);
    assert_within(s.min, -4, 0);
    assert_within(s.max, 7, 0);
    assert_within(s.mean, 1.5, 0);
    assert_int_equal(s.nonfinite_count, 0);
    float all[12];
    iso_volume_floats(&v, all);
    for (int i = 0; i < 12; ++i)
        assert_within(all[i], i - 4, 0);
    iso_volume_destroy(&v);
}

static uint64_t next_random(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return *state >> 33;
}

/* Bytes of a good file are changed or cut off at random: reading must end with
 * a status, and a volume that is accepted must be whole. */
static void fuzz_file(const char *name, const char *bytes, size_t size, size_t header_bytes, uint64_t *random,
                      int rounds)
{
    char *copy = malloc(size);
    for (int round = 0; round < rounds; ++round) {
        memcpy(copy, bytes, size);
        size_t kept = next_random(random) % 4 == 0 ? next_random(random) % size : size;
        int changes = (int)(next_random(random) % 4);
        for (int c = 0; c < changes && kept > 0; ++c) {
            size_t at = next_random(random) % (header_bytes < kept ? header_bytes : kept);
            copy[at] = next_random(random) % 2 ? (char)next_random(random)
                                               : "0123456789 -:,()\n"[next_random(random) % 17];
        }
        write_bytes(name, copy, kept);
        iso_volume v;
        iso_error err = {""};
        iso_status status = iso_volume_load(in_dir(name), &v, &err);
        assert_true(status == ISO_OK ? v.data != NULL : v.data == NULL && err.text[0] && !strchr(err.text, '\n'));
        if (status == ISO_OK) {
            iso_volume_stats s = iso_volume_measure(&v);
            assert_true(isfinite(s.mean) && s.nonfinite_count == 0);
        }
        iso_volume_destroy(&v);
    }
    free(copy);
}

static void damaged_files_never_crash_the_readers(void **state)
{
    (void)state;
    const char *given = getenv("ISOSHADE_FUZZ_SEED");
    uint64_t seed = given ? strtoull(given, NULL, 10) : 20261121, random = seed;
    print_message("fuzz: seed %llu (set ISOSHADE_FUZZ_SEED for another)\n", (unsigned long long)seed);
    const int rounds = 600;
    iso_geometry g = turned_geometry(4, 3, 2);
    iso_volume v;
    char *bytes;
    size_t size;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "v", &err));
    fill(&v);
    for (int gzip = 0; gzip < 2; ++gzip) {
        assert_ok(iso_volume_save(&v, in_dir("seed.nrrd"), gzip, &err));
        assert_ok(iso_file_read(in_dir("seed.nrrd"), &bytes, &size, &err));
        fuzz_file("fuzz.nrrd", bytes, size, size, &random, rounds);
        free(bytes);
    }
    iso_volume_destroy(&v);
    nifti_1_header h = nifti_header(2, 3, 2);
    h.qform_code = 1;
    for (int i = 0; i < 4; ++i) {
        if (i < 2)
            write_nifti("seed.nii", h, nifti_samples, 24, i);
        else
            write_nifti_2("seed.nii", nifti_2(), nifti_samples, 24, i == 3);
        assert_ok(iso_file_read(in_dir("seed.nii"), &bytes, &size, &err));
        fuzz_file("fuzz.nii", bytes, size, size, &random, rounds);
        free(bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_comes_back_from_raw_and_gzip_files),
        cmocka_unit_test(planes_one_by_one_equal_the_whole),
        cmocka_unit_test(a_sink_that_lacks_planes_leaves_no_file),
        cmocka_unit_test(both_byte_orders_and_detached_headers_are_read),
        cmocka_unit_test(text_samples_and_slices_in_files_of_their_own_are_read),
        cmocka_unit_test(the_space_origin_is_the_center_of_the_first_sample),
        cmocka_unit_test(anatomical_spaces_become_right_anterior_superior),
        cmocka_unit_test(spacings_axis_mins_and_units_are_kept),
        cmocka_unit_test(nifti_places_centers_by_its_sform),
        cmocka_unit_test(nifti_places_centers_by_its_qform),
        cmocka_unit_test(nifti_of_the_other_byte_order_and_in_two_files_is_read),
        cmocka_unit_test(raw_files_follow_the_layout_that_is_given),
        cmocka_unit_test(bad_nrrd_files_are_refused_with_the_reason),
        cmocka_unit_test(nifti_2_is_read_in_both_byte_orders),
        cmocka_unit_test(a_scale_is_applied_where_asked_for),
        cmocka_unit_test(bad_nifti_files_are_refused_with_the_reason),
        cmocka_unit_test(non_finite_voxels_are_counted_and_the_first_is_named),
        cmocka_unit_test(damage_inside_compressed_samples_is_found),
        cmocka_unit_test(statistics_are_those_of_the_samples),
        cmocka_unit_test(each_format_has_a_whole_row),
        cmocka_unit_test(a_format_of_this_test_alone_is_read_skipped_and_named),
        cmocka_unit_test(damaged_files_never_crash_the_readers),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
