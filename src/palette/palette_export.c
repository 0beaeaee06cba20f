/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inputs.h"
#include "palette/palette.h"

/* Nine digits preserve a float. */
#define NUMBERS "%.9g, %.9g, %.9g"

static void put_entry(FILE *file, const char *format, const iso_palette *p, size_t i)
{
    fprintf(file, format, (double)p->xyz[3 * i], (double)p->xyz[3 * i + 1], (double)p->xyz[3 * i + 2]);
}

/* Saves the text of a memory stream to a file. */
static iso_status save_text(FILE *memory, char **text, size_t *size, const char *path, iso_error *err)
{
    bool good = memory && fclose(memory) == 0;
    iso_status status = good ? iso_file_write(path, *text, *size, err)
                             : iso_fail(err, ISO_E_MEMORY, "%s: no memory for its text", path);
    free(*text);
    return status;
}

iso_status iso_palette_save_csv(const iso_palette *palette, const char *path, iso_error *err)
{
    char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (memory)
        fputs("index,x,y,z\n", memory);
    for (size_t i = 0; memory && i < palette->count; ++i) {
        fprintf(memory, "%zu,", i);
        put_entry(memory, "%.9g,%.9g,%.9g\n", palette, i);
    }
    return save_text(memory, &text, &size, path, err);
}

/* Parses a line "index,x,y,z": indices ascend from 0, entry 0 is zero, the others are unit up to a float's digits. */
static bool parse_line(const char *line, size_t wanted, float xyz[3])
{
    double n2 = 0;
    char *at;
    if (strtod(line, &at) != (double)wanted || at == line)
        return false;
    for (int c = 0; c < 3; ++c) {
        if (*at != ',')
            return false;
        const char *number = at + 1;
        double value = strtod(number, &at);
        if (at == number || !isfinite(value))
            return false;
        xyz[c] = (float)value;
        n2 += value * value;
    }
    return (*at == 0 || *at == '\r') && (wanted ? fabs(n2 - 1) < 1e-5 : n2 == 0);
}

iso_status iso_palette_load_csv(const char *path, iso_palette *palette, iso_error *err)
{
    FREED char *text = NULL;
    size_t size, lines = 0;
    *palette = (iso_palette){0};
    iso_status status = iso_inputs_note(path, err);
    TRY(status, iso_file_read(path, &text, &size, err));
    if (status != ISO_OK)
        return status;
    for (size_t i = 0; i < size; ++i)
        lines += text[i] == '\n';
    if (size && text[size - 1] != '\n')
        ++lines;
    if (memchr(text, 0, size)) /* would cut a line short */
        status = iso_fail(err, ISO_E_FORMAT, "%s: is not text (has a byte of 0)", path);
    else if (lines < 2 || lines > ISO_PALETTE_MAX + 2)
        status = iso_fail(err, ISO_E_FORMAT, "%s: has %zu lines, a palette has 2 to %d", path, lines,
                          ISO_PALETTE_MAX + 2);
    else
        status = iso_palette_create(palette, lines - 2, err);
    char *rest = text;
    for (size_t i = 0; i < lines && status == ISO_OK; ++i) {
        char *line = strsep(&rest, "\n");
        bool good = i ? parse_line(line, i - 1, palette->xyz + 3 * (i - 1)) : strncmp(line, "index,x,y,z", 11) == 0;
        if (!good)
            status = iso_fail(err, ISO_E_FORMAT, "%s:%zu: \"%.60s\" is not %s", path, i + 1, line,
                              i > 1 ? "the next index and a unit vector"
                              : i   ? "0,0,0,0"
                                    : "index,x,y,z");
    }
    if (status != ISO_OK)
        iso_palette_destroy(palette);
    return status;
}

iso_status iso_palette_save_povray(const iso_palette *palette, const char *path, const char *note, iso_error *err)
{
    char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (memory)
        fprintf(memory,
                "// Directions in world axes; entry 0 is no direction.\n// %s\n"
                "#declare Palette_Count = %zu;\n#declare Palette = array[Palette_Count] {\n",
                note, palette->count);
    for (size_t i = 0; memory && i < palette->count; ++i)
        put_entry(memory, i + 1 < palette->count ? "  <" NUMBERS ">,\n" : "  <" NUMBERS ">\n}\n", palette, i);
    return save_text(memory, &text, &size, path, err);
}

iso_status iso_palette_save_python(const iso_palette *palette, const char *path, const char *note, iso_error *err)
{
    static const char function[] =
        "\n\ndef make_image(name=\"palette\"):\n"
        "    \"\"\"A float image of one row in Blender: entry i is pixel i. Look it up at ((i + 0.5) / count, 0.5) with\n"
        "    interpolation Closest and color space Non-Color.\"\"\"\n"
        "    import bpy\n"
        "    image = bpy.data.images.new(name, len(palette), 1, float_buffer=True, is_data=True)\n"
        "    image.pixels = [c for n in palette for c in (*n, 1.0)]\n"
        "    image.pack()\n"
        "    return image\n";
    char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (memory)
        fprintf(memory, "# Directions in world axes; entry 0 is no direction.\n# %s\npalette = [\n", note);
    for (size_t i = 0; memory && i < palette->count; ++i)
        put_entry(memory, "    (" NUMBERS "),\n", palette, i);
    if (memory)
        fprintf(memory, "]%s", function);
    return save_text(memory, &text, &size, path, err);
}
