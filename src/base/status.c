/* SPDX-License-Identifier: MIT */
#include "base/status.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/control.h"

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

iso_status iso_errno_status(void)
{
    return errno == ENOMEM ? ISO_E_MEMORY : ISO_E_IO;
}

/* Texts of files and programs may hold anything; a message stays one line. */
static void one_line(char *text)
{
    for (size_t control; *text; text += control ? control : 1) {
        control = iso_words_control(text);
        memset(text, ' ', control);
    }
}

iso_status iso_fail(iso_error *err, iso_status status, const char *format, ...)
{
    if (err) {
        va_list args;
        va_start(args, format);
        vsnprintf(err->text, sizeof err->text, format, args);
        va_end(args);
        one_line(err->text);
    }
    return status;
}

iso_status iso_fail_in(iso_error *err, iso_status status, const char *format, ...)
{
    if (err) {
        char context[sizeof err->text / 2];
        va_list args;
        va_start(args, format);
        vsnprintf(context, sizeof context, format, args);
        va_end(args);
        one_line(context);
        size_t used = strlen(context);
        memmove(err->text + used + 2, err->text, sizeof err->text - used - 3);
        memcpy(err->text, context, used);
        memcpy(err->text + used, ": ", 2);
        err->text[sizeof err->text - 1] = 0;
    }
    return status;
}
