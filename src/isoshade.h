/* SPDX-License-Identifier: MIT */
/* isoshade.h - what programs include that link with libisoshade; the one place of its version. */
#ifndef ISOSHADE_H
#define ISOSHADE_H

#ifdef __cplusplus
extern "C" {
#endif

/* Programs that were built with one version run with a later one of the same major number. */
#define ISO_VERSION_MAJOR 0
#define ISO_VERSION_MINOR 2
#define ISO_VERSION_PATCH 0
#define ISO_VERSION_WORD(number) #number
#define ISO_VERSION_TEXT(major, minor, patch) ISO_VERSION_WORD(major) "." ISO_VERSION_WORD(minor) "." ISO_VERSION_WORD(patch)
#define ISO_VERSION ISO_VERSION_TEXT(ISO_VERSION_MAJOR, ISO_VERSION_MINOR, ISO_VERSION_PATCH) /* "0.2.0" */

/* The version of the library that runs, such as "0.2.0": not of the header that the program was built with. */
const char *iso_version(void);

#ifdef __cplusplus
}
#endif

#endif
