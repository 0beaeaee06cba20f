/* SPDX-License-Identifier: MIT */
/* A program of C99 and of C++17 that calls each function of isoshade.h once, and uses the results. Writes into the
 * current folder, and runs the program isoshade. Ends with the number of the line whose call failed. */
#include <isoshade.h>
#include <stdio.h>
#include <string.h>

#define MUST(condition)                                                      \
    do                                                                       \
        if (!(condition)) {                                                  \
            fprintf(stderr, "line %d: %s: %s\n", __LINE__, #condition, err.text); \
            return 1;                                                        \
        }                                                                    \
    while (0)
#define GOOD(call) MUST((call) == ISO_OK)

enum { NX = 9, NY = 8, NZ = 7, COUNT = NX * NY * NZ };

static iso_error err;
static unsigned char samples[COUNT];

static void warn(void *user, const char *text)
{
    *(size_t *)user += strlen(text);
}

static bool draw_black(void *user, const iso_frame_request *request, float *rgba)
{
    (void)rgba;
    ++*(int *)user;
    return request->values && request->width > 0 && request->step_mm > 0 && strstr(request->json, "camera");
}

static int use_volumes(iso_volume **volume)
{
    const size_t size[3] = {NX, NY, NZ};
    const double spacing_mm[3] = {1, 1, 1.25};
    const ptrdiff_t strides[3] = {1, NX, NX * NY};
    const iso_grid grid = iso_grid_axis_aligned(size, spacing_mm);
    iso_open_options options;
    iso_volume *file, *array;
    float values[COUNT];
    double edges[3];
    for (int i = 0; i < COUNT; ++i)
        samples[i] = (unsigned char)(28 * (i % NX));
    GOOD(iso_volume_from_memory(&grid, "uint8", samples, volume, &err));
    GOOD(iso_volume_save(*volume, "volume.nrrd", true, &err));
    GOOD(iso_volume_open("volume.nrrd", &file, &err));
    iso_volume_values(file, values);
    MUST(values[4] == samples[4] && memcmp(iso_volume_samples(file), samples, COUNT) == 0);
    iso_volume_free(file);
    memset(&options, 0, sizeof options);
    options.unit = "um";
    options.spacing[0] = options.spacing[1] = options.spacing[2] = 2000;
    GOOD(iso_volume_open_with("volume.nrrd", &options, &file, &err));
    const iso_grid scaled = iso_volume_grid(file);
    iso_grid_spacing_mm(&scaled, edges);
    MUST(edges[2] > 1.999 && edges[2] < 2.001 && strcmp(iso_volume_type(file), "uint8") == 0);
    iso_volume_free(file);
    GOOD(iso_volume_from_array(&grid, "bool", samples, strides, &array, &err));
    iso_volume_free(array);
    return 0;
}

static int use_pyramids(const iso_volume *volume, iso_pyramid **pyramid)
{
    iso_build_options options = iso_build_defaults();
    iso_pyramid *built;
    iso_level_view level;
    float directions[3 * COUNT];
    uint8_t codes[3 * COUNT];
    options.levels = 2;
    GOOD(iso_build(volume, &options, &built, &err));
    GOOD(iso_pyramid_save(built, "volume.iso", &err));
    iso_pyramid_free(built);
    GOOD(iso_pyramid_open("volume.iso", pyramid, &err));
    MUST(iso_pyramid_level_count(*pyramid) == 2);
    GOOD(iso_pyramid_level(*pyramid, 0, &level, &err));
    GOOD(iso_pyramid_directions(*pyramid, 0, directions, &err));
    MUST(level.max > level.min && iso_directions_bytes(level.code) == 3);
    GOOD(iso_directions_encode(level.code, directions, COUNT, codes, &err));
    GOOD(iso_directions_decode(level.code, codes, COUNT, directions, &err));
    return 0;
}

static int use_scenes(const iso_pyramid *pyramid, iso_scene **scene)
{
    const double value = 100;
    double color[1][4];
    iso_tf_point points[64];
    iso_scene *made;
    iso_tf *tf, *again, *adapted;
    char *text;
    GOOD(iso_tf_suggest(pyramid, "simulation", &tf, &err));
    const size_t count = iso_tf_points(tf, points, 64);
    GOOD(iso_tf_save(tf, "a.tf.json", &err));
    GOOD(iso_tf_text(tf, &text, &err));
    iso_tf_free(tf);
    GOOD(iso_tf_from_text(text, &tf, &err));
    iso_free(text);
    iso_tf_free(tf);
    GOOD(iso_tf_open("a.tf.json", &tf, &err));
    GOOD(iso_tf_adapt(tf, pyramid, 1, &adapted, &err));
    iso_tf_free(tf);
    GOOD(iso_tf_evaluate(adapted, pyramid, &value, 1, color, &err));
    iso_tf_free(adapted);
    MUST(count >= 2 && count <= 64 && color[0][3] >= 0);
    GOOD(iso_tf_from_points(points, count, 1, &again, &err));
    GOOD(iso_scene_automatic(pyramid, NULL, &made, &err));
    GOOD(iso_scene_set(made, "{\"image\": {\"width\": 12, \"height\": 12}}", &err));
    GOOD(iso_scene_set_tf(made, again, &err));
    iso_tf_free(again);
    MUST(iso_tf_points(iso_scene_tf(made), NULL, 0) == count);
    GOOD(iso_scene_save(made, "a.scene.json", &err));
    iso_scene_free(made);
    GOOD(iso_scene_open("a.scene.json", &made, &err));
    GOOD(iso_scene_text(made, &text, &err));
    iso_scene_free(made);
    GOOD(iso_scene_from_text(text, scene, &err));
    iso_free(text);
    return 0;
}

static int use_images(const iso_pyramid *pyramid, const iso_scene *scene)
{
    const double lo[3] = {0, 0, 0}, hi[3] = {NX, NY, NZ};
    const iso_region region = iso_region_of(lo, hi);
    iso_frame_options options = iso_frame_defaults();
    iso_image a, b, black;
    iso_metrics metrics;
    unsigned char *bytes;
    size_t size;
    options.level = 1;
    options.region = &region;
    options.renderer = "cpu";
    MUST(iso_render(pyramid, scene, &options, &a, &err) == ISO_E_USAGE); /* only others draw regions */
    options.region = NULL;
    GOOD(iso_render(pyramid, scene, &options, &a, &err));
    GOOD(iso_image_save_exr(&a, "a.exr", NULL, &err));
    GOOD(iso_image_load_exr("a.exr", &b, &err));
    GOOD(iso_metrics_measure(&a, &b, &metrics, &err));
    MUST(metrics.max_abs <= 0); /* EXR keeps floats */
    iso_image_destroy(&b);
    GOOD(iso_image_save_png(&a, "a.png", 1, &err));
    GOOD(iso_image_load_png("a.png", &b, &err));
    iso_image_destroy(&b);
    GOOD(iso_image_create(&black, 12, 12, &err));
    GOOD(iso_metrics_measure(&a, &black, &metrics, &err));
    MUST(metrics.max_abs > 0);
    iso_image_destroy(&black);
    GOOD(iso_image_png(&a, 1, &bytes, &size, &err));
    iso_free(bytes);
    GOOD(iso_image_exr(&a, &bytes, &size, &err));
    MUST(size > 4 * 12 * 12);
    iso_free(bytes);
    iso_image_destroy(&a);
    return 0;
}

static int use_exports(const iso_pyramid *pyramid, const iso_scene *scene)
{
    iso_plan_options limits = iso_plan_defaults();
    iso_export_options options = iso_export_defaults();
    iso_plan_result plan;
    unsigned char *bytes;
    size_t size;
    char *html;
    limits.brick_voxels = 8;
    GOOD(iso_plan(pyramid, scene, &limits, &plan, &err));
    MUST(plan.measured_rmse <= limits.error && plan.drawn_count > 0);
    options.plan = plan.json;
    GOOD(iso_export(pyramid, scene, "vdb", "planned.vdb", &options, &err));
    GOOD(iso_export_bytes(pyramid, scene, "vdb", &options, &bytes, &size, &err));
    iso_free(bytes);
    iso_plan_result_destroy(&plan);
    GOOD(iso_view_page(pyramid, scene, NULL, &html, &err));
    MUST(strstr(html, "<canvas"));
    iso_free(html);
    return 0;
}

static int use_validation(const iso_volume *volume, const iso_scene *scene)
{
    int drawn = 0;
    const iso_own_renderer own = {"black", draw_black, &drawn};
    iso_validate_options options = iso_validate_defaults();
    iso_validation_result result;
    options.scene = scene;
    options.renderers = &own;
    options.renderer_count = 1;
    GOOD(iso_validate(volume, &options, &result, &err));
    MUST(!result.agrees && result.summary[0] && strstr(result.json, "black") && strstr(result.html, "<html"));
    MUST(drawn >= 8); /* seven calibrations, and the scene */
    iso_validation_result_destroy(&result);
    return 0;
}

int main(void)
{
    size_t warned = 0;
    iso_volume *volume = NULL;
    iso_pyramid *pyramid = NULL;
    iso_scene *scene = NULL;
    iso_warnings_to(warn, &warned);
    MUST(strcmp(iso_version(), ISO_VERSION) == 0 && iso_version_number() == ISO_VERSION_NUMBER);
    MUST(strstr(iso_status_text(ISO_E_IO), "file") && iso_choice_name(ISO_CHOICE_VIEW, 0));
    const int failed = use_volumes(&volume) || use_pyramids(volume, &pyramid) || use_scenes(pyramid, &scene) ||
                       use_images(pyramid, scene) || use_exports(pyramid, scene) || use_validation(volume, scene);
    iso_scene_free(scene);
    iso_pyramid_free(pyramid);
    iso_volume_free(volume);
    iso_warnings_to(NULL, NULL);
    return failed || warned > 0;
}
