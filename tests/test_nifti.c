/* SPDX-License-Identifier: MIT */
/* NIfTI files: places, byte orders, scales, both versions, and what is refused. */
#include <math.h>
#include <nifti1.h>
#include <nifti2.h>
#include <string.h>

#include "volume_files.h"

TEST(nifti_places_centers_by_its_sform)
{
    nifti_1_header h = nifti_header(2, 3, 2);
    h.sform_code = 1, h.qform_code = 1; /* the sform goes first */
    float rows[3][4] = {{0, -2, 0, 10}, {1, 0, 0, 20}, {0, 0, 3, 30}};
    memcpy(h.srow_x, rows[0], 16), memcpy(h.srow_y, rows[1], 16), memcpy(h.srow_z, rows[2], 16);
    h.scl_slope = 2, h.scl_inter = -1024;
    for (int gzip = 0; gzip < 2; ++gzip) {
        const char *name = gzip ? "n.nii.gz" : "n.nii";
        OWNED(iso_volume) v;
        write_nifti(name, h, nifti_samples, 24, gzip);
        assert_ok(iso_volume_load(in_dir(name), &v, &err));
        assert_int_equal(v.type, ISO_I16);
        assert_memory_equal(v.data, nifti_samples, 24);
        iso_vec3 at = iso_geometry_to_world(&v.geometry, iso_v3(1.5, 2.5, 0.5)); /* the center of voxel (1, 2, 0) */
        assert_within(iso_norm(iso_sub(at, iso_v3(10 - 4, 20 + 1, 30))), 0, 1e-14);
        assert_true(v.notes.world_is_ras);
        assert_within(v.notes.scale_slope, 2, 0);
        assert_within(v.notes.scale_intercept, -1024, 0);
    }
}

TEST(nifti_places_centers_by_its_qform)
{
    nifti_1_header h = nifti_header(2, 3, 2);
    h.qform_code = 1;
    h.quatern_d = sqrtf(0.5f); /* a quarter turn about z */
    h.qoffset_x = 10, h.qoffset_y = 20, h.qoffset_z = 30;
    h.pixdim[0] = -1; /* and z reflected */
    OWNED(iso_volume) v;
    write_nifti("q.nii", h, nifti_samples, 24, false);
    assert_ok(iso_volume_load(in_dir("q.nii"), &v, &err));
    iso_vec3 at = iso_geometry_to_world(&v.geometry, iso_v3(1.5, 2.5, 1.5));
    assert_within(iso_norm(iso_sub(at, iso_v3(10 - 4, 20 + 1, 30 - 3))), 0, 2e-6); /* libnifti's floats */
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

TEST(nifti_of_the_other_byte_order_and_in_two_files_is_read)
{
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
    assert_within(v.geometry.origin_mm.z, -3, 0); /* bare spacings: centered */
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

static void swap8(void *p, int count)
{
    unsigned char *b = p;
    for (int i = 0; i < count; ++i, b += 8)
        for (int k = 0; k < 4; ++k) {
            unsigned char t = b[k];
            b[k] = b[7 - k], b[7 - k] = t;
        }
}

TEST(nifti_2_is_read_in_both_byte_orders)
{
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
        OWNED(iso_volume) v;
        write_nifti_2("two.nii", h, samples, 24, i & 2);
        assert_ok(iso_volume_load(in_dir("two.nii"), &v, &err));
        assert_memory_equal(v.data, nifti_samples, 24);
        iso_vec3 at = iso_geometry_to_world(&v.geometry, iso_v3(1.5, 2.5, 0.5));
        assert_within(iso_norm(iso_sub(at, iso_v3(10.000000001 - 4, 20 + 1, 30))), 0,
                      1e-14); /* a float has no such 10 */
        assert_within(v.notes.scale_slope, 2, 0);
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

TEST(a_scale_is_applied_where_asked_for)
{
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

TEST(bad_nifti_files_are_refused_with_the_reason)
{
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
    assert_refused("bad.nii", ISO_E_USAGE, "has 2 frames");
    h = good, h.datatype = 128; /* RGB24 */
    write_nifti("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_USAGE, "has 3 channels");
    h = good, h.datatype = 32; /* complex */
    write_nifti("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_FORMAT, "data type 32");
    h = good, h.dim[2] = -3;
    write_nifti("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_RANGE, "axis 2 has size -3");
    h = good, h.vox_offset = NAN;
    write_nifti("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_RANGE, "samples start");
    h = good, h.pixdim[1] = NAN;
    write_nifti("bad.nii", h, nifti_samples, 24, false);
    assert_refused("bad.nii", ISO_E_FORMAT, "spacing along its axis 1");
}

TEST_MAIN(make_folder, remove_folder)
