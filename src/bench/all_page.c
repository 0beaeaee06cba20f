/* SPDX-License-Identifier: MIT */
#include "bench/all_page.h"

#include "base/embed.h"
#include "report/page.h"

ISO_EMBED(iso_bench_all_html, "src/bench/all.html");
ISO_EMBED(iso_bench_all_css, "src/bench/all.css");
ISO_EMBED(iso_bench_all_js, "src/bench/all.js");

static const iso_page page_of_all = {"isoshade bench all", iso_bench_all_html, {iso_bench_all_js}, iso_bench_all_css};

static json_t *sentence_of(const json_t *answer)
{
    size_t i, met = 0, judged = 0, missing = 0;
    const json_t *row;
    json_array_foreach (json_object_get(answer, "headlines"), i, row) {
        const json_t *verdict = json_object_get(row, "met");
        met += json_is_true(verdict);
        judged += json_is_boolean(verdict);
        missing += json_is_null(json_object_get(row, "median"));
    }
    if (judged == 0)
        return json_string("Measured on small data, so no bars apply");
    return json_sprintf("%zu of %zu bars are met%s", met, judged,
                        missing ? "; some figures could not be measured" : "");
}

iso_status iso_bench_all_page_write(const char *path, const json_t *answer, iso_error *err)
{
    json_auto_t *data = json_copy((json_t *)answer), *nothing = json_object();
    iso_status status = ISO_E_MEMORY;
    if (data && nothing) {
        json_object_set_new(data, "title", json_string("Speed and memory"));
        json_object_set_new(data, "sentence", sentence_of(answer));
        status = iso_page_write(path, &page_of_all, data, nothing, err);
    } else {
        iso_fail(err, status, "%s: out of memory", path);
    }
    return status;
}
