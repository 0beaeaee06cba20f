/* SPDX-License-Identifier: MIT */
/* status.h - how the library's own functions say what went wrong.
 *
 * Every function that can fail returns an iso_status and takes an iso_error
 * last, which may be NULL; both stand in the library's header, with the list of
 * all statuses. The value of a status is the exit code of the command that met
 * it. The library never prints and never exits. */
#ifndef ISO_STATUS_H
#define ISO_STATUS_H

#include "isoshade.h"

/* Leaves the message in err (when not NULL) and returns status:
 *     return iso_fail(err, ISO_E_RANGE, "%s: size %zu, at most %zu", path, n, max); */
iso_status iso_fail(iso_error *err, iso_status status, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* What a call of the system that failed comes to, by errno: ISO_E_MEMORY where memory ended, else ISO_E_IO. */
iso_status iso_errno_status(void);

/* Puts "context: " before the message that a callee left. Returns status. */
iso_status iso_fail_in(iso_error *err, iso_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
