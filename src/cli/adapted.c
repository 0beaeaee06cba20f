#include "cli/adapted.h"

#include "cli/cli.h"

void iso_cli_adapted_defaults(iso_cli_adapted *a)
{
    *a = (iso_cli_adapted){.bits = iso_adapt_defaults().bits};
}

iso_status iso_cli_adapt_options(const iso_cli_adapted *a, int threads, iso_adapt_options *opt, iso_error *err)
{
    *opt = iso_adapt_defaults();
    iso_status status = iso_cli_check_range("--bits", a->bits, 8, 16, err);
    if (status == ISO_OK && a->average && iso_adapt_average_from_name(a->average, &opt->average, err) != ISO_OK)
        status = iso_fail_in(err, ISO_E_USAGE, "--average");
    if (status == ISO_OK && a->weight && iso_adapt_weight_from_name(a->weight, &opt->weight, err) != ISO_OK)
        status = iso_fail_in(err, ISO_E_USAGE, "--weight");
    if (status == ISO_OK && a->window != 0)
        status = iso_cli_check_range("--window", a->window, 1, 100, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--mix-s", a->mix_s, 0, 1, err);
    if (status == ISO_OK)
        status = iso_cli_check_range("--mix-t", a->mix_t, 0, 1 - a->mix_s, err);
    opt->window = a->window;
    opt->mix_s = a->mix_s;
    opt->mix_t = a->mix_t;
    opt->bits = a->bits;
    opt->fall_back = !a->always;
    opt->threads = threads;
    return status;
}

/* How to adapt, said without asking for it, would be passed over in silence. */
static bool is_told_how(const iso_cli_adapted *a)
{
    return a->average || a->weight || a->window != 0 || a->mix_s != 0 || a->mix_t != 0 || a->always ||
           a->bits != iso_adapt_defaults().bits;
}

iso_status iso_cli_adapt_view(const iso_cli_adapted *a, const char *path, const iso_pyramid *p, size_t level, iso_view *view,
                              int threads, iso_error *err)
{
    iso_adapt_options opt;
    iso_tf_table table;
    if (!a->wanted && is_told_how(a))
        return iso_fail(err, ISO_E_USAGE, "--average, --weight, --window, --mix-s, --mix-t, --bits and --always go with --adapt");
    if (!a->wanted)
        return ISO_OK;
    iso_status status = iso_cli_adapt_options(a, threads, &opt, err);
    if (status == ISO_OK)
        status = iso_adapt_level(p, iso_pyramid_is_one(path) ? path : NULL, level, &view->tf, &opt, &table, NULL, err);
    if (status != ISO_OK)
        return status;
    iso_tf_table_destroy(&view->tf);
    view->tf = table;
    return ISO_OK;
}

iso_status iso_cli_adapt_classes(const iso_cli_adapted *a, const char *path, const iso_pyramid *p, size_t level,
                                 const iso_view *view, int threads, iso_class_tables *classes, iso_error *err)
{
    iso_adapt_options opt;
    *classes = (iso_class_tables){0};
    iso_status status = iso_cli_adapt_options(a, threads, &opt, err);
    if (status == ISO_OK && level == 0)
        status = iso_fail(err, ISO_E_USAGE, "--classes is for coarse levels: --level 1 or more");
    if (status == ISO_OK)
        status = iso_adapt_classes(p, iso_pyramid_is_one(path) ? path : NULL, level, &view->tf, &opt, classes, err);
    return status;
}
