/* SPDX-License-Identifier: MIT */
#include "folder.h"
#include "volume_files.h"
#include "test.h"

#include <nifti1.h>
#include <nifti2.h>
#include <unistd.h>
#include <zlib.h>

#include "base/file.h"
#include "volume/stream_kernel.h"

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
        for (int j = 0; j < 3; ++j) /* 17 digits in the file; the corner is recomputed from a center */
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
            ((double *)v->data)[i] = (double)i * 1e3 + 0.1;
        else
            for (size_t b = 0; b < bytes; ++b)
                ((unsigned char *)v->data)[i * bytes + b] = (unsigned char)(i * 7 + b * 31 + 200);
    }
}

TEST(every_type_comes_back_from_raw_and_gzip_files)
{
    iso_geometry g = turned_geometry(5, 4, 3);
    for (int type = ISO_U8; type <= ISO_F64; ++type)
        for (int gzip = 0; gzip < 2; ++gzip) {
            OWNED(iso_volume) v, back;
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
        }
}

TEST(planes_one_by_one_equal_the_whole)
{
    iso_geometry g = turned_geometry(6, 5, 7);
    OWNED(iso_volume) v;
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

TEST(a_format_of_this_test_alone_is_read_skipped_and_named)
{
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
    assert_non_null(strstr(why.text, "starts with \"COUNTERS\", an unknown format; isoshade list names"));
    assert_int_equal(iso_volume_format_suffix_bytes("a.cnt"), 4);
    assert_int_equal(iso_volume_format_suffix_bytes("a.cnt.long"), 9);
    assert_int_equal(iso_volume_format_suffix_bytes(".cnt"), 0);
    assert_int_equal(iso_volume_format_suffix_bytes("a.nii.gz"), 7);
}

TEST(each_format_has_a_whole_row)
{
    for (size_t i = 0; i < iso_volume_format_names.count; ++i) {
        const iso_volume_format *f = iso_volume_format_at(i);
        assert_true(f->name && *f->name && f->title && *f->title && f->summary && *f->summary && f->suffixes[0] == '.');
        assert_true((!f->marks[0].bytes && !f->probe && !f->probe_path) == (!f->open && !f->read) && (!f->open && !f->read) == !f->starts);
        size_t row = 99;
        assert_ok(iso_names_find(&iso_volume_format_names, f->name, &row, &err)); /* and its name is its own */
        assert_int_equal(row, i);
    }
}

TEST(a_sink_that_lacks_planes_leaves_no_file)
{
    iso_geometry g = turned_geometry(2, 2, 3);
    iso_volume like = {.geometry = g, .type = ISO_U8, .notes = {.scale_slope = 1}};
    iso_volume_sink *sink;
    assert_ok(iso_sink_open(in_dir("lack.nrrd"), &like, false, &sink, &err));
    assert_ok(iso_sink_write(sink, 2, "12345678", &err));
    assert_status(iso_sink_commit(sink, &err), ISO_E_RANGE);
    assert_false(iso_path_exists(in_dir("lack.nrrd")));
}

TEST(both_byte_orders_and_detached_headers_are_read)
{
    static const unsigned char big[] = {0, 1, 0, 2, 255, 255, 128, 0}, little[] = {1, 0, 2, 0, 255, 255, 0, 128};
    static const int16_t wanted[] = {1, 2, -1, -32768};
    iso_volume v;
    write_nrrd("b.nrrd",
               "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 1 2\nspacings: 1 1 1\nendian: big\nencoding: raw\n\n",
               big, 8);
    assert_ok(iso_volume_load(in_dir("b.nrrd"), &v, &err));
    assert_memory_equal(v.data, wanted, 8);
    iso_volume_destroy(&v);
    write_nrrd(
        "l.nrrd",
        "NRRD0001\r\ntype: int16\r\ndimension: 3\r\nsizes: 2 1 2\r\nspacings: 1 1 1\r\nendian: little\r\nencoding: raw\r\n\r\n",
        little, 8);
    assert_ok(iso_volume_load(in_dir("l.nrrd"), &v, &err));
    assert_memory_equal(v.data, wanted, 8);
    iso_volume_destroy(&v);
    write_bytes("d.raw", "xyz\0\1\0\2\377\377\200\0", 11);
    write_nrrd(
        "d.nhdr",
        "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 1 2\nspacings: 1 1 1\nendian: big\nencoding: raw\nbyte skip: 3\ndata file: d.raw\n",
        "", 0);
    assert_ok(iso_volume_load(in_dir("d.nhdr"), &v, &err));
    assert_memory_equal(v.data, wanted, 8);
    iso_volume_destroy(&v);
    write_nrrd(
        "e.nhdr",
        "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 1 2\nspacings: 1 1 1\nendian: big\nencoding: raw\nbyte skip: -1\ndata file: d.raw\n",
        "", 0);
    assert_ok(iso_volume_load(in_dir("e.nhdr"), &v, &err));
    assert_memory_equal(v.data, wanted, 8);
    iso_volume_destroy(&v);
    gzFile gz = gzopen(in_dir("d.raw.gz"), "wb");
    gzwrite(gz, big, 8);
    gzclose(gz);
    write_nrrd(
        "g.nhdr",
        "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 1 2\nspacings: 1 1 1\nendian: big\nencoding: gzip\ndata file: d.raw.gz\n",
        "", 0);
    assert_ok(iso_volume_load(in_dir("g.nhdr"), &v, &err));
    assert_memory_equal(v.data, wanted, 8);
    iso_volume_destroy(&v);
}

TEST(text_samples_and_slices_in_files_of_their_own_are_read)
{
    iso_volume v;
    write_nrrd("t.nrrd", "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 1 2\nspacings: 1 1 1\nencoding: ascii\n\n",
               "1 2.5 -3 4e3\n", 13);
    assert_ok(iso_volume_load(in_dir("t.nrrd"), &v, &err));
    assert_memory_equal(v.data, ((float[]){1, 2.5f, -3, 4e3f}), 16);
    iso_volume_destroy(&v);
    write_bytes("s0.raw", "ab", 2);
    write_bytes("s1.raw", "cd", 2);
    write_nrrd(
        "s.nhdr",
        "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 2\nspacings: 1 1 1\nencoding: raw\ndata file: s%d.raw 0 1 1\n",
        "", 0);
    assert_ok(iso_volume_load(in_dir("s.nhdr"), &v, &err));
    assert_memory_equal(v.data, "abcd", 4);
    iso_volume_destroy(&v);
}

static iso_status load_vti_text(const char *type, const char *numbers, iso_volume *v, iso_error *error)
{
    char text[600];
    const int n =
        snprintf(text, sizeof text,
                 "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
                 "<ImageData WholeExtent=\"0 1 0 0 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 1\">\n"
                 "<Piece Extent=\"0 1 0 0 0 1\"><PointData Scalars=\"s\">\n"
                 "<DataArray type=\"%s\" Name=\"s\" format=\"ascii\">%s</DataArray>\n"
                 "</PointData></Piece></ImageData>\n</VTKFile>\n",
                 type, numbers);
    write_bytes("t.vti", text, (size_t)n);
    *v = (iso_volume){0};
    return iso_volume_load(in_dir("t.vti"), v, error);
}

/* A tag may follow the last of them; what C does with a number beyond a type differs by machine. */
TEST(numbers_of_a_text_end_at_a_tag_and_are_of_their_type)
{
    iso_volume v;
    assert_ok(load_vti_text("UInt8", "0 255.5 -0.5 7", &v, &err));
    assert_memory_equal(v.data, ((uint8_t[]){0, 255, 0, 7}), 4);
    iso_volume_destroy(&v);
    assert_ok(load_vti_text("Int16", "-32768 32767 0 1", &v, &err));
    assert_memory_equal(v.data, ((int16_t[]){-32768, 32767, 0, 1}), 8);
    iso_volume_destroy(&v);
    static const char *const beyond[][2] = {{"UInt8", "0 0 0 256"},
                                            {"UInt8", "0 0 0 -1"},
                                            {"UInt8", "nan 0 0 0"},
                                            {"Int16", "0 0 0 -32769"},
                                            {"UInt32", "0 0 0 4294967296"}};
    for (size_t i = 0; i < sizeof beyond / sizeof *beyond; ++i) {
        iso_error error = {""};
        assert_int_equal(load_vti_text(beyond[i][0], beyond[i][1], &v, &error), ISO_E_FORMAT);
        assert_non_null(strstr(error.text, beyond[i][0][0] == 'I' ? "which no int16 can be" : "which no uint"));
        iso_volume_destroy(&v);
    }
}

static iso_geometry geometry_of(const char *header)
{
    OWNED(iso_volume) v;
    write_nrrd("geo.nrrd", header, "12345678", 8);
    assert_ok(iso_volume_load(in_dir("geo.nrrd"), &v, &err));
    iso_geometry g = v.geometry;
    return g;
}

#define HEAD "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n"

TEST(the_space_origin_is_the_center_of_the_first_sample)
{
    iso_geometry g = geometry_of(
        HEAD "space dimension: 3\nspace directions: (0,2,0) (0,0,3) (5,0,0)\nspace origin: (10,20,30)\n\n");
    iso_vec3 center = iso_geometry_to_world(&g, iso_v3(0.5, 0.5, 0.5));
    assert_within(iso_norm(iso_sub(center, iso_v3(10, 20, 30))), 0, 1e-14);
    assert_within(iso_norm(iso_sub(g.origin_mm, iso_v3(7.5, 19, 28.5))), 0, 1e-14);
    assert_within(g.index_to_world.m[1][0], 2, 0); /* the step along x is the first column */
    assert_within(g.index_to_world.m[2][1], 3, 0);
    assert_within(g.index_to_world.m[0][2], 5, 0);
}

TEST(anatomical_spaces_become_right_anterior_superior)
{
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

TEST(spacings_axis_mins_and_units_are_kept)
{
    iso_geometry g = geometry_of(HEAD "spacings: 1 2 3\n\n");
    assert_within(iso_norm(iso_sub(g.origin_mm, iso_v3(-1, -2, -3))), 0, 0); /* centered */
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

static iso_status load_raw(const iso_raw_layout *layout, iso_volume *v, iso_error *err)
{
    iso_volume_source *source;
    *v = (iso_volume){0};
    NEED(iso_source_open_raw(in_dir("r.raw"), layout, &source, err));
    return iso_volume_load_source(source, in_dir("r.raw"), v, err);
}

TEST(raw_files_follow_the_layout_that_is_given)
{
    write_bytes("r.raw", "??\0\1\0\2\0\3\0\4\0\5\0\6", 14);
    iso_raw_layout layout = {
        .type = ISO_U16, .size = {3, 1, 2}, .spacing_mm = {1, 2, 3}, .big_endian = true, .skip_bytes = 2};
    iso_volume v;
    assert_ok(load_raw(&layout, &v, &err));
    float row[3];
    iso_volume_row(&v, 0, 1, row);
    assert_memory_equal(row, ((float[]){4, 5, 6}), 12);
    iso_volume_destroy(&v);
    layout.skip_bytes = 0; /* less than a plane follows: a trailer */
    assert_ok(load_raw(&layout, &v, &err));
    iso_volume_destroy(&v);
    layout.size[2] = 1;
    assert_status(load_raw(&layout, &v, &err), ISO_E_FORMAT);
    layout.size[2] = 2;
    layout.skip_bytes = 3;
    assert_status(load_raw(&layout, &v, &err), ISO_E_FORMAT);
    layout.size[0] = (size_t)1 << 62;
    assert_status(load_raw(&layout, &v, &err), ISO_E_RANGE);
}

TEST(bad_nrrd_files_are_refused_with_the_reason)
{
    static const struct {
        const char *header, *samples, *part;
        iso_status status;
    } cases[] = {
        {"", "", "empty", ISO_E_FORMAT},
        {"NRRX0004\ntype: uchar\n\n", "", "NRRX0004", ISO_E_FORMAT},
        {HEAD "spacings: 1 1 1\n\n", "1234567", "holds 7 bytes of samples, 2 x 2 x 2 of uint8 need 8", ISO_E_FORMAT},
        {HEAD "spacings: 1 1 1\n\n", "123456789", "too long", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\n", "", "hit end of header", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 0 2\nspacings: 1 1 1\nencoding: raw\n\n", "1", "",
         ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4000000000 4000000000 4000000000\nspacings: 1 1 1\nencoding: raw\n\n",
         "1", "", ISO_E_RANGE},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 100000 100000 100\nspacings: 1 1 1\nencoding: raw\n\n", "1",
         "need 1000000000000", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 100000 100000 100\nspacings: 1 1 1\nencoding: gzip\n\n", "1",
         "cannot hold", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 100000 100000 100\nspacings: 1 1 1\nencoding: ascii\n\n", "1 2 3",
         "cannot hold", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: gzip\n\n", "12345678",
         "not gzip", ISO_E_FORMAT},
        {"NRRD0004\ntype: quaternion\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: raw\n\n", "12345678",
         "quaternion", ISO_E_FORMAT},
        {HEAD "\n", "12345678", "does not state the spacing of its voxels", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 2\nsizes: 2 4\nencoding: raw\n\n", "12345678",
         "2 axes, 2 of space, a volume has 3", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 2 1 2\nspacings: nan 1 1 1\nencoding: raw\n\n", "123456789012",
         "has 3 channels", ISO_E_USAGE},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 2\nspacings: 1 1 1\nkinds: RGB-color domain domain\nencoding: raw\n\n",
         "123456789012", "3 axes, 2 of space", ISO_E_FORMAT},
        {"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspacings: 1 0 1\n\n", "12345678", "",
         ISO_E_FORMAT},
        {HEAD "space dimension: 3\nspace directions: (1,0,0) (1,0,0) (0,0,1)\n\n", "12345678", "span no volume",
         ISO_E_RANGE},
        {HEAD "spacings: 1 1 1\ndata file: nowhere.raw\n", "", "nowhere.raw", ISO_E_FORMAT},
        /* What teem itself would write beyond its buffers for. */
        {HEAD "spacings: 1 1 1\ndata file: s%9999d.raw 1 2 1\n", "", "one place for a number", ISO_E_FORMAT},
        {HEAD "spacings: 1 1 1\n# x\rdata file: s%d%n.raw 1 2 1\n", "", "one place for a number", ISO_E_FORMAT},
        {HEAD "spacings: 1 1 1\ndata file: s%d.raw 1 999999999 1\n", "", "at most 65536", ISO_E_RANGE},
        {HEAD "spacings: 1 1 1\ndata file: LIST\n-\n", "", "name of a file", ISO_E_FORMAT},
        {HEAD "spacings: 1 1 1\ndata file: bad.nrrd", "", "within a line", ISO_E_FORMAT},
        {HEAD "spacings: 1 1 1\ndata file: .\n", "", "not a regular file", ISO_E_IO},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        write_nrrd("bad.nrrd", cases[i].header, cases[i].samples, strlen(cases[i].samples));
        assert_refused("bad.nrrd", cases[i].status, cases[i].part);
    }
    char line[3000];
    snprintf(line, sizeof line, HEAD "spacings: 1 1 1\nkinds: %02000d\n\n", 1);
    write_nrrd("bad.nrrd", line, "12345678", 8);
    assert_refused("bad.nrrd", ISO_E_FORMAT, "2007 bytes, at most 800");
    /* Nor may a number be longer than teem's buffer for it. */
    snprintf(line, sizeof line, "%02000d 2 3 4 5 6 7 8", 1);
    write_nrrd("bad.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: ascii\n\n",
               line, strlen(line));
    assert_refused("bad.nrrd", ISO_E_FORMAT, "more than 100 digits");
    write_nrrd("bad.txt", "", line, strlen(line));
    write_nrrd(
        "bad.nrrd",
        "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: ascii\ndata file: bad.txt\n", "",
        0);
    assert_refused("bad.nrrd", ISO_E_FORMAT, "more than 100 digits");
    iso_volume v;
    assert_status(iso_volume_load(in_dir("absent.nrrd"), &v, &err), ISO_E_IO);
    /* A folder is taken for slices, which need ITK. */
    const iso_status of_folder = iso_volume_load(folder, &v, NULL);
    assert_true(of_folder == ISO_E_FORMAT || of_folder == ISO_E_MISSING);
}

TEST(non_finite_voxels_are_counted_and_the_first_is_named)
{
    iso_geometry g = turned_geometry(5, 4, 3);
    OWNED(iso_volume) v;
    assert_ok(iso_volume_create(&v, &g, ISO_F32, "v", &err));
    ((float *)v.data)[0] = NAN; /* no data */
    ((float *)v.data)[(1 * 4 + 2) * 5 + 3] = INFINITY;
    ((float *)v.data)[(2 * 4 + 0) * 5 + 1] = -INFINITY;
    assert_ok(iso_volume_save(&v, in_dir("nan.nrrd"), false, &err));
    assert_refused("nan.nrrd", ISO_E_RANGE, "2 of 60 voxels are NaN or infinite, none may be; the first is (3, 2, 1)");
}

TEST(damage_inside_compressed_samples_is_found)
{
    iso_geometry g = turned_geometry(16, 16, 16);
    OWNED(iso_volume) v;
    FREED char *bytes;
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
}

TEST(statistics_are_those_of_the_samples)
{
    iso_geometry g = turned_geometry(3, 2, 2);
    OWNED(iso_volume) v;
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
}

TEST_MAIN(make_folder, remove_folder)
