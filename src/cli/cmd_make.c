/* SPDX-License-Identifier: MIT */
/* cmd_make.c - writes synthetic volumes slab by slab. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/linalg.h"
#include "options/cli.h"
#include "volume/stream.h"
#include "volume/synthetic.h"

/* Approximate size of a slab of planes. */
#define SLAB_BYTES ((size_t)32 << 20)

typedef struct make_options {
    char *size, *spacing, *rotate, *center, *type, *range, *output;
    double grain;
    long long seed;
    int gzip;
} make_options;

/* Returns the rotation by angle_deg around axis (Rodrigues). */
static iso_mat3 rotation(iso_vec3 axis, double angle_deg)
{
    iso_vec3 u = iso_normalize(axis);
    double a = angle_deg * (3.14159265358979323846 / 180), c = cos(a), s = sin(a), t = 1 - c;
    return (iso_mat3){{{c + u.x * u.x * t, u.x * u.y * t - u.z * s, u.x * u.z * t + u.y * s},
                       {u.y * u.x * t + u.z * s, c + u.y * u.y * t, u.y * u.z * t - u.x * s},
                       {u.z * u.x * t - u.y * s, u.z * u.y * t + u.x * s, c + u.z * u.z * t}}};
}

/* Reads "X,Y,Z,ANGLE", or the nine numbers of a direction matrix, row by row. */
static iso_status parse_rotation(const char *text, iso_mat3 *matrix, iso_error *err)
{
    double v[9];
    int count = 0;
    const char *at = text;
    while (count < 9) {
        char *end;
        v[count] = strtod(at, &end);
        if (end == at || !isfinite(v[count]))
            break;
        ++count;
        at = end;
        if (*at != ',')
            break;
        ++at;
    }
    if (*at || (count != 4 && count != 9))
        return iso_fail(err, ISO_E_USAGE,
                        "--rotate is \"%s\", must be X,Y,Z,DEGREES or the 9 numbers of a direction matrix", text);
    if (count == 4) {
        if (iso_norm(iso_v3(v[0], v[1], v[2])) == 0)
            return iso_fail(err, ISO_E_USAGE, "--rotate is \"%s\", the axis must not be zero", text);
        *matrix = rotation(iso_v3(v[0], v[1], v[2]), v[3]);
        return ISO_OK;
    }
    for (int i = 0; i < 9; ++i)
        matrix->m[i / 3][i % 3] = v[i];
    return ISO_OK;
}

/* Reads "X,Y,Z" in mm. */
static iso_status parse_center(const char *text, iso_vec3 *center, iso_error *err)
{
    int end = -1;
    if (sscanf(text, "%lf,%lf,%lf%n", &center->x, &center->y, &center->z, &end) != 3 || text[end] ||
        !(iso_norm(*center) <= ISO_MOST_PLACE_MM))
        return iso_fail(err, ISO_E_USAGE, "--center is \"%s\", must be X,Y,Z in mm", text);
    return ISO_OK;
}

/* Makes the geometry, with the box centered at the world's origin or at --center. */
static iso_status parse_geometry(const make_options *opt, iso_geometry *g, iso_error *err)
{
    size_t size[3];
    double spacing[3] = {1, 1, 1};
    iso_mat3 turn = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    NEED(iso_words_parse_sizes(opt->size, "--size", size, err));
    if (opt->spacing)
        NEED(iso_words_parse_numbers(opt->spacing, "--spacing", spacing, err));
    for (int a = 0; a < 3; ++a)
        NEED(iso_words_check_range("--spacing", spacing[a], ISO_LEAST_MM, ISO_MOST_MM, err));
    iso_vec3 center = {0, 0, 0};
    if (opt->center)
        NEED(parse_center(opt->center, &center, err));
    if (opt->rotate)
        NEED(parse_rotation(opt->rotate, &turn, err));
    *g = iso_geometry_axis_aligned(size, spacing);
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            g->index_to_world.m[r][c] = turn.m[r][c] * spacing[c];
    g->origin_mm = iso_add(center, iso_mul(turn, g->origin_mm));
    return iso_geometry_check(g, "--size and --rotate", err);
}

/* Reads "LO,HI" within the limits of the type. */
static iso_status parse_range(const char *text, iso_type type, iso_field *field, iso_error *err)
{
    double least = 0, most = 0;
    char *end, *last;
    if (!text)
        return ISO_OK;
    iso_field_type_range(type, &least, &most);
    if (type == ISO_F32 || type == ISO_F64)
        least = -ISO_MOST_VALUE, most = ISO_MOST_VALUE;
    field->range[0] = strtod(text, &end);
    field->range[1] = *end == ',' ? strtod(end + 1, &last) : NAN;
    bool good = end != text && *end == ',' && last != end + 1 && !*last;
    for (int i = 0; i < 2; ++i)
        good = good && field->range[i] >= least && field->range[i] <= most;
    if (!good)
        return iso_fail(err, ISO_E_USAGE, "--range is \"%s\", must be LO,HI, each %g to %g", text, least, most);
    field->has_range = true;
    return ISO_OK;
}

static iso_status write_slabs(const iso_field *field, iso_volume_sink *sink, iso_type type, const iso_cli *cli,
                              iso_error *err)
{
    const size_t *n = field->geometry.size;
    size_t plane = n[0] * n[1] * iso_type_bytes(type);
    size_t slab = SLAB_BYTES / plane > 0 ? SLAB_BYTES / plane : 1;
    slab = slab < n[2] ? slab : n[2];
    iso_progress progress = iso_cli_progress(cli);
    iso_cli_expect(cli, &(iso_cli_stage){"make", 1}, 1);
    FREED void *planes = malloc(slab * plane);
    NEED_MEMORY(planes, err, "no memory for %zu bytes of planes", slab * plane);
    for (size_t z = 0; z < n[2]; z += slab) {
        size_t end = z + slab < n[2] ? z + slab : n[2];
        NEED(iso_field_sample_planes(field, type, z, end, cli->threads, planes, err));
        NEED(iso_sink_write(sink, end - z, planes, err));
        iso_progress_report(&progress, "make", (double)end / (double)n[2]);
    }
    return ISO_OK;
}

static iso_status make_volume(const iso_cli *cli, const make_options *opt, iso_error *err)
{
    iso_field field = {.seed = (uint64_t)opt->seed, .grain = opt->grain};
    iso_volume like = {.notes = {.scale_slope = 1}};
    iso_volume_sink *sink;
    NEED(iso_field_from_name(cli->arguments[0], &field.kind, err));
    NEED(iso_type_from_name(opt->type ? opt->type : "uint16", &like.type, err));
    NEED(parse_range(opt->range, like.type, &field, err));
    NEED(parse_geometry(opt, &field.geometry, err));
    like.geometry = field.geometry;
    NEED(iso_sink_open(opt->output, &like, opt->gzip, &sink, err));
    iso_status status = write_slabs(&field, sink, like.type, cli, err);
    if (status == ISO_OK)
        status = iso_sink_commit(sink, err);
    else
        iso_sink_abandon(sink);
    NEED(status);
    if (cli->json)
        iso_cli_print_results(cli, json_pack("{s:s, s:I}", "output", opt->output, "voxels",
                                             (json_int_t)iso_geometry_voxel_count(&field.geometry)));
    return ISO_OK;
}

static const iso_option options[] = {
    {"output", 'o', "NRRD file to write", "FILE", ISO_IN(make_options, output)},
    {"size", 0, "voxels along x, y and z", "NXxNYxNZ", ISO_IN(make_options, size)},
    {"spacing", 0, "spacing along the grid axes in mm (1)", "SXxSYxSZ", ISO_IN(make_options, spacing)},
    {"rotate", 0, "rotation: axis and degrees X,Y,Z,A, or a 3x3 matrix by rows", "NUMBERS",
     ISO_IN(make_options, rotate)},
    {"center", 0, "center of the box in mm (0,0,0)", "X,Y,Z", ISO_IN(make_options, center)},
    {"type", 0, "type of the samples (uint16)", "TYPE", ISO_IN(make_options, type)},
    {"range", 0, "sample values for 0 and 1 (the type's range; 0,1 for floats)", "LO,HI", ISO_IN(make_options, range)},
    {"grain", 0, "add noise with this standard deviation, as part of the range (0)", "SIGMA",
     ISO_IN(make_options, grain), .most = 1},
    {"seed", 0, "seed of noise, vessels and grain", "N", ISO_IN(make_options, seed), .flags = ISO_SHOWN},
    {"gzip", 0, "compress the samples", NULL, ISO_IN(make_options, gzip)},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    const make_options *opt = values;
    return opt->output && opt->size ? make_volume(cli, opt, err)
                                    : iso_fail(err, ISO_E_USAGE, "--size and -o are required");
}

#define KIND_LINE(name, text, help) "  " text ": " help "\n"
const iso_command iso_command_make = {
    .name = "make",
    .summary = "write a synthetic volume whose values and gradients are known",
    .min_arguments = 1,
    .max_arguments = 1,
    .usage = "KIND --size NXxNYxNZ -o FILE.nrrd [options]",
    .details = "Kinds, in coordinates that run from -1 to 1 along the shortest edge of the box:\n" ISO_FIELD_LIST(
        KIND_LINE) "Integer types use their whole range. The box is centered at the world's origin.\n"
                   "Without --grain all values are exactly known.",
    .examples = "  isoshade make marschner-lobb --size 40x56x33 --spacing 1x1x2.5 -o v.nrrd\n"
                "  isoshade make sphere --size 48 --type float --rotate 1,2,3,30 -o sphere.nrrd\n"
                "  isoshade make noise --size 64x48x32 --seed 7 --gzip -o noise.nrrd\n",
    ISO_COMMAND_OPTIONS(make_options, options, .seed = 1),
    .run = run,
};
