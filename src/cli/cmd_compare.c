/* SPDX-License-Identifier: MIT */
/* cmd_compare.c - measures the difference of two images, and checks it against limits. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "options/cli.h"
#include "compare/flip.h"
#include "compare/metrics.h"
#include "image/image.h"
#include "report/rows.h"

typedef struct compare_options {
    iso_tolerances tolerances;
    char *difference, *flip_map, *part, *layer;
    double scale;
    int hdr;
} compare_options;

/* Loads both pictures. --part and --layer apply to files that have parts or layers; at least one must. */
static iso_status load(const iso_cli *cli, const compare_options *opt, iso_image images[2], bool has_alpha[2],
                       iso_error *err)
{
    iso_image_choice choice = {.part = opt->part, .layer = opt->layer};
    for (int i = 0; i < 2; ++i) {
        NEED(iso_image_load(cli->arguments[i], &choice, &images[i], err));
        has_alpha[i] = choice.has_alpha;
    }
    if (opt->part && !choice.used_part)
        return iso_fail(err, ISO_E_USAGE, "--part is \"%s\", but neither file has several parts", opt->part);
    if (opt->layer && !choice.used_layer)
        return iso_fail(err, ISO_E_USAGE, "--layer is \"%s\", but neither file has layers", opt->layer);
    return ISO_OK;
}

/* Checks the limits: -inf is not given, and a limit of 0 would require equality, which is the default. */
static iso_status check_tolerances(iso_tolerances *l, iso_error *err)
{
    const struct {
        const char *name;
        double *value;
    } all[] = {
        {"--max-rmse", &l->rmse},      {"--max-abs", &l->max_abs},
        {"--max-p99", &l->p99_abs},    {"--max-dissimilarity", &l->ssim_dissimilarity},
        {"--max-flip", &l->flip_mean},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; ++i) {
        if (*all[i].value == -INFINITY)
            *all[i].value = 0;
        else if (!(*all[i].value > 0 && *all[i].value < INFINITY))
            return iso_fail(err, ISO_E_USAGE, "%s is %g, must be above 0; omit it to require equal images", all[i].name,
                            *all[i].value);
    }
    return ISO_OK;
}

/* Computes the mean of the FLIP map, and saves the map if requested. */
static iso_status measure_flip(const compare_options *opt, const iso_image images[2], double *mean, iso_error *err)
{
    OWNED(iso_image) picture = {0};
    size_t count = images[0].width * images[0].height;
    FREED float *map = malloc(count * sizeof *map);
    NEED_MEMORY(map, err, "no memory for %zu pixels", count);
    NEED((opt->hdr ? iso_flip_hdr : iso_flip_ldr)(&images[0], &images[1], ISO_FLIP_PIXELS_PER_DEGREE, map, err));
    *mean = iso_flip_mean(map, count);
    if (!opt->flip_map)
        return ISO_OK;
    NEED(iso_image_create(&picture, images[0].width, images[0].height, err));
    for (size_t i = 0; i < 4 * count; ++i)
        picture.rgba[i] = i % 4 == 3 ? 1 : map[i / 4];
    return iso_image_save(&picture, opt->flip_map, NULL, err);
}

typedef struct hdr_flip {
    double mean, start, stop;
    size_t exposures;
} hdr_flip;

static bool is_opaque(const iso_image *image)
{
    for (size_t i = 0; i < image->width * image->height; ++i)
        if (!(image->rgba[4 * i + 3] >= 1))
            return false;
    return true;
}

/* Result of comparing opacities. Some programs blend the background into their pictures, which makes them opaque: then
 * alpha differs for that reason alone. */
typedef struct opacity {
    const char *opaque, *other; /* "A" or "B"; NULL if both or neither are opaque throughout */
    double rmse_of_colors;
} opacity;

static opacity look_at_opacity(const iso_image images[2])
{
    const bool a = is_opaque(&images[0]), b = is_opaque(&images[1]);
    if (a == b)
        return (opacity){NULL, NULL, NAN};
    return (opacity){a ? "A" : "B", a ? "B" : "A", iso_metrics_rmse_of_colors(&images[0], &images[1], INFINITY)};
}

/* Copies alpha to a picture without one, so that only colors are compared. */
static void complete_alpha(iso_image images[2], const bool has_alpha[2])
{
    if (has_alpha[0] == has_alpha[1])
        return;
    const iso_image *from = &images[has_alpha[0] ? 0 : 1], *to = &images[has_alpha[0] ? 1 : 0];
    for (size_t i = 0; i < to->width * to->height; ++i)
        to->rgba[4 * i + 3] = from->rgba[4 * i + 3];
}

static void print_text(const iso_metrics *m, const opacity *o, const hdr_flip *hdr, bool agree)
{
    if (m->nonfinite_count > 0)
        printf("%zu pixel%s not finite\n", m->nonfinite_count, m->nonfinite_count == 1 ? " is" : "s are");
    else
        printf("rmse      %.4g\nmax_abs   %.4g at column %zu, row %zu\np99_abs   %.4g\npsnr_db   %.4g\n"
               "ssim      %.6f\nflip_mean %.6f\n",
               m->rmse, m->max_abs, m->worst[0], m->worst[1], m->p99_abs, m->psnr_db, m->ssim, m->flip_mean);
    if (o->opaque)
        printf("note      %s is opaque throughout, %s is not; rmse of the colors: %.4g\n", o->opaque, o->other,
               o->rmse_of_colors);
    if (isfinite(hdr->mean))
        printf("hdr_flip  %.6f over %zu exposures, 2^%.4f to 2^%.4f\n", hdr->mean, hdr->exposures, hdr->start,
               hdr->stop);
    printf("verdict   %s\n", agree ? "agree" : "differ");
}

static iso_status compare(const iso_cli *cli, const compare_options *opt, iso_image images[3], iso_error *err)
{
    iso_metrics m;
    double flip = NAN;
    bool has_alpha[2] = {false, false};
    hdr_flip hdr = {.mean = NAN};
    if (opt->flip_map)
        NEED(iso_image_check_name("--flip-map", opt->flip_map, err));
    NEED(load(cli, opt, images, has_alpha, err));
    const bool has_one_size = images[0].width == images[1].width && images[0].height == images[1].height;
    const opacity o = has_one_size ? look_at_opacity(images) : (opacity){NULL, NULL, NAN};
    if (has_one_size)
        complete_alpha(images, has_alpha);
    const iso_status status = iso_metrics_measure(&images[0], &images[1], &m, err);
    if (status != ISO_OK)
        return iso_fail_in(err, status, "%s and %s", cli->arguments[0], cli->arguments[1]);
    if (opt->difference) {
        NEED(iso_image_difference(&images[0], &images[1], opt->scale, &images[2], err));
        NEED(iso_image_save_png(&images[2], opt->difference, 1, err));
    }
    if ((opt->hdr || opt->flip_map) && m.nonfinite_count == 0)
        NEED(measure_flip(opt, images, &flip, err));
    if (opt->hdr && isfinite(flip)) {
        hdr.mean = flip;
        NEED(iso_flip_exposures(&images[0], &hdr.start, &hdr.stop, &hdr.exposures, err));
    }
    const bool agree = iso_metrics_within(&m, &opt->tolerances);
    if (!cli->json) {
        print_text(&m, &o, &hdr, agree);
        return agree ? ISO_OK : ISO_E_DIFFERS;
    }
    json_t *root = json_pack("{s:{s:o}, s:s, s:s}", "options", "limits", iso_tolerances_to_json(&opt->tolerances), "a",
                             cli->arguments[0], "b", cli->arguments[1]);
    json_object_update_new(root, iso_metrics_to_json(&m));
    if (o.opaque)
        json_object_update_new(root, json_pack("{s:s, s:o}", "opaque", o.opaque, "rmse_of_colors",
                                               iso_json_number(o.rmse_of_colors)));
    if (opt->hdr)
        json_object_set_new(root, "hdr_flip_mean", iso_json_number(hdr.mean));
    if (isfinite(hdr.mean))
        json_object_set_new(root, "hdr_flip_exposures",
                            json_pack("{s:f, s:f, s:I}", "start", hdr.start, "stop", hdr.stop, "count",
                                      (json_int_t)hdr.exposures));
    json_object_set_new(root, "verdict", json_string(agree ? "agree" : "differ"));
    iso_cli_print_results(cli, root);
    return agree ? ISO_OK : ISO_E_DIFFERS;
}

static const iso_option options[] = {
    {"max-rmse", 0, "largest allowed root mean square difference", "X", ISO_IN(compare_options, tolerances.rmse)},
    {"max-abs", 0, "largest allowed difference of any channel", "X", ISO_IN(compare_options, tolerances.max_abs)},
    {"max-p99", 0, "largest allowed difference of 99 % of the pixels", "X",
     ISO_IN(compare_options, tolerances.p99_abs)},
    {"max-dissimilarity", 0, "largest allowed 1 - SSIM", "X", ISO_IN(compare_options, tolerances.ssim_dissimilarity)},
    {"max-flip", 0, "largest allowed mean FLIP", "X", ISO_IN(compare_options, tolerances.flip_mean)},
    {"difference", 'd', "write a picture of |a - b|", "OUT.png", ISO_IN(compare_options, difference)},
    {"scale", 0, "factor for that picture; 0: the largest difference is white", "X", ISO_IN(compare_options, scale),
     .most = 1e30},
    {"flip-map", 0, "write the FLIP map: values as .exr, or gray as .png", "OUT", ISO_IN(compare_options, flip_map)},
    {"hdr", 0, "also measure and map HDR-FLIP, with A as reference", NULL, ISO_IN(compare_options, hdr)},
    {"part", 0, "part of a multipart OpenEXR file", "NAME|N", ISO_IN(compare_options, part)},
    {"layer", 0, "layer of an OpenEXR file", "NAME", ISO_IN(compare_options, layer)},
    ISO_OPTIONS_END,
};

static iso_status run(const iso_cli *cli, void *values, iso_error *err)
{
    compare_options *opt = values;
    iso_image images[3] = {{0}};
    iso_status status = check_tolerances(&opt->tolerances, err);
    TRY(status, compare(cli, opt, images, err));
    for (int i = 0; i < 3; ++i)
        iso_image_destroy(&images[i]);
    return status;
}

const iso_command iso_command_compare = {
    .name = "compare",
    .summary = "measure the difference of two images",
    .min_arguments = 2,
    .max_arguments = 2,
    .usage = "A B [--max-rmse X ...] [--difference OUT.png] [--json]",
    .details =
        "Images are OpenEXR (linear), PPM of 16 bits (linear) or PNG (decoded from sRGB, or by its gAMA and cHRM); a\n"
        "file's content decides, not its name. OpenEXR files of several parts need --part, a name or a number from 1.\n"
        "Channels of a layer, such as ViewLayer.Combined.R, need --layer ViewLayer.Combined.\n"
        "Exit code 0: the images agree within the given limits; 1: they differ. Without limits they\n"
        "must be equal. Limits, RMSE and differences are on linear RGB and alpha; SSIM and FLIP\n"
        "on sRGB. If one image is opaque throughout and the other is not, a note has the RMSE of\n"
        "the colors. If only one file has an alpha channel, alpha is not compared. Pixels that are not finite\n"
        "always differ.",
    .examples =
        "  isoshade make sphere --size 24 -o v.nrrd\n"
        "  isoshade render v.nrrd --scene refscenes/shells.scene.json --size 48 -o a.exr\n"
        "  isoshade render v.nrrd --scene refscenes/shells.scene.json --size 48 --with reference --quadrature midpoint -o b.exr\n"
        "  isoshade compare a.exr b.exr --max-rmse 1e-6 --max-abs 2e-5\n"
        "  isoshade compare a.exr b.exr --max-flip 0.01 --difference difference.png --json\n",
    ISO_COMMAND_OPTIONS(compare_options, options,
                        .tolerances = {-INFINITY, -INFINITY, -INFINITY, -INFINITY, -INFINITY}),
    .run = run,
};
