/* SPDX-License-Identifier: MIT */
/* What a program is asked to render: matrices that project as our rays look, samples and directions as they are, and
 * what the format has no words for is refused. */
#include <math.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "tests/folder.h"
#include "tests/rendered.h"
#include "renderers/request.h"

static iso_tf_point points[] = {{0, {0.9, 0.7, 0.4}, 0}, {0.5, {1, 0.9, 0.6}, 0.2}, {1, {0.3, 0.6, 0.9}, 0.4}};

static iso_pyramid noise(void)
{
    const iso_field field = {.kind = ISO_FIELD_NOISE,
                             .seed = 3,
                             .geometry = iso_geometry_axis_aligned((size_t[]){9, 7, 6}, (double[]){1, 1.2, 0.9})};
    return build_field(&field, 2);
}

/* Writes a request for a level and reads its JSON, to be released. */
static json_t *written(const iso_pyramid *p, size_t level, const iso_view *view)
{
    const iso_request_frame frames[] = {{.step_voxels = 0.5, .file = "a.exr"},
                                        {.samples = 4, .seed = 7, .file = "b.exr"}};
    const iso_request q = {
        .scene = "noise", .pyramid = p, .level = level, .view = view, .frames = frames, .frame_count = 2, .threads = 1};
    json_t *root;
    FREED char *path = iso_path_join(folder, "request.json");
    assert_ok(iso_request_write(&q, folder, &err));
    assert_ok(iso_json_load(path, &root, &err));
    return root;
}

static double at(const json_t *list, size_t i)
{
    return json_number_value(json_array_get(list, i));
}

static iso_vec3 vector(const json_t *list)
{
    return iso_v3(at(list, 0), at(list, 1), at(list, 2));
}

static void multiply(const json_t *rows, const double in[4], double out[4])
{
    for (size_t r = 0; r < 4; ++r) {
        out[r] = 0;
        for (size_t c = 0; c < 4; ++c)
            out[r] += at(json_array_get(rows, r), c) * in[c];
    }
}

/* Points on the rays of pixels land in the pixels' centers, between the near and the far plane where the box is. */
static void expect_projection(const json_t *root, const iso_view *view)
{
    const json_t *camera = json_object_get(root, "camera");
    const double near = json_number_value(json_object_get(camera, "near")),
                 far = json_number_value(json_object_get(camera, "far"));
    for (size_t row = 0; row < view->height; row += 5)
        for (size_t column = 0; column < view->width; column += 7) {
            const iso_ray ray = iso_camera_ray(&view->camera, view->width, view->height, column, row);
            const iso_vec3 p = iso_madd(ray.origin, ray.direction, 0.5 * (near + far));
            const double world[4] = {p.x, p.y, p.z, 1};
            double eye[4], clip[4];
            multiply(json_object_get(camera, "view"), world, eye);
            multiply(json_object_get(camera, "projection_matrix"), eye, clip);
            assert_float_equal((clip[0] / clip[3] + 1) / 2 * (double)view->width, (double)column + 0.5, 1e-9);
            assert_float_equal((1 - clip[1] / clip[3]) / 2 * (double)view->height, (double)row + 0.5, 1e-9);
            assert_true(fabs(clip[2] / clip[3]) < 1);
        }
}

TEST(cameras_project_as_our_rays_look)
{
    OWNED(iso_pyramid) p = noise();
    for (int orthographic = 0; orthographic < 2; ++orthographic) {
        iso_scene scene = scene_of_points(points, 3);
        scene.orthographic = orthographic;
        OWNED(iso_view) view = view_of(&scene, &p);
        json_auto_t *root = written(&p, 0, &view);
        expect_projection(root, &view);
    }
}

/* The last bytes of a file. */
static void expect_tail(const char *name, const void *wanted, size_t size)
{
    FREED char *path = iso_path_join(folder, name), *data;
    size_t all;
    assert_ok(iso_file_read(path, &data, &all, &err));
    assert_true(all > size);
    assert_memory_equal(data + all - size, wanted, size);
}

TEST(samples_directions_and_steps_are_those_of_the_level)
{
    OWNED(iso_pyramid) p = noise();
    const iso_scene scene = scene_of_points(points, 3);
    OWNED(iso_view) view = view_of(&scene, &p);
    json_t *root = written(&p, 1, &view), *volume = json_object_get(root, "volume");
    const iso_level *l = &p.levels[1];
    const size_t count = iso_geometry_voxel_count(&l->geometry);
    FREED float *directions = malloc(3 * count * sizeof *directions);
    iso_code_decode_all(p.options.code, l->codes, directions, count);
    expect_tail("volume.nrrd", l->scalar, count * sizeof *l->scalar);
    expect_tail("directions.nrrd", directions, 3 * count * sizeof *directions);
    /* A corner of the box, which the last voxels overhang: the sizes are odd. */
    const iso_vec3 corner = vector(json_array_get(json_object_get(volume, "box_index"), 1));
    assert_float_equal(corner.x, 4.5, 0);
    const iso_vec3 wanted = iso_geometry_to_world(&p.levels[0].geometry, iso_v3(9, 7, 6));
    for (size_t r = 0; r < 3; ++r) {
        const json_t *m = json_array_get(json_object_get(volume, "index_to_world"), r);
        assert_float_equal(iso_dot(vector(m), corner) + at(m, 3), (&wanted.x)[r], 1e-12);
    }
    const json_t *frames = json_object_get(root, "frames");
    const double mm = iso_geometry_min_spacing_mm(&l->geometry);
    assert_float_equal(json_number_value(json_object_get(json_array_get(frames, 0), "step_mm")), 0.5 * mm, 1e-15);
    assert_float_equal(json_number_value(json_object_get(json_array_get(frames, 1), "step_mm")), view.step_voxels * mm,
                       1e-15);
    assert_int_equal(json_integer_value(json_object_get(json_array_get(frames, 1), "seed")), 7);
    const json_t *tf = json_object_get(root, "tf");
    assert_int_equal(json_array_size(json_object_get(tf, "extinction_per_mm")), view.tf.count);
    assert_true((float)at(json_object_get(tf, "extinction_per_mm"), 200) == view.tf.entries[4 * 200 + 3]);
    assert_true((float)at(json_array_get(json_object_get(tf, "color"), 200), 1) == view.tf.entries[4 * 200 + 1]);
    json_decref(root);
}

TEST(without_light_there_are_no_directions)
{
    OWNED(iso_pyramid) p = noise();
    const iso_scene scene = scene_of_points(points, 3);
    OWNED(iso_view) view = view_of(&scene, &p);
    json_t *root = written(&p, 0, &view);
    assert_string_equal(json_string_value(json_object_get(json_object_get(root, "directions"), "file")),
                        "directions.nrrd");
    json_decref(root);
    view.shading.diffuse = view.shading.specular = 0;
    root = written(&p, 0, &view);
    assert_true(json_is_null(json_object_get(root, "directions")));
    json_decref(root);
}

TEST(what_it_has_no_words_for_is_refused)
{
    OWNED(iso_pyramid) p = noise();
    const iso_scene scene = scene_of_points(points, 3);
    OWNED(iso_view) view = view_of(&scene, &p);
    uint8_t scale = 0;
    iso_error why = {""};
    const iso_request_frame frame = {.file = "a.exr"};
    view.extinction_scale = &scale;
    assert_int_equal(iso_request_write(&(iso_request){.pyramid = &p, .view = &view, .frames = &frame, .frame_count = 1},
                                       folder, &why),
                     ISO_E_USAGE);
    assert_non_null(strstr(why.text, "extinction scales"));
    view.extinction_scale = NULL;
}

TEST_MAIN(make_folder, remove_folder)
