/* SPDX-License-Identifier: MIT */
/* programs.c - renderers that are programs may fail by themselves, and a report says how they were run. */
#include "base/process.h"
#include "report/rows.h"
#include "validate/validate.h"

/* True if the failure is the program's own. Out of memory, an unsupported request and Ctrl-C in this process are
 * not. */
bool iso_validate_is_its_fault(const iso_renderer_info *which, iso_status status)
{
    return iso_renderer_has(which, ISO_IS_PROGRAM) && status != ISO_OK && status != ISO_E_MEMORY &&
           status != ISO_E_USAGE && !iso_process_was_stopped();
}

iso_status iso_validate_refused_later(const iso_validation *v, iso_error *err)
{
    size_t i;
    json_t *row;
    json_array_foreach (json_object_get(iso_report_json(v->report), "agreement"), i, row) {
        if (iso_row_verdict(row) == ISO_VERDICT_REFUSED)
            return iso_fail(err, ISO_E_UNTRUSTED, "%s failed: %s", iso_row_text(row, "renderer"),
                            iso_row_text(row, "why"));
    }
    return ISO_OK;
}

void iso_validate_describe_programs(const iso_validation *v)
{
    for (size_t i = 0; i < iso_renderer_count(); ++i) {
        const iso_renderer_info *r = iso_renderer_at(i);
        if (v->wanted[i] && r->describe)
            iso_report_put(v->report, "programs", r->name, r->describe(r));
    }
}
