/* SPDX-License-Identifier: MIT */
/* status.h - error reports of the library's own functions.
 *
 * Every function that can fail returns an iso_status and takes an iso_error last, which may be NULL. Both are
 * defined in the library's header, with the list of all statuses. A command's exit code is the value of its status.
 * The library never prints and never exits. */
#pragma once

#include "base/owned.h"
#include "isoshade.h"

/* Leaves the message in err (when not NULL) and returns status:
 *     return iso_fail(err, ISO_E_RANGE, "%s: size %zu, at most %zu", path, n, max); */
iso_status iso_fail(iso_error *err, iso_status status, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* Returns the status of a failed system call, by errno: ISO_E_MEMORY if out of memory, otherwise ISO_E_IO. */
iso_status iso_errno_status(void);

/* Puts "context: " before the message that a callee left. Returns status. */
iso_status iso_fail_in(iso_error *err, iso_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Does the next step if all before it succeeded: status becomes the result of call, which runs only at ISO_OK. */
#define TRY(status, call)       \
    do {                        \
        if ((status) == ISO_OK) \
            (status) = (call);  \
    } while (0)

/* Returns from the function with the status of call, if it fails. Variables of owned.h are released. */
#define NEED(call)                              \
    do {                                        \
        const iso_status need_status_ = (call); \
        if (need_status_ != ISO_OK)             \
            return need_status_;                \
    } while (0)

/* Returns from the function with ISO_E_MEMORY and a message unless there is the memory:
 *     NEED_MEMORY(rows, err, "%s: no memory for %zu rows", path, count); */
#define NEED_MEMORY(has_it, err, ...)                            \
    do {                                                         \
        if (!(has_it))                                           \
            return iso_fail((err), ISO_E_MEMORY, __VA_ARGS__);   \
    } while (0)
