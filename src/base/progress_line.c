/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/progress_line.h"

#include <errno.h>
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

static const double REDRAW_SECONDS = 0.1, TICK_SECONDS = 1;
static const double LOG_LEAST_SECONDS = 5, LOG_MOST_SECONDS = 30;

struct iso_progress_line {
    iso_progress_lane first;
    char name[64], stage[96];
    iso_job *job;
    double stage_fraction; /* of a job without a layout */
    bool redraws, shown, idle, stops, ticks;
    double drawn_at;
    iso_progress_log log;
    pthread_mutex_t lock;
    pthread_cond_t wake;
    pthread_t ticker;
};

/* ---- text ---------------------------------------------------------------------------------- */

/* Rounded to what an estimate knows. */
static int put_duration(char *text, size_t size, double seconds)
{
    if (seconds < 10)
        return snprintf(text, size, "a few seconds");
    if (seconds < 60)
        return snprintf(text, size, "%.0f s", 5 * round(seconds / 5));
    if (seconds < 600) {
        const int tens = (int)round(seconds / 10);
        return tens % 6 ? snprintf(text, size, "%d min %d s", tens / 6, 10 * (tens % 6))
                        : snprintf(text, size, "%d min", tens / 6);
    }
    const int minutes = (int)round(seconds / 60);
    if (minutes < 60)
        return snprintf(text, size, "%d min", minutes);
    return snprintf(text, size, "%d h %d min", minutes / 60, minutes % 60);
}

/* Bytes of the first `columns` characters of UTF-8. */
static size_t bytes_of_columns(const char *text, size_t columns)
{
    size_t i = 0;
    for (size_t seen = 0; text[i]; ++i)
        if (((unsigned char)text[i] & 0xc0) != 0x80 && seen++ == columns)
            break;
    return i;
}

static size_t columns_of(const char *text)
{
    size_t n = 0;
    for (; *text; ++text)
        n += ((unsigned char)*text & 0xc0) != 0x80;
    return n;
}

void iso_progress_text(char *text, size_t size, const char *name, const iso_job_state *state, size_t columns)
{
    char tail[96], part[128];
    int n = snprintf(tail, sizeof tail, "%s%3.0f %%", state->part[0] ? "   " : " ", floor(100 * state->fraction));
    if (isfinite(state->left_seconds)) {
        n += snprintf(tail + n, sizeof tail - (size_t)n, ", about ");
        n += put_duration(tail + n, sizeof tail - (size_t)n, state->left_seconds);
        snprintf(tail + n, sizeof tail - (size_t)n, " left");
    }
    snprintf(part, sizeof part, "%s", state->part);
    const size_t others = columns_of(name) + 2 + strlen(tail), long_part = columns_of(part);
    if (columns > 0 && others + long_part > columns)
        part[bytes_of_columns(part, columns > others ? columns - others : 0)] = 0;
    snprintf(text, size, "%s: %s%s", name, part, tail);
    if (columns > 0)
        text[bytes_of_columns(text, columns)] = 0;
}

int iso_progress_log_is_due(iso_progress_log *log, const iso_job_state *state)
{
    const double since = state->passed_seconds - log->told_seconds;
    const int tenth = (int)floor(10 * state->fraction);
    if (!(since >= LOG_MOST_SECONDS || (since >= LOG_LEAST_SECONDS && tenth > log->told_tenth)))
        return 0;
    log->told_seconds = state->passed_seconds;
    log->told_tenth = tenth;
    log->count++;
    return 1;
}

/* ---- drawing; the lock is held --------------------------------------------------------------- */

/* Asked each time: a window that changes its size needs no signal. */
static size_t terminal_columns(void)
{
    struct winsize size;
    const char *text = getenv("COLUMNS");
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
        return size.ws_col;
    const long columns = text ? strtol(text, NULL, 10) : 0;
    return columns > 0 ? (size_t)columns : 80;
}

static void wipe(iso_progress_line *line)
{
    if (line->shown)
        fputs("\r\033[K", stderr), fflush(stderr);
    line->shown = false;
}

static iso_job_state look(iso_progress_line *line)
{
    iso_job_state state = iso_job_look(line->job, iso_clock_seconds());
    if (!iso_job_has_parts(line->job)) {
        state.part = line->stage;
        state.fraction = line->stage_fraction;
    }
    return state;
}

static void draw(iso_progress_line *line)
{
    char text[256];
    iso_job_state state = look(line);
    if (line->redraws) {
        const size_t columns = terminal_columns();
        iso_progress_text(text, sizeof text, line->name, &state, columns > 1 ? columns - 1 : 1);
        fprintf(stderr, "\r%s\033[K", text);
        line->shown = true;
    } else if (iso_progress_log_is_due(&line->log, &state)) {
        iso_progress_text(text, sizeof text, line->name, &state, 0);
        fprintf(stderr, "%s\n", text);
    }
    fflush(stderr);
    line->drawn_at = iso_clock_seconds();
}

/* ---- the ticker: time passes when nobody reports ---------------------------------------------- */

static void *tick(void *user)
{
    iso_progress_line *line = user;
    pthread_mutex_lock(&line->lock);
    while (!line->stops) {
        struct timespec until;
        clock_gettime(CLOCK_MONOTONIC, &until);
        until.tv_sec += (time_t)TICK_SECONDS;
        if (pthread_cond_timedwait(&line->wake, &line->lock, &until) == ETIMEDOUT && !line->idle)
            draw(line);
    }
    pthread_mutex_unlock(&line->lock);
    return NULL;
}

/* Signals are for the threads that work. */
static void start_ticker(iso_progress_line *line)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    line->ticks = pthread_create(&line->ticker, NULL, tick, line) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

/* ---- reports --------------------------------------------------------------------------------- */

/* Before the next part begins. */
static void tell_of_taken(iso_job *job, iso_progress_lane *lane)
{
    if (lane->taken != lane->told)
        iso_job_is_shortened(job, lane->number);
    lane->told = lane->taken;
}

static void take_report(iso_progress_line *line, iso_progress_lane *lane, const char *stage, double fraction)
{
    pthread_mutex_lock(&line->lock);
    if (!line->ticks)
        start_ticker(line);
    const bool new_stage = strcmp(stage, line->stage) != 0;
    snprintf(line->stage, sizeof line->stage, "%s", stage);
    line->stage_fraction = fmin(fmax(fraction, 0), 1);
    tell_of_taken(line->job, lane);
    iso_job_report(line->job, lane->number, stage, fraction, iso_clock_seconds());
    line->idle = fraction >= 1 && iso_job_is_done(line->job);
    if (line->idle)
        wipe(line);
    else if (new_stage || iso_clock_seconds() - line->drawn_at >= REDRAW_SECONDS)
        draw(line);
    pthread_mutex_unlock(&line->lock);
}

static void report(void *user, const char *stage, double fraction)
{
    iso_progress_lane *lane = user;
    take_report(lane->line, lane, stage, fraction);
}

iso_progress iso_progress_of_lane(iso_progress_lane *lane)
{
    return lane->line ? (iso_progress){.report = report, .user = lane} : (iso_progress){0};
}

iso_progress iso_progress_of_line(iso_progress_line *line)
{
    return line ? iso_progress_of_lane(&line->first) : (iso_progress){0};
}

void iso_progress_lane_end(iso_progress_lane *lane)
{
    iso_job *job = iso_progress_line_lock(lane->line);
    if (job) {
        tell_of_taken(job, lane);
        iso_job_end_lane(job, lane->number, iso_clock_seconds());
    }
    iso_progress_line_unlock(lane->line);
}

void iso_progress_line_begin_phase(iso_progress_line *line, const char *name)
{
    iso_job *job = iso_progress_line_lock(line);
    if (job)
        iso_job_begin_phase(job, name, iso_clock_seconds());
    iso_progress_line_unlock(line);
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

/* ---- its life -------------------------------------------------------------------------------- */

iso_job *iso_progress_line_lock(iso_progress_line *line)
{
    if (line)
        pthread_mutex_lock(&line->lock);
    return line ? line->job : NULL;
}

void iso_progress_line_unlock(iso_progress_line *line)
{
    if (line)
        pthread_mutex_unlock(&line->lock);
}

static bool can_redraw(void)
{
    const char *kind = getenv("TERM");
    return isatty(STDERR_FILENO) && kind && *kind && strcmp(kind, "dumb") != 0;
}

iso_progress_line *iso_progress_line_create(const char *name)
{
    iso_progress_line *line = calloc(1, sizeof *line);
    iso_job *job = iso_job_create(iso_threads(0));
    if (!line || !job) {
        free(line);
        iso_job_destroy(job);
        return NULL;
    }
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&line->wake, &monotonic);
    pthread_condattr_destroy(&monotonic);
    pthread_mutex_init(&line->lock, NULL);
    line->job = job;
    line->first.line = line;
    line->redraws = can_redraw();
    snprintf(line->name, sizeof line->name, "%s", name);
    return line;
}

void iso_progress_line_destroy(iso_progress_line *line)
{
    if (!line)
        return;
    pthread_mutex_lock(&line->lock);
    line->stops = true;
    pthread_cond_signal(&line->wake);
    pthread_mutex_unlock(&line->lock);
    if (line->ticks)
        pthread_join(line->ticker, NULL);
    wipe(line);
    if (line->log.count > 0) {
        char text[64];
        const double seconds = iso_job_look(line->job, iso_clock_seconds()).passed_seconds;
        put_duration(text, sizeof text, seconds);
        fprintf(stderr, "%s: ended after %s\n", line->name, text);
    }
    pthread_cond_destroy(&line->wake);
    pthread_mutex_destroy(&line->lock);
    iso_job_destroy(line->job);
    free(line);
}
