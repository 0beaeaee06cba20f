/* SPDX-License-Identifier: MIT */
/* scene.c - the files of pbrt-v4: https://pbrt.org/fileformat-v4
 *
 * - An "rgbgrid" without sigma_s gets 1 everywhere, so zeros are written.
 * - Le is the color times the illuminant of the color space, without the factor that lights have. Lescale is 1 over
 *   pbrt's integral of the luminous efficiency, 106.856895, to which its illuminants are scaled.
 * - Matrices are stored column by column. The camera looks along its z axis with x to the right, so the transform from
 *   the world is written unchanged, without mirroring.
 * - The medium follows the camera, whose transform pbrt needs first, and precedes the world, because a camera inside
 *   the medium refers to it. */
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/file.h"
#include "base/provenance.h"
#include "pbrt/pbrt.h"

static const double le_scale = 1 / 106.856895;

/* Prints a transform. rows: of a 3 x 4 matrix. */
static void print_transform(FILE *f, const char *directive, double rows[3][4])
{
    fprintf(f, "%s [", directive);
    for (int c = 0; c < 4; ++c)
        fprintf(f, " %.9g %.9g %.9g %d", rows[0][c], rows[1][c], rows[2][c], c == 3);
    fprintf(f, " ]\n");
}

static void print_camera(FILE *f, const iso_medium *m)
{
    const iso_view *view = m->baked->view;
    const iso_camera *camera = &m->camera;
    const iso_vec3 axes[3] = {camera->right, camera->up, camera->forward};
    const double aspect = (double)view->width / (double)view->height;
    const double half = camera->orthographic ? camera->half_height : 1;
    double rows[3][4];
    for (int r = 0; r < 3; ++r) {
        rows[r][0] = axes[r].x;
        rows[r][1] = axes[r].y;
        rows[r][2] = axes[r].z;
        rows[r][3] = -iso_dot(axes[r], camera->position);
    }
    print_transform(f, "Transform", rows);
    fprintf(f, "Camera \"%s\" \"float screenwindow\" [ %.9g %.9g %.9g %.9g ]",
            camera->orthographic ? "orthographic" : "perspective", -aspect * half, aspect * half, -half, half);
    if (!camera->orthographic)
        fprintf(f, " \"float fov\" [ %.9g ]", 360 / acos(-1) * atan(camera->half_height));
    fprintf(f, "\n");
}

static void print_lattice(FILE *f, const iso_geometry *g)
{
    double rows[3][4];
    const double origin[3] = {g->origin_mm.x, g->origin_mm.y, g->origin_mm.z};
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
            rows[r][c] = g->index_to_world.m[r][c];
        rows[r][3] = origin[r];
    }
    print_transform(f, "Transform", rows);
}

/* Prints the box. Bits number its corners: 1 along x, 2 along y, 4 along z. Triangles are counterclockwise from
 * outside. */
static void print_box(FILE *f, const size_t size[3])
{
    fprintf(f, "Shape \"trianglemesh\" \"point3 P\" [");
    for (size_t i = 0; i < 8; ++i)
        fprintf(f, " %zu %zu %zu", (i & 1) * size[0], (i >> 1 & 1) * size[1], (i >> 2) * size[2]);
    fprintf(
        f,
        " ]\n    \"integer indices\" [ 0 2 3 0 3 1  4 5 7 4 7 6  0 1 5 0 5 4  2 6 7 2 7 3  0 4 6 0 6 2  1 3 7 1 7 5 ]\n");
}

/* Prints the volume's name, in characters that comments can hold, and a note on optimized values. */
static void print_source(FILE *f, const iso_medium *m)
{
    for (const char *c = iso_provenance_title(m->made_from); *c; ++c)
        fputc(isalnum((unsigned char)*c) || strchr("._ ", *c) ? *c : '_', f);
    fputs(m->baked->level->is_optimized ? "; values: " ISO_OPTIMIZED_VALUES : "", f);
}

static void print_scene(FILE *f, const iso_medium *m)
{
    const iso_view *view = m->baked->view;
    const double *b = m->background;
    fprintf(f, "# isoshade, pbrt-v4: ");
    print_source(f, m);
    fprintf(
        f,
        "\n# A medium of baked grids that emits and absorbs; lengths in %s. Its colors are shaded for this camera and its lights.\n"
        "# Rays pass through pixel centers; a wider filter smooths edges.\n"
        "Film \"rgb\" \"integer xresolution\" [ %zu ] \"integer yresolution\" [ %zu ] \"string filename\" [ \"scene.exr\" ] \"bool savefp16\" [ false ]\n"
        "PixelFilter \"box\" \"float xradius\" [ 0.0005 ] \"float yradius\" [ 0.0005 ]\n"
        "Sampler \"zsobol\" \"integer pixelsamples\" [ 256 ] \"integer seed\" [ 0 ]\n"
        "Integrator \"volpath\" \"integer maxdepth\" [ 1 ]\n",
        m->unit, view->width, view->height);
    if (m->camera_is_inside)
        fprintf(f, "MediumInterface \"\" \"volume\"\n");
    print_camera(f, m);
    print_lattice(f, &m->geometry);
    fprintf(f, "Include \"medium.pbrt\"\nWorldBegin\n");
    if (b[0] > 0 || b[1] > 0 || b[2] > 0)
        fprintf(f, "LightSource \"infinite\" \"rgb L\" [ %.9g %.9g %.9g ]\n", b[0], b[1], b[2]);
    print_lattice(f, &m->geometry);
    fprintf(f, "MediumInterface \"volume\" \"\"\nMaterial \"interface\"\n");
    print_box(f, m->geometry.size);
}

static void print_triple(FILE *f, const float v[3])
{
    if (v[0] == 0 && v[1] == 0 && v[2] == 0)
        fputs(" 0 0 0", f); /* most points of most grids, and faster than printf() */
    else
        fprintf(f, " %.9g %.9g %.9g", (double)v[0], (double)v[1], (double)v[2]);
}

/* Prints the values, or zeros if `zero`. */
static void print_values(FILE *f, const iso_medium *m, bool color, bool zero)
{
    const size_t *n = m->geometry.size;
    for (size_t z = 0; z < n[2]; ++z)
        for (size_t y = 0; y < n[1]; ++y) {
            for (size_t x = 0; x < n[0]; ++x) {
                float extinction = 0, rgb[3] = {0};
                if (!zero)
                    iso_medium_point(m, x, y, z, &extinction, rgb);
                print_triple(f, color ? rgb : (const float[3]){extinction, extinction, extinction});
            }
            fputc('\n', f);
        }
}

static void print_medium(FILE *f, const iso_medium *m)
{
    const size_t *n = m->geometry.size;
    fprintf(f,
            "# Extinction per %s (sigma_a) and shaded color (Le) at the points of a grid, x fastest; sigma_s is 0.\n"
            "MakeNamedMedium \"volume\" \"string type\" [ \"rgbgrid\" ]\n"
            "    \"integer nx\" [ %zu ] \"integer ny\" [ %zu ] \"integer nz\" [ %zu ]\n"
            "    \"point3 p0\" [ 0 0 0 ] \"point3 p1\" [ %zu %zu %zu ]\n"
            "    \"float Lescale\" [ %.9g ]\n    \"rgb sigma_a\" [\n",
            m->unit, n[0], n[1], n[2], n[0], n[1], n[2], le_scale);
    print_values(f, m, false, false);
    fprintf(f, "    ]\n    \"rgb Le\" [\n");
    print_values(f, m, true, false);
    fprintf(f, "    ]\n    \"rgb sigma_s\" [\n");
    print_values(f, m, false, true);
    fprintf(f, "    ]\n");
}

static iso_status write_text(const iso_medium *m, const char *folder, const char *name,
                             void print(FILE *, const iso_medium *), iso_error *err)
{
    FREED char *path = iso_path_join(folder, name);
    NEED_MEMORY(path, err, "%s: out of memory", name);
    FILE *f = fopen(path, "wb");
    if (!f)
        return iso_fail(err, iso_errno_status(), "%s: %s", path, strerror(errno));
    print(f, m);
    const bool failed = ferror(f);
    if (fclose(f) == 0 && !failed)
        return ISO_OK;
    return iso_fail(err, ISO_E_IO, "%s: cannot be written (is the disk full?)", path);
}

iso_status iso_medium_write(const iso_medium *m, const char *folder, iso_error *err)
{
    NEED(write_text(m, folder, "medium.pbrt", print_medium, err));
    return write_text(m, folder, "scene.pbrt", print_scene, err);
}
