/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "encode/decode_double.h"
#include "povray/scene_parts.h"

double iso_povray_specular_sum(const iso_view *view)
{
    double sum = 0;
    for (size_t i = 0; i < view->light_count; ++i)
        sum += view->lights[i].intensity * view->shading.specular;
    return sum;
}

/* ka + kd sum of intensity |n.l|, with n = d / sqrt(|d|^2 + eps^2); at most 1. */
void iso_povray_write_diffuse(FILE *f, const iso_povray_scene *s)
{
    const iso_view *v = s->view;
    fprintf(f, "#declare Iso_Diffuse_Of = function (dx, dy, dz) {\n    %.17g", v->shading.ambient);
    for (size_t i = 0; i < v->light_count; ++i) {
        const iso_light *l = &v->lights[i];
        fprintf(f, "\n    + %.17g * abs(dx * %.17g + dy * %.17g + dz * %.17g) / sqrt(dx*dx + dy*dy + dz*dz + %.17g)",
                v->shading.diffuse * l->intensity, l->direction.x, l->direction.y, l->direction.z,
                ISO_DIRECTION_EPS * ISO_DIRECTION_EPS);
    }
    fprintf(f, " }\n");
    if (s->options->isosurface)
        return;
    fprintf(f,
            "#declare Iso_Diffuse = density {\n"
            "    function { %smin(1, Iso_Diffuse_Of(Iso_Dx(x, y, z), Iso_Dy(x, y, z), Iso_Dz(x, y, z)))%s }\n"
            "    color_map { [0 rgb 0] [1 rgb 1] } }\n\n",
            iso_povray_lazily(s, "select(Iso_Opaque(x, y, z), 0, "), iso_povray_lazily(s, ")"));
}

/* The unit vector to the viewer at a point in voxel coordinates, as a function's three arguments. */
static void write_to_viewer(FILE *f, const iso_povray_scene *s)
{
    const iso_camera *camera = &s->view->camera;
    if (camera->orthographic) {
        fprintf(f,
                "#declare Iso_Viewer_X = function (x, y, z) { %.17g }\n"
                "#declare Iso_Viewer_Y = function (x, y, z) { %.17g }\n"
                "#declare Iso_Viewer_Z = function (x, y, z) { %.17g }\n",
                -camera->forward.x, -camera->forward.y, -camera->forward.z);
        return;
    }
    static const char *const axis[3] = {"X", "Y", "Z"};
    const iso_vec3 o = iso_sub(camera->position, s->geometry->origin_mm);
    const double offset[3] = {o.x, o.y, o.z};
    for (int a = 0; a < 3; ++a) {
        const double *m = s->geometry->index_to_world.m[a];
        fprintf(f, "#declare Iso_Viewer_%s = function (x, y, z) { %.17g - x * %.17g - y * %.17g - z * %.17g } // mm\n",
                axis[a], offset[a], m[0], m[1], m[2]);
    }
}

/* sum of intensity |n.h|^p over the sum of the intensities, h = normalise(l + v): n.h = (d.l + d.v) / (|d| sqrt(2 + 2 l.v)). */
void iso_povray_write_specular(FILE *f, const iso_povray_scene *s)
{
    const iso_view *v = s->view;
    double intensities = 0;
    for (size_t i = 0; i < v->light_count; ++i)
        intensities += v->lights[i].intensity;
    fprintf(f, "// Highlights need the direction to the viewer: they belong to this camera.\n");
    write_to_viewer(f, s);
    fprintf(f, "// d: direction, v: unit vector to the viewer, n: the length that makes d a normal\n"
               "#declare Iso_Specular_Unit = function (dx, dy, dz, vx, vy, vz, n) {\n    0");
    for (size_t i = 0; i < v->light_count; ++i) {
        const iso_vec3 l = v->lights[i].direction;
        fprintf(f,
                "\n    + %.17g * pow(min(1, abs(dx * (vx + %.17g) + dy * (vy + %.17g) + dz * (vz + %.17g))"
                "\n        / (n * sqrt(max(1e-24, 2 + 2 * (vx * %.17g + vy * %.17g + vz * %.17g))))), %.17g)",
                v->lights[i].intensity / intensities, l.x, l.y, l.z, l.x, l.y, l.z, v->shading.power);
    }
    fprintf(f,
            " }\n#declare Iso_Specular_Of = function (dx, dy, dz, vx, vy, vz, v) {\n"
            "    Iso_Specular_Unit(dx, dy, dz, vx / v, vy / v, vz / v, sqrt(dx*dx + dy*dy + dz*dz + %.17g)) }\n"
            "#declare Iso_Specular_At = function (dx, dy, dz, vx, vy, vz) {\n"
            "    Iso_Specular_Of(dx, dy, dz, vx, vy, vz, sqrt(max(1e-24, vx*vx + vy*vy + vz*vz))) }\n",
            ISO_DIRECTION_EPS * ISO_DIRECTION_EPS);
    if (s->options->isosurface)
        return;
    fprintf(f,
            "#declare Iso_Specular = density {\n"
            "    function { %smin(1, Iso_Specular_At(Iso_Dx(x, y, z), Iso_Dy(x, y, z), Iso_Dz(x, y, z),\n"
            "        Iso_Viewer_X(x, y, z), Iso_Viewer_Y(x, y, z), Iso_Viewer_Z(x, y, z)))%s }\n"
            "    color_map { [0 rgb 0] [1 rgb 1] } }\n\n",
            iso_povray_lazily(s, "select(Iso_Opaque(x, y, z), 0, "), iso_povray_lazily(s, ")"));
}

/* Opaque, in the TF's colour at the value times the shade of the stored
 * direction: POV-Ray's own normals are gradients of the trilinear field, which
 * jump from cell to cell. */
void iso_povray_write_surface(FILE *f, const iso_povray_scene *s)
{
    const double specular = iso_povray_specular_sum(s->view), peak = 1 + specular;
    const bool clipped = s->view->clip_count > 0;
    double rgbs[4];
    iso_tf_lookup(&s->view->tf, s->options->iso, rgbs);
    fprintf(
        f,
        "// ---- the surface ----------------------------------------------------------\n"
        "// The first point of a ray where the value is at least Iso_Surface_Value. max_gradient bounds the slope of\n"
        "// the field: a smaller one is faster and loses pixels.\n"
        "#declare Iso_Surface_Value = %.17g;\n"
        "#declare Iso_Surface_Shade = function (x, y, z) {\n"
        "    (Iso_Diffuse_Of(Iso_Dx(x, y, z), Iso_Dy(x, y, z), Iso_Dz(x, y, z))",
        s->options->iso);
    if (specular > 0)
        fprintf(f,
                "\n    + %.17g * Iso_Specular_At(Iso_Dx(x, y, z), Iso_Dy(x, y, z), Iso_Dz(x, y, z),\n"
                "        Iso_Viewer_X(x, y, z), Iso_Viewer_Y(x, y, z), Iso_Viewer_Z(x, y, z))",
                specular);
    fprintf(f,
            ") * %.17g }\n"
            "#declare Iso_Surface = %sisosurface {\n"
            "    function { (Iso_Surface_Value - %.17g) * %.17g - Iso_Stored(x, y, z) }\n"
            "    contained_by { box { Iso_Box_Low, Iso_Box } }\n"
            "    threshold 0 accuracy 1e-6 max_gradient %.9g%s\n",
            1 / peak, clipped ? "intersection { " : "", s->scalar.lo, 1 / (s->scalar.hi - s->scalar.lo),
            s->max_gradient, clipped ? " all_intersections }" : "");
    iso_povray_write_clips(f, s);
    fprintf(f,
            "    pigment { function { min(1, Iso_Surface_Shade(x, y, z)) }\n"
            "        color_map { [0 rgb 0] [1 rgb <%.9g, %.9g, %.9g> * Iso_Emission * %.17g] } }\n"
            "    finish { emission 1 ambient 0 diffuse 0 } }\n",
            rgbs[0], rgbs[1], rgbs[2], peak);
}
