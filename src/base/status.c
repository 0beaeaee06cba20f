#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const char *iso_status_text(iso_status status)
{
    switch (status) {
#define ISO_STATUS_CASE(name, code, text) \
    case name: return text;
        ISO_STATUS_LIST(ISO_STATUS_CASE)
#undef ISO_STATUS_CASE
    }
    return "unknown status";
}

iso_status iso_fail(iso_error *err, iso_status status, const char *format, ...)
{
    if (err) {
        va_list args;
        va_start(args, format);
        vsnprintf(err->text, sizeof err->text, format, args);
        va_end(args);
    }
    return status;
}

iso_status iso_fail_in(iso_error *err, iso_status status, const char *format, ...)
{
    if (err) {
        char callee[sizeof err->text];
        memcpy(callee, err->text, sizeof callee);
        va_list args;
        va_start(args, format);
        int used = vsnprintf(err->text, sizeof err->text, format, args);
        va_end(args);
        if (used >= 0 && (size_t)used < sizeof err->text)
            snprintf(err->text + used, sizeof err->text - (size_t)used, ": %s", callee);
    }
    return status;
}
