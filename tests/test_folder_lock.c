/* SPDX-License-Identifier: MIT */
/* Two processes at one folder. The other one acts at a chosen moment: inside of the system's calls that a lock or a
 * commit makes, which this program replaces. So each order of events comes every time. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "base/manifest.h"
#include "folder.h"
#include "test.h"

/* The other process: called once, before or after the real call. */
typedef void other_process(void);
static other_process *before_flock, *before_rename, *after_rename, *after_exchange;
static bool no_locks, no_exchange;
static int pauses;

static void act(other_process **other)
{
    other_process *const call = *other;
    *other = NULL;
    if (call)
        call();
}

static int fail_by(int cause)
{
    errno = cause;
    return -1;
}

int flock(int fd, int how)
{
    act(&before_flock);
    return no_locks ? fail_by(ENOSYS) : (int)syscall(SYS_flock, fd, how);
}

int rename(const char *from, const char *to)
{
    act(&before_rename);
    const int result = (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
    const int cause = errno;
    act(&after_rename);
    errno = cause;
    return result;
}

int renameat2(int from_dir, const char *from, int to_dir, const char *to, unsigned flags)
{
    const int result = no_exchange ? fail_by(EINVAL) : (int)syscall(SYS_renameat2, from_dir, from, to_dir, to, flags);
    const int cause = errno;
    act(&after_exchange);
    errno = cause;
    return result;
}

int nanosleep(const struct timespec *asked, struct timespec *left)
{
    (void)asked;
    (void)left;
    ++pauses;
    return 0;
}

/* ---- the lock ---- */

static char *at(const char *name)
{
    static char paths[4][4096];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static bool is_locked(const iso_folder_lock *lock, const char *path)
{
    struct stat held, named;
    const int other = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const bool is = lock->fd >= 0 && other >= 0 && fstat(lock->fd, &held) == 0 && fstat(other, &named) == 0 &&
                    held.st_ino == named.st_ino && syscall(SYS_flock, other, LOCK_EX | LOCK_NB) != 0;
    if (other >= 0)
        close(other);
    return is;
}

static void finish_work(void)
{
    assert_int_equal(rename(at("work"), at("finished")), 0);
}

static void remove_work(void)
{
    assert_int_equal(rmdir(at("work")), 0);
}

static void replace_work(void)
{
    finish_work();
    assert_int_equal(mkdir(at("work"), 0777), 0);
}

static void begin_anew(void)
{
    iso_remove_tree(at("work"));
    iso_remove_tree(at("finished"));
    assert_int_equal(mkdir(at("work"), 0777), 0);
}

TEST(a_folder_that_lost_its_name_before_the_lock_is_not_locked)
{
    static other_process *const others[] = {finish_work, remove_work, replace_work};
    for (size_t i = 0; i < 3; ++i) {
        begin_anew();
        before_flock = others[i];
        const iso_folder_lock lock = iso_folder_lock_take(at("work"), true);
        assert_int_equal(lock.cause, 0);
        assert_true(is_locked(&lock, at("work")));
        assert_int_equal(lock.made, others[i] != replace_work);
        close(lock.fd);
    }
}

TEST(without_a_new_bearer_of_the_name_nothing_is_locked)
{
    begin_anew();
    before_flock = finish_work;
    const iso_folder_lock lock = iso_folder_lock_take(at("work"), false);
    assert_int_equal(lock.fd, -1);
    assert_int_equal(lock.cause, ENOENT);
}

TEST(another_s_lock_is_waited_for_two_seconds)
{
    begin_anew();
    const iso_folder_lock first = iso_folder_lock_take(at("work"), true);
    pauses = 0;
    const iso_folder_lock second = iso_folder_lock_take(at("work"), true);
    assert_int_equal(second.fd, -1);
    assert_int_equal(second.cause, EWOULDBLOCK);
    assert_int_equal(pauses, 40);
    close(first.fd);
}

TEST(without_locks_the_folder_is_opened_and_the_reason_told)
{
    begin_anew();
    no_locks = true;
    const iso_folder_lock lock = iso_folder_lock_take(at("work"), true);
    no_locks = false;
    assert_true(lock.fd >= 0);
    assert_int_equal(lock.cause, ENOSYS);
    close(lock.fd);
}

TEST(a_link_is_not_followed)
{
    begin_anew();
    assert_int_equal(symlink("work", at("link")), 0);
    const iso_folder_lock lock = iso_folder_lock_take(at("link"), true);
    assert_int_equal(lock.fd, -1);
    unlink(at("link"));
}

/* ---- outputs ---- */

static const char *const own[] = {"marker", "data", NULL};
static iso_output first, second;
static iso_status second_began;

static void write_own(const iso_output *out, const char *text)
{
    for (size_t i = 0; own[i]; ++i) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", out->temp_path, own[i]);
        FILE *f = fopen(path, "w");
        assert_non_null(f);
        fputs(text, f);
        assert_int_equal(fclose(f), 0);
    }
}

/* of: whose output stands at the final path, whole. Nothing else is left in the folder. */
static void assert_stands(const char *of)
{
    FREED char *text = NULL;
    size_t size;
    assert_ok(iso_manifest_check(at("out"), "out", &err));
    assert_ok(iso_file_read(at("out/data"), &text, &size, &err));
    assert_string_equal(text, of);
    assert_int_equal(access(at("out/marker"), F_OK), 0);
    assert_int_not_equal(access(at(".out.partial"), F_OK), 0);
    assert_int_not_equal(access(at("out.before"), F_OK), 0);
    iso_remove_tree(at("out"));
}

static iso_status begin_partial(iso_output *out, bool *resumed)
{
    iso_error err = {""};
    const iso_status status = iso_output_resume_dir(out, at("out"), own, false, resumed, &err);
    if (status != ISO_OK)
        assert_true(strstr(err.text, "another process is making it; wait for its end") != NULL);
    return status;
}

static void begin_first(void)
{
    bool resumed;
    iso_remove_tree(at("out"));
    assert_int_equal(begin_partial(&first, &resumed), ISO_OK);
    write_own(&first, "first");
}

static void commit_first(void)
{
    assert_ok(iso_output_commit(&first, &err));
}

static void begin_second(void)
{
    bool resumed;
    second_began = begin_partial(&second, &resumed);
    if (second_began == ISO_OK)
        write_own(&second, "second");
}

TEST(an_output_that_is_finished_while_another_waits_is_not_emptied)
{
    bool resumed;
    begin_first();
    before_flock = commit_first;
    assert_int_equal(begin_partial(&second, &resumed), ISO_OK);
    assert_false(resumed);
    iso_output_abandon(&second);
    assert_stands("first");
}

TEST(nor_is_it_lost_as_the_other_takes_its_place)
{
    bool resumed;
    begin_first();
    before_flock = commit_first;
    assert_int_equal(begin_partial(&second, &resumed), ISO_OK);
    write_own(&second, "second");
    assert_ok(iso_output_commit(&second, &err));
    assert_stands("second");
}

static iso_folder_lock at_work;

static void take_partial(void)
{
    at_work = iso_folder_lock_take(at(".out.partial"), true);
}

TEST(work_that_begins_right_after_a_rename_stays)
{
    begin_first();
    after_rename = take_partial;
    commit_first();
    assert_true(at_work.made && is_locked(&at_work, at(".out.partial")));
    close(at_work.fd);
    assert_int_equal(rmdir(at(".out.partial")), 0);
    assert_stands("first");
}

TEST(a_replaced_folder_is_not_taken_for_work)
{
    begin_first();
    commit_first();
    begin_second();
    first = second;
    after_exchange = begin_second; /* the old folder has the partial one's name then */
    commit_first();
    assert_int_equal(second_began, ISO_E_IO);
    assert_stands("second");
}

static void commit_second(void)
{
    assert_ok(iso_output_commit(&second, &err));
}

static void begin_two_folders(void)
{
    assert_ok(iso_output_begin_dir(&first, at("out"), "marker", &err));
    write_own(&first, "first");
    assert_ok(iso_output_begin_dir(&second, at("out"), "marker", &err));
    write_own(&second, "second");
}

/* Also where folders cannot be exchanged in one step. */
TEST(of_two_that_finish_at_once_the_last_one_stands)
{
    for (int i = 0; i < 2; ++i) {
        no_exchange = i == 1;
        begin_two_folders();
        before_rename = commit_second;
        commit_first();
        no_exchange = false;
        assert_stands("first");
    }
}

/* The old folder has stepped aside, and the other process takes the free name. */
static void commit_second_into_the_gap(void)
{
    after_rename = commit_second;
}

TEST(so_it_does_in_the_middle_of_an_exchange_by_steps)
{
    begin_first();
    commit_first();
    begin_two_folders();
    no_exchange = true;
    after_exchange = commit_second_into_the_gap;
    commit_first();
    no_exchange = false;
    assert_stands("first");
}

static bool folder_is_locked;

static void look_at_the_lock(void)
{
    const int other = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    assert_true(other >= 0);
    folder_is_locked = syscall(SYS_flock, other, LOCK_EX | LOCK_NB) != 0;
    close(other);
}

TEST(the_folder_is_locked_while_a_set_gets_its_names)
{
    iso_output outs[2] = {0};
    iso_error err = {""};
    const char *names[] = {at("grid.vdb"), at("scene.blend")};
    for (size_t i = 0; i < 2; ++i) {
        assert_int_equal(iso_output_begin(&outs[i], names[i], &err), ISO_OK);
        FILE *f = fopen(outs[i].temp_path, "wb");
        assert_non_null(f);
        fclose(f);
    }
    folder_is_locked = false;
    after_rename = look_at_the_lock;
    assert_int_equal(iso_output_commit_all(outs, 2, &err), ISO_OK);
    assert_true(folder_is_locked);
    look_at_the_lock();
    assert_false(folder_is_locked);
    assert_true(iso_path_exists(names[0]) && iso_path_exists(names[1]));
}

TEST_MAIN(make_folder, remove_folder)
