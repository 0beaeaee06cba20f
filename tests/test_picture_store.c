/* SPDX-License-Identifier: MIT */
/* The folder of pictures: removed so that a run that is killed in between leaves one that the next run takes. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "folder.h"
#include "renderers/picture_store.h"
#include "test.h"

/* After so many removals the process ends, as if it was killed. Below 0: never. */
static int removals_left = -1;

static void count_removal(void)
{
    if (removals_left == 0)
        _exit(0);
    removals_left -= removals_left > 0;
}

int unlinkat(int dir, const char *name, int flags)
{
    count_removal();
    return (int)syscall(SYS_unlinkat, dir, name, flags);
}

int unlink(const char *path)
{
    count_removal();
    return (int)syscall(SYS_unlinkat, AT_FDCWD, path, 0);
}

int rmdir(const char *path)
{
    count_removal();
    return (int)syscall(SYS_unlinkat, AT_FDCWD, path, AT_REMOVEDIR);
}

enum { PICTURES = 5 };

static void put_pictures(const char *work)
{
    for (int i = 0; i < PICTURES; ++i) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%032x.picture", work, i);
        assert_ok(iso_file_write(path, "x", 1, &err));
    }
}

static void open_store(const char *work, bool keep, iso_picture_store **store)
{
    iso_key *key = iso_key_create();
    assert_non_null(key);
    assert_ok(iso_picture_store_open(work, store, &err));
    assert_ok(iso_picture_store_begin(*store, keep, key, &(iso_ranks_place){.count = 1}, &err));
    iso_key_destroy(key);
}

/* How many removals there are is not assumed: one more each time, until all were made. */
TEST(killed_at_any_removal_it_blocks_no_later_run)
{
    for (int keeps = 0; keeps < 2; ++keeps) {
        FREED char *work = iso_path_join(folder, "r.work");
        bool is_gone = false;
        int kills = 0;
        for (; !is_gone; ++kills) {
            iso_picture_store *store;
            open_store(work, true, &store);
            put_pictures(work);
            const pid_t child = fork();
            if (child == 0) {
                removals_left = kills;
                iso_picture_store_close(store, true);
                _exit(0);
            }
            assert_int_equal(waitpid(child, NULL, 0), child);
            is_gone = !iso_path_exists(work);
            iso_picture_store_close(store, false);
            open_store(work, keeps, &store);
            iso_picture_store_close(store, true);
            assert_false(iso_path_exists(work));
        }
        assert_true(kills > PICTURES + 2); /* with the marker and the folder */
    }
}

static int ended_count;

static void note_end(void)
{
    ++ended_count;
}

/* Rank 1 of three joins the store that rank 0 of its job has begun, and leaves it to rank 0. */
TEST(ranks_share_a_store)
{
    FREED char *work = iso_path_join(folder, "shared.work");
    const iso_ranks_place first = {0, 3, "job 7 "}, second = {1, 3, "job 7 "};
    iso_key *key = iso_key_create();
    iso_picture_store *mine, *joined;
    assert_non_null(key);
    assert_ok(iso_picture_store_open(work, &mine, &err));
    assert_ok(iso_picture_store_begin(mine, false, key, &first, &err));
    assert_ok(iso_picture_store_join(work, key, &second, note_end, &joined, &err));
    const iso_picture_share a = iso_picture_store_share(mine, 10), b = iso_picture_store_share(joined, 10);
    assert_true(a.first == 0 && a.end == 3 && b.first == 3 && b.end == 6);
    const iso_picture_share alone = iso_picture_store_share(NULL, 10);
    assert_int_equal(alone.end, 0);
    put_pictures(work);
    iso_picture_store_close(joined, true);
    assert_true(iso_path_exists(work));
    iso_picture_store_close(mine, true);
    assert_false(iso_path_exists(work));
    assert_int_equal(ended_count, 0);
    iso_key_destroy(key);
}

TEST_MAIN(make_folder, remove_folder)
