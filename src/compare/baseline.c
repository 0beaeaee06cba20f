#include "compare/baseline.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *string_of(const json_t *object, const char *key)
{
    const char *s = json_string_value(json_object_get(object, key));
    return s ? s : "";
}

/* What a report measured of each row; a refused row has nulls, which are kept: they are missing figures later. */
static iso_status take_figures(json_t *figures, const json_t *row, const char *name, const char *const keys[], iso_error *err)
{
    for (int i = 0; keys[i]; ++i) {
        char key[768];
        snprintf(key, sizeof key, "%s/%s", name, keys[i]);
        if (json_object_get(figures, key))
            return iso_fail(err, ISO_E_RANGE, "baseline: the report has two figures \"%s\"", key);
        json_t *value = json_object_get(row, keys[i]);
        if (json_is_number(value))
            json_object_set(figures, key, value);
    }
    return ISO_OK;
}

iso_status iso_baseline_from_report(const json_t *report, json_t **baseline, iso_error *err)
{
    static const char *const agreement_keys[] = {"rmse", "max_abs", "p99_abs", "flip_mean", NULL};
    static const char *const consistency_keys[] = {"ssim_dissimilarity_mean", "flip_mean", "gradient_angle_mean_deg", NULL};
    *baseline = NULL;
    if (strcmp(string_of(report, "schema"), "isoshade.validate/1") != 0)
        return iso_fail(err, ISO_E_FORMAT, "baseline: schema is \"%s\", wanted isoshade.validate/1", string_of(report, "schema"));
    json_t *figures = json_object(), *row;
    size_t i;
    char name[700];
    iso_status status = ISO_OK;
    json_array_foreach(json_object_get(report, "agreement"), i, row) {
        snprintf(name, sizeof name, "agreement/%s/level %lld/%s/%s/%s", string_of(row, "scene"),
                 (long long)json_integer_value(json_object_get(row, "level")), string_of(row, "a"), string_of(row, "b"),
                 string_of(row, "tier"));
        if (status == ISO_OK)
            status = take_figures(figures, row, name, agreement_keys, err);
    }
    json_array_foreach(json_object_get(report, "consistency"), i, row) {
        snprintf(name, sizeof name, "consistency/%s/level %lld", string_of(row, "method"),
                 (long long)json_integer_value(json_object_get(row, "level")));
        if (status == ISO_OK)
            status = take_figures(figures, row, name, consistency_keys, err);
    }
    if (status == ISO_OK && json_object_size(figures) == 0)
        status = iso_fail(err, ISO_E_RANGE, "baseline: the report holds no figure");
    if (status != ISO_OK) {
        json_decref(figures);
        return status;
    }
    *baseline = json_pack("{s:s, s:s, s:o}", "schema", "isoshade.accepted/1", "command", string_of(report, "command"),
                          "figures", figures);
    return ISO_OK;
}

static void note(iso_baseline_result *r, const char *key, const json_t *accepted, const json_t *now, const char *change, bool first)
{
    json_t *o = json_pack("{s:s, s:O, s:O, s:s}", "figure", key, "accepted", accepted ? accepted : json_null(), "now",
                          now ? now : json_null(), "change", change);
    if (first)
        json_array_insert_new(r->changes, 0, o);
    else
        json_array_append_new(r->changes, o);
}

iso_status iso_baseline_compare(const json_t *now, const json_t *accepted, double factor, double floor,
                                iso_baseline_result *result, iso_error *err)
{
    *result = (iso_baseline_result){0};
    if (strcmp(string_of(accepted, "schema"), "isoshade.accepted/1") != 0)
        return iso_fail(err, ISO_E_FORMAT, "baseline: schema is \"%s\", wanted isoshade.accepted/1",
                        string_of(accepted, "schema"));
    if (!(factor >= 1 && factor <= 1e6) || !(floor >= 0 && floor <= 1))
        return iso_fail(err, ISO_E_RANGE, "baseline: factor %g, must be 1 to 1e6; floor %g, must be 0 to 1", factor, floor);
    const json_t *old_figures = json_object_get(accepted, "figures"), *new_figures = json_object_get(now, "figures");
    const char *key;
    json_t *value;
    result->changes = json_array();
    json_object_foreach((json_t *)new_figures, key, value)
        if (!json_object_get(old_figures, key)) {
            ++result->added;
            note(result, key, NULL, value, "new", false);
        }
    json_object_foreach((json_t *)old_figures, key, value) {
        const json_t *current = json_object_get(new_figures, key);
        double before = json_number_value(value), after = json_number_value(current);
        if (!json_is_number(current)) {
            ++result->missing;
            note(result, key, value, NULL, "missing", true);
        } else if (!(after <= factor * before + floor)) {
            ++result->worse;
            note(result, key, value, current, "worse", true);
        } else if (after < before / factor - floor) {
            ++result->better;
            note(result, key, value, current, "better", false);
        } else {
            ++result->same;
        }
    }
    return ISO_OK;
}
