/* SPDX-License-Identifier: MIT */
/* tf_text.c - NAME_tf.inc: the transfer function as a color_map that a person edits.
 *
 * While the color_map is as exported, POV-Ray looks values up in the exact table (transfer_text.c). It compares the two
 * when it parses the scene; an edited map is sampled at 256 places. */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "povray/scene_parts.h"

enum { MOST_POINTS = ISO_TF_FEW_POINTS };

/* A point of the map: position in the TF's range, linear color, and transmittance of one unit of length. */
typedef struct map_point {
    double position, rgb[3], transparency;
} map_point;

typedef struct editable_map {
    size_t count;
    map_point points[MOST_POINTS];
    double unit_mm;
    bool are_own; /* True if they are points of the transfer function's file */
    double loss;  /* of fitted points: largest distance to the table */
} editable_map;

/* True if all points are in the range, as a color_map requires. */
static bool has_own_points(const iso_tf_table *tf)
{
    for (size_t i = 0; i < tf->point_count; ++i)
        if (tf->points[i].value < tf->lo || tf->points[i].value > tf->hi)
            return false;
    return tf->point_count > 1 && tf->unit_mm > 0;
}

static void take_points(const iso_tf_table *tf, editable_map *map)
{
    *map = (editable_map){.count = tf->point_count, .unit_mm = tf->unit_mm, .are_own = true};
    for (size_t i = 0; i < tf->point_count; ++i) {
        const iso_tf_point *p = &tf->points[i];
        map_point *to = &map->points[i];
        to->position = (p->value - tf->lo) / (tf->hi - tf->lo);
        memcpy(to->rgb, p->rgb_linear, sizeof to->rgb);
        to->transparency = 1 - fmin(p->opacity, ISO_TF_MAX_OPACITY);
    }
}

/* Returns the table with transparencies instead of extinctions; the caller frees it. */
static iso_tf_table with_transparency(const iso_tf_table *tf, double unit_mm)
{
    iso_tf_table t = {0};
    if (iso_tf_table_copy(tf, &t, NULL) == ISO_OK)
        for (size_t i = 0; i < t.count; ++i)
            t.entries[4 * i + 3] = (float)exp(-(double)tf->entries[4 * i + 3] * unit_mm);
    return t;
}

/* Selects few entries of a table without points, such as an adapted one, so that lines between them are as close to the
 * table as possible. */
static void fit_points(const iso_povray_scene *s, editable_map *map)
{
    const double densest = s->peak_extinction;
    *map = (editable_map){.unit_mm = 2.302585 / densest, .loss = 5e-4}; /* an opacity of 0.9 */
    OWNED(iso_tf_table) t = with_transparency(s->tf, map->unit_mm);
    FREED bool *keep = t.entries ? calloc(t.count, sizeof *keep) : NULL;
    const int channels[2] = {0, 4};
    size_t count = MOST_POINTS + 1;
    while (keep && count > MOST_POINTS) {
        map->loss *= 2;
        memset(keep, 0, t.count * sizeof *keep);
        count = iso_povray_mark_bends(&t, channels, map->loss, keep);
    }
    for (size_t i = 0; keep && i < t.count; ++i) {
        if (!keep[i])
            continue;
        const float *e = t.entries + 4 * i;
        map->points[map->count++] =
            (map_point){(double)i / (double)(t.count - 1), {(double)e[0], (double)e[1], (double)e[2]}, (double)e[3]};
    }
}

/* Makes the map. False if the TF is 2D or has colors above 1, which a color_map cannot hold. */
static bool get_map(const iso_povray_scene *s, editable_map *map)
{
    if (s->tf_2d || s->options->isosurface || s->peak_color > 1)
        return false;
    if (has_own_points(s->tf))
        take_points(s->tf, map);
    else
        fit_points(s, map);
    return map->count > 1;
}

bool iso_povray_has_editable_map(const iso_povray_scene *s)
{
    editable_map map;
    return get_map(s, &map);
}

static void write_map_of(FILE *f, const iso_povray_scene *s)
{
    editable_map map;
    const iso_tf_table *tf = s->tf;
    if (!get_map(s, &map))
        return;
    fprintf(f,
            "// %s_tf.inc - the transfer function: edit it here.\n"
            "//\n"
            "//     [Iso_At (VALUE) rgbt <RED, GREEN, BLUE, TRANSPARENCY>]\n"
            "//\n"
            "// VALUE: of the data, %.9g to %.9g. Colors are linear light, 0 to 1; use srgbt for sRGB.\n"
            "// TRANSPARENCY: light that passes Iso_TF_Unit of the material, 0 to 1; at 1 the material is invisible.\n"
            "// Until you edit the map, the exact table of %zu entries is used. An edited map is sampled at\n"
            "// 256 places from the lowest value to the highest%s",
            s->name, tf->lo, tf->hi, tf->count, map.are_own ? ".\n" : ".\n// ");
    if (!map.are_own)
        fprintf(
            f,
            "These points are fitted to the table, within %.2g in colors and transparency; edits use them instead.\n",
            map.loss);
    fprintf(f,
            "#macro Iso_At (Value) ((Value - (%.17g)) / %.17g) #end\n"
            "#declare Iso_TF_Unit = %.9g; // mm\n"
            "#declare Iso_TF_Map = color_map {\n",
            tf->lo, tf->hi - tf->lo, map.unit_mm);
    for (size_t i = 0; i < map.count; ++i) {
        const map_point *p = &map.points[i];
        fprintf(f, "    [Iso_At (%.9g) rgbt <%.6g, %.6g, %.6g, %.6g>]\n", tf->lo + p->position * (tf->hi - tf->lo),
                p->rgb[0], p->rgb[1], p->rgb[2], p->transparency);
    }
    fprintf(f, "}\n");
}

void iso_povray_write_map(FILE *f, const iso_povray_scene *s)
{
    FREED char *text = NULL;
    size_t size = 0;
    FILE *memory = s->is_roi ? open_memstream(&text, &size) : NULL;
    if (!memory) {
        write_map_of(f, s);
        return;
    }
    write_map_of(memory, s);
    if (fclose(memory) == 0)
        iso_povray_write_renamed(f, text);
}

/* Compares between the points too, because of steps. */
static void write_comparison(FILE *f, const editable_map *map)
{
    fprintf(f,
            "// The exported points, to detect edits: position, color, transparency.\n"
            "#declare Iso_TF_Exported = array[%zu][5] {\n",
            map->count);
    for (size_t i = 0; i < map->count; ++i)
        fprintf(f, "    { %.9g, %.6g, %.6g, %.6g, %.6g }%s\n", map->points[i].position, map->points[i].rgb[0],
                map->points[i].rgb[1], map->points[i].rgb[2], map->points[i].transparency,
                i + 1 < map->count ? "," : "");
    fprintf(f,
            "}\n"
            "#declare Iso_TF_Unit_Exported = %.9g;\n"
            "#declare Iso_TF_Look = function { pigment { function { min(1, max(0, x)) } color_map { Iso_TF_Map } } }\n"
            "#declare Iso_TF_Edited = (abs(Iso_TF_Unit / Iso_TF_Unit_Exported - 1) > 1e-6);\n"
            "#macro Iso_TF_Was (I, C, F) ((1 - F) * Iso_TF_Exported[I][C] + F * Iso_TF_Exported[I + 1][C]) #end\n"
            "#macro Iso_TF_Compare (I, F)\n"
            "    #declare Iso_TF_Now = Iso_TF_Look(Iso_TF_Was (I, 0, F), 0, 0);\n"
            "    #if (max(abs(Iso_TF_Now.red - Iso_TF_Was (I, 1, F)), abs(Iso_TF_Now.green - Iso_TF_Was (I, 2, F)),\n"
            "            abs(Iso_TF_Now.blue - Iso_TF_Was (I, 3, F)), abs(Iso_TF_Now.transmit - Iso_TF_Was (I, 4, F))) > 1e-4)\n"
            "        #declare Iso_TF_Edited = true;\n"
            "    #end\n"
            "#end\n"
            "#declare Iso_TF_I = 0;\n"
            "#while (Iso_TF_I < dimension_size(Iso_TF_Exported, 1) - 1)\n"
            "    #declare Iso_TF_Width = Iso_TF_Exported[Iso_TF_I + 1][0] - Iso_TF_Exported[Iso_TF_I][0];\n"
            "    #declare Iso_TF_J = (Iso_TF_Width > 1e-6 ? 0 : 1000);\n"
            "    #declare Iso_TF_N = 8 + int(256 * Iso_TF_Width);\n"
            "    #while (Iso_TF_J < Iso_TF_N)\n"
            "        Iso_TF_Compare (Iso_TF_I, (Iso_TF_J + 0.5) / Iso_TF_N)\n"
            "        #declare Iso_TF_J = Iso_TF_J + 1;\n"
            "    #end\n"
            "    #declare Iso_TF_I = Iso_TF_I + 1;\n"
            "#end\n",
            map->unit_mm);
}

void iso_povray_begin_edited(FILE *f, const iso_povray_scene *s)
{
    editable_map map;
    if (!get_map(s, &map))
        return;
    fprintf(f, "#include \"%s_tf.inc\"\n", s->name);
    write_comparison(f, &map);
    fprintf(f,
            "#if (Iso_TF_Edited)\n"
            "#debug \"isoshade: the transfer function was edited\\n\"\n"
            "#macro Iso_TF_Depth (I) (-ln(max(1e-4, min(1, Iso_TF_Look(I / 255, 0, 0).transmit))) / Iso_TF_Unit) #end\n"
            "#declare Iso_TF_Most = 1e-9;\n"
            "#declare Iso_TF_I = 0;\n"
            "#while (Iso_TF_I < 256)\n"
            "    #declare Iso_TF_Most = max(Iso_TF_Most, Iso_TF_Depth (Iso_TF_I));\n"
            "    #declare Iso_TF_I = Iso_TF_I + 1;\n"
            "#end\n"
            "#declare Iso_Extinction = Iso_TF_Most / %.17g / Iso_Scale;\n"
            "#declare Iso_TF_Extinction = density { function { Iso_TF_Position(x, y, z) } color_map {\n"
            "    #declare Iso_TF_I = 0;\n"
            "    #while (Iso_TF_I < 256)\n"
            "        [Iso_TF_I / 255 rgb Iso_TF_Depth (Iso_TF_I) / Iso_TF_Most]\n"
            "        #declare Iso_TF_I = Iso_TF_I + 1;\n"
            "    #end } }\n"
            "#declare Iso_TF_Color = density { function { Iso_TF_Position(x, y, z) } color_map {\n"
            "    #declare Iso_TF_I = 0;\n"
            "    #while (Iso_TF_I < 256)\n"
            "        [Iso_TF_I / 255 rgb <Iso_TF_Look(Iso_TF_I / 255, 0, 0).red, Iso_TF_Look(Iso_TF_I / 255, 0, 0).green,\n"
            "            Iso_TF_Look(Iso_TF_I / 255, 0, 0).blue>]\n"
            "        #declare Iso_TF_I = Iso_TF_I + 1;\n"
            "    #end } }\n"
            "#declare Iso_Opaque_At = function (p) { 1 } // anywhere\n"
            "#else\n",
            s->units_per_mm);
}

void iso_povray_end_edited(FILE *f, const iso_povray_scene *s)
{
    if (iso_povray_has_editable_map(s))
        fprintf(f, "#end\n\n");
}
