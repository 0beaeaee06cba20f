/* SPDX-License-Identifier: MIT */
/* mitsuba.c - a scene of Mitsuba 3: https://mitsuba.readthedocs.io/en/stable/src/plugin_reference.html
 *
 * - Mitsuba's media do not emit (src/media/heterogeneous.cpp has albedo and sigma_t). So the picture shows the
 * background
 *   through the medium; a black background is replaced by white.
 * - .vol files: "VOL", 3, int32 1 (float32), int32 size x, y, z and channels, 6 float32 of a box, samples x fastest,
 * all
 *   little-endian (src/volumes/grid.cpp). Points are centers of cells of the unit cube, which to_world places.
 * - Its camera looks along z with x to the left and y up. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "media/media.h"

/* Prints a transform. columns[3]: position of the origin. */
static void print_matrix(FILE *f, const char *indent, const iso_vec3 columns[4])
{
    const iso_vec3 *c = columns;
    fprintf(f,
            "%s<transform name=\"to_world\">\n"
            "%s    <matrix value=\"%.9g %.9g %.9g %.9g  %.9g %.9g %.9g %.9g  %.9g %.9g %.9g %.9g  0 0 0 1\"/>\n"
            "%s</transform>\n",
            indent, indent, c[0].x, c[1].x, c[2].x, c[3].x, c[0].y, c[1].y, c[2].y, c[3].y, c[0].z, c[1].z, c[2].z,
            c[3].z, indent);
}

/* Prints the transform to the grid's box, from the unit cube, or from [-1, 1] along each axis if `sides` is 2. */
static void print_box(FILE *f, const char *indent, const iso_geometry *g, double sides)
{
    iso_vec3 columns[4];
    for (int c = 0; c < 3; ++c)
        columns[c] = iso_scale(iso_column(g->index_to_world, c), (double)g->size[c] / sides);
    columns[3] = g->origin_mm;
    for (int c = 0; c < 3 && sides == 2; ++c)
        columns[3] = iso_add(columns[3], columns[c]);
    print_matrix(f, indent, columns);
}

static void print_sensor(FILE *f, const iso_medium *m)
{
    const iso_view *view = m->baked->view;
    const iso_camera *c = &m->camera;
    const iso_vec3 middle = iso_geometry_box_center_mm(&m->geometry);
    const double distance = sqrt(iso_dot(iso_sub(middle, c->position), iso_sub(middle, c->position)));
    const double radius = iso_geometry_box_radius_mm(&m->geometry), aspect = (double)view->width / (double)view->height;
    /* An orthographic film is 2 units wide along x. */
    const double scale = c->orthographic ? c->half_height * aspect : 1;
    const iso_vec3 columns[4] = {iso_scale(c->right, -scale), iso_scale(c->up, scale), c->forward, c->position};
    fprintf(f, "    <sensor type=\"%s\">\n", c->orthographic ? "orthographic" : "perspective");
    if (!c->orthographic)
        fprintf(f, "        <string name=\"fov_axis\" value=\"y\"/>\n        <float name=\"fov\" value=\"%.9g\"/>\n",
                360 / acos(-1) * atan(c->half_height));
    fprintf(f,
            "        <float name=\"near_clip\" value=\"%.9g\"/>\n        <float name=\"far_clip\" value=\"%.9g\"/>\n",
            1e-4 * radius, distance + 2 * radius);
    print_matrix(f, "        ", columns);
    if (m->camera_is_inside)
        fprintf(f, "        <ref id=\"volume\"/>\n");
    fprintf(f,
            "        <sampler type=\"independent\">\n            <integer name=\"sample_count\" value=\"256\"/>\n"
            "        </sampler>\n"
            "        <film type=\"hdrfilm\">\n            <integer name=\"width\" value=\"%zu\"/>\n"
            "            <integer name=\"height\" value=\"%zu\"/>\n"
            "            <string name=\"pixel_format\" value=\"rgb\"/>\n"
            "            <string name=\"component_format\" value=\"float32\"/>\n"
            "            <rfilter type=\"box\"/>\n        </film>\n    </sensor>\n",
            view->width, view->height);
}

static void print_scene(FILE *f, const iso_medium *m)
{
    const double *b = m->background;
    const bool dark = !(b[0] > 0 || b[1] > 0 || b[2] > 0);
    fprintf(f, "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!-- isoshade, Mitsuba 3: ");
    iso_medium_print_source(m, f);
    fprintf(
        f,
        " -->\n"
        "<!-- A medium that only absorbs, extinction per %s: Mitsuba's media do not emit yet, so it has no colors. -->\n",
        m->unit);
    if (dark)
        fprintf(f, "<!-- The background light is white, because the scene's background is black. -->\n");
    fprintf(f,
            "<scene version=\"3.0.0\">\n"
            "    <integrator type=\"volpath\">\n        <integer name=\"max_depth\" value=\"-1\"/>\n"
            "        <integer name=\"rr_depth\" value=\"1000\"/>\n    </integrator>\n"
            "    <medium type=\"heterogeneous\" id=\"volume\">\n        <volume name=\"sigma_t\" type=\"gridvolume\">\n"
            "            <string name=\"filename\" value=\"sigma_t.vol\"/>\n"
            "            <string name=\"filter_type\" value=\"trilinear\"/>\n"
            "            <string name=\"wrap_mode\" value=\"clamp\"/>\n"
            "            <boolean name=\"raw\" value=\"true\"/>\n");
    print_box(f, "            ", &m->geometry, 1);
    fprintf(f, "        </volume>\n        <float name=\"albedo\" value=\"0\"/>\n"
               "        <float name=\"scale\" value=\"1\"/>\n    </medium>\n");
    print_sensor(f, m);
    fprintf(
        f,
        "    <emitter type=\"constant\">\n        <rgb name=\"radiance\" value=\"%.9g %.9g %.9g\"/>\n    </emitter>\n",
        dark ? 1 : b[0], dark ? 1 : b[1], dark ? 1 : b[2]);
    fprintf(f, "    <shape type=\"cube\">\n");
    print_box(f, "        ", &m->geometry, 2);
    fprintf(f,
            "        <bsdf type=\"null\"/>\n        <ref name=\"interior\" id=\"volume\"/>\n    </shape>\n</scene>\n");
}

static iso_status write_scene(const iso_medium *m, const char *folder, iso_error *err)
{
    FREED char *path = NULL;
    FILE *f;
    NEED(iso_medium_open(folder, "scene.xml", &path, &f, err));
    print_scene(f, m);
    return iso_medium_close(f, path, err);
}

/* Writes the native byte order, which is little-endian on all supported machines. */
static void write_grid(FILE *f, const iso_medium *m)
{
    const size_t *n = m->geometry.size;
    const int32_t header[5] = {1, (int32_t)n[0], (int32_t)n[1], (int32_t)n[2], 1};
    const float box[6] = {0, 0, 0, 1, 1, 1};
    fwrite("VOL\3", 1, 4, f);
    fwrite(header, sizeof *header, 5, f);
    fwrite(box, sizeof *box, 6, f);
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y)
            for (size_t x = 0; x < n[0]; ++x) {
                float extinction, color[3];
                iso_medium_point(m, x, y, z, &extinction, color);
                fwrite(&extinction, sizeof extinction, 1, f);
            }
}

iso_status iso_medium_write_mitsuba(const iso_medium *m, const char *folder, iso_error *err)
{
    FREED char *path = NULL;
    FILE *f;
    NEED(iso_medium_open(folder, "sigma_t.vol", &path, &f, err));
    write_grid(f, m);
    NEED(iso_medium_close(f, path, err));
    return write_scene(m, folder, err);
}
