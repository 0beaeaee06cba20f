/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "povray/scene_text.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/words.h"
#include "fit/extinction_scale.h"
#include "povray/scene_parts.h"
#include "scene/roi.h"

/* Writes a "function { ... }" of one DF3 file in voxel coordinates, v in [0, 1]. Interpolated samples are at voxel
 * centers; others fill their voxel: POV-Ray places the two half a voxel apart. */
static void write_lookup_as(FILE *f, const iso_povray_scene *s, const char *identifier, const char *suffix,
                            bool interpolated)
{
    const size_t *n = s->voxels->geometry.size;
    const double scale = s->lattice_scale, *offset = s->lattice_offset, rim = interpolated ? 0.5 : 1;
    fprintf(f,
            "#declare %s = function { pattern { density_file df3 \"%s_%s.df3\" interpolate %d\n"
            "    scale <%.17g, %.17g, %.17g> translate <%.17g, %.17g, %.17g> } }\n",
            identifier, s->name, suffix, interpolated, (double)(n[0] + 2) / scale, (double)(n[1] + 2) / scale,
            (double)(n[2] + 2) / scale, (offset[0] - rim) / scale, (offset[1] - rim) / scale,
            (offset[2] - rim) / scale);
}

static void write_lookup(FILE *f, const iso_povray_scene *s, const char *identifier, const char *suffix)
{
    write_lookup_as(f, s, identifier, suffix, true);
}

static const char *object_name(const iso_povray_scene *s)
{
    return s->options->isosurface ? "Iso_Surface" : "Iso_Volume";
}

static void write_header(FILE *f, const iso_povray_scene *s)
{
    const iso_geometry *g = s->geometry;
    double h[3];
    iso_geometry_spacing_mm(g, h);
    fprintf(f,
            "// %s.inc - a shaded volume, made by isoshade: level %zu of %s,\n"
            "// %zu x %zu x %zu voxels of %.6g x %.6g x %.6g mm.\n"
            "%s"
            "//\n"
            "//     #include \"%s.inc\"\n"
            "//     object { %s transform { Iso_To_World } }\n"
            "//\n"
            "// %s is in voxel coordinates: voxel (i, j, k) covers [i, i+1] x [j, j+1] x [k, k+1].\n"
            "// Iso_To_World rotates and stretches it like the data, to about %g units across. Scale it as you\n"
            "// like, but not far below 100: POV-Ray works to 0.001 units. Set Iso_Scale too, or the density changes.\n"
            "//\n"
            "// The emitted color is already shaded, with pre-computed directions. By default its lights are those\n"
            "// of Iso_Lights. With Iso_Scattering = 1 the scene's light_sources light it instead.\n"
            "//\n"
            "// Options, declared before the #include; numbers also on the command line (Declare=Iso_Intervals=100):\n"
            "//     Iso_Intervals   samples along a ray, at most 255; fewer is faster\n"
            "//     Iso_Emission    factor of the brightness; 0 leaves only the absorption (1)\n"
            "//     Iso_Scale       your scale of the placed volume (1)\n"
            "//     Iso_Shadows     on or off: casts shadows on other objects (on)\n"
            "//     Iso_Scattering  1: the scene's lights scatter in it, with its own shadows; slow (0)\n"
            "//     Iso_Lights      array of <x, y, z, intensity>: directions towards lights, and their strengths\n"
            "//     Iso_Viewer      position of the camera, for highlights (that of the export)\n"
            "// Positions and directions are in the space of Iso_To_World, before you move the volume.\n"
            "#declare Iso_Version_Before = version;\n"
            "#version 3.7; // 3.8 reads it too; the including scene's version is restored below\n\n"
            "#ifndef (Iso_Intervals) #declare Iso_Intervals = %zu; #end\n"
            "#ifndef (Iso_Emission) #declare Iso_Emission = 1; #end\n"
            "#ifndef (Iso_Scale) #declare Iso_Scale = 1; #end\n"
            "#ifndef (Iso_Shadows) #declare Iso_Shadows = on; #end\n"
            "#ifndef (Iso_Scattering) #declare Iso_Scattering = 0; #end\n\n",
            s->name, s->level, s->source, g->size[0], g->size[1], g->size[2], h[0], h[1], h[2],
            s->voxels->is_optimized ? "// Values: " ISO_OPTIMIZED_VALUES ".\n" : "", s->name, object_name(s),
            object_name(s), ISO_POVRAY_UNITS_ACROSS, s->options->intervals);
}

static void write_placement(FILE *f, const iso_povray_scene *s)
{
    const iso_geometry *g = s->geometry;
    iso_mat3 m = iso_mat3_scale(g->index_to_world, s->units_per_mm);
    iso_vec3 o = iso_scale(iso_sub(g->origin_mm, s->center_mm), s->units_per_mm);
    if (s->unit->name[0])
        fprintf(f, "// Unit of the data: %s, %.9g mm: Iso_Units_Per_mm * %.9g units.\n", s->unit->name, s->unit->mm,
                s->unit->mm);
    fprintf(f, "#declare Iso_Units_Per_mm = %.17g;\n", s->units_per_mm);
    static const double zero[3] = {0};
    const double *low = s->options->box ? s->options->box[0] : zero,
                 *high = s->options->box ? s->options->box[1] : g->box_index;
    fprintf(f, "#declare Iso_Box_Low = <%.17g, %.17g, %.17g>; // in voxels\n", low[0], low[1], low[2]);
    fprintf(f, "#declare Iso_Box = <%.17g, %.17g, %.17g>;\n", high[0], high[1], high[2]);
    fprintf(f, "#declare Iso_To_World = transform { matrix <\n");
    for (int c = 0; c < 3; ++c)
        fprintf(f, "    %.17g, %.17g, %.17g,\n", m.m[0][c], m.m[1][c], m.m[2][c]);
    fprintf(f, "    %.17g, %.17g, %.17g> }\n\n", o.x, o.y, o.z);
}

/* Keeps the density's values below 1: from 1 on patterns repeat. */
static void write_scale(FILE *f, const iso_povray_scene *s)
{
    const double above = 2 * iso_extinction_scale_of(ISO_EXTINCTION_SCALE_LAST);
    fprintf(f, "// Factor of the extinction: 2 to the power of a byte per voxel.\n");
    write_lookup(f, s, "Iso_Stored_Scale", "scale");
    fprintf(f,
            "#declare Iso_Scale_At = function (x, y, z) { pow(2, Iso_Stored_Scale(x, y, z) * %.17g - %.17g) }\n"
            "#declare Iso_Extinction_Scale = density { function { Iso_Scale_At(x, y, z) / %.17g }\n"
            "    color_map { [0 rgb 0] [1 rgb %.17g] } }\n\n",
            255.0 / ISO_EXTINCTION_SCALE_PER_OCTAVE, -iso_extinction_scale_log2(0), above, above);
}

static void write_label_names(FILE *f, const iso_povray_scene *s)
{
    const json_t *segments = s->voxels->segments;
    fprintf(f, "// A label map: looked up without interpolation, since values between two labels have no meaning.\n");
    for (size_t i = 0; i < json_array_size(segments); ++i) {
        const json_t *segment = json_array_get(segments, i);
        const char *name = json_string_value(json_object_get(segment, "name"));
        fprintf(f, "//     %d: ", (int)json_integer_value(json_object_get(segment, "label")));
        iso_words_put_line(f, name ? name : ""); /* a line feed would end the comment and start a statement */
        fputc('\n', f);
    }
}

static void write_fields(FILE *f, const iso_povray_scene *s)
{
    const iso_tf_table *tf = s->tf;
    const double steps = s->direction.bits == 8 ? 255 : s->direction.bits == 16 ? 65535 : 4294967295.0;
    fprintf(f, "// ---- the data -------------------------------------------------------------\n"
               "// Each file has a rim of one voxel, against the wrap-around of `interpolate`.\n");
    if (s->voxels->labels)
        write_label_names(f, s);
    write_lookup_as(f, s, "Iso_Stored", "scalar", !s->voxels->labels);
    fprintf(f,
            "// in the units of the data\n"
            "#declare Iso_Value = function (x, y, z) { %.17g + %.17g * Iso_Stored(x, y, z) }\n"
            "// 0 at the first entry of the transfer function, 1 at the last\n"
            "#declare Iso_TF_Position = function (x, y, z) { min(1, max(0, %.17g + %.17g * Iso_Stored(x, y, z))) }\n\n",
            s->scalar.lo, s->scalar.hi - s->scalar.lo, (s->scalar.lo - tf->lo) / (tf->hi - tf->lo),
            (s->scalar.hi - s->scalar.lo) / (tf->hi - tf->lo));
    if (s->tf_2d) {
        fprintf(
            f,
            "// The second value of the transfer function, one byte per voxel: 0 in its first row, 1 in its last.\n");
        write_lookup(f, s, "Iso_Second", "second");
        fprintf(f, "\n");
    }
    if (s->extinction_scale)
        write_scale(f, s);
    fprintf(f, "// Shading directions in world axes; their length is their reliability.\n");
    static const char *const axis[3] = {"x", "y", "z"};
    for (int a = 0; a < 3; ++a) {
        char identifier[16], suffix[16];
        snprintf(identifier, sizeof identifier, "Iso_Stored_D%s", axis[a]);
        snprintf(suffix, sizeof suffix, "d%s", axis[a]);
        write_lookup(f, s, identifier, suffix);
    }
    /* lo and hi are chosen so that a whole sample represents 0. */
    const double span = s->direction.hi - s->direction.lo, zero = round(-s->direction.lo / span * steps);
    for (int a = 0; a < 3; ++a)
        fprintf(f, "#declare Iso_D%s = function (x, y, z) { (Iso_Stored_D%s(x, y, z) * %.17g - %.17g) * %.17g }\n",
                axis[a], axis[a], steps, zero, span / steps);
    fprintf(f, "\n");
}

/* Writes the clip planes in voxel coordinates; POV-Ray keeps the side opposite to the normal. */
void iso_povray_write_clips(FILE *f, const iso_povray_scene *s)
{
    for (size_t i = 0; i < s->view->clip_count; ++i) {
        double p[4];
        iso_clip_in_index(&s->view->clips[i], s->geometry, p);
        const double length = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        fprintf(f, "    plane { <%.17g, %.17g, %.17g>, %.17g }\n", -p[0] / length, -p[1] / length, -p[2] / length,
                -p[3] / length);
    }
}

/* Writes absorption and emission of one layer; prefix: of its declared names; weight: one more density, or "". */
static void write_layer_media(FILE *f, const iso_povray_scene *s, const char *prefix, const char *weight)
{
    const double color = s->peak_color, specular = iso_povray_specular_sum(s->view);
    fprintf(f,
            "    media { method 2 samples 1,1 jitter 0 intervals Iso_Intervals\n"
            "        absorption %sExtinction\n"
            "        density { %sTF_Extinction }%s }\n"
"#if (Iso_Scattering & (Iso_Emission > 0))\n"
            "    media { method 2 samples 1,1 jitter 0 intervals Iso_Intervals\n"
            "        scattering { 1, rgb Iso_Emission * %sExtinction * %.17g extinction 0 }\n"
            "        density { %sTF_Extinction } density { %sTF_Color }%s }\n"
            "#end\n"
            "#if (!Iso_Scattering & (Iso_Emission > 0))\n"
            "    media { method 2 samples 1,1 jitter 0 intervals Iso_Intervals\n"
            "        emission Iso_Emission * %sExtinction * %.17g * Iso_Diffuse_Most\n"
            "        density { %sTF_Extinction } density { %sTF_Color } density { %sDiffuse }%s }\n",
            prefix, prefix, weight, prefix, color, prefix, prefix, weight, prefix, color, prefix, prefix, prefix, weight);
    if (specular > 0)
        fprintf(f,
                "    media { method 2 samples 1,1 jitter 0 intervals Iso_Intervals\n"
                "        emission Iso_Emission * %sExtinction * %.17g * Iso_Specular_Most\n"
                "        density { %sTF_Extinction } density { %sTF_Color } density { %sSpecular }%s }\n",
                prefix, color, prefix, prefix, prefix, weight);
    fprintf(f, "#end\n");
}

static void write_media(FILE *f, const iso_povray_scene *s)
{
    fprintf(
        f,
        "// ---- the medium -----------------------------------------------------------\n"
        "// Several densities in one media multiply. method 2 with one sample per interval is exact to second order;\n"
        "// the default method 3 is not.\n"
        "#declare Iso_Interior = interior {\n");
    char weight[80];
    snprintf(weight, sizeof weight, "%s%s", s->roi ? " density { Iso_Around }" : "",
             s->extinction_scale ? " density { Iso_Extinction_Scale }" : "");
    write_layer_media(f, s, "Iso_", weight);
    if (s->roi)
        write_layer_media(f, s->roi, "Iso_Roi_", " density { Iso_Roi }");
    const bool clipped = s->view->clip_count > 0;
    fprintf(f, "}\n\n#declare Iso_Volume = %s\n",
            clipped ? "intersection { box { Iso_Box_Low, Iso_Box }" : "box { Iso_Box_Low, Iso_Box");
    iso_povray_write_clips(f, s);
    fprintf(f, "    pigment { rgbt 1 } finish { ambient 0 diffuse 0 } hollow\n"
               "    #if (!Iso_Shadows) no_shadow #end\n"
               "    interior { Iso_Interior } }\n\n"
               "// POV-Ray draws no medium inside a solid object: a box or sky sphere around the volume needs\n"
               "// \"hollow\". Iso_Around_Volume (Thing) is the object Thing with it.\n"
               "#macro Iso_Around_Volume (Thing) object { Thing hollow } #end\n");
}

/* Writes the media of a layer. */
static void write_layer(FILE *f, const iso_povray_scene *s)
{
    write_fields(f, s);
    if (!s->options->isosurface)
        iso_povray_write_transfer_function(f, s);
    fprintf(f, "// ---- shading: two-sided, Blinn-Phong ---------------------------------------\n");
    iso_povray_write_diffuse(f, s);
    if (iso_povray_specular_sum(s->view) > 0)
        iso_povray_write_specular(f, s);
}

/* Writes the weights of the two layers: scene/roi.h. */
static void write_weights(FILE *f, const iso_roi *roi)
{
    const double *lo = roi->lo, *hi = roi->hi;
    fprintf(
        f,
        "// ---- the region of interest ------------------------------------------------\n"
        "// Iso_Roi is 1 in the box <%.9g, %.9g, %.9g>, <%.9g, %.9g, %.9g> and falls to 0 over the band around it.\n"
        "#declare Iso_Roi_Distance = function (x, y, z) {\n"
        "    max(%.17g - x, x - %.17g, %.17g - y, y - %.17g, %.17g - z, z - %.17g) }\n"
        "#declare Iso_Roi_Part = function (x, y, z) { 1 - min(1, max(0, Iso_Roi_Distance(x, y, z) / %.17g)) }\n"
        "#declare Iso_Roi_Weight = function (x, y, z) { pow(Iso_Roi_Part(x, y, z), 2) * (3 - 2 * Iso_Roi_Part(x, y, z)) }\n"
        "#declare Iso_Roi = density { function { Iso_Roi_Weight(x, y, z) } color_map { [0 rgb 0] [1 rgb 1] } }\n"
        "#declare Iso_Around = density { function { 1 - Iso_Roi_Weight(x, y, z) } color_map { [0 rgb 0] [1 rgb 1] } }\n\n",
        lo[0], lo[1], lo[2], hi[0], hi[1], hi[2], lo[0], hi[0], lo[1], hi[1], lo[2], hi[2], fmax(roi->band, 1e-9));
}

static bool ends_there(const char *at)
{
    return !isalnum((unsigned char)*at) && *at != '_';
}

/* Writes the text with its declared names renamed to those of the finer layer, except user settings and shared
 * names. */
void iso_povray_write_renamed(FILE *f, const char *text)
{
    static const char *const shared[] = {
        "Iso_Emission",     "Iso_Intervals",    "Iso_Scale",        "Iso_Light",
        "Iso_Units_Per_mm", "Iso_Diffuse_Most", "Iso_Specular_Most"}; /* and names that begin with these */
    static const char viewer[] = "Iso_Viewer"; /* only the point; functions of it belong to the layer */
    static const char from[] = "Iso_", to[] = "Iso_Roi_";
    for (const char *at; (at = strstr(text, from)); text = at + sizeof from - 1) {
        bool keep = strncmp(at, viewer, strlen(viewer)) == 0 && ends_there(at + strlen(viewer));
        for (size_t i = 0; i < sizeof shared / sizeof *shared; ++i)
            keep = keep || strncmp(at, shared[i], strlen(shared[i])) == 0;
        fprintf(f, "%.*s%s", (int)(at - text), text, keep ? from : to);
    }
    fputs(text, f);
}

/* Writes the finer layer. If memory runs out, nothing is written, and POV-Ray reports undeclared names. */
static void write_roi_layer(FILE *f, const iso_povray_scene *roi)
{
    FREED char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (!memory)
        return;
    write_layer(memory, roi);
    if (fclose(memory) == 0)
        iso_povray_write_renamed(f, text);
}

void iso_povray_write_include(FILE *f, const iso_povray_scene *s)
{
    write_header(f, s);
    write_placement(f, s);
    iso_povray_write_lights(f, s->view);
    write_layer(f, s);
    if (s->roi) {
        write_weights(f, s->view->roi);
        write_roi_layer(f, s->roi);
    }
    if (s->options->isosurface)
        iso_povray_write_surface(f, s);
    else
        write_media(f, s);
    fprintf(f, "\n#version Iso_Version_Before;\n");
}

static void write_vector(FILE *f, const char *name, iso_vec3 v)
{
    fprintf(f, "    %s <%.17g, %.17g, %.17g>\n", name, v.x, v.y, v.z);
}

static void write_camera(FILE *f, const iso_povray_scene *s)
{
    const iso_camera *c = &s->view->camera;
    const double scale = 2 * c->half_height * (c->orthographic ? s->units_per_mm : 1);
    const double aspect = (double)s->view->width / (double)s->view->height;
    fprintf(f, "// right-handed like the data, by `right` and `up`\ncamera {\n    %s\n",
            c->orthographic ? "orthographic" : "perspective");
    write_vector(f, "location", iso_scale(iso_sub(c->position, s->center_mm), s->units_per_mm));
    write_vector(f, "direction", c->forward);
    write_vector(f, "right", iso_scale(c->right, scale * aspect));
    write_vector(f, "up", iso_scale(c->up, scale));
    fprintf(f, "}\n\n");
}

/* Writes K planes across the view. The medium is sampled per piece of a ray, so they give K + 1 times the samples. */
static void write_planes(FILE *f, const iso_povray_scene *s)
{
    const iso_camera *c = &s->view->camera;
    const iso_geometry *g = s->geometry;
    const iso_mat3 m = iso_mat3_scale(g->index_to_world, 0.5 * s->units_per_mm);
    double radius = 0; /* half the extent of the box along the view */
    for (int a = 0; a < 3; ++a)
        radius += fabs(iso_dot(iso_column(m, a), c->forward)) * g->box_index[a];
    fprintf(f,
            "// Transparent planes cut the rays into pieces, each with its own Iso_Intervals.\n"
            "#ifndef (Iso_Planes) #declare Iso_Planes = %zu; #end\n"
            "#declare Iso_Plane = 1;\n"
            "#while (Iso_Plane <= Iso_Planes)\n"
            "    plane { <%.17g, %.17g, %.17g>, %.17g * (2 * Iso_Plane / (Iso_Planes + 1) - 1)\n"
            "        hollow pigment { rgbt 1 } finish { ambient 0 diffuse 0 } }\n"
            "    #declare Iso_Plane = Iso_Plane + 1;\n"
            "#end\n",
            s->options->planes, c->forward.x, c->forward.y, c->forward.z, radius);
}

void iso_povray_write_scene(FILE *f, const iso_povray_scene *s)
{
    const double *b = s->view->background;
    fprintf(f,
            "// %s.pov - rendered by \"povray %s.ini\" in this folder.\n"
            "//\n"
            "// Declare=Iso_Pass=1 renders the emission alone over black, times %.17g so that it is never clipped;\n"
            "// Declare=Iso_Pass=2 renders the transmittance over white: 1 - alpha.\n"
            "#version 3.7;\n"
            "#ifndef (Iso_Pass) #declare Iso_Pass = 0; #end\n"
            "#if (Iso_Pass = 1) #declare Iso_Emission = %.17g; #end\n"
            "#if (Iso_Pass = 2) #declare Iso_Emission = 0; #end\n\n"
            "// adc_bailout 0: also render the parts hidden by dense ones.\n"
            "global_settings { assumed_gamma 1.0 max_trace_level 256 adc_bailout 0 }\n\n",
            s->name, s->name, 1 / s->peak, 1 / s->peak);
    fprintf(f,
            "#switch (Iso_Pass)\n"
            "    #case (0) background { rgb <%.9g, %.9g, %.9g> } #break\n"
            "    #case (1) background { rgb 0 } #break\n"
            "    #case (2) background { rgb 1 } #break\n"
            "#end\n\n",
            b[0], b[1], b[2]);
    write_camera(f, s);
    fprintf(f,
            "#include \"%s.inc\"\n"
            "object { %s transform { Iso_To_World } }\n\n",
            s->name, object_name(s));
    if (!s->options->isosurface)
        write_planes(f, s);
}

static void write_ini_of_samples(FILE *f, const iso_povray_scene *s)
{
    const iso_povray_options *o = s->options;
    const double chord = 2 * iso_geometry_box_radius_mm(s->geometry) /
                         iso_geometry_min_spacing_mm(iso_view_step_geometry(s->view, s->geometry));
    fprintf(
        f,
        "; A sample every %.3g voxels or less: Iso_Intervals, at most 255, in each piece of a ray, and Iso_Planes planes\n"
        "; between the pieces. Time grows with their product, the error falls with its square. For a quick look:\n"
        ";     povray %s.ini Declare=Iso_Intervals=64 Declare=Iso_Planes=0\n"
        "; The exported values; edit them here:\n"
        ";Declare=Iso_Intervals=%zu\n"
        ";Declare=Iso_Planes=%zu\n",
        chord / (double)(o->intervals * (o->planes + 1)), s->name, o->intervals, o->planes);
}

void iso_povray_write_ini(FILE *f, const iso_povray_scene *s)
{
    fprintf(
        f,
        "; povray %s.ini\n"
        "Input_File_Name=%s.pov\n"
        "Output_File_Name=%s.png\n"
        "; 16 bits per channel, sRGB: the picture of `isoshade render --with povray` with the same samples, to half a\n"
        "; step of the 16 bits. Values above 1 are clipped.\n"
        "Output_File_Type=N\n"
        "Bits_Per_Color=16\n"
        "File_Gamma=sRGB\n"
        "Dither=Off\n"
        "Width=%zu\n"
        "Height=%zu\n",
        s->name, s->name, s->name, s->view->width, s->view->height);
    if (!s->options->isosurface)
        write_ini_of_samples(f, s);
    fprintf(f, "; Antialias=On multiplies the time; it is cheaper to render a larger picture and to shrink it.\n"
               "Antialias=Off\n"
               "Display=Off\n"
               "Pause_When_Done=Off\n");
}
