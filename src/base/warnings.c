/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/warnings.h"

#include <pthread.h>
#include <stdbool.h>
#include <string.h>

#include "isoshade.h"

enum { KEPT = 64 }; /* more are printed each time */

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static iso_warning_print *printer;
static iso_warning_callback listener; /* of a program that uses the library */
static void *listener_user;
static char *given[KEPT];
static size_t given_count;

void iso_warnings_print_by(iso_warning_print *print)
{
    printer = print;
}

void iso_warnings_to(iso_warning_callback warn, void *user)
{
    pthread_mutex_lock(&lock);
    listener = warn;
    listener_user = user;
    pthread_mutex_unlock(&lock);
}

void iso_warn(const char *text)
{
    pthread_mutex_lock(&lock);
    bool is_new = printer || listener;
    for (size_t i = 0; i < given_count && is_new; ++i)
        is_new = strcmp(given[i], text) != 0;
    if (is_new && given_count < KEPT && (given[given_count] = strdup(text)))
        ++given_count;
    if (is_new && printer)
        printer(text);
    if (is_new && listener)
        listener(listener_user, text);
    pthread_mutex_unlock(&lock);
}
