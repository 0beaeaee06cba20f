/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/progress_line.h"

#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "base/parallel.h"

enum { MOST_STEPS = 64 };
static const double REDRAW_SECONDS = 0.1, LOG_SECONDS = 30;

struct iso_progress_line {
    char command[64], name[96]; /* name: of the current step */
    struct step {
        const char *name;
        double cost;
    } steps[MOST_STEPS];
    size_t count, current;
    double done, fraction; /* of the step that runs, and of all */
    double start, drawn;
    bool redraws, shown, idle, ticks, stops;
    pthread_mutex_t lock;
    pthread_cond_t wake;
    pthread_t ticker;
};

/* Returns the text's length if it is cut to `bytes` bytes, between characters of UTF-8. */
static size_t cut(const char *text, size_t bytes)
{
    size_t length = strnlen(text, bytes);
    while (length > 0 && ((unsigned char)text[length] & 0xc0) == 0x80)
        --length;
    return length;
}

void iso_progress_text(char *text, size_t size, const char *command, const char *name, double fraction, double seconds,
                       size_t columns)
{
    char tail[64];
    const int s = (int)seconds, n = snprintf(tail, sizeof tail, "   %2d %%, ", (int)(100 * fraction));
    if (s < 60)
        snprintf(tail + n, sizeof tail - (size_t)n, "%d s", s);
    else if (s < 3600)
        snprintf(tail + n, sizeof tail - (size_t)n, "%d min %02d s", s / 60, s % 60);
    else
        snprintf(tail + n, sizeof tail - (size_t)n, "%d h %02d min", s / 3600, s / 60 % 60);
    const size_t others = strlen(command) + 2 + strlen(tail), room = columns > others ? columns - others : 0;
    snprintf(text, size, "%s: %.*s%s", command, (int)cut(name, columns ? room : strlen(name)), name, tail);
    if (columns)
        text[cut(text, columns)] = 0;
}

/* Returns the width of the terminal. It is asked each time, so a window that changes its size needs no signal. */
static size_t terminal_columns(void)
{
    struct winsize size;
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col : 80;
}

/* Clears the line. The caller holds the lock, except in functions of the header. */
static void wipe(iso_progress_line *line)
{
    if (line->shown)
        fputs("\r\033[K", stderr), fflush(stderr);
    line->shown = false;
}

static void draw(iso_progress_line *line)
{
    char text[256];
    const double now = iso_clock_seconds();
    if (line->idle || now - line->drawn < (line->redraws ? REDRAW_SECONDS : LOG_SECONDS))
        return;
    iso_progress_text(text, sizeof text, line->command, line->name, line->fraction, now - line->start,
                      line->redraws ? terminal_columns() - 1 : 0);
    fprintf(stderr, line->redraws ? "\r%s\033[K" : "%s\n", text);
    fflush(stderr);
    line->shown = line->redraws;
    line->drawn = now;
}

/* Updates the elapsed time while no thread reports. */
static void *tick(void *user)
{
    iso_progress_line *line = user;
    pthread_mutex_lock(&line->lock);
    for (struct timespec until; !line->stops; draw(line)) {
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_sec += 1;
        pthread_cond_timedwait(&line->wake, &line->lock, &until);
    }
    pthread_mutex_unlock(&line->lock);
    return NULL;
}

/* Starts the ticker with signals blocked: they are for the threads that work. */
static void start_ticker(iso_progress_line *line)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    line->ticks = pthread_create(&line->ticker, NULL, tick, line) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

void iso_progress_line_expect(iso_progress_line *line, const char *step, double cost)
{
    if (line && line->count < MOST_STEPS)
        line->steps[line->count++] = (struct step){step, cost};
}

static void set_done(iso_progress_line *line, double done)
{
    double sum = 0, all = 0;
    line->done = fmin(done, 1);
    for (size_t i = 0; i < line->count; ++i) {
        sum += line->steps[i].cost * (i < line->current ? 1 : i == line->current ? line->done : 0);
        all += line->steps[i].cost;
    }
    line->fraction = all > 0 ? fmax(line->fraction, sum / all) : line->done;
}

/* Ends the steps before the named one. A name that is not a later step leaves the total unchanged. */
static void go_on(iso_progress_line *line, const char *name, double fraction)
{
    size_t i = line->current;
    while (i < line->count && strcmp(line->steps[i].name, name) != 0)
        ++i;
    if (i < line->count)
        line->current = i;
    if (i < line->count || line->count == 0)
        set_done(line, fraction);
    snprintf(line->name, sizeof line->name, "%s", name);
}

static bool report(void *user, const char *stage, double fraction)
{
    iso_progress_line *line = user;
    pthread_mutex_lock(&line->lock);
    if (!line->ticks)
        start_ticker(line);
    go_on(line, stage, fraction);
    line->idle = fraction >= 1 && line->fraction >= 1; /* the command may print something else now */
    if (line->idle)
        wipe(line);
    draw(line);
    pthread_mutex_unlock(&line->lock);
    return true;
}

iso_progress iso_progress_of_line(iso_progress_line *line)
{
    return line ? (iso_progress){.report = report, .user = line} : (iso_progress){0};
}

void iso_progress_line_add(iso_progress_line *line, double part)
{
    if (!line)
        return;
    pthread_mutex_lock(&line->lock);
    set_done(line, line->done + part);
    draw(line);
    pthread_mutex_unlock(&line->lock);
}

double iso_progress_line_fraction(iso_progress_line *line)
{
    pthread_mutex_lock(&line->lock);
    const double fraction = line->fraction;
    pthread_mutex_unlock(&line->lock);
    return fraction;
}

void iso_progress_line_hide(iso_progress_line *line)
{
    if (!line)
        return;
    pthread_mutex_lock(&line->lock);
    wipe(line);
    line->idle = true;
    pthread_mutex_unlock(&line->lock);
}

iso_progress_line *iso_progress_line_create(const char *command)
{
    iso_progress_line *line = calloc(1, sizeof *line);
    const char *kind = getenv("TERM");
    if (!line)
        return NULL;
    pthread_cond_init(&line->wake, NULL);
    pthread_mutex_init(&line->lock, NULL);
    line->redraws = isatty(STDERR_FILENO) && kind && *kind && strcmp(kind, "dumb") != 0;
    line->start = iso_clock_seconds();
    line->drawn = line->redraws ? 0 : line->start;
    snprintf(line->command, sizeof line->command, "%s", command);
    return line;
}

void iso_progress_line_destroy(iso_progress_line *line)
{
    if (!line)
        return;
    iso_progress_line_hide(line);
    pthread_mutex_lock(&line->lock);
    line->stops = true;
    pthread_cond_signal(&line->wake);
    pthread_mutex_unlock(&line->lock);
    if (line->ticks)
        pthread_join(line->ticker, NULL);
    pthread_cond_destroy(&line->wake);
    pthread_mutex_destroy(&line->lock);
    free(line);
}
