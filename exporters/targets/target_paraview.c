/* SPDX-License-Identifier: MIT */
/* target_paraview.c - a level and a scene as a folder for ParaView. */
#define _GNU_SOURCE
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/json.h"
#include "pyramid/narrow.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"
#include "targets/targets.h"

/* ---- paraview ---- */

/* Exports a level and a scene for ParaView and pvbatch.
 *
 * A folder: NAME.vti, the level as VTK image data, and NAME.py, a state that shows it. "pvbatch NAME.py" writes
 * NAME.png to the folder.
 *
 *     NAME.vti   float32, appended raw. The values belong to CELLS. ParaView draws point data from the first point to the
 *                last, which would cut half a voxel at each face. It draws cells to their outer faces, interpolates
 *                between their centers, and clamps to the edge beyond, as isoshade does.
 *                Origin, Spacing and Direction are the level's: world = origin + direction spacing index.
 *     NAME.py    the transfer function's table as opacities for unit_mm, which is ScalarOpacityUnitDistance;
 *                camera, background, size of the view. Colors are linear light and are not converted.
 *
 * The Python contains no text of the user: the file's name has only letters, digits, "-" and "_", and the rest are
 * numbers. Shading is ParaView's own (doc/guide/other-programs.md). */

ISO_EMBED(iso_paraview_state_py, "exporters/paraview/state.py");

/* Columns are orthogonal up to this cosine, as VTK's Direction requires. Positions that are rounded to 5 digits turn an
 * axis by 1e-5, which moves the last of 1,000 voxels by a hundredth of one. */
#define MOST_SHEAR 2e-5

static bool is_sheared(const iso_geometry *g)
{
    double spacing[3];
    iso_geometry_spacing_mm(g, spacing);
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3;
        double dot = 0;
        for (int r = 0; r < 3; ++r)
            dot += g->index_to_world.m[r][a] * g->index_to_world.m[r][b];
        if (!(fabs(dot) <= MOST_SHEAR * spacing[a] * spacing[b]))
            return true;
    }
    return false;
}

static iso_status check(const iso_level *level, const iso_view *view, iso_error *err)
{
    const char *what = view->clip_count > 0           ? "clip planes"
                       : view->tf_2d                  ? "a 2D transfer function"
                       : view->extinction_scale       ? "extinction scales, which coarse levels with gaps have, too"
                       : view->roi                    ? "a region of interest"
                       : level->labels                ? "a label map"
                       : is_sheared(&level->geometry) ? "a sheared grid"
                                                      : NULL;
    return what ? iso_fail(err, ISO_E_USAGE, "--to paraview does not support %s", what) : ISO_OK;
}

/* ---- NAME.vti ---- */

/* Writes the header. Coarse voxels that overhang the box are drawn whole. */
static void put_header(FILE *f, const iso_level *level)
{
    const iso_geometry *g = &level->geometry;
    double h[3];
    iso_geometry_spacing_mm(g, h);
    const size_t *n = g->size;
    fprintf(f,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"%s\" "
            "header_type=\"UInt64\">\n",
            __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? "LittleEndian" : "BigEndian");
    fprintf(f,
            "  <ImageData WholeExtent=\"0 %zu 0 %zu 0 %zu\" Origin=\"%.17g %.17g %.17g\" Spacing=\"%.17g %.17g %.17g\" "
            "Direction=\"",
            n[0], n[1], n[2], g->origin_mm.x, g->origin_mm.y, g->origin_mm.z, h[0], h[1], h[2]);
    for (int i = 0; i < 9; ++i)
        fprintf(f, "%.17g%s", g->index_to_world.m[i / 3][i % 3] / h[i % 3], i < 8 ? " " : "\">\n");
    fprintf(f, "    <Piece Extent=\"0 %zu 0 %zu 0 %zu\">\n      <PointData/>\n      <CellData Scalars=\"value\">\n",
            n[0], n[1], n[2]);
    fprintf(
        f,
        "        <DataArray type=\"Float32\" Name=\"value\" format=\"appended\" RangeMin=\"%.9g\" RangeMax=\"%.9g\" "
        "offset=\"0\"/>\n",
        level->min, level->max);
    fprintf(f, "      </CellData>\n    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n_");
}

static iso_status write_vti(const iso_level *level, const char *path, iso_error *err)
{
    enum { BLOCK = 1024 };
    FILE *f = fopen(path, "wb");
    if (!f)
        return iso_fail(err, ISO_E_IO, "%s: cannot be written", path);
    const size_t count = iso_geometry_voxel_count(&level->geometry);
    const uint64_t bytes = count * sizeof *level->scalar;
    put_header(f, level);
    bool good = fwrite(&bytes, sizeof bytes, 1, f) == 1;
    float values[BLOCK];
    for (size_t at = 0; at < count && good; at += BLOCK) {
        const size_t n = count - at < BLOCK ? count - at : BLOCK;
        iso_level_file_scalars(level, NULL, at, n, values);
        good = fwrite(values, sizeof *values, n, f) == n;
    }
    good = fprintf(f, "\n  </AppendedData>\n</VTKFile>\n") > 0 && good;
    good = fclose(f) == 0 && good;
    return good ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be written whole", path);
}

/* ---- NAME.py ---- */

static json_t *vector_json(iso_vec3 v)
{
    return iso_json_numbers((double[]){v.x, v.y, v.z}, 3);
}

/* Returns the length for opacities: the transfer function's, or if unknown, one at which all are at most 0.87. */
static double unit_of(const iso_tf_table *tf)
{
    double most = 0;
    for (size_t i = 0; i < tf->count; ++i)
        most = fmax(most, (double)tf->entries[4 * i + 3]);
    return tf->unit_mm > 0 ? tf->unit_mm : most > 0 ? 2 / most : 1;
}

/* Returns the number of points between two entries. A line between extinctions is a curve between opacities: far apart,
 * it needs more points to stay within a hundredth of a step of 8 bits. */
static size_t steps_between(double first, double last, double unit_mm)
{
    const double bend = fabs(last - first) * unit_mm;
    return (size_t)fmin(ceil(sqrt(bend * bend * 3200)), 64) + (bend == 0);
}

/* Returns the TF as JSON. bright: factor of the colors; the ambient light if the scene has no lights. */
static json_t *tf_json(const iso_tf_table *tf, double bright)
{
    const double unit_mm = unit_of(tf), width = (tf->hi - tf->lo) / (double)(tf->count - 1);
    json_t *colors = json_array(), *opacities = json_array();
    for (size_t i = 0; i < tf->count; ++i) {
        const float *e = tf->entries + 4 * i;
        const double first = (double)e[3], last = i + 1 < tf->count ? (double)e[7] : first;
        const size_t steps = i + 1 < tf->count ? steps_between(first, last, unit_mm) : 1;
        const double value = tf->lo + width * (double)i;
        json_array_append_new(colors, iso_json_numbers((double[]){value, bright * (double)e[0], bright * (double)e[1],
                                                                  bright * (double)e[2]},
                                                       4));
        for (size_t k = 0; k < steps; ++k) {
            const double part = (double)k / (double)steps;
            const double extinction = first + (last - first) * part;
            json_array_append_new(opacities,
                                  iso_json_numbers((double[]){value + width * part, -expm1(-extinction * unit_mm)}, 2));
        }
    }
    return json_pack("{s:f, s:o, s:o}", "unit_mm", unit_mm, "colors", colors, "opacities", opacities);
}

static json_t *camera_json(const iso_camera *c)
{
    return json_pack("{s:s, s:o, s:o, s:o, s:f}", "projection", c->orthographic ? "orthographic" : "perspective",
                     "position", vector_json(c->position), "forward", vector_json(c->forward), "up", vector_json(c->up),
                     "half_height", c->half_height);
}

static json_t *scene_json(const iso_level *level, const iso_view *view, const char *name)
{
    const iso_shading *s = &view->shading;
    const bool lit = iso_view_is_lit(view);
    return json_pack("{s:s, s:i, s:i, s:o, s:o, s:o, s:o, s:i, s:o, s:{s:f, s:f, s:f, s:f}}", "name", name, "width",
                     (int)view->width, "height", (int)view->height, "center",
                     vector_json(iso_geometry_box_center_mm(&level->geometry)), "camera", camera_json(&view->camera),
                     "tf", tf_json(&view->tf, lit ? 1 : s->ambient), "background",
                     iso_json_numbers(view->background, 3), "shade", lit, "lights", iso_view_lights_to_json(view),
                     "shading", "ambient", s->ambient, "diffuse", s->diffuse, "specular", s->specular, "power",
                     s->power);
}

/* Writes the state with the scene as a Python literal: ASCII strings and numbers are the same in JSON and Python. */
static iso_status write_state(json_t *scene, const char *path, iso_error *err)
{
    static const char place[] = "SCENE = {}";
    const char *at = strstr(iso_paraview_state_py, place);
    FREED char *literal = scene ? json_dumps(scene, JSON_ENSURE_ASCII | JSON_INDENT(1) | JSON_REAL_PRECISION(9)) : NULL;
    char *text = NULL;
    const int length = literal && at ? asprintf(&text, "%.*sSCENE = %s%s", (int)(at - iso_paraview_state_py),
                                                iso_paraview_state_py, literal, at + sizeof place - 1)
                                     : -1;
    const iso_status status = length >= 0 ? iso_file_write(path, text, (size_t)length, err)
                                          : iso_fail(err, ISO_E_MEMORY, "%s: no memory", path);
    if (length >= 0)
        free(text);
    return status;
}

/* ---- the folder ---- */

static iso_status write_files(const iso_level *level, const iso_view *view, const char *name, const char *dir,
                              iso_error *err)
{
    FREED char *vti = NULL, *state = NULL;
    NEED(asprintf(&vti, "%s/%s.vti", dir, name) >= 0 && asprintf(&state, "%s/%s.py", dir, name) >= 0
             ? write_vti(level, vti, err)
             : iso_fail(err, ISO_E_MEMORY, "out of memory"));
    json_auto_t *scene = scene_json(level, view, name);
    return write_state(scene, state, err);
}

/* Exports the folder. ISO_E_USAGE: clip planes, a 2D transfer function, extinction scales, a region of interest, a
 * label map, or a sheared grid. ISO_E_IO, ISO_E_MEMORY. */
static iso_status paraview_export(const iso_pyramid *p, size_t level, const iso_view *view, const char *dir,
                                  iso_error *err)
{
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    NEED(check(&p->levels[level], view, err));
    FREED char *name = iso_path_plain_name(dir);
    NEED_MEMORY(name, err, "out of memory");
    NEED(iso_output_begin_dir(&out, dir, "*.vti", err)); /* any name: the folder may have been renamed */
    NEED(write_files(&p->levels[level], view, name, out.temp_path, err));
    return iso_output_commit(&out, err);
}

static iso_status write_paraview(const iso_export_job *job, iso_error *err)
{
    if (job->planned)
        return iso_fail(err, ISO_E_USAGE, "--plan has no meaning for --to paraview");
    OWNED(iso_view) view = {0};
    NEED(job->view_of_level(job, job->level, &view, err));
    return paraview_export(job->pyramid, job->level, &view, job->output, err);
}

const iso_export_target iso_export_target_paraview = {
    .name = "paraview",
    .title = "ParaView",
    .summary = "a folder with a .vti, and a state for ParaView and pvbatch",
    .output = "a folder",
    .options = ISO_EXPORT_TAKES(ISO_EXPORT_SCENE) | ISO_EXPORT_TAKES(ISO_EXPORT_SIZE) |
               ISO_EXPORT_TAKES(ISO_EXPORT_ADAPT),
    .write = write_paraview,
    .suffix = "",
};
