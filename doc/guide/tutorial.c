/* SPDX-License-Identifier: MIT */
/* tutorial.c - a volume at two levels: do they look alike? doc/guide/library.md has the commands that build it. */
#include <isoshade.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static iso_error error; /* the reason of the last failure, a sentence */

/* Ends the program if a function failed: the library itself never prints and never exits. */
static void must(iso_status status)
{
    if (status == ISO_OK)
        return;
    fprintf(stderr, "tutorial: %s: %s\n", iso_status_text(status), error.text);
    exit(status);
}

/* Makes a ball: 1 inside, 0 outside, with a soft border, 48 x 40 x 32 voxels of 1 x 1 x 1.5 mm. Samples are ordered
 * x fastest, then y, then z. The library copies them. */
static iso_volume *make_volume(void)
{
    const size_t size[3] = {48, 40, 32};
    const double spacing_mm[3] = {1, 1, 1.5};
    const iso_grid grid = iso_grid_axis_aligned(size, spacing_mm);
    float *samples = malloc(size[0] * size[1] * size[2] * sizeof *samples), *sample = samples;
    iso_volume *volume;
    if (!samples)
        abort();
    for (size_t k = 0; k < size[2]; ++k)
        for (size_t j = 0; j < size[1]; ++j)
            for (size_t i = 0; i < size[0]; ++i) {
                const double x = i + 0.5 - 24, y = j + 0.5 - 20, z = 1.5 * (k + 0.5 - 16);
                *sample++ = (float)(0.5 - 0.5 * tanh((sqrt(x * x + y * y + z * z) - 15) / 2));
            }
    must(iso_volume_from_memory(&grid, "float", samples, &volume, &error));
    free(samples);
    return volume;
}

/* Camera, light, background and transfer function. "fit" places the camera so that it sees any volume whole. Most
 * programs keep scenes in files: iso_scene_open(). */
static const char scene_text[] =
    "{\"schema\": \"isoshade.scene/1\", \"image\": {\"width\": 96, \"height\": 80},"
    " \"camera\": {\"projection\": \"perspective\", \"fit\": true, \"direction\": [1, 2, -1], \"up\": [0, 0, 1]},"
    " \"lights\": [{\"direction\": [-1, 1, 1], \"space\": \"camera\", \"intensity\": 1}],"
    " \"shading\": {\"ambient\": 0.3, \"diffuse\": 0.7}, \"background\": [1, 1, 1],"
    " \"tf\": {\"schema\": \"isoshade.tf/1\", \"range\": [0, 1], \"unit_distance_mm\": 1, \"color_space\": \"linear\","
    "  \"points\": [{\"value\": 0.3, \"r\": 0.9, \"g\": 0.5, \"b\": 0.2, \"opacity\": 0},"
    "               {\"value\": 0.7, \"r\": 0.9, \"g\": 0.3, \"b\": 0.1, \"opacity\": 0.5}]}}";

int main(void)
{
    iso_volume *volume = make_volume();
    iso_pyramid *pyramid;
    iso_scene *scene;
    iso_tf *adapted;
    /* Four levels, by the defaults. */
    must(iso_build(volume, NULL, &pyramid, &error));
    iso_volume_free(volume);

    /* A value of level 1 is the mean of eight finer ones, so it gets a transfer function of its own. */
    must(iso_scene_from_text(scene_text, &scene, &error));
    must(iso_tf_adapt(iso_scene_tf(scene), pyramid, 1, &adapted, &error));

    /* "reference", the default, computes in double precision; options.renderer = "gl" is faster. */
    iso_image fine, coarse;
    iso_frame_options options = iso_frame_defaults();
    must(iso_render(pyramid, scene, &options, &fine, &error));
    options.level = 1;
    options.tf = adapted;
    must(iso_render(pyramid, scene, &options, &coarse, &error));
    must(iso_image_save_png(&fine, "level0.png", 1.0, &error));
    must(iso_image_save_png(&coarse, "level1.png", 1.0, &error));

    /* RMSE of linear colors; FLIP: the difference that a person sees when the images alternate. */
    iso_metrics metrics;
    must(iso_metrics_measure(&fine, &coarse, &metrics, &error));
    printf("levels 0 and 1 differ by %.3f (RMSE), %.3f (FLIP)\n", metrics.rmse, metrics.flip_mean);
    /* Values and shading directions of level 0, for other programs. */
    must(iso_export(pyramid, NULL, "vdb", "volume.vdb", NULL, &error));

    /* The program frees each object that it was given. */
    iso_image_destroy(&fine);
    iso_image_destroy(&coarse);
    iso_scene_free(scene);
    iso_tf_free(adapted);
    iso_pyramid_free(pyramid);
    return 0;
}
