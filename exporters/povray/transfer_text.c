/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "povray/scene_parts.h"

/* POV-Ray's colors are floats: deviations of this part of the peak from a line do not show. */
static const double color_map_tolerance = 6e-8;

static double peak_color(const iso_tf_table *tf)
{
    double color = 1;
    for (size_t i = 0; i < tf->count; ++i) {
        const float *e = tf->entries + 4 * i;
        color = fmax(color, fmax((double)e[0], fmax((double)e[1], (double)e[2])));
    }
    return color;
}

/* Returns the largest possible color: a ray's weights sum to at most 1, and diffuse light is at most 1. */
double iso_povray_peak(const iso_view *view)
{
    return peak_color(&view->tf) * (1 + iso_povray_specular_sum(view));
}

/* Measures the peaks that densities and colors are divided by: POV-Ray wraps densities above 1 and clips colors above
 * 1. */
void iso_povray_measure_peaks(iso_povray_scene *s)
{
    const iso_tf_table *tf = s->tf;
    double extinction = 0;
    for (size_t i = 0; i < tf->count; ++i)
        extinction = fmax(extinction, (double)tf->entries[4 * i + 3]);
    s->peak_extinction = extinction > 0 ? extinction : 1;
    s->peak_color = peak_color(tf);
    s->peak = s->peak_color * (1 + iso_povray_specular_sum(s->view));
}

/* Narrows a cone of allowed slopes per channel until an entry lies outside it. */
size_t iso_povray_mark_bends(const iso_tf_table *tf, const int channels[2], double tolerance, bool *keep)
{
    size_t kept = 1, from = 0;
    double lo[4], hi[4];
    keep[0] = true;
    for (size_t i = 1; i < tf->count; ++i) {
        bool inside = i > from + 1;
        for (int c = channels[0]; c < channels[1]; ++c) {
            const double slope = ((double)tf->entries[4 * i + c] - (double)tf->entries[4 * from + c]) /
                                 (double)(i - from);
            inside = inside && slope >= lo[c] && slope <= hi[c];
        }
        if (i > from + 1 && !inside) {
            from = i - 1;
            keep[from] = true;
            ++kept;
        }
        for (int c = channels[0]; c < channels[1]; ++c) {
            const double rise = (double)tf->entries[4 * i + c] - (double)tf->entries[4 * from + c],
                         run = (double)(i - from);
            lo[c] = fmax(i == from + 1 ? -INFINITY : lo[c], (rise - tolerance) / run);
            hi[c] = fmin(i == from + 1 ? INFINITY : hi[c], (rise + tolerance) / run);
        }
        keep[i] = i + 1 == tf->count;
    }
    return kept + 1;
}

/* Source of a density map: the TF's channels [first, end), divided by peak. */
typedef struct map_source {
    int channels[2];
    double peak;
} map_source;

static map_source extinction_source(const iso_povray_scene *s)
{
    return (map_source){{3, 4}, s->peak_extinction};
}
static map_source color_source(const iso_povray_scene *s)
{
    return (map_source){{0, 3}, s->peak_color};
}

/* Positions in a color_map are floats: tables with finer steps become DF3 files. */
enum { max_color_map_table = 1024 };

/* Returns flags of the entries that a color_map needs, which the caller frees; NULL if the table does not fit a
 * color_map. */
static bool *color_map_entries(const iso_povray_scene *s, map_source source)
{
    const iso_tf_table *tf = s->tf;
    bool *keep = !s->tf_2d && tf->count <= max_color_map_table ? calloc(tf->count, sizeof *keep) : NULL;
    if (keep &&
        iso_povray_mark_bends(tf, source.channels, color_map_tolerance * source.peak, keep) >
            ISO_POVRAY_COLOR_MAP_ENTRIES) {
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

static void write_color_map(FILE *f, const char *identifier, const iso_tf_table *tf, map_source source,
                            const bool *keep)
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

/* Writes lookups of DF3 tables of one row, or of the rows of a 2D transfer function, linear between entries like a
 * color_map. `average` of three densities is a third of their sum. */
static void write_table_lookup(FILE *f, const iso_povray_scene *s, bool color)
{
    const size_t count = s->tf->count;
    const double scale = (double)(count - 1) / (double)count;
    char row[64] = "0";
    if (s->tf_2d)
        snprintf(row, sizeof row, "Iso_Second(x, y, z) * %.17g", (ISO_TF_2D_ROWS - 1.0) / ISO_TF_2D_ROWS);
    static const char *const channel[4] = {"red", "green", "blue", "extinction"};
    static const char *const unit[4] = {"<3, 0, 0>", "<0, 3, 0>", "<0, 0, 3>", "1"};
    for (int c = color ? 0 : 3; c < (color ? 3 : 4); ++c) {
        fprintf(f, "#declare Iso_Table_%s = function { pattern { density_file df3 \"%s_tf_%s.df3\" interpolate 1 } }\n",
                channel[c], s->name, channel[c]);
        fprintf(f,
                "#declare %s%s = density { function { Iso_Table_%s(Iso_TF_Position(x, y, z) * %.17g, %s, 0) }\n"
                "    color_map { [0 rgb 0] [1 rgb %s] } }\n",
                color ? "Iso_TF_" : "Iso_TF_Extinction", color ? channel[c] : "", channel[c], scale, row, unit[c]);
    }
    if (color)
        fprintf(f, "#declare Iso_TF_Color = density { average density_map {\n"
                   "    [1 Iso_TF_red] [1 Iso_TF_green] [1 Iso_TF_blue] } }\n");
}

static void write_map(FILE *f, const iso_povray_scene *s, bool color)
{
    const map_source source = color ? color_source(s) : extinction_source(s);
    FREED bool *keep = color_map_entries(s, source);
    if (keep)
        write_color_map(f, color ? "Iso_TF_Color" : "Iso_TF_Extinction", s->tf, source, keep);
    else
        write_table_lookup(f, s, color);
}

const char *iso_povray_lazily(const iso_povray_scene *s, const char *select)
{
    size_t zeros = 0;
    for (size_t i = 0; i + 1 < s->tf->count; ++i)
        zeros += s->tf->entries[4 * i + 3] == 0 && s->tf->entries[4 * i + 7] == 0;
    return zeros > 0 ? select : "";
}

/* Writes Iso_Opaque, negative in ranges of the TF without extinction: there the shading, most of the work, is
 * skipped. */
static void write_opaque_ranges(FILE *f, const iso_povray_scene *s)
{
    enum { most_ranges = 8 }; /* skipping fewer ranges is slower, not wrong */
    const iso_tf_table *tf = s->tf;
    const double last = (double)(tf->count - 1);
    int ranges = 0;
    if (!*iso_povray_lazily(s, "yes"))
        return;
    fprintf(f, "// Negative where the transfer function is transparent: no shading is computed there.\n"
               "#declare Iso_Opaque_At = function (p) { min(1");
    for (size_t i = 0; i < tf->count && ranges < most_ranges; ++i) {
        size_t end = i;
        while (end < tf->count && tf->entries[4 * end + 3] == 0)
            ++end;
        if (end > i + 1) {
            fprintf(f, ", max(%.9g - p, p - %.9g)", i > 0 ? (double)i / last : -1,
                    end < tf->count ? (double)(end - 1) / last : 2);
            ++ranges;
        }
        i = end > i ? end - 1 : i;
    }
    fprintf(f, ") }\n");
}

void iso_povray_write_transfer_function(FILE *f, const iso_povray_scene *s)
{
    const iso_tf_table *tf = s->tf;
    fprintf(
        f,
        "// ---- the transfer function ------------------------------------------------\n");
    iso_povray_begin_edited(f, s);
    fprintf(
        f,
        "// %zu entries from %.9g to %.9g; colors are linear light (assumed_gamma 1). Entries on a straight line are\n"
        "// left out; a table that needs more than the 256 of a color_map is a DF3 file.\n"
        "#declare Iso_Extinction = %.17g / Iso_Scale; // per unit, at Iso_TF_Extinction 1\n",
        tf->count, tf->lo, tf->hi, s->peak_extinction / s->units_per_mm);
    write_map(f, s, false);
    write_map(f, s, true);
    write_opaque_ranges(f, s);
    iso_povray_end_edited(f, s);
    if (*iso_povray_lazily(s, "yes"))
        fprintf(f, "#declare Iso_Opaque = function (x, y, z) { Iso_Opaque_At(Iso_TF_Position(x, y, z)) }\n\n");
}
