/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "bench/headlines.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Commands run in a new folder with volume.nrrd: thin shells in empty space, 512^3 bytes or (quick) 48^3. */
#define BUILD {"bench build --size 512 --runs 3 --files .", "bench build --size 48 --levels 2 --runs 1 --files ."}
#define RENDER \
    {"bench render --size 256 --image 512 --runs 3 --processor-time", "bench render --size 32 --image 32 --runs 1"}
#define BRICKS \
    {"bench render --size 256 --image 512 --runs 3 --bricks 8 --processor-time", \
     "bench render --size 32 --image 32 --runs 1 --bricks 8"}
#define CAST {"bench cast --size 256 --image 512", "bench cast --size 32 --image 32"}
#define EXPORT(to, name) \
    {"export volume.nrrd --to " to " -o " name, "export volume.nrrd --to " to " -o " name}

/* Commands that a person waits for: of a packed brain of 301 x 370 x 316 bytes, from Debian's mricron-data. */
#define BRAIN "/usr/share/mricron/templates/ch2better.nii.gz"
#define FOR_BRAIN(verb, options) {verb " " BRAIN " " options, verb " volume.nrrd " options}
#define FIRST FOR_BRAIN("render", "-o first.png")
#define FIRST_512 {"render volume.nrrd -o first.png --size 512", "render volume.nrrd -o first.png --size 64"}
#define PLAN FOR_BRAIN("plan", "--error 1/255")

const iso_headline iso_headlines[] = {
    {"first-picture", "a first picture of a brain", FIRST, "process.seconds", NULL, "s", NULL, true, 0.9},
    {"first-peak", "memory of the same", FIRST, "process.peak_bytes", NULL, "bytes", NULL, true, 1.76e8},
    {"first-picture-512", "a first picture of 512 x 512 x 512 bytes", FIRST_512, "process.seconds", NULL, "s", NULL,
     true, 1.5},
    {"first-peak-512", "memory of the same", FIRST_512, "process.peak_bytes", NULL, "bytes", NULL, true, 6e8},
    {"suggest", "a transfer function for the brain", FOR_BRAIN("tf suggest", "-o first.tf.json"), "process.seconds",
     NULL, "s", NULL, true, 0.6},
    {"view", "a page that draws the brain", FOR_BRAIN("view", "-o first.html"), "process.seconds", NULL, "s", NULL,
     true, 1.5},
    {"scenes", "a contact sheet of the brain", FOR_BRAIN("scenes", "-o scenes.png"), "process.seconds", NULL, "s", NULL,
     true, 2},
    {"plan", "a plan for the brain", PLAN, "process.seconds", NULL, "s", NULL, true, 5},
    {"plan-peak", "memory of the same", PLAN, "process.peak_bytes", NULL, "bytes", NULL, true, 3e8},
    {"build-memory", "building a pyramid with shading directions, in memory", BUILD, "ratio_to_memcpy", NULL, "times",
     "memcpy of the same bytes, same run", true, 6},
    {"build-files", "the same from a file to files", BUILD, "to_files.ratio_to_disk", NULL, "times",
     "reading and writing the same bytes, same run, until the disk has them", true, 1.25},
    {"gradients", "central differences to float vectors", BUILD, "gradients_to_float.ratio_to_memcpy", NULL, "times",
     "memcpy of the same bytes, same run", true, 2},
    {"build-peak", "memory of the build, in memory and to files", BUILD, "process.peak_bytes", NULL, "bytes", NULL, true,
     NAN},
    {"codes-dense", "stored directions against differences on the fly, dense TF", RENDER,
     "cases[tf=dense,gradients=on-the-fly,loop=auto].milliseconds", "cases[tf=dense,gradients=codes,loop=auto].milliseconds",
     "times faster", "differences on the fly, same run", false, 1.8},
    {"codes-sparse", "the same with a sparse TF", RENDER, "cases[tf=sparse,gradients=on-the-fly,loop=auto].milliseconds",
     "cases[tf=sparse,gradients=codes,loop=auto].milliseconds", "times faster", "differences on the fly, same run", false,
     1.4},
    {"empty-space", "empty space left out, sparse TF, shaded", RENDER,
     "cases[tf=sparse,gradients=codes,loop=plain].milliseconds", "cases[tf=sparse,gradients=codes,loop=skipping].milliseconds",
     "times faster", "the loop that takes every sample, same run", false, 10},
    {"loop-dense", "the loop chosen for a dense TF", RENDER, "cases[tf=dense,gradients=codes,loop=auto].milliseconds",
     "cases[tf=dense,gradients=codes,loop=plain].milliseconds", "times", "the loop that takes every sample, same run", true,
     1.05},
    {"cpu-dense", "the CPU ray caster, dense TF, shaded, processor time", CAST,
     "cases[tf=dense,gradients=codes].processor_ratio", NULL, "times faster", "the OpenGL one by software, same run", false,
     1.5},
    {"cpu-sparse", "the same with a sparse TF", CAST, "cases[tf=sparse,gradients=codes].processor_ratio", NULL,
     "times faster", "the OpenGL one by software, same run", false, 1.5},
    {"bricks", "bricks of two levels without seams, dense TF, not lit", BRICKS,
     "cases[renderer=gl,texture=bricks-baked,gradients=none].milliseconds",
     "cases[renderer=gl,texture=uniform,gradients=none].milliseconds", "times", "one texture, same run", true, 1.1},
    {"cpu-bricks", "the same by the CPU ray caster", BRICKS,
     "cases[renderer=cpu,texture=bricks-baked,gradients=none].milliseconds",
     "cases[renderer=cpu,texture=uniform,gradients=none].milliseconds", "times", "the whole volume, same run", true, 1.1},
    {"vdb-seconds", "a volume to OpenVDB, processor time", EXPORT("vdb", "volume.vdb"), "process.processor_seconds", NULL,
     "s", NULL, true, 12},
    {"vdb-peak", "memory of the same", EXPORT("vdb", "volume.vdb"), "process.peak_bytes", NULL, "bytes", NULL, true, 8e8},
    {"blend-seconds", "a volume to a .blend file, processor time with Blender's", EXPORT("blender", "volume.blend"),
     "process.processor_seconds", NULL, "s", NULL, true, 12},
    {"blend-peak", "memory of the same, the larger of both programs", EXPORT("blender", "volume.blend"),
     "process.peak_bytes", NULL, "bytes", NULL, true, 8e8},
    {"df3-seconds", "a volume to a scene of POV-Ray, processor time", EXPORT("povray", "povray"),
     "process.processor_seconds", NULL, "s", NULL, true, 12},
    {"df3-peak", "memory of the same", EXPORT("povray", "povray"), "process.peak_bytes", NULL, "bytes", NULL, true, 8e8},
};
const size_t iso_headline_count = sizeof iso_headlines / sizeof *iso_headlines;

/* ---- paths to numbers ---- */

/* True if the object has key=value; value is a string or an integer. */
static bool has_value(const json_t *object, const char *key, const char *value)
{
    const json_t *found = json_object_get(object, key);
    char number[32];
    if (json_is_integer(found)) {
        snprintf(number, sizeof number, "%lld", (long long)json_integer_value(found));
        return strcmp(number, value) == 0;
    }
    return json_is_string(found) && strcmp(json_string_value(found), value) == 0;
}

/* Finds the first object of the list with all of "key=value,key=value". Cuts the text up. */
static const json_t *choose(const json_t *list, char *conditions)
{
    size_t i;
    const json_t *object;
    char *keys[8], *values[8];
    size_t count = 0;
    for (char *one; count < 8 && (one = strsep(&conditions, ","));) {
        keys[count] = strsep(&one, "=");
        values[count++] = one ? one : "";
    }
    json_array_foreach(list, i, object)
    {
        bool all = true;
        for (size_t k = 0; k < count; ++k)
            all = all && has_value(object, keys[k], values[k]);
        if (all)
            return object;
    }
    return NULL;
}

static const json_t *follow(const json_t *answer, const char *way)
{
    char *copy = strdup(way), *rest = copy;
    const json_t *at = copy ? answer : NULL;
    for (char *part; at && (part = strsep(&rest, "."));) {
        char *bracket = strchr(part, '[');
        if (bracket) {
            *bracket++ = 0;
            bracket[strcspn(bracket, "]")] = 0;
        }
        at = json_object_get(at, part);
        if (bracket)
            at = choose(at, bracket);
    }
    free(copy);
    return at;
}

static iso_status read_number(const iso_headline *h, const json_t *answer, const char *way, double *value, iso_error *err)
{
    const json_t *found = follow(answer, way);
    if (!json_is_number(found))
        return iso_fail(err, ISO_E_FORMAT, "%s: no number at %s in the command's answer", h->name, way);
    *value = json_number_value(found);
    return ISO_OK;
}

iso_status iso_headline_value(const iso_headline *h, const json_t *answer, double *value, iso_error *err)
{
    double over = 1;
    iso_status status = read_number(h, answer, h->figure, value, err);
    if (status == ISO_OK && h->over)
        status = read_number(h, answer, h->over, &over, err);
    if (status == ISO_OK && !(over > 0))
        status = iso_fail(err, ISO_E_FORMAT, "%s: %s is %g", h->name, h->over, over);
    *value /= over;
    return status;
}
