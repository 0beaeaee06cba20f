/* SPDX-License-Identifier: MIT */
/* status.h - a status for the program, a text for the person.
 *
 * Every function that can fail returns an iso_status and takes an iso_error
 * last, which may be NULL. The value of a status is the exit code of the
 * command that met it. The library never prints and never exits. */
#ifndef ISO_STATUS_H
#define ISO_STATUS_H

#define ISO_STATUS_LIST(X)                                                          \
    X(ISO_OK, 0, "success")                                                         \
    X(ISO_E_DIFFERS, 1, "the comparison found a difference")                        \
    X(ISO_E_USAGE, 2, "bad command line or option value")                           \
    X(ISO_E_IO, 3, "a file could not be read or written")                           \
    X(ISO_E_FORMAT, 4, "a file's content is not what it should be")                 \
    X(ISO_E_RANGE, 5, "a value lies outside its limits")                            \
    X(ISO_E_MEMORY, 6, "not enough memory")                                         \
    X(ISO_E_MISSING, 7, "a needed program or device is missing")                    \
    X(ISO_E_PROGRAM, 8, "an external program or library failed")                    \
    X(ISO_E_UNTRUSTED, 9, "a renderer failed its calibration; comparison refused")

typedef enum iso_status {
#define ISO_STATUS_ENUM(name, code, text) name = code,
    ISO_STATUS_LIST(ISO_STATUS_ENUM)
#undef ISO_STATUS_ENUM
} iso_status;

typedef struct iso_error {
    char text[1024];
} iso_error;

/* The one-line meaning of a status, for --help and for JSON. */
const char *iso_status_text(iso_status status);

/* Leaves the message in err (when not NULL) and returns status:
 *     return iso_fail(err, ISO_E_RANGE, "%s: size %zu, at most %zu", path, n, max); */
iso_status iso_fail(iso_error *err, iso_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Puts "context: " before the message that a callee left. Returns status. */
iso_status iso_fail_in(iso_error *err, iso_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
