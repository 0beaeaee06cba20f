/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "povray/scene_text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "encode/decode_double.h"
#include "scene/roi.h"

/* POV-Ray's colours are floats: entries this close to a line, as a part of the peak, make no difference. */
static const double color_map_tolerance = 6e-8;

static double specular_sum(const iso_view *view)
{
    double sum = 0;
    for (size_t i = 0; i < view->light_count; ++i)
        sum += view->lights[i].intensity * view->shading.specular;
    return sum;
}

static double peak_color(const iso_tf_table *tf)
{
    double color = 1;
    for (size_t i = 0; i < tf->count; ++i) {
        const float *e = tf->entries + 4 * i;
        color = fmax(color, fmax((double)e[0], fmax((double)e[1], (double)e[2])));
    }
    return color;
}

/* The weights of a ray's samples sum to at most 1, and diffuse light to at most 1. */
double iso_povray_peak(const iso_view *view) { return peak_color(&view->tf) * (1 + specular_sum(view)); }

/* Density values above 1 wrap in POV-Ray, and colours above 1 are clipped: both are divided by a peak. */
void iso_povray_measure_peaks(iso_povray_scene *s)
{
    const iso_tf_table *tf = s->tf;
    double extinction = 0;
    for (size_t i = 0; i < tf->count; ++i)
        extinction = fmax(extinction, (double)tf->entries[4 * i + 3]);
    s->peak_extinction = extinction > 0 ? extinction : 1;
    s->peak_color = peak_color(tf);
    s->peak = s->peak_color * (1 + specular_sum(s->view));
}

/* "function { ... }" of one DF3 file in voxel coordinates, v in [0, 1]. */
static void write_lookup(FILE *f, const iso_povray_scene *s, const char *identifier, const char *suffix)
{
    const size_t *n = s->voxels->geometry.size;
    const double scale = s->lattice_scale, *offset = s->lattice_offset;
    fprintf(f, "#declare %s = function { pattern { density_file df3 \"%s_%s.df3\" interpolate 1\n"
               "    scale <%.17g, %.17g, %.17g> translate <%.17g, %.17g, %.17g> } }\n", identifier, s->name, suffix,
            (double)(n[0] + 2) / scale, (double)(n[1] + 2) / scale, (double)(n[2] + 2) / scale, (offset[0] - 0.5) / scale,
            (offset[1] - 0.5) / scale, (offset[2] - 0.5) / scale);
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
            "//\n"
            "//     #include \"%s.inc\"\n"
            "//     object { %s transform { Iso_To_World } }\n"
            "//\n"
            "// %s stands in voxel coordinates: voxel (i, j, k) covers [i, i+1] x [j, j+1] x [k, k+1].\n"
            "// Iso_To_World turns and stretches it as the data say, and makes it about %g units across. Scale it as you\n"
            "// like, but not far below 100: POV-Ray works to 0.001 units. Tell Iso_Scale, or it becomes denser or thinner.\n"
            "//\n"
            "// The colour is emitted and already shaded, from directions computed beforehand, so the scene's light_sources\n"
            "// do not touch it; its lights are Iso_Diffuse and Iso_Specular below.\n"
            "//\n"
            "// Declare before the #include, or on the command line (Declare=Iso_Intervals=100):\n"
            "//     Iso_Intervals   samples along a ray, at most 255; fewer is faster\n"
            "//     Iso_Emission    brightness, 1 is as the transfer function says; 0 leaves only the absorption\n"
            "//     Iso_Scale       what the placed volume is scaled by\n"
            "#version 3.7;\n\n"
            "#ifndef (Iso_Intervals) #declare Iso_Intervals = %zu; #end\n"
            "#ifndef (Iso_Emission) #declare Iso_Emission = 1; #end\n"
            "#ifndef (Iso_Scale) #declare Iso_Scale = 1; #end\n\n",
            s->name, s->level, s->source, g->size[0], g->size[1], g->size[2], h[0], h[1], h[2], s->name, object_name(s),
            object_name(s), ISO_POVRAY_UNITS_ACROSS, s->options->intervals);
}

static void write_placement(FILE *f, const iso_povray_scene *s)
{
    const iso_geometry *g = s->geometry;
    iso_mat3 m = iso_mat3_scale(g->index_to_world, s->units_per_mm);
    iso_vec3 o = iso_scale(iso_sub(g->origin_mm, s->center_mm), s->units_per_mm);
    fprintf(f, "#declare Iso_Units_Per_mm = %.17g;\n", s->units_per_mm);
    static const double zero[3] = {0};
    const double *low = s->options->box ? s->options->box[0] : zero, *high = s->options->box ? s->options->box[1] : g->box_index;
    fprintf(f, "#declare Iso_Box_Low = <%.17g, %.17g, %.17g>; // in voxels\n", low[0], low[1], low[2]);
    fprintf(f, "#declare Iso_Box = <%.17g, %.17g, %.17g>;\n", high[0], high[1], high[2]);
    fprintf(f, "#declare Iso_To_World = transform { matrix <\n");
    for (int c = 0; c < 3; ++c)
        fprintf(f, "    %.17g, %.17g, %.17g,\n", m.m[0][c], m.m[1][c], m.m[2][c]);
    fprintf(f, "    %.17g, %.17g, %.17g> }\n\n", o.x, o.y, o.z);
}

static void write_fields(FILE *f, const iso_povray_scene *s)
{
    const iso_tf_table *tf = s->tf;
    const double steps = s->direction.bits == 8 ? 255 : s->direction.bits == 16 ? 65535 : 4294967295.0;
    fprintf(f, "// ---- the data -------------------------------------------------------------\n"
               "// Each file has a rim of one voxel, against the wrap-around of `interpolate`.\n");
    write_lookup(f, s, "Iso_Stored", "scalar");
    fprintf(f, "// in the units of the data\n"
               "#declare Iso_Value = function (x, y, z) { %.17g + %.17g * Iso_Stored(x, y, z) }\n"
               "// 0 at the first entry of the transfer function, 1 at the last\n"
               "#declare Iso_TF_Position = function (x, y, z) { min(1, max(0, %.17g + %.17g * Iso_Stored(x, y, z))) }\n\n",
            s->scalar.lo, s->scalar.hi - s->scalar.lo, (s->scalar.lo - tf->lo) / (tf->hi - tf->lo),
            (s->scalar.hi - s->scalar.lo) / (tf->hi - tf->lo));
    if (s->tf_2d) {
        fprintf(f, "// The second value of the transfer function, a byte a voxel: 0 in its first row, 1 in its last.\n");
        write_lookup(f, s, "Iso_Class", "class");
        fprintf(f, "\n");
    }
    fprintf(f, "// Shading directions in world axes; their length says how sure they are.\n");
    static const char *const axis[3] = {"x", "y", "z"};
    for (int a = 0; a < 3; ++a) {
        char identifier[16], suffix[16];
        snprintf(identifier, sizeof identifier, "Iso_Stored_D%s", axis[a]);
        snprintf(suffix, sizeof suffix, "d%s", axis[a]);
        write_lookup(f, s, identifier, suffix);
    }
    /* lo and hi are chosen so that a whole sample stands for 0. */
    const double span = s->direction.hi - s->direction.lo, zero = round(-s->direction.lo / span * steps);
    for (int a = 0; a < 3; ++a)
        fprintf(f, "#declare Iso_D%s = function (x, y, z) { (Iso_Stored_D%s(x, y, z) * %.17g - %.17g) * %.17g }\n", axis[a],
                axis[a], steps, zero, span / steps);
    fprintf(f, "\n");
}

/* Marks the entries that a color_map needs: those between two kept ones lie on the line between them, within
 * `tolerance`. A cone of allowed slopes per channel narrows until an entry falls out of it. Returns how many. */
static size_t mark_bends(const iso_tf_table *tf, const int channels[2], double tolerance, bool *keep)
{
    size_t kept = 1, from = 0;
    double lo[4], hi[4];
    keep[0] = true;
    for (size_t i = 1; i < tf->count; ++i) {
        bool inside = i > from + 1;
        for (int c = channels[0]; c < channels[1]; ++c) {
            const double slope = ((double)tf->entries[4 * i + c] - (double)tf->entries[4 * from + c]) / (double)(i - from);
            inside = inside && slope >= lo[c] && slope <= hi[c];
        }
        if (i > from + 1 && !inside) {
            from = i - 1;
            keep[from] = true;
            ++kept;
        }
        for (int c = channels[0]; c < channels[1]; ++c) {
            const double rise = (double)tf->entries[4 * i + c] - (double)tf->entries[4 * from + c], run = (double)(i - from);
            lo[c] = fmax(i == from + 1 ? -INFINITY : lo[c], (rise - tolerance) / run);
            hi[c] = fmin(i == from + 1 ? INFINITY : hi[c], (rise + tolerance) / run);
        }
        keep[i] = i + 1 == tf->count;
    }
    return kept + 1;
}

/* What a density map is made of: the TF's channels [first, end), divided by peak. */
typedef struct map_source {
    int channels[2];
    double peak;
} map_source;

static map_source extinction_source(const iso_povray_scene *s) { return (map_source){{3, 4}, s->peak_extinction}; }
static map_source color_source(const iso_povray_scene *s) { return (map_source){{0, 3}, s->peak_color}; }

/* Positions in a color_map are floats: tables with finer steps than this travel as DF3. */
enum { max_color_map_table = 1024 };

/* NULL when the table does not fit a color_map; else which entries it needs, to be freed. */
static bool *color_map_entries(const iso_povray_scene *s, map_source source)
{
    const iso_tf_table *tf = s->tf;
    bool *keep = !s->tf_2d && tf->count <= max_color_map_table ? calloc(tf->count, sizeof *keep) : NULL;
    if (keep && mark_bends(tf, source.channels, color_map_tolerance * source.peak, keep) > ISO_POVRAY_COLOR_MAP_ENTRIES) {
        free(keep);
        keep = NULL;
    }
    return keep;
}

bool iso_povray_needs_tables(const iso_povray_scene *s, bool color)
{
    bool *keep = color_map_entries(s, color ? color_source(s) : extinction_source(s));
    free(keep);
    return !keep;
}

static void write_color_map(FILE *f, const char *identifier, const iso_tf_table *tf, map_source source, const bool *keep)
{
    fprintf(f, "#declare %s = density { function { Iso_TF_Position(x, y, z) } color_map {\n", identifier);
    for (size_t i = 0; i < tf->count; ++i) {
        const float *e = tf->entries + 4 * i;
        if (!keep[i])
            continue;
        fprintf(f, "    [%.9g rgb ", (double)i / (double)(tf->count - 1));
        if (source.channels[0] == 0)
            fprintf(f, "<%.9g, %.9g, %.9g>]\n", (double)e[0] / source.peak, (double)e[1] / source.peak,
                    (double)e[2] / source.peak);
        else
            fprintf(f, "%.9g]\n", (double)e[3] / source.peak);
    }
    fprintf(f, "} }\n");
}

/* DF3 tables of one row, or of a row a class, linear between entries as a
 * color_map is. `average` of three densities is a third of their sum. */
static void write_table_lookup(FILE *f, const iso_povray_scene *s, bool color)
{
    const size_t count = s->tf->count;
    const double scale = (double)(count - 1) / (double)count;
    char row[64] = "0";
    if (s->tf_2d)
        snprintf(row, sizeof row, "Iso_Class(x, y, z) * %.17g", (ISO_TF_2D_ROWS - 1.0) / ISO_TF_2D_ROWS);
    static const char *const channel[4] = {"red", "green", "blue", "extinction"};
    static const char *const unit[4] = {"<3, 0, 0>", "<0, 3, 0>", "<0, 0, 3>", "1"};
    for (int c = color ? 0 : 3; c < (color ? 3 : 4); ++c) {
        fprintf(f, "#declare Iso_Table_%s = function { pattern { density_file df3 \"%s_tf_%s.df3\" interpolate 1 } }\n",
                channel[c], s->name, channel[c]);
        fprintf(f, "#declare %s%s = density { function { Iso_Table_%s(Iso_TF_Position(x, y, z) * %.17g, %s, 0) }\n"
                   "    color_map { [0 rgb 0] [1 rgb %s] } }\n", color ? "Iso_TF_" : "Iso_TF_Extinction",
                color ? channel[c] : "", channel[c], scale, row, unit[c]);
    }
    if (color)
        fprintf(f, "#declare Iso_TF_Color = density { average density_map {\n"
                   "    [1 Iso_TF_red] [1 Iso_TF_green] [1 Iso_TF_blue] } }\n");
}

static void write_map(FILE *f, const iso_povray_scene *s, bool color)
{
    const map_source source = color ? color_source(s) : extinction_source(s);
    bool *keep = color_map_entries(s, source);
    if (keep)
        write_color_map(f, color ? "Iso_TF_Color" : "Iso_TF_Extinction", s->tf, source, keep);
    else
        write_table_lookup(f, s, color);
    free(keep);
}

static void write_transfer_function(FILE *f, const iso_povray_scene *s)
{
    const iso_tf_table *tf = s->tf;
    fprintf(f, "// ---- the transfer function ------------------------------------------------\n"
               "// %zu entries from %.9g to %.9g; colours are linear light (assumed_gamma 1). Entries on a straight line are\n"
               "// left out; what needs more than the 256 of a color_map is a table in a DF3 file.\n"
               "#declare Iso_Extinction = %.17g / Iso_Scale; // a unit, where Iso_TF_Extinction is 1\n",
            tf->count, tf->lo, tf->hi, s->peak_extinction / s->units_per_mm);
    write_map(f, s, false);
    write_map(f, s, true);
    fprintf(f, "\n");
}

/* "select(Iso_Opaque(x, y, z), 0, " when part of the TF is transparent: what follows is not evaluated there. */
static const char *lazily(const iso_povray_scene *s, const char *select)
{
    size_t zeros = 0;
    for (size_t i = 0; i + 1 < s->tf->count; ++i)
        zeros += s->tf->entries[4 * i + 3] == 0 && s->tf->entries[4 * i + 7] == 0;
    return zeros > 0 ? select : "";
}

/* Shading is most of the work. Iso_Opaque is negative inside the ranges of the TF without extinction. */
static void write_opaque(FILE *f, const iso_povray_scene *s)
{
    enum { most_ranges = 8 }; /* leaving some out is slower, not wrong */
    const iso_tf_table *tf = s->tf;
    const double last = (double)(tf->count - 1);
    int ranges = 0;
    if (!*lazily(s, "yes"))
        return;
    fprintf(f, "// Negative where the transfer function is transparent: no shading is computed there.\n"
               "#declare Iso_Opaque_At = function (p) { min(1");
    for (size_t i = 0; i < tf->count && ranges < most_ranges; ++i) {
        size_t end = i;
        while (end < tf->count && tf->entries[4 * end + 3] == 0)
            ++end;
        if (end > i + 1) {
            fprintf(f, ", max(%.9g - p, p - %.9g)", i > 0 ? (double)i / last : -1, end < tf->count ? (double)(end - 1) / last : 2);
            ++ranges;
        }
        i = end > i ? end - 1 : i;
    }
    fprintf(f, ") }\n#declare Iso_Opaque = function (x, y, z) { Iso_Opaque_At(Iso_TF_Position(x, y, z)) }\n\n");
}

/* ka + kd sum of intensity |n.l|, with n = d / sqrt(|d|^2 + eps^2); at most 1. */
static void write_diffuse(FILE *f, const iso_povray_scene *s)
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
    fprintf(f, "#declare Iso_Diffuse = density {\n"
               "    function { %smin(1, Iso_Diffuse_Of(Iso_Dx(x, y, z), Iso_Dy(x, y, z), Iso_Dz(x, y, z)))%s }\n"
               "    color_map { [0 rgb 0] [1 rgb 1] } }\n\n", lazily(s, "select(Iso_Opaque(x, y, z), 0, "), lazily(s, ")"));
}

/* The unit vector to the viewer at a point in voxel coordinates, as a function's three arguments. */
static void write_to_viewer(FILE *f, const iso_povray_scene *s)
{
    const iso_camera *camera = &s->view->camera;
    if (camera->orthographic) {
        fprintf(f, "#declare Iso_Viewer_X = function (x, y, z) { %.17g }\n"
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
        fprintf(f, "#declare Iso_Viewer_%s = function (x, y, z) { %.17g - x * %.17g - y * %.17g - z * %.17g } // mm\n", axis[a],
                offset[a], m[0], m[1], m[2]);
    }
}

/* sum of intensity |n.h|^p over the sum of the intensities, h = normalise(l + v): n.h = (d.l + d.v) / (|d| sqrt(2 + 2 l.v)). */
static void write_specular(FILE *f, const iso_povray_scene *s)
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
        fprintf(f, "\n    + %.17g * pow(min(1, abs(dx * (vx + %.17g) + dy * (vy + %.17g) + dz * (vz + %.17g))"
                   "\n        / (n * sqrt(max(1e-24, 2 + 2 * (vx * %.17g + vy * %.17g + vz * %.17g))))), %.17g)",
                v->lights[i].intensity / intensities, l.x, l.y, l.z, l.x, l.y, l.z, v->shading.power);
    }
    fprintf(f, " }\n#declare Iso_Specular_Of = function (dx, dy, dz, vx, vy, vz, v) {\n"
               "    Iso_Specular_Unit(dx, dy, dz, vx / v, vy / v, vz / v, sqrt(dx*dx + dy*dy + dz*dz + %.17g)) }\n"
               "#declare Iso_Specular_At = function (dx, dy, dz, vx, vy, vz) {\n"
               "    Iso_Specular_Of(dx, dy, dz, vx, vy, vz, sqrt(max(1e-24, vx*vx + vy*vy + vz*vz))) }\n",
            ISO_DIRECTION_EPS * ISO_DIRECTION_EPS);
    if (s->options->isosurface)
        return;
    fprintf(f, "#declare Iso_Specular = density {\n"
               "    function { %smin(1, Iso_Specular_At(Iso_Dx(x, y, z), Iso_Dy(x, y, z), Iso_Dz(x, y, z),\n"
               "        Iso_Viewer_X(x, y, z), Iso_Viewer_Y(x, y, z), Iso_Viewer_Z(x, y, z)))%s }\n"
               "    color_map { [0 rgb 0] [1 rgb 1] } }\n\n",
            lazily(s, "select(Iso_Opaque(x, y, z), 0, "), lazily(s, ")"));
}

/* The planes that a scene clips by, in voxel coordinates; POV-Ray's planes keep the side that their normals leave. */
static void write_clips(FILE *f, const iso_povray_scene *s)
{
    for (size_t i = 0; i < s->view->clip_count; ++i) {
        double p[4];
        iso_clip_in_index(&s->view->clips[i], s->geometry, p);
        const double length = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        fprintf(f, "    plane { <%.17g, %.17g, %.17g>, %.17g }\n", -p[0] / length, -p[1] / length, -p[2] / length,
                -p[3] / length);
    }
}

/* Absorption and emission of one layer; prefix: of its declared names; weight: one more density, or "". */
static void write_layer_media(FILE *f, const iso_povray_scene *s, const char *prefix, const char *weight)
{
    const double color = s->peak_color, specular = specular_sum(s->view);
    fprintf(f, "    media { method 2 samples 1,1 jitter 0 intervals Iso_Intervals\n"
               "        absorption %sExtinction\n"
               "        density { %sTF_Extinction }%s }\n"
               "#if (Iso_Emission > 0)\n"
               "    media { method 2 samples 1,1 jitter 0 intervals Iso_Intervals\n"
               "        emission Iso_Emission * %sExtinction * %.17g\n"
               "        density { %sTF_Extinction } density { %sTF_Color } density { %sDiffuse }%s }\n", prefix, prefix, weight,
            prefix, color, prefix, prefix, prefix, weight);
    if (specular > 0)
        fprintf(f, "    media { method 2 samples 1,1 jitter 0 intervals Iso_Intervals\n"
                   "        emission Iso_Emission * %sExtinction * %.17g\n"
                   "        density { %sTF_Extinction } density { %sTF_Color } density { %sSpecular }%s }\n", prefix,
                color * specular, prefix, prefix, prefix, weight);
    fprintf(f, "#end\n");
}

static void write_media(FILE *f, const iso_povray_scene *s)
{
    fprintf(f, "// ---- the medium -----------------------------------------------------------\n"
               "// Several densities in one media multiply. method 2 with one sample an interval is exact to second order;\n"
               "// the default method 3 is not.\n"
               "#declare Iso_Interior = interior {\n");
    write_layer_media(f, s, "Iso_", s->inner ? " density { Iso_Outside }" : "");
    if (s->inner)
        write_layer_media(f, s->inner, "Iso_Fine_", " density { Iso_Inside }");
    const bool clipped = s->view->clip_count > 0;
    fprintf(f, "}\n\n#declare Iso_Volume = %s\n", clipped ? "intersection { box { Iso_Box_Low, Iso_Box }" : "box { Iso_Box_Low, Iso_Box");
    write_clips(f, s);
    fprintf(f, "    pigment { rgbt 1 } finish { ambient 0 diffuse 0 } hollow\n"
               "    interior { Iso_Interior } }\n");
}

/* Opaque, in the TF's colour at the value times the shade of the stored
 * direction: POV-Ray's own normals are gradients of the trilinear field, which
 * jump from cell to cell. */
static void write_surface(FILE *f, const iso_povray_scene *s)
{
    const double specular = specular_sum(s->view), peak = 1 + specular;
    const bool clipped = s->view->clip_count > 0;
    double rgbs[4];
    iso_tf_lookup(&s->view->tf, s->options->iso, rgbs);
    fprintf(f, "// ---- the surface ----------------------------------------------------------\n"
               "// The first point of a ray where the value is at least Iso_Surface_Value. max_gradient bounds the slope of\n"
               "// the field: a smaller one is faster and loses pixels.\n"
               "#declare Iso_Surface_Value = %.17g;\n"
               "#declare Iso_Surface_Shade = function (x, y, z) {\n"
               "    (Iso_Diffuse_Of(Iso_Dx(x, y, z), Iso_Dy(x, y, z), Iso_Dz(x, y, z))", s->options->iso);
    if (specular > 0)
        fprintf(f, "\n    + %.17g * Iso_Specular_At(Iso_Dx(x, y, z), Iso_Dy(x, y, z), Iso_Dz(x, y, z),\n"
                   "        Iso_Viewer_X(x, y, z), Iso_Viewer_Y(x, y, z), Iso_Viewer_Z(x, y, z))", specular);
    fprintf(f, ") * %.17g }\n"
               "#declare Iso_Surface = %sisosurface {\n"
               "    function { (Iso_Surface_Value - %.17g) * %.17g - Iso_Stored(x, y, z) }\n"
               "    contained_by { box { Iso_Box_Low, Iso_Box } }\n"
               "    threshold 0 accuracy 1e-6 max_gradient %.9g%s\n", 1 / peak, clipped ? "intersection { " : "", s->scalar.lo,
            1 / (s->scalar.hi - s->scalar.lo), s->max_gradient, clipped ? " all_intersections }" : "");
    write_clips(f, s);
    fprintf(f, "    pigment { function { min(1, Iso_Surface_Shade(x, y, z)) }\n"
               "        color_map { [0 rgb 0] [1 rgb <%.9g, %.9g, %.9g> * Iso_Emission * %.17g] } }\n"
               "    finish { emission 1 ambient 0 diffuse 0 } }\n", rgbs[0], rgbs[1], rgbs[2], peak);
}

/* What the media of a layer are made of. */
static void write_layer(FILE *f, const iso_povray_scene *s)
{
    write_fields(f, s);
    if (!s->options->isosurface)
        write_transfer_function(f, s);
    fprintf(f, "// ---- shading: two-sided, Blinn-Phong ---------------------------------------\n");
    if (!s->options->isosurface)
        write_opaque(f, s);
    write_diffuse(f, s);
    if (specular_sum(s->view) > 0)
        write_specular(f, s);
}

/* The weights of the two layers: scene/roi.h. */
static void write_weights(FILE *f, const iso_roi *roi)
{
    const double *lo = roi->lo, *hi = roi->hi;
    fprintf(f, "// ---- the region of interest ------------------------------------------------\n"
               "// Iso_Inside is 1 in the box <%.9g, %.9g, %.9g>, <%.9g, %.9g, %.9g> and falls to 0 over the band around it.\n"
               "#declare Iso_Roi_Outside = function (x, y, z) {\n"
               "    max(%.17g - x, x - %.17g, %.17g - y, y - %.17g, %.17g - z, z - %.17g) }\n"
               "#declare Iso_Roi_Part = function (x, y, z) { 1 - min(1, max(0, Iso_Roi_Outside(x, y, z) / %.17g)) }\n"
               "#declare Iso_Roi_Weight = function (x, y, z) { pow(Iso_Roi_Part(x, y, z), 2) * (3 - 2 * Iso_Roi_Part(x, y, z)) }\n"
               "#declare Iso_Inside = density { function { Iso_Roi_Weight(x, y, z) } color_map { [0 rgb 0] [1 rgb 1] } }\n"
               "#declare Iso_Outside = density { function { 1 - Iso_Roi_Weight(x, y, z) } color_map { [0 rgb 0] [1 rgb 1] } }\n\n",
            lo[0], lo[1], lo[2], hi[0], hi[1], hi[2], lo[0], hi[0], lo[1], hi[1], lo[2], hi[2], fmax(roi->band, 1e-9));
}

/* The text with its declared names made those of the finer layer; what the user sets is shared. */
static void write_renamed(FILE *f, const char *text)
{
    static const char *const shared[] = {"Iso_Emission", "Iso_Intervals", "Iso_Scale"};
    static const char from[] = "Iso_", to[] = "Iso_Fine_";
    for (const char *at; (at = strstr(text, from)); text = at + sizeof from - 1) {
        bool keep = false;
        for (size_t i = 0; i < sizeof shared / sizeof *shared; ++i)
            keep = keep || strncmp(at, shared[i], strlen(shared[i])) == 0;
        fprintf(f, "%.*s%s", (int)(at - text), text, keep ? from : to);
    }
    fputs(text, f);
}

/* The finer layer. Nothing is written when memory ends: then the declared names are missing and POV-Ray says so. */
static void write_inner(FILE *f, const iso_povray_scene *inner)
{
    char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (!memory)
        return;
    write_layer(memory, inner);
    if (fclose(memory) == 0)
        write_renamed(f, text);
    free(text);
}

void iso_povray_write_include(FILE *f, const iso_povray_scene *s)
{
    write_header(f, s);
    write_placement(f, s);
    write_layer(f, s);
    if (s->inner) {
        write_weights(f, s->view->roi);
        write_inner(f, s->inner);
    }
    if (s->options->isosurface)
        write_surface(f, s);
    else
        write_media(f, s);
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
    fprintf(f, "// right-handed, as the data: `right` and `up` say so\ncamera {\n    %s\n",
            c->orthographic ? "orthographic" : "perspective");
    write_vector(f, "location", iso_scale(iso_sub(c->position, s->center_mm), s->units_per_mm));
    write_vector(f, "direction", c->forward);
    write_vector(f, "right", iso_scale(c->right, scale * aspect));
    write_vector(f, "up", iso_scale(c->up, scale));
    fprintf(f, "}\n\n");
}

/* The medium is sampled by piece, so K planes across the view give K + 1 times the samples. */
static void write_planes(FILE *f, const iso_povray_scene *s)
{
    const iso_camera *c = &s->view->camera;
    const iso_geometry *g = s->geometry;
    const iso_mat3 m = iso_mat3_scale(g->index_to_world, 0.5 * s->units_per_mm);
    double radius = 0; /* half the extent of the box along the view */
    for (int a = 0; a < 3; ++a)
        radius += fabs(iso_dot(iso_column(m, a), c->forward)) * g->box_index[a];
    fprintf(f, "// Transparent planes cut the rays into pieces, each with its own Iso_Intervals.\n"
               "#ifndef (Iso_Planes) #declare Iso_Planes = %zu; #end\n"
               "#declare Iso_Plane = 1;\n"
               "#while (Iso_Plane <= Iso_Planes)\n"
               "    plane { <%.17g, %.17g, %.17g>, %.17g * (2 * Iso_Plane / (Iso_Planes + 1) - 1)\n"
               "        hollow pigment { rgbt 1 } finish { ambient 0 diffuse 0 } }\n"
               "    #declare Iso_Plane = Iso_Plane + 1;\n"
               "#end\n", s->options->planes, c->forward.x, c->forward.y, c->forward.z, radius);
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
            "// adc_bailout 0: nothing is left out behind dense parts.\n"
            "global_settings { assumed_gamma 1.0 max_trace_level 256 adc_bailout 0 }\n\n",
            s->name, s->name, 1 / s->peak, 1 / s->peak);
    fprintf(f, "#switch (Iso_Pass)\n"
               "    #case (0) background { rgb <%.9g, %.9g, %.9g> } #break\n"
               "    #case (1) background { rgb 0 } #break\n"
               "    #case (2) background { rgb 1 } #break\n"
               "#end\n\n", b[0], b[1], b[2]);
    write_camera(f, s);
    fprintf(f, "#include \"%s.inc\"\n"
               "object { %s transform { Iso_To_World } }\n\n", s->name, object_name(s));
    if (!s->options->isosurface)
        write_planes(f, s);
}

void iso_povray_write_ini(FILE *f, const iso_povray_scene *s)
{
    fprintf(f, "; povray %s.ini\n"
               "Input_File_Name=%s.pov\n"
               "Output_File_Name=%s.png\n"
               "Output_File_Type=N8\n"
               "Width=%zu\n"
               "Height=%zu\n"
               "; Antialias=On multiplies the time; a larger picture made smaller costs less.\n"
               "Antialias=Off\n"
               "Display=Off\n"
               "Pause_When_Done=Off\n", s->name, s->name, s->name, s->view->width, s->view->height);
}
