/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/warnings.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { KEPT = 64 }; /* more are printed each time */

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static iso_warning_print *printer;
static char *given[KEPT];
static size_t given_count;

void iso_warnings_print_by(iso_warning_print *print)
{
    printer = print;
}

void iso_warn(const char *text)
{
    bool is_new = printer != NULL;
    pthread_mutex_lock(&lock);
    for (size_t i = 0; i < given_count && is_new; ++i)
        is_new = strcmp(given[i], text) != 0;
    if (is_new && given_count < KEPT && (given[given_count] = strdup(text)))
        ++given_count;
    if (is_new)
        printer(text);
    pthread_mutex_unlock(&lock);
}
