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

/* Writes the user's settings. Functions cannot read arrays, so each entry of Iso_Lights is copied to scalars. */
void iso_povray_write_lights(FILE *f, const iso_view *v)
{
    fprintf(f,
            "// ---- the lights -----------------------------------------------------------\n"
            "// Direction to each light, and its intensity.\n"
            "#ifndef (Iso_Lights) #declare Iso_Lights = array[%zu] {\n",
            v->light_count > 0 ? v->light_count : 1);
    for (size_t i = 0; i < v->light_count; ++i)
        fprintf(f, "    <%.17g, %.17g, %.17g, %.17g>%s\n", v->lights[i].direction.x, v->lights[i].direction.y,
                v->lights[i].direction.z, v->lights[i].intensity, i + 1 < v->light_count ? "," : "");
    if (v->light_count == 0)
        fprintf(f, "    <0, 0, 1, 0>\n");
    fprintf(f,
            "} #end\n"
            "#declare Iso_Light_Count = dimension_size(Iso_Lights, 1);\n"
            "#declare Iso_Light_Sum = 0;\n"
            "#declare Iso_Light = 0;\n"
            "#while (Iso_Light < Iso_Light_Count)\n"
            "    #declare Iso_Light_Sum = Iso_Light_Sum + Iso_Lights[Iso_Light].t;\n"
            "    #declare Iso_Light = Iso_Light + 1;\n"
            "#end\n"
            "#macro Iso_Light_Take (I)\n"
            "    #declare Iso_Light_V = Iso_Lights[I];\n"
            "    #declare Iso_Light_L = vlength(<Iso_Light_V.x, Iso_Light_V.y, Iso_Light_V.z>);\n"
            "    #declare Iso_Light_X = Iso_Light_V.x / Iso_Light_L;\n"
            "    #declare Iso_Light_Y = Iso_Light_V.y / Iso_Light_L;\n"
            "    #declare Iso_Light_Z = Iso_Light_V.z / Iso_Light_L;\n"
            "    #declare Iso_Light_I = Iso_Light_V.t;\n"
            "#end\n"
            "// Upper bounds of diffuse light and highlights.\n"
            "#declare Iso_Diffuse_Most = max(1, %.17g + %.17g * Iso_Light_Sum);\n"
            "#declare Iso_Specular_Most = max(1e-9, %.17g * Iso_Light_Sum);\n\n",
            v->shading.ambient, v->shading.diffuse, v->shading.specular);
}

static const char each_light[] =
    "#declare Iso_Light = 0;\n#while (Iso_Light < Iso_Light_Count) Iso_Light_Take (Iso_Light)\n";
static const char next_light[] = "#declare Iso_Light = Iso_Light + 1;\n#end\n";

/* Writes ka + kd sum of intensity |n.l|, with n = d / sqrt(|d|^2 + eps^2); at most Iso_Diffuse_Most. */
void iso_povray_write_diffuse(FILE *f, const iso_povray_scene *s)
{
    const iso_view *v = s->view;
    fprintf(f,
            "#declare Iso_Diffuse_Of = function (dx, dy, dz) { %.17g\n%s"
            "    + %.17g * Iso_Light_I * abs(dx * Iso_Light_X + dy * Iso_Light_Y + dz * Iso_Light_Z)\n"
            "        / sqrt(dx*dx + dy*dy + dz*dz + %.17g)\n%s }\n",
            v->shading.ambient, each_light, v->shading.diffuse, ISO_DIRECTION_EPS * ISO_DIRECTION_EPS, next_light);
    if (s->options->isosurface)
        return;
    fprintf(f,
            "#declare Iso_Diffuse = density {\n"
            "    function { %smin(1, Iso_Diffuse_Of(Iso_Dx(x, y, z), Iso_Dy(x, y, z), Iso_Dz(x, y, z)) / Iso_Diffuse_Most)%s }\n"
            "    color_map { [0 rgb 0] [1 rgb 1] } }\n\n",
            iso_povray_lazily(s, "select(Iso_Opaque(x, y, z), 0, "), iso_povray_lazily(s, ")"));
}

/* Writes the vector to the viewer at a point in voxel coordinates, as three arguments of a function. For an
 * orthographic camera it is the unit vector, unless the user declares the viewer. */
static void write_to_viewer(FILE *f, const iso_povray_scene *s)
{
    static const char *const axis[3] = {"X", "Y", "Z"}, *const part[3] = {"x", "y", "z"};
    const iso_camera *camera = &s->view->camera;
    const double forward[3] = {camera->forward.x, camera->forward.y, camera->forward.z};
    const iso_vec3 center = iso_sub(s->center_mm, s->geometry->origin_mm),
                   eye = iso_sub(camera->position, s->geometry->origin_mm);
    if (camera->orthographic)
        fprintf(f, "#ifdef (Iso_Viewer)\n");
    fprintf(f,
            "#ifdef (Iso_Viewer) #declare Iso_Viewer_At = Iso_Viewer / Iso_Units_Per_mm + <%.17g, %.17g, %.17g>;\n"
            "#else #declare Iso_Viewer_At = <%.17g, %.17g, %.17g>; #end\n",
            center.x, center.y, center.z, eye.x, eye.y, eye.z);
    for (int a = 0; a < 3; ++a) {
        const double *m = s->geometry->index_to_world.m[a];
        fprintf(f,
                "#declare Iso_Viewer_At_%s = Iso_Viewer_At.%s;\n"
                "#declare Iso_Viewer_%s = function (x, y, z) { Iso_Viewer_At_%s - x * %.17g - y * %.17g - z * %.17g } // mm\n",
                axis[a], part[a], axis[a], axis[a], m[0], m[1], m[2]);
    }
    if (!camera->orthographic)
        return;
    fprintf(f, "#else\n");
    for (int a = 0; a < 3; ++a)
        fprintf(f, "#declare Iso_Viewer_%s = function (x, y, z) { %.17g }\n", axis[a], -forward[a]);
    fprintf(f, "#end\n");
}

/* Writes sum of intensity |n.h|^p over the sum of the intensities, h = normalize(l + v): n.h = (d.l + d.v) / (|d|
 * sqrt(2 + 2 l.v)). */
void iso_povray_write_specular(FILE *f, const iso_povray_scene *s)
{
    fprintf(f, "// Highlights need the direction to the viewer: they belong to this camera, or to Iso_Viewer.\n");
    write_to_viewer(f, s);
    fprintf(f,
            "// d: direction, v: unit vector to the viewer, n: the length that makes d a normal\n"
            "#declare Iso_Specular_Unit = function (dx, dy, dz, vx, vy, vz, n) { 0\n%s"
            "    + Iso_Light_I / max(1e-9, Iso_Light_Sum) * pow(min(1, abs(dx * (vx + Iso_Light_X) + dy * (vy + Iso_Light_Y)\n"
            "        + dz * (vz + Iso_Light_Z)) / (n * sqrt(max(1e-24,\n"
            "        2 + 2 * (vx * Iso_Light_X + vy * Iso_Light_Y + vz * Iso_Light_Z))))), %.17g)\n%s }\n",
            each_light, s->view->shading.power, next_light);
    fprintf(f,
            "#declare Iso_Specular_Of = function (dx, dy, dz, vx, vy, vz, v) {\n"
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

/* Writes an opaque surface in the TF's color at the value, times the shade of the stored direction: POV-Ray's own
 * normals are gradients of the trilinear field, which jump from cell to cell. */
void iso_povray_write_surface(FILE *f, const iso_povray_scene *s)
{
    const double specular = iso_povray_specular_sum(s->view);
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
                "\n    + Iso_Specular_Most * Iso_Specular_At(Iso_Dx(x, y, z), Iso_Dy(x, y, z), Iso_Dz(x, y, z),\n"
                "        Iso_Viewer_X(x, y, z), Iso_Viewer_Y(x, y, z), Iso_Viewer_Z(x, y, z))");
    fprintf(f,
            ") / (Iso_Diffuse_Most + Iso_Specular_Most) }\n"
            "#declare Iso_Surface = %sisosurface {\n"
            "    function { (Iso_Surface_Value - %.17g) * %.17g - Iso_Stored(x, y, z) }\n"
            "    contained_by { box { Iso_Box_Low, Iso_Box } }\n"
            "    threshold 0 accuracy 1e-6 max_gradient %.9g%s\n",
            clipped ? "intersection { " : "", s->scalar.lo, 1 / (s->scalar.hi - s->scalar.lo),
            s->max_gradient, clipped ? " all_intersections }" : "");
    iso_povray_write_clips(f, s);
    fprintf(f,
            "    pigment { function { min(1, Iso_Surface_Shade(x, y, z)) }\n"
            "        color_map { [0 rgb 0] [1 rgb <%.9g, %.9g, %.9g> * Iso_Emission\n"
            "            * (Iso_Diffuse_Most + Iso_Specular_Most)] } }\n"
            "    #if (!Iso_Shadows) no_shadow #end\n"
            "    finish { emission 1 ambient 0 diffuse 0 } }\n",
            rgbs[0], rgbs[1], rgbs[2]);
}
